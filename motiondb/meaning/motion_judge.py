"""The words that a motion shows, by a judge that is independent of its generation.

**The judge** compares a motion with the captures as wholes, by statistics of windows of three
seconds. It uses neither symbols nor segments nor places, and never the captures that the motion was
made from. Notation:

    x       a window's means, standard deviations and quantiles (.1, .5, .9) of the whitened
            features, standardised and clipped; D values,
    k(x, x') = exp(-|x - x'|^2 / D), the likeness of two windows,
    g_w     1/sqrt(n) for the windows of a capture whose captions say word w among n actions, else 0
    m_w     mean of g_w over the windows, each of weight 1/sqrt(windows of its capture),
    z_w     (sum_i a_iw k(x, x_i)) / (m_w (1 - m_w))^(1/4), the mean over a motion's windows, where
            the a_iw are the kernel ridge regression of g_w - m_w on the windows x_i.

Far from all windows every z is 0: what is like nothing is neither shown nor denied. Captures are
left out exactly: with A the inverse of the kernel matrix with its ridge, a = A (g - m), and r the
rows left out, the others have the coefficients a - A_:r (A_rr)^-1 a_r.

Two cues give a calibrated probability that a motion shows w: z_w, and z_w less the largest z of
other words. Words that mostly occur in the same captures as w do not count among the others.

Source: Saunders, Gammerman and Vovk (1998) for the regression.

**The calibration of the two cues** uses real captures in pairs: one whose captions contain the word
w, and one of the same performer whose captions contain neither w nor a word related to it. In half
of the pairs, the second is one of the captures most similar to those of w. Both are judged without
the two, each by one or two of its windows, because generated motion is as short. The probability
therefore assumes prior odds of one to one.

A part of a capture of several actions may not show w. The first of a pair is therefore a capture
whose captions name one action, unless there are too few of these. No word has more than
``PAIRS_OF_A_WORD`` pairs, so that walking and running alone do not determine the probability.

On 508 pairs of CMU captures, 61 words, with the performers left out of the calibration: area under
the curve .88, expected calibration error .02 (linear regression: .84, .04); probabilities of .13,
.28, .49, .70 and .94 were right .15, .27, .45, .82 and .94 of the time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.counting import Described
from motiondb.meaning.regression import Certainty, fit_probability, probability
from motiondb.meaning.resemblance import pooled_statistics
from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.symbols.hmm_jobs import one_blas_thread

WINDOW = 45
"""Feature frames (3 s) of a window; windows overlap by half. Two to three seconds were the best
context in first measurements."""
CLIP = 3.0  # Standard deviations beyond which a value is clipped
RIDGE = 0.03
MOST_WINDOWS, MOST_ROWS = 8, 1500
"""Largest numbers of windows that the judge keeps, of a capture (spread over it) and in all: the
time of a verdict grows with the third power of the latter. Of more captures, those with rare words
stay."""
SPREAD_POWER = 0.25  # Power of the variance in z, as in the word map
RELATED = 0.5
"""Two words are related if at least this share of the captures of one also has the other."""
OTHERS = 3
"""Number of captures with which each capture is compared: more make the calibration more stable."""
PAIRS_OF_A_WORD = 30
"""Largest number of pairs of a word for the calibration: more take longer, and
words with many captures would outweigh the others."""
MOST_PAIRS = 1_500  # Largest number of pairs for the calibration: more take longer
PARTS = 2
"""Largest number of windows of a capture that are judged in the calibration: 3 to 4.5 s, about
the duration of an action in a generated motion."""
LEAST_PAIRS = 15  # Smallest number of pairs for a calibration, as for answers (``asked_certainty``)

Said = Mapping[int, tuple[frozenset[int], int]]
"""Capture number -> numbers of the words in its captions, and of the actions that these name."""


@dataclass(frozen=True, eq=False)
class MotionJudge:
    """The fitted data of the judge; the words of the captures are those of the current captions."""

    mean: FloatArray  # (columns,): means of the statistics
    spread: FloatArray  # (columns,): their standard deviations
    rows: FloatArray  # (windows, columns): statistics of the windows of all captures
    captures: IntArray  # (windows,): capture of every window
    # Certainty from the two cues; None if too few captures could be compared
    certainty: Certainty | None = None

    def only(self, captures: Collection[int]) -> MotionJudge:
        """Return the judge with the windows of some captures only."""
        kept = np.isin(self.captures, list(captures))
        return replace(self, rows=self.rows[kept], captures=self.captures[kept])

    def likeness(self, rows: FloatArray) -> FloatArray:
        """Likeness k of windows to those of the judge: array (n, windows)."""
        x, (known, lengths) = self._clipped(rows), self._known
        with one_blas_thread():  # sums of several threads differ in their last bits
            alike = 2.0 * x @ known.T
        alike -= (x**2).sum(axis=1)[:, None] + lengths  # in place: they are many
        np.minimum(alike, 0.0, out=alike)
        alike /= x.shape[1]
        return np.asarray(np.exp(alike, out=alike))

    def _clipped(self, rows: FloatArray) -> FloatArray:
        return np.clip((rows - self.mean) / self.spread, -CLIP, CLIP)

    @cached_property
    def _known(self) -> tuple[FloatArray, FloatArray]:
        """Statistics of the windows in standard deviations, and their squared lengths."""
        known = self._clipped(self.rows)
        return known, (known**2).sum(axis=1)

    @cached_property
    def weights(self) -> FloatArray:
        """Weight of every window: array (windows,)."""
        _, number, count = np.unique(self.captures, return_inverse=True, return_counts=True)
        return 1.0 / np.sqrt(count[number])

    @cached_property
    def inverse(self) -> FloatArray:
        """A of the module's docstring: array (windows, windows)."""
        matrix = self.likeness(self.rows) + np.diag(RIDGE / self.weights)
        with one_blas_thread():
            return np.asarray(np.linalg.inv(matrix))


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
    parts = np.stack([features[start : start + WINDOW] for start in starts]).astype(np.float64)
    return pooled_statistics(parts)


@dataclass(frozen=True, eq=False)
class JudgingTable:
    """The judge with the words of the current captions."""

    judge: MotionJudge  # With the described captures only
    coefficients: FloatArray  # (windows, words): a
    mean: FloatArray  # (words,): m
    said: Said  # Words and number of actions of every capture
    together: FloatArray  # (words, words): number of captures that say both words

    def related(self, word: int) -> frozenset[int]:
        """The words that mostly occur in the same captures as a word, including the word."""
        both, each = self.together[word], np.diag(self.together)
        near = (both >= RELATED * each[word]) | (both >= RELATED * np.maximum(each, 1.0))
        return frozenset(np.flatnonzero(near & (both > 0.0)).tolist()) | {word}


def judging_table(judge: MotionJudge, said: Said, n_words: int) -> JudgingTable:
    """Prepare a judge for the words of the captions."""
    if not set(judge.captures.tolist()) <= said.keys():
        judge = judge.only(said)
    targets = np.zeros((len(judge.captures), n_words))
    presence = np.zeros((len(said), n_words))
    for n, (capture, (words, n_actions)) in enumerate(said.items()):
        listed, own = sorted(words), judge.captures == capture
        targets[np.ix_(own, listed)] = 1.0 / np.sqrt(max(n_actions, 1))
        presence[n, listed] = float(own.any())
    mean = judge.weights @ targets / max(judge.weights.sum(), 1e-12)
    with one_blas_thread():
        coefficients = judge.inverse @ (targets - mean)
    return JudgingTable(judge, coefficients, mean, said, presence.T @ presence)


@dataclass(frozen=True, eq=False)
class WithoutSources:
    """The judge without some captures."""

    table: JudgingTable  # The judge with all captures
    coefficients: FloatArray  # (windows, words): a, 0 for the windows left out
    n_captures: FloatArray  # (words,): number of remaining captures whose captions have each word
    captures: frozenset[int]

    def scores(self, rows: FloatArray) -> FloatArray:
        """z of a motion, from the statistics of its windows: array (words,)."""
        kept = np.clip(self.table.mean, 1e-4, 0.999)
        with one_blas_thread():
            z = self.table.judge.likeness(rows) @ self.coefficients
        return np.asarray(z.mean(axis=0) / (kept * (1.0 - kept)) ** SPREAD_POWER)

    def cues(self, scores: FloatArray, word: int) -> FloatArray:
        """The two cues of a word: array (2,)."""
        others = self.n_captures >= 1.0
        others[list(self.table.related(word))] = False
        best = float(scores[others].max()) if others.any() else 0.0
        return np.array([scores[word], scores[word] - best])

    def probability(self, scores: FloatArray, word: int) -> float | None:
        """Probability that a motion shows a word; None if no remaining capture has the word."""
        sure = self.table.judge.certainty
        if self.n_captures[word] < 1.0 or sure is None:
            return None
        return float(probability(sure.log_odds(self.cues(scores, word))))

    def likeliest(self, scores: FloatArray, n_words: int) -> list[tuple[int, float]]:
        """The words of the largest z, the most probable first."""
        known = np.flatnonzero(self.n_captures >= 1.0)
        order = known[np.argsort(-scores[known], kind="stable")][:n_words]
        likely = [(int(w), self.probability(scores, int(w))) for w in order]
        told = [(word, p) for word, p in likely if p is not None]
        return sorted(told, key=lambda pair: -pair[1])


def judge_without(table: JudgingTable, out: Collection[int]) -> WithoutSources | None:
    """The judge without some captures; None if no described capture is left."""
    owners, inverse = table.judge.captures, table.judge.inverse
    gone = np.flatnonzero(np.isin(owners, list(out)))
    if len(gone) == len(owners):
        return None
    coefficients = table.coefficients.copy()
    with one_blas_thread():
        shift = np.linalg.solve(inverse[np.ix_(gone, gone)], coefficients[gone])
        coefficients -= inverse[:, gone] @ shift
    coefficients[gone] = 0.0
    n_captures = np.diag(table.together).copy()
    inside = set(owners[gone].tolist())
    for capture in inside:
        n_captures[sorted(table.said[capture][0])] -= 1.0
    remaining = frozenset(owners.tolist()) - inside
    return WithoutSources(table, coefficients, n_captures, remaining)


def fit_judge(
    windows: Mapping[int, FloatArray],
    said: Said,
    n_words: int,
    performers: Mapping[int, str],
    rng: np.random.Generator,
) -> MotionJudge:
    """Fit the judge and its calibration; of `windows` one capture at a time is looked at."""
    known = [capture for capture in windows if capture in said]
    sums = [(len(rows), rows.sum(axis=0)) for rows in map(windows.__getitem__, known)]
    n_windows = sum(n for n, _ in sums)
    mean = sum(total for _, total in sums) / n_windows
    spread = np.sqrt(sum(((windows[c] - mean) ** 2).sum(axis=0) for c in known) / n_windows)
    spread = np.maximum(spread, 1e-6 + 0.01 * spread.max())
    count = Counter(word for capture in known for word in said[capture][0])
    rarest = {c: min((count[word] for word in said[c][0]), default=len(said)) for c in known}
    most = int(np.clip(MOST_ROWS // len(known), 1, MOST_WINDOWS))
    chosen = sorted(sorted(known, key=rarest.__getitem__)[:MOST_ROWS])
    kept = {c: _spread_out(windows[c], most) for c in chosen}
    captures = np.repeat(np.array(list(kept), dtype=np.int64), [len(w) for w in kept.values()])
    judge = MotionJudge(mean, spread, np.concatenate(list(kept.values())), captures)
    table = judging_table(judge, {c: said[c] for c in kept}, n_words)
    pairs = _draw_pairs(table, performers, rng)
    if len(pairs) < LEAST_PAIRS:
        return judge
    cues, right = _compare(table, windows, pairs, rng)
    weights, constant = fit_probability(cues, right)
    return replace(judge, certainty=Certainty(weights, constant, float("nan")))


def _spread_out(rows: FloatArray, most: int) -> FloatArray:
    """At most so many of the windows of a capture, at equal distances from its first on."""
    chosen = np.linspace(0, len(rows) - 1, min(len(rows), most))
    return rows[chosen.round().astype(np.int64)]


def _draw_pairs(
    table: JudgingTable, performers: Mapping[int, str], rng: np.random.Generator
) -> list[tuple[int, int, int]]:
    """Pairs of captures for the calibration: (word, capture with the word, capture without it).

    The first capture shows one action if there are enough of these; otherwise it may be any.
    """
    single = frozenset(c for c in table.said if table.said[c][1] <= 1)
    pairs = _pairs_of(table, performers, rng, single)
    if len(pairs) < LEAST_PAIRS:
        pairs = _pairs_of(table, performers, rng, frozenset(table.said))
    chosen = np.sort(rng.permutation(len(pairs))[:MOST_PAIRS])
    return [pairs[i] for i in chosen]


def _pairs_of(
    table: JudgingTable,
    performers: Mapping[int, str],
    rng: np.random.Generator,
    first: frozenset[int],
) -> list[tuple[int, int, int]]:
    """Pairs of which the first capture is one of ``first``."""
    judge = table.judge
    evidence = judge.likeness(judge.rows) @ table.coefficients
    scores = {c: evidence[judge.captures == c].mean(axis=0) for c in table.said}
    pairs = []
    for word in np.flatnonzero(np.diag(table.together) >= 2.0).tolist():
        related = table.related(word)
        of_word: list[tuple[int, int, int]] = []
        for capture in sorted(c for c in first if word in table.said[c][0]):
            others = [
                c
                for c in sorted(table.said)
                if performers[c] == performers[capture] and not table.said[c][0] & related
            ]
            if not others:
                continue
            if rng.random() < 0.5:
                others.sort(key=lambda c: -scores[c][word])
                others = others[: max(3, len(others) // 3)]
            drawn = rng.permutation(len(others))[:OTHERS]
            of_word += [(word, capture, others[int(n)]) for n in drawn]
        kept = np.sort(rng.permutation(len(of_word))[:PAIRS_OF_A_WORD])
        pairs += [of_word[i] for i in kept]
    return pairs


def _compare(
    table: JudgingTable,
    windows: Mapping[int, FloatArray],
    pairs: Sequence[tuple[int, int, int]],
    rng: np.random.Generator,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Cues of a part of each capture of every pair, and whether the capture has the word."""
    cues, right = [], []
    for word, says, says_not in pairs:
        left = judge_without(table, (says, says_not))
        if left is None or left.n_captures[word] < 1.0:
            continue
        for capture, is_right in ((says, True), (says_not, False)):
            part = _part(windows[capture], rng)
            cues.append(left.cues(left.scores(part), word))
            right.append(is_right)
    return np.array(cues).reshape(-1, 2), np.array(right, dtype=bool)


def _part(rows: FloatArray, rng: np.random.Generator) -> FloatArray:
    """One to ``PARTS`` successive windows of a capture."""
    n_rows = min(int(rng.integers(1, PARTS + 1)), len(rows))
    start = int(rng.integers(len(rows) - n_rows + 1))
    return rows[start : start + n_rows]
