"""Random derivations of a grammar that always end, optionally with a given length.

Each nonterminal, from the start symbol down, is rewritten by a rule that is drawn by its
probability. With a cyclic grammar this may never end, or only after very many steps. In that case
every rule probability is multiplied by the same factor theta < 1 (damping). A tree of m rules
becomes theta^m times as likely, so the ratios between trees of equal size do not change. theta is
the greatest factor for which the mean length of a string does not exceed a given mean. Derivations
of the damped grammar end with probability 1.

Trees are drawn from the root downwards (:mod:`motiondb.grammar.cfg.trees`). For a given length,
they are drawn exactly from the undamped grammar, restricted to strings of this length, by the
weights W(X, l) of symbol X at length l (:mod:`motiondb.grammar.cfg.lengths`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from math import exp

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
from motiondb.grammar.cfg.inside import inside
from motiondb.grammar.cfg.lengths import length_weights, mean_length, nearest_length
from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form
from motiondb.grammar.cfg.trees import Trees
from motiondb.records import FloatArray

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
