"""The shortest string of a grammar with a given prefix that reaches given goals in order.

The goals c_1 ... c_g are sets of terminals. A string reaches them if members of them are a
subsequence of it. The state of a finite automaton counts how much of the prefix, and then how many
goals, have been passed. A fact says that a symbol, or the first symbols of a rule's right side, can
lead from one state to another. The search settles the cheapest fact first and joins it with facts
that begin where it ends or end where it begins, until the start symbol leads from the first state
to the last. A cost is the pair (actions, rules), so that a derivation always costs more than its
parts.

:mod:`motiondb.grammar.derivation.plan` finds the most probable way to one goal. Here there are
several goals, and each may be met by several terminals. For an empty prefix and the expression of a
player in a diagram, the result is a string with g_user = 0 if the grammar has one, without
sampling.

Source: the intersection of a context-free language with a regular one, Y. Bar-Hillel, M. Perles and
E. Shamir (1961); cheapest derivations, D. E. Knuth, "A Generalization of Dijkstra's Algorithm",
Information Processing Letters 6 (1977).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from heapq import heappop, heappush
from itertools import count

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Grammar, Tree, derive_by

Cost = tuple[int, int]
Whole = tuple[str, int, int]  # A symbol, and the states that it leads from and to
Part = tuple[int, int, int, int]
"""The number of a rule, the covered symbols of its right side, and the states from and to."""


def plan(
    grammar: Grammar, prefix: Sequence[str] = (), goals: Sequence[Collection[str]] = ()
) -> Tree:
    r"""Return the derivation of a shortest string; it is never the empty string.

    `goals`: Sets of terminals to pass after the prefix, in this order; any member of a set will do.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> grammar = read_grammar("S -> a S | B\nB -> b | b c")
    >>> plan(grammar, ["a"], [{"a"}, {"c"}]).leaves()
    ('a', 'a', 'b', 'c')
    """
    wanted = [frozenset(goal) for goal in goals]
    if not prefix and not wanted:
        wanted = [frozenset(grammar.terminals)]
    search = _Search(grammar, tuple(prefix), wanted)
    top = (grammar.start, 0, len(prefix) + len(wanted))
    if not search.settle(top):
        raise SceneError(_nowhere(grammar, prefix, wanted, search.ends(grammar.start)))
    return derive_by(grammar, search.choices(top))


class _Search:
    """Settled facts with their derivations, and the agenda of facts that wait."""

    def __init__(
        self, grammar: Grammar, prefix: tuple[str, ...], goals: list[frozenset[str]]
    ) -> None:
        self.grammar = grammar
        self.whole: dict[Whole, Part | None] = {}
        self.part: dict[Part, tuple[Part | None, Whole]] = {}
        self.costs: dict[Whole | Part, Cost] = {}
        self.beginning: defaultdict[tuple[str, int], list[Whole]] = defaultdict(list)
        self.waiting: defaultdict[tuple[str, int], list[Part]] = defaultdict(list)
        self.order = count()
        self.rules_from: defaultdict[str, list[int]] = defaultdict(list)
        self.agenda: list[tuple[Cost, int, Whole | Part, tuple[Part | None, Whole] | None]] = []
        for number, rule in enumerate(grammar.rules):
            for first in rule.right[:1]:
                self.rules_from[first].append(number)
        for terminal, i, j in self._terminals(prefix, goals):
            self._offer((1, 0), (terminal, i, j), None)
        for number, rule in enumerate(grammar.rules):
            if not rule.right:
                for i in range(len(prefix) + len(goals) + 1):
                    self._offer((0, 0), (number, 0, i, i), None)

    def _terminals(self, prefix: tuple[str, ...], goals: list[frozenset[str]]) -> Iterator[Whole]:
        """Yield the steps of the automaton; a terminal leads from each state to one other state."""
        for i, action in enumerate(prefix):
            yield action, i, i + 1
        for number in range(len(goals) + 1):
            i = len(prefix) + number
            for terminal in self.grammar.terminals:
                moves_on = number < len(goals) and terminal in goals[number]
                yield terminal, i, i + moves_on

    def _offer(
        self, cost: Cost, fact: Whole | Part, because: tuple[Part | None, Whole] | None
    ) -> None:
        if fact not in self.costs:
            heappush(self.agenda, (cost, next(self.order), fact, because))

    def settle(self, top: Whole) -> bool:
        """Settle facts, cheapest first, until ``top`` is settled; return False if it never is."""
        while self.agenda:
            cost, _, fact, because = heappop(self.agenda)
            if fact in self.costs:
                continue
            self.costs[fact] = cost
            if len(fact) == 3:
                self._settle_whole(fact, because[0] if because else None, cost)
                if fact == top:
                    return True
            else:
                self._settle_part(fact, because, cost)
        return False

    def _settle_whole(self, fact: Whole, part: Part | None, cost: Cost) -> None:
        symbol, i, j = fact
        self.whole[fact] = part
        self.beginning[symbol, i].append(fact)
        for rule in self.rules_from[symbol]:
            self._offer(cost, (rule, 1, i, j), (None, fact))
        for waits in self.waiting[symbol, i]:
            self._join(waits, fact)

    def _settle_part(
        self, fact: Part, because: tuple[Part | None, Whole] | None, cost: Cost
    ) -> None:
        rule, done, i, j = fact
        if because is not None:
            self.part[fact] = because
        right = self.grammar.rules[rule].right
        if done == len(right):
            left = self.grammar.rules[rule].left
            whole = (left, i, j)
            self._offer((cost[0], cost[1] + 1), whole, (fact, whole))
            return
        self.waiting[right[done], j].append(fact)
        for comes in self.beginning[right[done], j]:
            self._join(fact, comes)

    def _join(self, part: Part, whole: Whole) -> None:
        one, other = self.costs[part], self.costs[whole]
        longer = (part[0], part[1] + 1, part[2], whole[2])
        self._offer((one[0] + other[0], one[1] + other[1]), longer, (part, whole))

    def ends(self, symbol: str) -> list[int]:
        """Return the states that a symbol leads to from the first state."""
        return [j for _, _, j in self.beginning[symbol, 0]]

    def choices(self, top: Whole) -> list[int]:
        """Return the rules of a settled symbol's derivation, in preorder."""
        rules: list[int] = []
        waiting = [top]
        while waiting:
            part = self.whole[waiting.pop()]
            if part is None:  # a terminal
                continue
            rules.append(part[0])
            step: Part | None = part
            while step is not None and step in self.part:  # its parts, the last one first
                step, child = self.part[step]
                waiting.append(child)
        return rules


def _nowhere(
    grammar: Grammar, prefix: Sequence[str], goals: Sequence[frozenset[str]], ends: list[int]
) -> str:
    """Return why there is no plan: the prefix, or the first goal that cannot be met."""
    met = max((end - len(prefix) for end in ends), default=-1)
    begun = f" that begins with '{' '.join(prefix)}'" if prefix else ""
    through = ", then ".join(" or ".join(sorted(goal)) for goal in goals)
    if met < 0:
        limit = "no string of the grammar begins so" if prefix else "the grammar has no string"
    else:
        limit = f"{' or '.join(sorted(goals[met]))} cannot come {'then' if met else 'at all'}"
    return (
        f"grammar: expected a string from {grammar.start}{begun} with {through or 'nothing more'},"
        f" but {limit}. Leave it out, change the order, or add a rule that allows it."
    )
