"""What one activity looks like, frame by frame: a mixture of diagonal Gaussians, fitted by k-means.

Notation: x_t the frames, G those of one activity. k-means with far-apart starts splits G into
parts; part p has the share w_p of G, its mean m_p, and its variance v_p plus a share of the
variance of the whole take, so that a still part does not become infinitely sharp. The surprise of
a frame is -log sum_p w_p N(x_t; m_p, v_p), less the constant (D / 2) log 2 pi.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motiondb.records import FloatArray, IntArray

ROUNDS = 10
"""Of k-means."""


def surprise(
    values: FloatArray,
    inside: NDArray[np.bool_],
    rng: np.random.Generator,
    n_parts: int,
    floor: float,
) -> FloatArray:
    """-log density of every frame under the mixture of some of them: array (frames,), nats.

    Parameters
    ----------
    values : array (frames, dimensions). inside : array (frames,), the frames fitted, at least one.
    n_parts : of the mixture, at most. floor : share of the take's variance added to every part's.
    """
    own = np.ascontiguousarray(values[inside])
    centres = own[far_apart(own, min(n_parts, len(own)), rng)]
    least = floor * values.var(axis=0) + 1e-9
    return np.asarray(_surprise(np.ascontiguousarray(values), own, centres, least))


def far_apart(values: FloatArray, n: int, rng: np.random.Generator) -> list[int]:
    """Frames far from one another (k-means++)."""
    chosen = [int(rng.integers(len(values)))]
    distance = np.sum((values - values[chosen[0]]) ** 2, axis=1)
    while len(chosen) < n:
        total = distance.sum()
        shares = distance / total if total > 0 else np.full(len(values), 1.0 / len(values))
        chosen.append(int(rng.choice(len(values), p=shares)))
        distance = np.minimum(distance, np.sum((values - values[chosen[-1]]) ** 2, axis=1))
    return chosen


@njit(cache=True)
def _assign(own: FloatArray, centres: FloatArray) -> IntArray:
    nearest = np.zeros(len(own), np.int64)
    for t in range(len(own)):
        best = 1e300
        for p in range(len(centres)):
            distance = np.sum((own[t] - centres[p]) ** 2)
            if distance < best:
                best, nearest[t] = distance, p
    return nearest


@njit(cache=True)
def _surprise(values, own, centres, least):  # type: ignore[no-untyped-def]
    n_parts, n_dims = centres.shape
    nearest = _assign(own, centres)
    count = np.zeros(n_parts)
    for _ in range(ROUNDS):
        sums = np.zeros((n_parts, n_dims))
        count[:] = 0.0
        for t in range(len(own)):
            count[nearest[t]] += 1.0
            sums[nearest[t]] += own[t]
        for p in range(n_parts):
            if count[p] > 0.0:
                centres[p] = sums[p] / count[p]
        found = _assign(own, centres)
        if (found == nearest).all():
            break
        nearest = found
    means, variances = np.zeros((n_parts, n_dims)), np.zeros((n_parts, n_dims))
    count[:] = 0.0
    for t in range(len(own)):
        count[nearest[t]] += 1.0
        means[nearest[t]] += own[t]
    for p in range(n_parts):
        means[p] /= max(count[p], 1.0)
    for t in range(len(own)):
        variances[nearest[t]] += (own[t] - means[nearest[t]]) ** 2
    heights = np.full(n_parts, -1e300)
    for p in range(n_parts):
        variances[p] = variances[p] / max(count[p], 1.0) + least
        if count[p] > 0.0:
            heights[p] = np.log(count[p] / len(own)) - 0.5 * np.sum(np.log(variances[p]))
    answer = np.empty(len(values))
    logs = np.empty(n_parts)
    for t in range(len(values)):
        for p in range(n_parts):
            logs[p] = heights[p] - 0.5 * np.sum((values[t] - means[p]) ** 2 / variances[p])
        highest = logs.max()
        answer[t] = -highest - np.log(np.sum(np.exp(logs - highest)))
    return answer
