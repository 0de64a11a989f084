"""The engine against all trees of a sentence, and against its equations, iterated densely."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_grammars import grammars

from motiondb.grammar.cfg import automata
from motiondb.grammar.cfg.closure import BEST, COUNT, SUM
from motiondb.grammar.cfg.compiled import compile_grammar
from motiondb.grammar.cfg.context_free import Grammar, Rule, read_grammar
from motiondb.grammar.cfg.inside import inside
from motiondb.grammar.cfg.trees import Trees, best_rules, cumulated


@st.composite
def finite_grammars(draw: st.DrawFn) -> Grammar:
    """Grammars in which no nonterminal derives itself: each sentence has finitely many trees."""
    rules = []
    for left, below in (("S", "abAB"), ("A", "abB"), ("B", "ab")):
        rights = st.lists(st.sampled_from(below), max_size=3).map(tuple)
        for right in draw(st.lists(rights, min_size=1, max_size=4, unique=True)):
            rules.append(Rule(left, right, draw(st.sampled_from([1.0, 2.0, 3.0]))))
    made = Grammar("S", tuple(rules), ("a", "b"))
    return made.with_probabilities([rule.probability for rule in rules])


def all_trees(grammar: Grammar, sentence: tuple[str, ...]) -> list[float]:
    """The probability of each tree of a sentence."""

    @cache
    def row(right: tuple[str, ...], i: int, j: int) -> list[float]:
        if not right:
            return [1.0] * (i == j)
        ways = range(i, j + 1)
        return [p * q for k in ways for p in one(right[0], i, k) for q in row(right[1:], k, j)]

    @cache
    def one(symbol: str, i: int, j: int) -> list[float]:
        if not grammar.is_nonterminal(symbol):
            return [1.0] * (sentence[i:j] == (symbol,))
        rules = [grammar.rules[number] for number in grammar.rules_of[symbol]]
        return [rule.probability * p for rule in rules for p in row(rule.right, i, j)]

    return one("S", 0, len(sentence))


@settings(max_examples=60, deadline=None)
@given(finite_grammars(), st.lists(st.sampled_from("ab"), max_size=5).map(tuple))
def test_sum_best_and_number_are_those_of_all_trees(grammar, sentence):
    compiled = compile_grammar(grammar)
    numbers = np.array([compiled.ids[name] for name in sentence], dtype=np.int64)
    line = automata.sentence(numbers - compiled.n_nonterminals, len(compiled.ids))
    trees = all_trees(grammar, sentence)
    for kind, expected in ((SUM, sum(trees)), (BEST, max(trees, default=0)), (COUNT, len(trees))):
        made = inside(compiled, line, kind)
        assert made.weight(compiled.start) == pytest.approx(expected, rel=1e-6)
    best = inside(compiled, line, BEST)
    items = [(compiled.start, 0, len(sentence))]
    yielded = Trees(compiled, best, compiled.weights(BEST)).in_order(items)
    chances = [np.prod([grammar.rules[rule].probability for rule in rules]) for rules in yielded]
    assert chances == pytest.approx(sorted(trees, reverse=True), rel=1e-6)
    found = best_rules(compiled, best, compiled.weights(BEST))
    if found is not None:
        assert np.prod(compiled.probabilities[found]) == pytest.approx(max(trees), rel=1e-6)


def dense(compiled, automaton, kind):
    """The weights (S, Q, Q) by iteration of all equations from 0; None if it does not end.

    Sums over steps that read a string in several ways can be without bound.
    """
    n = automaton.n_states
    given_ = np.zeros((compiled.n_symbols, n, n))
    for s in range(n):
        if automaton.loops[s] >= 0:
            given_[compiled.terminals, s, s] = automaton.stays[automaton.loops[s]]
        for e in range(automaton.starts[s], automaton.starts[s + 1]):
            symbol = compiled.n_nonterminals + automaton.terminals[e]
            given_[symbol, s, automaton.targets[e]] = automaton.weights[e]
    weights, rules = given_.copy(), compiled.weights(kind)
    plus = np.maximum if kind == BEST else np.add
    for _ in range(2000):
        new = given_.copy()
        for symbol in range(compiled.n_symbols):
            if compiled.left[symbol] >= 0:
                one, other = weights[compiled.left[symbol]], weights[compiled.right[symbol]]
                parts = one[:, :, None] * other[None]
                new[symbol] = parts.max(axis=1) if kind == BEST else parts.sum(axis=1)
        for rule, (left, right) in enumerate(
            zip(compiled.rule_left.tolist(), compiled.rule_right.tolist(), strict=True)
        ):
            below = np.eye(n) if right < 0 else weights[right]
            new[left] = plus(new[left], rules[rule] * below)
        if np.allclose(new, weights, rtol=1e-14, atol=0):
            return new
        if new.max() > 1e6:
            return None
        weights = new
    return None


CHAINS = st.lists(st.tuples(*[st.sampled_from([0.0, 0.5, 1.0])] * 4), min_size=1, max_size=4)
STEPS = st.lists(st.booleans(), min_size=18, max_size=18)


@settings(max_examples=40, deadline=None)
@given(grammars(), CHAINS, STEPS, st.sampled_from([SUM, BEST]))
def test_weights_solve_the_equations_of_chains_and_of_blocks(grammar, states, steps, kind):
    compiled = compile_grammar(grammar)
    table = np.array(states)
    line = automata.chain(table[:-1, :2], table[:, 2:])
    blocks = np.array(steps).reshape(3, 2, 3)
    blocks[2, :, :2] = False  # the first two states are a block, the third follows
    blocks = automata.from_steps(blocks, np.array([False, False, True]), np.array([0, 2, 3]))
    for automaton in (line, blocks):
        expected = dense(compiled, automaton, kind)
        if expected is None:
            continue
        made = inside(compiled, automaton, kind)
        n = automaton.n_states
        for symbol, s, t in product(range(compiled.n_symbols), range(n), range(n)):
            value = made.weight(symbol, s, t)
            assert value == pytest.approx(expected[symbol, s, t], rel=1e-6, abs=1e-12)


def test_left_recursion_and_unit_cycles_are_summed_in_closed_form():
    compiled = compile_grammar(read_grammar("S -> S a [0.5] | A [0.5]\nA -> S [0.5] | b [0.5]"))
    line = automata.sentence(np.array([1, 0, 0]), 2)  # b a a: S -> A -> S is a cycle of 1/4
    expected = (1 / 4) / (3 / 4) * (0.5 / (3 / 4)) ** 2
    assert inside(compiled, line).weight(compiled.start) == pytest.approx(expected)
    assert inside(compiled, line, COUNT).weight(compiled.start) == np.inf


def test_draws_over_an_automaton_have_the_probabilities_of_their_trees():
    grammar = read_grammar("S -> S S [0.25] | a [0.5] | b [0.25]")
    compiled = compile_grammar(grammar)
    any_two = automata.chain(np.ones((2, 2)), np.zeros((3, 2)))
    made = inside(compiled, any_two)
    trees = Trees(compiled, made, compiled.weights(SUM))
    rng, n = np.random.default_rng(0), 3000
    drawn = [trees.draw((compiled.start, 0, 2), rng)[1] for _ in range(n)]
    names = [tuple(compiled.names[leaf] for leaf in leaves) for leaves in drawn]
    for string, chance in zip(product("ab", repeat=2), (4 / 9, 2 / 9, 2 / 9, 1 / 9), strict=True):
        assert names.count(string) / n == pytest.approx(chance, abs=4 * (chance / n) ** 0.5)
    assert trees.draw((compiled.start, 0, 2), rng, most=1) is None


def test_an_index_of_weight_0_is_never_drawn():
    assert cumulated([0.0, 2.0, 0.0, 2.0, 0.0]) == [0.0, 0.5, 0.5, 2.0, 2.0]
