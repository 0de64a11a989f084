"""Trees from the weights between states: the best one, all in order, and random ones.

An item (X, s, t) is a symbol that leads an automaton from state s to state t. It is derived in one
of several *ways*: by a rule with the part that it is rewritten to, or, if it is a tail Y Z, by a
state u between its parts (Y, s, u) and (Z, u, t). The share of a way is its weight divided by that
of the item.

- Shares of sums are the probabilities of the ways, given that the string leads from s to t. So a
  tree drawn from the root down by them has its probability in the grammar under this condition,
  and no draw is rejected.
- Shares of greatest weights say what a way costs, -log of its share, and the cheapest costs
  nothing. So A* search yields the trees in the order of their weights, and spends no step on others
  (P. E. Hart, N. J. Nilsson and B. Raphael, 1968).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from itertools import count
from math import inf, ldexp, log
from typing import NamedTuple

import numpy as np

from motiondb.grammar.cfg.closure import BEST
from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.inside import Inside, Rules, find, log_of, rules_of
from motiondb.grammar.kernels import maker, merged
from motiondb.records import FloatArray, IntArray

Item = tuple[int, int, int]
_Stack = tuple[Item, "_Stack"] | None
_Rules = tuple[int, "_Rules"] | None

TOLERANCE = 2.5e-10
"""Largest difference of log-probabilities that count as equal. It is smaller than the rule
penalty."""
_DIGITS = 10  # Costs of trees in order that agree in so many decimal places count as equal


class Ways(NamedTuple):
    """The ways to derive an item."""

    rules: list[int]  # The rule of each way, -1 for a tail
    parts: list[tuple[Item, ...]]
    sums: list[float]  # Sums of the shares up to each way; the last is above every random number
    shares: list[float]


def cumulated(weights: Sequence[float] | FloatArray) -> list[float]:
    """Return sums of weights divided by the total; that of the last possible one is 2.

    So ``bisect_right(cumulated(weights), rng.random())`` draws an index by weights.

    >>> cumulated([1.0, 3.0, 0.0])
    [0.25, 2.0, 2.0]
    """
    sums: list[float] = np.cumsum(weights).tolist()
    last = max(k for k, weight in enumerate(weights) if weight > 0.0)
    return [value / sums[-1] if k < last else 2.0 for k, value in enumerate(sums)]


def drawn(weights: Sequence[float] | FloatArray, rng: np.random.Generator) -> int:
    """Return a random index by weights, never one of weight 0."""
    return bisect_right(cumulated(weights), rng.random())


class Trees:
    """The trees of a grammar over an automaton, by their weights."""

    def __init__(self, compiled: CompiledGrammar, made: Inside, weights: FloatArray) -> None:
        self.compiled, self.made = compiled, made
        self._weights = weights.tolist()  # (R,): weight of each rule
        self._right = compiled.rule_right.tolist()
        self._bounds = compiled.rule_of.tolist()
        self._numbers = compiled.rule_numbers.tolist()
        self._children = list(zip(compiled.left.tolist(), compiled.right.tolist(), strict=True))
        self._ways: dict[Item, Ways] = {}

    def ways(self, item: Item) -> Ways:
        """Return the ways to derive an item of a nonterminal or a tail."""
        known = self._ways.get(item)
        if known is None:
            known = self._ways[item] = self._list_ways(item)
        return known

    def _list_ways(self, item: Item) -> Ways:
        symbol, s, t = item
        left, right = self._children[symbol]
        rules: list[int] = []
        parts: list[tuple[Item, ...]] = []
        shares: list[float] = []
        if left >= 0:
            states, of_states = _splits(self.made, item, left, right)
            shares = of_states.tolist()
            rules = [-1] * len(shares)
            parts = [((left, s, u), (right, u, t)) for u in states.tolist()]
        else:
            whole = find(self.made, symbol, s, t)[0]
            for rule in range(self._bounds[symbol], self._bounds[symbol + 1]):
                below = self._right[rule]
                value = float(s == t) if below < 0 else find(self.made, below, s, t)[0]
                if value > 0.0:
                    shares.append(self._weights[rule] * value / whole)  # of the same cell
                    rules.append(rule)
                    parts.append(((below, s, t),) if below >= 0 else ())
        return Ways(rules, parts, cumulated(shares), shares)

    def draw(
        self, item: Item, rng: np.random.Generator, most: float = inf
    ) -> tuple[list[int], list[int]] | None:
        """Draw a tree: numbers of its rules in preorder, and of its terminals.

        The result is None if it grew over ``most`` terminals.
        """
        first, last = self.compiled.terminals.start, self.compiled.terminals.stop
        random, many = rng.random, len(self.made.loops) > 1
        rules: list[int] = []
        leaves: list[int] = []
        waiting = [item]
        while waiting:
            item = waiting.pop()
            if first <= item[0] < last:
                leaves.append(item[0])
                if len(leaves) > most:
                    return None
                continue
            ways = self.ways(item)
            way = bisect_right(ways.sums, random())
            rules.append(self._numbers[ways.rules[way]])
            parts: list[Item] = []
            for part in ways.parts[way]:
                while part[0] >= last:  # a tail: its states from left to right
                    splits = self.ways(part)
                    one, part = splits.parts[bisect_right(splits.sums, random()) if many else 0]
                    parts.append(one)
                parts.append(part)
            waiting += reversed(parts)
        return rules, leaves

    def in_order(self, tops: Sequence[Item]) -> Iterator[list[int]]:
        """Yield the rules of trees in preorder, those of the greatest weight first.

        Of equal ones, that comes first which has the earlier rule at the first difference.
        """
        order = count()
        first, last = self.compiled.terminals.start, self.compiled.terminals.stop
        agenda: list[tuple[float, int, _Stack, _Rules]] = []
        for item in tops:
            cost = -self.made.log_weight(*item)
            if cost < inf:
                heappush(agenda, (round(cost, _DIGITS), -next(order), (item, None), None))
        while agenda:
            cost, _, stack, rules = heappop(agenda)
            if stack is None:
                yield [self._numbers[rule] for rule in _listed(rules)]
                continue
            item, rest = stack
            if first <= item[0] < last:
                heappush(agenda, (cost, -next(order), rest, rules))
                continue
            ways = self.ways(item)
            for way in range(len(ways.rules) - 1, -1, -1):
                below = rest
                for part in reversed(ways.parts[way]):
                    below = (part, below)
                taken = (ways.rules[way], rules) if ways.rules[way] >= 0 else rules
                more = round(cost - log(ways.shares[way]), _DIGITS)
                heappush(agenda, (more, -next(order), below, taken))


def _listed(rules: _Rules) -> list[int]:
    """Return linked rules in the order in which they were taken."""
    chosen = []
    while rules is not None:
        rule, rules = rules
        chosen.append(rule)
    return chosen[::-1]


@maker
def _splits(
    made: Inside, item: tuple[int, int, int], left: int, right: int
) -> tuple[IntArray, FloatArray]:
    """Return the states between two parts of a tail, and the shares of such ways of its weight."""
    tail, s, t = item
    whole, top = find(made, tail, s, t)
    begin, end = (s, t + 1) if made.shift else (0, len(made.loops))
    states, shares, used = np.zeros(end - begin, np.int64), np.zeros(end - begin), 0
    for u in range(begin, end):
        first, one = find(made, left, s, u)
        if first == 0.0:
            continue
        second, other = find(made, right, u, t)
        share = ldexp(first * second / whole, one + other - top)
        if share > 0.0:
            states[used], shares[used] = u, share
            used += 1
    return states[:used], shares[:used]


def best_rules(
    compiled: CompiledGrammar, made: Inside, weights: FloatArray, s: int = 0, t: int = -1
) -> IntArray | None:
    """Return the rules in use of the best tree of the start symbol, None if there is none.

    Of trees whose weights differ by rounding only, the one is taken which has at each node, from
    the root down, the rule that is first in the grammar, then the shortest first part.

    `made`: Greatest weights, with these `weights` (R,) of rules.
    """
    t = t % len(made.loops)
    if find(made, compiled.start, s, t)[0] == 0.0:
        return None
    rules = rules_of(compiled, BEST)._replace(weights=np.log(weights))
    return _best_rules(made, rules, (compiled.start, s, t))


@maker
def _best_rules(made: Inside, rules: Rules, item: tuple[int, int, int]) -> IntArray:
    """Return the rules of the best tree of an item in preorder."""
    left, right, rule_of, rule_right = rules.left, rules.right, rules.rule_of, rules.rule_right
    choices, used = np.zeros(64, np.int64), 0
    waiting, depth = np.zeros((64, 3), np.int64), 1
    waiting[0, 0], waiting[0, 1], waiting[0, 2] = item
    while depth > 0:
        depth -= 1
        symbol, i, j = waiting[depth]
        if depth + 2 > len(waiting):
            waiting = np.concatenate((waiting, np.zeros_like(waiting)))
        if used == len(choices):
            choices = np.append(choices, np.zeros_like(choices))
        goal = log_of(made, symbol, i, j) - TOLERANCE
        if left[symbol] >= 0:
            k = i
            while k < j:
                first = log_of(made, left[symbol], i, k)
                if first > -inf and first + log_of(made, right[symbol], k, j) >= goal:
                    break
                k += 1
            waiting[depth, 0], waiting[depth, 1], waiting[depth, 2] = right[symbol], k, j
            depth += 1
            waiting[depth, 0], waiting[depth, 1], waiting[depth, 2] = left[symbol], i, k
            depth += 1
        elif rule_of[symbol] < rule_of[symbol + 1]:
            choices[used] = _first_rule(made, rules, symbol, (i, j), goal)
            below = rule_right[choices[used]]
            if below >= 0:
                waiting[depth, 0], waiting[depth, 1], waiting[depth, 2] = below, i, j
                depth += 1
            used += 1
    return choices[:used]


@merged
def _first_rule(made: Inside, rules: Rules, symbol: int, span: tuple[int, int], goal: float) -> int:
    """Return the first rule of a symbol that reaches the goal between two states."""
    (i, j), rule_of = span, rules.rule_of
    for rule in range(rule_of[symbol], rule_of[symbol + 1] - 1):
        below, value = rules.rule_right[rule], rules.weights[rule]
        if below >= 0:
            value += log_of(made, below, i, j)
        elif i < j:
            continue
        if value >= goal:
            return rule
    return rule_of[symbol + 1] - 1
