"""Pooled statistics and the map from them to captions: by hand, and against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.meaning.resemblance import (
    POOLED_RIDGE,
    fit_pooled_map,
    pooled_statistics,
    statistics_of_intervals,
)
from motiondb.meaning.score_vectors import unit


def made_up(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    presence = rng.random((n, 4)) < 0.4
    presence[:, 0] |= ~presence.any(axis=1)
    return rng.normal(size=(n, 10)) * np.arange(1, 11), presence


@given(st.integers(1, 40), st.integers(1, 3), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_statistics_are_those_of_numpy(n_frames: int, n_dims: int, seed: int) -> None:
    frames = np.random.default_rng(seed).normal(size=(n_frames, n_dims)).astype(np.float32)
    exact = frames.astype(np.float64)
    expected = [exact.mean(axis=0), exact.std(axis=0)]
    expected += [np.quantile(exact, share, axis=0) for share in (0.1, 0.5, 0.9)]
    np.testing.assert_allclose(pooled_statistics(frames), np.concatenate(expected), atol=1e-12)


@given(st.lists(st.integers(1, 6), min_size=1, max_size=60), st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_statistics_of_many_intervals_are_those_of_each(lengths: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    intervals = [rng.normal(size=(length, 3)).astype(np.float32) for length in lengths]
    expected = np.stack([pooled_statistics(frames) for frames in intervals])
    np.testing.assert_allclose(statistics_of_intervals(intervals), expected, atol=1e-12)


def test_the_map_is_the_ridge_regression_of_captions_of_length_1() -> None:
    statistics, presence = made_up(30)
    fitted = fit_pooled_map(statistics, presence)
    p = unit((statistics - statistics.mean(axis=0)) / statistics.std(axis=0))
    t = presence / np.sqrt(presence.sum(axis=1, keepdims=True))
    p, t = p - p.mean(axis=0), t - t.mean(axis=0)
    weights = np.linalg.solve(p.T @ p + POOLED_RIDGE * np.eye(10), p.T @ t)
    np.testing.assert_allclose(fitted.weights, weights, atol=1e-9)
    np.testing.assert_allclose(fitted.evidence(statistics), p @ weights, atol=1e-9)
    np.testing.assert_allclose(fitted.evidence(statistics).mean(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("n", [1, 2])
def test_a_column_that_never_varies_counts_for_nothing(n: int) -> None:
    statistics = np.ones((n, 5))
    fitted = fit_pooled_map(statistics, np.ones((n, 2), dtype=bool))
    assert np.isfinite(fitted.evidence(statistics + 1.0)).all()
    assert fitted.evidence(statistics).tolist() == [[0.0, 0.0]] * n
