"""The symbol space: least stress, chosen dimensions, fixed pose."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.distance import pdist, squareform
from threadpoolctl import threadpool_limits

from motiondb.records import FloatArray, MotionSymbols
from motiondb.symbols import hmm, space
from motiondb.symbols.space import (
    build_space,
    choose_dimensions,
    divergence,
    find_clusters,
    sample_together,
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
        assert points.tolist() == [[0.0]] * n_points
        assert np.all(stress == 0)
    points, _ = scale(np.array([[0.0, 4.0], [4.0, 0.0]]))
    assert sorted(points[:, 0]) == pytest.approx([-2.0, 2.0])
    assert scale(uneven(4, 3), n_dimensions=5)[0].shape == (3, 5)


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


def blobs(seed: int, centres: FloatArray, n_each: int) -> FloatArray:
    rng = np.random.default_rng(seed)
    return np.repeat(centres, n_each, axis=0) + rng.normal(0, 0.4, (len(centres) * n_each, 2))


CENTRES = np.array([[-6.0, 0.0], [0.0, 5.0], [4.0, -4.0], [9.0, 3.0]])


@pytest.mark.parametrize("n_blobs", [1, 2, 4])
def test_bic_finds_the_number(n_blobs: int) -> None:
    points = blobs(1, CENTRES[:n_blobs], 15)
    actual = find_clusters(points, np.random.default_rng(1))
    np.testing.assert_array_equal(actual.clusters, np.repeat(np.arange(n_blobs), 15))
    np.testing.assert_allclose(actual.means, CENTRES[:n_blobs], atol=0.4)
    np.testing.assert_allclose(actual.weights, 1 / n_blobs, atol=0.01)
    assert actual.covars.shape == (n_blobs, 2, 2)


SHAPES_TO_FIND = {
    "spherical": [[[0.2, 0.0], [0.0, 0.2]], [[1.4, 0.0], [0.0, 1.4]]],
    "diag": [[[2.0, 0.0], [0.0, 0.1]], [[0.1, 0.0], [0.0, 2.0]]],
    "tied": [[[2.0, 1.2], [1.2, 1.0]], [[2.0, 1.2], [1.2, 1.0]]],
    "full": [[[2.0, 1.8], [1.8, 2.0]], [[2.0, -1.8], [-1.8, 2.0]]],
}


@pytest.mark.parametrize("shape", SHAPES_TO_FIND)
def test_bic_finds_the_shape_that_made_the_points(shape: str) -> None:
    rng = np.random.default_rng(5)
    truth = np.array(SHAPES_TO_FIND[shape])
    parts = [rng.multivariate_normal([12.0 * n, 0.0], truth[n], 80) for n in range(2)]
    points = np.concatenate(parts)
    with threadpool_limits(1):
        tried = [space._best_of_shape(points, 3, s, 0.01, 0) for s in space.SHAPES]
    assert space.SHAPES[int(np.argmin([bic for bic, _ in tried]))] == shape
    actual = find_clusters(points, np.random.default_rng(5))
    np.testing.assert_array_equal(actual.clusters, np.repeat([0, 1], 80))
    spread = 0.03 * np.var(points, axis=0).mean() * np.eye(2)  # the floor that BIC may not see
    np.testing.assert_allclose(actual.covars - spread, truth, atol=0.7)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(1, 3))
def test_every_point_belongs_to_one_cluster_and_no_cluster_is_empty(
    seed: int, n_points: int, n_dims: int
) -> None:
    rng = np.random.default_rng(seed)
    points = rng.integers(-2, 3, (n_points, n_dims)).astype(float)  # with many that coincide
    actual = find_clusters(points, rng)
    assert actual.clusters.shape == (n_points,)
    np.testing.assert_array_equal(np.unique(actual.clusters), np.arange(len(actual.weights)))
    assert actual.weights.sum() == pytest.approx(1.0)
    assert np.all(np.diff(actual.means[:, 0]) >= 0)
    assert np.all(np.linalg.eigvalsh(actual.covars) > 0)


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
    waiting = space._waiting_at_the_end(symbols)
    rng = np.random.default_rng(3)
    uniforms, normals = rng.random((5, 7)), rng.standard_normal((5, 7, 3))
    samples = sample_together(waiting, np.arange(3), uniforms, normals)
    zero, seven = np.array([0]), np.array([7])

    def log_p(s: int, frames: FloatArray) -> float:
        return float(hmm.score(waiting, frames, zero, seven)[0, s])

    monkeypatch.setattr(space, "_VALUES_AT_ONCE", 1)
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
