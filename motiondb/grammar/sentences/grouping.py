"""Right sides grouped by the beginnings and ends they share, as long as that saves bits.

The kernel of ``context_bits``. Rights are rows (left, offset, length, count) of ``table`` over the
symbols in ``text``. A group of g rights of one nonterminal with h, that share p symbols at the
beginning and q at the end, becomes one right with a new nonterminal between; the rests are its
alternatives. That saves (p + q)(g - 1) - 3 symbols, and nodes cost log2(h - g + 1) in place of
log2 h, those inside the group log2 g more.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

IntArray = npt.NDArray[np.int64]
_SHARED = 16
"""Lengths of beginnings and ends below which it is kept which were counted."""


@njit(cache=True)
def group_by_contexts(
    table: IntArray,
    text: IntArray,
    n_rights: int,
    end: int,
    length: int,
    n_nonterminals: int,
    n_terminals: int,
    n_repeats: int,
) -> tuple[int, int, int, float]:
    """Take the groups that save most until none saves; rights, length, nonterminals, data bits."""
    n_most = table.shape[0]
    begins = np.zeros((n_most, n_most), dtype=np.int64)
    closes = np.zeros((n_most, n_most), dtype=np.int64)
    for i in range(n_rights):
        for j in range(i + 1, n_rights):
            _compare(table, text, i, j, begins, closes)
    slot = np.zeros(n_most, dtype=np.int64)  # right -> place of its left side in the lists below
    nodes = np.zeros(n_most + 1)
    nodes[0] = table[:n_rights, 3].sum()
    alternatives = np.zeros(n_most + 1, dtype=np.int64)
    alternatives[0] = n_rights
    n_lefts = 1
    while n_rights < n_most:
        alphabet = n_nonterminals + n_terminals + 1
        i, p, q = _best_group(
            table, begins, closes, slot, n_rights, nodes, alternatives, length, alphabet
        )
        if i < 0:
            break
        members = _members(table, begins, closes, slot, n_rights, i, p, q)
        g = members.size
        end = _take(table, text, members, n_rights, end, p, q, n_terminals + n_repeats + n_lefts)
        slot[n_rights] = slot[i]
        alternatives[slot[i]] -= g - 1
        slot[members] = n_lefts
        nodes[n_lefts] = table[n_rights, 3]
        alternatives[n_lefts] = g
        length -= (p + q) * (g - 1) - 3
        for a in range(n_rights):
            if slot[a] == slot[n_rights]:
                _compare(table, text, a, n_rights, begins, closes)
            for r in members:
                if r < a and slot[a] == n_lefts:
                    _compare(table, text, r, a, begins, closes)
        n_lefts += 1
        n_rights += 1
        n_nonterminals += 1
    data = 0.0
    for k in range(n_lefts):
        data += nodes[k] * np.log2(alternatives[k])
    return n_rights, length, n_nonterminals, data


@njit(cache=True)
def _best_group(
    table: IntArray,
    begins: IntArray,
    closes: IntArray,
    slot: IntArray,
    n_rights: int,
    nodes: npt.NDArray[np.float64],
    alternatives: IntArray,
    length: int,
    alphabet: int,
) -> tuple[int, int, int]:
    """A right, and the beginning and end by which its group saves most; -1 where none saves."""
    now, more = np.log2(alphabet), np.log2(alphabet + 1)
    best, best_i, best_p, best_q = 1e-9, -1, 0, 0
    # many others share the same beginning and end with i: their group is the same, counted once
    seen = np.full((_SHARED, _SHARED), -1, dtype=np.int64)
    for i in range(n_rights):
        h = alternatives[slot[i]]
        for j in range(i + 1, n_rights):
            p, q = begins[i, j], closes[i, j]
            if slot[i] != slot[j] or p + q == 0:
                continue
            if p < _SHARED and q < _SHARED:
                if seen[p, q] == i:
                    continue
                seen[p, q] = i
            g, inner = 0, 0
            for r in range(n_rights):
                if r == i or _in_group(table, begins, closes, slot, i, r, p, q):
                    g += 1
                    inner += table[r, 3]
            saved = length * now - (length - (p + q) * (g - 1) + 3) * more
            saved += nodes[slot[i]] * np.log2(h / (h - g + 1)) - inner * np.log2(g)
            if saved > best:
                best, best_i, best_p, best_q = saved, i, p, q
    return best_i, best_p, best_q


@njit(cache=True)
def _members(
    table: IntArray,
    begins: IntArray,
    closes: IntArray,
    slot: IntArray,
    n_rights: int,
    i: int,
    p: int,
    q: int,
) -> IntArray:
    found = np.empty(n_rights, dtype=np.int64)
    g = 0
    for r in range(n_rights):
        if r == i or _in_group(table, begins, closes, slot, i, r, p, q):
            found[g] = r
            g += 1
    return found[:g]


@njit(cache=True)
def _in_group(
    table: IntArray,
    begins: IntArray,
    closes: IntArray,
    slot: IntArray,
    i: int,
    r: int,
    p: int,
    q: int,
) -> bool:
    low, high = min(i, r), max(i, r)
    fits = slot[i] == slot[r] and low != high and table[r, 2] >= p + q
    return fits and begins[low, high] >= p and closes[low, high] >= q


@njit(cache=True)
def _compare(
    table: IntArray, text: IntArray, i: int, j: int, begins: IntArray, closes: IntArray
) -> None:
    """Common beginning and common end of two rights; together no longer than the shorter."""
    a, b = table[i, 1], table[j, 1]
    n, m = table[i, 2], table[j, 2]
    least = min(n, m)
    p = 0
    while p < least and text[a + p] == text[b + p]:
        p += 1
    q = 0
    while q < least - p and text[a + n - 1 - q] == text[b + m - 1 - q]:
        q += 1
    begins[i, j] = p
    closes[i, j] = q


@njit(cache=True)
def _take(
    table: IntArray,
    text: IntArray,
    members: IntArray,
    new: int,
    end: int,
    p: int,
    q: int,
    symbol: int,
) -> int:
    """Make a group one right, row ``new``, its members the alternatives of ``symbol``."""
    i = members[0]
    offset, length = table[i, 1], table[i, 2]
    table[new, 0] = table[i, 0]
    table[new, 1] = end
    table[new, 2] = p + q + 1
    table[new, 3] = 0
    for k in range(p):
        text[end + k] = text[offset + k]
    text[end + p] = symbol
    for k in range(q):
        text[end + p + 1 + k] = text[offset + length - q + k]
    for r in members:
        table[new, 3] += table[r, 3]
        table[r, 0] = symbol
        table[r, 1] += p
        table[r, 2] -= p + q
    return end + p + q + 1
