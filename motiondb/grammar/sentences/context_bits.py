"""A fast description length of a partition, for the search of cuts.

A partition is judged by a grammar that is induced from shared contexts. This family of grammars is
simple enough to be induced thousands of times a second:

1. Equal sentences are one rule of S.
2. The repeats chosen by the cover that save symbols become nonterminals with one rule each.
3. Right sides of one nonterminal that share a beginning and an end become one rule, and their
   middle parts become the alternatives of a new nonterminal. The group that saves most bits is
   replaced first, until none saves any. Alternatives are grouped further in the same way.

The bits are those of :mod:`motiondb.grammar.rules.description_length` for that grammar. They are an
upper bound of the least description length of the same sentences.

Notation: rules are a table (:mod:`motiondb.grammar.induction.rule_arrays`). Terminals are 0 to
T - 1, the start symbol is T, repeat r is T + 1 + r, and further nonterminals follow.

Let a nonterminal have h right sides, of which g share p symbols at the beginning and q at the end.
Grouping replaces these g by one right side with
a new nonterminal between beginning and end, and their middle parts become its alternatives. That
saves (p + q)(g - 1) - 3 symbols. Each tree node of the old nonterminal then costs log2(h - g + 1)
bits in place of log2 h, and each node of the new one costs log2 g bits more.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1, for the description length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from motiondb.grammar.induction.rule_arrays import (
    COUNT,
    LEFT,
    LENGTH,
    OFFSET,
    ROWS,
    SYMBOLS,
    RuleTable,
    empty_table,
    shared_ends,
)
from motiondb.grammar.kernels import kernel, maker, merged
from motiondb.grammar.sentences.repeats import cover_repeats
from motiondb.records import FloatArray, IntArray

_SHARED = 16
"""Pairs of lengths (p, q) below this are counted once for each right side; longer ones may be
counted again. It affects only the time."""

_LEAST_SAVED = 1e-9  # Bits that a group must save. Smaller savings can be rounding errors


class _Shared(NamedTuple):
    """What right sides share with others of the same left side."""

    # (rights, rights): length of the common beginning of two right sides i < j of one left side
    begins: IntArray
    closes: IntArray  # (rights, rights): length of their common end
    slot: IntArray  # (rights,): number of the left side among the arrays of :class:`_Lefts`


class _Lefts(NamedTuple):
    """Number of tree nodes and number of alternatives of each left side."""

    nodes: FloatArray
    alternatives: IntArray


class _Group(NamedTuple):
    """The right sides that share p symbols with right side i at the beginning and q at the end."""

    i: int
    p: int
    q: int


@merged
def group_by_contexts(table: RuleTable, n_repeats: int, length: int, n_nonterminals: int) -> float:
    """Make groups, each time the one that saves most bits, until none saves any; return the bits.

    Parameters
    ----------
    table : RuleTable
        The rules of the start symbol, with room for others; changed in place.
    n_repeats : int
        Number of repeats, whose symbols are reserved.
    length : int
        Number of symbols of all rules, those of the repeats that are used among them.
    n_nonterminals : int
        Number of their nonterminals.
    """
    n_rights, n_most = table.used[ROWS], table.rows.shape[0]
    shared = _Shared(
        np.zeros((n_most, n_most), np.int64),
        np.zeros((n_most, n_most), np.int64),
        np.zeros(n_most, np.int64),
    )
    for j in range(n_rights):
        for i in range(j):
            _compare(table, shared, i, j)
    lefts = _Lefts(np.zeros(n_most + 1), np.zeros(n_most + 1, np.int64))
    lefts.nodes[0] = table.rows[:n_rights, COUNT].sum()
    lefts.alternatives[0] = n_rights
    n_lefts, alphabet = 1, n_nonterminals + table.n_terminals + 1
    while table.used[ROWS] < n_most:
        group = _best_group(table, shared, lefts, length, alphabet)
        if group.i < 0:
            break
        members = _members(table, shared, group)
        _take(table, members, group, table.n_terminals + n_repeats + n_lefts)
        _add_left(table, shared, lefts, members, group.i, n_lefts)
        length -= (group.p + group.q) * (members.size - 1) - 3
        n_lefts += 1
        alphabet += 1
    data = 0.0
    for k in range(n_lefts):
        data += lefts.nodes[k] * np.log2(lefts.alternatives[k])
    return length * np.log2(alphabet) + data


@merged
def _add_left(
    table: RuleTable, shared: _Shared, lefts: _Lefts, members: IntArray, i: int, n_lefts: int
) -> None:
    """Record a new left side ``n_lefts`` of the members, and compare the changed right sides."""
    slot, new = shared.slot, table.used[ROWS] - 1
    slot[new] = slot[i]
    lefts.alternatives[slot[i]] -= members.size - 1
    for r in members:
        slot[r] = n_lefts
    lefts.nodes[n_lefts] = table.rows[new, COUNT]
    lefts.alternatives[n_lefts] = members.size
    for a in range(new):
        if slot[a] == slot[new]:
            _compare(table, shared, a, new)
        for r in members:
            if r < a and slot[a] == n_lefts:
                _compare(table, shared, r, a)


@maker
def _best_group(
    table: RuleTable, shared: _Shared, lefts: _Lefts, length: int, alphabet: int
) -> _Group:
    """Return the group that saves most bits; its i is -1 if none saves any."""
    slot, n_rights = shared.slot, table.used[ROWS]
    now, more = np.log2(alphabet), np.log2(alphabet + 1)
    best, best_group = _LEAST_SAVED, _Group(-1, 0, 0)
    # Right sides that share the same beginning and end with i give the same group: count it once.
    seen = np.full((_SHARED, _SHARED), -1, dtype=np.int64)
    for i in range(n_rights):
        h = lefts.alternatives[slot[i]]
        for j in range(i + 1, n_rights):
            p, q = shared.begins[i, j], shared.closes[i, j]
            if slot[i] != slot[j] or p + q == 0:
                continue
            if p < _SHARED and q < _SHARED:
                if seen[p, q] == i:
                    continue
                seen[p, q] = i
            g, inner = _count_members(table, shared, _Group(i, p, q))
            saved = length * now - (length - (p + q) * (g - 1) + 3) * more
            saved += lefts.nodes[slot[i]] * np.log2(h / (h - g + 1)) - inner * np.log2(g)
            if saved > best:
                best, best_group = saved, _Group(i, p, q)
    return best_group


@merged
def _count_members(table: RuleTable, shared: _Shared, group: _Group) -> tuple[int, int]:
    """Count the members of a group, and their tree nodes."""
    g, nodes = 0, 0
    for r in range(table.used[ROWS]):
        if r == group.i or _in_group(table, shared, group, r):
            g += 1
            nodes += table.rows[r, COUNT]
    return g, nodes


@maker
def _members(table: RuleTable, shared: _Shared, group: _Group) -> IntArray:
    """Return the numbers of the members of a group, ascending."""
    members = np.empty(table.used[ROWS], dtype=np.int64)
    g = 0
    for r in range(table.used[ROWS]):
        if r == group.i or _in_group(table, shared, group, r):
            members[g] = r
            g += 1
    return members[:g]


@kernel
def _in_group(table: RuleTable, shared: _Shared, group: _Group, r: int) -> bool:
    """Return whether right side r belongs to a group; False for its own right side i."""
    low, high = min(group.i, r), max(group.i, r)
    fits = shared.slot[group.i] == shared.slot[r] and low != high
    fits = fits and table.rows[r, LENGTH] >= group.p + group.q
    return bool(
        fits and shared.begins[low, high] >= group.p and shared.closes[low, high] >= group.q
    )


@kernel
def _compare(table: RuleTable, shared: _Shared, i: int, j: int) -> None:
    """Record what two right sides i < j share."""
    shared.begins[i, j], shared.closes[i, j] = shared_ends(table, i, j, True)


@kernel
def _take(table: RuleTable, members: IntArray, group: _Group, symbol: int) -> None:
    """Replace a group by one right side, in a new row.

    The middle parts of the members become the alternatives of ``symbol``.
    """
    rows, text, p, q = table.rows, table.text, group.p, group.q
    new, end = table.used[ROWS], table.used[SYMBOLS]
    offset, length = rows[members[0], OFFSET], rows[members[0], LENGTH]
    rows[new, LEFT] = rows[members[0], LEFT]
    rows[new, OFFSET] = end
    rows[new, LENGTH] = p + q + 1
    rows[new, COUNT] = 0
    for k in range(p):
        text[end + k] = text[offset + k]
    text[end + p] = symbol
    for k in range(q):
        text[end + p + 1 + k] = text[offset + length - q + k]
    for r in members:
        rows[new, COUNT] += rows[r, COUNT]
        rows[r, LEFT] = symbol
        rows[r, OFFSET] += p
        rows[r, LENGTH] -= p + q
    table.used[ROWS], table.used[SYMBOLS] = new + 1, end + p + q + 1


_HASH = np.uint64(0x9E3779B97F4A7C15)
"""Multiplier of the polynomial hash: 2^64 divided by the golden ratio, which is odd and has no
regular bit pattern."""


class CoveredString(NamedTuple):
    """Joined strings with the cover of their repeats; made once and used for many partitions."""

    symbols: IntArray  # (N,): symbols, with a separator at the end of each string
    n_terminals: int
    # (N,): number of the repeat of which a chosen occurrence begins here, or -1
    repeat_at: IntArray
    repeat_starts: IntArray  # (R,): place of one chosen occurrence of each repeat
    repeat_lengths: IntArray  # (R,): length of each repeat, in symbols
    # (N,): whether a cut before this symbol would divide a chosen occurrence
    inside: npt.NDArray[np.bool_]
    # (N + 1,): hashes of all prefixes. They give the hash of any substring in constant time
    hashes: npt.NDArray[np.uint64]
    powers: npt.NDArray[np.uint64]  # (N + 1,): powers of the multiplier of the hash


def cover_string(symbols: IntArray, n_terminals: int) -> CoveredString:
    """Find the cover of joined strings by repeats; `symbols` (N,)."""
    starts, lengths = cover_repeats(symbols)
    inside = np.zeros(symbols.size, dtype=np.bool_)
    for start, length in zip(starts, lengths, strict=True):
        inside[start + 1 : start + length] = True
    number: dict[bytes, int] = {}
    firsts: list[tuple[int, int]] = []
    repeat_at = np.full(symbols.size, -1, dtype=np.int64)
    for start, length in zip(starts.tolist(), lengths.tolist(), strict=True):
        spelled = symbols[start : start + length].tobytes()
        if spelled not in number:
            number[spelled] = len(firsts)
            firsts.append((start, length))
        repeat_at[start] = number[spelled]
    begins, sizes = np.array(firsts, dtype=np.int64).reshape(-1, 2).T.copy()
    hashes, powers = _hashes(symbols)
    return CoveredString(symbols, n_terminals, repeat_at, begins, sizes, inside, hashes, powers)


def context_bits(covered: CoveredString, starts: IntArray, ends: IntArray) -> float:
    """Return the description length of sentences by the grammar of their contexts.

    Shapes: `starts`, `ends` (sentences,).
    """
    most = 2 * (covered.symbols.size + int((ends - starts).max()) + starts.size)
    text = np.empty(most, dtype=np.int64)
    table = empty_table(text, 2 * starts.size + 1, covered.n_terminals)
    return float(_context_grammar(covered, starts, ends, table)[0])


@maker
def _hashes(
    symbols: IntArray,
) -> tuple[npt.NDArray[np.uint64], npt.NDArray[np.uint64]]:
    """Return the hashes of all prefixes, and the powers of the multiplier."""
    hashes = np.zeros(symbols.size + 1, dtype=np.uint64)
    powers = np.ones(symbols.size + 1, dtype=np.uint64)
    for i in range(symbols.size):
        hashes[i + 1] = hashes[i] * _HASH + np.uint64(symbols[i] + 1)
        powers[i + 1] = powers[i] * _HASH
    return hashes, powers


@maker
def _context_grammar(
    cover: CoveredString, starts: IntArray, ends: IntArray, table: RuleTable
) -> tuple[float, npt.NDArray[np.bool_]]:
    """Fill an empty table with the rules; return the bits, and which repeats are nonterminals."""
    firsts, counts = _distinct(cover.hashes, cover.powers, starts, ends)
    used = _paying_repeats(cover, starts, ends, firsts)
    length, n_nonterminals = -1, 1  # of the whole sequence of rules
    end = 0
    for r in range(firsts.size):
        row = table.rows[r]
        row[LEFT], row[OFFSET], row[COUNT] = cover.n_terminals, end, counts[r]
        end = _write_sentence(cover, used, starts[firsts[r]], ends[firsts[r]], table.text, end)
        row[LENGTH] = end - row[OFFSET]
        length += row[LENGTH] + 2
    table.used[ROWS], table.used[SYMBOLS] = firsts.size, end
    for number in range(used.size):
        if used[number]:
            length += cover.repeat_lengths[number] + 2
            n_nonterminals += 1
    return group_by_contexts(table, used.size, length, n_nonterminals), used


@kernel
def _write_sentence(
    cover: CoveredString, used: npt.NDArray[np.bool_], i: int, stop: int, text: IntArray, end: int
) -> int:
    """Write symbols[i:stop] to ``text`` from ``end`` on; return the new end.

    Each used repeat is written as its nonterminal.
    """
    while i < stop:
        number = cover.repeat_at[i]
        if number >= 0 and used[number]:
            text[end] = cover.n_terminals + 1 + number
            i += cover.repeat_lengths[number]
        else:
            text[end] = cover.symbols[i]
            i += 1
        end += 1
    return end


@merged
def _distinct(
    hashes: npt.NDArray[np.uint64],
    powers: npt.NDArray[np.uint64],
    starts: IntArray,
    ends: IntArray,
) -> tuple[IntArray, IntArray]:
    """Return the first sentence of each group of equal sentences, and the size of each group."""
    n = starts.size
    keys = np.empty(n, dtype=np.uint64)
    for s in range(n):
        keys[s] = hashes[ends[s]] - hashes[starts[s]] * powers[ends[s] - starts[s]]
    firsts = np.empty(n, dtype=np.int64)
    counts = np.zeros(n, dtype=np.int64)
    n_distinct = 0
    for s in range(n):
        same = -1
        for f in range(n_distinct):
            t = firsts[f]
            if keys[t] == keys[s] and ends[t] - starts[t] == ends[s] - starts[s]:
                same = f
                break
        if same < 0:
            same = n_distinct
            firsts[n_distinct] = s
            n_distinct += 1
        counts[same] += 1
    return firsts[:n_distinct], counts[:n_distinct]


@merged
def _paying_repeats(
    cover: CoveredString, starts: IntArray, ends: IntArray, firsts: IntArray
) -> npt.NDArray[np.bool_]:
    """Return which repeats occur often enough in different sentences for a rule to save symbols."""
    repeat_at, repeat_lengths = cover.repeat_at, cover.repeat_lengths
    counts = np.zeros(repeat_lengths.size, dtype=np.int64)
    for s in firsts:
        for i in range(starts[s], ends[s]):
            if repeat_at[i] >= 0:
                counts[repeat_at[i]] += 1
    used = np.zeros(repeat_lengths.size, dtype=np.bool_)
    for number in range(used.size):
        used[number] = counts[number] * (repeat_lengths[number] - 1) > repeat_lengths[number] + 2
    return used
