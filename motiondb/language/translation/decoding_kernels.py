"""The arrays of one decoding question, and the log-probability of a sequence.

Notation as in :mod:`motiondb.language.translation.decoding`. Symbols whose rows of transitions are
equal (those of one cluster) form a *row*, so that the dynamic programs run over rows, not symbols.
The symbols of each word are split into those that *say* it and the rest, see below.

**The A* search, and its two upper bounds on the log-probability of a sequence.** Both bounds follow
from log x <= log q + x / q - 1. The first applies it to every word; its q are found by Frank-Wolfe
steps, and the sequences of these steps are first candidates. This bound is loose for words that no
symbol of a sequence gives a sizeable probability. The second bound therefore splits the symbols of
each word into those that *say* it (give it a large probability) and the rest, and its dynamic
program carries the set of words not yet said as a bit mask: the probability of a word never said is
bounded by the most that the remaining symbols can give it. Where there are more than ``TRACKED``
words, only those with the widest split are tracked.

A node of the search holds the first k symbols of a sequence of length l, their log-probability so
far, and the set of words that they have not said.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray

TRACKED = 6
"""Largest number of words in the bit mask, for 2^6 masks. Chosen by hand: memory doubles with
each word."""
LEAST = 1e-12  # The smallest probability whose logarithm is taken to bound or to split


class Problem(NamedTuple):
    """The arrays of one question; log-probabilities unless stated otherwise."""

    t: FloatArray  # (S + 1, m), probability: row 0 is NULL
    alignments: FloatArray  # (L + 1, m, L + 1): a(i | j, l, m) at [l, j, i]
    row_of: IntArray  # (S + 1,): row of the beginning, then of every symbol
    starts: IntArray  # (rows + 1,): row r goes to followers[starts[r]:starts[r + 1]] at those costs
    followers: IntArray  # (edges,): symbol numbers
    costs: FloatArray  # (edges,): log-probabilities of the transitions to the followers
    end: FloatArray  # (rows,): log-probability that the capture ends after a symbol of the row
    lengths: FloatArray  # (L + 1,): log P(l | m)
    says: IntArray  # (S,): bit mask of the tracked words that a symbol says
    tracked: IntArray  # (TRACKED or m,): words that have the bits 0, 1,
    unsaid: FloatArray  # (m,): largest probability of word j under a symbol that does not say it
    usual: FloatArray  # (m,): mean probability of word j under symbols that say it


def pose_problem(
    t: FloatArray, alignments: FloatArray, log_transitions: FloatArray, log_lengths: FloatArray
) -> Problem:
    """Merge equal rows of transitions, keep the possible ones, split the symbols of each word.

    Shapes: `t` (S + 1, m); `alignments` (L + 1, m, L + 1); `log_transitions` (S + 1, S + 1);
    `log_lengths` (L + 1,).
    """
    numbers: dict[bytes, int] = {}
    row_of = [numbers.setdefault(row.tobytes(), len(numbers)) for row in log_transitions]
    rows = log_transitions[np.unique(row_of, return_index=True)[1]]
    possible = rows[:, 1:] > -np.inf
    says, tracked, unsaid, usual = _split_symbols(t[1:])
    return Problem(
        t=np.ascontiguousarray(t),
        alignments=np.ascontiguousarray(alignments),
        row_of=np.array(row_of, dtype=np.int64),
        starts=np.append(0, np.cumsum(possible.sum(axis=1))).astype(np.int64),
        followers=np.nonzero(possible)[1].astype(np.int64),
        costs=np.ascontiguousarray(rows[:, 1:][possible]),
        end=np.ascontiguousarray(rows[:, 0]),
        lengths=np.ascontiguousarray(log_lengths),
        says=says,
        tracked=tracked,
        unsaid=unsaid,
        usual=usual,
    )


def _split_symbols(t: FloatArray) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Which symbols say which words: the split of log t of largest between-group variance (Otsu).

    t : array (S, m). Returns ``says``, ``tracked``, ``unsaid`` and ``usual`` of :class:`Problem`.
    """
    n_symbols, m = t.shape
    order = np.argsort(-t, axis=0, kind="stable")
    values = np.log(np.maximum(np.take_along_axis(t, order, axis=0), LEAST))
    n_saying = np.arange(1, n_symbols)[:, None]
    sums = np.cumsum(values, axis=0)
    upper = sums[:-1] / n_saying
    lower = (sums[-1] - sums[:-1]) / (n_symbols - n_saying)
    between = n_saying * (n_symbols - n_saying) * (upper - lower) ** 2
    says = np.zeros(n_symbols, dtype=np.int64)
    if n_symbols == 1:
        return says, np.zeros(0, dtype=np.int64), t[0].copy(), t[0].copy()
    split = np.argmax(between, axis=0)
    gap = (upper - lower)[split, np.arange(m)]
    tracked = np.sort(np.argsort(-gap, kind="stable")[:TRACKED]).astype(np.int64)
    unsaid = t.max(axis=0)
    usual = np.array([t[order[: split[j] + 1, j], j].mean() for j in range(m)])
    for bit, j in enumerate(tracked):
        says[order[: split[j] + 1, j]] |= 1 << bit
        unsaid[j] = t[order[split[j] + 1, j], j]
    return says, tracked, unsaid, usual


@njit(cache=True)
def sequence_value(problem: Problem, path: IntArray) -> float:
    """log P(l | m) + log P(path) + log P(words | path)."""
    length = len(path)
    value = problem.lengths[length] + moves_along(problem, path)
    for s in sums_along(problem, path):
        value += np.log(s) if s > 0.0 else -np.inf
    return value


@njit(cache=True)
def sums_along(problem: Problem, path: IntArray) -> FloatArray:
    """S_j of a whole sequence, array (m,), probability."""
    a = problem.alignments[len(path)]
    sums = np.empty(problem.t.shape[1])
    for j in range(len(sums)):
        sums[j] = a[j, 0] * problem.t[0, j]
        for k in range(len(path)):
            sums[j] += a[j, k + 1] * problem.t[path[k] + 1, j]
    return sums


@njit(cache=True)
def moves_along(problem: Problem, path: IntArray) -> float:
    """log P(path), from begin to end."""
    total, row = 0.0, problem.row_of[0]
    for symbol in path:
        step = -np.inf
        for edge in range(problem.starts[row], problem.starts[row + 1]):
            if problem.followers[edge] == symbol:
                step = problem.costs[edge]
                break
        total += step
        row = problem.row_of[symbol + 1]
    return total + problem.end[row]


@njit(cache=True)
def offer(problem: Problem, path: IntArray, best: IntArray, value: float) -> float:
    """Copy a sequence into ``best`` (length first) if it is better, and return the best value."""
    candidate = sequence_value(problem, path)
    if candidate > value:
        best[0] = len(path)
        for k in range(len(path)):
            best[k + 1] = path[k]
        return candidate
    return value


ROUNDS = 3
"""Largest number of Frank-Wolfe steps per length. Chosen by hand; any number gives a valid
bound."""
SLACK = 1e-10
"""Nats by which a bound may exceed the best sequence and still count as no better (rounding)."""


@njit(cache=True)
def symbol_pays(problem: Problem, length: int, q: FloatArray, pays: FloatArray) -> None:
    """Contribution of symbol s at position k to the bound: sum_j a(k | j) t(j | s) / q_j.

    Fills ``pays``, array (at least l + 1, S).
    """
    n_symbols, m = len(problem.says), len(q)
    pays[0] = 0.0
    for k in range(1, length + 1):
        pays[k] = 0.0
        for j in range(m):
            weight = problem.alignments[length, j, k] / q[j]
            for s in range(n_symbols):
                pays[k, s] += weight * problem.t[s + 1, j]


@njit(cache=True)
def relax(
    problem: Problem, length: int, q: FloatArray, best: IntArray, value: float
) -> tuple[float, float]:
    """Frank-Wolfe on the first bound of one length; improves ``best`` and ``q`` in place.

    Returns the least upper bound of the length, and the value of ``best``.
    """
    m = len(q)
    x, x_moves, upper = np.empty(m), 0.0, np.inf
    pays = np.empty((length + 1, len(problem.says)))
    for step in range(ROUNDS):
        symbol_pays(problem, length, q, pays)
        path, linear = _best_path(problem, length, pays)
        if linear == -np.inf:
            return -np.inf, value
        value = offer(problem, path, best, value)
        linear += problem.lengths[length]
        for j in range(m):
            linear += np.log(q[j]) - 1.0 + problem.alignments[length, j, 0] * problem.t[0, j] / q[j]
        upper = min(upper, linear)
        y, y_moves = sums_along(problem, path), moves_along(problem, path)
        share = 1.0 if step == 0 else _line_search(x, y, y_moves - x_moves)
        if upper <= value + SLACK or share < 1e-4:
            break
        if step == 0:
            x_moves = y_moves
            for j in range(m):
                x[j] = y[j]
        x_moves += share * (y_moves - x_moves)
        for j in range(m):
            x[j] += share * (y[j] - x[j])
            q[j] = max(LEAST, x[j])
    return upper, value


@njit(cache=True)
def _best_path(problem: Problem, length: int, pays: FloatArray) -> tuple[IntArray, float]:
    """Sequence of largest sum of transitions and contributions, by dynamic programming."""
    n_rows = len(problem.end)
    onward = np.zeros((length, n_rows), dtype=np.int64)
    path = np.zeros(length, dtype=np.int64)
    ahead, worth = problem.end.copy(), np.empty(len(problem.says))
    for k in range(length - 1, -1, -1):
        for s in range(len(worth)):
            worth[s] = pays[k + 1, s] + ahead[problem.row_of[s + 1]]
        for row in range(n_rows):
            top, arg = -np.inf, 0
            for edge in range(problem.starts[row], problem.starts[row + 1]):
                total = problem.costs[edge] + worth[problem.followers[edge]]
                if total > top:
                    top, arg = total, problem.followers[edge]
            ahead[row], onward[k, row] = top, arg
    row = problem.row_of[0]
    value = ahead[row]
    for k in range(length):
        path[k] = onward[k, row]
        row = problem.row_of[path[k] + 1]
    return path, value


@njit(cache=True)
def _line_search(x: FloatArray, y: FloatArray, slope: float) -> float:
    """The share of y that maximises slope share + sum_j log(x_j + share (y_j - x_j))."""
    low, high = 0.0, 1.0
    for _ in range(30):
        share = 0.5 * (low + high)
        rise = slope
        for j in range(len(x)):
            rise += (y[j] - x[j]) / max(LEAST, x[j] + share * (y[j] - x[j]))
        if rise > 0.0:
            low = share
        else:
            high = share
    return 0.5 * (low + high)


@njit(cache=True)
def said_level(problem: Problem, length: int, q: FloatArray) -> FloatArray:
    """Values q for the second bound: the usual probability of a word that one symbol says.

    The symbol is assumed at the position of largest alignment probability. Words that are
    not tracked keep their q, and so does a larger q.
    """
    level = q.copy()
    for j in problem.tracked:
        place = 0.0
        for k in range(1, length + 1):
            place = max(place, problem.alignments[length, j, k])
        null = problem.alignments[length, j, 0] * problem.t[0, j]
        level[j] = max(q[j], null + place * problem.usual[j])
    return level


@njit(cache=True)
def track(  # noqa: C901  one compiled dynamic program, a loop inside a loop
    problem: Problem, length: int, q: FloatArray, pays: FloatArray, ahead: Float32Array
) -> None:
    """Compute the second bound of one length.

    Parameters
    ----------
    pays : array (l + 1, S)
        See :func:`symbol_pays`.
    ahead : array (at least l + 1, rows, masks)
        Filled with an upper bound of the value after position k from a row, with the words of the
        mask not yet said; the linearised logarithms are part of it, the contributions of earlier
        positions are not. ahead[0, row of the begin, all words], with the length's log-probability,
        bounds every sequence of the length. In single precision for speed; raised by more than its
        rounding errors can amount to.
    """
    n_rows, n_symbols = len(problem.end), len(problem.says)
    n_masks = 1 << len(problem.tracked)
    ends = _ends(problem, length, q, n_masks)
    pad = _rounding(problem, length, pays, ends)
    for row in range(n_rows):
        for mask in range(n_masks):
            ahead[length, row, mask] = problem.end[row] + ends[mask] + pad
    step = np.empty((n_symbols, n_masks), dtype=np.float32)
    top = np.empty(n_masks, dtype=np.float32)
    for k in range(length - 1, -1, -1):
        for s in range(n_symbols):
            onward, pay = ahead[k + 1, problem.row_of[s + 1]], np.float32(pays[k + 1, s])
            if problem.says[s] == 0:
                for mask in range(n_masks):
                    step[s, mask] = pay + onward[mask]
            else:
                for mask in range(n_masks):
                    step[s, mask] = pay + onward[mask & ~problem.says[s]]
        for row in range(n_rows):
            if k == 0 and row != problem.row_of[0]:
                continue
            for mask in range(n_masks):
                top[mask] = -np.inf
            for edge in range(problem.starts[row], problem.starts[row + 1]):
                cost, onward = np.float32(problem.costs[edge]), step[problem.followers[edge]]
                for mask in range(n_masks):
                    total = cost + onward[mask]
                    top[mask] = total if total > top[mask] else top[mask]
            for mask in range(n_masks):
                ahead[k, row, mask] = top[mask]


@njit(cache=True)
def _ends(problem: Problem, length: int, q: FloatArray, n_masks: int) -> FloatArray:
    """The constant part of the bound for each set of words never said, array (masks,)."""
    total = 0.0
    losses = np.zeros(len(problem.tracked))
    for j in range(len(q)):
        most = null = problem.alignments[length, j, 0] * problem.t[0, j]
        said = np.log(q[j]) - 1.0 + null / q[j]
        total += said
        for k in range(1, length + 1):
            most += problem.alignments[length, j, k] * problem.unsaid[j]
        for bit in range(len(losses)):
            if problem.tracked[bit] == j:
                losses[bit] = min(0.0, np.log(most) - said) if most > 0.0 else -np.inf
    ends = np.empty(n_masks)
    for mask in range(n_masks):
        ends[mask] = total
        for bit in range(len(losses)):
            if mask >> bit & 1:
                ends[mask] += losses[bit]
    return ends


@njit(cache=True)
def _rounding(problem: Problem, length: int, pays: FloatArray, ends: FloatArray) -> float:
    """More than single precision can lose in 2 l + 3 additions of numbers of this size."""
    costliest, latest = 0.0, 0.0
    for cost in problem.costs:
        costliest = max(costliest, -cost)
    for values in (problem.end, ends):
        size = 0.0
        for x in values:
            if x > -np.inf:
                size = max(size, abs(x))
        latest += size
    most = 0.0
    for k in range(1, length + 1):
        for s in range(pays.shape[1]):
            most = max(most, pays[k, s])
    return 4e-7 * (length + 2) * (latest + length * (costliest + most))


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
