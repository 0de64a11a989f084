"""Clusters of symbols: a Gaussian mixture in the symbol space, its size and shape chosen by BIC.

BIC = -2 log L + parameters ln(points). Mixtures of 1, 2, ... components are fitted with spherical,
diagonal, tied (one covariance for all) and full covariances, because full covariances need many
points. The mixture of lowest BIC is taken, among equals the first; mixtures with a component that
holds a single point are taken only if there is no other. Each point belongs to its most probable
component; components without points are left out. Clusters are numbered along the first axis.

Source: Fraley and Raftery, Model-based clustering, 2002; Schwarz, 1978.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, IntArray

if TYPE_CHECKING:
    from sklearn.mixture import GaussianMixture

MAX_CLUSTERS = 20  # Chosen by hand: more groups of symbols would not be read
SHAPES = ("spherical", "diag", "tied", "full")
_POINTS_A_CLUSTER = 3  # least mean number: fewer points do not determine a covariance. By hand.
_SINGLE_POINT_PENALTY = 1e9  # added to the BIC of a mixture with a component of one point
_PATIENCE = 4  # the search ends after so many sizes in a row that do not lower the BIC. By hand.
_RELATIVE_FLOOR = 0.03  # least variance, share of the coordinates' mean variance. By hand.


class Clusters(NamedTuple):
    """A Gaussian mixture and the component of every point."""

    clusters: IntArray  # (points,): component of each point
    weights: FloatArray  # (clusters,): weights of the components; they sum to 1
    means: FloatArray  # (clusters, dimensions): means of the components
    covars: FloatArray  # (clusters, dimensions, dimensions): covariances of the components


def find_clusters(
    coordinates: FloatArray, rng: np.random.Generator, *, n_clusters: int | None = None
) -> Clusters:
    """Cluster points by a Gaussian mixture.

    Shapes: `coordinates` (points, dimensions).

    `n_clusters`: Number of clusters. None: chosen by BIC, at most a third of the points and at most
    20. Where points coincide or components stay empty, there are fewer clusters than given.
    """
    n_points = len(coordinates)
    if n_points == 0:
        raise MotionDBError("clusters: expected at least one symbol, found none. Learn first.")
    if n_clusters is not None and not 1 <= n_clusters <= n_points:
        raise MotionDBError(
            f"clusters: expected a number from 1 to {n_points} (the symbols), found {n_clusters}. "
            "Ask for fewer clusters, or leave the number to motiondb."
        )
    distinct = len(np.unique(coordinates.round(9), axis=0))
    most = min(max(1, n_points // _POINTS_A_CLUSTER), MAX_CLUSTERS, distinct)
    sizes = range(1, most + 1) if n_clusters is None else [min(n_clusters, distinct)]
    floor = max(_RELATIVE_FLOOR * float(np.mean(np.var(coordinates, axis=0))), 1e-9)
    seed = int(rng.integers(2**31))
    if distinct == 1:
        n_dims = coordinates.shape[1]
        spread = floor * np.eye(n_dims)[None]
        labels = np.zeros(n_points, dtype=np.int64)
        return Clusters(labels, np.ones(1), coordinates[:1].copy(), spread)
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # on matrices of this size a second thread costs more than it saves
        families = [_best_of_shape(coordinates, sizes, shape, floor, seed) for shape in SHAPES]
    return _in_order(min(families, key=lambda pair: pair[0])[1], coordinates)


def _best_of_shape(
    coordinates: FloatArray, sizes: Iterable[int], shape: str, floor: float, seed: int
) -> tuple[float, GaussianMixture]:
    """Lowest BIC and its mixture; the search ends after a few sizes in a row without progress."""
    tried: list[tuple[float, GaussianMixture]] = []
    for size in sizes:
        mixture = _fit_mixture(coordinates, size, shape, floor, seed)
        bic = float(mixture.bic(coordinates))
        if size > 1 and 1 in np.bincount(mixture.predict(coordinates)):
            bic += _SINGLE_POINT_PENALTY
        tried.append((bic, mixture))
        if len(tried) - int(np.argmin([bic for bic, _ in tried])) > _PATIENCE:
            break
    return min(tried, key=lambda pair: pair[0])


def _fit_mixture(
    coordinates: FloatArray, size: int, shape: str, floor: float, seed: int
) -> GaussianMixture:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.mixture import GaussianMixture

    # k-means++ starts from single points, so that a tied covariance would start far too wide
    mixture = GaussianMixture(
        size,
        covariance_type=shape,
        reg_covar=floor,
        n_init=4,
        max_iter=300,
        init_params="kmeans" if shape == "tied" else "k-means++",
        random_state=seed,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # the BIC decides
        return mixture.fit(coordinates)


def _in_order(mixture: GaussianMixture, coordinates: FloatArray) -> Clusters:
    """Components with points, ordered along the first axis, with weights that sum to 1."""
    labels = mixture.predict(coordinates)
    alive = np.unique(labels)
    alive = alive[np.lexsort(mixture.means_[alive].T[::-1])]
    number = np.empty(len(mixture.weights_), dtype=np.int64)
    number[alive] = np.arange(len(alive))
    weights, means = mixture.weights_[alive], mixture.means_[alive]
    return Clusters(number[labels], weights / weights.sum(), means, _full_covars(mixture)[alive])


def _full_covars(mixture: GaussianMixture) -> FloatArray:
    """Covariances of all components, whatever their shape: array (components, d, d)."""
    n_components, n_dims = mixture.means_.shape
    covars = np.asarray(mixture.covariances_)
    if mixture.covariance_type == "tied":
        return np.repeat(covars[None], n_components, axis=0)
    if mixture.covariance_type == "full":
        return covars
    return covars.reshape(n_components, -1, 1) * np.eye(n_dims)
