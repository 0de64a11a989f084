"""Why an interval was found: its score taken apart, exactly, into words, symbols and frames.

The log-odds of a word in a window are linear in the window's score vector v (``words.word_map``):

    log-odds(w) = const_w + v . k_w,    v = sum_i f_i z_i / |sum_i f_i z_i|

with z_i the standardised scores of segment i and f_i its frames inside the window. So segment i
adds f_i (z_i . k_w) / |...|, and that is its share, said of the symbol that won the segment. Means
over an action's words and over the two looks (the action's window and the whole capture) are
applied to every share already. Several actions are wanted together, and the log-odds of all are not
the mean of theirs: what that changes is one further part, ``together``. What is excluded is taken
apart in the same way, and every exclusion lowers the answer by one number, ``Lowering.amount``. All
parts of what is asked, ``together`` and these amounts sum (``math.fsum``) to the very number that
ranks the answer.
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
    word : number in the vocabulary. action : number of its action.
    log_odds : of the word by itself, the mean of its window and of the whole capture.
    prior : what it adds before any motion is seen (how often it is said).
    written : what people's words about the capture add.
    shares : what the segments add, in order of time.
    exclusion : number of the exclusion that it belongs to, -1 where it is asked for. The parts of
        an excluded word sum to its share of its action's log-odds, not to anything that is added to
        the answer.
    """

    word: int
    action: int
    log_odds: float
    prior: float
    written: float
    shares: tuple[Share, ...]
    exclusion: int = -1

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
    window : frames of the action's window. peak : number of the segment it stands around.
    weight : of this word in the answer: 1 / (actions with words * words of the action).
    """
    look = Look((window,), (peak,), (1.0,), 0.5)
    return explain_look(evidence, word, look, Place(action, weight))


@dataclass(frozen=True)
class Look:
    """Where an action is looked at.

    Attributes
    ----------
    windows : tuple of (int, int)
        Frames of every window.
    peaks : tuple of int
        Numbers of the segments that they stand around.
    weights : tuple of float
        Their weights, which sum to 1.
    near : float
        Share of the windows; the rest is of the whole capture.
    """

    windows: tuple[tuple[int, int], ...]
    peaks: tuple[int, ...]
    weights: tuple[float, ...]
    near: float


@dataclass(frozen=True)
class Place:
    """A word's place in a question.

    Attributes
    ----------
    action : int
        Number of its action.
    weight : float
        Of the word: 1 / (asked actions * words of the action); for an excluded word
        1 / words of the action.
    exclusion : int
        Number of its exclusion, -1 where it is asked for.
    """

    action: int
    weight: float
    exclusion: int = -1


def explain_look(evidence: Evidence, word: int, look: Look, place: Place) -> WordReason:
    """Take one word's part of an answer apart, said of several windows and the whole capture."""
    amounts = (1.0 - look.near) * segment_shares(evidence, 0, int(evidence.ends[-1]))
    said = (1.0 - look.near) * float(evidence.written.max())
    for window, peak, weight in zip(look.windows, look.peaks, look.weights):
        amounts = amounts + look.near * weight * segment_shares(evidence, *window)
        said += look.near * weight * float(evidence.written[peak])
    shares = tuple(
        Share(int(symbol), int(start), int(end), float(place.weight * amount))
        for symbol, start, end, amount in zip(
            evidence.symbols, evidence.starts, evidence.ends, amounts
        )
    )
    log_odds = math.fsum([evidence.constant, said, *amounts])
    return WordReason(
        word, place.action, log_odds, place.weight * evidence.constant, place.weight * said,
        shares, place.exclusion,
    )  # fmt: skip


def by_action(reasons: Sequence[WordReason]) -> list[tuple[float, float]]:
    """Log-odds of every asked action by itself, and what of them people's words add."""
    asked = [reason for reason in reasons if reason.exclusion < 0]
    actions = sorted({reason.action for reason in asked})
    found = []
    for k in actions:
        own = [reason for reason in asked if reason.action == k]
        log_odds = math.fsum(p for reason in own for p in reason.parts)
        said = math.fsum(reason.written for reason in own)
        found.append((len(actions) * log_odds, len(actions) * said))
    return found


def together(reasons: Sequence[WordReason]) -> float:
    """What asking for all actions at once adds to the mean of their log-odds (0 for one action)."""
    each = [log_odds for log_odds, _ in by_action(reasons)]
    if len(each) < 2:
        return 0.0
    return joint_log_odds(each) - math.fsum(asked_parts(reasons))


def asked_parts(reasons: Sequence[WordReason]) -> list[float]:
    """Every part of every word that is asked for."""
    return [part for reason in reasons if reason.exclusion < 0 for part in reason.parts]


@dataclass(frozen=True)
class Lowering:
    """What one exclusion takes from an answer.

    Attributes
    ----------
    exclusion : int
        Its number.
    actions : tuple of (float, float)
        Per excluded action its log-odds, and what of them people's words add.
    log_odds : float
        That all of them are seen.
    amount : float
        What the exclusion adds to the answer's log-odds: at most 0, but for the first of a
        question that asks for nothing, which is -log_odds.
    """

    exclusion: int
    actions: tuple[tuple[float, float], ...]
    log_odds: float
    amount: float


def lowerings(reasons: Sequence[WordReason]) -> list[Lowering]:
    """What every exclusion takes from an answer, in order; each after the ones before it."""
    statements = [log_odds for log_odds, _ in by_action(reasons)]
    found = []
    for number in sorted({reason.exclusion for reason in reasons if reason.exclusion >= 0}):
        own = [reason for reason in reasons if reason.exclusion == number]
        each = []
        for action in sorted({reason.action for reason in own}):
            words = [reason for reason in own if reason.action == action]
            log_odds = math.fsum(part for reason in words for part in reason.parts)
            each.append((log_odds, math.fsum(reason.written for reason in words)))
        joint = joint_log_odds([log_odds for log_odds, _ in each])
        before = joint_log_odds(statements) if statements else 0.0
        statements.append(-joint)
        amount = joint_log_odds(statements) - before
        found.append(Lowering(number, tuple(each), joint, amount))
    return found


def total(reasons: Sequence[WordReason]) -> float:
    """The answer's log-odds: the exactly rounded sum of all parts, ``together`` and lowerings."""
    amounts = [lowering.amount for lowering in lowerings(reasons)]
    return math.fsum([*asked_parts(reasons), together(reasons), *amounts])


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
