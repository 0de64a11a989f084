"""What decoding asks, and how good a sequence can still become: the bounds of the A* search.

Notation as in :mod:`motiondb.words.decoding`. Symbols whose rows of transitions are equal (those
of one cluster) form a *row*, so that the dynamic programs run over rows, not symbols.

Two upper bounds of the same kind, both from log x <= log q + x / q - 1. The first holds every word
to it, and its q are found by Frank-Wolfe steps, whose sequences are first answers. It forgets that
a word which no symbol says is lost for good: half a sequence that says it already scores well. The
second therefore splits the symbols of each word into those that *say* it and the rest, and its
dynamic program carries the set of words not yet said (a bit mask): a word never said is held to
the most that the rest can give. Where there are more than ``TRACKED`` words, only those with the
widest split are tracked.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray

TRACKED = 6
"""Words whose being said is tracked: 2^6 masks."""
ROUNDS = 4
"""Frank-Wolfe steps per length at most."""
SLACK = 1e-10
"""Nats by which a bound may exceed the best sequence and still count as no better (rounding)."""
LEAST = 1e-12
"""The smallest q."""


class Problem(NamedTuple):
    """Log-probabilities unless said otherwise.

    Attributes
    ----------
    t : array (S + 1, m), probability; row 0 is NULL.
    alignments : array (L + 1, m, L + 1), a(i | j, l, m) at [l, j, i].
    row_of : array (S + 1,), the row of the begin, then of every symbol.
    starts : array (rows + 1,); row r goes to followers[starts[r]:starts[r + 1]] at those costs.
    followers, costs : arrays (edges,), symbol numbers and log-probabilities.
    end : array (rows,).
    lengths : array (L + 1,), log P(l | m).
    says : array (S,), bit mask of the tracked words that a symbol says.
    tracked : array (TRACKED or m,), which words have bits 0, 1, ...
    unsaid : array (m,), the most that a symbol which does not say word j gives it, probability.
    usual : array (m,), what a symbol that says word j gives it on average, probability.
    """

    t: FloatArray
    alignments: FloatArray
    row_of: IntArray
    starts: IntArray
    followers: IntArray
    costs: FloatArray
    end: FloatArray
    lengths: FloatArray
    says: IntArray
    tracked: IntArray
    unsaid: FloatArray
    usual: FloatArray


def pose_problem(
    t: FloatArray, alignments: FloatArray, log_transitions: FloatArray, log_lengths: FloatArray
) -> Problem:
    """Join equal rows of transitions, keep the possible ones, split the symbols of each word."""
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
    """Which symbols say which words: the split of log t with the largest variance between (Otsu).

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
    sums = a[:, 0] * problem.t[0]
    for k in range(len(path)):
        sums += a[:, k + 1] * problem.t[path[k] + 1]
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
def symbol_pays(problem: Problem, length: int, q: FloatArray) -> FloatArray:
    """What symbol s pays at position k: sum_j a(k | j) t(j | s) / q_j, array (l + 1, S)."""
    n_symbols, m = len(problem.says), len(q)
    pays = np.zeros((length + 1, n_symbols))
    for k in range(1, length + 1):
        for j in range(m):
            weight = problem.alignments[length, j, k] / q[j]
            for s in range(n_symbols):
                pays[k, s] += weight * problem.t[s + 1, j]
    return pays


@njit(cache=True)
def offer(problem: Problem, path: IntArray, best: IntArray, value: float) -> float:
    """Take a sequence into ``best`` (length first) where it is better; returns the best value."""
    found = sequence_value(problem, path)
    if found > value:
        best[0] = len(path)
        best[1 : len(path) + 1] = path
        return found
    return value


@njit(cache=True)
def relax(
    problem: Problem, length: int, q: FloatArray, best: IntArray, value: float
) -> tuple[float, float]:
    """Frank-Wolfe on the first bound of one length; improves ``best`` and ``q`` in place.

    Returns the least upper bound of the length, and the value of ``best``.
    """
    m = len(q)
    x, x_moves, upper = np.empty(m), 0.0, np.inf
    for step in range(ROUNDS):
        path, linear = _best_path(problem, length, symbol_pays(problem, length, q))
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
            x[:], x_moves = y, y_moves
        x_moves += share * (y_moves - x_moves)
        for j in range(m):
            x[j] += share * (y[j] - x[j])
            q[j] = max(LEAST, x[j])
    return upper, value


@njit(cache=True)
def _best_path(problem: Problem, length: int, pays: FloatArray) -> tuple[IntArray, float]:
    """The sequence of the largest transitions and pays together, by dynamic programming."""
    n_rows = len(problem.end)
    onward = np.zeros((length, n_rows), dtype=np.int64)
    path = np.zeros(length, dtype=np.int64)
    ahead, before = problem.end.copy(), np.empty(n_rows)
    for k in range(length - 1, -1, -1):
        for row in range(n_rows):
            top = -np.inf
            for edge in range(problem.starts[row], problem.starts[row + 1]):
                r = problem.followers[edge]
                total = problem.costs[edge] + pays[k + 1, r] + ahead[problem.row_of[r + 1]]
                if total > top:
                    top, onward[k, row] = total, r
            before[row] = top
        ahead, before = before, ahead
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
    """q for the second bound: where a word is usually when one symbol in its best place says it.

    Untracked words keep their q; a q that is larger already stays.
    """
    level = q.copy()
    for j in problem.tracked:
        a = problem.alignments[length, j]
        level[j] = max(q[j], a[0] * problem.t[0, j] + a[1 : length + 1].max() * problem.usual[j])
    return level


@njit(cache=True)
def track(problem: Problem, length: int, q: FloatArray, pays: FloatArray) -> Float32Array:
    """The second bound of one length.

    Returns
    -------
    ahead : array (l + 1, rows, masks), an upper bound of what comes after position k from a row,
        with the words of the mask not yet said; the linearised logarithms are part of it, what
        earlier positions paid is not. ahead[0, row of the begin, all words], with the length's
        log-probability, bounds every sequence of the length. In single precision for speed;
        raised by more than its rounding errors can amount to.
    """
    n_rows, n_symbols = len(problem.end), len(problem.says)
    n_masks = 1 << len(problem.tracked)
    ahead = np.full((length + 1, n_rows, n_masks), np.float32(-np.inf), dtype=np.float32)
    ends = _ends(problem, length, q, n_masks)
    pad = _rounding(problem, length, pays, ends)
    for mask in range(n_masks):
        ahead[length, :, mask] = (problem.end + ends[mask] + pad).astype(np.float32)
    step = np.empty((n_symbols, n_masks), dtype=np.float32)
    for k in range(length - 1, -1, -1):
        for s in range(n_symbols):
            row, pay = ahead[k + 1, problem.row_of[s + 1]], np.float32(pays[k + 1, s])
            for mask in range(n_masks):
                step[s, mask] = pay + row[mask & ~problem.says[s]]
        for row in range(n_rows):
            if k == 0 and row != problem.row_of[0]:
                continue
            top = ahead[k, row]
            for edge in range(problem.starts[row], problem.starts[row + 1]):
                cost, onward = np.float32(problem.costs[edge]), step[problem.followers[edge]]
                for mask in range(n_masks):
                    total = cost + onward[mask]
                    top[mask] = total if total > top[mask] else top[mask]
    return ahead


@njit(cache=True)
def _ends(problem: Problem, length: int, q: FloatArray, n_masks: int) -> FloatArray:
    """The constant part of the bound for each set of words never said, array (masks,)."""
    total = 0.0
    losses = np.zeros(len(problem.tracked))
    for j in range(len(q)):
        a = problem.alignments[length, j, : length + 1]
        null = a[0] * problem.t[0, j]
        said = np.log(q[j]) - 1.0 + null / q[j]
        total += said
        most = null + a[1:].sum() * problem.unsaid[j]
        for bit in range(len(losses)):
            if problem.tracked[bit] == j:
                losses[bit] = min(0.0, np.log(most) - said) if most > 0.0 else -np.inf
    ends = np.full(n_masks, total)
    for mask in range(n_masks):
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
    return 4e-7 * (length + 2) * (latest + length * (costliest + pays.max()))
