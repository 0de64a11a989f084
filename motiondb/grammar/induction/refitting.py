"""Sentences read by the rules of another rule set: what a search goes on from.

The rules tell how often they are used, but not by which sentence; so a search cannot part again
what it has united. Here the sentences are read anew, each by its cheapest parse: only the rules
that are used remain, with the number of their nodes. A sentence that the rules do not derive gets
a rule of the start symbol, made of the fewest bits: terminals, and nonterminals that stand for
parts of it. Rules may thus be taken away, given copies, or learned from some of the sentences
only, and all sentences are derived again afterwards.

The kernel is a chart over spans, filled from the nonterminals that use no other upwards, which
acyclic rules allow; its costs are bits: log2 h for a node of one of h alternatives, and the
logarithm of the alphabet for each symbol of a new rule.

Source: the cheapest derivation by dynamic programming over spans, D. H. Younger, "Recognition and
Parsing of Context-Free Languages in Time n^3", Information and Control 10 (1967), for right sides
of any length.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numba import njit

from motiondb.grammar.induction.rule_arrays import LEFT, LENGTH, OFFSET
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet

_LARGEST_CHART = 20_000_000
"""Cells, nonterminals times spans, beyond which sentences are too long to be read."""


def refit(donor: RuleSet, flat: RuleSet) -> RuleSet | None:
    """The donor's rules as far as the sentences of the flat rules use them, and rules for the rest.

    None where a sentence is too long, the donor is cyclic, or what the sentences use of it breaks
    the laws.

    >>> from motiondb.grammar.rules.rule_set import flat_rules
    >>> donor = RuleSet(4, {4: {(0, 5, 3): 1}, 5: {(1,): 1, (2,): 1, (1, 1): 1}})
    >>> found = refit(donor, flat_rules({(0, 1, 3): 2, (0, 2, 3): 1, (2, 3): 1}, 4))
    >>> found.rules
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
    for sentence, written in _readings(donor, rows, flat, uses):
        if written:
            new.setdefault(written, []).append(sentence)
    for (left, right), number in zip(rows, uses.tolist(), strict=True):
        if number:
            rules.setdefault(left, {})[right] = number
    found = RuleSet(flat.n_terminals, rules, flat.constants, flat.empties, flat.singles)
    plain = found.copy()
    for right, told in new.items():
        for sentence in told:
            found.add(found.start, right, sentences[sentence])
            plain.add(plain.start, sentence, sentences[sentence])
    if found.lawful():
        return found
    plain.drop_unused()
    return plain if plain.lawful() else None


def _readings(
    donor: RuleSet, rows: list[tuple[int, Right]], flat: RuleSet, uses: np.ndarray
) -> Iterator[tuple[Right, Right]]:
    """Each sentence with the right side it needs, () where the donor derives it; fills ``uses``."""
    sentences = flat.rules[flat.start]
    lefts = [donor.start, *sorted(left for left in donor.rules if left != donor.start)]
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
    room = max(map(len, sentences)) + 1
    deepest = 1 + max((len(right) for _, right in rows), default=0)
    chart = (
        np.empty((len(lefts), room, room)),
        np.zeros((len(lefts), room, room), dtype=np.int64),
        np.empty((deepest, room)),
    )
    for sentence, count in sentences.items():
        symbols = np.array(sentence, dtype=np.int64)
        rest = _read(table, text, donor.n_terminals, bits, symbol_bits, symbols, count, chart, uses)
        back = donor.n_terminals
        yield sentence, tuple(s if s < back else lefts[s - back] for s in rest.tolist())


@njit(cache=True)
def _read(table, text, n_terminals, bits, symbol_bits, sentence, count, chart, uses):  # type: ignore[no-untyped-def]
    """Add ``count`` to the uses of the rows of the cheapest parse; what a new rule must hold.

    Rows stand bottom-up, the start symbol's last. chart : best (lefts, n + 1, n + 1), bits of a
    span; how, its row; reach (longest right + 1, n + 1), room for the work.
    """
    best, how, reach = chart
    n = sentence.size
    best[:, : n + 1, : n + 1] = np.inf
    for r in range(table.shape[0]):
        left, length = table[r, LEFT] - n_terminals, table[r, LENGTH]
        for i in range(n + 1 if left > 0 else 1):
            low, high = _reached(table, text, n_terminals, r, best, reach, sentence, i)
            for j in range(low, high + 1):
                cost = reach[length, j] + bits[left]
                if cost < best[left, i, j] - 1e-9:
                    best[left, i, j] = cost
                    how[left, i, j] = r
    if best[0, 0, n] < np.inf:
        _count(table, text, n_terminals, chart, sentence, count, uses, 0, 0, n)
        return np.empty(0, dtype=np.int64)
    by_left, by_start = _cover(best, symbol_bits, n)
    rest = np.empty(n, dtype=np.int64)
    filled, j = 0, n
    while j > 0:
        i, left = by_start[j], by_left[j]
        rest[filled] = sentence[i] if left < 0 else left + n_terminals
        if left >= 0:
            _count(table, text, n_terminals, chart, sentence, count, uses, left, i, j)
        filled += 1
        j = i
    return rest[:filled][::-1].copy()


@njit(cache=True)
def _reached(table, text, n_terminals, r, best, reach, sentence, start):  # type: ignore[no-untyped-def]
    """Fill reach[k, j]: bits of sentence[start:j] as the first k symbols of row r; least, most j
    that the whole right side reaches (most below least where none)."""
    n, offset = sentence.size, table[r, OFFSET]
    reach[0, : n + 1] = np.inf
    reach[0, start] = 0.0
    low = high = start
    for k in range(table[r, LENGTH]):
        reach[k + 1, : n + 1] = np.inf
        symbol = text[offset + k]
        least, most = n + 1, -1
        for i in range(low, high + 1):
            if reach[k, i] == np.inf:
                continue
            if symbol < n_terminals:
                if i < n and sentence[i] == symbol:
                    reach[k + 1, i + 1] = reach[k, i]
                    least, most = min(least, i + 1), i + 1
                continue
            for j in range(i, n + 1):
                cost = reach[k, i] + best[symbol - n_terminals, i, j]
                if cost < reach[k + 1, j]:
                    reach[k + 1, j] = cost
                    least, most = min(least, j), max(most, j)
        if most < 0:
            return 1, 0
        low, high = least, most
    return low, high


@njit(cache=True)
def _cover(best, symbol_bits, n):  # type: ignore[no-untyped-def]
    """The symbol that ends at each place j in the cheapest cover up to j: its left side, -1 for a
    terminal, and where it starts."""
    cost = np.full(n + 1, np.inf)
    cost[0] = 0.0
    by_left, by_start = np.full(n + 1, -1), np.arange(n + 1) - 1
    for j in range(1, n + 1):
        cost[j] = cost[j - 1] + symbol_bits
        for left in range(1, best.shape[0]):
            for i in range(j):
                changed = cost[i] + symbol_bits + best[left, i, j]
                if changed < cost[j] - 1e-9:
                    cost[j] = changed
                    by_left[j], by_start[j] = left, i
    return by_left, by_start


@njit(cache=True)
def _count(table, text, n_terminals, chart, sentence, count, uses, left, start, end):  # type: ignore[no-untyped-def]
    """Count the rows of the cheapest tree of a span."""
    best, how, reach = chart
    waiting = [(left, start, end)]
    while len(waiting) > 0:
        node, i, j = waiting.pop()
        r = how[node, i, j]
        uses[r] += count
        _reached(table, text, n_terminals, r, best, reach, sentence, i)
        for k in range(table[r, LENGTH] - 1, -1, -1):
            symbol = text[table[r, OFFSET] + k] - n_terminals
            if symbol < 0:
                j -= 1
                continue
            for m in range(i, j + 1):
                if reach[k, m] + best[symbol, m, j] <= reach[k + 1, j] + 1e-9:
                    waiting.append((symbol, m, j))
                    j = m
                    break
