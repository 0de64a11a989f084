"""Random subtrees of a derivation that keep g_user = 0.

A player's expression c_1 .. c_g is an automaton that reads the action string. In state i the first
i classes have been passed; an action of class c_(i + 1) leads to i + 1, another one stays. Actions
that only a diagram may ask for (:func:`motiondb.scene.language.expressions.exact_actions`: a pass
has a receiver, a catch a passer) lead nowhere else, unless they continue a repeated class.

Subtrees are drawn by the sums over this automaton (:mod:`motiondb.grammar.cfg.trees`): one has
exactly the probability of the grammar given that it leads from i to one of the states that are
allowed after it, so no draw is rejected. Two subtrees of the same node have probabilities whose
ratio is that of the products of their rules: the probability of the condition depends on what is
outside, so it cancels in the ratio of a proposal and its reverse.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5 ("until P(X') > 0").
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.errors import SceneError
from motiondb.grammar.cfg.automata import Automaton, chain
from motiondb.grammar.cfg.closure import SUM
from motiondb.grammar.cfg.compiled import compile_grammar
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.cfg.inside import inside
from motiondb.grammar.cfg.trees import Trees, drawn
from motiondb.records import FloatArray
from motiondb.scene.language.expressions import Item

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
        compiled = compile_grammar(grammar)
        self._names = compiled.names
        self._numbers = {name: number for number, name in enumerate(compiled.names)}
        chances = np.zeros(len(grammar.rules))
        chances[compiled.rule_numbers] = compiled.probabilities
        with np.errstate(divide="ignore"):
            self._log_weights = np.log(chances).tolist()
        closed = frozenset(only_asked)
        self._next = _transitions(compiled.names[compiled.terminals], self.items, closed)
        made = inside(compiled, _automaton(self._next, self.n_states))
        if not made.weight(compiled.start) > 0.0:
            wanted = "".join(map(str, self.items))
            raise SceneError(
                f"grammar: expected a string from {grammar.start} that fits {wanted}, found none."
                " Change the order of what is asked, or add a rule that allows it."
            )
        self._trees = Trees(compiled, made, compiled.weights(SUM))
        self._inside: dict[str, FloatArray] = {}

    def inside(self, symbol: str) -> FloatArray:
        """Return I_A: array (states, states), the probability of leading from one to another."""
        known = self._inside.get(symbol)
        if known is None:
            known = np.zeros((self.n_states, self.n_states))
            if symbol in self._numbers:
                for i, j in np.ndindex(known.shape):
                    known[i, j] = self._trees.made.weight(self._numbers[symbol], i, j)
            self._inside[symbol] = known  # whole: other threads ask, too
        return known

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
        until = ends[drawn(self.inside(symbol)[since, ends], rng)]
        tree = self._trees.draw((self._numbers[symbol], since, until), rng, most)
        if tree is None:
            return None
        return Derivation(tuple(tree[0]), tuple(self._names[number] for number in tree[1]))


def _transitions(
    terminals: Sequence[str], items: Sequence[Item], closed: frozenset[str]
) -> dict[str, list[int]]:
    """Return for every terminal the state that it leads to from each state."""
    next_states = {}
    for action in terminals:
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


def _automaton(steps: dict[str, list[int]], n_states: int) -> Automaton:
    """Return the automaton of steps by terminal and state."""
    reached = np.array(list(steps.values())).reshape(-1, n_states).T
    states = np.arange(n_states)[:, None]
    return chain((reached[:-1] == states[1:]) * 1.0, (reached == states) * 1.0)
