"""Paths of every length through a graph of symbols, summed, maximised or counted at once.

A derivation can pass from symbol to symbol without reading anything: A -> B, or A -> B C where C
becomes empty. With w(A, B) the weight of one such step, the closure w* = 1 + w + w w + ... holds
the weight of all chains from A to B, endless round trips included. It is found component by
component (Tarjan, 1972), the symbols that lead nowhere else first; inside a strongly connected
component by Kleene's elimination, for which a semiring needs only plus, times and star.

The three semirings share their product and differ in plus and star:
SUM (+, 1 / (1 - a)) gives probabilities, BEST (max, 1) the best chain, COUNT (+, infinity) numbers.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.records import FloatArray, IntArray

SUM, BEST, COUNT = 0, 1, 2


@njit(cache=True)
def strong_components(starts, targets):  # type: ignore[no-untyped-def]
    """Number the strongly connected components of a graph, those that others lead to first.

    Parameters
    ----------
    starts, targets : arrays (n + 1,), (edges,); the edges of node a lead to
        ``targets[starts[a]:starts[a + 1]]``.

    Returns
    -------
    array (n,), the component of each node; an edge never leads to a higher number.
    """
    n = len(starts) - 1
    label = np.full(n, -1, np.int64)
    index = np.full(n, -1, np.int64)
    low = np.zeros(n, np.int64)
    edge = starts[:n].copy()
    stack, path = np.zeros(n, np.int64), np.zeros(n, np.int64)
    n_stack = n_path = n_index = n_labels = 0
    for root in range(n):
        if index[root] >= 0:
            continue
        path[0], n_path = root, 1
        while n_path > 0:
            node = path[n_path - 1]
            if index[node] < 0:
                index[node] = low[node] = n_index
                n_index += 1
                stack[n_stack] = node
                n_stack += 1
            if edge[node] < starts[node + 1]:
                target = targets[edge[node]]
                if index[target] < 0:
                    path[n_path] = target
                    n_path += 1
                    continue  # come back to this edge when the target is done
                if label[target] < 0:
                    low[node] = min(low[node], low[target])
                edge[node] += 1
                continue
            n_path -= 1
            if low[node] == index[node]:
                while True:
                    n_stack -= 1
                    label[stack[n_stack]] = n_labels
                    if stack[n_stack] == node:
                        break
                n_labels += 1
    return label


@njit(cache=True)
def _plus(kind, a, b):  # type: ignore[no-untyped-def]
    return max(a, b) if kind == 1 else a + b


@njit(cache=True)
def _star(kind, a):  # type: ignore[no-untyped-def]
    if a == 0.0 or kind == 1:
        return 1.0
    return 1.0 / (1.0 - a) if kind == 0 and a < 1.0 else np.inf


@njit(cache=True)
def _close_component(kind, inner):  # type: ignore[no-untyped-def]
    """Kleene's elimination in place: ``inner`` (m, m) becomes its closure."""
    m = len(inner)
    for k in range(m):
        star = _star(kind, inner[k, k])
        for i in range(m):
            if i == k or inner[i, k] == 0.0:
                continue
            factor = inner[i, k] * star
            for j in range(m):
                if j != k and inner[k, j] != 0.0:
                    inner[i, j] = _plus(kind, inner[i, j], factor * inner[k, j])
            inner[i, k] = factor
        for j in range(m):
            if j != k and inner[k, j] != 0.0:
                inner[k, j] *= star
        inner[k, k] = star
    return inner


@njit(cache=True)
def _gather(kind, node, a, graph, rows, work):  # type: ignore[no-untyped-def]
    """Row ``a`` of a component: steps inside it, and what the steps out of it lead to.

    Returns how many nodes are reached so far.
    """
    starts, targets, weights, label = graph
    row_start, row_end, columns, values = rows
    place, inner, outer, reached, is_reached, n_reached = work
    for e in range(starts[node], starts[node + 1]):
        target = targets[e]
        if label[target] == label[node]:
            inner[a, place[target]] = _plus(kind, inner[a, place[target]], weights[e])
            continue
        for c in range(row_start[target], row_end[target]):
            column = columns[c]
            outer[a, column] = _plus(kind, outer[a, column], weights[e] * values[c])
            if not is_reached[column]:
                reached[n_reached], is_reached[column] = column, True
                n_reached += 1
    return n_reached


@njit(cache=True)
def _close_graph(kind, graph, order, largest):  # type: ignore[no-untyped-def]
    label = graph[3]
    n = len(label)
    row_start, row_end = np.zeros(n, np.int64), np.zeros(n, np.int64)
    columns, values, used = np.zeros(2 * n + 16, np.int64), np.zeros(2 * n + 16), 0
    place, reached, is_reached = np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros(n, np.bool_)
    outer = np.zeros((largest, n))
    first = 0
    while first < n:
        m, n_reached = 0, 0
        while first + m < n and label[order[first + m]] == label[order[first]]:
            node = order[first + m]
            place[node], outer[m, node] = m, 1.0
            reached[m], is_reached[node] = node, True
            m += 1
        inner, n_reached = np.zeros((m, m)), m
        for a in range(m):
            rows = (row_start, row_end, columns, values)
            work = (place, inner, outer, reached, is_reached, n_reached)
            n_reached = _gather(kind, order[first + a], a, graph, rows, work)
        _close_component(kind, inner)
        while used + m * n_reached > len(columns):
            columns = np.append(columns, np.zeros_like(columns))
            values = np.append(values, np.zeros_like(values))
        for a in range(m):
            row_start[order[first + a]] = used
            for r in range(n_reached):
                total = 0.0
                for b in range(m):
                    if inner[a, b] != 0.0 and outer[b, reached[r]] != 0.0:
                        total = _plus(kind, total, inner[a, b] * outer[b, reached[r]])
                if total != 0.0:
                    columns[used], values[used] = reached[r], total
                    used += 1
            row_end[order[first + a]] = used
        for r in range(n_reached):
            for a in range(m):
                outer[a, reached[r]] = 0.0
            is_reached[reached[r]] = False
        first += m
    return row_start, row_end, columns, values


def close_graph(
    kind: int, starts: IntArray, targets: IntArray, weights: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Closure of a weighted graph as sparse rows.

    Parameters
    ----------
    kind : SUM, BEST or COUNT.
    starts, targets, weights : arrays (n + 1,), (edges,), (edges,), the edges of each node.

    Returns
    -------
    starts (n + 1,), columns and values (entries,): row a holds w*(a, b) for all b it leads to,
    itself with the empty chain included, in ascending order of b.

    >>> starts, columns, values = close_graph(
    ...     SUM, np.array([0, 1, 2]), np.array([1, 0]), np.array([0.5, 0.5]))
    >>> values.round(4).tolist()
    [1.3333, 0.6667, 0.6667, 1.3333]
    """
    label = strong_components(starts, targets)
    order, largest = np.argsort(label, kind="stable"), int(np.bincount(label).max(initial=0))
    begin, end, columns, values = _close_graph(
        kind, (starts, targets, weights, label), order, largest
    )
    lengths = end - begin
    new_starts = np.concatenate(([0], np.cumsum(lengths)))
    take = np.repeat(begin - new_starts[:-1], lengths) + np.arange(new_starts[-1])
    rows = np.repeat(np.arange(len(lengths)), lengths)
    take = take[np.lexsort((columns[take], rows))]
    return new_starts, columns[take], values[take]


def transpose(
    starts: IntArray, columns: IntArray, values: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """The same sparse matrix by columns: for each b, the a that lead to it, ascending."""
    n = len(starts) - 1
    rows = np.repeat(np.arange(n), np.diff(starts))
    order = np.argsort(columns, kind="stable")
    new_starts = np.concatenate(([0], np.cumsum(np.bincount(columns, minlength=n))))
    return new_starts, rows[order], values[order]
