"""Refit rules to sentences: parse all sentences by the rules of another rule set.

A rule set counts how often its rules are used, but not by which sentence, so a search cannot split
what it has merged. Here each sentence is parsed again in the fewest bits.
Only rules that are used remain, with their new counts. A sentence that the rules do not derive gets
a rule of the start symbol of the fewest bits, made of terminals and of nonterminals that derive
parts of it. Rules may therefore be removed, copied, or learned from some of the sentences only;
afterwards all sentences are derived again.

A node of a nonterminal with h alternatives costs log2 h bits, and a symbol of a new rule the
logarithm of the alphabet.

The compiled part is a chart over parts of a text, of one sentence or of long strings that are to be
cut (:mod:`motiondb.grammar.sentences.cutting`). It is filled component by component of the
nonterminals, bottom-up. It is not the engine of :mod:`motiondb.grammar.cfg.inside`: rules change
with every sentence set, so right sides are read as they are, without tails and closures. Within a
component whose nonterminals derive themselves, spans are filled from the last first symbol to the
first one, and for each first symbol again until no cost falls: no rule of a span needs a span that
begins earlier. Only rules that can begin with a nonterminal of the component are tried again. Costs
are not negative and no nonterminal derives itself alone, so this ends.

Source: D. H. Younger, "Recognition and Parsing of Context-Free Languages in Time n^3", Information
and Control 10 (1967), for the chart over spans; here right sides have any length.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.rule_arrays import LEFT, LENGTH, OFFSET, RuleTable, copy_numbers
from motiondb.grammar.kernels import kernel, maker, merged
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet, components, nullable_lefts
from motiondb.records import BoolArray, FloatArray, IntArray


class Costs(NamedTuple):
    """Rules with their costs."""

    table: RuleTable  # The rules, component by component, bottom-up
    groups: IntArray  # (components + 1,): index of the first rule of each component
    recursive: BoolArray  # (components,): whether the nonterminals of a component derive themselves
    again: BoolArray  # (rules,): whether a rule can begin with a nonterminal of its component
    bits: FloatArray  # (nonterminals,): bits of a node of each nonterminal
    symbol_bits: float  # Bits of a symbol of a new rule


def costs_of(donor: RuleSet) -> tuple[Costs, list[tuple[int, Right]], list[int]]:
    """Write rules into arrays; also return the rules and the nonterminals in their order there."""
    lefts = [donor.start, *sorted(left for left in donor.rules if left != donor.start)]
    groups = components(donor.rules)
    rows = [(x, right) for group in groups for x in group for right in sorted(donor.rules[x])]
    names = {left: donor.start + k for k, left in enumerate(lefts)}
    table = np.zeros((len(rows), 5), dtype=np.int64)
    text = np.zeros(1 + sum(len(right) for _, right in rows), dtype=np.int64)
    end = 0
    for r, (left, right) in enumerate(rows):
        text[end : end + len(right)] = [names.get(symbol, symbol) for symbol in right]
        table[r, LEFT], table[r, OFFSET], table[r, LENGTH] = names[left], end, len(right)
        end += len(right)
    sizes = [sum(len(donor.rules[left]) for left in group) for group in groups]
    nullable = nullable_lefts(donor.rules)
    group_of = {left: g for g, group in enumerate(groups) for left in group}
    costs = Costs(
        RuleTable(table, text, np.array([len(rows), end]), donor.n_terminals),
        np.cumsum([0, *sizes]).astype(np.int64),
        np.array([_derives_itself(donor, group) for group in groups], dtype=np.bool_),
        np.array([_begins_within(row, group_of, nullable) for row in rows], dtype=np.bool_),
        np.array([math.log2(max(1, len(donor.rules[left]))) for left in lefts]),
        math.log2(len(lefts) + donor.n_terminals + 1),
    )
    return costs, rows, lefts


def _derives_itself(donor: RuleSet, group: list[int]) -> bool:
    """Whether the nonterminals of a component derive themselves."""
    return len(group) > 1 or any(group[0] in right for right in donor.rules[group[0]])


def _begins_within(
    row: tuple[int, Right], group_of: dict[int, int], nullable: frozenset[int]
) -> bool:
    """Whether a right side can begin with a nonterminal of the component of its left side."""
    left, right = row
    for symbol in right:
        if group_of.get(symbol) == group_of[left]:
            return True
        if symbol not in nullable:
            return False
    return False


_LARGEST_CHART = 20_000_000
"""Cells (nonterminals times spans) beyond which sentences are not parsed: 320 MB of memory."""

_EQUAL = 1e-9  # Bits by which a cost must be lower to replace another

RULE, PARENT, PLACE, SPAN = range(4)  # Columns of the nodes of a parse


@dataclass(frozen=True, eq=False)
class CheapestParse:
    """The cheapest parse of a sentence."""

    cover: Right  # Right side of the new rule of a sentence that the rules do not derive, else ()
    # (nodes, 4): the nodes of the tree, or of the trees of the cover, each after its parent: the
    # number of the rule, the parent (-1 for none), the place in the right side of the parent, and
    # the number of symbols of the sentence that the node spans
    nodes: IntArray


class _Chart(NamedTuple):
    """What nonterminals derive of a text, by the first symbol and the length of the part."""

    # (nonterminals, n + 1, lengths): fewest bits by which a nonterminal derives a part
    best: FloatArray
    # (nonterminals, n + 1, lengths): the row of the rule of this derivation; no nonterminals where
    # no tree is wanted
    how: IntArray
    # (nonterminals, n + 1, 2): least and greatest length of the parts from a symbol on; the
    # greatest is -1 if there is none
    ends: IntArray
    reach: FloatArray  # (longest right side + 1, lengths): work array of :func:`_reach_ends`


def _chart(costs: Costs, n: int, longest: int, n_how: int) -> _Chart:
    """Make a chart of texts of n symbols, with trees of parts from ``n_how`` places."""
    shape, deepest = (
        (len(costs.bits), n + 1, longest + 1),
        int(costs.table.rows[:, LENGTH].max(initial=0)),
    )
    return _Chart(
        np.full(shape, np.inf),
        np.zeros((shape[0] if n_how else 0, n_how, longest + 1), dtype=np.int64),
        np.empty((shape[0], n + 1, 2), dtype=np.int64),
        np.empty((deepest + 1, longest + 1)),
    )


def cheapest_parts(costs: Costs, text: IntArray, longest: int) -> FloatArray:
    """Return the fewest bits by which nonterminals derive each part of a text.

    Shapes: `text` (N,); result (nonterminals, N + 1, longest + 1), by the first symbol of the part
    and its length.
    """
    chart = _chart(costs, len(text), longest, 0)
    _fill(costs, text, chart)
    return chart.best


Parsed = tuple[list[tuple[int, Right]], dict[Right, CheapestParse]]
"""Rules in the order of their numbers in the parses, and how each sentence is parsed."""


def read_all(donor: RuleSet, sentences: Iterable[Right]) -> Parsed | None:
    """Parse sentences in the fewest bits.

    >>> donor = RuleSet(2, {2: {(3,): 1}, 3: {(0, 3): 1, (1,): 1}}, loops=True)
    >>> rows, parses = read_all(donor, [(0, 0, 1), (0, 1, 0)])
    >>> rows
    [(3, (0, 3)), (3, (1,)), (2, (3,))]
    >>> parses[0, 0, 1].nodes.tolist()
    [[2, -1, 0, 3], [0, 0, 0, 3], [0, 1, 1, 2], [1, 2, 1, 1]]
    >>> parses[0, 1, 0].cover
    (3, 0)
    """
    listed = list(sentences)
    room = 1 + max(map(len, listed), default=0)
    if len(donor.rules) * room**2 > _LARGEST_CHART:
        return None
    costs, rows, lefts = costs_of(donor)
    chart = _chart(costs, room - 1, room - 1, room)
    text = np.array([symbol for sentence in listed for symbol in sentence], dtype=np.int64)
    bounds = np.cumsum([0, *map(len, listed)])
    covers, cover_bounds, nodes, node_bounds = _read_sentences(costs, text, bounds, chart)
    back = donor.n_terminals
    named = [s if s < back else lefts[s - back] for s in covers.tolist()]
    parses = {
        sentence: CheapestParse(tuple(named[first:last]), nodes[low:high])
        for sentence, (first, last), (low, high) in zip(
            listed, pairwise(cover_bounds.tolist()), pairwise(node_bounds.tolist()), strict=True
        )
    }
    return rows, parses


@maker
def _read_sentences(
    costs: Costs, text: IntArray, bounds: IntArray, chart: _Chart
) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return the covers and nodes of all sentences, one after another, each with its bounds.

    Sentence k is ``text[bounds[k]:bounds[k + 1]]``. One call for all: a call costs as much as a
    short sentence.
    """
    n = bounds.size - 1
    cover_bounds, node_bounds = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64)
    covers, nodes = np.empty(text.size, np.int64), np.empty((4 * text.size + 16, 4), np.int64)
    for k in range(n):
        sentence = text[bounds[k] : bounds[k + 1]]
        _fill(costs, sentence, chart)
        cover, of_sentence = _read(costs, sentence, chart)
        first, low = cover_bounds[k], node_bounds[k]
        cover_bounds[k + 1], node_bounds[k + 1] = first + cover.size, low + of_sentence.shape[0]
        while node_bounds[k + 1] > nodes.shape[0]:
            nodes = np.concatenate((nodes, np.empty_like(nodes)))
        copy_numbers(cover, 0, cover.size, covers, first)
        for j in range(of_sentence.shape[0]):
            copy_numbers(of_sentence[j], 0, 4, nodes[low + j], 0)
    return covers[: cover_bounds[n]], cover_bounds, nodes, node_bounds


@kernel
def _fill(costs: Costs, text: IntArray, chart: _Chart) -> None:
    """Fill the chart of a text; of the start symbol only its beginning, if trees are wanted."""
    table, n, whole = costs.table, text.size, chart.how.size > 0
    _clear(chart, n)
    for g in range(costs.recursive.size):
        first, last = costs.groups[g], costs.groups[g + 1]
        if not costs.recursive[g]:
            for r in range(first, last):
                is_start = whole and table.rows[r, LEFT] == table.n_terminals
                for i in range(1 if is_start else n + 1):
                    _lower(costs, r, i, text, chart)
            continue
        for i in range(n, -1, -1):
            lowered, begun = True, False
            while lowered:
                lowered = False
                for r in range(first, last):
                    tried = costs.again[r] or not begun
                    if tried and _lower(costs, r, i, text, chart):
                        lowered = True
                begun = True


@kernel
def _clear(chart: _Chart, n: int) -> None:
    """Empty the chart for a text of n symbols."""
    width = chart.best.shape[2]
    for left in range(chart.best.shape[0]):
        for i in range(n + 1):
            chart.ends[left, i, 0], chart.ends[left, i, 1] = width, -1
            for m in range(min(width, n - i + 1)):
                chart.best[left, i, m] = np.inf


@kernel
def _lower(costs: Costs, r: int, i: int, text: IntArray, chart: _Chart) -> bool:
    """Lower the costs of the parts that a rule derives from symbol ``i``; True if any fell."""
    table = costs.table
    left, length = table.rows[r, LEFT] - table.n_terminals, table.rows[r, LENGTH]
    if length > 0:  # most rules do not begin here, which is checked first
        first = table.text[table.rows[r, OFFSET]]
        if first < table.n_terminals:
            if i == text.size or text[i] != first:
                return False
        elif chart.ends[first - table.n_terminals, i, 1] < 0:
            return False
    low, high = _reach_ends(table, r, chart, text, i)
    lowered = False
    for m in range(low, high + 1):
        cost = chart.reach[length, m] + costs.bits[left]
        if cost < chart.best[left, i, m] - _EQUAL:
            chart.best[left, i, m] = cost
            if chart.how.size > 0:
                chart.how[left, i, m] = r
            chart.ends[left, i, 0] = min(chart.ends[left, i, 0], m)
            chart.ends[left, i, 1] = max(chart.ends[left, i, 1], m)
            lowered = True
    return lowered


@merged
def _read(costs: Costs, sentence: IntArray, chart: _Chart) -> tuple[IntArray, IntArray]:
    """Return the cover of a sentence, empty if it has a tree, and the nodes of its trees."""
    table, n = costs.table, sentence.size
    if chart.best[0, 0, n] < np.inf:
        roots = np.array([[0, 0, n]])
        return np.empty(0, dtype=np.int64), _nodes_of(table, chart, sentence, roots)
    by_left, by_start = _cheapest_cover(chart, costs.symbol_bits, n)
    cover = np.empty(n, dtype=np.int64)
    roots = np.empty((n, 3), dtype=np.int64)
    filled, n_roots, j = 0, 0, n
    while j > 0:
        i, left = by_start[j], by_left[j]
        cover[filled] = sentence[i] if left < 0 else left + table.n_terminals
        if left >= 0:
            roots[n_roots] = left, i, j
            n_roots += 1
        filled += 1
        j = i
    return cover[:filled][::-1].copy(), _nodes_of(table, chart, sentence, roots[:n_roots])


@kernel
def _reach_ends(
    table: RuleTable, r: int, chart: _Chart, text: IntArray, start: int
) -> tuple[int, int]:
    """Fill ``reach[k, m]``, the bits of m symbols from ``start`` as the first k of row ``r``.

    Returns the least and the greatest length m of the whole right side; greatest below least if
    there is none.
    """
    most, offset = min(text.size - start, chart.reach.shape[1] - 1), table.rows[r, OFFSET]
    for m in range(most + 1):
        chart.reach[0, m] = np.inf
    chart.reach[0, 0] = 0.0
    low = high = 0
    for k in range(table.rows[r, LENGTH]):
        for m in range(most + 1):
            chart.reach[k + 1, m] = np.inf
        symbol = table.text[offset + k]
        if symbol < table.n_terminals:
            low, high = _read_terminal(
                chart.reach, k, (low, min(high, most - 1)), text, start, symbol
            )
        else:
            symbol -= table.n_terminals
            low, high = _read_nonterminal(chart, k, (low, high), symbol, start, most)
        if high < 0:
            return 1, 0
    return low, high


@merged
def _read_terminal(
    reach: FloatArray, k: int, span: tuple[int, int], text: IntArray, start: int, symbol: int
) -> tuple[int, int]:
    """Fill row k + 1 of ``reach`` from row k by a terminal; the least and greatest length."""
    least, greatest = reach.shape[1], -1
    for m in range(span[0], span[1] + 1):
        if reach[k, m] < np.inf and text[start + m] == symbol:
            reach[k + 1, m + 1] = reach[k, m]
            least, greatest = min(least, m + 1), m + 1
    return least, greatest


@merged
def _read_nonterminal(
    chart: _Chart, k: int, span: tuple[int, int], left: int, start: int, most: int
) -> tuple[int, int]:
    """Fill row k + 1 of ``reach`` from row k by a nonterminal; the least and greatest length."""
    reach, least, greatest = chart.reach, most + 1, -1
    for m in range(span[0], span[1] + 1):
        if reach[k, m] == np.inf:
            continue
        low, high = chart.ends[left, start + m, 0], chart.ends[left, start + m, 1]
        for q in range(low, min(high, most - m) + 1):
            cost = reach[k, m] + chart.best[left, start + m, q]
            if cost < reach[k + 1, m + q]:
                reach[k + 1, m + q] = cost
                least, greatest = min(least, m + q), max(greatest, m + q)
    return least, greatest


@merged
def _cheapest_cover(chart: _Chart, symbol_bits: float, n: int) -> tuple[IntArray, IntArray]:
    """Cover a sentence by symbols of a new rule.

    Returns for each end j the nonterminal that ends there in the cheapest cover up to j, -1 for a
    terminal, and where it starts.
    """
    cost = np.full(n + 1, np.inf)
    cost[0] = 0.0
    by_left, by_start = np.full(n + 1, -1), np.arange(n + 1) - 1
    for j in range(1, n + 1):
        cost[j] = cost[j - 1] + symbol_bits
        for left in range(1, chart.best.shape[0]):
            for i in range(j):
                if chart.ends[left, i, 0] > j - i or chart.ends[left, i, 1] < j - i:
                    continue
                changed = cost[i] + symbol_bits + chart.best[left, i, j - i]
                if changed < cost[j] - _EQUAL:
                    cost[j] = changed
                    by_left[j], by_start[j] = left, i
    return by_left, by_start


@maker
def _nodes_of(table: RuleTable, chart: _Chart, sentence: IntArray, roots: IntArray) -> IntArray:
    """Return the nodes of the cheapest trees of some roots (nonterminal, start, end)."""
    waiting = [(0, 0, 0, 0, 0)][:0]
    for k in range(roots.shape[0]):
        waiting.append((roots[k, 0], roots[k, 1], roots[k, 2], -1, 0))
    kept = [(0, 0, 0, 0)][:0]
    while len(waiting) > 0:
        left, i, j, parent, place = waiting.pop()
        r = chart.how[left, i, j - i]
        node = len(kept)
        kept.append((r, parent, place, j - i))
        _reach_ends(table, r, chart, sentence, i)
        for k in range(table.rows[r, LENGTH] - 1, -1, -1):
            symbol = table.text[table.rows[r, OFFSET] + k] - table.n_terminals
            if symbol < 0:
                j -= 1
                continue
            for m in range(i, j + 1):
                cost = chart.reach[k, m - i] + chart.best[symbol, m, j - m]
                if cost <= chart.reach[k + 1, j - i] + _EQUAL:
                    waiting.append((symbol, m, j, node, k))
                    j = m
                    break
    nodes = np.empty((len(kept), 4), dtype=np.int64)
    for k in range(len(kept)):
        nodes[k, RULE], nodes[k, PARENT], nodes[k, PLACE], nodes[k, SPAN] = kept[k]
    return nodes


_MOST_REFITS = 20
"""Largest number of successive refits. Chosen by hand: a few are enough, and each saves bits."""

_SAVED = 1e-6  # Bits that a further refit must save


def refit(donor: RuleSet, flat: RuleSet) -> RuleSet | None:
    """Return the rules of ``donor`` that the sentences use, and new rules for other sentences.

    >>> from motiondb.grammar.rules.rule_set import flat_rules
    >>> donor = RuleSet(4, {4: {(0, 5, 3): 1}, 5: {(1,): 1, (2,): 1, (1, 1): 1}})
    >>> refit(donor, flat_rules({(0, 1, 3): 2, (0, 2, 3): 1, (2, 3): 1}, 4)).rules
    {4: {(0, 5, 3): 3, (2, 3): 1}, 5: {(1,): 2, (2,): 1}}
    """
    parsed = _parsed(donor, flat)
    return None if parsed is None else _refitted(parsed, flat)


def _parsed(donor: RuleSet, flat: RuleSet) -> Parsed | None:
    if not flat.loops and donor.order() is None:
        return None
    return read_all(donor, flat.rules[flat.start])


def _refitted(parsed: Parsed, flat: RuleSet, lawful: bool = False) -> RuleSet | None:
    """Return the rules that the trees use; None if they break the laws.

    If the donor is ``lawful``, so are those of its rules that trees of the start symbol use.
    """
    sentences = flat.rules[flat.start]
    rows, parses = parsed
    new: dict[Right, list[Right]] = {}
    used: tuple[list[IntArray], list[IntArray]] = ([], [])  # by derived sentences, and by covers
    weights: tuple[list[int], list[int]] = ([], [])
    for sentence, parse in parses.items():
        is_cover = bool(parse.cover)
        used[is_cover].append(parse.nodes[:, RULE])
        weights[is_cover].append(sentences[sentence])
        if is_cover:
            new.setdefault(parse.cover, []).append(sentence)
    derived, covered = (_uses(*of_kind, len(rows)) for of_kind in zip(used, weights, strict=True))
    refitted = _counted(flat, rows, derived + covered)
    for cover, same_cover in new.items():
        refitted.add(refitted.start, cover, sum(sentences[sentence] for sentence in same_cover))
    if (lawful and not new) or is_lawful(refitted):
        return refitted
    plain = _counted(flat, rows, derived)
    for sentence in (sentence for same_cover in new.values() for sentence in same_cover):
        plain.add(plain.start, sentence, sentences[sentence])
    return plain if is_lawful(plain) else None


def _uses(used: list[IntArray], weights: list[int], n_rules: int) -> IntArray:
    """Return how often each rule is used by sentences, each with its weight."""
    if not used:
        return np.zeros(n_rules, dtype=np.int64)
    repeated = np.repeat(weights, [len(rules) for rules in used])
    counts = np.bincount(np.concatenate(used), weights=repeated, minlength=n_rules)
    return counts.astype(np.int64)


def _counted(flat: RuleSet, rows: list[tuple[int, Right]], uses: IntArray) -> RuleSet:
    """Return the rules that are used, with their counts."""
    rules: Rules = {flat.start: {}}
    for (left, right), number in zip(rows, uses.tolist(), strict=True):
        if number:
            rules.setdefault(left, {})[right] = number
    return flat.with_rules(rules)


def refit_fully(donor: RuleSet, flat: RuleSet) -> RuleSet:
    """Refit rules again and again while this saves bits."""
    return refit_and_read(donor, flat)[0]


def refit_and_read(donor: RuleSet, flat: RuleSet) -> tuple[RuleSet, Parsed | None]:
    """Refit rules as :func:`refit_fully` does, and keep the trees."""
    best, bits = donor, donor.bits()
    for _ in range(_MOST_REFITS):
        parsed = _parsed(best, flat)
        refitted = None if parsed is None else _refitted(parsed, flat, lawful=True)
        if refitted is None or refitted.bits() > bits - _SAVED:
            return best, parsed
        best, bits = refitted, refitted.bits()
    return best, None
