"""The arrays of one decoding question, and the log-probability of a sequence.

Notation as in :mod:`motiondb.language.translation.decoding`. Symbols whose rows of transitions are
equal (those of one cluster) form a *row*, so that the dynamic programs run over rows, not symbols.
The symbols of each word are split into those that *say* it and the rest, see
:mod:`.decoding_kernels`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.records import FloatArray, IntArray

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
