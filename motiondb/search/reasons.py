"""Why an interval was found: its score taken apart, exactly, into words, symbols and frames.

The log-odds of a word in a window are linear in the window's score vector v (``words.word_map``):

    log-odds(w) = const_w + v . k_w,    v = sum_i f_i z_i / |sum_i f_i z_i|

with z_i the standardised scores of segment i and f_i its frames inside the window. So segment i
adds f_i (z_i . k_w) / |...|, and that is its share, said of the symbol that won the segment. Means
over an action's words and over the two looks (the action's window and the whole capture) are
applied to every share already. Several actions are wanted together, and the log-odds of all are not
the mean of theirs: what that changes is one further part, ``together``. All parts of an answer sum
(``math.fsum``) to the very number that ranks it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray
from motiondb.search.by_words import joint_log_odds


@dataclass(frozen=True)
class Share:
    """What one segment (frames [start, end), won by ``symbol``) adds to an answer's log-odds."""

    symbol: int
    start: int
    end: int
    amount: float


@dataclass(frozen=True)
class WordReason:
    """What one asked word adds to an answer.

    Attributes
    ----------
    word : int
        Number in the vocabulary.
    action : int
        Number of its action.
    log_odds : float
        Of the word by itself, the mean of its window and of the whole capture.
    prior : float
        What it adds before any motion is seen (how often it is said).
    written : float
        What people's words about the capture add.
    shares : tuple[Share, ...]
        What the segments add, in order of time.
    """

    word: int
    action: int
    log_odds: float
    prior: float
    written: float
    shares: tuple[Share, ...]

    @property
    def parts(self) -> tuple[float, ...]:
        """Every number that adds to the answer's log-odds."""
        return (self.prior, self.written, *(share.amount for share in self.shares))

    @property
    def contribution(self) -> float:
        """Their sum."""
        return math.fsum(self.parts)

    @property
    def log_probability(self) -> float:
        """log P(word), nats, from ``log_odds``."""
        return -float(np.logaddexp(0.0, -self.log_odds))


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a capture offers for one word.

    constant, slope : of the word, see the module; a number and array (symbols,).
    standardised : array (segments, symbols). starts, ends, symbols : arrays (segments,).
    written : array (segments,), log-odds that people's words add, 0 where there are none.
    """

    constant: float
    slope: FloatArray
    standardised: FloatArray
    starts: IntArray
    ends: IntArray
    symbols: IntArray
    written: FloatArray


def segment_shares(evidence: Evidence, low: int, high: int) -> FloatArray:
    """What every segment adds to a word's log-odds in the window [low, high): array (segments,)."""
    inside = np.minimum(evidence.ends, high) - np.maximum(evidence.starts, low)
    weights = np.maximum(inside, 0).astype(np.float64)
    length = float(np.linalg.norm(weights @ evidence.standardised))
    return weights * (evidence.standardised @ evidence.slope) / (length if length > 0 else 1.0)


def explain_word(
    evidence: Evidence, word: int, action: int, window: tuple[int, int], peak: int, weight: float
) -> WordReason:
    """Take one word's part of an answer apart.

    Parameters
    ----------
    window : tuple[int, int]
        Frames of the action's window.
    peak : int
        Number of the segment it stands around.
    weight : float
        Of this word in the answer: 1 / (actions with words * words of the action).
    """
    near = segment_shares(evidence, *window)
    whole = segment_shares(evidence, 0, int(evidence.ends[-1]))
    said = 0.5 * float(evidence.written[peak]) + 0.5 * float(evidence.written.max())
    amounts = 0.5 * near + 0.5 * whole
    shares = tuple(
        Share(int(symbol), int(start), int(end), float(weight * amount))
        for symbol, start, end, amount in zip(
            evidence.symbols, evidence.starts, evidence.ends, amounts
        )
    )
    log_odds = math.fsum([evidence.constant, said, *amounts])
    return WordReason(word, action, log_odds, weight * evidence.constant, weight * said, shares)


def by_action(reasons: Sequence[WordReason]) -> list[tuple[float, float]]:
    """Log-odds of every asked action by itself, and what of them people's words add."""
    actions = sorted({reason.action for reason in reasons})
    found = []
    for k in actions:
        own = [reason for reason in reasons if reason.action == k]
        log_odds = math.fsum(p for reason in own for p in reason.parts)
        said = math.fsum(reason.written for reason in own)
        found.append((len(actions) * log_odds, len(actions) * said))
    return found


def together(reasons: Sequence[WordReason]) -> float:
    """What asking for all actions at once adds to the mean of their log-odds (0 for one action)."""
    each = [log_odds for log_odds, _ in by_action(reasons)]
    if len(each) < 2:
        return 0.0
    return joint_log_odds(each) - math.fsum(p for reason in reasons for p in reason.parts)


def total(reasons: Sequence[WordReason]) -> float:
    """The answer's log-odds: the exactly rounded sum of all parts of all words."""
    parts = [part for reason in reasons for part in reason.parts]
    return math.fsum([*parts, together(reasons)])


def strongest(reason: WordReason, limit: int = 3) -> list[Share]:
    """The shares that speak loudest for or against a word; neighbours of one symbol are joined."""
    joined: list[Share] = []
    for share in reason.shares:
        if joined and joined[-1].symbol == share.symbol and joined[-1].end == share.start:
            last = joined[-1]
            joined[-1] = Share(last.symbol, last.start, share.end, last.amount + share.amount)
        else:
            joined.append(share)
    return sorted(joined, key=lambda share: -abs(share.amount))[:limit]
