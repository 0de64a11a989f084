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

Notation: right sides are rows (left, offset, length, count) over one array of symbols. Terminals
are 0 to T - 1, the start symbol is T, repeat r is T + 1 + r, and further nonterminals follow.

Let a nonterminal have h right sides, of which g
share p symbols at the beginning and q at the end. Grouping replaces these g by one right side with
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

from motiondb.grammar.kernels import kernel, maker
from motiondb.grammar.sentences.repeats import cover_repeats
from motiondb.records import FloatArray, IntArray

_SHARED = 16
"""Pairs of lengths (p, q) below this are counted once for each right side; longer ones may be
counted again. It affects only the time."""

_LEAST_SAVED = 1e-9  # Bits that a group must save. Smaller savings can be rounding errors


class Size(NamedTuple):
    """Size of a grammar."""

    n_rights: int  # Number of right sides
    n_text: int  # Number of symbols in the text
    # Number of symbols of all rules written one after the other, with left sides and separators
    length: int
    n_nonterminals: int


class _Rights(NamedTuple):
    """Right sides, and the lengths of the beginnings and ends that they share."""

    table: IntArray  # (rights, 4): rows (left, offset, length, count)
    text: IntArray  # (symbols,): the right sides
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


@maker
def group_by_contexts(
    table: IntArray, text: IntArray, size: Size, n_terminals: int, n_repeats: int
) -> tuple[int, int, int, float]:
    """Make groups, each time the one that saves most bits, until none saves any.

    Parameters
    ----------
    table : array (rights, 4)
        Rows (left, offset, length, count), with space for new ones; changed in place.
    text : array (symbols,)
        The right sides, with space for new ones; changed in place.
    size : Size
        Size of the grammar before.
    n_terminals : int
        Number of terminals.
    n_repeats : int
        Number of repeats, whose symbols are reserved.

    Returns
    -------
    n_rights : int
        Number of right sides.
    length : int
        Number of symbols of all rules.
    n_nonterminals : int
        Number of nonterminals.
    bits : float
        Bits of the sentences given the rules.
    """
    n_rights, end, length, n_nonterminals = size
    n_most = table.shape[0]
    rights = _Rights(
        table,
        text,
        np.zeros((n_most, n_most), np.int64),
        np.zeros((n_most, n_most), np.int64),
        np.zeros(n_most, np.int64),
    )
    for i in range(n_rights):
        for j in range(i + 1, n_rights):
            _compare(rights, i, j)
    lefts = _Lefts(np.zeros(n_most + 1), np.zeros(n_most + 1, np.int64))
    lefts.nodes[0] = table[:n_rights, 3].sum()
    lefts.alternatives[0] = n_rights
    n_lefts = 1
    while n_rights < n_most:
        alphabet = n_nonterminals + n_terminals + 1
        group = _best_group(rights, lefts, n_rights, length, alphabet)
        if group.i < 0:
            break
        members = _members(rights, n_rights, group)
        end = _take(rights, members, n_rights, end, group, n_terminals + n_repeats + n_lefts)
        _add_left(rights, lefts, members, group.i, n_rights, n_lefts)
        length -= (group.p + group.q) * (members.size - 1) - 3
        n_lefts += 1
        n_rights += 1
        n_nonterminals += 1
    data = 0.0
    for k in range(n_lefts):
        data += lefts.nodes[k] * np.log2(lefts.alternatives[k])
    return n_rights, length, n_nonterminals, data


@kernel
def _add_left(
    rights: _Rights, lefts: _Lefts, members: IntArray, i: int, new: int, n_lefts: int
) -> None:
    """Record a new left side ``n_lefts`` of the members, and compare the changed right sides."""
    slot = rights.slot
    slot[new] = slot[i]
    lefts.alternatives[slot[i]] -= members.size - 1
    for r in members:
        slot[r] = n_lefts
    lefts.nodes[n_lefts] = rights.table[new, 3]
    lefts.alternatives[n_lefts] = members.size
    for a in range(new):
        if slot[a] == slot[new]:
            _compare(rights, a, new)
        for r in members:
            if r < a and slot[a] == n_lefts:
                _compare(rights, r, a)


@maker
def _best_group(
    rights: _Rights, lefts: _Lefts, n_rights: int, length: int, alphabet: int
) -> _Group:
    """Return the group that saves most bits; its i is -1 if none saves any."""
    slot = rights.slot
    now, more = np.log2(alphabet), np.log2(alphabet + 1)
    best, best_group = _LEAST_SAVED, _Group(-1, 0, 0)
    # Right sides that share the same beginning and end with i give the same group: count it once.
    seen = np.full((_SHARED, _SHARED), -1, dtype=np.int64)
    for i in range(n_rights):
        h = lefts.alternatives[slot[i]]
        for j in range(i + 1, n_rights):
            p, q = rights.begins[i, j], rights.closes[i, j]
            if slot[i] != slot[j] or p + q == 0:
                continue
            if p < _SHARED and q < _SHARED:
                if seen[p, q] == i:
                    continue
                seen[p, q] = i
            g, inner = _count_members(rights, n_rights, _Group(i, p, q))
            saved = length * now - (length - (p + q) * (g - 1) + 3) * more
            saved += lefts.nodes[slot[i]] * np.log2(h / (h - g + 1)) - inner * np.log2(g)
            if saved > best:
                best, best_group = saved, _Group(i, p, q)
    return best_group


@kernel
def _count_members(rights: _Rights, n_rights: int, group: _Group) -> tuple[int, int]:
    """Count the members of a group, and their tree nodes."""
    g, nodes = 0, 0
    for r in range(n_rights):
        if r == group.i or _in_group(rights, group, r):
            g += 1
            nodes += rights.table[r, 3]
    return g, nodes


@maker
def _members(rights: _Rights, n_rights: int, group: _Group) -> IntArray:
    """Return the numbers of the members of a group, ascending."""
    members = np.empty(n_rights, dtype=np.int64)
    g = 0
    for r in range(n_rights):
        if r == group.i or _in_group(rights, group, r):
            members[g] = r
            g += 1
    return members[:g]


@kernel
def _in_group(rights: _Rights, group: _Group, r: int) -> bool:
    """Return whether right side r belongs to a group; False for its own right side i."""
    low, high = min(group.i, r), max(group.i, r)
    fits = rights.slot[group.i] == rights.slot[r] and low != high
    fits = fits and rights.table[r, 2] >= group.p + group.q
    return bool(
        fits and rights.begins[low, high] >= group.p and rights.closes[low, high] >= group.q
    )


@kernel
def _compare(rights: _Rights, i: int, j: int) -> None:
    """Record the lengths of the common beginning and end of two right sides i < j.

    Their sum is at most the length of the shorter right side.
    """
    table, text = rights.table, rights.text
    a, b = table[i, 1], table[j, 1]
    n, m = table[i, 2], table[j, 2]
    least = min(n, m)
    p = 0
    while p < least and text[a + p] == text[b + p]:
        p += 1
    q = 0
    while q < least - p and text[a + n - 1 - q] == text[b + m - 1 - q]:
        q += 1
    rights.begins[i, j] = p
    rights.closes[i, j] = q


@kernel
def _take(
    rights: _Rights, members: IntArray, new: int, end: int, group: _Group, symbol: int
) -> int:
    """Replace a group by one right side, row ``new``; return the new end of the text.

    The middle parts of the members become the alternatives of ``symbol``.
    """
    table, text, p, q = rights.table, rights.text, group.p, group.q
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
    table = np.empty((2 * starts.size + 1, 4), dtype=np.int64)
    most = 2 * (covered.symbols.size + int((ends - starts).max()) + starts.size)
    text = np.empty(most, dtype=np.int64)
    bits, _, _ = _context_grammar(covered, starts, ends, table, text)
    return float(bits)


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
    cover: CoveredString, starts: IntArray, ends: IntArray, table: IntArray, text: IntArray
) -> tuple[float, int, npt.NDArray[np.bool_]]:
    """Return bits, the number of right sides in ``table``, and which repeats are nonterminals.

    ``table`` (right sides, 4) and ``text`` are work arrays that are filled.
    """
    n_terminals, repeat_lengths = cover.n_terminals, cover.repeat_lengths
    hashes, powers = cover.hashes, cover.powers
    firsts, counts = _distinct(hashes, powers, starts, ends)
    used = _paying_repeats(cover, starts, ends, firsts)
    n_rights = firsts.size
    end = 0
    for r in range(n_rights):
        table[r, 0] = cover.n_terminals
        table[r, 1] = end
        table[r, 3] = counts[r]
        end = _write_sentence(cover, used, starts[firsts[r]], ends[firsts[r]], text, end)
        table[r, 2] = end - table[r, 1]
    length = 0  # of the whole sequence of rules
    for r in range(n_rights):
        length += table[r, 2] + 2
    n_nonterminals = 1
    for number in range(used.size):
        if used[number]:
            length += repeat_lengths[number] + 2
            n_nonterminals += 1
    size = Size(n_rights, end, length - 1, n_nonterminals)
    n_rights, length, n_nonterminals, data = group_by_contexts(
        table, text, size, n_terminals, used.size
    )
    return length * np.log2(n_nonterminals + n_terminals + 1) + data, n_rights, used


@maker
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


@maker
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


@maker
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
