"""Periods, loops and repetitions of a movement."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.generate import cycles


def naive_self_difference(poses: np.ndarray, longest: int) -> list[float]:
    """D(T), one pair of frames after the other."""
    spread = 2.0 * sum(float(np.var(poses[:, d])) for d in range(poses.shape[1]))
    actual = [0.0]
    for lag in range(1, longest + 1):
        pairs = [(poses[t + lag] - poses[t]) for t in range(len(poses) - lag)]
        actual.append(float(np.mean([d @ d for d in pairs])) / spread)
    return actual


def test_self_difference_is_that_of_the_slow_twin() -> None:
    poses = np.random.default_rng(0).normal(size=(30, 3))
    np.testing.assert_allclose(
        cycles.self_difference(poses, 12), naive_self_difference(poses, 12), rtol=1e-9
    )


@given(st.integers(15, 40), st.integers(0, 100))
def test_the_period_of_a_wave_is_found(period: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * (np.arange(4 * period) / period + rng.random())
    poses = np.stack([np.sin(phase), np.cos(phase)], axis=1)
    poses += rng.normal(scale=0.02, size=poses.shape)
    actual = cycles.find_period(poses)
    assert actual is not None
    assert abs(actual - period) <= 1


def test_a_single_movement_has_no_period() -> None:
    bump = np.exp(-0.5 * ((np.arange(90) - 45) / 8.0) ** 2)[:, None]
    assert cycles.find_period(bump) is None
    assert cycles.find_period(bump[:10]) is None


def test_a_loop_closes_where_the_poses_are_alike() -> None:
    phase = 2 * np.pi * np.arange(51) / 20
    loop = cycles.best_loop(np.stack([np.sin(phase), np.cos(phase)], axis=1), 15)
    assert loop is not None
    assert loop.length in (20, 40)
    assert loop.cost == pytest.approx(0.0, abs=1e-9)
    assert cycles.best_loop(np.zeros((10, 2)), 10) is None


@given(st.integers(0, 9), st.integers(1, 20), st.integers(0, 6), st.integers(0, 15))
def test_repetition_plays_the_loop_more_often(a: int, length: int, times: int, rest: int) -> None:
    loop = cycles.Loop(a, a + length, 0.0)
    parts = cycles.repeat(0, a + length + rest, loop, times)
    assert sum(end - start for start, end in parts) == a + length + rest + times * length
    assert parts[0][0] == 0
    assert parts[-1][1] == a + length + rest
    assert all(after[0] == a and before[1] == a + length
               for before, after in itertools.pairwise(parts))  # fmt: skip
