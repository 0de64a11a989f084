"""Explanation of the rank of an answer to words, in words and seconds.

The numbers are those of :mod:`motiondb.search.reasons`; here word numbers become words,
and frames become seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from motiondb.records import MOTION_FPS
from motiondb.search import reasons


@dataclass(frozen=True)
class SymbolShare:
    """Contribution of a motion symbol, in one interval, to the log-odds of an answer."""

    symbol: int
    start: float  # Start of the interval, seconds
    end: float  # End of the interval, seconds
    amount: float


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
    prior : float
        Contribution of the word's frequency, before any motion is considered.
    written : float
        Contribution of captions.
    as_caption : float
        Contribution of the comparison of a long question with whole captions.
    shares : tuple of SymbolShare
        Contribution of every segment, in order of time.
    strongest : tuple of SymbolShare
        The largest shares by absolute value; neighbours with the same symbol count as one.
    contribution : float
        Sum of ``prior``, ``written``, ``as_caption`` and all ``shares``.
    """

    word: str
    log_odds: float
    log_probability: float
    prior: float
    written: float
    as_caption: float
    shares: tuple[SymbolShare, ...]
    strongest: tuple[SymbolShare, ...]
    contribution: float

    @property
    def other_shares(self) -> float:
        """Sum of the shares that are not among the strongest."""
        named = self.prior + self.written + self.as_caption
        return self.contribution - named - sum(s.amount for s in self.strongest)

    def facts(self) -> dict[str, Any]:
        """The numbers for JSON; times in seconds."""
        return {
            "word": self.word,
            "log_odds": self.log_odds,
            "log_probability": self.log_probability,
            "contribution": self.contribution,
            "prior": self.prior,
            "written": self.written,
            "as_caption": self.as_caption,
            "symbols": [
                {"symbol": s.symbol, "from": s.start, "to": s.end, "share": s.amount}
                for s in self.shares
            ],
        }


@dataclass(frozen=True)
class ExplainedExclusion:
    """What the exclusion of some words adds to an answer's log-odds."""

    words: tuple[ExplainedWord, ...]
    log_odds: float  # Log-odds that the capture shows them
    amount: float  # What the exclusion adds, nats


@dataclass(frozen=True)
class Explanation:
    """Parts of the log-odds that rank an answer.

    ``math.fsum`` of the parts of ``words`` (prior, written, as_caption, shares), of ``together``
    and of the amounts of ``excluded`` is exactly ``log_odds``.

    Attributes
    ----------
    log_odds : float
        Log-odds of the answer, nats.
    words : tuple of ExplainedWord
        The requested words.
    together : float
        Log-odds that all actions occur, less the mean of their log-odds; 0 for one action.
    excluded : tuple of ExplainedExclusion
        What every exclusion adds.
    """

    log_odds: float
    words: tuple[ExplainedWord, ...]
    together: float
    excluded: tuple[ExplainedExclusion, ...]

    def facts(self) -> dict[str, Any]:
        """The parts for JSON; their sum is ``log_odds``, as described above."""
        return {
            "log_odds": self.log_odds,
            "together": self.together,
            "words": [word.facts() for word in self.words],
            "excluded": [
                {
                    "amount": excluded.amount,
                    "log_odds": excluded.log_odds,
                    "words": [word.facts() for word in excluded.words],
                }
                for excluded in self.excluded
            ],
        }


def explain(why: Sequence[reasons.WordReason], vocabulary: Sequence[str]) -> Explanation:
    """Explain one answer."""
    excluded = tuple(
        ExplainedExclusion(
            tuple(_word(w, vocabulary) for w in why if w.exclusion == lowering.exclusion),
            lowering.log_odds,
            lowering.amount,
        )
        for lowering in reasons.lowerings(why)
    )
    asked = tuple(_word(w, vocabulary) for w in why if w.exclusion < 0)
    return Explanation(reasons.total(why), asked, reasons.together(why), excluded)


def _word(reason: reasons.WordReason, vocabulary: Sequence[str]) -> ExplainedWord:
    return ExplainedWord(
        vocabulary[reason.word],
        reason.log_odds,
        reason.log_probability,
        reason.prior,
        reason.written,
        reason.as_caption,
        tuple(map(_in_seconds, reason.shares)),
        tuple(map(_in_seconds, reasons.strongest(reason))),
        reason.contribution,
    )


def _in_seconds(share: reasons.Share) -> SymbolShare:
    return SymbolShare(share.symbol, share.start / MOTION_FPS, share.end / MOTION_FPS, share.amount)
