"""Closure of a weighted graph: all paths between symbols, summed, maximised or counted.

A derivation can pass from symbol to symbol without reading anything: A -> B, or A -> B C where C
becomes empty. With w(A, B) the weight of one such step, the closure w* = 1 + w + w w + ... holds
the weight of all chains from A to B, cycles included. It is computed component by component
(Tarjan, 1972), starting with components from which no other is reached; inside a strongly connected
component by Kleene's elimination, for which a semiring needs only plus, times and star.

The three semirings share their product and differ in plus and star:
SUM (+, 1 / (1 - a)) gives probabilities, BEST (max, 1) the best chain, COUNT (+, infinity) numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.kernels import kernel, maker, merged
from motiondb.records import BoolArray, FloatArray, IntArray

SUM, BEST, COUNT = 0, 1, 2  # The semirings
MOST_CHAINS = 4_000_000
"""Largest number of pairs of symbols with a chain between them: 64 MB. A grammar of 100 symbols,
each of which leads to every other, has 10,000."""
MOST_STEPS = 200_000_000
"""Largest number of products of the closure of components. They take about a second."""


class Sparse(NamedTuple):
    """A sparse matrix by rows, or a weighted graph by nodes."""

    starts: IntArray  # (n + 1,): row a has the entries ``starts[a]`` to ``starts[a + 1]``
    columns: IntArray  # (entries,): column of each entry; in a graph, the target of the edge
    values: FloatArray  # (entries,): value of each entry; of a graph, the weight of the edge


class _Graph(NamedTuple):
    """A :class:`Sparse` graph with the component ``label`` (n,) of each node."""

    starts: IntArray
    columns: IntArray
    values: FloatArray
    label: IntArray


class _Rows(NamedTuple):
    """Rows of the closure so far: where each begins and ends (n,), columns and values."""

    begin: IntArray
    end: IntArray
    columns: IntArray
    values: FloatArray


class _Component(NamedTuple):
    """The component that is being closed."""

    place: IntArray  # (n,): number of a node within the component
    inner: FloatArray  # (m, m): weights of steps inside the component
    outer: FloatArray  # (largest m, n): weights from a node of the component to any node
    reached: IntArray  # (n,): list of the nodes with a weight in ``outer``
    is_reached: BoolArray  # (n,): whether each node has a weight in ``outer``


@maker
def strong_components(starts: IntArray, targets: IntArray) -> IntArray:
    """Number the strongly connected components, so that edges lead to the same or a lower number.

    Parameters
    ----------
    starts : array (n + 1,)
        The edges of node a lead to ``targets[starts[a]:starts[a + 1]]``.
    targets : array (edges,)
        Target of each edge.

    Returns
    -------
    array (n,)
        The component of each node; an edge never leads to a higher number.
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
                n_stack = _pop_component(label, stack, n_stack, node, n_labels)
                n_labels += 1
    return label


@kernel
def _pop_component(label: IntArray, stack: IntArray, n_stack: int, node: int, number: int) -> int:
    """Number the nodes of the stack down to ``node``; return the new size of the stack."""
    while True:
        n_stack -= 1
        label[stack[n_stack]] = number
        if stack[n_stack] == node:
            return n_stack


@kernel
def _plus(kind: int, a: float, b: float) -> float:
    """Add two weights in a semiring."""
    return max(a, b) if kind == BEST else a + b


@kernel
def _star(kind: int, a: float) -> float:
    """Return 1 + a + a a + ... in a semiring."""
    if a == 0.0 or kind == BEST:
        return 1.0
    return 1.0 / (1.0 - a) if kind == SUM and a < 1.0 else np.inf


@merged
def _close_component(kind: int, inner: FloatArray) -> None:
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


@kernel
def _gather(
    kind: int, node: int, graph: _Graph, rows: _Rows, component: _Component, n_reached: int
) -> int:
    """Fill the row of a node: steps inside its component, and rows that are reached from it.

    Returns how many nodes are reached so far.
    """
    place, inner, outer, reached, is_reached = component
    a = place[node]
    for e in range(graph.starts[node], graph.starts[node + 1]):
        target, weight = graph.columns[e], graph.values[e]
        if graph.label[target] == graph.label[node]:
            inner[a, place[target]] = _plus(kind, inner[a, place[target]], weight)
            continue
        for c in range(rows.begin[target], rows.end[target]):
            column = rows.columns[c]
            outer[a, column] = _plus(kind, outer[a, column], weight * rows.values[c])
            if not is_reached[column]:
                reached[n_reached], is_reached[column] = column, True
                n_reached += 1
    return n_reached


@kernel
def _multiply(kind: int, nodes: IntArray, rows: _Rows, component: _Component, used: int) -> int:
    """Write the rows of a component, inner times outer, and empty ``outer``.

    Returns how many entries there are so far.
    """
    _, inner, outer, reached, is_reached = component
    m = len(nodes)
    for a in range(m):
        rows.begin[nodes[a]] = used
        for column in reached:
            total = 0.0
            for b in range(m):
                if inner[a, b] != 0.0 and outer[b, column] != 0.0:
                    total = _plus(kind, total, inner[a, b] * outer[b, column])
            if total != 0.0:
                rows.columns[used], rows.values[used] = column, total
                used += 1
        rows.end[nodes[a]] = used
    for column in reached:
        for a in range(m):
            outer[a, column] = 0.0
        is_reached[column] = False
    return used


@maker
def _close_graph(kind: int, graph: _Graph, order: IntArray, largest: int) -> tuple[_Rows, bool]:
    """Return the closure by rows, and whether it is complete; ``order``: nodes by component."""
    label = graph.label
    n = len(label)
    row_begin, row_end = np.zeros(n, np.int64), np.zeros(n, np.int64)
    columns, values, used = np.zeros(2 * n + 16, np.int64), np.zeros(2 * n + 16), 0
    place, reached, is_reached = np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros(n, np.bool_)
    outer = np.zeros((largest, n))
    first = n_steps = 0
    while first < n:
        m = 0
        while first + m < n and label[order[first + m]] == label[order[first]]:
            node = order[first + m]
            place[node], outer[m, node] = m, 1.0
            reached[m], is_reached[node] = node, True
            m += 1
        nodes, n_reached = order[first : first + m], m
        rows = _Rows(row_begin, row_end, columns, values)
        inner = np.zeros((m, m))
        component = _Component(place, inner, outer, reached, is_reached)
        for node in nodes:
            n_reached = _gather(kind, node, graph, rows, component, n_reached)
        n_steps += m * m * (m + n_reached)
        if n_steps > MOST_STEPS or used + m * n_reached > MOST_CHAINS:
            return rows, False
        _close_component(kind, inner)
        while used + m * n_reached > len(columns):
            columns = np.append(columns, np.zeros_like(columns))
            values = np.append(values, np.zeros_like(values))
        rows = _Rows(row_begin, row_end, columns, values)
        component = _Component(place, inner, outer, reached[:n_reached], is_reached)
        used = _multiply(kind, nodes, rows, component, used)
        first += m
    return _Rows(row_begin, row_end, columns, values), True


@maker
def _close(
    kind: int, starts: IntArray, targets: IntArray, weights: FloatArray
) -> tuple[Sparse, bool]:
    """Return the closure by columns, and whether it is complete; edges of weight 0 are none."""
    n = len(starts) - 1
    firsts, columns, values = np.zeros(n + 1, np.int64), np.zeros_like(targets), weights.copy()
    used = 0
    for node in range(n):
        for e in range(starts[node], starts[node + 1]):
            if weights[e] > 0.0:
                columns[used], values[used] = targets[e], weights[e]
                used += 1
        firsts[node + 1] = used
    label = strong_components(firsts, columns)
    order, largest = _by_number(label)
    rows = _Rows(firsts, firsts, columns, values)
    is_whole = largest * n <= MOST_STEPS // 8  # the dense rows of a component
    if is_whole:
        graph = _Graph(firsts, columns, values, label)
        rows, is_whole = _close_graph(kind, graph, order, largest)
    if not is_whole:
        return Sparse(firsts, columns, values), False
    places = np.zeros(n + 1, np.int64)
    for node in range(n):
        for e in range(rows.begin[node], rows.end[node]):
            places[rows.columns[e] + 1] += 1
    places = np.cumsum(places)
    by_column, above = places[:-1].copy(), np.zeros(places[n], np.int64)
    factors = np.zeros(places[n])
    for node in range(n):
        for e in range(rows.begin[node], rows.end[node]):
            place = by_column[rows.columns[e]]
            above[place], factors[place] = node, rows.values[e]
            by_column[rows.columns[e]] += 1
    return Sparse(places, above, factors), True


@merged
def _by_number(label: IntArray) -> tuple[IntArray, int]:
    """Return the nodes by label, ascending, and the size of the largest component."""
    n = len(label)
    firsts = np.zeros(n + 1, np.int64)
    for number in label:
        firsts[number + 1] += 1
    largest = firsts.max()
    firsts = np.cumsum(firsts)
    order = np.zeros(n, np.int64)
    for node in range(n):
        order[firsts[label[node]]] = node
        firsts[label[node]] += 1
    return order, largest


def close_graph(kind: int, graph: Sparse) -> Sparse:
    """Compute the closure of a weighted graph by columns: for each b, the a that lead to it.

    >>> graph = Sparse(np.array([0, 1, 2]), np.array([1, 0]), np.array([0.5, 0.5]))
    >>> close_graph(SUM, graph).values.round(4).tolist()
    [1.3333, 0.6667, 0.6667, 1.3333]
    """
    closed, is_whole = _close(kind, *graph)
    if not is_whole:
        raise GrammarError(
            f"grammar: expected at most {MOST_CHAINS:,} chains from symbol to symbol without"
            " reading anything, found more. Use fewer rules of one symbol, and fewer that become"
            " empty."
        )
    return closed
