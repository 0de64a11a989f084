"""Resemblance of intervals: similarity of their motion, and of the words it suggests.

Notation: v the vector of an interval (:mod:`motiondb.meaning.score_vectors`), e(v) the evidence for
every word by the word map (:mod:`motiondb.meaning.word_map`), v' the vector without posture and
travel, p(v) a second opinion on the words. The resemblance of two intervals is

    MEANING_SHARE cos(e(v), e(w)) + (1 - MEANING_SHARE) cos(v', w')

where words were learned, and cos(v, w) otherwise. When captures are ranked, the first term is

    (MEANING_SHARE - POOLED_SHARE) cos(e(v), e(w)) + POOLED_SHARE cos(p(v), p(w)),

because two opinions that err on different captures rank better than either. Words of direction, of
manner and of parts of the body have the share ``MODIFIER_SHARE`` of the others in e and p: they
identify the action less often.

Captures are ranked by the mean of their resemblance to the example and of their mean resemblance to
the captures most similar to it (:func:`with_feedback`), weighted by the similarity of those. So two
performers of one action are found through a third.

**The second opinion** is linear in pooled statistics. x_t are the whitened features of frame t (D
dimensions), s the mean, the standard deviation and the 10th, 50th and 90th percentile of x over the
frames of an interval (5 D values), p the standardised s as a vector of length 1, t = y / |y| with
y_w = 1 where word w was written about the interval. The evidence for w is

    z_w = (p - mean p) . u_w,

by ridge regression of t - mean t on p - mean p. Spread and percentiles are not additive over
segments, and so not part of score vectors; they describe the range of a movement directly.

Source: Rocchio, Relevance feedback in information retrieval (1971), with the first answers taken as
right. Pooled statistics are the strongest simple method in ``docs/measured/quality.md`` ("Query by
example").
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from motiondb.language.vocabulary import MODIFIERS
from motiondb.meaning.regression import fit_ridge
from motiondb.meaning.score_vectors import times, unit
from motiondb.meaning.word_map import WordMap
from motiondb.records import Float32Array, FloatArray, IntArray

MEANING_SHARE = 0.8
"""Weight of the words in a resemblance, where words were learned.

Chosen among twelve settings by leaving performers out of the CMU training parts
(``docs/measured/quality.md``, "Query by example").
"""
POOLED_SHARE = 0.3
"""Part of that weight of the second opinion on the words. Chosen between .3 and .4 by leaving
performers out of the CMU training parts (1-NN accuracy and mAP there .667 and .643 without it,
.689 and .648 with .3, .688 and .651 with .4)."""
SECOND_LENGTH = math.sqrt(POOLED_SHARE)  # Of the second opinion in a row
MOVING_LENGTH = math.sqrt(1.0 - MEANING_SHARE)  # Of the movement in a row
ROUNDING = 1e-5  # More than rounding adds to a product
MODIFIER_SHARE = 0.5
"""Weight of words of direction, manner and parts of the body. Below
it, actions that differ by these words (raising the left or the right hand) are not distinguished.

Chosen between this and 1 in CMU training parts (docs/measured/quality.md, "Query by example")."""
FEEDBACK = 10
"""Number of captures that are assumed to be right answers, but at most one in ``FEWEST_OTHERS``.
Chosen among 0, 5, 10 and 20 in the CMU training parts."""
FEWEST_OTHERS = 5  # Smallest number of captures for each one that is assumed to be a right answer


@dataclass(frozen=True, eq=False)
class MeaningSpace:
    """Linear maps from an interval to the row whose dot products are resemblances."""

    # (columns, words): u of the word map, times the weights of the words
    weights: FloatArray | Float32Array
    # (words,): c of the word map, times the weights of the words
    offsets: FloatArray | Float32Array
    n_moving: int  # Number of the first columns of a vector that are neither posture nor travel
    pooled: PooledMap | None  # Second opinion on the words, its u times the weights of the words

    def rows(
        self, vectors: FloatArray | Float32Array, statistics: FloatArray | None = None
    ) -> FloatArray | Float32Array:
        """Rows whose dot products are resemblances: array (..., columns of a row).

        Shapes: `vectors` (..., columns); `statistics` (..., 5 D), None without a second opinion.
        """
        seen: NDArray[Any] = vectors.astype(self.weights.dtype, copy=False)
        said, rest = self.said_rows(times(seen, self.weights)), self.rest_rows(seen, statistics)
        return np.concatenate([said, rest], axis=-1)

    def said_rows(self, evidence: FloatArray | Float32Array) -> FloatArray | Float32Array:
        """The first columns of rows: words, by their evidence (..., words) without offsets."""
        share = MEANING_SHARE - (0.0 if self.pooled is None else POOLED_SHARE)
        return unit(evidence + self.offsets) * math.sqrt(share)

    def rest_rows(
        self, vectors: FloatArray | Float32Array, statistics: FloatArray | None = None
    ) -> FloatArray | Float32Array:
        """The other columns of rows: movement and the second opinion; see :meth:`rows`."""
        moving = unit(vectors[..., : self.n_moving].astype(self.weights.dtype, copy=False))
        moving *= MOVING_LENGTH
        if self.pooled is None:
            return moving
        assert statistics is not None
        evidence = self.pooled.evidence(statistics.astype(self.weights.dtype, copy=False))
        return np.concatenate([moving, unit(evidence) * SECOND_LENGTH], axis=-1)

    def most_alike(
        self,
        said: FloatArray | Float32Array,
        moving: FloatArray,
        example: FloatArray | Float32Array,
        asked: FloatArray | Float32Array,
    ) -> FloatArray:
        """The largest product that rows can have with another row: array (n,).

        Let r be the movement of a row, x that of the example, of the same length, p their product,
        and a x + y that of the other row, y orthogonal to x. Its product with r is at most
        a p + |y| |r - p x / |x|^2|, and that of second opinions at most that of their lengths.

        Shapes: `said` (n, words): the words of the rows; `moving` (n,): p; `example`, `asked`
        (columns of a row,): the row of the example, and the other row.
        """
        words, opinion = said.shape[1], said.shape[1] + self.n_moving
        x, other = example[words:opinion], asked[words:opinion]
        square = MOVING_LENGTH**2
        a = float(other @ x) / square
        y = float(np.linalg.norm(other - a * x))
        aside = np.sqrt(np.maximum(square - moving**2 / square, 0.0) + ROUNDING)
        seconds = SECOND_LENGTH * float(np.linalg.norm(asked[opinion:]))
        return said @ asked[:words] + (a * moving + y * aside + seconds + ROUNDING)


def meaning_space(
    words: WordMap,
    n_posture_and_travel: int = 0,
    emphasis: FloatArray | None = None,
    pooled: PooledMap | None = None,
    dtype: DTypeLike = np.float32,
) -> MeaningSpace:
    """Prepare the rows of many intervals.

    Shapes: `emphasis` (words,).

    `dtype`: Precision. Single precision halves the memory that a comparison reads, which is most of
    its time; resemblances then differ from those in double precision by some 1e-7, and by more for
    vectors whose evidence for every word is nearly 0.
    """
    weights = np.ones(len(words.offsets)) if emphasis is None else emphasis
    second = None
    if pooled is not None:
        arrays = {**vars(pooled), "weights": pooled.weights * weights}
        second = PooledMap(**{name: array.astype(dtype) for name, array in arrays.items()})
    return MeaningSpace(
        (words.weights * weights).astype(dtype),
        (words.offsets * weights).astype(dtype),
        len(words.weights) - n_posture_and_travel,
        second,
    )


def resemblance(
    vector: FloatArray,
    vectors: FloatArray,
    words: WordMap | None = None,
    *,
    n_posture_and_travel: int = 0,
    emphasis: FloatArray | None = None,
) -> FloatArray:
    """Similarity of intervals to one interval: array (n,), 1 for the same.

    Shapes: `vector` (columns,); `vectors` (n, columns); `emphasis` (words,).
    """
    if words is None:
        return np.asarray(vectors @ vector)
    space = meaning_space(words, n_posture_and_travel, emphasis, dtype=np.float64)
    return np.asarray(np.einsum("ij,j->i", space.rows(vectors), space.rows(vector)))


def with_feedback(
    alike: FloatArray | Float32Array, rows: FloatArray | Float32Array
) -> FloatArray | Float32Array:
    """Mean of the resemblance to the example and to the captures most like it: array (n,).

    Shapes: `alike` (n,); `rows` (n, columns).

    >>> rows = np.array([[1.0, 0.0], [0.6, 0.8], [0.0, 1.0]])
    >>> with_feedback(np.array([0.9, 0.5, 0.0]), rows).round(2).tolist()
    [0.95, 0.55, 0.0]
    """
    best, weights = right_answers(alike)
    if not len(best):
        return alike
    together = rows @ (weights @ rows[best])
    together *= 0.5
    together += 0.5 * alike
    return np.asarray(together)


def right_answers(alike: FloatArray | Float32Array) -> tuple[IntArray, FloatArray | Float32Array]:
    """Captures that are assumed to be right answers, and their weights, of sum 1; or none.

    Shapes: `alike` (captures,): their resemblance to the example, at least that of the
    ``FEEDBACK`` largest; -inf of others.
    """
    n = max(1, min(FEEDBACK, len(alike) // FEWEST_OTHERS))
    best = np.argsort(-alike, kind="stable")[: n if len(alike) > n else 0]
    weights = np.maximum(alike[best], 0.0)
    total = float(weights.sum())
    return (best, weights / total) if total > 0.0 else (best[:0], weights[:0])


def emphasis_of(names: Sequence[str]) -> FloatArray:
    """Weights of words in a resemblance: array (words,).

    >>> emphasis_of(["walk", "left"]).tolist()
    [1.0, 0.5]
    """
    return np.array([MODIFIER_SHARE if name in MODIFIERS else 1.0 for name in names])


POOLED_RIDGE = 0.3
"""Ridge of the regression. Chosen between .1 and .3 by leaving performers out of the CMU training
parts (docs/measured/quality.md, "Query by example"): 1-NN accuracy .692 with it, .686 with .1."""
QUANTILES = (0.1, 0.5, 0.9)  # Quantiles of the features over the frames of an interval
BLOCK = 16
"""Intervals of one length whose statistics are computed together. Between 10 and 30 the time for an
interval was a quarter of that of one alone (30 frames), a third (100 frames); with 300 it was more,
since they do not fit the processor's cache."""


@dataclass(frozen=True, eq=False)
class PooledMap:
    """A linear map from pooled statistics to words."""

    centre: FloatArray  # (5 D,): mean of the statistics over the described intervals
    spread: FloatArray  # (5 D,): their standard deviation, at least a hundredth of the largest
    mean: FloatArray  # (5 D,): mean of p
    weights: FloatArray  # (5 D, words): u

    def evidence(self, statistics: FloatArray) -> FloatArray:
        """Evidence z for every word: array (..., words), from `statistics` (..., 5 D)."""
        rows = unit((statistics - self.centre) / self.spread) - self.mean
        return times(rows, self.weights)


def pooled_statistics(frames: Float32Array | FloatArray) -> FloatArray:
    """Mean, standard deviation and quantiles of the features of intervals: array (..., 5 D).

    Quantiles are interpolated linearly between the values, as ``np.quantile`` does.

    Shapes: `frames` (..., frames, D).

    >>> pooled_statistics(np.array([[0.0], [1.0], [2.0]])).round(3).tolist()
    [1.0, 0.816, 0.2, 1.0, 1.8]
    """
    ordered = np.sort(
        np.ascontiguousarray(np.swapaxes(frames, -1, -2)), axis=-1
    )  # (..., D, frames)
    last = ordered.shape[-1] - 1
    places = np.array(QUANTILES) * last
    low = places.astype(np.int64)
    share = places - low
    below = ordered[..., low].astype(np.float64)
    above = ordered[..., np.minimum(low + 1, last)].astype(np.float64)
    quantiles = np.swapaxes((1.0 - share) * below + share * above, -1, -2)
    mean, spread = ordered.mean(axis=-1, dtype=np.float64), ordered.std(axis=-1, dtype=np.float64)
    return np.concatenate([mean, spread, quantiles.reshape(*mean.shape[:-1], -1)], axis=-1)


def statistics_of_intervals(intervals: Sequence[Float32Array]) -> FloatArray:
    """Pooled statistics of intervals of any lengths: array (intervals, 5 D).

    Intervals of one length are computed together, ``BLOCK`` at a time.

    Shapes: `intervals` each (frames, D).
    """
    lengths = np.array([len(frames) for frames in intervals])
    order = np.argsort(lengths, kind="stable")
    changes = np.flatnonzero(np.diff(lengths[order])) + 1
    statistics = np.empty((len(intervals), (2 + len(QUANTILES)) * intervals[0].shape[1]))
    for alike in np.split(order, changes):
        for first in range(0, len(alike), BLOCK):
            block = alike[first : first + BLOCK]
            statistics[block] = pooled_statistics(np.stack([intervals[n] for n in block]))
    return statistics


def fit_pooled_map(statistics: FloatArray, presence: NDArray[np.bool_]) -> PooledMap:
    """Fit the map to the described intervals; `statistics` (n, 5 D); `presence` (n, words)."""
    centre, spread = statistics.mean(axis=0), statistics.std(axis=0)
    spread = np.maximum(spread, 1e-6 + 0.01 * spread.max(initial=0.0))
    rows = unit((statistics - centre) / spread)
    weights, _ = fit_ridge(rows, unit(presence.astype(np.float64)), POOLED_RIDGE)
    return PooledMap(centre, spread, rows.mean(axis=0), weights)
