"""Likelihoods, paths and samples of symbols against hand, twin and hmmlearn."""

from __future__ import annotations

import naive_hmm as naive
import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm, hmm_jobs, hmm_kernels

TWO_COINS = MotionSymbols(
    np.array([2]),
    np.array([[0.5, 0.25]]),
    np.array([[[0.0], [2.0]]]),
    np.ones((1, 2, 1)),
)
LOG_2_PI = np.log(2 * np.pi)


def whole(frames: FloatArray) -> tuple[IntArray, IntArray]:
    return np.array([0]), np.array([len(frames)])


def as_hmmlearn(symbols: MotionSymbols, s: int) -> GaussianHMM:
    """The symbol with one further, absorbing state that no frame can be in."""
    n, n_dims = int(symbols.n_states[s]), symbols.means.shape[2]
    model = GaussianHMM(n + 1, "diag", init_params="", params="", implementation="log")
    model.startprob_ = np.eye(n + 1)[0]
    model.transmat_ = np.zeros((n + 1, n + 1))
    for k in range(n):
        model.transmat_[k, k] = symbols.self_loops[s, k]
        model.transmat_[k, k + 1] = 1 - symbols.self_loops[s, k]
    model.transmat_[n, n] = 1.0
    model.means_ = np.concatenate([symbols.means[s, :n], np.full((1, n_dims), 1e6)])
    model.covars_ = np.concatenate([symbols.covars[s, :n], np.ones((1, n_dims))])
    return model


def test_score_by_hand() -> None:
    frames = np.array([[0.0], [2.0]])
    # stay: 1/2 exp(-2), move: 1/2; both times (2 pi)^-1. Leaving: 1/2 * 3/4.
    free = hmm.score(TWO_COINS, frames, *whole(frames))
    left = hmm.score(TWO_COINS, frames, *whole(frames), exit=True)
    assert free[0, 0] == pytest.approx(np.log(0.5 * (1 + np.exp(-2))) - LOG_2_PI, rel=1e-6)
    assert left[0, 0] == pytest.approx(np.log(0.375) - LOG_2_PI, rel=1e-6)
    assert free.dtype == np.float32


def test_too_short_to_leave_is_impossible() -> None:
    frames = np.zeros((1, 1))
    assert hmm.score(TWO_COINS, frames, *whole(frames), exit=True)[0, 0] == np.float32(-1e30)
    assert hmm.score(TWO_COINS, frames, *whole(frames))[0, 0] == pytest.approx(-0.5 * LOG_2_PI)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 7), st.booleans())
def test_score_posteriors_and_path_are_sums_over_all_paths(
    seed: int, n_frames: int, exit: bool
) -> None:
    rng = np.random.default_rng(seed)
    symbols = naive.random_symbols(rng, [3, 1, 4], 2)
    frames = rng.normal(0, 1.5, (n_frames, 2))
    scores = hmm.score(symbols, frames, *whole(frames), exit=exit)
    for s in range(3):
        possible = n_frames >= symbols.n_states[s] or not exit
        expected = naive.log_likelihood(symbols, s, frames, exit) if possible else -1e30
        assert scores[0, s] == pytest.approx(expected, rel=1e-4, abs=1e-4)
        ends = exit and possible
        gamma = hmm_kernels.posteriors(frames, hmm_kernels.log_symbols(symbols), s, exit)[0]
        np.testing.assert_allclose(gamma, naive.posteriors(symbols, s, frames, ends), atol=1e-9)
        path = hmm.viterbi(symbols, s, frames, exit=exit)
        assert tuple(path) == naive.best_path(symbols, s, frames, ends)


def test_score_and_viterbi_are_those_of_hmmlearn() -> None:
    rng = np.random.default_rng(1)
    symbols = naive.random_symbols(rng, [6, 4, 5, 6], 5)
    ends = np.cumsum(rng.integers(3, 40, 25))
    starts = np.concatenate([[0], ends[:-1]])
    frames = rng.normal(0, 2, (ends[-1], 5)).astype(np.float32)
    scores = hmm.score(symbols, frames, starts, ends)
    models = [as_hmmlearn(symbols, s) for s in range(4)]
    expected = [[model.score(frames[a:b]) for model in models] for a, b in zip(starts, ends)]
    np.testing.assert_allclose(scores, expected, rtol=1e-4)
    for a, b, s in zip(starts, ends, rng.integers(0, 4, 25)):
        np.testing.assert_array_equal(
            hmm.viterbi(symbols, s, frames[a:b]), models[s].decode(frames[a:b])[1]
        )


def test_blocks_threads_and_order_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    symbols = naive.random_symbols(rng, [int(k) for k in rng.integers(1, 6, 19)], 3)
    frames = rng.normal(0, 2, (400, 3))
    starts = rng.integers(0, 380, 60)  # unordered, overlapping
    ends = starts + rng.integers(1, 20, 60)
    expected = hmm.score(symbols, frames, starts, ends)
    monkeypatch.setattr(hmm_jobs, "FRAMES_AT_ONCE", 30)
    monkeypatch.setattr(hmm_jobs, "LEAST_WORK", 0)
    monkeypatch.setattr(hmm_jobs, "N_THREADS", 3)
    monkeypatch.setattr(hmm_kernels, "BLOCK_VALUES", 50)
    np.testing.assert_allclose(hmm.score(symbols, frames, starts, ends), expected, rtol=1e-5)


def test_hopeless_and_narrow_symbols_keep_finite_scores() -> None:
    """Scaling would underflow here, and single precision would cancel."""
    rng = np.random.default_rng(3)
    symbols = naive.random_symbols(rng, [4, 4], 3)
    narrow = MotionSymbols(
        symbols.n_states, symbols.self_loops, symbols.means + 500, symbols.covars * 1e-5
    )
    frames = narrow.means[0, [0, 0, 1, 2, 3, 3]] + rng.normal(0, 3e-3, (6, 3))
    scores = hmm.score(narrow, frames, *whole(frames))
    expected = [naive.log_likelihood(narrow, s, frames, False) for s in range(2)]
    np.testing.assert_allclose(scores[0], expected, rtol=1e-4)
    assert expected[1] < -1e4


def test_viterbi_all_lays_segments_end_to_end() -> None:
    rng = np.random.default_rng(4)
    symbols = naive.random_symbols(rng, [3, 2], 2)
    frames = rng.normal(0, 2, (30, 2))
    starts, ends = np.array([20, 0, 5]), np.array([30, 5, 17])
    states = hmm.viterbi_all(symbols, frames, starts, ends, np.array([1, 0, 1]))
    parts = [hmm.viterbi(symbols, s, frames[a:b]) for a, b, s in zip(starts, ends, [1, 0, 1])]
    np.testing.assert_array_equal(states, np.concatenate(parts))


def test_sample_has_the_durations_and_the_gaussians_of_the_symbol() -> None:
    rng = np.random.default_rng(5)
    symbols = naive.random_symbols(rng, [3], 2)
    draws = [hmm.sample(symbols, 0, rng) for _ in range(3000)]
    for k in range(3):
        stays = np.array([np.sum(states == k) for _, states in draws])
        assert stays.min() == 1
        assert stays.mean() == pytest.approx(1 / (1 - symbols.self_loops[0, k]), rel=0.06)
        values = np.concatenate([frames[states == k] for frames, states in draws])
        np.testing.assert_allclose(values.mean(axis=0), symbols.means[0, k], atol=0.1)
        np.testing.assert_allclose(values.var(axis=0), symbols.covars[0, k], rtol=0.1)


def test_sample_of_given_length_weighs_paths_by_their_probability() -> None:
    rng = np.random.default_rng(6)
    drawn = [tuple(hmm.sample(TWO_COINS, 0, rng, length=4)[1]) for _ in range(4000)]
    # 0001: 1/2 1/2, 0011: 1/2 1/4, 0111: 1/4 1/4, over 7/16 in all.
    for path, share in {(0, 0, 0, 1): 4 / 7, (0, 0, 1, 1): 2 / 7, (0, 1, 1, 1): 1 / 7}.items():
        assert drawn.count(path) / 4000 == pytest.approx(share, abs=0.03)


def test_the_same_seed_gives_the_same_sample() -> None:
    first, second = (hmm.sample(TWO_COINS, 0, np.random.default_rng(7))[0] for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_error_texts() -> None:
    frames = np.zeros((5, 1))
    cases = [
        (
            lambda: hmm.score(TWO_COINS, np.zeros((5, 3)), *whole(frames)),
            "frames: expected 1 columns as the symbols have, found shape (5, 3). "
            "Project the features into the symbols' space.",
        ),
        (
            lambda: hmm.score(TWO_COINS, frames, np.array([0, 3]), np.array([2, 3])),
            "segment 1: expected 0 <= start < end <= 5, found [3, 3). "
            "Leave out empty segments and those beyond the frames.",
        ),
        (
            lambda: hmm.viterbi(TWO_COINS, 4, frames),
            "assignment: expected symbols from 0 to 0, found 4. Number the symbols from 0.",
        ),
        (
            lambda: hmm.sample(TWO_COINS, 0, np.random.default_rng(0), length=1),
            "symbol 0: expected a length of at least 2 frames (its states), found 1. "
            "Ask for more frames.",
        ),
    ]
    for call, text in cases:
        with pytest.raises(MotionDBError) as caught:
            call()
        assert str(caught.value) == text


def test_symbols_that_do_not_fit_together_are_refused() -> None:
    frames = np.zeros((5, 1))
    shape = MotionSymbols(np.array([2]), np.ones((1, 2)), np.zeros((1, 2, 1)), np.ones((1, 3, 1)))
    with pytest.raises(MotionDBError, match=r"^symbols\.covars: expected shape \(1, 2, 1\), found"):
        hmm.score(shape, frames, *whole(frames))
    count = MotionSymbols(np.array([3]), np.ones((1, 2)), np.zeros((1, 2, 1)), np.ones((1, 2, 1)))
    with pytest.raises(MotionDBError, match=r"^symbols\.n_states: expected 1 numbers from 1 to 2,"):
        hmm.score(count, frames, *whole(frames))
    flat = MotionSymbols(np.array([2]), np.ones((1, 2)), np.zeros((1, 2, 1)), np.zeros((1, 2, 1)))
    with pytest.raises(MotionDBError, match="variances above 0"):
        hmm.score(flat, frames, *whole(frames))
    loop = MotionSymbols(np.array([2]), np.full((1, 2), 1.5), *([np.ones((1, 2, 1))] * 2))
    with pytest.raises(MotionDBError, match=r"^symbols\.self_loops: expected probabilities"):
        hmm.score(loop, frames, *whole(frames))
