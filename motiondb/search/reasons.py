"""Decomposition of the score of an answer into words, symbols and frames.

The log-odds of a word in a window are linear in the window's score vector v
(:mod:`motiondb.meaning.word_map`):

    log-odds(w) = const_w + v . k_w,    v = sum_i f_i z_i / |sum_i f_i z_i|

with z_i the standardised scores of segment i and f_i its frames inside the window. Segment i
therefore contributes f_i (z_i . k_w) / |...| to its symbol's share, averaged over an action's words
and over the windows (that of the action and the whole capture). To the whole capture the word's
likeness (:mod:`motiondb.meaning.caption_map`) is added. The log-odds of several words and
actions together are not the mean of their log-odds; the difference is one further part,
``together``. Every
exclusion lowers the answer by one number, ``Lowering.amount``. The parts of the requested words,
``together`` and these amounts sum (``math.fsum``) to exactly the number by which the answer is
ranked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from motiondb.meaning.by_question import QuestionHit, Statement
from motiondb.meaning.word_evidence import WINDOW_MARGIN, action_log_odds, joint_log_odds
from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.search.asked_words import AskedWords
from motiondb.tabled import Tabled


@dataclass(frozen=True)
class SymbolShare:
    """Contribution of a motion symbol, in one interval, to the log-odds of an answer."""

    __pydantic_config__: ClassVar = {"alias_generator": lambda name: name.rstrip("_")}
    symbol: int
    from_: float  # Start of the interval, seconds; "from" in JSON
    to: float  # End of the interval, seconds
    share: float  # Nats


@dataclass(frozen=True)
class WordReason:
    """Contribution of one word of the query to an answer."""

    word: int  # Number in the vocabulary
    action: int  # Number of its action
    log_odds: float  # Log-odds of the word alone: mean of its window and of the whole capture
    prior: float  # Contribution of the word's frequency, before any motion is considered
    written: float  # Contribution of captions of the capture
    shares: tuple[SymbolShare, ...]  # Contributions of the segments, in order of time
    # Number of the exclusion that the word belongs to, -1 if it is requested. The parts of an
    # excluded word sum to its share of the log-odds of its action, not to anything that is added to
    # the answer
    exclusion: int = -1
    likeness: float = 0.0  # Contribution of the likeness to the caption that the motion suggests

    @property
    def parts(self) -> tuple[float, ...]:
        """All summands of the log-odds of the word's action that are due to this word."""
        return (self.prior, self.written, self.likeness, *(s.share for s in self.shares))

    @property
    def contribution(self) -> float:
        """Sum of the parts."""
        return math.fsum(self.parts)

    @property
    def log_probability(self) -> float:
        """log P(word), nats, from ``log_odds``."""
        return -float(np.logaddexp(0.0, -self.log_odds))


@dataclass(frozen=True, eq=False)
class Evidence:
    """The data from which the log-odds of one word in one capture are computed."""

    constant: float  # const_w of the module
    slope: FloatArray  # (symbols,): k_w of the module
    standardised: FloatArray  # (segments, symbols): standardised scores of the segments
    starts: IntArray  # (segments,): first frame of each segment
    ends: IntArray  # (segments,): one past the last frame of each segment
    symbols: IntArray  # (segments,): symbols of the segments
    written: FloatArray  # (segments,): log-odds that captions add, 0 without captions
    likeness: float = 0.0  # Likeness of the word to what the motion of the capture suggests, nats


def segment_shares(evidence: Evidence, low: int, high: int) -> FloatArray:
    """Contribution of every segment to a word's log-odds in a window: array (segments,)."""
    inside = np.minimum(evidence.ends, high) - np.maximum(evidence.starts, low)
    weights = np.maximum(inside, 0).astype(np.float64)
    length = float(np.linalg.norm(weights @ evidence.standardised))
    return weights * (evidence.standardised @ evidence.slope) / (length if length > 0 else 1.0)


def said_by_captions(written: FloatArray, starts: IntArray, statement: Statement) -> float:
    """What captions add to a word where a statement is evaluated.

    Shapes: `written` (segments,): log-odds that captions add; `starts` (segments,).
    """
    said = (1.0 - statement.near) * float(written.max())
    for frame, share in statement.places:
        said += statement.near * share * float(written[_segment_at(starts, frame)])
    return said


def _segment_at(starts: IntArray, frame: int) -> int:
    """The segment that holds a frame; `starts` (segments,)."""
    return int(np.searchsorted(starts, frame, side="right")) - 1


def explain_word(
    evidence: Evidence, word: int, action: int, statement: Statement, weight: float
) -> WordReason:
    """Decompose the contribution of one word of an action, with its weight in the answer."""
    whole = 1.0 - statement.near
    amounts = whole * segment_shares(evidence, 0, int(evidence.ends[-1]))
    said = said_by_captions(evidence.written, evidence.starts, statement)
    for frame, share in statement.places:
        peak = _segment_at(evidence.starts, frame)
        low = int(evidence.starts[peak]) - WINDOW_MARGIN
        high = int(evidence.ends[peak]) + WINDOW_MARGIN
        amounts = amounts + statement.near * share * segment_shares(evidence, low, high)
    shares = tuple(
        SymbolShare(int(symbol), int(start) / MOTION_FPS, int(end) / MOTION_FPS, weight * amount)
        for symbol, start, end, amount in zip(
            evidence.symbols, evidence.starts, evidence.ends, amounts.tolist()
        )
    )
    alike = 2.0 * whole * evidence.likeness
    log_odds = math.fsum([evidence.constant, said, alike, *amounts])
    return WordReason(
        word,
        action,
        log_odds,
        weight * evidence.constant,
        weight * said,
        shares,
        statement.exclusion,
        weight * alike,
    )


def explain_hit(asked: AskedWords, capture: int, hit: QuestionHit) -> tuple[WordReason, ...]:
    """The contribution of every word of a question to an answer, segment by segment."""
    learned, table = asked.learned, asked.learned.segments
    rows = learned.rows[capture]
    standardised = learned.segment_rows[rows]
    said = asked.evidence.written.get(capture)
    alike = asked.likeness[learned.places_in_rows[capture]]
    n_asked = sum(statement.exclusion < 0 for statement in hit.statements)
    why = []
    for action, statement in enumerate(hit.statements):
        share = 1.0 if statement.exclusion >= 0 else 1.0 / n_asked
        for word in statement.words:
            slope, constant = asked.word_map.linear(word)
            evidence = Evidence(
                constant,
                slope,
                standardised,
                table.starts[rows],
                table.ends[rows],
                table.symbols[rows],
                np.zeros(len(standardised)) if said is None else said[:, word],
                float(alike[word]),
            )
            weight = share / len(statement.words)
            why.append(explain_word(evidence, word, action, statement, weight))
    return tuple(why)


def by_action(reasons: Sequence[WordReason]) -> list[float]:
    """Log-odds of every action alone, in order."""
    actions = sorted({reason.action for reason in reasons})
    return [
        float(action_log_odds([reason.log_odds for reason in reasons if reason.action == k]))
        for k in actions
    ]


def together(reasons: Sequence[WordReason]) -> float:
    """Log-odds of all words together, less the mean of those of actions (0 for one word)."""
    asked = [reason for reason in reasons if reason.exclusion < 0]
    if len(asked) < 2:
        return 0.0
    return joint_log_odds(by_action(asked)) - math.fsum(asked_parts(reasons))


def asked_parts(reasons: Sequence[WordReason]) -> list[float]:
    """Every part of every requested word."""
    return [part for reason in reasons if reason.exclusion < 0 for part in reason.parts]


@dataclass(frozen=True)
class Lowering:
    """The reduction of an answer by one exclusion."""

    exclusion: int
    log_odds: float  # Log-odds that all of them are seen
    # The contribution of the exclusion to the answer's log-odds: at most 0, except for the first
    # exclusion of a question without requested actions, for which it is -log_odds
    amount: float


def lowerings(reasons: Sequence[WordReason]) -> list[Lowering]:
    """The reductions of an answer by its exclusions, in order; each after the earlier ones."""
    statements = by_action([reason for reason in reasons if reason.exclusion < 0])
    lowered = []
    for number in sorted({reason.exclusion for reason in reasons if reason.exclusion >= 0}):
        joint = joint_log_odds(by_action([r for r in reasons if r.exclusion == number]))
        before = joint_log_odds(statements) if statements else 0.0
        statements.append(-joint)
        amount = joint_log_odds(statements) - before
        lowered.append(Lowering(number, joint, amount))
    return lowered


def total(reasons: Sequence[WordReason]) -> float:
    """The log-odds that rank the answer: the exactly rounded sum of all parts and lowerings."""
    amounts = [lowering.amount for lowering in lowerings(reasons)]
    return math.fsum([*asked_parts(reasons), together(reasons), *amounts])


def strongest(reason: WordReason, limit: int = 3) -> list[SymbolShare]:
    """Shares of largest absolute value; those of neighbours with one symbol are added first."""
    joined: list[SymbolShare] = []
    for each in reason.shares:
        if joined and joined[-1].symbol == each.symbol and joined[-1].to == each.from_:
            last = joined[-1]
            joined[-1] = SymbolShare(last.symbol, last.from_, each.to, last.share + each.share)
        else:
            joined.append(each)
    return sorted(joined, key=lambda each: -abs(each.share))[:limit]


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
        Sum of ``prior``, ``written``, ``likeness`` and all ``symbols``.
    prior : float
        Contribution of the word's frequency, before any motion is considered.
    written : float
        Contribution of captions.
    likeness : float
        Contribution of the likeness to the caption that the motion of the capture suggests.
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
    likeness: float
    symbols: tuple[SymbolShare, ...]
    strongest: tuple[SymbolShare, ...]
    others: float


@dataclass(frozen=True)
class ExplainedExclusion:
    """What the exclusion of some words adds to an answer's log-odds."""

    amount: float  # What the exclusion adds, nats
    log_odds: float  # Log-odds that the capture shows them
    words: tuple[ExplainedWord, ...]


@dataclass(frozen=True, repr=False)
class Explanation(Tabled):
    """Parts of the log-odds that rank an answer.

    ``math.fsum`` of the parts of ``words`` (prior, written, likeness, symbols), of ``together``
    and of the amounts of ``excluded`` is exactly ``log_odds``.

    Attributes
    ----------
    log_odds : float
        Log-odds of the answer, nats.
    together : float
        Log-odds of all words together, less the mean of those of actions; 0 for one word.
    words : tuple of ExplainedWord
        The requested words.
    excluded : tuple of ExplainedExclusion
        What every exclusion adds.
    suggests : tuple of str
        Captions of other captures nearest in meaning to what the motion of this one suggests: what
        the likeness of the words is to.
    """

    log_odds: float
    together: float
    words: tuple[ExplainedWord, ...]
    excluded: tuple[ExplainedExclusion, ...]
    suggests: tuple[str, ...] = ()


def explain(
    why: Sequence[WordReason], vocabulary: Sequence[str], suggests: tuple[str, ...] = ()
) -> Explanation:
    """Explain one answer."""
    excluded = tuple(
        ExplainedExclusion(
            lowering.amount,
            lowering.log_odds,
            tuple(_word(w, vocabulary) for w in why if w.exclusion == lowering.exclusion),
        )
        for lowering in lowerings(why)
    )
    asked = tuple(_word(w, vocabulary) for w in why if w.exclusion < 0)
    return Explanation(total(why), together(why), asked, excluded, suggests)


def _word(reason: WordReason, vocabulary: Sequence[str]) -> ExplainedWord:
    shares = tuple(strongest(reason))
    named = reason.prior + reason.written + reason.likeness
    return ExplainedWord(
        vocabulary[reason.word],
        reason.log_odds,
        reason.log_probability,
        reason.contribution,
        reason.prior,
        reason.written,
        reason.likeness,
        reason.shares,
        shares,
        reason.contribution - named - sum(s.share for s in shares),
    )
