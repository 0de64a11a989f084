"""Parts of right sides in arrays of rules: their positions and their neighbours."""

from __future__ import annotations

from typing import NamedTuple

from motiondb.grammar.induction.rule_arrays import LENGTH, OFFSET, RuleTable, compiled
from motiondb.records import IntArray


class Part(NamedTuple):
    """A string of symbols: ``length`` symbols of the text from ``start`` on."""

    start: int
    length: int


class Place(NamedTuple):
    """A part of a right side: ``length`` symbols of row ``row`` from its symbol ``first`` on."""

    row: int
    first: int
    length: int


@compiled
def same_symbols(text: IntArray, one: int, other: int, length: int) -> bool:
    """Whether two places of the text hold the same ``length`` symbols."""
    for k in range(length):  # noqa: SIM110  numba compiles no generator expressions
        if text[one + k] != text[other + k]:
            return False
    return True


@compiled
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


@compiled
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


@compiled
def neighbours(table: RuleTable, place: Place) -> tuple[int, int]:
    """Return the symbols before and after a place; -1 at the beginning, -2 at the end."""
    start = table.rows[place.row, OFFSET]
    end = place.first + place.length
    before = table.text[start + place.first - 1] if place.first > 0 else -1
    after = table.text[start + end] if end < table.rows[place.row, LENGTH] else -2
    return before, after


@compiled
def fitting_length(table: RuleTable, first: Place, r: int, k: int) -> int:
    """Return the length of a part at place ``k`` of row ``r`` that may join ``first``; -1 if none.

    It ends before the same neighbour, holds other symbols, and does not touch the first place.
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
