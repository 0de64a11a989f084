"""Two motions aligned: a motion with itself, at another tempo, and against all paths."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from motiondb.search.alignment import align


def poses(times: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(times + k) for k in range(6)], axis=1).astype(np.float32)


def test_the_same_motion_at_half_the_tempo_is_no_distance_away() -> None:
    times = np.arange(0.0, 4.0, 0.1)
    slow = np.repeat(times, 2)
    found = align(poses(times), poses(slow))
    assert found.distances.max() == 0.0
    assert found.joint_distances.tolist() == [0.0, 0.0]
    assert (found.path[:, 1] // 2 == found.path[:, 0]).all()


@pytest.mark.parametrize("seed", range(3))
def test_no_other_path_is_cheaper(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = (rng.normal(size=(n, 6)).astype(np.float32) for n in (5, 7))
    found = align(first, second)

    @cache
    def least(i: int, j: int) -> float:
        if (i, j) == (0, 0):
            return 2.0 * found.costs[0, 0]
        ways = [(i - 1, j - 1, 2.0), (i - 1, j, 1.0), (i, j - 1, 1.0)]
        return min(least(a, b) + w * found.costs[i, j] for a, b, w in ways if min(a, b) >= 0)

    steps = np.diff(found.path, axis=0, prepend=[[-1, -1]]).sum(axis=1)
    cost = sum(w * found.costs[i, j] for w, (i, j) in zip(steps, found.path))
    assert cost == pytest.approx(least(4, 6))
