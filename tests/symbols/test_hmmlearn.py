"""Symbols as models of hmmlearn and back: equal scores, equal parameters, refusals."""

from __future__ import annotations

import naive_hmm as naive
import numpy as np
import pytest
from hmmlearn.hmm import GaussianHMM
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, MotionSymbols
from motiondb.symbols import hmm


def scores_of(symbols: MotionSymbols, frames: FloatArray) -> FloatArray:
    return hmm.score(symbols, frames, np.array([0]), np.array([len(frames)]))[0].astype(float)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.integers(1, 30))
def test_scores_and_paths_are_equal(seed: int, n_frames: int) -> None:
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


def test_refusals_name_the_model() -> None:
    ahead = any_model([[0.5, 0.5], [0.0, 1.0]])
    with pytest.raises(MotionDBError, match="hmmlearn: expected at least 1 model, found 0"):
        MotionSymbols.from_hmmlearn([])
    with pytest.raises(MotionDBError, match="hmmlearn model 1: expected a left-to-right model"):
        MotionSymbols.from_hmmlearn([ahead, any_model([[0.5, 0.5], [0.2, 0.8]])])
    with pytest.raises(MotionDBError, match="model 0: expected diagonal covariances, found 'sph"):
        MotionSymbols.from_hmmlearn([any_model([[0.5, 0.5], [0.0, 1.0]], "spherical")])
    wide = any_model([[0.5, 0.5], [0.0, 1.0]])
    wide.means_, wide.n_features = np.zeros((2, 3)), 3
    with pytest.raises(MotionDBError, match="model 1: expected 1 dimensions as in model 0, found"):
        MotionSymbols.from_hmmlearn([ahead, wide])
    symbols = naive.random_symbols(np.random.default_rng(0), [2, 2], 1)
    for wrong in (-1, 2):
        with pytest.raises(MotionDBError, match=f"expected a number from 0 to 1, found {wrong}"):
            symbols.to_hmmlearn(wrong)
