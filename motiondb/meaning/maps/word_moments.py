"""Sufficient statistics of the word map: sums over captures from which a capture can be removed.

Notation of :mod:`motiondb.meaning.maps.word_map`: v the score vector of a described interval, y its
words. Ridge regression needs n, sum v, sum y, sum v v' and sum v y' only. The values of v are
rounded to multiples of 2^-16, so that their products are multiples of 2^-32 and every sum over up
to two million intervals is exact in floating point: adding a capture and removing it, in any order,
restores exactly the same sums. The rounding error (0.000008 of a vector of length 1) is far below
the difference between two captures of the same movement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.maps.word_map import WordMap, word_spreads
from motiondb.records import FloatArray

_GRAIN = 2.0**16  # vectors are rounded to multiples of its reciprocal, see the module


@dataclass(frozen=True, eq=False)
class CaptionMoments:
    """Sums over described intervals for :mod:`motiondb.meaning.maps.caption_map`."""

    words: FloatArray  # (words,): sum of t, the words of an interval as a vector of length 1
    cross: FloatArray  # (symbols, words): sum of v t'

    def __add__(self, other: CaptionMoments) -> CaptionMoments:
        return CaptionMoments(self.words + other.words, self.cross + other.cross)

    def __sub__(self, other: CaptionMoments) -> CaptionMoments:
        return CaptionMoments(self.words - other.words, self.cross - other.cross)


@dataclass(frozen=True, eq=False)
class WordMoments:
    """Sums over described intervals."""

    n: float
    vectors: FloatArray  # (symbols,): sum of v
    words: FloatArray  # (words,): sum of y
    gram: FloatArray  # (symbols, symbols): sum of v v'
    cross: FloatArray  # (symbols, words): sum of v y'
    # Sums for whole captions; None in databases of versions that did not keep them
    captions: CaptionMoments | None = None

    def __add__(self, other: WordMoments) -> WordMoments:
        captions, others = self.captions, other.captions
        return WordMoments(
            self.n + other.n,
            self.vectors + other.vectors,
            self.words + other.words,
            self.gram + other.gram,
            self.cross + other.cross,
            None if captions is None or others is None else captions + others,
        )

    def __sub__(self, other: WordMoments) -> WordMoments:
        captions, others = self.captions, other.captions
        return WordMoments(
            self.n - other.n,
            self.vectors - other.vectors,
            self.words - other.words,
            self.gram - other.gram,
            self.cross - other.cross,
            None if captions is None or others is None else captions - others,
        )


def word_moments(vectors: FloatArray, presence: NDArray[np.bool_]) -> WordMoments:
    """Compute the sums over some intervals.

    Shapes: `vectors` (n, symbols); `presence` (n, words).

    >>> m = word_moments(np.array([[0.6, 0.8]]), np.array([[True, False]]))
    >>> m.n, m.cross.round(3).tolist()
    (1.0, [[0.6, 0.0], [0.8, 0.0]])
    """
    v = np.round(np.asarray(vectors, dtype=np.float64) * _GRAIN) / _GRAIN
    y = presence.astype(np.float64)
    length = np.sqrt(np.maximum(y.sum(axis=1, keepdims=True), 1.0))
    t = np.round(y / length * _GRAIN) / _GRAIN
    return WordMoments(
        float(len(v)),
        v.sum(axis=0),
        y.sum(axis=0),
        v.T @ v,
        v.T @ y,
        CaptionMoments(t.sum(axis=0), v.T @ t),
    )


def solve_word_map(moments: WordMoments, ridge: float, calibration: FloatArray) -> WordMap:
    """Word map from sums, with a given ridge and calibration.

    From the sums of the intervals given to :func:`motiondb.meaning.maps.word_map.fit_word_map` it
    is the same map, up to rounding errors.

    Shapes: `calibration` (3,).
    """
    n = max(moments.n, 1.0)
    mean_v: FloatArray = moments.vectors / n
    mean_y: FloatArray = moments.words / n
    gram = moments.gram - n * np.outer(mean_v, mean_v) + ridge * np.eye(len(mean_v))
    target = moments.cross - n * np.outer(mean_v, mean_y)
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # sums of several threads differ in their last bits
        weights = np.linalg.solve(gram, target).astype(np.float64, copy=False)
    priors = np.clip(mean_y, 0.5 / n, 1.0 - 0.5 / n)
    spreads = word_spreads(priors)
    # one order of summation: a matrix product's last bits depend on the number of threads
    offsets = -np.einsum("i,ij->j", mean_v, weights, optimize=False)
    return WordMap(weights, offsets, priors, spreads, calibration, ridge=ridge)
