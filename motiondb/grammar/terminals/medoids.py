"""Group segments around medoids by the swap search.

Given distances between n things, choose K of them (medoids) so that

    E = sum_m price_m + sum_i weight_i D(i, nearest medoid)

is small. The first K things are the first medoids, so that the result depends on the segmentation
alone. Things are tried in turn as medoids. The gain of putting a thing in the place of each medoid
is found for all K at once in O(n), from the nearest and second nearest medoid of every thing, and
the best swap is made at once if it lowers E. The search ends after a round without a swap; then no
single swap lowers E. Every medoid is in its own group, so no group is empty, even if points
coincide. Ties go to the lowest number.

With weights L(s_i) and prices, E is 1 / F (:mod:`.terminals`), and the groups maximise F.

Source: L. Kaufman and P. J. Rousseeuw, Finding Groups in Data (1990), chapter 2; E. Schubert and
P. J. Rousseeuw, "Fast and eager k-medoids clustering" (2021), for the order of the work.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.kernels import maker
from motiondb.records import FloatArray, IntArray

_LEAST_GAIN = 1e-12  # Smallest relative decrease of E by a swap; smaller ones are rounding errors


class _Nearest(NamedTuple):
    """Nearest group, least and second least cost of every thing."""

    near: IntArray
    first: FloatArray
    second: FloatArray


def group_by_medoids(
    distances: FloatArray,
    n_groups: int,
    *,
    weights: NDArray[np.floating] | None = None,
    prices: NDArray[np.floating] | None = None,
    initial: IntArray | None = None,
) -> tuple[IntArray, IntArray]:
    """Choose medoids and group things by the nearest one.

    Shapes: `distances` (n, n); `weights`, `prices` (n,); `initial`, result (K,).

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


@maker
def nearest_medoids(costs: FloatArray, medoids: IntArray) -> IntArray:
    """Return the group of every thing from costs (medoid, thing); a medoid is in its own."""
    labels = np.zeros(costs.shape[1], np.int64)
    for i in range(costs.shape[1]):
        for k in range(1, len(medoids)):
            if costs[medoids[k], i] < costs[medoids[labels[i]], i]:
                labels[i] = k
    for k in range(len(medoids)):
        labels[medoids[k]] = k
    return labels


@maker
def two_least(
    table: NDArray[np.floating],
    least: NDArray[np.floating],
    second: NDArray[np.floating],
    nearest: IntArray,
) -> None:
    """Fill least and second least of costs (K, things), and the medoid of the least."""
    for c in range(table.shape[1]):
        least[c], second[c], nearest[c] = np.inf, np.inf, -1
        for k in range(table.shape[0]):
            cost = table[k, c]
            if cost < least[c]:
                second[c], least[c], nearest[c] = least[c], cost, k
            elif cost < second[c]:
                second[c] = cost


@maker
def _swap(costs: FloatArray, prices: FloatArray, medoids: IntArray) -> IntArray:
    """Swap medoids, in place, until no swap lowers E."""
    n, n_groups = costs.shape[1], len(medoids)
    nearest = _Nearest(np.empty(n, np.int64), np.empty(n), np.empty(n))
    is_medoid = np.zeros(n, np.bool_)
    is_medoid[medoids] = True
    two_least(costs[medoids], nearest.first, nearest.second, nearest.near)
    least = _LEAST_GAIN * (nearest.first.sum() + prices[medoids].sum() + 1e-300)
    change = np.empty(n_groups)
    unchanged, candidate = 0, 0
    while unchanged < n:
        if not is_medoid[candidate]:
            change[:] = -prices[medoids]
            k, difference = _try_swap(costs[candidate], nearest, change)
            if prices[candidate] + difference < -least:
                is_medoid[medoids[k]] = False
                is_medoid[candidate] = True
                medoids[k] = candidate
                two_least(costs[medoids], nearest.first, nearest.second, nearest.near)
                unchanged = -1
        unchanged += 1
        candidate = (candidate + 1) % n
    return medoids


@maker
def _try_swap(costs: FloatArray, nearest: _Nearest, change: FloatArray) -> tuple[int, float]:
    """Return the medoid whose replacement by a thing changes E the most, and the change.

    ``shared`` is the change that does not depend on which medoid is replaced.
    """
    near, first, second = nearest
    shared = 0.0
    for i in range(len(costs)):
        if costs[i] < first[i]:
            shared += costs[i] - first[i]
            # the old medoid loses nothing: the thing leaves its group anyway
        elif len(change) == 1 or costs[i] < second[i]:
            change[near[i]] += costs[i] - first[i]
        else:
            change[near[i]] += second[i] - first[i]
    k = int(np.argmin(change))
    return k, shared + change[k]
