"""Rule sets as arrays, for the compiled search that changes them many thousand times a second.

A rule is a row (left, offset, length, count, key) of a table. Its right side is
``text[offset : offset + length]``; ``count`` is the number of tree nodes that use the rule, and
``key`` a hash of the right side, so that right sides are rarely compared symbol by symbol. While a
change is tried, new right sides are appended to the text, and rules that do not change keep their
place in it. A change is undone by shortening the text again.

Symbols are numbered as in :mod:`motiondb.grammar.rules.rule_set`: terminals 0 to T - 1, the start
symbol T, further nonterminals above.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motiondb.grammar.kernels import kernel
from motiondb.grammar.rules.rule_set import Rules, RuleSet
from motiondb.records import BoolArray, FloatArray, IntArray

LEFT, OFFSET, LENGTH, COUNT, KEY = range(5)  # Columns of a table

N_COLUMNS = 5  # Columns of the array of rules; their meaning is given above
ROWS, SYMBOLS = 0, 1  # What ``RuleTable.used`` counts

_HASH_FACTOR, _HASH_BITS = 1_000_003, (1 << 40) - 1
"""Multiplier and mask of the polynomial hash. 40 bits times the multiplier fit into 64 bits."""


class RuleTable(NamedTuple):
    """A rule set as arrays."""

    rows: IntArray  # (rows, 5): the rules; see the module for the columns
    text: IntArray  # (symbols,): the right sides. Tables of one search share it
    used: IntArray  # (2,): how many rows and how many symbols of the text are in use
    n_terminals: int


def empty_table(text: IntArray, n_rows: int, n_terminals: int) -> RuleTable:
    """Make a table without rules over a text."""
    rows = np.zeros((n_rows, N_COLUMNS), dtype=np.int64)
    return RuleTable(rows, text, np.zeros(2, dtype=np.int64), n_terminals)


def table_of(rule_set: RuleSet, n_rows: int, n_text: int) -> RuleTable:
    """Write a rule set into arrays."""
    text = np.zeros(n_text, dtype=np.int64)
    table = empty_table(text, n_rows, rule_set.n_terminals)
    names = {left: rule_set.start + k for k, left in enumerate(sorted(rule_set.rules))}
    for left, rights in sorted(rule_set.rules.items()):
        for right, count in sorted(rights.items()):
            spelled = [names.get(symbol, symbol) for symbol in right]
            end = int(table.used[SYMBOLS])
            text[end : end + len(right)] = spelled
            put(table, len(right), names[left], count)
    return table


def rules_of(table: RuleTable, like: RuleSet) -> RuleSet:
    """Read a rule set from arrays; the laws are those of ``like``."""
    rules: Rules = {table.n_terminals: {}}
    for left, offset, length, count, _ in table.rows[: table.used[ROWS]].tolist():
        right = tuple(table.text[offset : offset + length].tolist())
        rules.setdefault(left, {})[right] = count
    return like.with_rules(rules)


@kernel
def put(table: RuleTable, length: int, left: int, count: int) -> bool:
    """Add a rule whose right side has been written at the end of the text; False if it is full.

    If the left side has this right side already, only its count grows. A right side that is the
    left side itself is dropped.
    """
    rows, text, n_rows, end = table.rows, table.text, table.used[ROWS], table.used[SYMBOLS]
    if length == 1 and text[end] == left:
        return True
    key = length + 1
    for k in range(end, end + length):
        key = (key * _HASH_FACTOR + text[k] + 1) & _HASH_BITS
    for r in range(n_rows):
        if rows[r, LEFT] == left and rows[r, KEY] == key and rows[r, LENGTH] == length:
            rows[r, COUNT] += count
            return True
    if n_rows >= rows.shape[0]:
        return False
    rows[n_rows, LEFT] = left
    rows[n_rows, OFFSET] = end
    rows[n_rows, LENGTH] = length
    rows[n_rows, COUNT] = count
    rows[n_rows, KEY] = key
    table.used[ROWS] = n_rows + 1
    table.used[SYMBOLS] = end + length
    return True


@kernel
def clear(table: RuleTable, source: RuleTable) -> None:
    """Empty a table that is to hold a change of ``source``, whose part of the text stays."""
    table.used[ROWS] = 0
    table.used[SYMBOLS] = source.used[SYMBOLS]


@kernel
def copy_row(source: RuleTable, r: int, goal: RuleTable) -> None:
    """Append row ``r`` of a table to another, without comparison."""
    n = goal.used[ROWS]
    for column in range(N_COLUMNS):
        goal.rows[n, column] = source.rows[r, column]
    goal.used[ROWS] = n + 1


@kernel
def copy_rows(source: RuleTable, goal: RuleTable) -> None:
    """Make a table over the same text equal to another."""
    goal.used[ROWS] = 0
    for r in range(source.used[ROWS]):
        copy_row(source, r, goal)
    goal.used[SYMBOLS] = source.used[SYMBOLS]


@kernel
def copy_numbers(source: IntArray, first: int, n: int, goal: IntArray, place: int) -> None:
    """Copy n numbers; unlike an assignment of slices, this compiles no message for other sizes."""
    for k in range(n):
        goal[place + k] = source[first + k]


@kernel
def bits_of(table: RuleTable, nodes: IntArray, alternatives: IntArray, logs: FloatArray) -> float:
    """Return the description length in bits.

    Parameters
    ----------
    table : RuleTable
        The rules.
    nodes : array (nonterminals,)
        Filled with the tree nodes of each nonterminal, from the start symbol on.
    alternatives : array (nonterminals,)
        Filled with the number of rules of each nonterminal.
    logs : array
        log2 of 0, 1, 2, ... (0 for 0).
    """
    nodes[:] = 0
    alternatives[:] = 0
    length = -1
    last = 0  # most of the nonterminals that the arrays have room for have no rules
    for r in range(table.used[ROWS]):
        left = table.rows[r, LEFT] - table.n_terminals
        last = max(last, left)
        nodes[left] += table.rows[r, COUNT]
        alternatives[left] += 1
        length += table.rows[r, LENGTH] + 2
    data = 0.0
    n_lefts = 0
    for k in range(last + 1):
        if alternatives[k] > 0:
            n_lefts += 1
            data += nodes[k] * logs[alternatives[k]]
    return length * logs[n_lefts + table.n_terminals + 1] + data


@kernel
def mark_descendants(table: RuleTable, symbol: int, reached: BoolArray) -> None:
    """Mark the nonterminals that a nonterminal leads to, itself among them.

    Parameters
    ----------
    table : RuleTable
        The rules.
    symbol : int
        A nonterminal.
    reached : array (nonterminals,)
        Filled with the marks.
    """
    reached[:] = False
    reached[symbol - table.n_terminals] = True
    grown = True
    while grown:
        grown = False
        for r in range(table.used[ROWS]):
            if reached[table.rows[r, LEFT] - table.n_terminals]:
                offset = table.rows[r, OFFSET]
                for k in range(offset, offset + table.rows[r, LENGTH]):
                    other = table.text[k] - table.n_terminals
                    if other >= 0 and not reached[other]:
                        reached[other] = True
                        grown = True


@kernel
def count_references(table: RuleTable, numbers: IntArray) -> None:
    """Count how often each nonterminal occurs in right sides.

    Parameters
    ----------
    table : RuleTable
        The rules.
    numbers : array (nonterminals,)
        Filled with the counts.
    """
    numbers[:] = 0
    for r in range(table.used[ROWS]):
        offset = table.rows[r, OFFSET]
        for k in range(offset, offset + table.rows[r, LENGTH]):
            if table.text[k] >= table.n_terminals:
                numbers[table.text[k] - table.n_terminals] += 1


class Part(NamedTuple):
    """A string of symbols: ``length`` symbols of the text from ``start`` on."""

    start: int
    length: int


class Substring(NamedTuple):
    """A substring of a right side: ``length`` symbols of row ``row`` from symbol ``first`` on."""

    row: int
    first: int
    length: int


@kernel
def same_symbols(text: IntArray, one: int, other: int, length: int) -> bool:
    """Whether two places of the text hold the same ``length`` symbols."""
    for k in range(length):  # noqa: SIM110  numba compiles no generator expressions
        if text[one + k] != text[other + k]:
            return False
    return True


@kernel
def occurrences(table: RuleTable, r: int, part: Part) -> int:
    """Count how often a part occurs in the right side of row ``r``, without overlap."""
    number, k = 0, table.rows[r, OFFSET]
    last = k + table.rows[r, LENGTH] - part.length
    while k <= last:
        if same_symbols(table.text, k, part.start, part.length):
            number += 1
            k += part.length
        else:
            k += 1
    return number


LONGEST_MEMBER = 4
"""Symbols of an alternative of a class at most. Chosen by hand, so that a try stays short."""


@kernel
def shared_ends(table: RuleTable, a: int, b: int, from_left: bool) -> tuple[int, int]:
    """Return the lengths of the common beginning and end of two rows, without overlap."""
    text = table.text
    n, m = table.rows[a, LENGTH], table.rows[b, LENGTH]
    one, other = table.rows[a, OFFSET], table.rows[b, OFFSET]
    least = min(n, m)
    p = q = 0
    if from_left:
        while p < least and text[one + p] == text[other + p]:
            p += 1
    while q < least - p and text[one + n - 1 - q] == text[other + m - 1 - q]:
        q += 1
    if not from_left:
        while p < least - q and text[one + p] == text[other + p]:
            p += 1
    return p, q


@kernel
def neighbours(table: RuleTable, part: Substring) -> tuple[int, int]:
    """Return the symbols before and after a substring; -1 at the beginning, -2 at the end."""
    start = table.rows[part.row, OFFSET]
    end = part.first + part.length
    before = table.text[start + part.first - 1] if part.first > 0 else -1
    after = table.text[start + end] if end < table.rows[part.row, LENGTH] else -2
    return before, after


@kernel
def fitting_length(table: RuleTable, first: Substring, r: int, k: int) -> int:
    """Return the length of a part at place ``k`` of row ``r`` that may join ``first``; -1 if none.

    It ends before the same neighbour, holds other symbols, and does not touch ``first``.
    """
    _, after = neighbours(table, first)
    here, start = table.rows[first.row, OFFSET] + first.first, table.rows[r, OFFSET]
    m = table.rows[r, LENGTH]
    for length in range(min(LONGEST_MEMBER, m - k) + 1):
        if (table.text[start + k + length] if k + length < m else -2) != after:
            continue
        if length == first.length and same_symbols(table.text, here, start + k, length):
            continue
        stop = first.first + first.length
        if r == first.row and k < stop + 1 and first.first < k + length + 1:
            continue
        return length
    return -1
