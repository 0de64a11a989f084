"""Lengths of the strings of a grammar: their mean, and the weight of every length.

W(X, l) is the total probability of the strings of l terminals that X derives: the chart of a
sentence of l symbols that may be anything, in which only the length of a span matters. W(A, l) =
sum p(A -> Y) W(Y, l) and W(Y Z, l) = sum over k of W(Y, k) W(Z, l - k). Steps that read nothing are
summed by the chains of the compiled grammar. Each length has its own power of two.
"""

from __future__ import annotations

from functools import lru_cache
from math import frexp, inf, ldexp
from typing import NamedTuple

import numpy as np
from numba import njit

from motiondb.grammar.cfg.closure import Sparse
from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form
from motiondb.records import BoolArray, FloatArray, IntArray


class _Forms(NamedTuple):
    """The data on which the lengths of strings depend."""

    terminals: tuple[int, int]  # First terminal, and the symbol after the last
    left: IntArray  # (S,): left child of each symbol that is a tail, else -1
    right: IntArray  # (S,): right child of each symbol that is a tail, else -1
    chains: Sparse  # Chains to each symbol that read nothing
    empties: FloatArray  # (S,): probability that a symbol becomes empty


@njit(cache=True)
def _fill_lengths(n: int, forms: _Forms) -> tuple[FloatArray, IntArray]:
    """Fill W up to length n, and the exponents."""
    n_symbols = len(forms.empties)
    weights, exponents = np.zeros((n + 1, n_symbols)), np.zeros(n + 1, np.int64)
    weights[0] = forms.empties
    possible = np.zeros(n + 1, np.bool_)
    for length in range(1, n + 1):
        base = np.zeros(n_symbols)
        if length == 1:
            base[forms.terminals[0] : forms.terminals[1]] = 1.0
        top = _add_tails(base, weights, exponents, possible, length, forms)
        for symbol in range(n_symbols):
            if base[symbol] > 0.0:
                for c in range(forms.chains.starts[symbol], forms.chains.starts[symbol + 1]):
                    above, weight = forms.chains.columns[c], forms.chains.values[c]
                    weights[length, above] += weight * base[symbol]
        greatest = weights[length].max()
        if greatest > 0.0:
            shift = frexp(greatest)[1]
            for symbol in range(n_symbols):
                weights[length, symbol] = ldexp(weights[length, symbol], -shift)
            exponents[length], possible[length] = top + shift, True
    return weights, exponents


@njit(cache=True)
def _add_tails(
    base: FloatArray,
    weights: FloatArray,
    exponents: IntArray,
    possible: BoolArray,
    length: int,
    forms: _Forms,
) -> int:
    """Add the tails of two strings of ``length`` together to ``base``; their power of two."""
    top, is_known = 0, False
    for k in range(1, length):
        exponent = exponents[k] + exponents[length - k]
        if possible[k] and possible[length - k] and (not is_known or exponent > top):
            top, is_known = exponent, True
    for k in range(1, length):
        if not (possible[k] and possible[length - k]):
            continue
        factor = ldexp(1.0, exponents[k] + exponents[length - k] - top)
        for tail in range(len(base)):
            if forms.left[tail] >= 0:
                first = weights[k, forms.left[tail]]
                base[tail] += first * weights[length - k, forms.right[tail]] * factor
    return top


@lru_cache(maxsize=16)
def length_weights(compiled: CompiledGrammar, n: int) -> tuple[FloatArray, IntArray]:
    """Return W for lengths 0 to ``n``: values (n + 1, S) and the exponent of 2 of each length."""
    terminals = (compiled.terminals.start, compiled.terminals.stop)
    forms = _Forms(terminals, compiled.left, compiled.right, compiled.all_chains, compiled.empties)
    return _fill_lengths(n, forms)


def shortest_length(compiled: CompiledGrammar) -> int:
    """Return the length of the shortest string of the grammar."""
    lengths = np.full(compiled.n_symbols, inf)
    lengths[compiled.terminals] = 1.0
    tails, right = compiled.left >= 0, compiled.rule_right
    while True:
        new = lengths.copy()
        new[tails] = lengths[compiled.left[tails]] + lengths[compiled.right[tails]]
        np.minimum.at(new, compiled.rule_left, np.where(right < 0, 0.0, lengths[right]))
        if np.array_equal(new, lengths):
            return int(lengths[compiled.start])
        lengths = new


def longest_length(compiled: CompiledGrammar) -> float:
    """Return the length of the longest string of the grammar, infinite if there is no longest.

    A tree in which no symbol occurs below itself is at most as deep as the number of symbols.
    Lengths that still grow after that many rounds are unbounded.
    """
    lengths = np.full(compiled.n_symbols, -inf)
    lengths[compiled.terminals] = 1.0
    tails, right = compiled.left >= 0, compiled.rule_right
    for _ in range(compiled.n_symbols + 1):
        new = lengths.copy()
        new[tails] = lengths[compiled.left[tails]] + lengths[compiled.right[tails]]
        np.maximum.at(new, compiled.rule_left, np.where(right < 0, 0.0, lengths[right]))
        if np.array_equal(new, lengths):
            return float(lengths[compiled.start])
        lengths = new
    return inf


def nearest_length(grammar: AnyGrammar, length: int) -> int:
    """Return the nearest length that a string of the grammar has; of two, the shorter.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> pairs = read_grammar("S -> a S b | empty")
    >>> nearest_length(pairs, 6), nearest_length(pairs, 7)
    (6, 6)
    """
    compiled = compiled_form(grammar)
    shortest = shortest_length(compiled)
    if length <= shortest:
        return shortest
    longest = longest_length(compiled)
    if length >= longest:
        return int(longest)
    farthest = 2 * length - shortest
    seen = min(length + 8, farthest)
    while True:
        weights, _ = length_weights(compiled, seen)
        possible = np.flatnonzero(weights[:, compiled.start] > 0)
        best = int(possible[np.argmin(np.abs(possible - length))])
        if abs(best - length) <= seen - length or seen == farthest:
            return best
        seen = min(length + abs(best - length), farthest)


def mean_length(compiled: CompiledGrammar, chances: FloatArray) -> float:
    """Return the mean length of the strings of random derivations: M = own terminals + M m, solved.

    It is infinite if a derivation may not end.

    Shapes: `chances` (rules in use,).
    """
    parts, n_terminals = _expected_parts(compiled)
    expected = np.zeros((compiled.n_nonterminals, compiled.n_nonterminals))
    np.add.at(expected, compiled.rule_left, chances[:, None] * parts)
    terminals = np.bincount(
        compiled.rule_left, weights=chances * n_terminals, minlength=compiled.n_nonterminals
    )
    right_sides = np.stack([terminals, np.ones(compiled.n_nonterminals)], axis=1)
    try:
        means = np.linalg.solve(np.eye(compiled.n_nonterminals) - expected, right_sides)
    except np.linalg.LinAlgError:
        return inf
    # rules needed: at least 1 each and finite exactly where the spectral radius is below 1
    if not (np.isfinite(means).all() and (means[:, 1] >= 1 - 1e-9).all()):
        return inf
    return float(means[compiled.start, 0])


@lru_cache(maxsize=16)
def _expected_parts(compiled: CompiledGrammar) -> tuple[FloatArray, FloatArray]:
    """Count nonterminals (R, N) and terminals (R,) on the right side of each rule in use."""
    index = {name: k for k, name in enumerate(compiled.names[: compiled.n_nonterminals])}
    parts = np.zeros((len(compiled.rule_numbers), compiled.n_nonterminals))
    terminals = np.zeros(len(compiled.rule_numbers))
    for row, rule in enumerate(compiled.rule_numbers):
        for symbol in compiled.grammar.rules[rule].right:
            if symbol in index:
                parts[row, index[symbol]] += 1
            else:
                terminals[row] += 1
    return parts, terminals
