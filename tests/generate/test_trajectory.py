"""The most probable trajectory: against dense least squares, and as properties."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.generate import trajectory
from motiondb.records import FloatArray


def dense_windows(n_frames: int) -> FloatArray:
    """W (3 n, n): values, first and second differences, the ends repeated."""
    identity = np.eye(n_frames)
    rows = []
    for t in range(n_frames):
        before, after = identity[max(t - 1, 0)], identity[min(t + 1, n_frames - 1)]
        rows += [identity[t], (after - before) / 2.0, after - 2.0 * identity[t] + before]
    return np.array(rows)


def by_least_squares(means: FloatArray, covars: FloatArray) -> FloatArray:
    n_frames, n_dims = len(means), means.shape[1] // 3
    result = np.empty((n_frames, n_dims))
    for d in range(n_dims):
        columns = [d, d + n_dims, d + 2 * n_dims]
        weight = 1.0 / np.sqrt(covars[:, columns].ravel())
        result[:, d] = np.linalg.lstsq(
            dense_windows(n_frames) * weight[:, None],
            means[:, columns].ravel() * weight,
            rcond=None,
        )[0]
    return result


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.integers(1, 12))
def test_the_band_solution_equals_dense_least_squares(seed: int, n_frames: int) -> None:
    rng = np.random.default_rng(seed)
    means, covars = rng.normal(size=(n_frames, 6)), rng.uniform(0.1, 3.0, (n_frames, 6))
    np.testing.assert_allclose(
        trajectory.most_probable(means, covars), by_least_squares(means, covars), atol=1e-9
    )


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6), st.integers(1, 20))
def test_values_and_their_own_differences_come_back(seed: int, n_frames: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(n_frames, 2))
    means = trajectory.with_deltas(values)
    covars = rng.uniform(0.1, 2.0, means.shape)
    np.testing.assert_allclose(trajectory.most_probable(means, covars), values, atol=1e-9)


def test_differences_by_hand() -> None:
    stacked = trajectory.with_deltas(np.array([[0.0], [1.0], [4.0]]))
    np.testing.assert_allclose(stacked, [[0, 0.5, 1.0], [1, 2.0, 2.0], [4, 1.5, -3.0]])


def test_a_step_between_states_becomes_smooth() -> None:
    means = np.zeros((40, 3))
    means[20:, 0] = 1.0
    covars = np.tile([0.1, 0.001, 0.001], (40, 1))
    smooth = trajectory.most_probable(means, covars)[:, 0]
    assert np.abs(np.diff(smooth)).max() < 0.2
    assert np.all(np.diff(smooth) > -1e-3)
    np.testing.assert_allclose(smooth + smooth[::-1], 1.0, atol=1e-9)


def test_widening_brings_the_variance_back() -> None:
    rng = np.random.default_rng(0)
    quiet = rng.normal(0, 1.0, (500, 2)) + np.array([5.0, -3.0])
    means, covars = np.zeros((500, 2)), np.full((500, 2), 1.44)
    wide = trajectory.widen(quiet, means, covars, strength=1.0)
    np.testing.assert_allclose(wide.var(axis=0), 1.44, rtol=1e-9)
    np.testing.assert_allclose(wide.mean(axis=0), quiet.mean(axis=0))
    np.testing.assert_allclose(trajectory.widen(quiet, means, covars, 0.0), quiet)


@pytest.mark.parametrize("wanted", [0.01, 100.0])
def test_widening_never_shrinks_and_has_a_bound(wanted: float) -> None:
    quiet = np.random.default_rng(1).normal(size=(300, 1))
    wide = trajectory.widen(quiet, np.zeros((300, 1)), np.full((300, 1), wanted), 1.0)
    factor = wide.std() / quiet.std()
    assert factor == pytest.approx(1.0 if wanted < 1 else 1.6)
