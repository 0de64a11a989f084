"""Evidence against loops by context: what a loop derives must not depend on where it stands.

A context-free rule is used as often in one place as in another. Where (x | y)* is learned from
sentences of x+ y+, y is never followed by x, although half of all rounds are x. Where x* is learned
from x+, the loop never ends before its first round. The saved rules outweigh this, so the
description length does not show the fault.

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

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.support.cheapest_parse import (
    PARENT,
    PLACE,
    RULE,
    Parsed,
    Reading,
    read_all,
)
from motiondb.grammar.rules.rule_laws import recursive_lefts
from motiondb.grammar.rules.rule_set import Right, RuleSet
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
    rows, readings = parsed
    looping = recursive_lefts(rule_set.rules)
    loops = np.array([left in looping for left, _ in rows])
    nodes = _nodes_of(readings, sentences)
    doubts = [*_by_rules_above(nodes, rows, loops), *_by_rules_beside(nodes, rows, loops)]
    least = min(doubts, key=lambda doubt: doubt.chance, default=None)
    return least.context if least is not None and least.chance < LEAST_CHANCE else None


def _nodes_of(readings: dict[Right, Reading], sentences: dict[Right, int]) -> _Nodes:
    sizes = [len(reading.nodes) for reading in readings.values()]
    nodes = np.concatenate([reading.nodes for reading in readings.values()])
    first = np.repeat(np.cumsum([0, *sizes[:-1]]), sizes)  # of the sentence of each node
    roots = nodes[:, PARENT] < 0
    parents = np.where(roots, -1, nodes[:, PARENT] + first)
    above = np.where(roots, _ROOT, nodes[parents, RULE])
    place = np.where(roots, 0, nodes[:, PLACE])
    higher = np.where(roots, _ROOT, above[parents])
    high_place = np.where(roots, 0, place[parents])
    table = np.column_stack([nodes[:, RULE], above, place, higher, high_place])
    weights = np.repeat([sentences[sentence] for sentence in readings], sizes)
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
