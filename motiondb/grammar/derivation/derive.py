"""Random derivations of a grammar that always end, optionally with a given length.

Each nonterminal, from the start symbol down, is rewritten by a rule that is drawn by its
probability. With a cyclic grammar this may never end, or only after very many steps. In that case
every rule probability is multiplied by the same factor theta < 1 (damping). A tree of m rules
becomes theta^m times as likely, so the ratios between trees of equal size do not change. theta is
the greatest factor for which the mean length of a string does not exceed a given mean. Derivations
of the damped grammar end with probability 1.

Trees are drawn from the root downwards (:mod:`motiondb.grammar.cfg.trees`). For a given length,
they are drawn exactly from the undamped grammar, restricted to strings of this length, by the
weights W(X, l): the total probability of the strings of l terminals that X derives. It is what X
derives from the first to the l-th state of the automaton of all strings
(:mod:`motiondb.grammar.cfg.automata`), in which only the distance of two states matters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from math import exp, inf

import numpy as np

from motiondb.grammar.cfg import automata
from motiondb.grammar.cfg.closure import SUM
from motiondb.grammar.cfg.compiled import (
    CompiledGrammar,
    ending_chances,
    finite_part,
    with_chances,
)
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Tree, derive_by
from motiondb.grammar.cfg.inside import Inside, find, inside
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form
from motiondb.grammar.cfg.trees import Trees
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


MEAN_LENGTH = 100.0  # Default bound on the mean number of symbols of a random string

_WEAKEST = -12.0  # natural logarithm of the strongest damping; chosen by hand, not tuned


def derive(
    grammar: AnyGrammar,
    rng: np.random.Generator,
    *,
    length: int | None = None,
    most: float = MEAN_LENGTH,
) -> Tree:
    """Return a random tree of a grammar.

    `length`: Number of symbols of the string. If no string has this length, the nearest length that
    some string has is used; of two, the shorter. The leaves of the tree show which.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> a S b | c")
    >>> "".join(derive(toy, np.random.default_rng(0), length=7).leaves())
    'aaacbbb'
    """
    compiled = compiled_form(grammar)
    if length is not None and length < 0:
        raise GrammarError(
            f"length: expected 0 or more symbols, found {length}. Ask for a length of at least 1."
        )
    if length is None:
        compiled, n = damped(compiled, most), 0
    else:
        n = length = nearest_length(compiled, length)
    drawn = _trees_of(compiled, length).draw((compiled.start, 0, n), rng)
    assert drawn is not None
    return derive_by(compiled.grammar, drawn[0])


@lru_cache(maxsize=16)
def damped(compiled: CompiledGrammar, most: float = MEAN_LENGTH) -> CompiledGrammar:
    """Return a grammar whose derivations end and have a bounded mean length.

    The grammar is not damped if this holds already. Otherwise the bound is `most`, or twice the
    mean length at the strongest damping if that is greater.
    """
    finite = finite_part(compiled)
    if mean_length(finite, finite.probabilities) <= most:
        return finite
    low, high = _WEAKEST, 0.0
    most = max(most, 2 * mean_length(compiled, _damped_chances(compiled, low)))
    while high - low > 1e-6:
        middle = (low + high) / 2
        if mean_length(compiled, _damped_chances(compiled, middle)) <= most:
            low = middle
        else:
            high = middle
    return with_chances(compiled, _damped_chances(compiled, low))


def _damped_chances(compiled: CompiledGrammar, log_factor: float) -> FloatArray:
    """Return the rule probabilities (R,) of a damped grammar, given that derivations end."""
    weaker = replace(compiled, probabilities=compiled.probabilities * exp(log_factor))
    return ending_chances(weaker)


@lru_cache(maxsize=16)
def _trees_of(compiled: CompiledGrammar, length: int | None) -> Trees:
    """Return the trees of all strings of a length, or of all strings."""
    weights = compiled.weights(SUM)
    if length is not None:
        return Trees(compiled, length_weights(compiled, length), weights)
    stays = np.ones((1, len(compiled.ids)))
    anything = automata.chain(stays[:0], stays)
    return Trees(compiled, inside(compiled, anything), weights)


def draw_chain(
    grammar: Grammar, seconds: Mapping[str, float], wanted: float, rng: np.random.Generator
) -> tuple[Tree, ...]:
    """Draw sentences that follow one another until they take a wanted time.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> chain = draw_chain(
    ...     read_grammar("S -> a b"), {"a": 1.0, "b": 2.0}, 10.0, np.random.default_rng(0)
    ... )
    >>> [" ".join(tree.leaves()) for tree in chain]
    ['a b', 'a b', 'a b']
    """
    trees: list[Tree] = []
    total = 0.0
    while total < wanted:
        tree = derive(grammar, rng)
        longer = total + sum(seconds[name] for name in tree.leaves())
        if trees and wanted - total <= longer - wanted:
            break
        trees.append(tree)
        total = longer
    return tuple(trees)
