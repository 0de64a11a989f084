"""HMMs in series (A12): rows sum to one, states add up, walks and outputs as distributed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.generate import series
from motiondb.records import MotionSymbols


def random_symbols(seed: int, n_symbols: int = 4, longest: int = 5) -> MotionSymbols:
    rng = np.random.default_rng(seed)
    n_states = rng.integers(1, longest + 1, n_symbols)
    inside = np.arange(longest) < n_states[:, None]
    loops = np.where(inside, rng.uniform(0.0, 0.95, inside.shape), 0.0)
    means = rng.normal(size=(n_symbols, longest, 2)) * inside[..., None]
    covars = np.where(inside[..., None], rng.uniform(0.1, 2.0, (n_symbols, longest, 2)), 1.0)
    return MotionSymbols(n_states, loops, means, covars)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_rows_sum_to_one_and_states_add_up(seed: int, length: int) -> None:
    symbols = random_symbols(seed)
    sequence = np.random.default_rng(seed).integers(0, 4, length)
    joined = series.join_series(symbols, sequence)
    n_states = sum(int(symbols.n_states[s]) for s in sequence)
    assert joined.transmat.shape == (n_states, n_states)
    np.testing.assert_allclose(joined.transmat.sum(axis=1), 1.0)
    assert joined.startprob.tolist() == [1.0] + [0.0] * (n_states - 1)
    rows, columns = np.nonzero(joined.transmat)
    assert set((columns - rows).tolist()) <= {0, 1}
    assert np.bincount(joined.positions, minlength=length).tolist() == [
        symbols.n_states[s] for s in sequence
    ]


def test_the_exit_leads_to_the_next_symbol_by_hand() -> None:
    symbols = MotionSymbols(
        np.array([2, 1]),
        np.array([[0.5, 0.75], [0.2, 0.0]]),
        np.array([[[1.0], [2.0]], [[3.0], [0.0]]]),
        np.ones((2, 2, 1)),
    )
    joined = series.join_series(symbols, np.array([0, 1]))
    np.testing.assert_allclose(joined.transmat, [[0.5, 0.5, 0], [0, 0.75, 0.25], [0, 0, 1.0]])
    assert joined.means[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert joined.positions.tolist() == [0, 0, 1]
    assert joined.self_loops.tolist() == [0.5, 0.75, 0.2]
    assert series.expected_durations(joined).tolist() == [2, 4, 1]


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6))
def test_expected_durations_add_up(seed: int) -> None:
    joined = series.join_series(random_symbols(seed), np.array([0, 1, 2, 3, 0]))
    durations = series.expected_durations(joined)
    assert durations.min() >= 1
    mean = np.sum(1.0 / (1.0 - joined.self_loops))
    assert abs(durations.sum() - mean) <= 1.0 + 0.5 * np.sum(joined.self_loops < 0.5)


def test_walks_go_from_the_first_state_out_of_the_last() -> None:
    joined = series.join_series(random_symbols(1), np.array([2, 0]))
    states = series.sample_states(joined, np.random.default_rng(0))
    assert states[0] == 0
    assert states[-1] == len(joined.self_loops) - 1
    assert set(np.diff(states).tolist()) <= {0, 1}


def test_walks_last_as_long_as_their_self_loops_say() -> None:
    joined = series.join_series(random_symbols(2), np.array([0, 1]))
    rng = np.random.default_rng(0)
    counts = np.mean(
        [
            np.bincount(series.sample_states(joined, rng), minlength=len(joined.self_loops))
            for _ in range(3000)
        ],
        axis=0,
    )
    np.testing.assert_allclose(counts, 1.0 / (1.0 - joined.self_loops), rtol=0.1)


def test_outputs_are_distributed_as_their_states() -> None:
    joined = series.join_series(random_symbols(3), np.array([1, 2]))
    states = np.repeat(np.arange(len(joined.self_loops)), 4000)
    outputs = series.sample_outputs(joined, states, np.random.default_rng(0))
    outputs = outputs.reshape(-1, 4000, 2)
    np.testing.assert_allclose(outputs.mean(axis=1), joined.means, atol=0.1)
    np.testing.assert_allclose(outputs.var(axis=1), joined.covars, rtol=0.12)


def test_the_same_seed_gives_the_same_walk() -> None:
    joined = series.join_series(random_symbols(4), np.array([0, 3]))
    one, two = (
        series.sample_outputs(joined, series.sample_states(joined, rng), rng)
        for rng in (np.random.default_rng(9), np.random.default_rng(9))
    )
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("loop", [0.0, 1.0])
def test_states_that_never_stay_or_never_leave(loop: float) -> None:
    symbols = MotionSymbols(
        np.array([1]), np.array([[loop]]), np.zeros((1, 1, 1)), np.ones((1, 1, 1))
    )
    joined = series.join_series(symbols, np.array([0]))
    assert joined.transmat.tolist() == [[1.0]]
    assert series.expected_durations(joined)[0] == (1 if loop == 0 else 1000)
