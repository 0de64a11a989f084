"""Cut strings again by rules, so that the sentences take the fewest bits.

Given rules, every part of a string has a price. A part that the start symbol derives costs the bits
of its cheapest derivation, log2 of the number of alternatives at each node. Any other part costs a
new rule: its left side, a separator, and each symbol of the shortest right side of current
nonterminals and terminals, with the bits of what these derive. The cuts of least price are found
exactly, by dynamic programming. These are the cuts that a learner with these rules would make.
Rules learned from the new sentences take no more bits, and so on (learning by hard assignment, as
in segmental k-means).

Nonterminals are processed component by component, bottom-up. The prices of nonterminals that derive
themselves are a fixed point: they are computed for the last first symbol of a part to the first
one, and for each first symbol again until no price falls. With N symbols, parts of at most L
symbols and M symbols in all right sides the time is at most M N L^2 for rules without loops, and
far less where few parts are derived.

Sources: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1, for the bits; R. Bellman, "Dynamic Programming"
(1957); B.-H. Juang and L. R. Rabiner, "The segmental K-means algorithm", IEEE Transactions on
Acoustics, Speech, and Signal Processing 38 (1990).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.rules.rule_laws import components, recursive_lefts
from motiondb.grammar.rules.rule_set import RuleSet
from motiondb.records import BoolArray, Float32Array, FloatArray, IntArray

_LOWER = 1e-3
"""Bits by which a price must fall to be passed on: more than the rounding of single precision."""


class _Rows(NamedTuple):
    """Rules as rows (left, offset, length, number of alternatives of the left side) over a text."""

    table: IntArray
    text: IntArray
    n_terminals: int


def cut_by_rules(
    symbols: IntArray,
    bounds: IntArray,
    rule_set: RuleSet,
    lengths: tuple[int, int],
    *,
    novelty: float = 1.0,
    shaken: FloatArray | None = None,
) -> tuple[tuple[int, ...], ...]:
    """Return the inner cuts of least price for each string.

    Shapes: `symbols`, `shaken` (N,); `bounds` (strings + 1,).

    `lengths`: Shortest and longest sentence, in symbols. A string that cannot be cut into such
    sentences stays whole.

    `novelty`: Factor of the price of new rules. A lower factor gives more new sentences.

    >>> rules = RuleSet(3, {3: {(0, 4): 3}, 4: {(1,): 2, (2,): 1}})  # S -> a A, A -> b | c
    >>> symbols, bounds = np.array([0, 1, 0, 2, 0, 1, 3]), np.array([0, 7])
    >>> cut_by_rules(symbols, bounds, rules, (1, 7))
    ((2, 4),)
    """
    shortest, longest = lengths
    longest = min(longest, int(np.diff(bounds).max()) - 1)  # a larger value only needs memory
    price = sentence_prices(symbols, rule_set, longest, novelty)
    if shaken is not None:
        price += shaken[:, None]
    cuts = []
    for low, high in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        places = _cheapest(price[low : high - 1], shortest)
        cuts.append(tuple(places.tolist()))
    return tuple(cuts)


def sentence_prices(
    symbols: IntArray, rule_set: RuleSet, longest: int, novelty: float = 1.0
) -> FloatArray:
    """Return the price of each part of the strings as a sentence.

    Shapes: `symbols` (N,); result (N, longest + 1).
    """
    groups = components(rule_set.rules)
    order = [left for group in groups for left in group]
    number = {left: place for place, left in enumerate(order)}
    n_terminals = rule_set.n_terminals
    text: list[int] = []
    rows = []
    for left in order:
        for right in rule_set.rules[left]:
            coded = [s if s < n_terminals else n_terminals + number[s] for s in right]
            rows.append((number[left], len(text), len(right), len(rule_set.rules[left])))
            text.extend(coded)
    table = np.array(rows, dtype=np.int64).reshape(-1, 4)
    letter = float(np.log2(len(order) + n_terminals + 1))
    sizes = [sum(len(rule_set.rules[left]) for left in group) for group in groups]
    looping = recursive_lefts(rule_set.rules)
    bits = _derivation_bits(
        symbols,
        _Rows(table, np.array(text, np.int64), n_terminals),
        np.cumsum([0, *sizes]),
        np.array([group[0] in looping for group in groups]),
        longest,
    )
    new = _new_rule_bits(symbols, bits, n_terminals, letter)
    known = bits[number[rule_set.start]].astype(np.float64)
    more = np.log2(len(rule_set.rules[rule_set.start]) + 1.0)
    return np.minimum(known, novelty * (new + 2.0 * letter) + more)


@njit(cache=True)
def _derivation_bits(
    symbols: IntArray, rows: _Rows, groups: IntArray, recursive: BoolArray, longest: int
) -> Float32Array:
    """Return the bits of deriving each part from each of V nonterminals (V, N, longest + 1).

    ``groups`` (components + 1,) says where the rules of each component begin, ``recursive``
    (components,) whether its nonterminals derive themselves.
    """
    n, table = symbols.size, rows.table
    n_lefts = table[:, 0].max() + 1
    bits = np.full((n_lefts, n, longest + 1), np.inf, dtype=np.float32)
    for g in range(recursive.size):
        first, last = groups[g], groups[g + 1]
        if not recursive[g]:
            for r in range(first, last):
                for i in range(n):
                    _lower(symbols, rows, r, i, bits)
            continue
        for i in range(n - 1, -1, -1):
            lowered = True
            while lowered:
                lowered = False
                for r in range(first, last):
                    if _lower(symbols, rows, r, i, bits):
                        lowered = True
    return bits


@njit(cache=True)
def _lower(symbols: IntArray, rows: _Rows, r: int, i: int, bits: Float32Array) -> bool:
    """Lower the bits of the parts that a rule derives from symbol ``i``; True if any fell."""
    left, offset, length, alternatives = rows.table[r]
    longest = bits.shape[2] - 1
    now = np.full(longest + 1, np.inf, dtype=np.float32)
    now[0] = np.float32(np.log2(alternatives))
    reach = 0
    for k in range(offset, offset + length):
        symbol = rows.text[k]
        if symbol < rows.n_terminals:
            now, reach = _read_terminal(now, reach, i, symbols, symbol)
        else:
            now, reach = _read_nonterminal(now, reach, i, bits[symbol - rows.n_terminals])
        if reach < 0:
            break
    lowered = False
    for m in range(reach + 1):
        if now[m] < bits[left, i, m]:
            lowered = lowered or now[m] < bits[left, i, m] - np.float32(_LOWER)
            bits[left, i, m] = now[m]
    return lowered


@njit(cache=True)
def _read_terminal(
    now: Float32Array, reach: int, i: int, symbols: IntArray, symbol: int
) -> tuple[Float32Array, int]:
    """Extend the prefixes that begin at i by a terminal.

    Return their bits by length, and the length of the longest; -1 if there is none.
    """
    n, longest = symbols.size, len(now) - 1
    new = np.full(longest + 1, np.inf, dtype=np.float32)
    new_reach = -1
    for m in range(min(reach, n - i, longest) + 1):
        if now[m] < np.inf and m < longest and i + m < n and symbols[i + m] == symbol:
            new[m + 1] = now[m]
            new_reach = m + 1
    return new, new_reach


@njit(cache=True)
def _read_nonterminal(
    now: Float32Array, reach: int, i: int, below: Float32Array
) -> tuple[Float32Array, int]:
    """Extend the prefixes that begin at i by a nonterminal, with bits ``below`` (N, lengths).

    Return their bits by length, and the length of the longest; -1 if there is none.
    """
    n, longest = below.shape[0], len(now) - 1
    new = np.full(longest + 1, np.inf, dtype=np.float32)
    new_reach = -1
    for m in range(min(reach, n - 1 - i) + 1):
        if now[m] == np.inf:
            continue
        for q in range(longest - m + 1):
            if now[m] + below[i + m, q] < new[m + q]:
                new[m + q] = now[m] + below[i + m, q]
                new_reach = max(new_reach, m + q)
    return new, new_reach


@njit(cache=True)
def _new_rule_bits(
    symbols: IntArray, bits: Float32Array, n_terminals: int, letter: float
) -> FloatArray:
    """Return the bits of each part as the right side of a new rule (N, longest + 1)."""
    n_lefts, n, width = bits.shape
    new = np.full((n + 1, width), np.inf)
    new[:, 0] = 0.0
    for i in range(n - 1, -1, -1):
        if symbols[i] >= n_terminals:  # the end of a string
            continue
        for m in range(1, width):
            piece = letter if m == 1 else np.inf
            for left in range(n_lefts):
                piece = min(piece, letter + bits[left, i, m])
            if piece == np.inf or i + m > n:
                continue
            for q in range(width - m):
                new[i, m + q] = min(new[i, m + q], piece + new[i + m, q])
    return new[:n]


@njit(cache=True)
def _cheapest(price: FloatArray, shortest: int) -> IntArray:
    """Return the inner cuts of least price of one string, given prices (N, longest + 1)."""
    n, width = price.shape
    least = np.full(n + 1, np.inf)
    before = np.zeros(n + 1, dtype=np.int64)
    least[0] = 0.0
    for i in range(n):
        if least[i] == np.inf:
            continue
        for m in range(shortest, min(width - 1, n - i) + 1):
            if least[i] + price[i, m] < least[i + m]:
                least[i + m], before[i + m] = least[i] + price[i, m], i
    cuts = np.empty(n, dtype=np.int64)
    n_cuts = 0
    if least[n] < np.inf:
        j = before[n]
        while j > 0:
            cuts[n_cuts] = j
            n_cuts += 1
            j = before[j]
    return cuts[:n_cuts][::-1].copy()
