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
way wherever they stand.

*Contexts.* What a loop derives must not depend on where it stands: a context-free rule is used as
often in one place as in another. Where (x | y)* is learned from sentences of x+ y+, y is never
followed by x, although half of all rounds are x. Where x* is learned from x+, the loop never ends
before its first round. The saved rules outweigh this, so the description length does not show the
fault.

Nodes of nonterminals that derive themselves are counted by *context*. This is the place in the rule
above them; or this place and the place of the rule above in the rule above it; or this place and
the rule that another nonterminal of the same right side is rewritten by. Let a nonterminal be used
n times in a context, and a rule of it never, but with share q in other contexts. If contexts do not
matter, this happens with probability (1 - q)^n. Where that is less than ``LEAST_CHANCE``, the
nonterminal is copied for the context. After refitting, the copy lacks the rule.

Source: R. C. Carrasco and J. Oncina, "Learning Stochastic Regular Grammars by Means of a State
Merging Method", ICGI 1994, for states that are merged only if what follows them does not differ.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.refitting import (
    PARENT,
    PLACE,
    RULE,
    SPAN,
    CheapestParse,
    Parsed,
    read_all,
    refit,
    refit_and_read,
)
from motiondb.grammar.kernels import kernel, maker
from motiondb.grammar.rules.rule_set import (
    Right,
    Rules,
    RuleSet,
    components,
    nullable_lefts,
    recursive_lefts,
)
from motiondb.records import BoolArray, IntArray

LEAST_CHANCE = 0.005
"""Probability below which a rule is not missing in a context by chance. It is low because many
contexts and rules are tested. Chosen by hand on drawn languages."""

Row = tuple[int, Right]  # A rule: its left and its right side

_ROOT = -1  # The rule above the root of a tree


class Context(NamedTuple):
    """The place of a nonterminal in a tree."""

    left: int  # Left side of the rule above it; -1 at the root of the tree
    right: Right  # Right side of the rule above it
    place: int  # Its place in this right side
    # The place of another nonterminal of the right side, and the rule that it is rewritten by; None
    # if this does not matter
    beside: tuple[int, Right] | None = None


class _Doubt(NamedTuple):
    """A context, and the probability that a rule is missing in it by chance."""

    chance: float
    context: Context


class _Nodes(NamedTuple):
    """The nodes of all trees."""

    # (nodes, 5): the rule of each node, the rule above and the place in it, and the rule above that
    # and the place in it; -1 where there is none
    table: IntArray
    weights: IntArray  # (nodes,): how often the sentence of each node occurs
    pairs: IntArray  # (pairs, 2): nodes of one parent: all ordered pairs


def unlike_context(
    rule_set: RuleSet, flat: RuleSet, parsed: Parsed | None = None
) -> Context | None:
    """Return the context in which the use of a nonterminal differs most clearly from elsewhere.

    >>> flat = RuleSet(2, {2: {(0, 1): 12, (0, 0, 1): 12, (0, 0, 0, 1): 12}})
    >>> rules = RuleSet(2, {2: {(3, 1): 36}, 3: {(0, 3): 72, (): 36}}, loops=True)
    >>> unlike_context(rules, flat)
    Context(left=2, right=(3, 1), place=0, beside=None)
    """
    sentences = flat.rules[flat.start]
    parsed = parsed or read_all(rule_set, sentences)
    if parsed is None:
        return None
    rows, parses = parsed
    looping = recursive_lefts(rule_set.rules)
    loops = np.array([left in looping for left, _ in rows])
    nodes = _nodes_of(parses, sentences)
    doubts = [*_by_rules_above(nodes, rows, loops), *_by_rules_beside(nodes, rows, loops)]
    least = min(doubts, key=lambda doubt: doubt.chance, default=None)
    return least.context if least is not None and least.chance < LEAST_CHANCE else None


def _nodes_of(parses: dict[Right, CheapestParse], sentences: dict[Right, int]) -> _Nodes:
    sizes = [len(parse.nodes) for parse in parses.values()]
    nodes = np.concatenate([parse.nodes for parse in parses.values()])
    first = np.repeat(np.cumsum([0, *sizes[:-1]]), sizes)  # of the sentence of each node
    roots = nodes[:, PARENT] < 0
    parents = np.where(roots, -1, nodes[:, PARENT] + first)
    above = np.where(roots, _ROOT, nodes[parents, RULE])
    place = np.where(roots, 0, nodes[:, PLACE])
    higher = np.where(roots, _ROOT, above[parents])
    high_place = np.where(roots, 0, place[parents])
    table = np.column_stack([nodes[:, RULE], above, place, higher, high_place])
    weights = np.repeat([sentences[sentence] for sentence in parses], sizes)
    return _Nodes(table, weights, _siblings(parents))


def _siblings(parents: IntArray) -> IntArray:
    """Return all ordered pairs (pairs, 2) of nodes of one parent."""
    order = np.argsort(parents, kind="stable")
    order = order[parents[order] >= 0]
    pairs = [np.empty((0, 2), dtype=np.int64)]
    apart = 1
    while True:
        one, other = order[:-apart], order[apart:]
        same = parents[one] == parents[other]
        if not same.any():
            return np.concatenate(pairs)
        pairs += [np.column_stack(pair)[same] for pair in ((one, other), (other, one))]
        apart += 1


def _by_rules_above(nodes: _Nodes, rows: list[Row], loops: BoolArray) -> Iterator[_Doubt]:
    """Yield the least probable context of each nonterminal that loops, by one rule above and two.

    Two rules are used if the nonterminal of the lower one loops too.
    """
    lefts = np.array([left for left, _ in rows])
    above = nodes.table[:, 1]
    within = (above >= 0) & loops[above]
    for symbol in sorted({rows[row][0] for row in np.flatnonzero(loops)}):
        members = lefts[nodes.table[:, 0]] == symbol
        table, weights = nodes.table[members], nodes.weights[members]
        for columns in ((1, 2), (1, 2, 3, 4)):
            keys, counts = _counted(table[:, columns], table[:, 0], weights, len(rows))
            tested = np.ones(len(keys), dtype=np.bool_)
            if len(columns) > 2:
                inner, _ = _unique_rows(table[within[members]][:, columns])
                tested = (keys[:, None] == inner).all(axis=2).any(axis=1)
            chance, c = _least_probable(counts, tested)
            row, place = keys[c, -2:].tolist()
            left, right = (_ROOT, ()) if row == _ROOT else rows[row]
            yield _Doubt(chance, Context(left, right, place))


def _by_rules_beside(nodes: _Nodes, rows: list[Row], loops: BoolArray) -> Iterator[_Doubt]:
    """Yield the least probable context of each two nonterminals of a rule, if one of them loops."""
    first, second = nodes.table[nodes.pairs[:, 0]], nodes.table[nodes.pairs[:, 1]]
    weights = nodes.weights[nodes.pairs[:, 0]]
    chosen = loops[first[:, 0]] | loops[second[:, 0]]
    first, second, weights = first[chosen], second[chosen], weights[chosen]
    triples, inverse = _unique_rows(np.column_stack([first[:, 1], first[:, 2], second[:, 2]]))
    for number, (row, place, other) in enumerate(triples.tolist()):
        members = inverse == number
        keys, counts = _counted(second[members, :1], first[members, 0], weights[members], len(rows))
        chance, c = _least_probable(counts, np.ones(len(keys), dtype=np.bool_))
        (left, right), (_, beside) = rows[row], rows[int(keys[c, 0])]
        yield _Doubt(chance, Context(left, right, place, (other, beside)))


def _unique_rows(table: IntArray) -> tuple[IntArray, IntArray]:
    """Return the different rows of a table in ascending order, and the number of each row."""
    least = table.min(axis=0, initial=0)
    widths = table.max(axis=0, initial=0) - least + 1
    factors = np.append(np.cumprod(widths[:0:-1])[::-1], 1)  # the first column counts most
    _, index, inverse = np.unique((table - least) @ factors, return_index=True, return_inverse=True)
    return table[index], inverse


def _counted(
    contexts: IntArray, rules: IntArray, weights: IntArray, n_rules: int
) -> tuple[IntArray, IntArray]:
    """Return the different contexts, and how often each rule is used in each."""
    keys, inverse = _unique_rows(contexts)
    cells = inverse * n_rules + rules
    counts = np.bincount(cells, weights=weights, minlength=len(keys) * n_rules)
    return keys, counts.astype(np.int64).reshape(len(keys), n_rules)


def _least_probable(counts: IntArray, tested: BoolArray) -> tuple[float, int]:
    """Return the least probability (1 - q)^n of a rule that a context lacks, and the context.

    ``counts`` (contexts, rules) says how often rules are used, ``tested`` which contexts count.
    """
    uses = counts.sum(axis=1)
    elsewhere = counts.sum(axis=0) - counts
    shares = np.where(counts == 0, elsewhere, 0) / np.maximum(uses.sum() - uses, 1)[:, None]
    chances = np.where(tested, (1.0 - shares.max(axis=1)) ** uses, 1.0)
    c = int(np.argmin(chances))
    return float(chances[c]), c


def split_context(rule_set: RuleSet, context: Context) -> RuleSet:
    """Copy a nonterminal for one context.

    >>> rules = RuleSet(2, {2: {(3,): 4}, 3: {(0, 3): 2, (1,): 4}}, loops=True)
    >>> split_context(rules, Context(3, (0, 3), 1)).rules
    {2: {(3,): 4}, 3: {(0, 4): 2, (1,): 4}, 4: {(0, 4): 2, (1,): 4}}
    """
    new = max(rule_set.rules) + 1
    changed = rule_set.copy()
    if context.left == _ROOT:
        changed.rename({changed.start: new})
        changed.rules[changed.start] = dict(changed.rules[new])
        return changed
    if context.beside is not None:
        return _split_beside(changed, context, context.beside)
    symbol = context.right[context.place]
    written = _with_symbols(context.right, {context.place: new})
    rights = changed.rules[context.left]
    changed.rules[context.left] = {
        (written if right == context.right else right): count for right, count in rights.items()
    }
    changed.rules[new] = dict(changed.rules[symbol])
    return changed


def _split_beside(rule_set: RuleSet, context: Context, beside: tuple[int, Right]) -> RuleSet:
    """Split a rule in two: one where ``beside`` is the rule of a nonterminal, one where it is not.

    Both hold copies of the two nonterminals of the context.
    """
    other, chosen = beside
    symbol, neighbour = context.right[context.place], context.right[other]
    first = max(rule_set.rules) + 1
    names = ({context.place: first, other: first + 1}, {context.place: first + 2, other: first + 3})
    written = [_with_symbols(context.right, new) for new in names]
    rights = rule_set.rules[context.left]
    rights.update(dict.fromkeys(written, rights.pop(context.right)))
    alternatives = rule_set.rules[neighbour]
    itself = neighbour == context.left and chosen == context.right
    first_kind = {r: alternatives[r] for r in (written if itself else [chosen])}
    second_kind = {r: count for r, count in alternatives.items() if r not in first_kind}
    copied = dict(rule_set.rules[symbol])
    for new, kind in zip(names, (first_kind, second_kind), strict=True):
        rule_set.rules[new[context.place]], rule_set.rules[new[other]] = dict(copied), kind
    return rule_set


def _with_symbols(right: Right, symbols: dict[int, int]) -> Right:
    return tuple(symbols.get(k, symbol) for k, symbol in enumerate(right))


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
    rows, parses = parsed
    counts = np.array([sentences[sentence] for sentence in parses])
    lefts = np.array([left for left, _ in rows])
    nodes = np.concatenate([one.nodes for one in parses.values()])
    bounds = np.cumsum([0, *(len(one.nodes) for one in parses.values())])
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


@kernel
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


@maker
def _all_rounds(nodes: IntArray, bounds: IntArray, row: int, places: BoolArray) -> IntArray:
    """Return what :func:`_rounds` says of each tree (trees, 3)."""
    judged = np.empty((bounds.size - 1, 3), dtype=np.int64)
    for tree in range(bounds.size - 1):
        most, above, below = _rounds(nodes[bounds[tree] : bounds[tree + 1]], row, places)
        judged[tree, 0], judged[tree, 1], judged[tree, 2] = most, above, below
    return judged


@maker
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
