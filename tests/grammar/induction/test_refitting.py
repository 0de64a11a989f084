"""Sentences read again by other rules, and rules taken apart, against slow obvious twins."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_rules import STRING, A, B, S, T, acyclic_rules, strings_of

from grammar_tasks.language_match import match_languages
from motiondb.grammar.cfg.context_free import read_grammar
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce_with_bits
from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.perturbation import forget, perturb, split
from motiondb.grammar.induction.refitting import refit
from motiondb.grammar.induction.rule_compaction import Effort, compact
from motiondb.grammar.rules.description_length import description_length
from motiondb.grammar.rules.rule_set import RuleSet, flat_rules

STRINGS = st.dictionaries(STRING, st.integers(1, 3), min_size=1, max_size=5)


def generator(seed=7):
    return np.random.default_rng(seed)


def naive_bits(rules):
    """Bits of the cheapest derivation of a string from symbols, by trying all."""

    @cache
    def bits(symbols, string):
        if not symbols:
            return 0.0 if not string else math.inf
        first, rest = symbols[0], symbols[1:]
        if first < T:
            return bits(rest, string[1:]) if string[:1] == (first,) else math.inf
        node = math.log2(len(rules[first]))
        return min(
            node + min(bits(right, string[:k]) for right in rules[first]) + bits(rest, string[k:])
            for k in range(len(string) + 1)
        )

    return bits


def check_nodes(rules, total):
    """Nodes of each nonterminal are as many as its uses."""
    for left, rights in rules.items():
        used = sum(
            count * right.count(left)
            for others in rules.values()
            for right, count in others.items()
        )
        assert sum(rights.values()) == (total if left == S else used)


@settings(max_examples=30, deadline=None)
@given(acyclic_rules(least=0, most=3), STRING, st.integers(1, 3))
def test_a_sentence_is_read_by_its_cheapest_parse(donor, sentence, count):
    refitted = refit(donor, flat_rules({sentence: count}, T))
    if refitted is None:
        assert not is_lawful(donor)
        return
    bits = naive_bits(donor.rules)
    cheapest = bits((S,), sentence)
    if cheapest < math.inf:
        used = sum(
            number * math.log2(len(donor.rules[left]))
            for left, rights in refitted.rules.items()
            for number in rights.values()
        )
        assert used == pytest.approx(count * cheapest)
        assert all(right in donor.rules[left] for left, right in refitted.uses())
    else:  # a new rule: as cheap as any row of terminals and nonterminals that derives it
        (right,) = refitted.rules[S]
        symbol = math.log2(len(donor.rules) + T + 1)
        least = [0.0] + [math.inf] * len(sentence)
        for j in range(1, len(sentence) + 1):
            for i in range(j):
                span = sentence[i:j]
                one = min([bits((A,), span), bits((B,), span), 0.0 if i == j - 1 else math.inf])
                least[j] = min(least[j], least[i] + symbol + one)
        if is_lawful(refitted) and any(s >= T for s in right):
            assert len(right) * symbol + bits(right, sentence) == pytest.approx(least[-1])
        assert bits(right, sentence) < math.inf


@settings(max_examples=30, deadline=None)
@given(acyclic_rules(least=0, most=3), STRINGS)
def test_all_sentences_are_derived_and_every_node_counted(donor, sentences):
    flat = flat_rules(sentences, T)
    refitted = refit(donor, flat)
    if refitted is None:  # the donor itself was unlawful, in rules that all sentences need
        assert not is_lawful(flat.with_rules(donor.rules))
        return
    assert is_lawful(refitted)
    assert set(sentences) <= strings_of(refitted.rules)
    check_nodes(refitted.rules, sum(sentences.values()))


def test_what_needs_a_forgotten_rule_is_forgotten_too():
    rules = RuleSet(T, {S: {(A, 0): 1}, A: {(B, 1): 1}, B: {(2,): 1}})
    for seed in range(20):
        for number in (1, 2, 3):
            left_over = forget(rules, number, generator(seed)).rules
            known = set(range(T)) | set(left_over)
            assert all(known.issuperset(right) for rights in left_over.values() for right in rights)
            # every rule needs the next: without any one of them no sentence is left
            assert left_over[S] == {}


@settings(max_examples=40, deadline=None)
@given(acyclic_rules(least=0, most=3), st.booleans(), st.integers(0, 1000))
def test_copies_derive_the_same_strings(donor, once, seed):
    copied = split(donor, once, generator(seed))
    references = donor.references()
    if copied is None:
        assert references[A] < 2
        assert references[B] < 2
        return
    assert strings_of(copied.rules) == strings_of(donor.rules)
    assert len(copied.rules) > len(donor.rules)


@settings(max_examples=20, deadline=None)
@given(STRINGS, st.integers(0, 1000))
def test_rules_taken_apart_derive_all_sentences(sentences, seed):
    flat = flat_rules(sentences, T)
    rules = compact(flat, effort=Effort(begun=3, repeated=2, tries=500))
    perturbed = perturb(rules, flat, 300, generator(seed))
    if perturbed is not None:
        assert is_lawful(perturbed)
        assert set(sentences) <= strings_of(perturbed.rules)
        check_nodes(perturbed.rules, sum(sentences.values()))


@settings(max_examples=10, deadline=None)
@given(st.dictionaries(STRING, st.integers(1, 3), min_size=4, max_size=9))
def test_rules_of_samples_become_rules_of_all_sentences(sentences):
    flat = flat_rules(sentences, T)
    compacted = compact(flat, effort=Effort(2, 4, 500, samples=2, sampled=3))
    assert compacted.bits() <= flat.bits()
    assert is_lawful(compacted)
    assert set(sentences) <= strings_of(compacted.rules)
    check_nodes(compacted.rules, sum(sentences.values()))


BOUTS = """
S -> ready Bout Bout rest
Bout -> Guard Blow | Blow
Guard -> parry | duck
Blow -> hook | jab hook | jab jab
"""


def test_more_sentences_do_not_make_worse_rules():
    truth = read_grammar(BOUTS)
    rng = np.random.default_rng(3)
    sentences = [derive(truth, rng).leaves() for _ in range(36)]
    induced = induce_with_bits(sentences)
    match = match_languages(induced.grammar, truth, np.random.default_rng(0))
    assert induced.bits.total <= description_length(truth, sentences).total + 1e-6
    assert match.precision == match.recall == 1.0
