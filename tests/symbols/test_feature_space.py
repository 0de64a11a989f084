"""The whitened space: uncorrelated, of like size, the same however often it is fitted."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.records import Float32Array
from motiondb.symbols.feature_space import fit_feature_space


def correlated(seed: int, n_frames: int = 400, n_values: int = 8) -> Float32Array:
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(n_values, n_values)) * np.linspace(3, 0.3, n_values)[:, None]
    return (rng.normal(size=(n_frames, n_values)) @ mixing + 5.0).astype(np.float32)


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_projections_are_white(seed: int, n_dimensions: int) -> None:
    values = correlated(seed)
    space = fit_feature_space([values[:150], values[150:]], n_dimensions)
    actual = space.project(values)
    assert actual.dtype == np.float32
    np.testing.assert_allclose(actual.mean(axis=0), 0.0, atol=1e-3)
    np.testing.assert_allclose(np.cov(actual.T, bias=True), np.eye(n_dimensions), atol=0.01)


def test_axes_are_those_of_a_singular_value_decomposition() -> None:
    values = correlated(3)
    space = fit_feature_space([values], 4)
    centred = values.astype(np.float64) - values.mean(axis=0, dtype=np.float64)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    expected = axes[:4].T / (sizes[:4] / np.sqrt(len(values)))
    signs = np.sign(np.sum(space.projection * expected, axis=0))
    np.testing.assert_allclose(space.projection * signs, expected, atol=1e-5)
    largest = np.argmax(np.abs(space.projection), axis=0)
    assert np.all(space.projection[largest, np.arange(4)] > 0)


def test_an_endless_take_does_not_decide_the_space() -> None:
    """Its weight is that of 900 frames."""
    short, endless = correlated(1, 900), np.tile(correlated(2, 900), (10, 1))
    one = fit_feature_space([short, endless], 4)
    other = fit_feature_space([short, endless[:900]], 4)
    np.testing.assert_allclose(one.mean, other.mean, rtol=1e-6)
    np.testing.assert_allclose(one.projection, other.projection, atol=1e-6)


def test_outliers_are_clipped() -> None:
    space = fit_feature_space([correlated(4)], 3)
    wild = space.project(np.full((1, 8), 1e6, dtype=np.float32))
    assert np.abs(wild).max() <= 8.0


def test_one_frame_and_none_give_a_space_that_works() -> None:
    one = fit_feature_space([np.ones((1, 8), dtype=np.float32)], 3)
    np.testing.assert_array_equal(one.project(np.full((2, 8), 0.5, dtype=np.float32)), 0.5)
    assert fit_feature_space([], 3).projection.shape == (0, 0)
    still = fit_feature_space([np.ones((50, 8), dtype=np.float32)], 3)
    assert np.isfinite(still.project(np.ones((2, 8), dtype=np.float32))).all()
