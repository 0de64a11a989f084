"""The symbol space: distances between symbols, points at such distances, and clusters of them.

Distances are a symmetric Kullback-Leibler rate, estimated by Monte Carlo. With y_in the n-th of N
sequences of T frames sampled from symbol i,

    d_n(i, j) = 1 / 2T [ log P_i(y_in) - log P_j(y_in) + log P_j(y_jn) - log P_i(y_jn) ]
    D(i, j)   = max(0, mean_n d_n(i, j)),   variance = var_n d_n(i, j) / N,   D(i, i) = 0.

A symbol that has reached its last state stays there, so that every P is a density over sequences of
T frames; then the expectation of d_n is not negative, and a negative estimate is set to 0. All
symbols share their random numbers: sequence n of every symbol has the same uniforms for its
transitions and the same normals for its frames. That lowers the variance of the differences.
Symbols of one state have D = symmetric divergence of their Gaussians.

Coordinates. Multidimensional scaling finds points x_i that minimise the stress

    sqrt( sum_i<j (|x_i - x_j| - D_ij)^2 / sum_i<j D_ij^2 )

by majorisation (SMACOF): X <- B(X) X / S with B_ij = -D_ij / |x_i - x_j| off the diagonal and rows
that sum to 0. D is not a metric, so that in general no space fits it exactly. The iteration starts
from classical scaling and has no randomness. The result is rotated to its principal axes, largest
first, and every axis is signed so that its largest coordinate is positive: two runs agree.

Number of dimensions (``choose_dimensions``): the smallest one at which the stress is below 0.05, or
after which one more dimension lowers the stress by less than a twentieth of that of one dimension.

Clusters come from a Gaussian mixture, its size and shape chosen by BIC = -2 log L + parameters
ln(points). Mixtures of 1, 2, ... components are fitted with spherical,
diagonal, tied (one covariance for all) and full covariances, because full covariances need many
points. The mixture of lowest BIC is taken, among equals the first; mixtures with a component that
holds a single point are taken only if there is no other. Each point belongs to its most probable
component; components without points are left out. Clusters are numbered along the first axis.

Source: Juang and Rabiner, A probabilistic distance measure for hidden Markov models, 1985; paper A
prints it with one sequence; Borg and Groenen, Modern Multidimensional Scaling, 2005, chapters 8 and
12; Fraley and Raftery, Model-based clustering, 2002; Schwarz, 1978.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from motiondb.records import FloatArray, IntArray, MotionSymbols, SymbolSpace
from motiondb.symbols import hmm

if TYPE_CHECKING:
    from sklearn.mixture import GaussianMixture

N_SEQUENCES = 32
"""Sequences a symbol; the variance of every distance is stored beside it."""
_LONGEST = 60  # frames, 4 s: a self-loop near 1 would ask for endless sequences.
_VALUES_AT_ONCE = 2_000_000  # 16 MB of samples: bounds memory, changes no result

MAX_DIMENSIONS = 8  # Largest number of dimensions tried
GOOD_STRESS = 0.05  # Stress that Kruskal (1964) calls good
LEAST_GAIN = 0.05  # Least fall of the stress, in that of one dimension, for a further one

MAX_CLUSTERS = 20  # More groups of symbols would not be read
SHAPES = ("spherical", "diag", "tied", "full")
_POINTS_A_CLUSTER = 3  # least mean number: fewer points do not determine a covariance.
_SINGLE_POINT_PENALTY = 1e9  # added to the BIC of a mixture with a component of one point
_PATIENCE = 4  # the search ends after so many sizes in a row that do not lower the BIC.
_RELATIVE_FLOOR = 0.03  # least variance, share of the coordinates' mean variance.


def build_space(symbols: MotionSymbols, rng: np.random.Generator) -> SymbolSpace:
    """Distances, coordinates and clusters of symbols."""
    distances, variances = divergence(symbols, rng)
    coordinates, stress = scale(distances)
    clusters = find_clusters(coordinates, rng)
    return SymbolSpace(distances, variances, coordinates, stress, *clusters)


def divergence(
    symbols: MotionSymbols,
    rng: np.random.Generator,
    *,
    n_sequences: int = N_SEQUENCES,
    n_frames: int | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Distances and variances (symbols, symbols); T is the typical duration if not given."""
    waiting = _waiting_at_the_end(symbols)
    n_frames = n_frames or typical_duration(symbols)
    n_symbols, _, n_dims = symbols.means.shape
    uniforms = rng.random((n_sequences, n_frames))
    normals = rng.standard_normal((n_sequences, n_frames, n_dims))
    losses = np.empty((n_symbols, n_sequences, n_symbols))
    width = max(1, _VALUES_AT_ONCE // normals.size)
    for first in range(0, n_symbols, width):
        some = np.arange(first, min(first + width, n_symbols))
        frames = sample_together(waiting, some, uniforms, normals).reshape(-1, n_dims)
        starts = np.arange(0, len(frames), n_frames)
        totals = hmm.score(waiting, frames, starts, starts + n_frames).astype(np.float64)
        totals = totals.reshape(len(some), n_sequences, n_symbols)
        true = totals[np.arange(len(some)), :, some]
        losses[some] = (true[:, :, None] - totals) / n_frames
    both = 0.5 * (losses.transpose(1, 0, 2) + losses.transpose(1, 2, 0))
    distances = np.maximum(both.mean(axis=0), 0.0)
    variances = both.var(axis=0, ddof=1) / n_sequences
    np.fill_diagonal(distances, 0.0)
    np.fill_diagonal(variances, 0.0)
    return distances, variances


def typical_duration(symbols: MotionSymbols) -> int:
    """Mean expected duration of the symbols in frames, at most 60 for each of them.

    >>> s = MotionSymbols(np.array([2]), np.array([[0.9, 0.5]]), *[np.ones((1, 2, 1))] * 2)
    >>> typical_duration(s)  # 10 + 2 frames
    12
    """
    real = np.arange(symbols.self_loops.shape[1]) < symbols.n_states[:, None]
    stays = np.where(real, 1.0 / np.maximum(1.0 - symbols.self_loops, 1.0 / _LONGEST), 0.0)
    mean = float(np.mean(np.minimum(stays.sum(axis=1), _LONGEST)))
    return max(round(mean), int(symbols.n_states.max()))


def sample_together(
    symbols: MotionSymbols, chosen: IntArray, uniforms: FloatArray, normals: FloatArray
) -> FloatArray:
    """Sequences (chosen, sequences, frames, dimensions) from the same random numbers."""
    rows = chosen[:, None]
    state = np.zeros((len(chosen), len(uniforms)), dtype=np.int64)
    frames = np.empty((len(chosen), *normals.shape))
    for t in range(normals.shape[1]):
        frames[:, :, t] = symbols.means[rows, state]
        frames[:, :, t] += np.sqrt(symbols.covars[rows, state]) * normals[:, t]
        moves = uniforms[:, t] >= symbols.self_loops[rows, state]
        state = np.minimum(state + moves, symbols.n_states[rows] - 1)
    return frames


def _waiting_at_the_end(symbols: MotionSymbols) -> MotionSymbols:
    loops = symbols.self_loops.copy()
    loops[np.arange(symbols.n_symbols), symbols.n_states - 1] = 1.0
    return MotionSymbols(symbols.n_states, loops, symbols.means, symbols.covars)


class Clusters(NamedTuple):
    """A Gaussian mixture and the component of every point."""

    clusters: IntArray  # (points,): component of each point
    weights: FloatArray  # (clusters,): weights of the components; they sum to 1
    means: FloatArray  # (clusters, dimensions): means of the components
    covars: FloatArray  # (clusters, dimensions, dimensions): covariances of the components


def find_clusters(coordinates: FloatArray, rng: np.random.Generator) -> Clusters:
    """Cluster points (points, dimensions) by the Gaussian mixture of lowest BIC."""
    n_points = len(coordinates)
    distinct = len(np.unique(coordinates.round(9), axis=0))
    most = min(max(1, n_points // _POINTS_A_CLUSTER), MAX_CLUSTERS, distinct)
    floor = max(_RELATIVE_FLOOR * float(np.mean(np.var(coordinates, axis=0))), 1e-9)
    seed = int(rng.integers(2**31))
    if distinct == 1:
        n_dims = coordinates.shape[1]
        spread = floor * np.eye(n_dims)[None]
        labels = np.zeros(n_points, dtype=np.int64)
        return Clusters(labels, np.ones(1), coordinates[:1].copy(), spread)
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # on matrices of this size a second thread costs more than it saves
        families = [_best_of_shape(coordinates, most, shape, floor, seed) for shape in SHAPES]
    return _in_order(min(families, key=lambda pair: pair[0])[1], coordinates)


def _best_of_shape(
    coordinates: FloatArray, most: int, shape: str, floor: float, seed: int
) -> tuple[float, GaussianMixture]:
    """Lowest BIC and its mixture; the search ends after a few sizes in a row without progress."""
    tried: list[tuple[float, GaussianMixture]] = []
    for size in range(1, most + 1):
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


def scale(
    distances: FloatArray, *, n_dimensions: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Coordinates (points, dimensions) of least stress found by SMACOF, and all stresses."""
    n_tried = max(1, min(len(distances) - 1, MAX_DIMENSIONS))
    n_tried = max(n_tried, n_dimensions or 1)
    start = classical_scaling(distances, n_tried)
    solutions: list[FloatArray] = []
    stress = np.empty(n_tried)
    for p in range(1, n_tried + 1):
        points, stress[p - 1] = smacof(distances, start[:, :p])
        if p > 1 and stress[p - 1] > stress[p - 2]:
            points, stress[p - 1] = smacof(distances, np.c_[solutions[-1], start[:, p - 1]])
        if p > 1 and stress[p - 1] > stress[p - 2]:
            points, stress[p - 1] = np.c_[solutions[-1], np.zeros(len(points))], stress[p - 2]
        solutions.append(points)
    chosen = n_dimensions or choose_dimensions(stress)
    return turn_to_axes(solutions[chosen - 1]), stress


def choose_dimensions(stress: FloatArray) -> int:
    """Choose the number of dimensions by stress (dimensions,) and the module's rule.

    >>> choose_dimensions(np.array([0.5, 0.2, 0.19, 0.18]))
    2
    >>> choose_dimensions(np.array([0.04, 0.03]))
    1
    """
    for p in range(1, len(stress)):
        gain = stress[p - 1] - stress[p]
        if stress[p - 1] < GOOD_STRESS or gain < LEAST_GAIN * stress[0]:
            return p
    return len(stress)


def classical_scaling(distances: FloatArray, n_dimensions: int) -> FloatArray:
    """Principal coordinates (points, dimensions); empty axes get a small spread for SMACOF."""
    n_points = len(distances)
    centring = np.eye(n_points) - 1.0 / n_points
    values, vectors = np.linalg.eigh(-0.5 * centring @ distances**2 @ centring)
    values, vectors = values[::-1][:n_dimensions], vectors[:, ::-1][:, :n_dimensions]
    least = 1e-6 * max(float(values[0]), 0.0)
    missing = np.zeros((n_points, n_dimensions - len(values)))
    return np.c_[vectors * np.sqrt(np.maximum(values, least)), missing]


def smacof(
    distances: FloatArray, start: FloatArray, *, n_iterations: int = 500, tolerance: float = 1e-6
) -> tuple[FloatArray, float]:
    """Lower the stress from a start, until it falls by less than a share of itself."""
    total = float(np.sum(distances**2))
    if total == 0.0:
        return np.zeros_like(start), 0.0
    points, stress = start, np.inf
    for _ in range(n_iterations):
        between = _distances(points)
        previous, stress = stress, float(np.sqrt(np.sum((between - distances) ** 2) / total))
        if previous - stress < tolerance * previous and np.isfinite(previous):
            break
        ratio = np.divide(distances, between, out=np.zeros_like(between), where=between > 1e-12)
        points = (ratio.sum(axis=1)[:, None] * points - ratio @ points) / len(points)
    return points, float(np.sqrt(np.sum((_distances(points) - distances) ** 2) / total))


def turn_to_axes(points: FloatArray) -> FloatArray:
    """Centre points, rotate them to their principal axes and fix the signs.

    >>> turn_to_axes(np.array([[0.0, 1.0], [0.0, 4.0], [0.0, 1.0]])).round(3) + 0.0
    array([[-1.,  0.],
           [ 2.,  0.],
           [-1.,  0.]])
    """
    centred = points - points.mean(axis=0)
    axes = np.linalg.svd(centred, full_matrices=True)[2]
    turned = centred @ axes.T
    largest = np.argmax(np.abs(turned).round(9), axis=0)
    signs = np.where(turned[largest, np.arange(turned.shape[1])] < 0, -1.0, 1.0)
    return turned * signs


def _distances(points: FloatArray) -> FloatArray:
    squares = np.sum(points**2, axis=1)
    between = np.sqrt(np.maximum(squares[:, None] + squares - 2 * points @ points.T, 0.0))
    np.fill_diagonal(between, 0.0)
    return between
