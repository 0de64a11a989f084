"""Random derivations: they end, stay in the language, and have the right distribution."""

from __future__ import annotations

from collections import Counter
from itertools import product
from math import exp

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_grammars import grammars

from motiondb.grammar.cfg.compiled import compile_grammar
from motiondb.grammar.cfg.context_free import (
    Grammar,
    GrammarError,
    choices_of,
    derive_by,
    read_grammar,
)
from motiondb.grammar.cfg.parse import accepts, compiled_form, log_probability
from motiondb.grammar.derivation.derive import (
    damped,
    derive,
    length_weights,
    longest_length,
    mean_length,
    nearest_length,
    shortest_length,
)
from motiondb.grammar.languages import finite_language


@given(grammars(), st.integers(0, 2**32 - 1), st.sampled_from([None, 0, 1, 4, 9]))
@settings(max_examples=30, deadline=None)
def test_never_leaves_the_language(grammar: Grammar, seed: int, length: int | None) -> None:
    rng = np.random.default_rng(seed)
    tree = derive(grammar, rng, length=length, most=20.0)
    assert derive_by(grammar, choices_of(tree)) == tree
    if len(tree.leaves()) < 120:
        assert accepts(grammar, tree.leaves())
    if length is not None:
        assert len(tree.leaves()) == nearest_length(grammar, length)


@given(grammars(), st.integers(0, 6))
@settings(max_examples=40, deadline=None)
def test_nearest_length_is_the_nearest(grammar: Grammar, length: int) -> None:
    possible = [n for n in range(9) if any(accepts(grammar, s) for s in product("ab", repeat=n))]
    actual = nearest_length(grammar, length)
    if possible:
        best = min(possible, key=lambda n: (abs(n - length), n))
        assert actual == best or (abs(best - length) > 8 - length and actual > 8)
        assert shortest_length(compile_grammar(grammar)) == possible[0]
    else:
        assert actual > 8


@given(grammars())
@settings(max_examples=30, deadline=None)
def test_weights_of_lengths_are_sums_over_strings(grammar: Grammar) -> None:
    compiled = compile_grammar(grammar)
    made = length_weights(compiled, 4)
    for n in range(5):
        total = sum(exp(log_probability(compiled, s)) for s in product("ab", repeat=n))
        assert made.weight(compiled.start, 0, n) == pytest.approx(total, rel=1e-9)


@given(grammar=grammars())
def test_the_longest_string_is_that_of_the_language(grammar: Grammar) -> None:
    language = finite_language(grammar, 1000)
    actual = longest_length(compile_grammar(grammar))
    if language is None:
        assert actual >= 9  # more than 1,000 strings of two letters
    else:
        assert actual == max(map(len, language))


def expected_length(grammar):
    """Mean length of the strings of random derivations."""
    compiled = compiled_form(grammar)
    return mean_length(compiled, compiled.probabilities)


@pytest.mark.parametrize("text", ["S -> S S [0.5] | a [0.5]", "S -> a S b [0.999] | c [0.001]"])
def test_damping_reaches_the_asked_mean_and_no_further(text: str) -> None:
    grammar = read_grammar(text)
    for most in (5.0, 40.0):
        milder = damped(compile_grammar(grammar), most)
        assert expected_length(milder) == pytest.approx(most, rel=1e-2)
        assert expected_length(milder) <= most
        assert milder.grammar.terminals == grammar.terminals


def test_damping_keeps_the_proportions_of_trees_of_equal_size() -> None:
    grammar = read_grammar("S -> S S [0.6] | a [0.3] | b [0.1]")
    milder = damped(compile_grammar(grammar), 3.0)
    chance = {s: exp(log_probability(milder, s)) for s in ("aaa", "aba", "bba")}
    assert chance["aaa"] / chance["aba"] == pytest.approx(3)
    assert chance["aba"] / chance["bba"] == pytest.approx(3)


def chi_square(counts: Counter, chance: dict, n: int) -> float:
    rest = 1 - sum(chance.values())
    other = n - sum(counts[s] for s in chance)
    terms = [(counts[s] - n * p) ** 2 / (n * p) for s, p in chance.items()]
    return sum(terms) + ((other - n * rest) ** 2 / (n * rest) if rest > 1e-9 else 0.0)


def test_strings_come_as_often_as_they_are_probable() -> None:
    grammar = read_grammar("S -> A S [0.3] | A [0.7]\nA -> a [0.5] | b [0.3] | empty [0.2]")
    rng, n = np.random.default_rng(1), 3000
    counts = Counter(derive(grammar, rng).leaves() for _ in range(n))
    strings = [s for k in range(3) for s in product("ab", repeat=k)]
    chance = {s: exp(log_probability(grammar, s)) for s in strings}
    # 7 degrees of freedom: above 24.3 in 1 of 1,000 cases
    assert chi_square(counts, chance, n) < 24.3


def test_strings_of_a_length_come_in_their_proportions() -> None:
    grammar = read_grammar("S -> S S [0.5] | a [0.2] | b b [0.2] | S [0.05] | empty [0.05]")
    rng, n = np.random.default_rng(2), 3000
    counts = Counter(derive(grammar, rng, length=3).leaves() for _ in range(n))
    raw = {s: exp(log_probability(grammar, s)) for s in product("ab", repeat=3)}
    raw = {s: p for s, p in raw.items() if p > 0}
    chance = {s: p / sum(raw.values()) for s, p in raw.items()}
    assert set(counts) == set(chance) == {tuple("aaa"), tuple("abb"), tuple("bba")}
    # 2 degrees of freedom: above 13.8 in 1 of 1,000 cases
    assert chi_square(counts, chance, n) < 13.8


def test_a_negative_length_is_refused() -> None:
    with pytest.raises(GrammarError, match=r"length: expected 0 or more symbols, found -1\."):
        derive(read_grammar("S -> a"), np.random.default_rng(0), length=-1)
