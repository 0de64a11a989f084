"""Groups of segments around medoids, by the swap search.

Given distances between n things, choose K of them (medoids) so that

    E = sum_m price_m + sum_i weight_i D(i, nearest medoid)

is small. The first K things are the medoids to begin with, so that the answer depends on the
segmentation alone. Things are tried in turn as medoids: for every one the gain of putting it in
the place of each medoid is found for all K at once in O(n) from the nearest and second nearest
medoid of every thing, and the best swap is made at once if it lowers E. The search ends after a
whole round without a swap: no single swap lowers E then. Every medoid is in its own group, so no
group is empty, even where things coincide. Ties go to the lowest number.

With weights L(s_i) and prices, E is 1 / F (``objective``), and the groups are those of largest F.

Source: L. Kaufman and P. J. Rousseeuw, Finding Groups in Data (1990), chapter 2; E. Schubert and
P. J. Rousseeuw, "Fast and eager k-medoids clustering" (2021) for the order of the work.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.records import FloatArray, IntArray

_LEAST_GAIN = 1e-12


def group_by_medoids(
    distances: FloatArray,
    n_groups: int,
    *,
    weights: NDArray[np.floating] | None = None,
    prices: NDArray[np.floating] | None = None,
    initial: IntArray | None = None,
) -> tuple[IntArray, IntArray]:
    """Medoids and labels.

    Parameters
    ----------
    distances : array (n, n), 0 on the diagonal.
    n_groups : K, 1 to n.
    weights : array (n,), how much a thing's distance counts (default 1).
    prices : array (n,), what a thing costs as a medoid (default 0).
    initial : array (K,), medoids to begin with (default: the first K).

    Returns
    -------
    medoids : array (K,), numbers of things; labels : array (n,), group of every thing.

    Raises
    ------
    GrammarError
        when K is not between 1 and n.

    >>> points = np.array([0.0, 0.1, 5.0, 5.2, 5.1])
    >>> group_by_medoids(np.abs(points[:, None] - points), 2)
    (array([4, 1]), array([1, 1, 0, 0, 0]))
    """
    n = len(distances)
    if not 1 <= n_groups <= n:
        raise GrammarError(
            f"medoids: expected 1 to {n} groups for {n} segments, found {n_groups}. "
            "Ask for another number."
        )
    by = np.ones(n) if weights is None else np.asarray(weights, dtype=np.float64)
    paid = np.zeros(n) if prices is None else np.asarray(prices, dtype=np.float64)
    first = np.arange(n_groups) if initial is None else np.asarray(initial, dtype=np.int64)
    costs = np.ascontiguousarray(np.asarray(distances, dtype=np.float64).T * by)
    medoids = _swap(costs, paid, first.copy())
    return medoids, nearest_medoids(costs, medoids)


@njit(cache=True)
def nearest_medoids(costs: FloatArray, medoids: IntArray) -> IntArray:
    """The group of every thing from costs (medoid, thing); a medoid is in its own."""
    labels = np.zeros(costs.shape[1], np.int64)
    for i in range(costs.shape[1]):
        for k in range(1, len(medoids)):
            if costs[medoids[k], i] < costs[medoids[labels[i]], i]:
                labels[i] = k
    for k in range(len(medoids)):
        labels[medoids[k]] = k
    return labels


@njit(cache=True)
def _two_nearest(costs, medoids, near, first, second):  # type: ignore[no-untyped-def]
    """Group, least and second least cost of every thing."""
    for i in range(costs.shape[1]):
        near[i], first[i], second[i] = -1, np.inf, np.inf
        for k in range(len(medoids)):
            cost = costs[medoids[k], i]
            if cost < first[i]:
                near[i], second[i], first[i] = k, first[i], cost
            elif cost < second[i]:
                second[i] = cost


@njit(cache=True)
def _swap(costs, prices, medoids):  # type: ignore[no-untyped-def]
    n, n_groups = costs.shape[1], len(medoids)
    near = np.empty(n, np.int64)
    first, second = np.empty(n), np.empty(n)
    is_medoid = np.zeros(n, np.bool_)
    is_medoid[medoids] = True
    _two_nearest(costs, medoids, near, first, second)
    least = _LEAST_GAIN * (first.sum() + prices[medoids].sum() + 1e-300)
    change = np.empty(n_groups)
    unchanged, candidate = 0, 0
    while unchanged < n:
        if not is_medoid[candidate]:
            shared = prices[candidate]
            for k in range(n_groups):
                change[k] = -prices[medoids[k]]
            for i in range(n):
                cost = costs[candidate, i]
                if cost < first[i]:
                    shared += cost - first[i]
                    # the old medoid's loss is no loss here: the thing leaves it anyway
                elif n_groups == 1 or cost < second[i]:
                    change[near[i]] += cost - first[i]
                else:
                    change[near[i]] += second[i] - first[i]
            k = int(np.argmin(change))
            if shared + change[k] < -least:
                is_medoid[medoids[k]] = False
                is_medoid[candidate] = True
                medoids[k] = candidate
                _two_nearest(costs, medoids, near, first, second)
                unchanged = -1
        unchanged += 1
        candidate = (candidate + 1) % n
    return medoids
