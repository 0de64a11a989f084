"""How far an activity lasts: the interval of a take that goes on as an example does.

Warping finds where a take repeats an example frame by frame; but one performer twists four times
and another ten, and what is looked for is all of it. The context of a frame is the mean and spread
of its features over 2.6 s, on whitened principal axes of all captures' contexts. With d_t the mean
distance of a take's frame to the five nearest contexts of the example, the interval [a, b) is the
one that maximises

    sum_{t in [a, b)} (theta - d_t),    theta = near + SHARE (median of d - near),

near the least mean of d over two seconds: found exactly in one pass (Kadane 1984, with a least
length by prefix sums). A take that shows the activity throughout has no other level to stand out
from; the whole of it is the answer then only if the sum says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import Float32Array, FloatArray
from motiondb.symbols.segmentation import context

WINDOW = 39
SPREAD_WEIGHT = 1.5
N_AXES = 24
THINNED = 5
"""Every fifth frame takes part in the choice of axes."""
SHARE = 0.35
NEAREST = 5
SHORTEST = 22
"""Feature frames (1.5 s) that an activity lasts at least."""
NEAR_FRAMES = 30
LEAST_EXAMPLE = 30
"""Feature frames (2 s) of the shortest example that has a context of its own."""
LONG = 1.5
"""A take is asked for whole activities where it is this many times as long as the example."""


@dataclass(frozen=True, eq=False)
class ContextSpace:
    """features : array (n,), mean of the features; mean : array (2 n,), of their contexts;
    projection : array (2 n, axes), whitening."""

    features: FloatArray
    mean: FloatArray
    projection: FloatArray

    def view(self, features: FloatArray | Float32Array) -> FloatArray:
        """Contexts (frames, axes) of features (frames, n), 15 a second."""
        return (_contexts(features - self.features) - self.mean) @ self.projection


def fit_context_space(captures: Sequence[FloatArray | Float32Array]) -> ContextSpace:
    """Whitened principal axes of the contexts of all captures (features, 15 a second)."""
    total = sum(len(c) for c in captures)
    centre = sum(c.sum(axis=0, dtype=np.float64) for c in captures) / max(total, 1)
    rows = np.concatenate([_contexts(c - centre)[::THINNED] for c in captures])
    mean = rows.mean(axis=0)
    values, axes = np.linalg.eigh((rows - mean).T @ (rows - mean) / len(rows))
    kept = np.argsort(-values)[:N_AXES]
    spread = np.sqrt(np.maximum(values[kept], 1e-6 * values.max() + 1e-12))
    return ContextSpace(np.asarray(centre), mean, axes[:, kept] / spread)


def extent(example: FloatArray, take: FloatArray) -> tuple[float, int, int]:
    """The interval of a take that goes on as the example does.

    Parameters
    ----------
    example : array
        Contexts (frames, axes) from :meth:`ContextSpace.view`.
    take : array
        Contexts (frames, axes) from :meth:`ContextSpace.view`.

    Returns
    -------
    Mean distance to the example inside, first and last + 1 frame. A take shorter than an activity
    is one.
    """
    margin = min(WINDOW // 4, (len(example) - 1) // 2)
    inner = example[margin : len(example) - margin]
    squares = np.sum(take**2, axis=1)[:, None] + np.sum(inner**2, axis=1) - 2.0 * (take @ inner.T)
    nearest = min(NEAREST, len(inner))
    closest = np.partition(np.maximum(squares, 0.0), nearest - 1, axis=1)[:, :nearest]
    distance = np.sqrt(closest).mean(axis=1)
    start, end = longest_gain(_threshold(distance) - distance, SHORTEST)
    return float(distance[start:end].mean()), start, end


def longest_gain(gains: FloatArray, shortest: int) -> tuple[int, int]:
    """The interval of largest sum among those of at least ``shortest`` frames (ties: the first).

    >>> longest_gain(np.array([-1.0, 2.0, -0.5, 2.0, -3.0, 3.0]), 2)
    (1, 4)
    """
    n_frames = len(gains)
    if n_frames <= shortest:
        return 0, n_frames
    sums = np.concatenate([[0.0], np.cumsum(gains)])
    lowest, before = np.minimum.accumulate(sums), np.zeros(n_frames + 1, dtype=np.int64)
    fresh = np.flatnonzero(np.diff(lowest, prepend=np.inf) < 0)
    before[fresh] = fresh
    before = np.maximum.accumulate(before)
    ends = np.arange(shortest, n_frames + 1)
    best = int(ends[np.argmax(sums[ends] - lowest[ends - shortest])])
    return int(before[best - shortest]), best


def _threshold(distance: FloatArray) -> float:
    length = min(NEAR_FRAMES, len(distance))
    near = np.convolve(distance, np.full(length, 1.0 / length), "valid").min()
    return float(near + SHARE * (np.median(distance) - near))


def _contexts(features: FloatArray | Float32Array) -> FloatArray:
    values = context(np.asarray(features, dtype=np.float64), WINDOW)
    values[:, features.shape[1] :] *= SPREAD_WEIGHT
    return values
