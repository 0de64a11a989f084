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

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1, for the description length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from motiondb.grammar.rules.repeats import cover_repeats
from motiondb.grammar.sentences.grouping import Size, group_by_contexts

IntArray = npt.NDArray[np.int64]
_HASH = np.uint64(0x9E3779B97F4A7C15)
"""Multiplier of the polynomial hash: 2^64 divided by the golden ratio, which is odd and has no
regular bit pattern."""


class _Cover(NamedTuple):
    """The arrays of a :class:`CoveredString`, for compiled functions."""

    symbols: IntArray
    n_terminals: int
    repeat_at: IntArray
    repeat_starts: IntArray
    repeat_lengths: IntArray
    hashes: npt.NDArray[np.uint64]
    powers: npt.NDArray[np.uint64]


@dataclass(frozen=True, eq=False)
class CoveredString:
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
    table = np.array(firsts, dtype=np.int64).reshape(-1, 2)
    hashes, powers = _hashes(symbols)
    return CoveredString(
        symbols, n_terminals, repeat_at, table[:, 0], table[:, 1], inside, hashes, powers
    )


def context_bits(covered: CoveredString, starts: IntArray, ends: IntArray) -> float:
    """Return the description length of sentences by the grammar of their contexts.

    Shapes: `starts`, `ends` (sentences,).
    """
    n = _rights_at_most(starts)
    table = np.empty((n, 4), dtype=np.int64)
    text = np.empty(_text_at_most(starts, ends, covered), dtype=np.int64)
    bits, _, _ = _context_grammar(_arrays(covered), starts, ends, table, text)
    return float(bits)


def _arrays(covered: CoveredString) -> _Cover:
    return _Cover(
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
    """Return the hashes of all prefixes, and the powers of the multiplier."""
    hashes = np.zeros(symbols.size + 1, dtype=np.uint64)
    powers = np.ones(symbols.size + 1, dtype=np.uint64)
    for i in range(symbols.size):
        hashes[i + 1] = hashes[i] * _HASH + np.uint64(symbols[i] + 1)
        powers[i + 1] = powers[i] * _HASH
    return hashes, powers


@njit(cache=True)
def _context_grammar(
    cover: _Cover, starts: IntArray, ends: IntArray, table: IntArray, text: IntArray
) -> tuple[float, int, npt.NDArray[np.bool_]]:
    """Return bits, the number of right sides in ``table``, and which repeats are nonterminals.

    ``table`` (right sides, 4) and ``text`` are work arrays that are filled.
    """
    _, n_terminals, _, _, repeat_lengths, hashes, powers = cover
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


@njit(cache=True)
def _write_sentence(
    cover: _Cover, used: npt.NDArray[np.bool_], i: int, stop: int, text: IntArray, end: int
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


@njit(cache=True)
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


@njit(cache=True)
def _paying_repeats(
    cover: _Cover, starts: IntArray, ends: IntArray, firsts: IntArray
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
