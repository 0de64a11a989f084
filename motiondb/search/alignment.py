"""Alignment of two motions by dynamic time warping, and how far their poses are apart.

The distance of two poses is the mean over the joints of their distance in metres, relative to the
pelvis and the heading. The path of least mean cost goes from the first to the last pose of both,
in steps of one pose of either or of both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray

MOST_POSES = 1500
"""Poses of a motion that are aligned; of longer ones every second, third, ... is taken."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """Which poses of two motions correspond."""

    path: IntArray  # (steps, 2): numbers of poses of both motions, neither falls
    distances: FloatArray  # (steps,): metres
    joint_distances: FloatArray  # (joints,): mean over the steps, metres
    costs: FloatArray  # (poses of the first, poses of the second): metres


def align(first: Float32Array, second: Float32Array) -> Alignment:
    """Align poses (poses, 3 * joints), metres."""
    a, b = (p.reshape(len(p), -1, 3).astype(float) for p in (first, second))
    costs = np.stack([np.linalg.norm(pose - b, axis=2).mean(axis=1) for pose in a])
    path = _cheapest_path(costs)
    apart = np.linalg.norm(a[path[:, 0]] - b[path[:, 1]], axis=2)
    return Alignment(path, apart.mean(axis=1), apart.mean(axis=0), costs)


def _cheapest_path(costs: FloatArray) -> IntArray:
    """The path of least cost through a matrix from corner to corner, by antidiagonals.

    A diagonal step costs its pose twice, so that paths of all kinds are as long.

    >>> _cheapest_path(np.array([[0.0, 9.0, 9.0], [9.0, 0.0, 0.0]])).tolist()
    [[0, 0], [1, 1], [1, 2]]
    """
    n, m = costs.shape
    total = np.full((n + 1, m + 1), np.inf)
    total[0, 0] = 0.0
    for diagonal in range(2, n + m + 1):
        i = np.arange(max(1, diagonal - m), min(n, diagonal - 1) + 1)
        j = diagonal - i
        cost = costs[i - 1, j - 1]
        ways = [total[i - 1, j - 1] + 2.0 * cost, total[i - 1, j] + cost, total[i, j - 1] + cost]
        total[i, j] = np.min(ways, axis=0)
    i, j = n, m
    path = [(n - 1, m - 1)]
    while (i, j) != (1, 1):
        cost = costs[i - 1, j - 1]
        ways = [
            (total[i - 1, j - 1] + 2.0 * cost, (i - 1, j - 1)),
            (total[i - 1, j] + cost, (i - 1, j)),
            (total[i, j - 1] + cost, (i, j - 1)),
        ]
        i, j = min(ways, key=lambda way: way[0])[1]
        path.append((i - 1, j - 1))
    return np.array(path[::-1], dtype=np.int64)
