"""Evidence for loops: rules that loop are kept only if the sentences support them.

A rule loops if a symbol of its right side derives, in turn, its left side. The sentences are parsed
in the fewest bits. The *rounds* of a rule in a sentence are its uses on one path from the root of
the tree, on the path with the most of them; a use after which the loop derives only the empty
string does not count. A rule is supported if

* some sentence has at least two rounds, three if there are fewer than twenty sentences: a movement
  that is merely done twice in a row has one round. If another rule of the same loop has as many
  rounds, one round less is enough, provided that the rule is used below a rule of the loop and
  above one, in one sentence or in two; one of several repeating alternatives can therefore be rare;
* the sentences do not stop at a bound. Let C be the most rounds, m the number of sentences with C
  rounds, and q the share of those that went on among all times that a sentence could go on or stop
  before C. If loops end only by chance, m sentences all stop at C with probability (1 - q)^m. The
  rule is refused if this is less than 0.05 and m is at least 3. (Two longest sentences are often
  equally long by chance where q is high.) If a sentence may go through the loop several times, or
  in several ways, the bound is 0.01.

A rule that is not supported is written out: the nonterminals that derive each other are copied once
for each round, and the last copy lacks the rule. Then the rules are refitted, which drops unused
rules. The remaining rules are judged again. Loops that are supported must also be used in the same
way wherever they stand (:mod:`.context_evidence`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.induction.support.cheapest_parse import (
    PARENT,
    PLACE,
    RULE,
    SPAN,
    Parsed,
    read_all,
)
from motiondb.grammar.induction.support.context_evidence import split_context, unlike_context
from motiondb.grammar.induction.support.refitting import refit, refit_and_read
from motiondb.grammar.rules.rule_laws import components, nullable_lefts, recursive_lefts
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet
from motiondb.records import BoolArray, IntArray

_FEW = 20  # Number of sentences below which three rounds are required

_ROUNDS, _ROUNDS_OF_FEW = 2, 3  # Rounds that some sentence must have

_LEAST_CHANCE, _LEAST_OF_MANY = 0.05, 0.01
"""Probability below which sentences do not stop at the same number of rounds by chance: where a
sentence goes through a loop once, and where it may do so several times or in several ways. Then the
rounds of a sentence are the most of several, and equal numbers are more frequent. With 0.05, of
thirty true grammars that nest one in five was refused."""

_FEWEST_AT_BOUND = 3  # Sentences that stop at the most rounds before this counts as a bound

_MOST_COPIES = 60
"""Largest number of copies of nonterminals when a loop is written out. Chosen by hand, to bound
the time."""

_MOST_LOOPS = 12
"""Largest number of loops that are written out one after another. Chosen by hand, to bound the
time."""


class Judged(NamedTuple):
    """A rule that loops."""

    left: int
    right: Right
    rounds: int  # The most rounds of a sentence
    supported: bool  # Whether the sentences support it


def rounds_asked(flat: RuleSet) -> int:
    """Return the rounds that some sentence must have, for flat rules of all sentences."""
    return _ROUNDS if sum(flat.rules[flat.start].values()) >= _FEW else _ROUNDS_OF_FEW


def judge_loops(
    rule_set: RuleSet, flat: RuleSet, asked: int, parsed: Parsed | None = None
) -> list[Judged] | None:
    """Judge each rule that loops by the sentences.

    >>> flat = RuleSet(2, {2: {(0, 1): 9, (0, 0, 1): 6, (0, 0, 0, 1): 4, (0, 0, 0, 0, 1): 1}})
    >>> rules = RuleSet(2, {2: {(0, 3): 20}, 3: {(0, 3): 16, (1,): 20}}, loops=True)
    >>> judge_loops(rules, flat, 2)
    [Judged(left=3, right=(0, 3), rounds=3, supported=True)]
    """
    sentences = flat.rules[flat.start]
    parsed = parsed or read_all(rule_set, sentences)
    if parsed is None:
        return None
    rows, readings = parsed
    counts = np.array([sentences[sentence] for sentence in readings])
    lefts = np.array([left for left, _ in rows])
    nodes = np.concatenate([one.nodes for one in readings.values()])
    bounds = np.cumsum([0, *(len(one.nodes) for one in readings.values())])
    verdicts: list[Judged] = []
    for group in components(rule_set.rules):
        places = _loop_places(rows, set(group))
        looping = np.flatnonzero(places.any(axis=1)).tolist()
        inside = np.isin(lefts, group)
        once = places.sum() == 1 and _most_entries(nodes, bounds, inside, places) <= 1
        least = _LEAST_CHANCE if once else _LEAST_OF_MANY
        of_group = []
        strict = False
        for row in looping:
            judged = _all_rounds(nodes, bounds, row, places)
            expanded = (lefts == rows[row][0])[nodes[:, RULE]]
            entered = np.logical_or.reduceat(expanded, bounds[:-1])
            rounds, above, below = judged[entered].T if entered.any() else np.zeros((3, 1), int)
            most, bounded = int(rounds.max()), stops_at_bound(rounds, counts[entered], least)
            enough = most >= asked
            strict = strict or (enough and not bounded)
            within = bool(above.any() and below.any()) and most >= asked - 1
            of_group.append((row, most, enough, within, bounded))
        verdicts += [
            Judged(*rows[row], most, (enough or (within and strict)) and not bounded)
            for row, most, enough, within, bounded in of_group
        ]
    return verdicts


def _loop_places(rows: list[tuple[int, Right]], group: set[int]) -> BoolArray:
    """Mark the places (rules, longest right side) that lead back into a component."""
    width = max(len(right) for _, right in rows)
    marks = np.zeros((len(rows), max(width, 1)), dtype=np.bool_)
    for row, (left, right) in enumerate(rows):
        if left in group:
            marks[row, : len(right)] = [symbol in group for symbol in right]
    return marks


@njit(cache=True)
def _most_entries(nodes: IntArray, bounds: IntArray, inside: BoolArray, places: BoolArray) -> int:
    """Return how often a tree enters a component from outside, at most.

    ``inside`` (rules,) marks the component. The nodes of tree k lie between ``bounds[k]`` and
    ``bounds[k + 1]``.
    """
    most = 0
    for tree in range(bounds.size - 1):
        number, first = 0, bounds[tree]
        for k in range(first, bounds[tree + 1]):
            parent = nodes[k, PARENT]
            within = parent >= 0 and places[nodes[first + parent, RULE], nodes[k, PLACE]]
            number += int(inside[nodes[k, RULE]] and not within)
        most = max(most, number)
    return most


def stops_at_bound(rounds: IntArray, counts: IntArray, least_chance: float = _LEAST_CHANCE) -> bool:
    """Whether sentences stop at the most rounds more often than chance explains.

    Shapes: `rounds`, `counts` (sentences,).

    >>> stops_at_bound(np.array([0, 1, 2]), np.array([7, 7, 6]))
    True
    >>> stops_at_bound(np.array([0, 1, 2, 3, 5]), np.array([9, 5, 3, 2, 1]))
    False
    """
    most = rounds.max()
    at_bound = int(counts[rounds == most].sum())
    went_on = int((counts * rounds).sum())
    stopped = int(counts[rounds < most].sum())
    chance = (1.0 - went_on / max(went_on + stopped, 1)) ** at_bound
    return at_bound >= _FEWEST_AT_BOUND and chance < least_chance


@njit(cache=True)
def _all_rounds(nodes: IntArray, bounds: IntArray, row: int, places: BoolArray) -> IntArray:
    """Return what :func:`_rounds` says of each tree (trees, 3)."""
    judged = np.empty((bounds.size - 1, 3), dtype=np.int64)
    for tree in range(bounds.size - 1):
        most, above, below = _rounds(nodes[bounds[tree] : bounds[tree + 1]], row, places)
        judged[tree, 0], judged[tree, 1], judged[tree, 2] = most, above, below
    return judged


@njit(cache=True)
def _rounds(nodes: IntArray, row: int, places: BoolArray) -> tuple[int, int, int]:
    """Return the rounds of a rule, and whether rounds of its loop are above and below one.

    ``places`` (rules, longest right side) marks symbols that lead back into the component of the
    rule.
    """
    n = nodes.shape[0]
    rounds = np.zeros(n, dtype=np.int64)  # of the rule, on the path to a node and with it
    depth = np.zeros(n, dtype=np.int64)  # of all rules of the component
    since = np.full(n, -1, dtype=np.int64)  # the depth at the first round of the rule
    is_round = np.zeros(n, dtype=np.bool_)
    for k in range(n):
        parent = nodes[k, PARENT]
        if parent >= 0 and places[nodes[parent, RULE], nodes[k, PLACE]] and nodes[k, SPAN] > 0:
            is_round[parent] = True
    most, above, below = 0, 0, 0
    for k in range(n):
        parent = nodes[k, PARENT]
        if parent >= 0:
            rounds[k], depth[k], since[k] = rounds[parent], depth[parent], since[parent]
        if is_round[k]:
            if nodes[k, RULE] == row:
                rounds[k] += 1
                most = max(most, rounds[k])
                above = max(above, int(depth[k] > 0))
                if since[k] < 0:
                    since[k] = depth[k] + 1
            depth[k] += 1
            if since[k] >= 0 and depth[k] > since[k]:
                below = 1
    return most, above, below


def keep_supported(
    rule_set: RuleSet,
    flat: RuleSet,
    asked: int,
    parsed: Parsed | None = None,
    most: float = math.inf,
) -> RuleSet | None:
    """Write out the loops that the sentences do not support."""
    current = rule_set
    for _ in range(_MOST_LOOPS):
        if not recursive_lefts(current.rules):
            return current
        parsed = parsed or read_all(current, flat.rules[flat.start])
        judged = judge_loops(current, flat, asked, parsed)
        if judged is None:
            return None
        refused = [one for one in judged if not one.supported]
        written: RuleSet | None
        if refused:
            worst = min(refused, key=lambda one: one.rounds)
            written = write_out(current, worst.left, worst.right, worst.rounds)
        else:
            context = unlike_context(current, flat, parsed)
            if context is None:
                return current
            written = split_context(current, context)
        refitted = None if written is None else refit(written, flat)
        if refitted is None:
            return None
        current, parsed = refit_and_read(refitted, flat)
        if current.bits() > most:
            return None
    return None


def write_out(rule_set: RuleSet, left: int, right: Right, rounds: int) -> RuleSet | None:
    """Write a rule that loops out, so that no path has more than ``rounds`` rounds of it.

    >>> rules = RuleSet(2, {2: {(3,): 4}, 3: {(0, 3): 2, (1,): 4}}, loops=True)
    >>> write_out(rules, 3, (0, 3), 1).rules
    {2: {(3,): 4}, 3: {(0, 4): 2, (1,): 4}, 4: {(1,): 4}}
    """
    group = next(group for group in components(rule_set.rules) if left in group)
    if len(group) * rounds > _MOST_COPIES:
        return None
    nullable = nullable_lefts(rule_set.rules)
    first = max(rule_set.rules) + 1
    rules: Rules = {x: dict(rule_set.rules[x]) for x in rule_set.rules if x not in group}
    names = [{x: x for x in group}]
    for level in range(rounds):
        names.append({x: first + level * len(group) + k for k, x in enumerate(group)})
    for level, here in enumerate(names):
        below = names[min(level + 1, rounds)]
        for x in group:
            rules[here[x]] = {}
            for old, count in rule_set.rules[x].items():
                loops = (x, old) == (left, right)
                written = [(below if loops else here).get(symbol, symbol) for symbol in old]
                if loops and level == rounds:
                    if not all(symbol in nullable for symbol in old if symbol in group):
                        continue
                    written = [symbol for symbol in old if symbol not in group]
                if tuple(written) != (here[x],):
                    rules[here[x]][tuple(written)] = count
    return rule_set.with_rules(rules)
