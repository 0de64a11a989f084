"""First segmentation of a capture: a cost, and an exact search for its minimum.

Notation: x_t the context of frame t, the mean and the standard deviation of the features in a
window of 1.5 seconds around it, because a single frame does not show an activity; s_t the speed of
the pose at frame t. A segmentation 0 = c_0 < c_1 < ... < c_n = T costs

    sum_i [ sum_{t in [c_i, c_i+1)} |x_t - mean|^2 + penalty + rest * s(c_i) ]

so that the context is nearly constant within a segment and boundaries are placed where the body
moves least. Dynamic programming finds the exact minimum over segmentations with all lengths in
[shortest, longest], in O(T * longest * dimensions) by prefix sums.

Source: the least-squares cost of change-point detection (Truong, Oudre, Vayatis, 2020). Once there
are symbols, captures are segmented again by them (``acquisition``).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray, Segment
from motiondb.symbols.settings import SegmentationSettings


@njit(cache=True, nogil=True)
def context(features: FloatArray, window: int) -> FloatArray:
    """Mean and deviation in a centred window: array (frames, 2 * dimensions)."""
    n_frames, n_dims = features.shape
    sums, squares = np.zeros((2, n_frames + 1, n_dims))
    for t in range(n_frames):
        for d in range(n_dims):
            sums[t + 1, d] = sums[t, d] + features[t, d]
            squares[t + 1, d] = squares[t, d] + features[t, d] * features[t, d]
    values, scale = np.empty((n_frames, 2 * n_dims)), np.sqrt(n_dims)
    for t in range(n_frames):
        low, high = max(t - window // 2, 0), min(t + window // 2 + 1, n_frames)
        for d in range(n_dims):
            mean = (sums[high, d] - sums[low, d]) / (high - low)
            variance = (squares[high, d] - squares[low, d]) / (high - low) - mean * mean
            values[t, d] = mean / scale
            values[t, n_dims + d] = np.sqrt(max(variance, 0.0)) / scale
    return values


@njit(cache=True, nogil=True)
def sums_before(frames: FloatArray | Float32Array, places: IntArray) -> FloatArray:
    """Sums of all frames before some places, which rise: array (places, dimensions)."""
    sums, total, n = np.empty((len(places), frames.shape[1])), np.zeros(frames.shape[1]), 0
    for t in range(len(frames) + 1):
        if n == len(places):
            break
        if places[n] == t:
            sums[n] = total
            n += 1
        if t < len(frames):
            for d in range(frames.shape[1]):
                total[d] += frames[t, d]
    return sums


def pose_speed(features: FloatArray) -> FloatArray:
    """Speed of the features relative to the capture's mean speed: array (frames,)."""
    if len(features) < 2:
        return np.zeros(len(features))
    speed = np.linalg.norm(np.gradient(features, axis=0), axis=1)
    return speed / max(float(speed.mean()), 1e-12)


def segment(features: FloatArray, settings: SegmentationSettings | None = None) -> list[Segment]:
    """Segmentation of least cost of one capture; `features` (frames, dimensions)."""
    settings = settings or SegmentationSettings()
    n_frames = len(features)
    if n_frames == 0:
        return []
    if n_frames < 2 * settings.shortest:
        return [Segment(0, n_frames)]
    cuts = optimal_cuts(
        context(np.asarray(features, dtype=np.float64), settings.window),
        settings.penalty + settings.rest * pose_speed(features),
        settings.shortest,
        settings.longest,
    )
    return [Segment(int(a), int(b)) for a, b in pairwise(cuts)]


def optimal_cuts(
    values: FloatArray, cut_costs: FloatArray, shortest: int, longest: int
) -> IntArray:
    """Boundaries of least cost; ``longest`` is at least 2 ``shortest`` - 1, so all is tiled."""
    sums = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    squares = np.concatenate([[0.0], np.cumsum(np.sum(values**2, axis=1))])
    return _cut(sums, squares, cut_costs, shortest, max(longest, 2 * shortest - 1))


@njit(cache=True, nogil=True)
def _cut(
    sums: FloatArray, squares: FloatArray, cut_costs: FloatArray, shortest: int, longest: int
) -> IntArray:
    """Boundaries of least cost from prefix sums of the values and of their squares."""
    n_frames = len(squares) - 1
    best = np.full(n_frames + 1, 1e300)
    before = np.zeros(n_frames + 1, np.int64)
    best[0] = 0.0
    for end in range(shortest, n_frames + 1):
        for start in range(max(0, end - longest), end - shortest + 1):
            if best[start] >= 1e300:
                continue
            residual = squares[end] - squares[start]
            for d in range(sums.shape[1]):
                total = sums[end, d] - sums[start, d]
                residual -= total * total / (end - start)
            cost = best[start] + cut_costs[start] + residual
            if cost < best[end]:
                best[end] = cost
                before[end] = start
    cuts = [n_frames]
    while cuts[-1] > 0:
        cuts.append(before[cuts[-1]])
    return np.array(cuts[::-1])
