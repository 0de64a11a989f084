"""Rules as arrays: what an annealed search changes hundreds of thousands of times a second.

Rules are rows (left, offset, length, count, key) of a table; a right side is
``text[offset : offset + length]``. The text only grows while a change is tried: rules that stay
as they are keep their place in it, a change that is refused is forgotten by cutting the text off.
Rows of one left side and equal right sides are one row, their nodes added; ``key`` is a hash of
the right side, so that seldom more than one is read.

Symbols are numbered as in ``rule_set``: terminals 0..T-1, the start symbol T, nonterminals above.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

from motiondb.grammar.rules.rule_set import Rules, RuleSet

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]

LEFT, OFFSET, LENGTH, COUNT, KEY = range(5)
_FACTOR, _KEYS = 1_000_003, (1 << 40) - 1


def table_of(rule_set: RuleSet, n_rows: int, n_text: int) -> tuple[IntArray, IntArray, int, int]:
    """Table (n_rows, 5) and text (n_text,) with the rules, and how much of each is filled."""
    table, text = np.zeros((n_rows, 5), dtype=np.int64), np.zeros(n_text, dtype=np.int64)
    names = {left: rule_set.start + k for k, left in enumerate(sorted(rule_set.rules))}
    filled = end = 0
    for left, rights in sorted(rule_set.rules.items()):
        for right, count in sorted(rights.items()):
            spelled = [names.get(symbol, symbol) for symbol in right]
            text[end : end + len(right)] = spelled
            filled, end = put(table, text, filled, end, len(right), names[left], count)
    return table, text, filled, end


def rules_of(
    table: IntArray, text: IntArray, filled: int, n_terminals: int, like: RuleSet
) -> RuleSet:
    """The rule set of a table, with the laws of ``like``."""
    rules: Rules = {n_terminals: {}}
    for left, offset, length, count, _ in table[:filled].tolist():
        rules.setdefault(left, {})[tuple(text[offset : offset + length].tolist())] = count
    return RuleSet(n_terminals, rules, like.constants, like.empties, like.singles)


@njit(cache=True)
def put(  # type: ignore[no-untyped-def]
    table, text, filled, end, length, left, count
):
    """Add a row whose right side has been written at ``end``; rows filled, and end of the text.

    A right side that the left has already only adds to its nodes; one that is the left itself is
    dropped. Where the table is full, -1 rows are filled.
    """
    if length == 1 and text[end] == left:
        return filled, end
    key = length + 1
    for k in range(end, end + length):
        key = (key * _FACTOR + text[k] + 1) & _KEYS
    for r in range(filled):
        if table[r, LEFT] == left and table[r, KEY] == key and table[r, LENGTH] == length:
            table[r, COUNT] += count
            return filled, end
    if filled >= table.shape[0]:
        return -1, end
    table[filled, LEFT] = left
    table[filled, OFFSET] = end
    table[filled, LENGTH] = length
    table[filled, COUNT] = count
    table[filled, KEY] = key
    return filled + 1, end + length


@njit(cache=True)
def bits_of(table, filled, n_terminals, nodes, alternatives, logs):  # type: ignore[no-untyped-def]
    """Description length; fills nodes and alternatives of each nonterminal, from the start on."""
    nodes[:] = 0
    alternatives[:] = 0
    length = -1
    for r in range(filled):
        left = table[r, LEFT] - n_terminals
        nodes[left] += table[r, COUNT]
        alternatives[left] += 1
        length += table[r, LENGTH] + 2
    data = 0.0
    n_lefts = 0
    for k in range(alternatives.size):
        if alternatives[k] > 0:
            n_lefts += 1
            data += nodes[k] * logs[alternatives[k]]
    return length * logs[n_lefts + n_terminals + 1] + data


@njit(cache=True)
def lawful(  # type: ignore[no-untyped-def]
    table, text, filled, n_terminals, alternatives, weights, marks, total, empties
):
    """The laws of ``rule_set``: acyclic, constants and singles kept, no nullable beside itself.

    weights : array (T,), a random number for each constant terminal and 0 for others, so that
    sums are equal only where numbers are; total : the sum of a sentence. marks : array (T,), a bit
    of its own for each single terminal, 0 for others.
    """
    n = alternatives.size
    known = np.zeros(n, dtype=np.bool_)
    nullable = np.zeros(n, dtype=np.bool_)
    sums = np.zeros(n, dtype=np.int64)
    held = np.zeros(n, dtype=np.int64)
    resolved = np.zeros(filled, dtype=np.bool_)
    left_over = alternatives.copy()
    seen = np.zeros(n, dtype=np.bool_)
    n_resolved = 0
    while n_resolved < filled:
        before = n_resolved
        for r in range(filled):
            if resolved[r]:
                continue
            ready, empty, value, bits, twice = True, True, 0, 0, 0
            offset = table[r, OFFSET]
            for k in range(offset, offset + table[r, LENGTH]):
                symbol = text[k]
                if symbol < n_terminals:
                    value += weights[symbol]
                    twice |= bits & marks[symbol]
                    bits |= marks[symbol]
                    empty = False
                    continue
                symbol -= n_terminals
                if not known[symbol]:
                    ready = False
                    break
                value += sums[symbol]
                twice |= bits & held[symbol]
                bits |= held[symbol]
                empty = empty and nullable[symbol]
            if not ready:
                continue
            left = table[r, LEFT] - n_terminals
            if (seen[left] and sums[left] != value) or (empty and not empties) or twice:
                return False
            seen[left] = True
            sums[left] = value
            held[left] |= bits
            nullable[left] = nullable[left] or empty
            left_over[left] -= 1
            known[left] = left_over[left] == 0
            resolved[r] = True
            n_resolved += 1
        if n_resolved == before:
            return False
    if sums[0] != total:
        return False
    for r in range(filled):
        offset = table[r, OFFSET]
        for k in range(offset + 1, offset + table[r, LENGTH]):
            symbol = text[k]
            if symbol == text[k - 1] and symbol >= n_terminals and nullable[symbol - n_terminals]:
                return False
    return True


@njit(cache=True)
def below(table, text, filled, n_terminals, symbol, found):  # type: ignore[no-untyped-def]
    """Fill ``found`` (nonterminals,) with what a nonterminal leads to, itself among it."""
    found[:] = False
    found[symbol - n_terminals] = True
    grown = True
    while grown:
        grown = False
        for r in range(filled):
            if found[table[r, LEFT] - n_terminals]:
                offset = table[r, OFFSET]
                for k in range(offset, offset + table[r, LENGTH]):
                    other = text[k] - n_terminals
                    if other >= 0 and not found[other]:
                        found[other] = True
                        grown = True


@njit(cache=True)
def references(table, text, filled, n_terminals, numbers):  # type: ignore[no-untyped-def]
    """Fill ``numbers`` (nonterminals,) with how often each stands in right sides."""
    numbers[:] = 0
    for r in range(filled):
        offset = table[r, OFFSET]
        for k in range(offset, offset + table[r, LENGTH]):
            if text[k] >= n_terminals:
                numbers[text[k] - n_terminals] += 1
