"""The symbol space: points whose distances approximate those of the symbols.

Multidimensional scaling finds coordinates x_i that minimise the stress

    sqrt( sum_i<j (|x_i - x_j| - D_ij)^2 / sum_i<j D_ij^2 )

by majorisation (SMACOF): X <- B(X) X / S with B_ij = -D_ij / |x_i - x_j| off the diagonal and rows
that sum to 0. D is not a metric, so that in general no space fits it exactly. The iteration starts
from classical scaling and has no randomness. The result is rotated to its principal axes, largest
first, and every axis is signed so that its largest coordinate is positive: two runs agree.

Number of dimensions (``choose_dimensions``): the smallest one at which the stress is below 0.05, or
after which one more dimension lowers the stress by less than a twentieth of that of one dimension.

Source: Borg and Groenen, Modern Multidimensional Scaling, 2005, chapters 8 and 12.
"""

from __future__ import annotations

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import FloatArray, MotionSymbols, SymbolSpace
from motiondb.symbols.clusters import find_clusters
from motiondb.symbols.divergence import N_SEQUENCES, divergence

MAX_DIMENSIONS = 8  # Largest number of dimensions tried
GOOD_STRESS = 0.05  # Stress that Kruskal (1964) calls good
LEAST_GAIN = 0.05  # Least fall of the stress, in that of one dimension, for a further one


def build_space(
    symbols: MotionSymbols,
    rng: np.random.Generator,
    *,
    n_sequences: int = N_SEQUENCES,
    n_dimensions: int | None = None,
    n_clusters: int | None = None,
) -> SymbolSpace:
    """Distances, coordinates and clusters of symbols."""
    distances, variances = divergence(symbols, rng, n_sequences=n_sequences)
    coordinates, stress = scale(distances, n_dimensions=n_dimensions)
    clusters = find_clusters(coordinates, rng, n_clusters=n_clusters)
    return SymbolSpace(distances, variances, coordinates, stress, *clusters)


def scale(
    distances: FloatArray, *, n_dimensions: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Coordinates of least stress found by SMACOF.

    Shapes: `distances` (points, points); result (points, dimensions).
    """
    _check(distances)
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
    """Choose the number of dimensions by the rule of the module.

    Shapes: `stress` (tried dimensions,).

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
    """Principal coordinates: array (points, dimensions); exact for distances between points.

    Axes without a positive eigenvalue get a small spread, so that the majorisation can use them.

    Shapes: `distances` (points, points).
    """
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
    """Lower the stress by majorisation, from a start.

    Shapes: `distances` (points, points); `start`, result (points, dimensions).

    `tolerance`: The iteration ends where the stress falls by less than this share of itself.
    """
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

    Shapes: `points` (points, dimensions).

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


def _check(distances: FloatArray) -> None:
    square = distances.ndim == 2 and distances.shape[0] == distances.shape[1] > 0
    if not square or not np.all(np.isfinite(distances)) or not np.allclose(distances, distances.T):
        raise MotionDBError(
            "symbol space: expected finite, symmetric distances between at least one symbol, found "
            f"shape {distances.shape} or values that are not. Compute the distances anew."
        )
