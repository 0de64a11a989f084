"""A linear map from pooled statistics of an interval to its caption: a second opinion on its words.

Notation: x_t the whitened features of frame t (D dimensions), s the mean, the standard deviation
and the 10th, 50th and 90th percentile of x over the frames of an interval (5 D values), p the
standardised s as a vector of length 1, t = y / |y| with y_w = 1 where word w was written about the
interval. The evidence of the second opinion for w is

    z_w = (p - mean p) . u_w,

by ridge regression of t - mean t on p - mean p over the described intervals. Unlike the columns of
:mod:`motiondb.meaning.movement`, spread and percentiles are not additive over segments, and
so are not part of the score vectors. They describe the range of a movement directly. The map takes
part in the resemblance of captures to an example
(:mod:`motiondb.meaning.resemblance`). It is fitted by ``learn`` and does not change until
the next ``learn``.

Source: pooled statistics are the strongest simple method in ``docs/measured/quality.md`` ("Query by
example").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.ridge import fit_ridge
from motiondb.meaning.score_vectors import unit
from motiondb.records import Float32Array, FloatArray

RIDGE = 0.3
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
        """Evidence z for every word: array (n, words), from `statistics` (n, 5 D)."""
        rows = unit((statistics - self.centre) / self.spread)
        return np.asarray((rows - self.mean) @ self.weights)


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
    weights, _ = fit_ridge(rows, unit(presence.astype(np.float64)), RIDGE)
    return PooledMap(centre, spread, rows.mean(axis=0), weights)
