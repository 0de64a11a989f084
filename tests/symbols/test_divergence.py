"""Distances between symbols against closed forms and an obvious twin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, MotionSymbols
from motiondb.symbols import hmm
from motiondb.symbols import space as module
from motiondb.symbols.space import divergence, sample_together


def symbols_of(seed: int, n_states: list[int], n_dims: int = 3) -> MotionSymbols:
    rng = np.random.default_rng(seed)
    shape = (len(n_states), max(n_states))
    return MotionSymbols(
        np.array(n_states),
        rng.uniform(0.3, 0.9, shape),
        rng.normal(0, 1, (*shape, n_dims)),
        rng.uniform(0.4, 1.5, (*shape, n_dims)),
    )


def gaussian_divergence(symbols: MotionSymbols, i: int, j: int) -> float:
    """(KL(i, j) + KL(j, i)) / 2 of the first states' Gaussians."""
    (m, n), (v, w) = symbols.means[[i, j], 0], symbols.covars[[i, j], 0]
    return float(np.sum((v + (m - n) ** 2) / w + (w + (m - n) ** 2) / v - 2) / 4)


def test_two_gaussians_by_hand() -> None:
    symbols = MotionSymbols(
        np.array([1, 1]), np.full((2, 1), 0.5), np.array([[[0.0]], [[2.0]]]), np.ones((2, 1, 1))
    )
    distances, variances = divergence(symbols, np.random.default_rng(0), n_sequences=2000)
    assert gaussian_divergence(symbols, 0, 1) == 2.0
    assert distances[0, 1] == pytest.approx(2.0, abs=0.02)
    # Equal variances and common normals: both directions' noise cancels altogether.
    assert variances[0, 1] == pytest.approx(0.0, abs=1e-9)


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 10**6))
def test_single_states_agree_with_the_closed_form(seed: int) -> None:
    symbols = symbols_of(seed, [1, 1, 1])  # of different self-loops, which must not matter
    distances, variances = divergence(
        symbols, np.random.default_rng(seed), n_sequences=400, n_frames=20
    )
    for i in range(3):
        for j in range(i):
            error = abs(distances[i, j] - gaussian_divergence(symbols, i, j))
            assert error < 5 * np.sqrt(variances[i, j]) + 1e-3


def test_symmetric_not_negative_zero_diagonal() -> None:
    symbols = symbols_of(1, [3, 2, 4, 1])
    twice = MotionSymbols(*(np.concatenate([a, a]) for a in vars(symbols).values()))
    distances, variances = divergence(twice, np.random.default_rng(1), n_sequences=8)
    np.testing.assert_array_equal(distances, distances.T)
    np.testing.assert_array_equal(variances, variances.T)
    assert np.all(distances >= 0)
    assert np.all(np.diag(distances) == 0)
    np.testing.assert_allclose(np.diag(distances, 4), 0.0, atol=1e-6)  # each beside its copy


def test_variance_is_that_of_repeated_estimates() -> None:
    symbols = symbols_of(2, [2, 3])
    runs = [divergence(symbols, np.random.default_rng(n), n_sequences=10) for n in range(400)]
    spread = np.var([distances[0, 1] for distances, _ in runs])
    assert np.mean([variances[0, 1] for _, variances in runs]) == pytest.approx(spread, rel=0.25)


def test_the_twin_that_scores_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    symbols = symbols_of(3, [2, 3, 1])
    waiting = module._waiting_at_the_end(symbols)
    rng = np.random.default_rng(3)
    uniforms, normals = rng.random((5, 7)), rng.standard_normal((5, 7, 3))
    samples = sample_together(waiting, np.arange(3), uniforms, normals)
    zero, seven = np.array([0]), np.array([7])

    def log_p(s: int, frames: FloatArray) -> float:
        return float(hmm.score(waiting, frames, zero, seven)[0, s])

    monkeypatch.setattr(module, "_VALUES_AT_ONCE", 1)
    distances, variances = divergence(symbols, np.random.default_rng(3), n_sequences=5, n_frames=7)
    for i in range(3):
        for j in range(i):
            each = [
                (log_p(i, y) - log_p(j, y) + log_p(j, z) - log_p(i, z)) / 14
                for y, z in zip(samples[i], samples[j])
            ]
            assert distances[i, j] == pytest.approx(max(0.0, np.mean(each)), rel=1e-5)
            assert variances[i, j] == pytest.approx(np.var(each, ddof=1) / 5, rel=1e-4)


def test_samples_wait_in_the_last_state_and_start_in_the_first() -> None:
    symbols = symbols_of(4, [2, 3])
    still = MotionSymbols(
        symbols.n_states, symbols.self_loops, symbols.means, np.full_like(symbols.covars, 1e-12)
    )
    rng = np.random.default_rng(4)
    frames = sample_together(
        still, np.array([1, 0]), rng.random((6, 40)), rng.standard_normal((6, 40, 3))
    )
    np.testing.assert_allclose(frames[0, :, 0], np.tile(still.means[1, 0], (6, 1)), atol=1e-4)
    np.testing.assert_allclose(frames[0, :, -1], np.tile(still.means[1, 2], (6, 1)), atol=1e-4)
    np.testing.assert_allclose(frames[1, :, -1], np.tile(still.means[0, 1], (6, 1)), atol=1e-4)


def test_one_symbol() -> None:
    distances, variances = divergence(symbols_of(5, [3]), np.random.default_rng(5))
    assert distances.tolist() == variances.tolist() == [[0.0]]


def test_error_text() -> None:
    with pytest.raises(MotionDBError) as caught:
        divergence(symbols_of(6, [1]), np.random.default_rng(0), n_sequences=1)
    assert str(caught.value) == (
        "divergence: expected at least 2 sequences a symbol, found 1. "
        "One sequence has no variance: sample more."
    )
