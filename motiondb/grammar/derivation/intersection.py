"""Intersection of a grammar with an automaton: weights of each symbol between pairs of states.

An item (X, s, t) is the set of strings that a symbol X derives and that lead the automaton from
state s to state t. Its weight W is the sum of the probabilities of these derivations, and V the
greatest of them:

    W(A, s, t) = sum p(A -> Y) W(Y, s, t),    W(Y Z, s, t) = sum over u of W(Y, s, u) W(Z, u, t),

and V with the maximum for the sum. The automaton reads each string in one way at most, so no string
is counted twice.

The states are in blocks that steps never leave backwards (:class:`.pattern.Acceptor`). The weights
between two blocks depend only on those between blocks that lie from the one to the other, so pairs
of blocks are solved one after another, the nearest first. What blocks strictly between them give is
computed once. The remainder is a least solution, found by iteration component by component of the
symbols. Most blocks have one state, and an iteration is then as short as the list of rules. Strings
that lead from such a state to itself hold the terminals of its gap only; W of these is found by
Newton's method (:mod:`motiondb.grammar.cfg.least_solution`).

Sources: Y. Bar-Hillel, M. Perles and E. Shamir, "On Formal Properties of Simple Phrase Structure
Grammars" (1961); M.-J. Nederhof and G. Satta, "Probabilistic Parsing as Intersection", IWPT 2003.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.least_solution import least_solution, part_groups
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form
from motiondb.grammar.derivation.pattern import Acceptor, Pattern, acceptor_of
from motiondb.records import BoolArray, FloatArray, IntArray

_CLOSE = 1e-13  # Relative change of a weight below which an iteration has converged

_MOST_ROUNDS = 100_000
"""Largest number of iterations. Chosen by hand: a loop that continues with probability 0.999
needs 30,000."""


_Pair = tuple[int, int, int, int]
"""First state of a block and the state after its last one, and the same of another block."""


@dataclass(frozen=True, eq=False)
class Intersection:
    """A grammar and an automaton."""

    compiled: CompiledGrammar
    automaton: Acceptor  # The automaton over its terminals
    sums: FloatArray  # (symbols, states, states): w

    @property
    def ends(self) -> FloatArray:
        """The probability (states,) of sentences that lead to each accepting state, else 0."""
        return np.where(self.automaton.accepting, self.sums[self.compiled.start, 0], 0.0)


def intersect(
    grammar: AnyGrammar, pattern: Pattern, allowed: frozenset[str] | None = None
) -> Intersection:
    """Intersect a grammar with the automaton of a pattern."""
    compiled = compiled_form(grammar)
    automaton = acceptor_of(pattern, compiled.names[compiled.terminals], allowed)
    return Intersection(compiled, automaton, weights_of(compiled, automaton, best=False))


def weights_of(compiled: CompiledGrammar, automaton: Acceptor, *, best: bool) -> FloatArray:
    """Return the weights of all items; result (symbols, states, states)."""
    n = len(automaton.steps)
    weights = np.zeros((compiled.n_symbols, n, n))
    weights[compiled.terminals] = automaton.steps.transpose(1, 0, 2)
    groups = part_groups(compiled, np.ones(compiled.n_symbols, bool))
    equations = _Equations(
        np.concatenate([group for group, _ in groups]),
        np.cumsum([0, *(len(group) for group, _ in groups)]),
        np.array([c for _, c in groups]),
        compiled.rule_of,
        compiled.rule_right,
        compiled.probabilities,
        compiled.left,
        compiled.right,
    )
    alone = np.zeros(n, dtype=np.bool_)
    if not best:
        alone[automaton.bounds[:-1][np.diff(automaton.bounds) == 1]] = True
        for state in np.flatnonzero(alone).tolist():
            weights[:, state, state] = _staying(compiled, automaton.steps[state, :, state])
    _solve(equations, automaton.bounds, alone, weights, best)
    return weights


def _staying(compiled: CompiledGrammar, terminals: BoolArray) -> FloatArray:
    """Return the probability (symbols,) of strings of certain terminals only."""
    if terminals.all():
        return compiled.ends
    if not terminals.any():
        return compiled.empties
    return least_solution(compiled, terminals, np.ones(compiled.n_symbols, bool))


class _Equations(NamedTuple):
    """The equations of the symbols.

    rule_of, rule_right, probabilities, left, right : array
        As in :class:`.compiled.CompiledGrammar`.
    """

    members: IntArray  # (S,): the symbols, component by component, parts first
    bounds: IntArray  # (components + 1,): index of the first member of each component
    cyclic: BoolArray  # (components,): whether a component has a cycle
    rule_of: IntArray
    rule_right: IntArray
    probabilities: FloatArray
    left: IntArray
    right: IntArray


@njit(cache=True)
def _solve(
    equations: _Equations, blocks: IntArray, alone: BoolArray, weights: FloatArray, best: bool
) -> None:
    """Fill the weights of pairs of blocks, the nearest first; ``blocks`` (blocks + 1,) bounds them.

    Given are the weights of terminals, and those from a state to itself for the states ``alone``.
    """
    largest = np.diff(blocks).max()
    between = np.zeros((weights.shape[0], largest, largest))
    new = np.empty((largest, largest))
    for apart in range(blocks.size - 1):
        for b in range(blocks.size - 1 - apart):
            c = b + apart
            pair = blocks[b], blocks[b + 1], blocks[c], blocks[c + 1]
            if apart > 1:
                _add_between(equations, pair, weights, between, best)
            if b < c or not alone[blocks[b]]:
                _solve_pair(equations, pair, weights, (between, new), best)


@njit(cache=True)
def _add_between(
    equations: _Equations, pair: _Pair, weights: FloatArray, between: FloatArray, best: bool
) -> None:
    """Fill ``between`` (symbols, s, t) with what states strictly between two blocks give."""
    first, first_end, last, last_end = pair
    for symbol in range(weights.shape[0]):
        left, right = equations.left[symbol], equations.right[symbol]
        if left < 0:
            continue
        for s in range(first, first_end):
            total = between[symbol, s - first]
            total[:] = 0.0
            for u in range(first_end, last):
                if weights[left, s, u] > 0.0:
                    _add(total, weights[left, s, u], weights[right, u, last:last_end], best)


@njit(cache=True)
def _solve_pair(
    equations: _Equations,
    pair: _Pair,
    weights: FloatArray,
    work: tuple[FloatArray, FloatArray],
    best: bool,
) -> None:
    """Fill the weights between two blocks, component by component of the symbols."""
    first, first_end, last, last_end = pair
    new = work[1]
    for g in range(equations.cyclic.size):
        for _ in range(_MOST_ROUNDS):
            changed = False
            for symbol in equations.members[equations.bounds[g] : equations.bounds[g + 1]]:
                if not _evaluate(symbol, equations, pair, weights, work, best):
                    continue
                for s in range(first, first_end):
                    for t in range(last, last_end):
                        old, risen = weights[symbol, s, t], new[s - first, t - last]
                        if risen > old:
                            changed = changed or risen - old > _CLOSE * risen
                            weights[symbol, s, t] = risen
            if not changed or not equations.cyclic[g]:
                break


@njit(cache=True)
def _evaluate(
    symbol: int,
    equations: _Equations,
    pair: _Pair,
    weights: FloatArray,
    work: tuple[FloatArray, FloatArray],
    best: bool,
) -> bool:
    """Fill ``new`` with the right side of the equation of a symbol; False for a terminal."""
    first, first_end, last, last_end = pair
    between, new = work
    n = last_end - last
    if equations.left[symbol] >= 0:
        for s in range(first, first_end):
            row = new[s - first, :n]
            row[:] = 0.0
            if first_end < last:
                row[:] = between[symbol, s - first, :n]
            _add_tail(row, symbol, s, (equations, pair), weights, best)
        return True
    rules = range(equations.rule_of[symbol], equations.rule_of[symbol + 1])
    for s in range(first, first_end):
        row = new[s - first, :n]
        row[:] = 0.0
        for r in rules:
            below, chance = equations.rule_right[r], equations.probabilities[r]
            if below >= 0:
                _add(row, chance, weights[below, s, last:last_end], best)
            elif first == last:
                row[s - first] = max(row[s - first], chance) if best else row[s - first] + chance
    return len(rules) > 0


@njit(cache=True)
def _add_tail(
    row: FloatArray,
    symbol: int,
    s: int,
    where: tuple[_Equations, _Pair],
    weights: FloatArray,
    best: bool,
) -> None:
    """Add what a tail gives from state s by way of the two blocks of a pair themselves."""
    equations, (first, first_end, last, last_end) = where
    left, right = equations.left[symbol], equations.right[symbol]
    for u in range(first, first_end):
        if weights[left, s, u] > 0.0:
            _add(row, weights[left, s, u], weights[right, u, last:last_end], best)
    for u in range(max(last, first_end), last_end):
        if weights[left, s, u] > 0.0:
            _add(row, weights[left, s, u], weights[right, u, last:last_end], best)


@njit(cache=True)
def _add(new: FloatArray, factor: float, values: FloatArray, best: bool) -> None:
    """Add the product of a factor and values to ``new``, or take the greater of both."""
    for t in range(new.size):
        value = factor * values[t]
        new[t] = max(new[t], value) if best else new[t] + value
