"""Lengths of the strings of a grammar: their mean, and the weight of every length.

W(X, l) is the total probability of the strings of l terminals that X derives: what it derives from
the first to the l-th state of the automaton of all strings (:mod:`.automata`), in which only the
distance of two states matters.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf

import numpy as np

from motiondb.grammar.cfg import automata
from motiondb.grammar.cfg.closure import SUM
from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.inside import Inside, find, inside
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form
from motiondb.records import FloatArray


@lru_cache(maxsize=16)
def length_weights(compiled: CompiledGrammar, n: int) -> Inside:
    """Return W of all lengths up to ``n``: that of length l leads from state 0 to state l."""
    return inside(compiled, automata.lengths(n, len(compiled.ids)), SUM, shift=True)


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
        made = length_weights(compiled, seen)
        values = [find(made, compiled.start, 0, n)[0] for n in range(seen + 1)]
        possible = np.flatnonzero(values)
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
