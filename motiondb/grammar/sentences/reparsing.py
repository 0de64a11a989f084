"""Cut strings again by rules, so that the sentences take the fewest bits.

Given rules, every part of a string has a price. A part that the start symbol derives costs the bits
of its cheapest derivation, log2 of the number of alternatives at each node. Any other part costs a
new rule: its left side, a separator, and each symbol of the shortest right side of current
nonterminals and terminals, with the bits of what these derive. The cuts of least price are found
exactly, by dynamic programming. These are the cuts that a learner with these rules would make.
Rules learned from the new sentences take no more bits, and so on (learning by hard assignment, as
in segmental k-means).

The prices of what nonterminals derive are those of :mod:`motiondb.grammar.induction.refitting`,
here of all parts of at most L symbols. With N symbols and M symbols in all right sides the time is
at most M N L^2 for rules without loops, and far less where few parts are derived.

Sources: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1, for the bits; R. Bellman, "Dynamic Programming"
(1957); B.-H. Juang and L. R. Rabiner, "The segmental K-means algorithm", IEEE Transactions on
Acoustics, Speech, and Signal Processing 38 (1990).
"""

from __future__ import annotations

import numpy as np

from motiondb.grammar.induction.refitting import cheapest_parts, costs_of
from motiondb.grammar.kernels import maker
from motiondb.grammar.rules.rule_set import RuleSet
from motiondb.records import FloatArray, IntArray


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
    costs, _, _ = costs_of(rule_set)
    bits, letter = cheapest_parts(costs, symbols, longest)[:, :-1], costs.symbol_bits
    new = _new_rule_bits(symbols, bits, rule_set.n_terminals, letter)
    more = np.log2(len(rule_set.rules[rule_set.start]) + 1.0)
    return np.minimum(bits[0], novelty * (new + 2.0 * letter) + more)


@maker
def _new_rule_bits(
    symbols: IntArray, bits: FloatArray, n_terminals: int, letter: float
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


@maker
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
