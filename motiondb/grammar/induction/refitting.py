"""Refit rules to sentences: parse all sentences by the rules of another rule set.

A rule set counts how often its rules are used, but not by which sentence, so a search cannot split
what it has merged. Here each sentence is parsed again in the fewest bits. Only rules that are used
remain, with their new counts. A sentence that the rules do not derive gets a rule of the start
symbol of the fewest bits, made of terminals and of nonterminals that stand for parts of it. So
rules may be removed, copied, or learned from some of the sentences only, and all sentences are
derived again afterwards.

The compiled part is a chart over spans. It is filled from the nonterminals that use no others
upwards, which acyclic rules allow. Costs are bits: log2 h for a node with h alternatives, and the
logarithm of the alphabet for each symbol of a new rule.

Source: D. H. Younger, "Recognition and Parsing of Context-Free Languages in Time n^3", Information
and Control 10 (1967), for the chart over spans; here right sides have any length.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.induction.rule_arrays import LEFT, LENGTH, OFFSET, ROWS, RuleTable
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet
from motiondb.records import FloatArray, IntArray

_LARGEST_CHART = 20_000_000
"""Cells (nonterminals times spans) beyond which sentences are not parsed: 320 MB of memory."""

_EQUAL = 1e-9
"""Bits by which a cost must be lower to replace another."""


class _Costs(NamedTuple):
    """Rules with their costs.

    Attributes
    ----------
    table : RuleTable
        The rules, each after those of the nonterminals on its right side.
    bits : array (nonterminals,)
        Bits of a node of each nonterminal.
    symbol_bits : float
        Bits of a symbol of a new rule.
    """

    table: RuleTable
    bits: FloatArray
    symbol_bits: float


class _Chart(NamedTuple):
    """The chart of a sentence of n symbols.

    Attributes
    ----------
    best : array (nonterminals, n + 1, n + 1)
        Fewest bits by which a nonterminal derives a span.
    how : array (nonterminals, n + 1, n + 1)
        The row of the rule that does so.
    reach : array (longest right side + 1, n + 1)
        Room for the work of :func:`_reach_ends`.
    """

    best: FloatArray
    how: IntArray
    reach: FloatArray


def refit(donor: RuleSet, flat: RuleSet) -> RuleSet | None:
    """Return the rules of ``donor`` that the sentences use, and new rules for other sentences.

    Parameters
    ----------
    donor : RuleSet
        The rules to parse by.
    flat : RuleSet
        One rule for each sentence.

    Returns
    -------
    RuleSet or None
        None if a sentence is too long, the donor is cyclic, or the rules that are used break the
        laws of the rule set.

    >>> from motiondb.grammar.rules.rule_set import flat_rules
    >>> donor = RuleSet(4, {4: {(0, 5, 3): 1}, 5: {(1,): 1, (2,): 1, (1, 1): 1}})
    >>> refit(donor, flat_rules({(0, 1, 3): 2, (0, 2, 3): 1, (2, 3): 1}, 4)).rules
    {4: {(0, 5, 3): 3, (2, 3): 1}, 5: {(1,): 2, (2,): 1}}
    """
    order = donor.order()
    sentences = flat.rules[flat.start]
    longest = max(map(len, sentences))
    if order is None or len(donor.rules) * (longest + 1) ** 2 > _LARGEST_CHART:
        return None
    rules: Rules = {donor.start: {}}
    new: dict[Right, list[Right]] = {}
    rows = [(left, right) for left in reversed(order) for right in sorted(donor.rules[left])]
    uses = np.zeros(len(rows), dtype=np.int64)
    for sentence, right in _parse_all(donor, rows, flat, uses):
        if right:
            new.setdefault(right, []).append(sentence)
    for (left, right), number in zip(rows, uses.tolist(), strict=True):
        if number:
            rules.setdefault(left, {})[right] = number
    refitted = RuleSet(flat.n_terminals, rules, flat.constants, flat.empties, flat.singles)
    plain = refitted.copy()
    for right, derived in new.items():
        for sentence in derived:
            refitted.add(refitted.start, right, sentences[sentence])
            plain.add(plain.start, sentence, sentences[sentence])
    if refitted.lawful():
        return refitted
    plain.drop_unused()
    return plain if plain.lawful() else None


def _parse_all(
    donor: RuleSet, rows: list[tuple[int, Right]], flat: RuleSet, uses: IntArray
) -> Iterator[tuple[Right, Right]]:
    """Yield each sentence and the right side of its new rule, () if none; fills ``uses``."""
    sentences = flat.rules[flat.start]
    lefts = [donor.start, *sorted(left for left in donor.rules if left != donor.start)]
    costs = _costs_of(donor, rows, lefts)
    room = max(map(len, sentences)) + 1
    deepest = 1 + max((len(right) for _, right in rows), default=0)
    chart = _Chart(
        np.empty((len(lefts), room, room)),
        np.zeros((len(lefts), room, room), dtype=np.int64),
        np.empty((deepest, room)),
    )
    for sentence, number in sentences.items():
        symbols = np.array(sentence, dtype=np.int64)
        rest = _parse(costs, symbols, number, chart, uses)
        back = donor.n_terminals
        yield sentence, tuple(s if s < back else lefts[s - back] for s in rest.tolist())


def _costs_of(donor: RuleSet, rows: list[tuple[int, Right]], lefts: list[int]) -> _Costs:
    names = {left: donor.start + k for k, left in enumerate(lefts)}
    table = np.zeros((len(rows), 5), dtype=np.int64)
    text = np.zeros(1 + sum(len(right) for _, right in rows), dtype=np.int64)
    end = 0
    for r, (left, right) in enumerate(rows):
        text[end : end + len(right)] = [names.get(symbol, symbol) for symbol in right]
        table[r, LEFT], table[r, OFFSET], table[r, LENGTH] = names[left], end, len(right)
        end += len(right)
    bits = np.array([math.log2(max(1, len(donor.rules[left]))) for left in lefts])
    symbol_bits = math.log2(len(lefts) + donor.n_terminals + 1)
    return _Costs(
        RuleTable(table, text, np.array([len(rows), end]), donor.n_terminals), bits, symbol_bits
    )


@njit(cache=True)
def _parse(
    costs: _Costs, sentence: IntArray, number: int, chart: _Chart, uses: IntArray
) -> IntArray:
    """Add ``number`` to the uses of the rules of the cheapest parse.

    Returns the right side of a new rule if there is no parse, else an empty array.
    """
    table, bits = costs.table, costs.bits
    n = sentence.size
    chart.best[:, : n + 1, : n + 1] = np.inf
    for r in range(table.used[ROWS]):
        left, length = table.rows[r, LEFT] - table.n_terminals, table.rows[r, LENGTH]
        for i in range(n + 1 if left > 0 else 1):
            low, high = _reach_ends(table, r, chart, sentence, i)
            for j in range(low, high + 1):
                cost = chart.reach[length, j] + bits[left]
                if cost < chart.best[left, i, j] - _EQUAL:
                    chart.best[left, i, j] = cost
                    chart.how[left, i, j] = r
    if chart.best[0, 0, n] < np.inf:
        _count_tree(table, chart, sentence, (0, 0, n), number, uses)
        return np.empty(0, dtype=np.int64)
    by_left, by_start = _cheapest_cover(chart.best, costs.symbol_bits, n)
    rest = np.empty(n, dtype=np.int64)
    filled, j = 0, n
    while j > 0:
        i, left = by_start[j], by_left[j]
        rest[filled] = sentence[i] if left < 0 else left + table.n_terminals
        if left >= 0:
            _count_tree(table, chart, sentence, (left, i, j), number, uses)
        filled += 1
        j = i
    return rest[:filled][::-1].copy()


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
def _count_tree(
    table: RuleTable,
    chart: _Chart,
    sentence: IntArray,
    node: tuple[int, int, int],
    number: int,
    uses: IntArray,
) -> None:
    """Count the rules of the cheapest tree of a node (nonterminal, start, end)."""
    waiting = [node]
    while len(waiting) > 0:
        left, i, j = waiting.pop()
        r = chart.how[left, i, j]
        uses[r] += number
        _reach_ends(table, r, chart, sentence, i)
        for k in range(table.rows[r, LENGTH] - 1, -1, -1):
            symbol = table.text[table.rows[r, OFFSET] + k] - table.n_terminals
            if symbol < 0:
                j -= 1
                continue
            for m in range(i, j + 1):
                cost = chart.reach[k, m] + chart.best[symbol, m, j]
                if cost <= chart.reach[k + 1, j] + _EQUAL:
                    waiting.append((symbol, m, j))
                    j = m
                    break
