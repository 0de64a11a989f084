"""The words that a motion shows, by a judge that is independent of its generation.

The judge compares a motion with the captures as wholes, by statistics of windows of three seconds.
It uses neither symbols nor segments nor places, and never the captures that the motion was made
from. Notation:

    x       a window's means, standard deviations and quantiles (.1, .5, .9) of the whitened
            features, standardised, clipped, of length 1, with a constant 1 appended,
    g_w     1/sqrt(n) for the windows of a capture whose captions say word w among n actions, else 0
    m_w     mean of g_w over the windows,
    z_w     (x . u_w - m_w) / (m_w (1 - m_w))^(1/4), the mean over a motion's windows, where u_w is
            the ridge regression of g_w on x. Each window weighs 1/sqrt(windows of its capture).

Two cues give a calibrated probability that a motion shows w: z_w, and z_w less the largest z of
other words. Words that mostly occur in the same captions as w do not count among the others.
:mod:`motiondb.meaning.judging.judge_fitting` describes their calibration.

Source: ridge regression on pooled features is the strongest ordinary method of ``docs/quality.md``.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning.calibration import Certainty, probability
from motiondb.meaning.counting import Described
from motiondb.records import Float32Array, FloatArray, IntArray

WINDOW = 45
"""Feature frames (3 s) of a window; windows overlap by half. Two to three seconds were the best
context in first measurements."""
QUANTILES = (0.1, 0.5, 0.9)  # Quantiles over the frames of a window
CLIP = 3.0  # Standard deviations beyond which a value is clipped
RIDGE = 1.0
"""Ridge of the regression. Of .03 to 10, 1 gave the most right first words on CMU performers left
out (.629; .615 to .629 from .03 to 3)."""
SPREAD_POWER = 0.25
"""Power of the variance in z, as in the word map; .5 gave .592 right first words in place of
.629."""
RELATED = 0.5
"""Two words are related if at least this share of the captures of one also has the other."""

Said = Mapping[int, tuple[frozenset[int], int]]
"""Capture number -> numbers of the words in its captions, and of the actions that these name."""


@dataclass(frozen=True, eq=False)
class MotionJudge:
    """The fitted data of the judge; the words of the captures are those of the current captions."""

    mean: FloatArray  # (columns,): means of the statistics
    spread: FloatArray  # (columns,): their standard deviations
    rows: FloatArray  # (windows, columns): statistics of the windows of all captures
    captures: IntArray  # (windows,): capture of every window
    # (4,): certainty from the two cues, as an array; empty if too few captures could be compared
    calibration: FloatArray

    def only(self, captures: Collection[int]) -> MotionJudge:
        """Return the judge with the windows of some captures only."""
        kept = np.isin(self.captures, list(captures))
        rows, owners = self.rows[kept], self.captures[kept]
        return MotionJudge(self.mean, self.spread, rows, owners, self.calibration)

    def standardise(self, rows: FloatArray) -> FloatArray:
        """Vectors x of windows: array (windows, columns + 1)."""
        x = np.clip((rows - self.mean) / self.spread, -CLIP, CLIP)
        length = np.linalg.norm(x, axis=1, keepdims=True)
        return np.concatenate([x / np.maximum(length, 1e-12), np.ones((len(x), 1))], axis=1)


def said_words(described: Sequence[Described], numbers: Mapping[str, int]) -> Said:
    """Numbers of the words in the captions of every capture, and of the actions that they name."""
    said: dict[int, tuple[frozenset[int], int]] = {}
    for d in described:
        words, n_actions = said.get(d.capture_id, (frozenset[int](), 1))
        more = frozenset(numbers[w] for w in d.words if w in numbers)
        said[d.capture_id] = (words | more, max(n_actions, d.n_actions))
    return said


def pool_windows(features: Float32Array) -> FloatArray:
    """Statistics of the windows of a motion: array (windows, 5 D); one window if it is short.

    Shapes: `features` (frames, D).
    """
    starts = range(0, max(len(features) - WINDOW, 0) + 1, WINDOW // 2)
    rows = []
    for start in starts:
        part = features[start : start + WINDOW].astype(np.float64)
        quantiles = np.quantile(part, QUANTILES, axis=0).ravel()
        rows.append(np.concatenate([part.mean(axis=0), part.std(axis=0), quantiles]))
    return np.array(rows)


@dataclass(frozen=True, eq=False)
class Sums:
    """Weighted sums of the regression, from which captures can be subtracted.

    gram: array (columns, columns); cross: array (columns, words); words: array (words,); weight.
    """

    gram: FloatArray
    cross: FloatArray
    words: FloatArray
    weight: float

    def less(self, other: Sums) -> Sums:
        """Return these sums less those of some captures."""
        return Sums(
            self.gram - other.gram,
            self.cross - other.cross,
            self.words - other.words,
            self.weight - other.weight,
        )


@dataclass(frozen=True, eq=False)
class JudgingTable:
    """The judge with the words of the current captions."""

    judge: MotionJudge
    vectors: FloatArray  # (windows, columns + 1): vectors x of the windows of described captures
    targets: FloatArray  # (windows, words): g of these windows
    weights: FloatArray  # (windows,): their weights
    owners: IntArray  # (windows,): their captures
    said: Said  # Words and number of actions of every capture
    together: FloatArray  # (words, words): number of captures that say both words

    def sums(self, which: IntArray | slice = slice(None)) -> Sums:
        """Sums over some windows."""
        x, w = self.vectors[which], self.weights[which][:, None]
        g = self.targets[which]
        return Sums((x * w).T @ x, (x * w).T @ g, (w * g).sum(axis=0), float(w.sum()))

    def related(self, word: int) -> frozenset[int]:
        """The words that mostly occur in the same captures as a word, including the word."""
        both, each = self.together[word], np.diag(self.together)
        near = (both >= RELATED * each[word]) | (both >= RELATED * np.maximum(each, 1.0))
        return frozenset(np.flatnonzero(near & (both > 0.0)).tolist()) | {word}


def judging_table(judge: MotionJudge, said: Said, n_words: int) -> JudgingTable:
    """Prepare a judge for the words of the captions."""
    kept = np.isin(judge.captures, list(said))
    owners = judge.captures[kept]
    targets = np.zeros((len(owners), n_words))
    presence = np.zeros((len(said), n_words))
    for n, (capture, (words, n_actions)) in enumerate(said.items()):
        listed = sorted(words)
        targets[np.ix_(owners == capture, listed)] = 1.0 / np.sqrt(max(n_actions, 1))
        presence[n, listed] = float((owners == capture).any())
    _, number, count = np.unique(owners, return_inverse=True, return_counts=True)
    weights = 1.0 / np.sqrt(count[number]) if len(owners) else np.zeros(0)
    return JudgingTable(
        judge,
        judge.standardise(judge.rows[kept]),
        targets,
        weights,
        owners,
        said,
        presence.T @ presence,
    )


@dataclass(frozen=True, eq=False)
class WithoutSources:
    """The judge without some captures."""

    table: JudgingTable  # The judge with all captures
    slopes: FloatArray  # (columns + 1, words): u
    mean: FloatArray  # (words,): m
    n_captures: FloatArray  # (words,): number of remaining captures whose captions have each word
    captures: frozenset[int]

    def scores(self, rows: FloatArray) -> FloatArray:
        """z of a motion, from the statistics of its windows: array (words,)."""
        kept = np.clip(self.mean, 1e-4, 0.999)
        x = self.table.judge.standardise(rows)
        z = (x @ self.slopes - self.mean) / (kept * (1.0 - kept)) ** SPREAD_POWER
        return np.asarray(z.mean(axis=0))

    def cues(self, scores: FloatArray, word: int) -> FloatArray:
        """The two cues of a word: array (2,)."""
        others = self.n_captures >= 1.0
        others[list(self.table.related(word))] = False
        best = float(scores[others].max()) if others.any() else 0.0
        return np.array([scores[word], scores[word] - best])

    def probability(self, scores: FloatArray, word: int) -> float | None:
        """Probability that a motion shows a word; None if no remaining capture has the word."""
        packed = self.table.judge.calibration
        if self.n_captures[word] < 1.0 or not len(packed):
            return None
        sure = Certainty(packed[:-2], float(packed[-2]), float(packed[-1]))
        return float(probability(sure.log_odds(self.cues(scores, word))))

    def likeliest(self, scores: FloatArray, n_words: int) -> list[tuple[int, float]]:
        """The words of the largest z, the most probable first."""
        known = np.flatnonzero(self.n_captures >= 1.0)
        order = known[np.argsort(-scores[known], kind="stable")][:n_words]
        likely = [(int(w), self.probability(scores, int(w))) for w in order]
        told = [(word, p) for word, p in likely if p is not None]
        return sorted(told, key=lambda pair: -pair[1])


def judge_without(
    table: JudgingTable, out: Collection[int], sums: Sums | None = None
) -> WithoutSources | None:
    """The judge without some captures; None if no described capture is left."""
    gone = np.flatnonzero(np.isin(table.owners, list(out)))
    left = (sums or table.sums()).less(table.sums(gone))
    if len(gone) == len(table.owners):
        return None
    ridge = np.full(len(left.gram), RIDGE)
    ridge[-1] = 1e-9  # the constant is not penalised
    slopes = np.linalg.solve(left.gram + np.diag(ridge), left.cross)
    n_captures = np.diag(table.together).copy()
    inside = set(table.owners[gone].tolist())
    for capture in inside:
        n_captures[sorted(table.said[capture][0])] -= 1.0
    remaining = frozenset(table.owners.tolist()) - inside
    mean = left.words / left.weight
    return WithoutSources(table, np.asarray(slopes), mean, n_captures, remaining)
