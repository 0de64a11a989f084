"""Rules learned from sentences: the toy language, independence of order, the laws, bad input."""

from __future__ import annotations

from itertools import permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import GrammarError, check_grammar, format_grammar
from motiondb.grammar.induction.induction import FAMILIES, induce, induce_with_bits, read_rules
from motiondb.grammar.induction.law_checks import is_lawful
from motiondb.grammar.induction.rule_compaction import Effort
from motiondb.grammar.languages import finite_language
from motiondb.grammar.rules.description_length import description_length, most_economical_tree
from motiondb.grammar.rules.hypotheses import SELECTIONS, align, propose, select
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


def naive_links(one, other):
    """Length of the longest common subsequence by trying all."""
    if not one or not other:
        return 0
    skipped = max(naive_links(one[1:], other), naive_links(one, other[1:]))
    return max(skipped, 1 + naive_links(one[1:], other[1:])) if one[0] == other[0] else skipped


@given(st.lists(st.integers(0, 2), max_size=6), st.lists(st.integers(0, 2), max_size=6))
@settings(max_examples=50, deadline=None)
def test_alignment_links_as_much_as_possible_and_does_not_ask_who_is_first(one, other):
    slots = align(tuple(one), tuple(other))
    outside = len(one) - sum(b - a for (a, b), _ in slots)
    assert outside == naive_links(one, other)
    assert align(tuple(other), tuple(one)) == tuple((y, x) for x, y in slots)


def test_a_bias_links_what_stands_at_the_same_place():
    # 0 stands last in the one sentence, first and last in the other
    one, other = (5, 6, 7, 0), (0, 8, 8, 0)
    assert align(one, other) == (((0, 3), (0, 0)), ((4, 4), (1, 4)))
    assert align(one, other, biased=True) == (((0, 3), (0, 3)),)


@pytest.mark.parametrize("selection", SELECTIONS)
def test_what_is_selected_does_not_cross(selection):
    sentences = [(0, 1, 2, 3), (0, 1, 4), (5, 2, 3), (0, 6, 3)]
    slots = [(i, j, align(sentences[i], sentences[j])) for i in range(4) for j in range(i + 1, 4)]
    for places in select(propose(sentences, slots), selection):
        for one in places:
            for other in places:
                assert not one.start < other.start < one.end < other.end


def test_first_leaf_and_branch_believe_different_things():
    # of the crossing spans (0, 2) and (1, 3), the first was proposed first, the second is said
    # twice elsewhere
    sentences = [(7, 8, 9, 1), (2, 3), (8, 9, 4, 4, 4), (8, 9, 5, 5, 5, 5)]
    slots = [(0, 1, (((0, 2), (0, 1)),)), (0, 2, (((1, 3), (0, 2)),)), (2, 3, (((0, 2), (0, 2)),))]
    hypotheses = propose(sentences, slots)
    kept = {way: {(p.start, p.end) for p in select(hypotheses, way)[0]} for way in SELECTIONS}
    assert kept["first"] == {(0, 2)}
    assert kept["leaf"] == {(1, 3)}
    assert kept["branch"] == {(1, 3)}


def test_the_worked_example_is_learned():
    grammar = induce([tuple("abxcd"), tuple("abycd"), tuple("abxcd")])
    assert format_grammar(grammar) == "S -> a b A c d\nA -> x [0.6667] | y [0.3333]"


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("selection", SELECTIONS)
def test_alignment_alone_covers_its_examples_in_any_family_and_selection(family, selection):
    grammar = induce(TOY, family=family, selection=selection, compacted=False)
    check_grammar(grammar)
    assert set(TOY) <= language(grammar)


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
    grammars = {
        induce(order, family="edit", selection="first", compacted=False)
        for order in list(permutations(TOY))[::7]
    }
    assert len(grammars) == 1
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


@pytest.mark.parametrize("compacted", [True, False])
@pytest.mark.parametrize("family", ["auto", "suffix"])
def test_one_shot_in_each_example_means_one_shot_in_each_derived_sentence(compacted, family):
    grammar = induce(BASKETBALL, family=family, compacted=compacted, effort=LITTLE)
    strings = language(grammar)
    assert {string.count("shoot") for string in strings} == {1}
    assert {string.count("catch") for string in strings} == {1}
    assert set(BASKETBALL) <= strings


def test_alignment_without_laws_would_shoot_twice():
    # dribble shoot walk, shoot dribble walk: shoot and nothing are exchanged in both places, so
    # alignment alone has S -> X dribble X walk with X -> shoot | empty
    words = [(0, 1, 2), (1, 0, 2)]
    hypotheses = propose(words, [(0, 1, align(*words))])
    kept = select(hypotheses, "first")
    free = read_rules(hypotheses, kept, [1, 1], 3, lawful=False)
    bound = read_rules(hypotheses, kept, [1, 1], 3)
    constants = constant_terminals(dict.fromkeys(words, 1))
    assert constants == {0: 1, 1: 1, 2: 1}
    assert not is_lawful(RuleSet(3, free.rules, constants))
    assert is_lawful(RuleSet(3, bound.rules, constants))


@pytest.mark.parametrize(
    ("sentences", "options", "message"),
    [
        ([], {}, "sentences: expected at least one, found none"),
        ([("a",), ()], {}, "sentence 2: expected at least one terminal, found an empty"),
        ([("a",)], {"family": "edid"}, "family: expected .* found 'edid'. Did you mean edit?"),
        ([("a",)], {"selection": "tree"}, "selection: expected first, leaf, branch or auto"),
    ],
)
def test_bad_input_is_refused(sentences, options, message):
    with pytest.raises(GrammarError, match=message):
        induce(sentences, **options)


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
