"""The A* search of decoding, over the bounds of :mod:`.decoding_bounds`.

A node holds the first k symbols of a sequence of length l, their log-probability so far, and the
set of words that they have not said.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.language.translation.decoding_bounds import (
    SLACK,
    relax,
    said_level,
    symbol_pays,
    track,
)
from motiondb.language.translation.decoding_problem import LEAST, Problem, offer
from motiondb.records import Float32Array, FloatArray, IntArray

DIVES = 64
"""Number of nodes, expanded first, that are completed along their bound to find good sequences
early.

Chosen by hand; it changes the time, not the optimum.
"""


def search_sequences(
    problem: Problem, node_limit: int, open_limit: int
) -> tuple[IntArray, float, float, int]:
    """Find the sequence of largest log-probability; result (l,)."""
    m, longest = problem.t.shape[1], len(problem.lengths) - 1
    n_rows, n_masks = len(problem.end), 1 << len(problem.tracked)
    best = np.zeros(longest + 1, dtype=np.int64)  # best[0] is the length
    value = -np.inf
    q = np.maximum(LEAST, 0.5 * problem.t[1:].max(axis=0))
    q_of = np.ones((longest + 1, m))
    uppers = np.full(longest + 1, -np.inf)
    for length in range(1, longest + 1):
        if problem.lengths[length] > -np.inf:
            uppers[length], value = relax(problem, length, q, best, value)
            q_of[length] = q
    pays = np.empty((longest + 1, longest + 1, len(problem.says)))
    ahead = np.empty((longest + 1, longest + 1, n_rows, n_masks), dtype=np.float32)
    for length in np.argsort(-uppers, kind="stable"):
        if uppers[length] <= value + SLACK:
            break
        q = said_level(problem, length, q_of[length])
        symbol_pays(problem, length, q, pays[length])
        track(problem, length, q, pays[length], ahead[length])
        path = np.zeros(length, dtype=np.int64)
        _dive(problem, ahead[length], pays[length], path, 0)
        value = offer(problem, path, best, value)
        upper = problem.lengths[length] + ahead[length, 0, problem.row_of[0], n_masks - 1]
        uppers[length] = min(uppers[length], upper)
    value, bound, expanded = _best_first(
        problem, uppers, pays, ahead, best, value, node_limit, open_limit
    )
    return best[1 : best[0] + 1].copy(), value, bound, expanded


@njit(cache=True)
def _dive(
    problem: Problem, ahead: Float32Array, pays: FloatArray, path: IntArray, depth: int
) -> None:
    """Complete a sequence from ``depth`` on by the largest bound, in place."""
    mask = ahead.shape[2] - 1
    for k in range(depth):
        mask &= ~problem.says[path[k]]
    for k in range(depth, len(path)):
        row = problem.row_of[0] if k == 0 else problem.row_of[path[k - 1] + 1]
        top = -np.inf
        path[k] = 0
        for edge in range(problem.starts[row], problem.starts[row + 1]):
            s = problem.followers[edge]
            onward = ahead[k + 1, problem.row_of[s + 1], mask & ~problem.says[s]]
            total = problem.costs[edge] + pays[k + 1, s] + onward
            if total > top:
                top, path[k] = total, s
        mask &= ~problem.says[path[k]]


@njit(cache=True)
def _best_first(  # noqa: C901  one compiled loop over the heap and its arrays
    problem: Problem,
    uppers: FloatArray,
    pays: FloatArray,
    ahead: Float32Array,
    best: IntArray,
    value: float,
    node_limit: int,
    open_limit: int,
) -> tuple[float, float, int]:
    """A*: expand the node of largest bound until no bound exceeds the value of ``best``.

    Node n: shape[n] = (length, depth, words not said), paths[n, :depth], spent[n] the length's and
    the transitions' log-probability and the pays so far, bounds[n].
    """
    longest = len(problem.lengths) - 1
    shape = np.empty((open_limit, 3), dtype=np.int64)
    paths = np.empty((open_limit, longest), dtype=np.int64)
    spent, bounds = np.empty(open_limit), np.empty(open_limit)
    heap = np.empty(open_limit, dtype=np.int64)
    n_heap = n_nodes = expanded = 0
    dropped = -np.inf
    for length in range(1, longest + 1):
        if uppers[length] > value + SLACK:
            shape[n_nodes, 0], shape[n_nodes, 1] = length, 0
            shape[n_nodes, 2] = ahead.shape[3] - 1
            spent[n_nodes], bounds[n_nodes] = problem.lengths[length], uppers[length]
            n_heap = _push(heap, n_heap, bounds, n_nodes)
            n_nodes += 1
    while n_heap > 0 and bounds[heap[0]] > value + SLACK:
        node = heap[0]
        if expanded >= node_limit:
            dropped = max(dropped, bounds[node])
            break
        n_heap = _pop(heap, n_heap, bounds)
        expanded += 1
        length, depth, mask = shape[node, 0], shape[node, 1], shape[node, 2]
        path = paths[node, :length]
        if depth > 0 and expanded <= DIVES:
            _dive(problem, ahead[length], pays[length], path, depth)
            value = offer(problem, path, best, value)
        row = problem.row_of[0] if depth == 0 else problem.row_of[path[depth - 1] + 1]
        for edge in range(problem.starts[row], problem.starts[row + 1]):
            s = problem.followers[edge]
            unsaid = mask & ~problem.says[s]
            total = spent[node] + problem.costs[edge] + pays[length, depth + 1, s]
            bound = total + ahead[length, depth + 1, problem.row_of[s + 1], unsaid]
            if bound <= value + SLACK:
                continue
            path[depth] = s
            if depth + 1 == length:
                value = offer(problem, path, best, value)
            elif n_nodes == open_limit:
                dropped = max(dropped, bound)
            else:
                shape[n_nodes, 0], shape[n_nodes, 1], shape[n_nodes, 2] = length, depth + 1, unsaid
                for k in range(depth + 1):
                    paths[n_nodes, k] = path[k]
                spent[n_nodes], bounds[n_nodes] = total, min(bound, bounds[node])
                n_heap = _push(heap, n_heap, bounds, n_nodes)
                n_nodes += 1
    return value, dropped if dropped > value + SLACK else value, expanded


@njit(cache=True)
def _push(heap: IntArray, size: int, bounds: FloatArray, node: int) -> int:
    """Put a node on the heap, largest bound on top, and return the new size."""
    place = size
    while place > 0 and bounds[heap[(place - 1) // 2]] < bounds[node]:
        heap[place] = heap[(place - 1) // 2]
        place = (place - 1) // 2
    heap[place] = node
    return size + 1


@njit(cache=True)
def _pop(heap: IntArray, size: int, bounds: FloatArray) -> int:
    """Take the top node off the heap and return the new size."""
    size -= 1
    node = heap[size]
    place = 0
    while 2 * place + 1 < size:
        child = 2 * place + 1
        if child + 1 < size and bounds[heap[child + 1]] > bounds[heap[child]]:
            child += 1
        if bounds[heap[child]] <= bounds[node]:
            break
        heap[place] = heap[child]
        place = child
    heap[place] = node
    return size
