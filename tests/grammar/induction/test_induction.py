"""Rules learned from sentences: the toy language, independence of order, the laws, bad input."""

from __future__ import annotations

from itertools import permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import GrammarError, check_grammar, format_grammar
from motiondb.grammar.induction.induction import induce, induce_with_bits
from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.rule_compaction import Effort
from motiondb.grammar.languages import finite_language
from motiondb.grammar.rules.description_length import description_length, most_economical_tree
from motiondb.grammar.rules.rule_set import (
    RuleSet,
    constant_terminals,
    flat_rules,
)

TOY = [tuple(word) for word in ["rfdpm", "rfdsm", "rdfsm", "rdpm", "rdsm", "rpm"]]
TOY_LANGUAGE = {
    tuple("r" + x + y + z + w + "m")
    for x in ("", "f")
    for y in ("", "d")
    for z in ("", "f")
    for w in "ps"
}
LITTLE = Effort(begun=6, repeated=6, tries=800)
SENTENCES = st.lists(
    st.lists(st.sampled_from("abcd"), min_size=1, max_size=6).map(tuple), min_size=1, max_size=5
)


def language(grammar, longest=10):
    """All strings of a grammar, or those of at most ``longest`` symbols."""
    known = {left: set() for left in grammar.nonterminals}
    while True:
        size = sum(map(len, known.values()))
        for rule in grammar.rules:
            strings = {()}
            for part in rule.right:
                ends = known.get(part, {(part,)})
                strings = {a + b for a in strings for b in ends if len(a + b) <= longest}
            known[rule.left] |= strings
        if sum(map(len, known.values())) == size:
            return known[grammar.start]


def test_the_worked_example_is_learned():
    grammar = induce([tuple("abxcd"), tuple("abycd"), tuple("abxcd")])
    assert format_grammar(grammar) == "S -> a b A c d\nA -> x [0.6667] | y [0.3333]"


def test_the_toy_language_is_learned_within_the_papers_size():
    induced = induce_with_bits(TOY)
    assert len(induced.grammar.nonterminals) <= 5
    assert len(induced.grammar.rules) <= 11
    strings = language(induced.grammar)
    assert set(TOY) <= strings <= TOY_LANGUAGE
    assert len(strings) > len(TOY)
    flat = flat_rules({tuple("dfmprs".index(s) for s in word): 1 for word in TOY}, 6)
    assert induced.bits.total < flat.bits()


def test_the_order_of_sentences_changes_nothing():
    assert len({induce(order, effort=LITTLE) for order in list(permutations(TOY))[::24]}) == 1


@settings(max_examples=25, deadline=None)
@given(SENTENCES)
def test_the_grammar_derives_every_sentence_at_the_bits_that_are_told(sentences):
    induced = induce_with_bits(sentences, effort=LITTLE)
    trees = [most_economical_tree(induced.grammar, sentence) for sentence in sentences]
    assert [tree.leaves() for tree in trees] == sentences
    assert induced.bits == description_length(induced.grammar, sentences)
    check_grammar(induced.grammar)


BASKETBALL = [
    tuple(word.split())
    for word in (
        "walk catch dribble shoot walk",
        "walk catch dribble dribble shoot walk walk",
        "walk walk catch fake dribble shoot walk",
        "catch dribble fake shoot walk",
        "walk catch fake shoot walk walk walk",
        "catch dribble dribble dribble shoot walk",
        "walk walk catch shoot walk",
        "walk catch dribble fake dribble shoot walk",
    )
]


def test_one_shot_in_each_example_means_one_shot_in_each_derived_sentence():
    grammar = induce(BASKETBALL, effort=LITTLE)
    strings = language(grammar)
    assert {string.count("shoot") for string in strings} == {1}
    assert {string.count("catch") for string in strings} == {1}
    assert set(BASKETBALL) <= strings


def test_rules_that_would_shoot_twice_are_unlawful():
    # dribble shoot walk, shoot dribble walk: with X -> shoot | empty on both places
    words = {(0, 1, 2): 1, (1, 0, 2): 1}
    constants = constant_terminals(words)
    assert constants == {0: 1, 1: 1, 2: 1}
    exchanged = {3: {(4, 0, 4, 2): 2}, 4: {(1,): 2, (): 2}}
    assert not is_lawful(RuleSet(3, exchanged, constants))
    assert is_lawful(RuleSet(3, {3: dict(words)}, constants))


@pytest.mark.parametrize(
    ("sentences", "message"),
    [
        ([], "sentences: expected at least one, found none"),
        ([("a",), ()], "sentence 2: expected at least one terminal, found an empty"),
    ],
)
def test_bad_input_is_refused(sentences, message):
    with pytest.raises(GrammarError, match=message):
        induce(sentences)


def test_an_action_of_ten_sentences_that_none_holds_twice_is_never_derived_twice():
    # "s" stands before and after other actions: rules that save bits would let it stand in both
    words = [
        "rsm",
        "rdsm",
        "rfsdm",
        "rdfm",
        "rsfm",
        "rdsdm",
        "rsddm",
        "rdfsm",
        "rffsm",
        "rsffm",
        "rfsm",
        "rsdm",
    ]
    sentences = [tuple(word) for word in words]
    grammar = induce(sentences, effort=LITTLE)
    strings = finite_language(grammar, 10_000)
    assert set(sentences) <= set(strings)
    assert max(string.count("s") for string in strings) == 1
