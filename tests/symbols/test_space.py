"""The symbol space: least stress, chosen dimensions, fixed pose."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.distance import pdist, squareform

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, MotionSymbols
from motiondb.symbols.space import (
    build_space,
    choose_dimensions,
    scale,
    smacof,
    turn_to_axes,
)


def uneven(seed: int, n_points: int) -> FloatArray:
    """Distances that no space fits."""
    rng = np.random.default_rng(seed)
    return squareform(rng.uniform(0.5, 3.0, n_points * (n_points - 1) // 2))


def stress_of(points: FloatArray, distances: FloatArray) -> float:
    wanted = squareform(distances)
    return float(np.sqrt(np.sum((pdist(points) - wanted) ** 2) / np.sum(wanted**2)))


def test_points_on_a_line_by_hand() -> None:
    distances = np.array([[0.0, 3, 1], [3, 0, 4], [1, 4, 0]])
    points, stress = scale(distances)
    np.testing.assert_allclose(points[:, 0], [-2 / 3, 7 / 3, -5 / 3], atol=1e-6)
    assert points.shape == (3, 1)
    np.testing.assert_allclose(stress, 0.0, atol=1e-6)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10**6), st.integers(4, 20), st.integers(1, 3))
def test_distances_between_points_come_back(seed: int, n_points: int, n_dims: int) -> None:
    truth = np.random.default_rng(seed).normal(0, 5, (n_points, n_dims))
    distances = squareform(pdist(truth))
    points, stress = scale(distances, n_dimensions=n_dims)
    np.testing.assert_allclose(squareform(pdist(points)), distances, atol=1e-4)
    assert stress[n_dims - 1] < 1e-5


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6), st.integers(2, 12))
def test_the_stress_curve_never_rises_and_is_the_stress(seed: int, n_points: int) -> None:
    distances = uneven(seed, n_points)
    points, stress = scale(distances)
    assert np.all(np.diff(stress) <= 1e-12)
    assert stress_of(points, distances) == pytest.approx(stress[points.shape[1] - 1], abs=1e-9)
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=1e-9)


def test_no_small_step_lowers_the_stress() -> None:
    distances = uneven(1, 9)
    points, _ = scale(distances, n_dimensions=2)
    actual, reached = smacof(distances, points, n_iterations=5000, tolerance=1e-12)
    better = minimize(lambda x: stress_of(x.reshape(9, 2), distances), actual.ravel())
    assert better.fun == pytest.approx(reached, abs=1e-5)


def test_order_and_mirroring_do_not_matter() -> None:
    """Shuffled symbols come out as the same points, shuffled; so two runs agree."""
    distances = uneven(2, 14)
    shuffled = np.random.default_rng(2).permutation(14)
    first, _ = scale(distances, n_dimensions=3)
    second, _ = scale(distances[np.ix_(shuffled, shuffled)], n_dimensions=3)
    np.testing.assert_allclose(second, first[shuffled], atol=1e-3)


def test_axes_are_principal_and_signed() -> None:
    rng = np.random.default_rng(3)
    points = turn_to_axes(rng.normal(0, [1.0, 5.0, 3.0], (30, 3)))
    covariance = points.T @ points
    np.testing.assert_allclose(covariance, np.diag(np.diag(covariance)), atol=1e-9)
    assert np.all(np.diff(np.diag(covariance)) < 0)
    assert np.all(points.max(axis=0) >= -points.min(axis=0))


def test_choice_of_dimensions() -> None:
    assert choose_dimensions(np.array([0.4, 0.3, 0.2, 0.185])) == 3
    assert choose_dimensions(np.array([0.4, 0.03, 0.0])) == 2
    assert choose_dimensions(np.array([0.4])) == 1
    assert choose_dimensions(np.array([0.0, 0.0])) == 1
    assert choose_dimensions(np.array([0.4, 0.3, 0.2])) == 3


def test_few_and_equal_symbols() -> None:
    for n_points in (1, 2, 3):
        points, stress = scale(np.zeros((n_points, n_points)))
        assert np.all(points == 0)
        assert points.shape == (n_points, 1)
        assert np.all(stress == 0)
    points, _ = scale(np.array([[0.0, 4.0], [4.0, 0.0]]))
    assert sorted(points[:, 0]) == pytest.approx([-2.0, 2.0])
    assert scale(uneven(4, 3), n_dimensions=5)[0].shape == (3, 5)


def test_a_symbol_far_from_all_others() -> None:
    distances = uneven(5, 10)
    distances[0, 1:] = distances[1:, 0] = 1e6
    points, stress = scale(distances)
    assert np.all(np.isfinite(points))
    assert np.all(np.isfinite(stress))


@pytest.mark.parametrize("n_symbols", [1, 2, 3, 24])
def test_build_space_is_whole_and_deterministic(n_symbols: int) -> None:
    rng = np.random.default_rng(6)
    centres = rng.normal(0, 4, (3, 1, 4))[np.arange(n_symbols) % 3]
    shape = (n_symbols, 2, 4)
    symbols = MotionSymbols(
        np.full(n_symbols, 2),
        np.full((n_symbols, 2), 0.8),
        centres + rng.normal(0, 0.3, shape),
        np.ones(shape),
    )
    first, second = (build_space(symbols, np.random.default_rng(7)) for _ in range(2))
    for name, value in vars(first).items():
        np.testing.assert_array_equal(value, getattr(second, name))
    n_clusters, n_dims = first.means.shape
    assert first.clusters.shape == (n_symbols,)
    assert first.coordinates.shape == (n_symbols, n_dims)
    assert first.covars.shape == (n_clusters, n_dims, n_dims)
    assert first.weights.sum() == pytest.approx(1.0)
    if n_symbols == 24:
        assert n_clusters == 3
        assert len(set(zip(first.clusters, np.arange(24) % 3))) == 3


def test_error_text() -> None:
    with pytest.raises(MotionDBError) as caught:
        scale(np.array([[0.0, 1.0], [2.0, 0.0]]))
    assert str(caught.value) == (
        "symbol space: expected finite, symmetric distances between at least one symbol, found "
        "shape (2, 2) or values that are not. Compute the distances anew."
    )
