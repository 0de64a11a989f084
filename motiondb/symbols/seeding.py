"""First groups of segments, before there are symbols: k-means on a description of the segments.

A segment is described by its mean features in each of its thirds, so that the same poses in another
order have another description.

Source: Arthur and Vassilvitskii, k-means++, 2007 (the start of k-means).
"""

from __future__ import annotations

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray


def describe_segments(frames: Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Mean features of every third of a segment: array (segments, 3 * dimensions).

    Shapes: `frames` (frames, dimensions); `starts`, `ends` (segments,).
    """
    sums = np.concatenate([np.zeros((1, frames.shape[1])), np.cumsum(frames, axis=0, dtype=float)])
    parts = []
    for third in range(3):
        low = starts + (ends - starts) * third // 3
        high = np.maximum(starts + (ends - starts) * (third + 1) // 3, low + 1)
        high = np.minimum(high, len(frames))
        parts.append((sums[high] - sums[low]) / (high - low)[:, None])
    return np.concatenate(parts, axis=1)


def seed_groups(descriptors: FloatArray, n_groups: int, rng: np.random.Generator) -> IntArray:
    """First groups by k-means (k-means++ start): array (segments,), no group empty.

    Shapes: `descriptors` (segments, values).
    """
    from sklearn.cluster import KMeans
    from threadpoolctl import threadpool_limits

    n_groups = min(n_groups, n_distinct(descriptors))
    if n_groups == 1:
        return np.zeros(len(descriptors), dtype=np.int64)
    seed = int(rng.integers(2**31))
    means = KMeans(n_groups, n_init=1, max_iter=30, random_state=seed)
    with threadpool_limits(1):  # sums of several threads differ in their last bits
        labels = means.fit_predict(descriptors)
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def n_distinct(descriptors: FloatArray) -> int:
    """Number of descriptors that differ by more than rounding errors.

    Shapes: `descriptors` (segments, values).

    >>> n_distinct(np.array([[1.0, 2.0], [1.0, 2.0 + 1e-9], [1.0, 3.0]]))
    2
    """
    return len(np.unique(descriptors.round(6), axis=0))
