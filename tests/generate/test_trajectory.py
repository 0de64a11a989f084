"""Fine symbols, HMMs in series (A12), and their most probable trajectory."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.generate import symbol_motion
from motiondb.generate.symbol_motion import SPLIT, fine_states, fine_symbols
from motiondb.records import FloatArray, MotionSymbols


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
        symbol_motion.most_probable(means, covars), by_least_squares(means, covars), atol=1e-9
    )


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6), st.integers(1, 20))
def test_values_and_their_own_differences_come_back(seed: int, n_frames: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(n_frames, 2))
    means = symbol_motion.with_deltas(values)
    covars = rng.uniform(0.1, 2.0, means.shape)
    np.testing.assert_allclose(symbol_motion.most_probable(means, covars), values, atol=1e-9)


def test_differences_by_hand() -> None:
    stacked = symbol_motion.with_deltas(np.array([[0.0], [1.0], [4.0]]))
    np.testing.assert_allclose(stacked, [[0, 0.5, 1.0], [1, 2.0, 2.0], [4, 1.5, -3.0]])


def random_symbols(seed: int, n_symbols: int = 4, longest: int = 5) -> MotionSymbols:
    rng = np.random.default_rng(seed)
    n_states = rng.integers(1, longest + 1, n_symbols)
    inside = np.arange(longest) < n_states[:, None]
    loops = np.where(inside, rng.uniform(0.0, 0.95, inside.shape), 0.0)
    means = rng.normal(size=(n_symbols, longest, 2)) * inside[..., None]
    covars = np.where(inside[..., None], rng.uniform(0.1, 2.0, (n_symbols, longest, 2)), 1.0)
    return MotionSymbols(n_states, loops, means, covars)


def test_symbols_in_series_by_hand() -> None:
    symbols = MotionSymbols(
        np.array([2, 1]),
        np.array([[0.5, 0.75], [0.2, 0.0]]),
        np.array([[[1.0], [2.0]], [[3.0], [0.0]]]),
        np.ones((2, 2, 1)),
    )
    joined = symbol_motion.join_series(symbols, np.array([0, 1]))
    assert joined.means[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert joined.positions.tolist() == [0, 0, 1]
    assert joined.self_loops.tolist() == [0.5, 0.75, 0.2]
    assert symbol_motion.expected_durations(joined).tolist() == [2, 4, 1]


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6))
def test_expected_durations_add_up(seed: int) -> None:
    joined = symbol_motion.join_series(random_symbols(seed), np.array([0, 1, 2, 3, 0]))
    durations = symbol_motion.expected_durations(joined)
    assert durations.min() >= 1
    mean = np.sum(1.0 / (1.0 - joined.self_loops))
    assert abs(durations.sum() - mean) <= 1.0 + 0.5 * np.sum(joined.self_loops < 0.5)


@settings(deadline=None, max_examples=40)
@given(st.lists(st.integers(0, 9), min_size=1, max_size=5))
def test_states_are_cut_into_equal_parts_that_rise(lengths: list[int]) -> None:
    path = np.repeat(np.arange(len(lengths)), lengths)
    fine = fine_states(path, len(lengths))
    assert np.all(np.diff(fine) >= 0)
    np.testing.assert_array_equal(fine // SPLIT, path)
    for state, length in enumerate(lengths):
        counts = np.bincount(fine[path == state] - SPLIT * state, minlength=SPLIT)
        assert counts.max() - counts.min() <= 1
        assert counts.sum() == length


def test_means_variances_and_durations_by_hand() -> None:
    group = [np.array([[0.0], [0], [3], [3], [6], [6]]), np.array([[2.0], [2], [5], [5], [8], [8]])]
    states = [np.zeros(6, dtype=np.int64)] * 2
    symbols = fine_symbols([group], [states], 1)
    assert symbols.n_states.tolist() == [3]
    np.testing.assert_allclose(symbols.means[0, :, 0], [1, 4, 7])
    np.testing.assert_allclose(symbols.covars[0, :, 0], 1.0)
    np.testing.assert_allclose(symbols.self_loops[0], 0.5)
    assert symbols.means.shape == (1, 3, 3)


def test_states_passed_over_borrow_a_neighbour() -> None:
    symbols = fine_symbols([[np.array([[1.0], [9.0]])]], [[np.array([0, 2])]], 3)
    assert symbols.means[0, :, 0].tolist() == [1, 1, 1, 1, 9, 9, 9, 9, 9]
    assert symbols.self_loops.tolist() == [[0.0] * 9]
    assert symbols.covars.min() > 0


def test_no_variance_falls_below_its_floor() -> None:
    rng = np.random.default_rng(0)
    moving = rng.normal(size=(60, 2))
    still = np.full((60, 2), 5.0)
    states = np.repeat(np.arange(4), 15)
    symbols = fine_symbols([[moving], [still]], [[states], [states]], 4)
    everything = np.concatenate([symbol_motion.with_deltas(v) for v in (moving, still)])
    floor = symbol_motion.VARIANCE_FLOOR * everything.var(axis=0)
    assert np.all(symbols.covars >= floor - 1e-15)
    np.testing.assert_allclose(symbols.covars[1, 0, 0], floor[0])


def test_the_trajectory_of_a_symbol_is_what_its_segments_did() -> None:
    """Through the fine states and back: a rise and fall of one second within a tenth."""
    rng = np.random.default_rng(0)
    shape = np.sin(np.linspace(0, np.pi, 30))[:, None]
    group = [shape + rng.normal(0, 0.02, shape.shape) for _ in range(20)]
    states = np.repeat(np.arange(5), 6)
    symbols = fine_symbols([group], [[states] * 20], 5)
    joined = symbol_motion.join_series(symbols, np.array([0]))
    path = np.repeat(np.arange(15), symbol_motion.expected_durations(joined))
    assert len(path) == 30
    actual = symbol_motion.most_probable(joined.means[path], joined.covars[path])
    np.testing.assert_allclose(actual, shape, atol=0.1)


@pytest.mark.parametrize(("wanted", "factor"), [(1.44, 1.2), (0.01, 1.0), (100.0, 1.6)])
def test_widening_brings_the_variance_back_and_has_bounds(wanted: float, factor: float) -> None:
    quiet = np.random.default_rng(0).normal(size=(500, 1))
    quiet = 5.0 + (quiet - quiet.mean()) / quiet.std()
    means, covars = np.zeros((500, 1)), np.full((500, 1), wanted)
    wide = symbol_motion.widen(quiet, means, covars, strength=1.0)
    assert wide.std() == pytest.approx(factor)
    assert wide.mean() == pytest.approx(5.0)
    np.testing.assert_allclose(symbol_motion.widen(quiet, means, covars, 0.0), quiet)
