"""Explanation of the rank of an answer to words, in words and seconds.

The numbers are those of :mod:`motiondb.search.reasons`; here word numbers become words,
and frames become seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from motiondb.records import MOTION_FPS
from motiondb.search import reasons


@dataclass(frozen=True)
class SymbolShare:
    """Contribution of a motion symbol, in one interval, to the log-odds of an answer."""

    __pydantic_config__: ClassVar = {"alias_generator": lambda name: name.rstrip("_")}
    symbol: int
    from_: float  # Start of the interval, seconds; "from" in JSON
    to: float  # End of the interval, seconds
    share: float  # Nats


@dataclass(frozen=True)
class ExplainedWord:
    """Contribution of one word of a question to an answer.

    Attributes
    ----------
    word : str
        The word.
    log_odds : float
        Log-odds of the word alone, nats.
    log_probability : float
        Logarithm of the probability that belongs to these log-odds.
    contribution : float
        Sum of ``prior``, ``written``, ``as_caption`` and all ``symbols``.
    prior : float
        Contribution of the word's frequency, before any motion is considered.
    written : float
        Contribution of captions.
    as_caption : float
        Contribution of the comparison of a long question with whole captions.
    symbols : tuple of SymbolShare
        Contribution of every segment, in order of time.
    strongest : tuple of SymbolShare
        The largest shares by absolute value; neighbours with the same symbol count as one.
    others : float
        Sum of the shares that are not among the strongest.
    """

    word: str
    log_odds: float
    log_probability: float
    contribution: float
    prior: float
    written: float
    as_caption: float
    symbols: tuple[SymbolShare, ...]
    strongest: tuple[SymbolShare, ...]
    others: float


@dataclass(frozen=True)
class ExplainedExclusion:
    """What the exclusion of some words adds to an answer's log-odds."""

    amount: float  # What the exclusion adds, nats
    log_odds: float  # Log-odds that the capture shows them
    words: tuple[ExplainedWord, ...]


@dataclass(frozen=True)
class Explanation:
    """Parts of the log-odds that rank an answer.

    ``math.fsum`` of the parts of ``words`` (prior, written, as_caption, symbols), of ``together``
    and of the amounts of ``excluded`` is exactly ``log_odds``.

    Attributes
    ----------
    log_odds : float
        Log-odds of the answer, nats.
    together : float
        Log-odds that all actions occur, less the mean of their log-odds; 0 for one action.
    words : tuple of ExplainedWord
        The requested words.
    excluded : tuple of ExplainedExclusion
        What every exclusion adds.
    """

    log_odds: float
    together: float
    words: tuple[ExplainedWord, ...]
    excluded: tuple[ExplainedExclusion, ...]


def explain(why: Sequence[reasons.WordReason], vocabulary: Sequence[str]) -> Explanation:
    """Explain one answer."""
    excluded = tuple(
        ExplainedExclusion(
            lowering.amount,
            lowering.log_odds,
            tuple(_word(w, vocabulary) for w in why if w.exclusion == lowering.exclusion),
        )
        for lowering in reasons.lowerings(why)
    )
    asked = tuple(_word(w, vocabulary) for w in why if w.exclusion < 0)
    return Explanation(reasons.total(why), reasons.together(why), asked, excluded)


def _word(reason: reasons.WordReason, vocabulary: Sequence[str]) -> ExplainedWord:
    strongest = tuple(map(_in_seconds, reasons.strongest(reason)))
    named = reason.prior + reason.written + reason.as_caption
    return ExplainedWord(
        vocabulary[reason.word],
        reason.log_odds,
        reason.log_probability,
        reason.contribution,
        reason.prior,
        reason.written,
        reason.as_caption,
        tuple(map(_in_seconds, reason.shares)),
        strongest,
        reason.contribution - named - sum(s.share for s in strongest),
    )


def _in_seconds(share: reasons.Share) -> SymbolShare:
    return SymbolShare(share.symbol, share.start / MOTION_FPS, share.end / MOTION_FPS, share.amount)
