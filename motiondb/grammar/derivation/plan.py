"""Plan from the beginning of a sentence to a goal: the best continuation.

The string has the form w x g y. Here w is the prefix, x holds no goal, g is the first goal after w,
and y completes the sentence. Such strings are the paths of a small automaton from state 0 to its
last state. States 0..n follow w. A loop at n reads any terminal but the goal. The goal leads from
n to n + 1, where a loop reads any terminal.

The best tree over the automaton is found like a shortest path. An item (X, s, t) states that symbol
X can lead from state s to state t. The cheapest item is settled first. The cost of a tree is -log
of its probability, or the number of symbols that it adds. The other of the two breaks ties.

Source: D. E. Knuth, "A Generalization of Dijkstra's Algorithm", Information Processing Letters 6
(1977).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count

import numpy as np

from motiondb.errors import suggestion
from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.context_free import GrammarError, Tree, derive_by
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form, fault_at, read_sentence

Item = tuple[int, int, int]
Cost = tuple[float, float]


@dataclass(frozen=True)
class Plan:
    """A continuation of a prefix."""

    # Terminals after the prefix, up to and including the goal. Empty without a goal
    to_goal: tuple[str, ...]
    then: tuple[str, ...]  # Terminals after the goal that complete the sentence
    tree: Tree  # The tree of the whole sentence, with the prefix
    log_probability: float  # Natural logarithm of the probability of the tree


def plan(
    grammar: AnyGrammar, prefix: Sequence[str], goal: str | None = None, *, shortest: bool = False
) -> Plan:
    r"""Return the most probable, or the shortest, continuation to a goal and to a full sentence.

    The most probable tree is chosen, not the most probable string. Of the shortest continuations,
    the one with the most probable tree is chosen.

    `goal`: A terminal that must follow. If the prefix holds it already, it must occur again.
    Without a goal the sentence is only completed.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> hold A\nA -> dribble A [0.6] | shoot [0.3] | pass S [0.1]")
    >>> found = plan(toy, ["hold"], "pass")
    >>> found.to_goal, found.then
    (('pass',), ('hold', 'shoot'))
    """
    compiled = compiled_form(grammar)
    viable = read_sentence(compiled, prefix)
    if viable.position < len(prefix):
        raise fault_at(compiled, tuple(prefix), viable)
    if goal is not None and goal not in compiled.ids:
        near = suggestion(goal, compiled.ids) or " Use a terminal of the grammar."
        raise GrammarError(f"goal: expected a terminal of the grammar, found {goal!r}.{near}")
    search = _Search(compiled, tuple(prefix), goal, shortest)
    top = search.run()
    if top is None:
        raise GrammarError(
            f"goal: expected that {goal!r} can come after {' '.join(prefix) or 'the beginning'!r},"
            " found no sentence of the grammar in which it does. Choose another goal, or plan"
            " from an earlier place."
        )
    choices = search.choices(top)
    tree = derive_by(compiled.grammar, compiled.rule_numbers[choices].tolist())
    rest = tree.leaves()[len(prefix) :]
    cut = 0 if goal is None else rest.index(goal) + 1
    chance = float(np.log(compiled.probabilities[choices]).sum())
    return Plan(rest[:cut], rest[cut:], tree, chance)


class _Search:
    """The agenda of items to settle, and the items that are settled."""

    def __init__(
        self, compiled: CompiledGrammar, prefix: tuple[str, ...], goal: str | None, shortest: bool
    ) -> None:
        self.compiled, self.prefix, self.goal, self.shortest = compiled, prefix, goal, shortest
        self.n_states = len(prefix) + (2 if goal is not None else 1)
        self.settled: dict[Item, tuple[int, tuple[Item, ...]]] = {}
        self.costs: dict[Item, Cost] = {}
        self.ending: defaultdict[tuple[int, int], list[int]] = defaultdict(list)
        self.beginning: defaultdict[tuple[int, int], list[int]] = defaultdict(list)
        self.agenda: list[tuple[Cost, int, Item, int, tuple[Item, ...]]] = []
        self.order = count()
        self.rules_to: defaultdict[int, list[int]] = defaultdict(list)
        for rule, symbol in enumerate(compiled.rule_right.tolist()):
            self.rules_to[symbol].append(rule)
        self.tails_left: defaultdict[int, list[int]] = defaultdict(list)
        self.tails_right: defaultdict[int, list[int]] = defaultdict(list)
        for tail in np.flatnonzero(compiled.left >= 0).tolist():
            self.tails_left[int(compiled.left[tail])].append(tail)
            self.tails_right[int(compiled.right[tail])].append(tail)
        self.log_costs = (-np.log(compiled.probabilities)).tolist()

    def run(self) -> Item | None:
        """Settle items, the cheapest first, until the start symbol spans all states."""
        top = (self.compiled.start, 0, self.n_states - 1)
        for cost, item, rule in self._first_items():
            heappush(self.agenda, (cost, next(self.order), item, rule, ()))
        while self.agenda:
            cost, _, item, rule, parts = heappop(self.agenda)
            if item in self.settled:
                continue
            self.settled[item], self.costs[item] = (rule, parts), cost
            if item == top:
                return top
            self._combine(item, cost)
        return None

    def _first_items(self) -> Iterator[tuple[Cost, Item, int]]:
        """Yield the items of terminals and of empty rules: cost, item, rule (-1 if none)."""
        ids, n = self.compiled.ids, len(self.prefix)
        for place, name in enumerate(self.prefix):
            yield (0.0, 0.0), (ids[name], place, place + 1), -1
        for state in range(n, self.n_states):
            for name, terminal in ids.items():
                to_goal = name == self.goal and state == n
                yield self._cost(0.0, 1.0), (terminal, state, state + to_goal), -1
        for rule in self.rules_to[-1]:
            left = int(self.compiled.rule_left[rule])
            for state in range(self.n_states):
                yield self._cost(self.log_costs[rule], 0.0), (left, state, state), rule

    def _cost(self, chance: float, length: float) -> Cost:
        """Return the two costs, -log of a probability and a length, the main one first."""
        return (length, chance) if self.shortest else (chance, length)

    def _combine(self, item: Item, cost: Cost) -> None:
        """Offer every item that a settled item completes, alone or with a neighbour."""
        symbol, first, last = item
        for rule in self.rules_to[symbol]:
            left = int(self.compiled.rule_left[rule])
            step = self._cost(self.log_costs[rule], 0.0)
            self._offer((left, first, last), cost, step, rule, (item,))
        self.ending[symbol, last].append(first)
        self.beginning[symbol, first].append(last)
        for tail in self.tails_left[symbol]:
            right = int(self.compiled.right[tail])
            for end in self.beginning[right, last]:
                other = (right, last, end)
                self._offer((tail, first, end), cost, self.costs[other], -1, (item, other))
        for tail in self.tails_right[symbol]:
            left = int(self.compiled.left[tail])
            for begin in self.ending[left, first]:
                other = (left, begin, first)
                self._offer((tail, begin, last), cost, self.costs[other], -1, (other, item))

    def _offer(
        self, item: Item, cost: Cost, more: Cost, rule: int, parts: tuple[Item, ...]
    ) -> None:
        """Put an item on the agenda unless it is settled."""
        if item not in self.settled:
            total = (cost[0] + more[0], cost[1] + more[1])
            heappush(self.agenda, (total, next(self.order), item, rule, parts))

    def choices(self, top: Item) -> list[int]:
        """Return the rules of an item's tree in preorder."""
        rules, waiting = [], [top]
        while waiting:
            rule, parts = self.settled[waiting.pop()]
            if rule >= 0:
                rules.append(rule)
            waiting.extend(reversed(parts))
        return rules
