"""Cycles of a movement: its period, the best place to repeat it, and the pieces of a repetition.

Notation: x_t the pose at frame t (any vector whose squared length compares poses), T a number of
frames. A movement is *periodic* if some lag T has a small self-difference

    D(T) = mean_t |x_{t+T} - x_t|^2 / (2 sum_d var(x_d)),

which is about 1 for unrelated poses and 0 for an exact repetition. The period is the shortest lag
at a local minimum of D below ``PERIODIC``. A *loop* [a, b) is a part of the movement that can be
played again and again, because the poses and velocities at a and b are nearly the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray

PERIODIC = 0.35
"""Largest self-difference of a periodic movement. Walks of real captures have .05 to .2, single
jumps more than .6."""
SHORTEST_PERIOD, LONGEST_PERIOD = 12, 90
"""Shortest and longest period, frames (0.4 s and 3 s at 30 a second): faster cycles are
trembling."""
LEAST_OVERLAP = 0.3
"""Smallest overlap of a movement with itself, shifted by the lag, as a share of its length."""
LENGTH_WEIGHT = 0.15
"""Cost by which a loop of one second is worse than one of two, in the units of the poses' squared
distance. Longer loops are less monotonous."""


@dataclass(frozen=True)
class Loop:
    """A part [first, behind) that can be repeated."""

    first: int
    behind: int  # Last frame + 1
    cost: float  # Squared distance between the poses and velocities at both ends

    @property
    def length(self) -> int:
        """Number of frames."""
        return self.behind - self.first


def self_difference(poses: FloatArray, longest: int) -> FloatArray:
    """D(T) for the lags T = 0, 1, ..., longest: array (longest + 1,); `poses` (frames, values).

    >>> wave = np.sin(2 * np.pi * np.arange(40) / 10)[:, None]
    >>> self_difference(wave, 10).round(2)[[0, 5, 10]]
    array([0., 2., 0.])
    """
    spread = 2.0 * float(poses.var(axis=0).sum()) + 1e-12
    differences = np.zeros(longest + 1)
    for lag in range(1, longest + 1):
        differences[lag] = np.mean(np.sum((poses[lag:] - poses[:-lag]) ** 2, axis=1)) / spread
    return differences


def find_period(poses: FloatArray, periodic: float = PERIODIC) -> int | None:
    """The period of a movement in frames, None without one; `poses` (frames, values).

    >>> wave = np.sin(2 * np.pi * np.arange(80) / 20)[:, None]
    >>> find_period(wave), find_period(np.linspace(0, 1, 80)[:, None])
    (20, None)
    """
    longest = min(LONGEST_PERIOD, int(len(poses) * (1.0 - LEAST_OVERLAP)))
    if longest <= SHORTEST_PERIOD:
        return None
    difference = self_difference(poses, longest)
    inner = difference[SHORTEST_PERIOD:longest]
    lowest = (inner <= difference[SHORTEST_PERIOD - 1 : longest - 1]) & (
        inner <= difference[SHORTEST_PERIOD + 1 : longest + 1]
    )
    lags = SHORTEST_PERIOD + np.flatnonzero(lowest & (inner < periodic))
    return int(lags[0]) if len(lags) else None


def best_loop(
    edges: FloatArray, shortest: int, missing: tuple[float, float] | None = None
) -> Loop | None:
    """The loop of least cost, None if there is none; `edges` (frames + 1, values).

    >>> loop = best_loop(np.sin(2 * np.pi * np.arange(31) / 10)[:, None], 8)
    >>> loop.length, round(loop.cost, 6)
    (30, 0.0)
    """
    n = len(edges)
    if n - 1 < shortest or shortest < 1:
        return None
    square = np.sum(edges**2, axis=1)
    distance = np.maximum(square[:, None] + square[None] - 2.0 * (edges @ edges.T), 0.0)
    frames = np.arange(n)
    length = frames[None] - frames[:, None]
    cost = distance + LENGTH_WEIGHT * 30.0 / np.maximum(length, 1)
    cost[length < shortest] = np.inf
    if missing is not None:
        low, high = missing
        fills = np.floor(high / np.maximum(length, 1)) * length >= low
        cost[~fills] = np.inf
    first, behind = np.unravel_index(int(np.argmin(cost)), cost.shape)
    if not np.isfinite(cost[first, behind]):
        return None
    return Loop(int(first), int(behind), float(distance[first, behind]))


def repeat(first: int, behind: int, loop: Loop, times: int) -> list[tuple[int, int]]:
    """Return the pieces of a movement [first, behind) whose loop is played additional times.

    >>> repeat(0, 50, Loop(10, 30, 0.0), 2)
    [(0, 30), (10, 30), (10, 50)]
    >>> repeat(0, 50, Loop(10, 30, 0.0), 0)
    [(0, 50)]
    """
    if times < 1:
        return [(first, behind)]
    inner = [(loop.first, loop.behind)] * (times - 1)
    return [(first, loop.behind), *inner, (loop.first, behind)]


def calmest_phase(poses: FloatArray, period: int) -> int:
    """The frame of the first period at which the movement is slowest, averaged over periods.

    `poses` (frames, values).

    >>> calmest_phase(np.cos(2 * np.pi * (np.arange(60) - 4) / 20)[:, None], 20) in (4, 14)
    True
    """
    speed = np.linalg.norm(np.gradient(poses, axis=0), axis=1)
    whole = len(speed) // period * period
    return int(np.argmin(speed[:whole].reshape(-1, period).mean(axis=0)))
