"""Intersection of a grammar with an automaton: weights of each symbol between pairs of states.

An item (X, s, t) is the set of strings that a symbol X derives and that lead the automaton from
state s to state t. Its weight W is the sum of the probabilities of these derivations, and V the
greatest of them:

    W(A, s, t) = sum p(A -> Y) W(Y, s, t),    W(Y Z, s, t) = sum over u of W(Y, s, u) W(Z, u, t),

and V with the maximum for the sum. Both are least solutions, found by iteration component by
component. The automaton is deterministic, so no string is counted twice.

Sources: Y. Bar-Hillel, M. Perles and E. Shamir, "On Formal Properties of Simple Phrase Structure
Grammars" (1961); M.-J. Nederhof and G. Satta, "Probabilistic Parsing as Intersection", IWPT 2003.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.least_solution import part_groups
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form
from motiondb.grammar.derivation.pattern import Automaton, Pattern, automaton_of
from motiondb.records import FloatArray, IntArray

_CLOSE = 1e-13
"""Relative change of a weight below which an iteration has converged."""

_MOST_ROUNDS = 100_000
"""Largest number of iterations. Chosen by hand: a loop that continues with probability 0.999
needs 30,000."""


@dataclass(frozen=True, eq=False)
class Intersection:
    """A grammar and an automaton.

    Attributes
    ----------
    compiled : CompiledGrammar
        The grammar.
    automaton : Automaton
        The automaton over its terminals.
    sums : array (symbols, states, states)
        W.
    """

    compiled: CompiledGrammar
    automaton: Automaton
    sums: FloatArray

    @property
    def ends(self) -> FloatArray:
        """The probability (states,) of sentences that lead to each accepting state, else 0."""
        return np.where(self.automaton.accepting, self.sums[self.compiled.start, 0], 0.0)


def intersect(
    grammar: AnyGrammar, pattern: Pattern, allowed: frozenset[str] | None = None
) -> Intersection:
    """Intersect a grammar with the automaton of a pattern.

    Parameters
    ----------
    grammar : Grammar or CompiledGrammar
        The grammar.
    pattern : Pattern
        The pattern.
    allowed : frozenset of str, optional
        Terminals that a sentence may hold; all unless given.

    Raises
    ------
    GrammarError
        The grammar derives nothing, or the pattern has too many states.
    """
    compiled = compiled_form(grammar)
    automaton = automaton_of(pattern, compiled.names[compiled.terminals], allowed)
    return Intersection(compiled, automaton, weights_of(compiled, automaton, best=False))


def weights_of(compiled: CompiledGrammar, automaton: Automaton, *, best: bool) -> FloatArray:
    """Return the weights of all items.

    Parameters
    ----------
    compiled : CompiledGrammar
        The grammar.
    automaton : Automaton
        The automaton over its terminals.
    best : bool
        Whether to compute V instead of W.

    Returns
    -------
    array (symbols, states, states)
        W or V.
    """
    n = len(automaton.steps)
    weights = np.zeros((compiled.n_symbols, n, n))
    states = np.arange(n)
    for place, symbol in enumerate(range(compiled.terminals.start, compiled.terminals.stop)):
        after = automaton.steps[:, place]
        weights[symbol, states[after >= 0], after[after >= 0]] = 1.0
    groups = part_groups(compiled, np.ones(compiled.n_symbols, bool))
    members = np.concatenate([group for group, _ in groups])
    bounds = np.cumsum([0, *(len(group) for group, _ in groups)])
    cyclic = np.array([c for _, c in groups])
    rules = compiled.rule_of, compiled.rule_right, compiled.probabilities
    children = compiled.left, compiled.right
    _solve((members, bounds, cyclic), rules, children, weights, best)
    return weights


@njit(cache=True)
def _solve(
    groups: tuple[IntArray, IntArray, IntArray],
    rules: tuple[IntArray, IntArray, FloatArray],
    children: tuple[IntArray, IntArray],
    weights: FloatArray,
    best: bool,
) -> None:
    """Fill the weights component by component, parts first."""
    members, bounds, cyclic = groups
    n = weights.shape[1]
    new = np.empty((n, n))
    for g in range(cyclic.size):
        for _ in range(_MOST_ROUNDS):
            changed = False
            for symbol in members[bounds[g] : bounds[g + 1]]:
                if not _evaluate(symbol, rules, children, weights, new, best):
                    continue
                for s in range(n):
                    for t in range(n):
                        old = weights[symbol, s, t]
                        if new[s, t] > old:
                            changed = changed or new[s, t] - old > _CLOSE * new[s, t]
                            weights[symbol, s, t] = new[s, t]
            if not changed or not cyclic[g]:
                break


@njit(cache=True)
def _evaluate(
    symbol: int,
    rules: tuple[IntArray, IntArray, FloatArray],
    children: tuple[IntArray, IntArray],
    weights: FloatArray,
    new: FloatArray,
    best: bool,
) -> bool:
    """Fill ``new`` with the right side of the equation of a symbol; False for a terminal."""
    rule_of, rule_right, probabilities = rules
    n = weights.shape[1]
    left, right = children[0][symbol], children[1][symbol]
    first, last = rule_of[symbol], rule_of[symbol + 1]
    if left < 0 and first == last:
        return False
    new[:] = 0.0
    if left >= 0:
        for u in range(n):
            for s in range(n):
                if weights[left, s, u] > 0.0:
                    _add(new[s], weights[left, s, u], weights[right, u], best)
        return True
    empty = np.eye(n)
    for r in range(first, last):
        for s in range(n):
            inner = empty[s] if rule_right[r] < 0 else weights[rule_right[r], s]
            _add(new[s], probabilities[r], inner, best)
    return True


@njit(cache=True)
def _add(new: FloatArray, factor: float, values: FloatArray, best: bool) -> None:
    """Add the product of a factor and values to ``new``, or take the greater of both."""
    for t in range(new.size):
        value = factor * values[t]
        new[t] = max(new[t], value) if best else new[t] + value
