"""What anyone could put together in an afternoon from scikit-learn and dynamic time warping.

Pooled features: mean, spread and quantiles of the whitened features over a capture (or a window),
standardised over all captures, rows scaled to length 1 where a cosine or a ridge is meant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from motiondb.meaning.score_vectors import unit
from motiondb.records import Float32Array, FloatArray
from quality_protocol.kept import kept

Words = NDArray[np.bool_]
QUANTILES = (0.1, 0.5, 0.9)
"""Quantiles of the features over time. Chosen by hand; not tuned."""
WINDOW = 45
"""Feature frames (3 s) of the windows."""


def pooled(captures: Sequence[Float32Array]) -> FloatArray:
    """Mean, spread, quantiles: array (captures, 5 * dimensions), standardised columns."""
    rows = np.array([_statistics(x) for x in captures])
    return (rows - rows.mean(axis=0)) / (rows.std(axis=0) + 1e-9)


def windows(captures: Sequence[Float32Array]) -> tuple[FloatArray, NDArray[np.int64]]:
    """Pooled features of windows with half overlap, and whose they are."""
    rows, owner = [], []
    for number, x in enumerate(captures):
        for low in range(0, max(len(x) - WINDOW, 0) + 1, WINDOW // 2):
            rows.append(_statistics(x[low : low + WINDOW]))
            owner.append(number)
    array = np.array(rows)
    return (array - array.mean(axis=0)) / (array.std(axis=0) + 1e-9), np.array(owner)


def logistic(train: FloatArray, words: Words, test: FloatArray, strength: float) -> FloatArray:
    """One-vs-rest log-odds (test, words); a word never seen in training gets -20."""
    from sklearn.linear_model import LogisticRegression

    odds = np.full((len(test), words.shape[1]), -20.0)
    for word in np.flatnonzero(words.any(axis=0)):
        if words[:, word].all():
            odds[:, word] = 20.0
            continue
        model = LogisticRegression(C=strength, solver="liblinear")
        odds[:, word] = model.fit(train, words[:, word]).decision_function(test)
    return odds


def ridge(train: FloatArray, target: FloatArray, test: FloatArray, strength: float) -> FloatArray:
    """Centred ridge regression by its dual."""
    mean_x, mean_y = train.mean(axis=0), target.mean(axis=0)
    x = train - mean_x
    weights = np.linalg.solve(x @ x.T + strength * np.eye(len(x)), target - mean_y)
    return (test - mean_x) @ x.T @ weights + mean_y


def canonical(
    train: FloatArray, target: FloatArray, test: FloatArray, n_axes: int
) -> tuple[FloatArray, FloatArray]:
    """Canonical correlation analysis: captures (test, axes) and words (words, axes) as rows of
    length 1 in the space of the ``n_axes`` most correlated directions of features and TF-IDF.

    Both sides are whitened with as much of the unit matrix as their mean variance is, for there are
    more columns than captures (a tenth of it gives 0.34 in place of 0.42 mean average precision).
    """
    mean_x, mean_y = train.mean(axis=0), target.mean(axis=0)
    x, y = train - mean_x, target - mean_y
    to_x, to_y = _whitening(x), _whitening(y)
    left, shared, right = np.linalg.svd((x @ to_x).T @ (y @ to_y), full_matrices=False)
    weights = np.sqrt(shared[:n_axes])
    captures = (test - mean_x) @ to_x @ left[:, :n_axes] * weights
    words = to_y @ right[:n_axes].T * weights
    return unit(captures), unit(words)


def _whitening(rows: FloatArray) -> FloatArray:
    _, sizes, axes = np.linalg.svd(rows, full_matrices=False)
    kept = sizes > 1e-9 * sizes[0]
    sizes, axes = sizes[kept], axes[kept]
    return np.asarray(axes.T / np.sqrt(sizes**2 + float(np.mean(sizes**2))))


def tf_idf(words: Words) -> tuple[FloatArray, FloatArray]:
    """TF-IDF rows of length 1, and the inverse document frequencies."""
    idf = np.log((1.0 + len(words)) / (1.0 + words.sum(axis=0)))
    return unit(words * idf), idf


def neighbours(similarity: FloatArray, target: FloatArray, n_nearest: int) -> FloatArray:
    """Mean target of the nearest captures: array (test, words)."""
    nearest = np.argsort(-similarity, axis=1, kind="stable")[:, :n_nearest]
    return target[nearest].mean(axis=1)


def warping_distances(captures: Sequence[Float32Array]) -> FloatArray:
    """Dynamic time warping between all pairs: mean distance along the path; kept on disk."""
    frames = np.concatenate(captures).astype(np.float32)
    bounds = np.cumsum([0, *(len(x) for x in captures)])
    return kept("warped", [frames, bounds], lambda: _warp_all(frames, bounds))


def warping_row(query: Float32Array, captures: Sequence[Float32Array]) -> FloatArray:
    """Distances of one query to all captures, on one core; for its time."""
    return np.array([_warp(query, x) for x in captures])


def _statistics(x: Float32Array) -> FloatArray:
    quantiles = np.quantile(x, QUANTILES, axis=0).ravel()
    return np.concatenate([x.mean(axis=0), x.std(axis=0), quantiles])


@njit(cache=True, fastmath=True)
def _warp(a: Float32Array, b: Float32Array) -> float:
    far = np.float32(1e30)
    cost = np.full(len(b) + 1, far)
    steps = np.zeros(len(b) + 1, np.int64)
    cost[0] = 0.0
    for i in range(len(a)):
        row = np.full(len(b) + 1, far)
        count = np.zeros(len(b) + 1, np.int64)
        for j in range(len(b)):
            total = np.float32(0.0)
            for d in range(a.shape[1]):
                gap = a[i, d] - b[j, d]
                total += gap * gap
            best, n = cost[j], steps[j]
            if cost[j + 1] < best:
                best, n = cost[j + 1], steps[j + 1]
            if row[j] < best:
                best, n = row[j], count[j]
            row[j + 1], count[j + 1] = best + np.sqrt(total), n + 1
        cost, steps = row, count
    return cost[-1] / steps[-1]


@njit(cache=True, parallel=True)
def _warp_all(frames: Float32Array, bounds: NDArray[np.int64]) -> FloatArray:
    n = len(bounds) - 1
    distances = np.zeros((n, n))
    for i in prange(n):
        for j in range(i + 1, n):
            distances[i, j] = _warp(
                frames[bounds[i] : bounds[i + 1]], frames[bounds[j] : bounds[j + 1]]
            )
    return distances + distances.T
