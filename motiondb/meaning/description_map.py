"""A kernel map from score vectors to the words that are told of a motion.

Notation: v the score vector of an interval, of length 1; t = y / |y| with y_w = 1 where word w was
written about the interval; p(i) the performer of interval i, n_p the number of a performer's
described intervals. The predicted caption is

    f(v) = sum over j of a_j k(v, v_j) + b,    k(v, v') = v . v' + BETA exp((v . v' - 1) / TAU),

by kernel ridge regression: it minimises sum over i of omega_i |t_i - f(v_i)|^2 + RIDGE |f|^2. The
second term of the kernel lets captions of movements that are nearly the same speak for themselves,
while the ridge of the linear term can be large. omega_i = n_p(i)^(-1/2), scaled to a mean of 1, so
that a performer with many captures does not outweigh the others. Words are told in the order of

    s_w = f_w(v) + ALPHA log e_w,

where e_w is the effective number of performers of word w: the exponential of the entropy of the
performers' shares in the intervals with w. A word of one performer shows the performer as much as
the word.

One logistic map for all words makes probabilities, P(w) = sigmoid(a s_w + b). It is fitted to
predictions without the performer and to predictions with other captures of the performer, half and
half. Nearly all of these are near 0 and decide its slope, so that the probabilities agree with the
truth on average, but less well in between: on the sample data, with performers left out, .32 of the
words told with .14 are true, .67 of those with .85 and .92 of those with .98. Fitted to the ten
likeliest words of each interval, .86 of those told with .85 were true, but the expected calibration
error over all words rose from .006 to .035.

Where there are more than MOST_CENTRES intervals, f is restricted to the span of the kernels at that
many of them, and the regression still counts all intervals.

Source: Williams and Seeger (2001) for Nystroem's approximation; ``docs/measured/quality.md``
("Motion to words") compares the map with others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.counting import Described, known_only, training_rows
from motiondb.meaning.regression import calibrate, fit_ridge, probability, shared_words
from motiondb.meaning.score_vectors import ScoreSpace, unit
from motiondb.records import FloatArray, IntArray, SegmentTable
from motiondb.symbols.hmm_jobs import one_blas_thread

RIDGE = 0.2
"""Ridge of the regression. Chosen from 36 settings, with BETA, TAU and ALPHA, by leaving performers
and tenths of the captures out of the CMU training parts ("Motion to words" in
``docs/measured/quality.md``)."""
BETA = 0.3  # Weight of the local term of the kernel. Chosen with RIDGE
TAU = 0.2  # Width of the local term, a difference of cosines. Chosen with RIDGE
ALPHA = 0.03  # Weight of the effective number of performers. Chosen with RIDGE
MOST_CENTRES = 1000  # Largest number of kernels. Bounds the time of fitting;
FEW_CENTRES = 500  # Number below which a general solver is as quick as SciPy's with its import
MOST_PARTS = 20
"""Largest number of parts of whole performers that the calibration leaves out. Bounds its time;"""
MANY, FEW_PARTS = 1000, 5
"""Number of intervals from which the calibration leaves out fifths, of performers and of intervals,
in place of twentieths and tenths: thirty maps of many hours took a twentieth of learning."""
AT_ONCE = 512  # Intervals whose kernels are computed together: of hours all would be large
JITTER = 1e-8
"""Added to the diagonal of the kernel matrix, which is singular where intervals repeat."""


@dataclass(frozen=True, eq=False)
class DescriptionMap:
    """A kernel map from score vectors to words."""

    centres: FloatArray  # (m, columns): score vectors v_j
    weights: FloatArray  # (m, words): a
    offsets: FloatArray  # (words,): b + ALPHA log e

    def scores(self, vectors: FloatArray) -> FloatArray:
        """Scores s of all words in intervals: array (n, words), from `vectors` (n, columns)."""
        with one_blas_thread():  # sums of several threads differ in their last bits
            return np.asarray(kernel(vectors, self.centres) @ self.weights + self.offsets)


def kernel(first: FloatArray, second: FloatArray) -> FloatArray:
    """k of the module's docstring, between all pairs: array (n, m).

    Shapes: `first` (n, columns); `second` (m, columns).

    >>> kernel(np.array([[1.0, 0.0]]), np.array([[1.0, 0.0], [0.0, 1.0]])).round(4).tolist()
    [[1.3, 0.002]]
    """
    cosine = first @ second.T
    return np.asarray(cosine + BETA * np.exp((cosine - 1.0) / TAU))


def effective_performers(presence: NDArray[np.bool_], groups: IntArray) -> FloatArray:
    """Effective number of performers of every word, e; 0.5 for a word of none: array (words,).

    Shapes: `presence` (n, words); `groups` (n,).

    >>> effective_performers(np.ones((4, 1), dtype=bool), np.array([0, 0, 1, 1])).tolist()
    [2.0]
    """
    numbers = np.unique(groups, return_inverse=True)[1]
    counts = np.zeros((int(numbers.max()) + 1, presence.shape[1]))
    np.add.at(counts, numbers, presence)
    shares = counts / np.maximum(counts.sum(axis=0), 1.0)
    entropy = -(shares * np.log(np.where(shares > 0.0, shares, 1.0))).sum(axis=0)
    return np.where(counts.any(axis=0), np.exp(entropy), 0.5)


def fit_description_map(
    vectors: FloatArray, presence: NDArray[np.bool_], groups: IntArray
) -> DescriptionMap:
    """Fit the map to the described intervals.

    Shapes: `vectors` (n, columns); `presence` (n, words); `groups` (n,).
    """
    numbers, sizes = np.unique(groups, return_inverse=True, return_counts=True)[1:]
    omega = np.asarray(sizes[numbers] ** -0.5, dtype=np.float64)
    omega /= omega.mean()
    target = unit(presence.astype(np.float64))
    centres = vectors[_centre_rows(numbers)]
    with one_blas_thread():  # sums of several threads differ in their last bits
        between = kernel(centres, centres) + JITTER * np.eye(len(centres))
        factor = np.asarray(np.linalg.cholesky(between), dtype=np.float64)
        columns = np.empty((len(vectors), len(centres)))
        for first in range(0, len(vectors), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            columns[some] = _solve(factor, kernel(centres, vectors[some])).T
        slopes, offsets = fit_ridge(columns, target, RIDGE, omega)
        weights = _solve(factor, slopes, transposed=True)
    prior = ALPHA * np.log(effective_performers(presence, groups))
    return DescriptionMap(centres, weights, offsets + prior)


def score_probabilities(scores: FloatArray, calibration: FloatArray) -> FloatArray:
    """Probabilities of words from their scores: array (n, words).

    Shapes: `scores` (n, words); `calibration` (2,).

    >>> score_probabilities(np.array([[0.5, 0.0]]), np.array([2.0, -1.0])).round(4).tolist()
    [[0.5, 0.2689]]
    """
    return probability(calibration[0] * scores + calibration[1])


def _solve(factor: FloatArray, right: FloatArray, transposed: bool = False) -> FloatArray:
    """Solve a lower triangular system, or that of its transpose; `right` (n, columns)."""
    if len(factor) < FEW_CENTRES:  # to import SciPy takes longer
        return np.asarray(np.linalg.solve(factor.T if transposed else factor, right))
    from scipy.linalg import solve_triangular

    return np.asarray(solve_triangular(factor, right, lower=True, trans="T" if transposed else "N"))


def fit_description_calibration(
    vectors: FloatArray, presence: NDArray[np.bool_], groups: IntArray
) -> FloatArray:
    """Calibration of the scores of words, a and b of the module's docstring: array (2,).

    With one performer, fifths of the intervals are left out in place of performers.

    Shapes: `vectors` (n, columns); `presence` (n, words); `groups` (n,).
    """
    among = np.unique(groups, return_inverse=True)[1]
    if not among.any():  # the map itself keeps the one performer
        among = np.arange(len(vectors)) % 5
    shared = shared_words(presence, among)
    of_performers, of_all = (MOST_PARTS, 10) if len(vectors) < MANY else (FEW_PARTS, FEW_PARTS)
    scores = [
        _left_out(vectors, presence, groups, left)[:, shared]
        for left in (among % of_performers, np.arange(len(vectors)) % of_all)
    ]
    truth = np.concatenate([presence, presence])[:, shared].astype(np.float64)
    z = np.concatenate(scores)
    a, _, b = calibrate(z, np.zeros_like(z), truth)
    return np.array([a, b])


def _left_out(
    vectors: FloatArray, presence: NDArray[np.bool_], groups: IntArray, parts: IntArray
) -> FloatArray:
    """Scores of every interval by the map without its part: array (n, words)."""
    scores = np.zeros(presence.shape)
    for part in np.unique(parts):
        test = parts == part
        fitted = fit_description_map(vectors[~test], presence[~test], groups[~test])
        scores[test] = fitted.scores(vectors[test])
    return scores


def _centre_rows(numbers: IntArray) -> IntArray:
    """At most MOST_CENTRES rows, dealt out in rounds over the performers; ascending."""
    order = np.argsort(numbers, kind="stable")
    first = np.searchsorted(numbers[order], numbers[order])
    rounds = np.empty(len(numbers), dtype=np.int64)
    rounds[order] = np.arange(len(numbers)) - first
    chosen = np.lexsort([numbers, rounds])[:MOST_CENTRES]
    return np.sort(chosen)


def map_descriptions(
    table: SegmentTable,
    described: Sequence[Described],
    scores: ScoreSpace,
    number: Mapping[str, int],
    performers: Mapping[int, str],
) -> DescriptionMap | None:
    """Map from score vectors to words, from all described intervals; None if there are none."""
    known = known_only(list(described), number)
    if not known:
        return None
    vectors, presence, captures = training_rows(table, known, scores, number)
    groups = np.unique([performers[int(c)] for c in captures], return_inverse=True)[1]
    return fit_description_map(vectors, presence, groups)
