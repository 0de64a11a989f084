"""Likelihoods, paths and samples of symbols against hand, twin and hmmlearn."""

from __future__ import annotations

import re
from dataclasses import replace

import naive_hmm as naive
import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb import workers
from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm, hmm_jobs, hmm_kernels, network
from motiondb.symbols.network import segment_by_symbols

TWO_COINS = MotionSymbols(
    np.array([2]),
    np.array([[0.5, 0.25]]),
    np.array([[[0.0], [2.0]]]),
    np.ones((1, 2, 1)),
)


def whole(frames: FloatArray) -> tuple[IntArray, IntArray]:
    return np.array([0]), np.array([len(frames)])


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 7), st.booleans())
def test_score_posteriors_and_path_are_sums_over_all_paths(
    seed: int, n_frames: int, exit: bool
) -> None:
    rng = np.random.default_rng(seed)
    symbols = naive.random_symbols(rng, [3, 1, 4], 2)
    frames = rng.normal(0, 1.5, (n_frames, 2))
    scores = hmm.score(symbols, frames, *whole(frames), exit=exit)
    assert scores.dtype == np.float32
    for s in range(3):
        possible = n_frames >= symbols.n_states[s] or not exit
        expected = naive.log_likelihood(symbols, s, frames, exit) if possible else -1e30
        assert scores[0, s] == pytest.approx(expected, rel=1e-4, abs=1e-4)
        ends = exit and possible
        gamma = hmm_kernels.posteriors(frames, hmm_kernels.log_symbols(symbols), s, exit)[0]
        np.testing.assert_allclose(gamma, naive.posteriors(symbols, s, frames, ends), atol=1e-9)
        path = hmm.viterbi(symbols, s, frames, exit=exit)
        assert tuple(path) == naive.best_path(symbols, s, frames, ends)


def test_blocks_threads_and_order_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    symbols = naive.random_symbols(rng, [int(k) for k in rng.integers(1, 6, 19)], 3)
    frames = rng.normal(0, 2, (400, 3))
    starts = rng.integers(0, 380, 60)  # unordered, overlapping
    ends = starts + rng.integers(1, 20, 60)
    expected = hmm.score(symbols, frames, starts, ends)
    monkeypatch.setattr(hmm_jobs, "FRAMES_AT_ONCE", 30)
    monkeypatch.setattr(workers, "N_THREADS", 3)
    monkeypatch.setattr(workers, "_LEAST", 0.0)
    monkeypatch.setattr(hmm_kernels, "BLOCK_VALUES", 50)
    np.testing.assert_allclose(hmm.score(symbols, frames, starts, ends), expected, rtol=1e-5)


def test_likely_symbols_are_scored_again_and_others_kept() -> None:
    rng = np.random.default_rng(7)
    symbols = naive.random_symbols(rng, [3, 1, 2] * 3, 2)
    starts, frames = np.arange(0, 60, 6), rng.normal(0, 2, (60, 2)).astype(np.float32)
    before = rng.normal(0, 50, (10, 9)).astype(np.float32)
    scores = hmm.rescore(symbols, frames, starts, starts + 6, before, 2)
    again = before >= np.sort(before, axis=1)[:, -2:-1]
    expected = hmm.score(symbols, frames, starts, starts + 6)
    np.testing.assert_array_equal(scores, np.where(again, expected, before))


def test_few_symbols_are_all_scored_again() -> None:
    rng = np.random.default_rng(8)
    symbols = naive.random_symbols(rng, [3] * 4, 2)
    frames = rng.normal(0, 2, (12, 2))
    segments = np.array([0, 6]), np.array([6, 12])
    scores = hmm.rescore(symbols, frames, *segments, np.zeros((2, 4), dtype=np.float32), 2)
    np.testing.assert_array_equal(scores, hmm.score(symbols, frames, *segments))


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


def value_of(
    symbols: MotionSymbols, frames: FloatArray, way: list[tuple[int, int, int]], cost: float
) -> float:
    """What ``segment_by_symbols`` maximises, for a given segmentation."""
    total = -cost * (len(way) - 1)
    for start, end, s in way:
        total += max(p for _, p in naive.paths(symbols, s, frames[start:end], True))
    return total


@settings(deadline=None, max_examples=25)
@given(
    st.integers(0, 10**6),
    st.integers(3, 8),
    st.floats(-2, 4),
    st.integers(1, 4),
)
def test_best_of_all_segmentations(seed: int, n_frames: int, cost: float, shortest: int) -> None:
    rng = np.random.default_rng(seed)
    symbols = naive.random_symbols(rng, [2, 1, 3], 2)
    frames = rng.normal(0, 1.5, (n_frames, 2))
    shortest = min(shortest, n_frames)
    way = segment_by_symbols(
        symbols,
        frames,
        switch_cost=cost,
        minimum_duration=shortest,
    )
    expected, _ = naive.best_segmentation(symbols, frames, cost, shortest)
    assert [a for a, _, _ in way] == [0, *(b for _, b, _ in way[:-1])]
    assert way[-1][1] == n_frames
    assert all(b - a >= max(shortest, symbols.n_states[s]) for a, b, s in way)
    assert value_of(symbols, frames, way, cost) == pytest.approx(expected, abs=1e-3)


def test_blocks_change_no_segmentation(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    symbols = naive.random_symbols(rng, [3, 2, 4, 3], 3)
    frames = rng.normal(0, 2, (90, 3))
    expected = segment_by_symbols(symbols, frames, switch_cost=3.0, minimum_duration=5)
    monkeypatch.setattr(network, "BLOCK_VALUES", 100)
    again = segment_by_symbols(symbols, frames, switch_cost=3.0, minimum_duration=5)
    assert again == expected
    assert len(expected) > 3


def test_samples_in_series_are_found_again() -> None:
    rng = np.random.default_rng(2)
    symbols = naive.random_symbols(rng, [4, 4, 4, 4], 6, spread=4.0)
    truth = [2, 0, 0, 3, 1, 2]
    parts = [naive.passage(symbols, s, rng) for s in truth]
    ends = np.cumsum([len(part) for part in parts])
    way = segment_by_symbols(symbols, np.concatenate(parts), switch_cost=5.0)
    assert [s for _, _, s in way] == truth
    assert [end for _, end, _ in way] == ends.tolist()


def test_too_short_for_any_symbol() -> None:
    symbols = naive.random_symbols(np.random.default_rng(3), [4, 3], 2)
    frames = symbols.means[1, :2]
    assert segment_by_symbols(symbols, frames) == [(0, 2, 1)]
    assert segment_by_symbols(symbols, symbols.means[0], minimum_duration=9) == [(0, 4, 0)]
    assert segment_by_symbols(symbols, np.zeros((0, 2))) == []


def scores_of(symbols: MotionSymbols, frames: FloatArray) -> FloatArray:
    return hmm.score(symbols, frames, np.array([0]), np.array([len(frames)]))[0].astype(float)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.integers(1, 30))
def test_scores_and_paths_are_those_of_hmmlearn(seed: int, n_frames: int) -> None:
    rng = np.random.default_rng(seed)
    symbols = naive.random_symbols(rng, [3, 1, 5], 2)
    frames = rng.normal(0, 1.5, (n_frames, 2))
    models = [symbols.to_hmmlearn(s) for s in range(3)]
    expected = scores_of(symbols, frames)
    np.testing.assert_allclose([m.score(frames) for m in models], expected, rtol=1e-4, atol=1e-4)
    for s, model in enumerate(models):
        np.testing.assert_array_equal(model.decode(frames)[1], hmm.viterbi(symbols, s, frames))


def test_there_and_back_is_the_same_to_the_last_bit() -> None:
    symbols = naive.random_symbols(np.random.default_rng(3), [4, 2, 6], 3)
    back = MotionSymbols.from_hmmlearn([symbols.to_hmmlearn(s) for s in range(3)])
    for name in ("n_states", "self_loops", "means", "covars"):
        np.testing.assert_array_equal(getattr(back, name), getattr(symbols, name))


def test_without_an_exit_state_the_last_state_is_never_left() -> None:
    symbols = naive.random_symbols(np.random.default_rng(4), [3], 2)
    model = symbols.to_hmmlearn(0, exit_state=False)
    assert model.n_components == 3
    assert model.transmat_[2].tolist() == [0.0, 0.0, 1.0]
    back = MotionSymbols.from_hmmlearn([model])
    np.testing.assert_array_equal(back.self_loops[0], [*symbols.self_loops[0, :2], 1.0])
    frames = np.random.default_rng(5).normal(size=(12, 2))
    assert model.score(frames) == pytest.approx(scores_of(back, frames)[0], rel=1e-4)


def test_hmmlearn_can_fit_and_sample_what_it_is_given() -> None:
    rng = np.random.default_rng(6)
    symbols = naive.random_symbols(rng, [3], 2, spread=4.0)
    model = symbols.to_hmmlearn(0, exit_state=False)
    drawn = [model.sample(40, random_state=int(seed))[0] for seed in range(5)]
    frames, lengths = np.concatenate(drawn), [40] * 5
    before = model.score(frames, lengths)
    model.fit(frames, lengths)
    assert model.score(frames, lengths) >= before
    assert MotionSymbols.from_hmmlearn([model]).n_states.tolist() == [3]


def any_model(transitions: list[list[float]], covariance: str = "diag") -> GaussianHMM:
    model = GaussianHMM(2, covariance, init_params="")
    model.startprob_ = np.array([1.0, 0.0])
    model.transmat_ = np.array(transitions)
    model.means_ = np.zeros((2, 1))
    model.covars_ = np.ones((2, 1)) if covariance == "diag" else np.ones(2)
    return model


@pytest.mark.parametrize(
    ("part", "value", "told"),
    [
        ("startprob_", [np.nan, 0.0], "numbers that are not finite"),
        ("transmat_", [[0.5, 0.5], [0.0, 0.0]], "rows of transitions that do not sum to 1"),
        ("transmat_", [[0.5, 0.5], [np.nan, np.nan]], "numbers that are not finite"),
        ("means_", [[0.0], [np.inf]], "numbers that are not finite"),
        ("_covars_", [[1.0], [0.0]], "variances that are not above 0"),
        ("_covars_", [[np.nan], [1.0]], "numbers that are not finite"),
    ],
)
def test_what_a_fit_left_without_numbers_is_refused(part: str, value: object, told: str) -> None:
    ahead, failed = (any_model([[0.5, 0.5], [0.0, 1.0]]) for _ in range(2))
    setattr(failed, part, np.array(value))
    with pytest.raises(MotionDBError) as error:
        MotionSymbols.from_hmmlearn([ahead, failed])
    assert str(error.value).startswith(
        f"hmmlearn model 1: expected a model that was fitted, found {told}"
    )


def test_refusals_name_the_model() -> None:
    ahead = any_model([[0.5, 0.5], [0.0, 1.0]])
    wide = any_model([[0.5, 0.5], [0.0, 1.0]])
    wide.means_, wide.n_features = np.zeros((2, 3)), 3
    for models, text in (
        ([], "hmmlearn: expected at least 1 model, found 0"),
        ([ahead, any_model([[0.5, 0.5], [0.2, 0.8]])], "model 1: expected a left-to-right model"),
        ([any_model([[0.5, 0.5], [0.0, 1.0]], "spherical")], "model 0: expected diagonal covar"),
        ([ahead, wide], "model 1: expected 1 dimensions as in model 0, found"),
    ):
        with pytest.raises(MotionDBError, match=text):
            MotionSymbols.from_hmmlearn(models)
    with pytest.raises(MotionDBError, match="expected a number from 0 to 0, found 1"):
        TWO_COINS.to_hmmlearn(1)


FIVE = np.zeros((5, 1))
ALL = (FIVE, *whole(FIVE))


WRONG = {
    "frames: expected 1 columns as the symbols have, found shape (5, 3). Project the features": (
        lambda: hmm.score(TWO_COINS, np.zeros((5, 3)), *whole(FIVE))
    ),
    "segment 1: expected 0 <= start < end <= 5, found [3, 3). Leave out empty segments": (
        lambda: hmm.score(TWO_COINS, FIVE, np.array([0, 3]), np.array([2, 3]))
    ),
    "symbols.covars: expected shape (1, 2, 1), found": (
        lambda: hmm.score(replace(TWO_COINS, covars=np.ones((1, 3, 1))), *ALL)
    ),
    "symbols.n_states: expected 1 numbers from 1 to 2,": (
        lambda: hmm.score(replace(TWO_COINS, n_states=np.array([3])), *ALL)
    ),
    "variances above 0": (lambda: hmm.score(replace(TWO_COINS, covars=np.zeros((1, 2, 1))), *ALL)),
    "symbols.self_loops: expected probabilities": (
        lambda: hmm.score(replace(TWO_COINS, self_loops=np.full((1, 2), 1.5)), *ALL)
    ),
    "assignment: expected symbols from 0 to 0, found 4. Number the symbols from 0.": (
        lambda: hmm.fit(TWO_COINS, *ALL, np.array([4]), n_iterations=1, variance_floor=1)
    ),
    "assignment: expected a symbol for each of 1 segments, found 3. Give one number a segment.": (
        lambda: hmm.fit(TWO_COINS, *ALL, np.zeros(3), n_iterations=1, variance_floor=1)
    ),
}


@pytest.mark.parametrize("text", WRONG)
def test_what_does_not_fit_is_refused(text: str) -> None:
    with pytest.raises(MotionDBError, match=re.escape(text)):
        WRONG[text]()
