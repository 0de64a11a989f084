"""Rule probabilities from sentences: counts by hand and by derivative, likelihood that climbs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg import Grammar, Rule, choices_of, read_grammar
from motiondb.grammar.derive import derive
from motiondb.grammar.estimate import (
    estimate,
    estimate_from_best_trees,
    expected_counts,
    log_likelihood,
    rule_counts,
)
from motiondb.grammar.parse import ParseError, accepts, log_probability, parse

rules = st.builds(
    Rule,
    st.sampled_from(["S", "A", "B"]),
    st.lists(st.sampled_from(["S", "A", "B", "a", "b"]), max_size=3).map(tuple),
    st.sampled_from([1.0, 2.0, 3.0]),
)


@st.composite
def grammars(draw: st.DrawFn) -> Grammar:
    """Small grammars with empty rules and cycles as they come, each side ending with 7 of 10."""
    found = [*draw(st.lists(rules, min_size=2, max_size=6))]
    ending = []
    for left in ("S", "A", "B"):
        ending.append(Rule(left, tuple(draw(st.lists(st.sampled_from(["a", "b"]), max_size=2)))))
    grown = {left: sum(r.probability for r in found if r.left == left) or 1.0 for left in "SAB"}
    weights = [0.3 * r.probability / grown[r.left] for r in found] + [0.7] * 3
    return Grammar("S", (*found, *ending), ("a", "b")).with_probabilities(weights)


@given(grammars(), st.lists(st.sampled_from(["a", "b"]), max_size=4).map(tuple), st.data())
@settings(max_examples=80, deadline=None)
def test_expected_counts_are_the_derivative_of_the_log_probability(
    grammar: Grammar, sentence: tuple[str, ...], data: st.DataObject
) -> None:
    """d log P / d log weight = count - probability x count of the left side."""
    assume(accepts(grammar, sentence))
    counts = expected_counts(grammar, sentence)
    rule = data.draw(st.integers(0, len(grammar.rules) - 1))
    step = 1e-4
    changed = []
    for factor in (np.exp(step), np.exp(-step)):
        weights = [r.probability for r in grammar.rules]
        weights[rule] *= factor
        changed.append(log_probability(grammar.with_probabilities(weights), sentence))
    left = grammar.rules[rule].left
    of_left = sum(counts[r] for r in grammar.rules_of[left])
    expected = counts[rule] - grammar.rules[rule].probability * of_left
    assert (changed[0] - changed[1]) / (2 * step) == pytest.approx(expected, abs=1e-4, rel=1e-4)


@given(grammars(), st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_expected_counts_read_the_sentence_once(grammar: Grammar, seed: int) -> None:
    sentence = derive(grammar, np.random.default_rng(seed), length=5).leaves()
    counts = expected_counts(grammar, sentence)
    read = dict.fromkeys(grammar.terminals, 0.0)
    rewritten = dict.fromkeys(grammar.nonterminals, 0.0)
    rewritten["S"] = -1.0  # the start is nobody's child
    for number, rule in zip(counts, grammar.rules):
        rewritten[rule.left] += number
        for symbol in rule.right:
            if symbol in read:
                read[symbol] += number
            else:
                rewritten[symbol] -= number
    assert read == pytest.approx({t: sentence.count(t) for t in read}, rel=1e-6, abs=1e-9)
    assert rewritten == pytest.approx(dict.fromkeys(rewritten, 0.0), abs=1e-5 * counts.max())


def test_by_hand() -> None:
    # aa: S -> a S, S -> A, A -> a with 1/8, or S -> A, A -> a a with 1/4
    grammar = read_grammar("S -> a S [0.5] | A [0.5]\nA -> a | a a")
    assert expected_counts(grammar, ["a", "a"]) == pytest.approx([1 / 3, 1, 1 / 3, 2 / 3])
    tree = parse(grammar, ["a", "a"])
    assert rule_counts(grammar, [tree, tree]).tolist() == [0, 2, 0, 2]


def test_empty_sentence_through_a_cycle() -> None:
    grammar = read_grammar("S -> S S [0.25] | empty [0.75]")
    # e = 1; m = uses of S -> S S: m = p (1 + 2 m), m = p / (1 - 2 p) = 1/2; one more ends
    assert expected_counts(grammar, []) == pytest.approx([0.5, 1.5])


@given(grammars(), st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_likelihood_never_falls(grammar: Grammar, seed: int) -> None:
    rng = np.random.default_rng(seed)
    sentences = [derive(grammar, rng, length=k).leaves() for k in (1, 3, 4, 4)]
    flat = grammar.with_probabilities([1.0] * len(grammar.rules))
    for learn in (estimate, estimate_from_best_trees):
        found = learn(flat, sentences, rounds=8)
        likelihoods = found.log_likelihoods
        assert all(b >= a - 1e-6 * (1 + abs(a)) for a, b in pairwise(likelihoods))
    found = estimate(flat, sentences, rounds=8)
    assert log_likelihood(found.grammar, sentences) == pytest.approx(found.log_likelihoods[-1])


def test_known_probabilities_are_found_again() -> None:
    truth = read_grammar("S -> A B\nA -> a A [0.3] | a [0.7]\nB -> b [0.6] | c [0.3] | empty [0.1]")
    rng = np.random.default_rng(5)
    sentences = [derive(truth, rng).leaves() for _ in range(2000)]
    start = truth.with_probabilities([1.0] * len(truth.rules))
    for found in (estimate(start, sentences), estimate_from_best_trees(start, sentences)):
        for a, b in zip(found.grammar.rules, truth.rules):
            assert a.probability == pytest.approx(b.probability, abs=0.04)


def test_ambiguity_is_shared_by_expectation_and_decided_by_best_trees() -> None:
    grammar = read_grammar("S -> A | B\nA -> a | b\nB -> a | c")
    sentences = [("a",)] * 2 + [("b",)] * 3 + [("c",)]
    soft = estimate(grammar, sentences, rounds=200).grammar
    hard = estimate_from_best_trees(grammar, sentences).grammar
    assert hard.rules[0].probability == pytest.approx(5 / 6)
    assert log_likelihood(soft, sentences) >= log_likelihood(hard, sentences) - 1e-6
    # either way the strings come as often as they were seen
    chance = [np.exp(log_probability(soft, [s])) for s in "abc"]
    assert chance == pytest.approx([1 / 3, 1 / 2, 1 / 6], abs=1e-3)


def test_rules_that_no_tree_uses_share_equally() -> None:
    grammar = read_grammar("S -> a | B\nB -> b [0.9] | c [0.1]")
    found = estimate(grammar, [("a",)]).grammar
    assert [rule.probability for rule in found.rules] == [1.0, 0.0, 0.5, 0.5]
    assert choices_of(parse(found, ["a"])) == (0,)


def test_the_sentence_at_fault_is_named() -> None:
    grammar = read_grammar("S -> a b")
    for learn in (estimate, estimate_from_best_trees):
        with pytest.raises(ParseError, match=r"^sentence 1, symbol 1 \('a'\): expected b"):
            learn(grammar, [("a", "b"), ("a", "a")])
