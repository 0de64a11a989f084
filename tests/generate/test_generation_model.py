"""Finer symbols for generation: states cut in three, means and durations by hand."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.generate import generation_model, series, trajectory
from motiondb.generate.generation_model import SPLIT, fine_states, generation_symbols


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
    symbols = generation_symbols([group], [states], 1)
    assert symbols.n_states.tolist() == [3]
    np.testing.assert_allclose(symbols.means[0, :, 0], [1, 4, 7])
    np.testing.assert_allclose(symbols.covars[0, :, 0], 1.0)
    np.testing.assert_allclose(symbols.self_loops[0], 0.5)
    assert symbols.means.shape == (1, 3, 3)


def test_states_passed_over_borrow_a_neighbour() -> None:
    symbols = generation_symbols([[np.array([[1.0], [9.0]])]], [[np.array([0, 2])]], 3)
    assert symbols.means[0, :, 0].tolist() == [1, 1, 1, 1, 9, 9, 9, 9, 9]
    assert symbols.self_loops.tolist() == [[0.0] * 9]
    assert symbols.covars.min() > 0


def test_no_variance_falls_below_its_floor() -> None:
    rng = np.random.default_rng(0)
    moving = rng.normal(size=(60, 2))
    still = np.full((60, 2), 5.0)
    states = np.repeat(np.arange(4), 15)
    symbols = generation_symbols([[moving], [still]], [[states], [states]], 4)
    everything = np.concatenate([trajectory.with_deltas(v) for v in (moving, still)])
    floor = generation_model.VARIANCE_FLOOR * everything.var(axis=0)
    assert np.all(symbols.covars >= floor - 1e-15)
    np.testing.assert_allclose(symbols.covars[1, 0, 0], floor[0])


def test_the_trajectory_of_a_symbol_is_what_its_segments_did() -> None:
    """Through the fine states and back: a rise and fall of one second within a tenth."""
    rng = np.random.default_rng(0)
    shape = np.sin(np.linspace(0, np.pi, 30))[:, None]
    group = [shape + rng.normal(0, 0.02, shape.shape) for _ in range(20)]
    states = np.repeat(np.arange(5), 6)
    symbols = generation_symbols([group], [[states] * 20], 5)
    joined = series.join_series(symbols, np.array([0]))
    path = np.repeat(np.arange(15), series.expected_durations(joined))
    assert len(path) == 30
    actual = trajectory.most_probable(joined.means[path], joined.covars[path])
    np.testing.assert_allclose(actual, shape, atol=0.1)
