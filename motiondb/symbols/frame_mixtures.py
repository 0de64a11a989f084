"""A model of one activity's frames: a mixture of diagonal Gaussians, fitted by k-means.

Notation: x_t the frames of a take, G those of one activity. k-means, started from frames far apart,
splits G into parts. Part p has the weight w_p = its share of G, the mean m_p, and the variance v_p
plus a share of the variance of the whole take, so that a part without movement keeps a finite
density. The surprise of a frame is its negative log-likelihood -log sum_p w_p N(x_t; m_p, v_p),
without the constant (D / 2) log 2 pi.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motiondb.records import FloatArray, IntArray

ROUNDS = 10  # Rounds of k-means at most. Chosen by hand; it usually ends earlier


def surprise(
    values: FloatArray,
    inside: NDArray[np.bool_],
    rng: np.random.Generator,
    n_parts: int,
    floor: float,
) -> FloatArray:
    """Negative log-likelihood of every frame under a mixture fitted to some: array (frames,), nats.

    Shapes: `values` (frames, dimensions); `inside` (frames,).

    `floor`: Share of the take's variance that is added to the variance of every component.
    """
    fitted = np.ascontiguousarray(values[inside])
    centres = fitted[far_apart(fitted, min(n_parts, len(fitted)), rng)]
    least = floor * values.var(axis=0) + 1e-9
    return np.asarray(_surprise(np.ascontiguousarray(values), fitted, centres, least))


def far_apart(values: FloatArray, n: int, rng: np.random.Generator) -> list[int]:
    """Numbers of n frames that are far from one another, drawn as k-means++ does.

    Shapes: `values` (frames, dimensions).
    """
    chosen = [int(rng.integers(len(values)))]
    distance = np.sum((values - values[chosen[0]]) ** 2, axis=1)
    while len(chosen) < n:
        total = distance.sum()
        shares = distance / total if total > 0 else np.full(len(values), 1.0 / len(values))
        chosen.append(int(rng.choice(len(values), p=shares)))
        distance = np.minimum(distance, np.sum((values - values[chosen[-1]]) ** 2, axis=1))
    return chosen


@njit(cache=True)
def _assign(fitted: FloatArray, centres: FloatArray) -> IntArray:
    """Nearest centre of every frame: array (frames,)."""
    nearest = np.zeros(len(fitted), np.int64)
    for t in range(len(fitted)):
        best = 1e300
        for p in range(len(centres)):
            distance = np.sum((fitted[t] - centres[p]) ** 2)
            if distance < best:
                best, nearest[t] = distance, p
    return nearest


@njit(cache=True)
def _partition(fitted: FloatArray, centres: FloatArray) -> IntArray:
    """k-means: the part of every frame; ``centres`` are moved in place."""
    n_parts, n_dims = centres.shape
    nearest = _assign(fitted, centres)
    count = np.zeros(n_parts)
    for _ in range(ROUNDS):
        sums = np.zeros((n_parts, n_dims))
        count[:] = 0.0
        for t in range(len(fitted)):
            count[nearest[t]] += 1.0
            sums[nearest[t]] += fitted[t]
        for p in range(n_parts):
            if count[p] > 0.0:
                centres[p] = sums[p] / count[p]
        assigned = _assign(fitted, centres)
        if (assigned == nearest).all():
            break
        nearest = assigned
    return nearest


@njit(cache=True)
def _surprise(
    values: FloatArray, fitted: FloatArray, centres: FloatArray, least: FloatArray
) -> FloatArray:
    """Negative log-likelihood of ``values`` under the mixture of ``fitted``: array (frames,)."""
    n_parts, n_dims = centres.shape
    nearest = _partition(fitted, centres)
    means, variances = np.zeros((n_parts, n_dims)), np.zeros((n_parts, n_dims))
    count = np.zeros(n_parts)
    for t in range(len(fitted)):
        count[nearest[t]] += 1.0
        means[nearest[t]] += fitted[t]
    for p in range(n_parts):
        means[p] /= max(count[p], 1.0)
    for t in range(len(fitted)):
        variances[nearest[t]] += (fitted[t] - means[nearest[t]]) ** 2
    heights = np.full(n_parts, -1e300)
    for p in range(n_parts):
        variances[p] = variances[p] / max(count[p], 1.0) + least
        if count[p] > 0.0:
            heights[p] = np.log(count[p] / len(fitted)) - 0.5 * np.sum(np.log(variances[p]))
    answer = np.empty(len(values))
    logs = np.empty(n_parts)
    for t in range(len(values)):
        for p in range(n_parts):
            logs[p] = heights[p] - 0.5 * np.sum((values[t] - means[p]) ** 2 / variances[p])
        highest = logs.max()
        answer[t] = -highest - np.log(np.sum(np.exp(logs - highest)))
    return answer
