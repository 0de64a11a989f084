"""Parse sentences by a rule set in the fewest bits, or cover them by parts that the rules derive.

A node of a nonterminal with h alternatives costs log2 h bits, and a symbol of a new rule the
logarithm of the alphabet. A sentence that the rules do not derive is covered: it becomes a new
right side of the start symbol, made of terminals and of nonterminals that derive parts of it, in
the fewest bits.

The compiled part is a chart over spans, filled component by component of the nonterminals,
bottom-up. Within a component whose nonterminals derive themselves, spans are filled from the last
first symbol to the first one, and for each first symbol again until no cost falls: no rule of a
span needs a span that begins earlier. Costs are not negative and no nonterminal derives itself
alone, so this ends.

Source: D. H. Younger, "Recognition and Parsing of Context-Free Languages in Time n^3", Information
and Control 10 (1967), for the chart over spans; here right sides have any length.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.induction.rule_arrays import LEFT, LENGTH, OFFSET, RuleTable
from motiondb.grammar.rules.rule_laws import components, recursive_lefts
from motiondb.grammar.rules.rule_set import Right, RuleSet
from motiondb.records import BoolArray, FloatArray, IntArray

_LARGEST_CHART = 20_000_000
"""Cells (nonterminals times spans) beyond which sentences are not parsed: 320 MB of memory."""

_EQUAL = 1e-9
"""Bits by which a cost must be lower to replace another."""

RULE, PARENT, PLACE, SPAN = range(4)
"""Columns of the nodes of a reading."""


@dataclass(frozen=True, eq=False)
class Reading:
    """The cheapest parse of a sentence.

    Attributes
    ----------
    cover : tuple of int
        Right side of the new rule of a sentence that the rules do not derive, else ().
    nodes : array (nodes, 4)
        The nodes of the tree, or of the trees of the cover, each after its parent: the number of
        the rule, the parent (-1 for none), the place in the right side of the parent, and the
        number of symbols of the sentence that the node spans.
    """

    cover: Right
    nodes: IntArray


class _Costs(NamedTuple):
    """Rules with their costs.

    Attributes
    ----------
    table : RuleTable
        The rules, component by component, bottom-up.
    groups : array (components + 1,)
        Index of the first rule of each component.
    recursive : array (components,)
        Whether the nonterminals of a component derive themselves.
    bits : array (nonterminals,)
        Bits of a node of each nonterminal.
    symbol_bits : float
        Bits of a symbol of a new rule.
    """

    table: RuleTable
    groups: IntArray
    recursive: BoolArray
    bits: FloatArray
    symbol_bits: float


class _Chart(NamedTuple):
    """The chart of a sentence of n symbols.

    Attributes
    ----------
    best : array (nonterminals, n + 1, n + 1)
        Fewest bits by which a nonterminal derives a span.
    how : array (nonterminals, n + 1, n + 1)
        The row of the rule of this derivation.
    reach : array (longest right side + 1, n + 1)
        Work array of :func:`_reach_ends`.
    """

    best: FloatArray
    how: IntArray
    reach: FloatArray


def read_all(
    donor: RuleSet, sentences: Iterable[Right]
) -> tuple[list[tuple[int, Right]], dict[Right, Reading]] | None:
    """Parse sentences in the fewest bits.

    Parameters
    ----------
    donor : RuleSet
        The rules; none of their nonterminals derives itself alone.
    sentences : iterable of Right
        Different sentences as terminal numbers.

    Returns
    -------
    rows : list of (int, Right)
        The rules in the order of their numbers in the readings.
    readings : dict of Right to Reading
        The parse of each sentence.

    None is returned if a sentence is too long.

    >>> donor = RuleSet(2, {2: {(3,): 1}, 3: {(0, 3): 1, (1,): 1}}, loops=True)
    >>> rows, readings = read_all(donor, [(0, 0, 1), (0, 1, 0)])
    >>> rows
    [(3, (0, 3)), (3, (1,)), (2, (3,))]
    >>> readings[0, 0, 1].nodes.tolist()
    [[2, -1, 0, 3], [0, 0, 0, 3], [0, 1, 1, 2], [1, 2, 1, 1]]
    >>> readings[0, 1, 0].cover
    (3, 0)
    """
    listed = list(sentences)
    room = 1 + max(map(len, listed), default=0)
    if len(donor.rules) * room**2 > _LARGEST_CHART:
        return None
    lefts = [donor.start, *sorted(left for left in donor.rules if left != donor.start)]
    groups = components(donor.rules)
    rows = [(x, right) for group in groups for x in group for right in sorted(donor.rules[x])]
    costs = _costs_of(donor, rows, lefts, groups)
    deepest = 1 + max((len(right) for _, right in rows), default=0)
    chart = _Chart(
        np.empty((len(lefts), room, room)),
        np.zeros((len(lefts), room, room), dtype=np.int64),
        np.empty((deepest, room)),
    )
    readings = {}
    for sentence in listed:
        symbols = np.array(sentence, dtype=np.int64)
        _fill(costs, symbols, chart)
        cover, nodes = _read(costs, symbols, chart)
        back = donor.n_terminals
        named = tuple(s if s < back else lefts[s - back] for s in cover.tolist())
        readings[sentence] = Reading(named, nodes)
    return rows, readings


def _costs_of(
    donor: RuleSet, rows: list[tuple[int, Right]], lefts: list[int], groups: list[list[int]]
) -> _Costs:
    names = {left: donor.start + k for k, left in enumerate(lefts)}
    table = np.zeros((len(rows), 5), dtype=np.int64)
    text = np.zeros(1 + sum(len(right) for _, right in rows), dtype=np.int64)
    end = 0
    for r, (left, right) in enumerate(rows):
        text[end : end + len(right)] = [names.get(symbol, symbol) for symbol in right]
        table[r, LEFT], table[r, OFFSET], table[r, LENGTH] = names[left], end, len(right)
        end += len(right)
    looping = recursive_lefts(donor.rules)
    sizes = [sum(len(donor.rules[left]) for left in group) for group in groups]
    return _Costs(
        RuleTable(table, text, np.array([len(rows), end]), donor.n_terminals),
        np.cumsum([0, *sizes]).astype(np.int64),
        np.array([group[0] in looping for group in groups], dtype=np.bool_),
        np.array([math.log2(max(1, len(donor.rules[left]))) for left in lefts]),
        math.log2(len(lefts) + donor.n_terminals + 1),
    )


@njit(cache=True)
def _fill(costs: _Costs, sentence: IntArray, chart: _Chart) -> None:
    """Fill the chart of a sentence."""
    table, n = costs.table, sentence.size
    chart.best[:, : n + 1, : n + 1] = np.inf
    for g in range(costs.recursive.size):
        first, last = costs.groups[g], costs.groups[g + 1]
        if not costs.recursive[g]:
            for r in range(first, last):
                is_start = table.rows[r, LEFT] == table.n_terminals
                for i in range(1 if is_start else n + 1):
                    _lower(costs, r, i, sentence, chart)
            continue
        for i in range(n, -1, -1):
            lowered = True
            while lowered:
                lowered = False
                for r in range(first, last):
                    if _lower(costs, r, i, sentence, chart):
                        lowered = True


@njit(cache=True)
def _lower(costs: _Costs, r: int, i: int, sentence: IntArray, chart: _Chart) -> bool:
    """Lower the costs of the spans that a rule derives from symbol ``i``; True if any fell."""
    table = costs.table
    left, length = table.rows[r, LEFT] - table.n_terminals, table.rows[r, LENGTH]
    if length > 0:  # most rules do not begin here, which is checked first
        first = table.text[table.rows[r, OFFSET]]
        if first < table.n_terminals and (i == sentence.size or sentence[i] != first):
            return False
    low, high = _reach_ends(table, r, chart, sentence, i)
    lowered = False
    for j in range(low, high + 1):
        cost = chart.reach[length, j] + costs.bits[left]
        if cost < chart.best[left, i, j] - _EQUAL:
            chart.best[left, i, j] = cost
            chart.how[left, i, j] = r
            lowered = True
    return lowered


@njit(cache=True)
def _read(costs: _Costs, sentence: IntArray, chart: _Chart) -> tuple[IntArray, IntArray]:
    """Return the cover of a sentence, empty if it has a tree, and the nodes of its trees."""
    table, n = costs.table, sentence.size
    if chart.best[0, 0, n] < np.inf:
        roots = np.array([[0, 0, n]])
        return np.empty(0, dtype=np.int64), _nodes_of(table, chart, sentence, roots)
    by_left, by_start = _cheapest_cover(chart.best, costs.symbol_bits, n)
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


@njit(cache=True)
def _reach_ends(
    table: RuleTable, r: int, chart: _Chart, sentence: IntArray, start: int
) -> tuple[int, int]:
    """Fill ``reach[k, j]``, the bits of sentence[start:j] as the first k symbols of row ``r``.

    Returns the least and the greatest end j of the whole right side; greatest below least if there
    is none.
    """
    n, offset = sentence.size, table.rows[r, OFFSET]
    chart.reach[0, : n + 1] = np.inf
    chart.reach[0, start] = 0.0
    low = high = start
    for k in range(table.rows[r, LENGTH]):
        chart.reach[k + 1, : n + 1] = np.inf
        symbol = table.text[offset + k]
        if symbol < table.n_terminals:
            low, high = _read_terminal(chart.reach, k, (low, high), sentence, symbol)
        else:
            below = chart.best[symbol - table.n_terminals]
            low, high = _read_nonterminal(chart.reach, k, (low, high), below, n)
        if high < 0:
            return 1, 0
    return low, high


@njit(cache=True)
def _read_terminal(
    reach: FloatArray, k: int, span: tuple[int, int], sentence: IntArray, symbol: int
) -> tuple[int, int]:
    """Fill row k + 1 of ``reach`` from row k by a terminal; the least and greatest end."""
    least, most = sentence.size + 1, -1
    for i in range(span[0], min(span[1], sentence.size - 1) + 1):
        if reach[k, i] < np.inf and sentence[i] == symbol:
            reach[k + 1, i + 1] = reach[k, i]
            least, most = min(least, i + 1), i + 1
    return least, most


@njit(cache=True)
def _read_nonterminal(
    reach: FloatArray, k: int, span: tuple[int, int], below: FloatArray, n: int
) -> tuple[int, int]:
    """Fill row k + 1 of ``reach`` from row k by a nonterminal; the least and greatest end."""
    least, most = n + 1, -1
    for i in range(span[0], span[1] + 1):
        if reach[k, i] == np.inf:
            continue
        for j in range(i, n + 1):
            cost = reach[k, i] + below[i, j]
            if cost < reach[k + 1, j]:
                reach[k + 1, j] = cost
                least, most = min(least, j), max(most, j)
    return least, most


@njit(cache=True)
def _cheapest_cover(best: FloatArray, symbol_bits: float, n: int) -> tuple[IntArray, IntArray]:
    """Cover a sentence by symbols of a new rule.

    Returns for each end j the nonterminal that ends there in the cheapest cover up to j, -1 for a
    terminal, and where it starts.
    """
    cost = np.full(n + 1, np.inf)
    cost[0] = 0.0
    by_left, by_start = np.full(n + 1, -1), np.arange(n + 1) - 1
    for j in range(1, n + 1):
        cost[j] = cost[j - 1] + symbol_bits
        for left in range(1, best.shape[0]):
            for i in range(j):
                changed = cost[i] + symbol_bits + best[left, i, j]
                if changed < cost[j] - _EQUAL:
                    cost[j] = changed
                    by_left[j], by_start[j] = left, i
    return by_left, by_start


@njit(cache=True)
def _nodes_of(table: RuleTable, chart: _Chart, sentence: IntArray, roots: IntArray) -> IntArray:
    """Return the nodes of the cheapest trees of some roots (nonterminal, start, end)."""
    waiting = [(0, 0, 0, 0, 0)][:0]
    for k in range(roots.shape[0]):
        waiting.append((roots[k, 0], roots[k, 1], roots[k, 2], -1, 0))
    kept = [(0, 0, 0, 0)][:0]
    while len(waiting) > 0:
        left, i, j, parent, place = waiting.pop()
        r = chart.how[left, i, j]
        node = len(kept)
        kept.append((r, parent, place, j - i))
        _reach_ends(table, r, chart, sentence, i)
        for k in range(table.rows[r, LENGTH] - 1, -1, -1):
            symbol = table.text[table.rows[r, OFFSET] + k] - table.n_terminals
            if symbol < 0:
                j -= 1
                continue
            for m in range(i, j + 1):
                cost = chart.reach[k, m] + chart.best[symbol, m, j]
                if cost <= chart.reach[k + 1, j] + _EQUAL:
                    waiting.append((symbol, m, j, node, k))
                    j = m
                    break
    nodes = np.empty((len(kept), 4), dtype=np.int64)
    for k in range(len(kept)):
        nodes[k] = kept[k]
    return nodes
