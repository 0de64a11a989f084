"""Baum-Welch against hand, hmmlearn and the sum over all paths."""

from __future__ import annotations

import naive_hmm as naive
import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb import workers
from motiondb.records import FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm


def drawn(
    seed: int, n_segments: int, shortest: int = 1, longest: int = 14
) -> tuple[FloatArray, IntArray, IntArray]:
    """Random-walk frames and segments that tile them."""
    rng = np.random.default_rng(seed)
    ends = np.cumsum(rng.integers(shortest, longest, n_segments))
    frames = rng.normal(0, 0.7, (ends[-1], 3)).cumsum(axis=0)
    return frames, np.concatenate([[0], ends[:-1]]), ends


def test_initialise_by_hand() -> None:
    frames = np.array([[0.0], [2.0], [4.0], [8.0], [1.0], [5.0], [7.0]])
    symbols = hmm.initialise(
        frames, np.array([0, 4]), np.array([4, 7]), np.array([0, 0]), np.array([2]), 0.5
    )
    # Segment 0 is cut 2 + 2. Segment 1, of 3 frames, has its frame 1 in state 1 * 2 // 3 = 0.
    np.testing.assert_allclose(symbols.means[0, :, 0], [8 / 4, 19 / 3])
    np.testing.assert_allclose(symbols.covars[0, :, 0], [30 / 4 - 4, 129 / 3 - (19 / 3) ** 2])
    np.testing.assert_allclose(symbols.self_loops[0], [1 - 2 / 4, 1 - 2 / 3])


def test_initialise_without_segments_and_with_short_ones() -> None:
    frames = np.array([[0.0], [2.0], [10.0]])
    symbols = hmm.initialise(
        frames, np.array([0, 2]), np.array([2, 3]), np.array([0, 0]), np.array([3, 2]), 0.1
    )
    np.testing.assert_allclose(symbols.means[0, :, 0], [5.0, 2.0, 4.0])  # the last: all its frames
    np.testing.assert_allclose(symbols.means[1, :, 0], [4.0, 4.0, 0.0])  # nothing: all frames; pad
    np.testing.assert_allclose(symbols.covars[0, 1], [0.1])
    np.testing.assert_allclose(symbols.covars[1, 2], [1.0])


def test_one_iteration_is_that_of_hmmlearn() -> None:
    frames, starts, ends = drawn(1, 12, 6, 20)
    rng = np.random.default_rng(2)
    symbols = naive.random_symbols(rng, [4, 3], 3)
    symbols.self_loops[0, 3] = symbols.self_loops[1, 2] = 1.0
    assignment = rng.integers(0, 2, 12)
    fitted, trace = hmm.fit(
        symbols,
        frames,
        starts,
        ends,
        assignment,
        n_iterations=1,
        variance_floor=1e-9,
        exit_required=False,
    )
    total = 0.0
    for s, n in enumerate([4, 3]):
        model = GaussianHMM(n, "diag", n_iter=1, init_params="", params="tmc", covars_prior=0.0)
        model.startprob_ = np.eye(n)[0]
        model.transmat_ = np.diag(symbols.self_loops[s, :n])
        model.transmat_ += np.diag(1 - symbols.self_loops[s, : n - 1], 1)
        model.means_, model.covars_ = symbols.means[s, :n], symbols.covars[s, :n]
        mine = [frames[a:b] for a, b, w in zip(starts, ends, assignment) if w == s]
        total += model.score(np.concatenate(mine), [len(x) for x in mine])
        model.fit(np.concatenate(mine), [len(x) for x in mine])
        np.testing.assert_allclose(fitted.means[s, :n], model.means_, rtol=1e-6)
        variances = np.stack([np.diag(c) for c in model.covars_])
        np.testing.assert_allclose(fitted.covars[s, :n], variances, rtol=1e-5)
        expected = np.clip(np.diag(model.transmat_), *hmm.SELF_LOOP_BOUNDS)
        np.testing.assert_allclose(fitted.self_loops[s, : n - 1], expected[:-1], rtol=1e-6)
        assert fitted.self_loops[s, n - 1] == 1.0
    assert trace[0] == pytest.approx(total)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.booleans(), st.floats(1e-3, 1.0))
def test_the_likelihood_never_falls_and_bounds_hold(
    seed: int, exit_required: bool, floor: float
) -> None:
    frames, starts, ends = drawn(seed, 10)
    rng = np.random.default_rng(seed)
    symbols = naive.random_symbols(rng, [3, 1, 5], 3)
    assignment = rng.integers(0, 2, 10)  # symbol 2 has no segments
    fitted, trace = hmm.fit(
        symbols,
        frames,
        starts,
        ends,
        assignment,
        n_iterations=8,
        variance_floor=np.array([floor, floor, 0.2]),
        exit_required=exit_required,
    )
    assert np.all(np.diff(trace) >= -1e-9 * np.abs(trace[:-1]))
    real = np.arange(5) < fitted.n_states[:, None]
    assert np.all(fitted.covars[real] >= [floor, floor, 0.2])
    low, high = hmm.SELF_LOOP_BOUNDS
    assert np.all((fitted.self_loops[real] >= low) & (fitted.self_loops[real] <= high))
    np.testing.assert_array_equal(fitted.means[2], symbols.means[2])
    for array, padding in zip((fitted.self_loops, fitted.means, fitted.covars), (0, 0, 1)):
        assert np.all(array[~real] == padding)


def test_trace_is_the_sum_over_all_paths_that_leave() -> None:
    frames, starts, ends = drawn(3, 6, 2, 7)  # some are shorter than the 3 states
    symbols = naive.random_symbols(np.random.default_rng(3), [3], 3)
    _, trace = hmm.fit(
        symbols, frames, starts, ends, np.zeros(6, int), n_iterations=0, variance_floor=1e-6
    )
    expected = sum(
        naive.log_likelihood(symbols, 0, frames[a:b], bool(b - a >= 3))
        for a, b in zip(starts, ends)
    )
    assert trace == pytest.approx([expected])


def test_a_maximum_of_all_paths_is_a_fixed_point() -> None:
    """After many steps no parameter can be moved to raise the likelihood of all paths."""
    frames, starts, ends = drawn(4, 5, 3, 7)
    zeros = np.zeros(5, int)
    start = hmm.initialise(frames, starts, ends, zeros, np.array([2]), 0.05)
    best, _ = hmm.fit(start, frames, starts, ends, zeros, n_iterations=600, variance_floor=0.05)

    def total(symbols: MotionSymbols) -> float:
        return float(
            sum(naive.log_likelihood(symbols, 0, frames[a:b], True) for a, b in zip(starts, ends))
        )

    reached = total(best)
    for step in (-1e-3, 1e-3):
        for k in range(2):
            loops, means = best.self_loops.copy(), best.means.copy()
            loops[0, k] += step
            means[0, k, 1] += step
            moved = MotionSymbols(best.n_states, loops, best.means, best.covars)
            assert total(moved) < reached + 1e-9
            moved = MotionSymbols(best.n_states, best.self_loops, means, best.covars)
            assert total(moved) < reached + 1e-9


def test_zeros_stay_zero() -> None:
    frames, starts, ends = drawn(5, 10, 4, 9)
    zeros = np.zeros(10, int)
    symbols = naive.random_symbols(np.random.default_rng(5), [3], 3)
    symbols.self_loops[0] = [0.0, 0.5, 1.0]
    fitted, _ = hmm.fit(
        symbols,
        frames,
        starts,
        ends,
        zeros,
        n_iterations=4,
        variance_floor=0.1,
        exit_required=False,
    )
    assert fitted.self_loops[0, 0] == 0.0
    assert fitted.self_loops[0, 2] == 1.0


def test_what_a_symbol_cannot_produce_counts_for_nothing() -> None:
    symbols = naive.random_symbols(np.random.default_rng(9), [2], 1)
    symbols.self_loops[0] = [0.0, 0.0]  # two frames, no more
    frames = np.array([[0.0], [1.0], [5.0], [6.0], [7.0]])
    starts, ends = np.array([0, 2]), np.array([2, 5])
    fitted, _ = hmm.fit(symbols, frames, starts, ends, [0, 0], n_iterations=1, variance_floor=0.1)
    np.testing.assert_allclose(fitted.means[0, :, 0], [0.0, 1.0])


def test_threads_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    frames, starts, ends = drawn(6, 40)
    rng = np.random.default_rng(6)
    symbols = naive.random_symbols(rng, [3, 2, 4, 3, 3], 3)
    assignment = rng.integers(0, 5, 40)
    options = {"n_iterations": 3, "variance_floor": 0.1}
    first, trace = hmm.fit(symbols, frames, starts, ends, assignment, **options)
    monkeypatch.setattr(workers, "N_THREADS", 4)
    monkeypatch.setattr(workers, "_LEAST", 0.0)
    second, again = hmm.fit(symbols, frames, starts, ends, assignment, **options)
    np.testing.assert_array_equal(trace, again)
    for name in ("self_loops", "means", "covars"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
