"""Random subtrees of a derivation that keep g_user = 0.

A player's expression c_1 .. c_g is an automaton that reads the action string. In state i the first
i classes have been passed; an action of class c_(i + 1) leads to i + 1, another one stays. Actions
that only a diagram may ask for (:data:`motiondb.scene.language.expressions.ONLY_ASKED`: a pass has
a receiver, a catch a passer) lead nowhere else, unless they continue a repeated class. With
T_a[i, j] = 1 if the terminal a leads from i to j, the probability that a nonterminal A derives a
string that leads from i to j is the least solution of

    I_A = sum over rules r of A:  p_r  T_B1 T_B2 ..  (the matrices of the rule's right side)

From these sums, subtrees are drawn top down: a rule by p_r times its product, then the states
between its symbols. A subtree has exactly the probability of the grammar given that it leads from i
to one of the states that are allowed after it, so no draw is rejected. Two subtrees of the same
node have probabilities whose ratio is that of the products of their rules: the probability of the
condition depends on what is outside, so it cancels in the ratio of a proposal and its reverse.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5 ("until P(X') > 0"); the intersection of a context-free language with a
regular one, Y. Bar-Hillel, M. Perles and E. Shamir (1961).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.records import FloatArray
from motiondb.scene.language.expressions import Item

_TOLERANCE = 1e-14
"""Relative change of the sums at which the iteration ends: near the precision of floats."""
_ROUNDS = 10_000
"""Most rounds of the iteration; the grammars that are shipped need fewer than a hundred."""
NOWHERE = -1  # State of a string that cannot be continued


@dataclass(frozen=True)
class Derivation:
    """A subtree: its rules in preorder, and the actions that it derives."""

    rules: tuple[int, ...]
    actions: tuple[str, ...]


class Derivations:
    """The derivations of a grammar that fit an expression.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = Derivations(read_grammar("S -> a | b S"), [Item(("a",))])
    >>> round(float(toy.inside("S")[0, 1]), 9), toy.run(["b", "a"])
    (1.0, [0, 0, 1])
    """

    def __init__(
        self, grammar: Grammar, items: Sequence[Item], only_asked: Collection[str] = ()
    ) -> None:
        self.grammar = grammar
        self.items = tuple(items)
        self.n_states = len(self.items) + 1
        weights = [rule.probability for rule in grammar.rules]
        with np.errstate(divide="ignore"):
            self._log_weights = np.log(np.array(weights, dtype=float)).tolist()
        for closed in (frozenset(only_asked), frozenset[str]()):
            self._next = _transitions(grammar, self.items, closed)
            self._inside, self._rests = _inside_sums(grammar, self._next, self.n_states)
            if self._inside[grammar.start][0, -1] > 0.0:
                break
        else:
            wanted = "".join(map(str, self.items))
            raise SceneError(
                f"grammar: expected a string from {grammar.start} that fits {wanted}, found none."
                " Change the order of what is asked, or add a rule that allows it."
            )
        self._rules: dict[tuple[str, int, int], tuple[list[float], list[int]]] = {}
        self._states: dict[tuple[int, int, int, int], tuple[list[float], list[int]]] = {}

    def inside(self, symbol: str) -> FloatArray:
        """Return I_A: array (states, states), the probability of leading from one to another."""
        return self._inside[symbol]

    def run(self, actions: Sequence[str], state: int = 0) -> list[int]:
        """Return the states before every action and after the last; NOWHERE after a dead end."""
        states = [state]
        for action in actions:
            state = self._next[action][state] if state >= 0 else NOWHERE
            states.append(state)
        return states

    def fits(self, actions: Sequence[str]) -> bool:
        """Return whether a string leads from the first state to the last."""
        return self.run(actions)[-1] == self.n_states - 1

    def ends_before(self, actions: Sequence[str]) -> list[int]:
        """Return the states from which ``actions`` lead to the last one."""
        last = self.n_states - 1
        return [s for s in range(self.n_states) if self.run(actions, s)[-1] == last]

    def log_probability(self, rules: Sequence[int]) -> float:
        """Return the logarithm of the product of rule probabilities."""
        return math.fsum(self._log_weights[rule] for rule in rules)

    def draw(
        self,
        symbol: str,
        since: int,
        ends: Sequence[int],
        rng: np.random.Generator,
        most: int = 10_000,
    ) -> Derivation | None:
        """Draw a subtree of ``symbol`` that leads from state ``since`` to one of ``ends``.

        The result is None if it grew over ``most`` actions. A proposal of a string that is too long
        is thus rejected.
        """
        sums = self._inside[symbol]
        until = ends[_drawn(_cumulative([float(sums[since, end]) for end in ends]), rng.random())]
        rules: list[int] = []
        actions: list[str] = []
        waiting = [(symbol, since, until)]
        random = rng.random
        while waiting:
            symbol, i, j = waiting.pop()
            if not self.grammar.is_nonterminal(symbol):
                actions.append(symbol)
                if len(actions) > most:
                    return None
                continue
            sums_of, numbers = self._rules_of(symbol, i, j)
            rule = numbers[_drawn(sums_of, random())]
            rules.append(rule)
            waiting += self._parts(rule, i, j, random)[::-1]
        return Derivation(tuple(rules), tuple(actions))

    def _rules_of(self, symbol: str, i: int, j: int) -> tuple[list[float], list[int]]:
        weighted = self._rules.get((symbol, i, j))
        if weighted is None:
            numbers = list(self.grammar.rules_of[symbol])
            rules = self.grammar.rules
            weights = [rules[n].probability * float(self._rests[n][0][i, j]) for n in numbers]
            weighted = self._rules[symbol, i, j] = _cumulative(weights), numbers
        return weighted

    def _parts(
        self, rule: int, i: int, j: int, random: Callable[[], float]
    ) -> list[tuple[str, int, int]]:
        """Return a rule's symbols with the states that they lead from and to."""
        parts = []
        right = self.grammar.rules[rule].right
        for k, symbol in enumerate(right):
            state = j
            if k + 1 < len(right):
                key = rule, k, i, j
                ways = self._states.get(key)
                if ways is None:
                    both = self._matrix(symbol)[i] * self._rests[rule][k + 1][:, j]
                    ways = self._states[key] = _cumulative(both.tolist()), []
                state = _drawn(ways[0], random())
            parts.append((symbol, i, state))
            i = state
        return parts

    def _matrix(self, symbol: str) -> FloatArray:
        return self._inside[symbol]


def _cumulative(weights: Sequence[float]) -> list[float]:
    """Return cumulative sums divided by the total; the last one exceeds every random number."""
    sums: list[float] = np.cumsum(weights).tolist()
    whole = sums[-1]
    last = max(k for k, weight in enumerate(weights) if weight > 0.0)
    return [value / whole if k < last else 2.0 for k, value in enumerate(sums)]


def _drawn(sums: list[float], u: float) -> int:
    return bisect_right(sums, u)


def _transitions(
    grammar: Grammar, items: Sequence[Item], closed: frozenset[str]
) -> dict[str, list[int]]:
    """Return for every terminal the state that it leads to from each state."""
    next_states = {}
    for action in grammar.terminals:
        row = []
        for state in range(len(items) + 1):
            if state < len(items) and action in items[state].actions:
                row.append(state + 1)
                continue
            before = items[state - 1] if state else None
            goes_on = before is not None and before.repeated and action in before.actions
            row.append(state if goes_on or action not in closed else NOWHERE)
        next_states[action] = row
    return next_states


def _inside_sums(
    grammar: Grammar, steps: dict[str, list[int]], n: int
) -> tuple[dict[str, FloatArray], list[list[FloatArray]]]:
    """Return I of every symbol, and for every rule the products of the ends of its right side.

    It is the least solution, by iteration from 0: each round adds deeper trees.
    """
    sums = {}
    for action, row in steps.items():
        sums[action] = np.zeros((n, n))
        for i, j in enumerate(row):
            if j >= 0:
                sums[action][i, j] = 1.0
    for symbol in grammar.nonterminals:
        sums[symbol] = np.zeros((n, n))
    for _ in range(_ROUNDS):
        change = 0.0
        for symbol in grammar.nonterminals:
            new = np.zeros((n, n))
            for number in grammar.rules_of[symbol]:
                rule = grammar.rules[number]
                new += rule.probability * _rests(rule.right, sums, n)[0]
            grown = new - sums[symbol]
            change = max(change, float((grown / np.where(new > 0, new, 1.0)).max()))
            sums[symbol] = new
        if change < _TOLERANCE:
            break
    return sums, [_rests(rule.right, sums, n) for rule in grammar.rules]


def _rests(right: Sequence[str], sums: dict[str, FloatArray], n: int) -> list[FloatArray]:
    """Return the products of the matrices of a right side from each symbol to the end."""
    products = [np.eye(n)]
    for symbol in reversed(right):
        products.append(sums[symbol] @ products[-1] if len(products) > 1 else sums[symbol])
    return products[::-1]
