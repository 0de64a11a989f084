"""Weighted automata that read strings of terminals, for the engine (:mod:`.inside`).

States are numbered in blocks: edges lead to the same or a later block, never back. Nearly always a
block is one state. What such a state reads without leaving it is its *loop class*: all states of a
class have the same weights of strings that lead from the state to itself.

    sentence a b c        0 -a-> 1 -b-> 2 -c-> 3
    strings of length n   0 -any-> 1 (-any-> 2 ..., which need not be filled: see ``shift``)
    pattern a ... b       0 -a-> 1 -b-> 2, state 1 stays on anything
    pattern ... a b ...   states 0 and 1 lead to each other (a block) until a is followed by b
    diagram               a state an item; other actions stay
    plan                  a state a symbol of the prefix, then a state a goal
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from motiondb.records import BoolArray, FloatArray, IntArray


class Automaton(NamedTuple):
    """An automaton of Q states; a string is read from state 0. Terminals are numbered from 0."""

    starts: IntArray  # (Q + 1,): the edges of state s are ``starts[s]:starts[s + 1]``
    targets: IntArray  # (E,): state that each edge leads to, ascending for each state
    terminals: IntArray  # (E,): what each edge reads
    weights: FloatArray  # (E,)
    loops: IntArray  # (Q,): loop class of each state, -1 in a block of several states
    stays: FloatArray  # (classes, terminals): weight of staying on a terminal, 0 if it does not
    bounds: IntArray  # (blocks + 1,): the states of block b are ``bounds[b]:bounds[b + 1]``
    final: BoolArray  # (Q,): whether a string may end in each state

    @property
    def n_states(self) -> int:
        """Number of states, Q."""
        return len(self.loops)


def sentence(numbers: IntArray, n_terminals: int) -> Automaton:
    """Return the automaton of one string; `numbers` (n,) of terminals."""
    return _line(len(numbers), n_terminals)._replace(terminals=numbers)


@lru_cache(maxsize=64)
def _line(n: int, n_terminals: int) -> Automaton:
    final = np.zeros(n + 1, np.bool_)
    final[n] = True
    states, stays = np.arange(n + 1), np.zeros((1, n_terminals))
    starts, loops, bounds = np.append(states, n), np.zeros(n + 1, np.int64), np.arange(n + 2)
    return Automaton(starts, states[1:], states[1:], np.ones(n), loops, stays, bounds, final)


def lengths(n: int, n_terminals: int) -> Automaton:
    """Return the first edges of the automaton of all strings of n symbols (see ``shift``)."""
    moves = np.zeros((n, n_terminals))
    moves[:1] = 1.0
    return chain(moves, np.zeros((n + 1, n_terminals)))


def chain(moves: FloatArray, stays: FloatArray) -> Automaton:
    """Return an automaton whose state k leads to k + 1 or stays, and whose last state is final.

    `moves` (Q - 1, terminals) and `stays` (Q, terminals) are weights, 0 where there is no edge.

    >>> made = chain(np.array([[1.0, 0.0]]), np.array([[0.0, 1.0], [0.0, 0.0]]))
    >>> made.targets.tolist(), made.terminals.tolist(), made.loops.tolist()
    ([1], [0], [0, 1])
    """
    sources, read = np.nonzero(moves)
    final = np.zeros(len(stays), np.bool_)
    final[-1] = True
    return _automaton((sources, sources + 1, read), moves[sources, read], stays, final)


def from_steps(steps: BoolArray, final: BoolArray, bounds: IntArray) -> Automaton:
    """Return the automaton of steps (Q, terminals, Q), with given blocks of its states."""
    alone = np.repeat(np.diff(bounds) == 1, np.diff(bounds))
    same = np.arange(len(final))
    stays = np.where(alone[:, None], steps[same, :, same], False).astype(np.float64)
    edges = steps.copy()
    edges[same[alone], :, same[alone]] = False
    sources, targets, read = np.nonzero(edges.transpose(0, 2, 1))
    made = _automaton((sources, targets, read), np.ones(len(read)), stays, final)
    return made._replace(loops=np.where(alone, made.loops, -1), bounds=bounds)


def _automaton(
    edges: tuple[IntArray, IntArray, IntArray],
    weights: FloatArray,
    stays: FloatArray,
    final: BoolArray,
) -> Automaton:
    """Put edges, sorted by their sources and targets, and what stays (Q, terminals) together."""
    sources, targets, read = edges
    n = len(stays)
    classes: dict[bytes, int] = {}
    loops = [classes.setdefault(row.tobytes(), len(classes)) for row in stays]
    first = [loops.index(number) for number in range(len(classes))]
    starts = np.searchsorted(sources, np.arange(n + 1))
    return Automaton(
        starts,
        np.ascontiguousarray(targets),
        np.ascontiguousarray(read),
        weights,
        np.array(loops),
        np.ascontiguousarray(stays[first]),
        np.arange(n + 1),
        final,
    )


def items(moves: Sequence[IntArray], stays: Sequence[IntArray], weights: FloatArray) -> Automaton:
    """Return a chain by the terminals that each state moves on and stays on.

    Shapes: `weights` (terminals,), of every terminal. There is one state more than `moves`.
    """
    rows = np.zeros((2, len(stays), len(weights)))
    for table, numbers in zip(rows, (moves, stays), strict=True):
        for row, some in zip(table, numbers, strict=False):
            row[some] = weights[some]
    return chain(rows[0, :-1], rows[1])
