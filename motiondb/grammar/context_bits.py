"""Description length of a partition within a fraction of a millisecond: what the search asks.

A partition is judged by the grammar that contexts give, a family simple enough to be induced and
counted thousands of times a second:

1. equal sentences are one rule of S;
2. of the repeats that the cover has chosen, those that pay are nonterminals with one rule;
3. right sides of one nonterminal that share a beginning and an end become one rule, what stands
   between becomes the alternatives of a new nonterminal; the group that saves most bits is taken,
   until none saves any. Alternatives are grouped further in the same way.

The bits are those of ``description`` for that grammar: an upper bound of what ``induction`` finds
for the same sentences. ``context_rules`` gives the grammar itself.

Notation: rights are rows of (left, offset, length, count) over one array of symbols. Terminals
are 0..T-1, the start symbol T, repeats T+1.. by their number, further nonterminals above.

Source: description length from J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures
from Human Motion Data", Computer Graphics Forum 30 (2011), section 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

from motiondb.grammar.repeats import cover_repeats
from motiondb.grammar.rule_set import Rules, RuleSet

IntArray = npt.NDArray[np.int64]
_HASH = np.uint64(0x9E3779B97F4A7C15)


@dataclass(frozen=True, eq=False)
class CoveredString:
    """Joined strings with the cover of their repeats; made once, asked for many partitions.

    symbols : array (N,), separators at the ends of strings; n_terminals : K.
    repeat_at : array (N,), number of the repeat that begins there, or -1.
    repeat_starts, repeat_lengths : array (R,), where each repeat first stands and how long it is.
    inside : array (N,), whether a cut before this symbol would divide a chosen occurrence.
    hashes, powers : array (N + 1,), so that equal substrings are found without reading them.
    """

    symbols: IntArray
    n_terminals: int
    repeat_at: IntArray
    repeat_starts: IntArray
    repeat_lengths: IntArray
    inside: npt.NDArray[np.bool_]
    hashes: npt.NDArray[np.uint64]
    powers: npt.NDArray[np.uint64]


def cover_string(symbols: IntArray, n_terminals: int) -> CoveredString:
    """Find the cover of a joined string (see :func:`repeats.join_strings`)."""
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
    table = np.array(firsts, dtype=np.int64).reshape(-1, 2)
    hashes, powers = _hashes(symbols)
    return CoveredString(
        symbols, n_terminals, repeat_at, table[:, 0], table[:, 1], inside, hashes, powers
    )


def context_bits(covered: CoveredString, starts: IntArray, ends: IntArray) -> float:
    """DL of the sentences symbols[starts[i]:ends[i]], none of which divides a chosen occurrence."""
    n = _rights_at_most(starts)
    table = np.empty((n, 4), dtype=np.int64)
    text = np.empty(_text_at_most(starts, ends, covered), dtype=np.int64)
    bits, _, _ = _context_grammar(*_arrays(covered), starts, ends, table, text)
    return float(bits)


def context_rules(covered: CoveredString, starts: IntArray, ends: IntArray) -> RuleSet:
    """The grammar whose bits :func:`context_bits` counts."""
    n = _rights_at_most(starts)
    table = np.empty((n, 4), dtype=np.int64)
    text = np.empty(_text_at_most(starts, ends, covered), dtype=np.int64)
    _, n_rights, used = _context_grammar(*_arrays(covered), starts, ends, table, text)
    rules: Rules = {covered.n_terminals: {}}
    for left, offset, length, count in table[:n_rights].tolist():
        rules.setdefault(left, {})[tuple(text[offset : offset + length].tolist())] = count
    result = RuleSet(covered.n_terminals, rules)
    for number in np.flatnonzero(used).tolist():
        symbol = covered.n_terminals + 1 + number
        first, length = int(covered.repeat_starts[number]), int(covered.repeat_lengths[number])
        count = sum(
            nodes * right.count(symbol)
            for rights in rules.values()
            for right, nodes in rights.items()
        )
        spelled = tuple(covered.symbols[first : first + length].tolist())
        result.rules[symbol] = {spelled: count}
    return result


def _arrays(covered: CoveredString) -> tuple:
    return (
        covered.symbols,
        covered.n_terminals,
        covered.repeat_at,
        covered.repeat_starts,
        covered.repeat_lengths,
        covered.hashes,
        covered.powers,
    )


def _rights_at_most(starts: IntArray) -> int:
    return 2 * starts.size + 1


def _text_at_most(starts: IntArray, ends: IntArray, covered: CoveredString) -> int:
    return 2 * covered.symbols.size + 2 * int((ends - starts).max()) + 2 * starts.size


@njit(cache=True)
def _hashes(
    symbols: IntArray,
) -> tuple[npt.NDArray[np.uint64], npt.NDArray[np.uint64]]:
    hashes = np.zeros(symbols.size + 1, dtype=np.uint64)
    powers = np.ones(symbols.size + 1, dtype=np.uint64)
    for i in range(symbols.size):
        hashes[i + 1] = hashes[i] * _HASH + np.uint64(symbols[i] + 1)
        powers[i + 1] = powers[i] * _HASH
    return hashes, powers


@njit(cache=True)
def _context_grammar(
    symbols: IntArray,
    n_terminals: int,
    repeat_at: IntArray,
    repeat_starts: IntArray,
    repeat_lengths: IntArray,
    hashes: npt.NDArray[np.uint64],
    powers: npt.NDArray[np.uint64],
    starts: IntArray,
    ends: IntArray,
    table: IntArray,
    text: IntArray,
) -> tuple[float, int, npt.NDArray[np.bool_]]:
    """Bits, number of rights in ``table`` over ``text``, and which repeats are nonterminals."""
    firsts, counts = _distinct(symbols, hashes, powers, starts, ends)
    used = _paying_repeats(repeat_at, repeat_starts, repeat_lengths, starts, ends, firsts)
    n_rights = firsts.size
    end = 0
    for r in range(n_rights):
        table[r, 0] = n_terminals
        table[r, 1] = end
        table[r, 3] = counts[r]
        i = starts[firsts[r]]
        while i < ends[firsts[r]]:
            number = repeat_at[i]
            if number >= 0 and used[number]:
                text[end] = n_terminals + 1 + number
                i += repeat_lengths[number]
            else:
                text[end] = symbols[i]
                i += 1
            end += 1
        table[r, 2] = end - table[r, 1]
    length = 0  # of the whole sequence of rules
    for r in range(n_rights):
        length += table[r, 2] + 2
    n_nonterminals = 1
    for number in range(used.size):
        if used[number]:
            length += repeat_lengths[number] + 2
            n_nonterminals += 1
    n_rights, length, n_nonterminals, data = _group(
        table, text, n_rights, end, length - 1, n_nonterminals, n_terminals, used.size
    )
    return length * np.log2(n_nonterminals + n_terminals + 1) + data, n_rights, used


@njit(cache=True)
def _distinct(
    symbols: IntArray,
    hashes: npt.NDArray[np.uint64],
    powers: npt.NDArray[np.uint64],
    starts: IntArray,
    ends: IntArray,
) -> tuple[IntArray, IntArray]:
    """The first of each group of equal sentences, and how many are in it."""
    n = starts.size
    keys = np.empty(n, dtype=np.uint64)
    for s in range(n):
        keys[s] = hashes[ends[s]] - hashes[starts[s]] * powers[ends[s] - starts[s]]
    firsts = np.empty(n, dtype=np.int64)
    counts = np.zeros(n, dtype=np.int64)
    found = 0
    for s in range(n):
        same = -1
        for f in range(found):
            t = firsts[f]
            if keys[t] == keys[s] and ends[t] - starts[t] == ends[s] - starts[s]:
                same = f
                break
        if same < 0:
            same = found
            firsts[found] = s
            found += 1
        counts[same] += 1
    return firsts[:found], counts[:found]


@njit(cache=True)
def _paying_repeats(
    repeat_at: IntArray,
    repeat_starts: IntArray,
    repeat_lengths: IntArray,
    starts: IntArray,
    ends: IntArray,
    firsts: IntArray,
) -> npt.NDArray[np.bool_]:
    """The repeats that stand in different sentences often enough to be worth a rule."""
    counts = np.zeros(repeat_starts.size, dtype=np.int64)
    for s in firsts:
        for i in range(starts[s], ends[s]):
            if repeat_at[i] >= 0:
                counts[repeat_at[i]] += 1
    used = np.zeros(repeat_starts.size, dtype=np.bool_)
    for number in range(used.size):
        used[number] = counts[number] * (repeat_lengths[number] - 1) > repeat_lengths[number] + 2
    return used


@njit(cache=True)
def _group(
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
    for i in range(n_rights):
        h = alternatives[slot[i]]
        for j in range(i + 1, n_rights):
            p, q = begins[i, j], closes[i, j]
            if slot[i] != slot[j] or p + q == 0:
                continue
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
