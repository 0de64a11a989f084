"""Clusters of symbols: as many as there are, one for every symbol."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_limits

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray
from motiondb.symbols import space
from motiondb.symbols.space import find_clusters


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
        tried = [space._best_of_shape(points, range(1, 4), s, 0.01, 0) for s in space.SHAPES]
    assert space.SHAPES[int(np.argmin([bic for bic, _ in tried]))] == shape
    actual = find_clusters(points, np.random.default_rng(5))
    np.testing.assert_array_equal(actual.clusters, np.repeat([0, 1], 80))
    spread = 0.03 * np.var(points, axis=0).mean() * np.eye(2)  # the floor that BIC may not see
    np.testing.assert_allclose(actual.covars - spread, truth, atol=0.7)


@pytest.mark.parametrize("shape", space.SHAPES)
def test_covariances_of_every_shape_are_written_out_in_full(shape: str) -> None:
    points = blobs(6, CENTRES[:3], 12)
    mixture = space._fit_mixture(points, 3, shape, 0.01, 0)
    full = space._full_covars(mixture)
    assert full.shape == (3, 2, 2)
    for n in range(3):
        one = np.asarray(mixture.covariances_ if shape == "tied" else mixture.covariances_[n])
        expected = one if one.ndim == 2 else one * np.eye(2)
        np.testing.assert_array_equal(full[n], expected)


def test_shapes_are_weighed_by_their_parameters() -> None:
    """One component in 2 dimensions: 3, 4, 5 and 5 parameters, of ln n each, beside -2 log L."""
    points = np.random.default_rng(7).normal(0, 1, (50, 2))
    for shape, n_parameters in zip(("spherical", "diag", "tied", "full"), (3, 4, 5, 5)):
        mixture = space._fit_mixture(points, 1, shape, 1e-6, 0)
        likelihood = -2 * mixture.score_samples(points).sum()
        assert mixture.bic(points) == pytest.approx(
            likelihood + n_parameters * np.log(50), abs=1e-3
        )


def test_a_given_number_overrides() -> None:
    points = blobs(2, CENTRES, 10)
    actual = find_clusters(points, np.random.default_rng(2), n_clusters=2)
    assert len(actual.weights) == 2


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


def test_the_same_seed_gives_the_same_clusters() -> None:
    points = np.random.default_rng(3).normal(0, 1, (40, 2))
    first, second = (find_clusters(points, np.random.default_rng(4)) for _ in range(2))
    for a, b in zip(first, second):
        np.testing.assert_array_equal(a, b)


def test_error_texts() -> None:
    with pytest.raises(MotionDBError) as caught:
        find_clusters(np.zeros((3, 2)), np.random.default_rng(0), n_clusters=4)
    assert str(caught.value) == (
        "clusters: expected a number from 1 to 3 (the symbols), found 4. "
        "Ask for fewer clusters, or leave the number to motiondb."
    )
    with pytest.raises(MotionDBError) as caught:
        find_clusters(np.zeros((0, 2)), np.random.default_rng(0))
    assert str(caught.value) == "clusters: expected at least one symbol, found none. Learn first."
