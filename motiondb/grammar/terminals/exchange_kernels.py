"""Costs of cells and the best exchange of a medoid, compiled; see :mod:`.exchange`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.terminals.candidates import path_costs
from motiondb.records import Float32Array, FloatArray, IntArray


class Graph(NamedTuple):
    """Cells as a graph, as in ``Cells``, and the cost of each cut."""

    firsts: IntArray
    pointers: IntArray
    cut_costs: FloatArray


class KnownCosts(NamedTuple):
    """Least and second least cost and nearest medoid of the cells, and costs to the tried cell."""

    least: Float32Array
    second: Float32Array
    nearest: IntArray
    tried: Float32Array


class Prices(NamedTuple):
    """Costs of the current medoids (K,), and of the tried cell as a medoid."""

    medoids: FloatArray
    tried: float


@njit(cache=True, fastmath=True, nogil=True)
def frame_distances(
    columns: Float32Array, squares: Float32Array, start: int, end: int
) -> Float32Array:
    """Return d of all frames to the frames [start, end): array (medoid's frames, frames).

    Not a matrix product: the libraries for these start their own threads, which slow down
    simultaneous searches.
    """
    n_dimensions, n_frames = columns.shape
    table = np.empty((end - start, n_frames), np.float32)
    for u in range(end - start):
        row = table[u]
        for t in range(n_frames):
            row[t] = np.float32(0.0)
        for d in range(0, n_dimensions, 4):
            a, b, c, e = columns[d], columns[d + 1], columns[d + 2], columns[d + 3]
            x, y, z, w = a[start + u], b[start + u], c[start + u], e[start + u]
            for t in range(n_frames):
                row[t] += x * a[t] + y * b[t] + z * c[t] + w * e[t]
        for t in range(n_frames):
            square = squares[t] + squares[start + u] - np.float32(2.0) * row[t]
            row[t] = np.sqrt(max(square, np.float32(0.0)))
    return table


@njit(cache=True, fastmath=True, nogil=True)
def warped_costs(
    table: Float32Array, cuts: IntArray, firsts: IntArray, pointers: IntArray, out: Float32Array
) -> None:
    """Sum distances (medoid's frames, frames) over warped cells, into ``out``."""
    n_medoid = table.shape[0]
    for j in range(len(cuts)):
        for c in range(pointers[j], pointers[j + 1]):
            first, length = cuts[firsts[c]], cuts[j] - cuts[firsts[c]]
            total, behind, at = np.float32(0.0), 0, 0
            if length >= n_medoid:
                for t in range(first, first + length):
                    total += table[at, t]
                    behind += n_medoid
                    if behind >= length:
                        behind -= length
                        at += 1
                out[c] = total
            else:
                for u in range(n_medoid):
                    total += table[u, first + at]
                    behind += length
                    if behind >= n_medoid:
                        behind -= n_medoid
                        at += 1
                out[c] = total * np.float32(length) / np.float32(n_medoid)


@njit(cache=True, nogil=True)
def two_least(
    table: Float32Array, least: Float32Array, second: Float32Array, nearest: IntArray
) -> None:
    """Fill the least and second least cost of every cell, and the medoid of the least."""
    for c in range(table.shape[1]):
        least[c], second[c], nearest[c] = np.inf, np.inf, -1
        for k in range(table.shape[0]):
            cost = table[k, c]
            if cost < least[c]:
                second[c], least[c], nearest[c] = least[c], cost, k
            elif cost < second[c]:
                second[c] = cost


@njit(cache=True, nogil=True)
def best_exchange(
    graph: Graph, known: KnownCosts, prices: Prices, bound: float
) -> tuple[int, float]:
    """Return the medoid to replace by the tried cell, and the new G; -1 if none is below ``bound``.

    No exchange is cheaper than adding the new medoid and keeping all others. If that does not lower
    the cost, nothing is tried.
    """
    firsts, pointers, cut_costs = graph
    least, second, nearest, tried = known
    reached = np.empty(len(cut_costs))
    before = np.empty(len(cut_costs), np.int64)
    costs = np.minimum(least, tried)
    paid = prices.medoids.sum() + prices.tried
    floor = path_costs(firsts, pointers, costs, cut_costs, reached, before)
    floor += paid
    best = -1
    for k in range(len(prices.medoids)):
        if floor - prices.medoids[k] >= bound:
            continue
        for c in range(len(costs)):
            costs[c] = min(second[c] if nearest[c] == k else least[c], tried[c])
        total = path_costs(firsts, pointers, costs, cut_costs, reached, before)
        total += paid - prices.medoids[k]
        if total < bound:
            bound, best = total, k
    return best, bound
