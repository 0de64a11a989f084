"""The words that a motion shows, by a judge that is independent of its generation.

**The judge** compares a motion with the captures as wholes, by statistics of windows of three
seconds. It uses neither symbols nor segments nor places, and never the captures that the motion was
made from. Notation:

    x       a window's means, standard deviations and quantiles (.1, .5, .9) of the whitened
            features, standardised, clipped, of length 1,
    g_w     1/sqrt(n) for the windows of a capture whose captions say word w among n actions, else 0
    m_w     mean of g_w over the windows,
    z_w     (x - mean x) . u_w / (m_w (1 - m_w))^(1/4), the mean over a motion's windows, where u_w
            is the ridge regression of g_w on x. Each window weighs 1/sqrt(windows of its capture).

Two cues give a calibrated probability that a motion shows w: z_w, and z_w less the largest z of
other words. Words that mostly occur in the same captions as w do not count among the others.

Source: ridge regression on pooled features is the strongest ordinary method of
``docs/measured/quality.md``.

**The calibration of the two cues** uses real captures in pairs: one whose captions contain the word
w, and one of the same performer whose captions contain neither w nor a word related to it. In half
of the pairs, the second is one of the captures most similar to those of w. Both are judged without
the two, each by one or two of its windows, because generated motion is as short. The probability
therefore assumes prior odds of one to one.

A part of a capture of several actions may not show w. The first of a pair is therefore a capture
whose captions name one action, unless there are too few of these. No word has more than
``PAIRS_OF_A_WORD`` pairs, so that walking and running alone do not determine the probability.

On 505 pairs of CMU captures, 61 words, with the performers left out of the calibration: area under
the curve .84, expected calibration error .04; probabilities of .12, .29, .50, .70 and .94 were
right .21, .22, .47, .72 and .95 of the time.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.counting import Described
from motiondb.meaning.regression import Certainty, Sums, fit_probability, probability, sum_rows
from motiondb.meaning.score_vectors import unit
from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.symbols.hmm_jobs import one_blas_thread

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
OTHERS = 3
"""Number of captures with which each capture is compared: more make the calibration more stable."""
PAIRS_OF_A_WORD = 30
"""Largest number of pairs of a word for the calibration: more take longer, and
words with many captures would outweigh the others."""
MOST_PAIRS = 3_000  # Largest number of pairs for the calibration: more take longer
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
    calibration: Certainty | None = None

    def only(self, captures: Collection[int]) -> MotionJudge:
        """Return the judge with the windows of some captures only."""
        kept = np.isin(self.captures, list(captures))
        rows, owners = self.rows[kept], self.captures[kept]
        return MotionJudge(self.mean, self.spread, rows, owners, self.calibration)

    def standardise(self, rows: FloatArray) -> FloatArray:
        """Vectors x of windows: array (windows, columns)."""
        return unit(np.clip((rows - self.mean) / self.spread, -CLIP, CLIP))


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
class JudgingTable:
    """The judge with the words of the current captions."""

    judge: MotionJudge
    vectors: FloatArray  # (windows, columns): vectors x of the windows of described captures
    targets: FloatArray  # (windows, words): g of these windows
    weights: FloatArray  # (windows,): their weights
    owners: IntArray  # (windows,): their captures
    said: Said  # Words and number of actions of every capture
    together: FloatArray  # (words, words): number of captures that say both words

    def sums(self, which: IntArray | slice = slice(None)) -> Sums:
        """Sums over some windows."""
        return sum_rows(self.vectors[which], self.targets[which], self.weights[which])

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
    slopes: FloatArray  # (columns, words): u
    shift: FloatArray  # (words,): mean x . u
    mean: FloatArray  # (words,): m
    n_captures: FloatArray  # (words,): number of remaining captures whose captions have each word
    captures: frozenset[int]

    def scores(self, rows: FloatArray) -> FloatArray:
        """z of a motion, from the statistics of its windows: array (words,)."""
        kept = np.clip(self.mean, 1e-4, 0.999)
        x = self.table.judge.standardise(rows)
        z = (x @ self.slopes - self.shift) / (kept * (1.0 - kept)) ** SPREAD_POWER
        return np.asarray(z.mean(axis=0))

    def cues(self, scores: FloatArray, word: int) -> FloatArray:
        """The two cues of a word: array (2,)."""
        others = self.n_captures >= 1.0
        others[list(self.table.related(word))] = False
        best = float(scores[others].max()) if others.any() else 0.0
        return np.array([scores[word], scores[word] - best])

    def probability(self, scores: FloatArray, word: int) -> float | None:
        """Probability that a motion shows a word; None if no remaining capture has the word."""
        sure = self.table.judge.calibration
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


def judge_without(
    table: JudgingTable, out: Collection[int], sums: Sums | None = None
) -> WithoutSources | None:
    """The judge without some captures; None if no described capture is left."""
    gone = np.flatnonzero(np.isin(table.owners, list(out)))
    if len(gone) == len(table.owners):
        return None
    left = (sums or table.sums()) - table.sums(gone)
    slopes, shift = left.solve(RIDGE)
    n_captures = np.diag(table.together).copy()
    inside = set(table.owners[gone].tolist())
    for capture in inside:
        n_captures[sorted(table.said[capture][0])] -= 1.0
    remaining = frozenset(table.owners.tolist()) - inside
    mean = left.targets / left.n
    return WithoutSources(table, slopes, shift, mean, n_captures, remaining)


def fit_judge(
    windows: Mapping[int, FloatArray],
    said: Said,
    n_words: int,
    performers: Mapping[int, str],
    rng: np.random.Generator,
) -> MotionJudge:
    """Fit the judge and its calibration."""
    rows = np.concatenate(list(windows.values()))
    captures = np.repeat(
        np.array(list(windows), dtype=np.int64), [len(w) for w in windows.values()]
    )
    spread = rows.std(axis=0)
    spread = np.maximum(spread, 1e-6 + 0.01 * spread.max())
    judge = MotionJudge(rows.mean(axis=0), spread, rows, captures)
    table = judging_table(judge, {c: said[c] for c in said if c in windows}, n_words)
    with one_blas_thread():  # many small systems
        pairs = _draw_pairs(table, performers, rng)
        if len(pairs) < LEAST_PAIRS:
            return judge
        cues, right = _compare(table, windows, pairs, rng)
    weights, constant = fit_probability(cues, right)
    sure = Certainty(weights, constant, float("nan"))
    return MotionJudge(judge.mean, judge.spread, rows, captures, sure)


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
    everything = judge_without(table, ())
    assert everything is not None  # a described capture has a window
    evidence = table.vectors @ everything.slopes
    scores = {c: evidence[table.owners == c].mean(axis=0) for c in table.said}
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
    sums = table.sums()
    cues, right = [], []
    for word, says, says_not in pairs:
        left = judge_without(table, (says, says_not), sums)
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
