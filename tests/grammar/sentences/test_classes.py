"""Rules over classes of terminals: what is proposed is used where it saves bits."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from motiondb.grammar.baselines.language_measures import match_languages
from motiondb.grammar.cfg.context_free import read_grammar
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce, induce_with_bits
from motiondb.grammar.rules.rule_set import RuleSet, as_grammar
from motiondb.grammar.sentences.classes import (
    by_class,
    class_rules,
    induce_in_classes,
    occurrences,
    spelled_out,
)
from motiondb.grammar.sentences.partition import find_sentences, sentences_between

BOUTS = read_grammar(
    "S -> r R R R i\nR -> D A | A\nA -> P P | P K | K\nD -> g | j | b\n"
    "P -> c | h | k | l\nK -> d | e | f"
)
"""Each punch has four ways and each kick three, as a side and a speed are chosen freely."""
WAYS = (("r",), ("i",), ("b",), ("g", "j"), ("c", "h", "k", "l"), ("d", "e", "f"))
WRONG = (("r", "b"), ("i",), ("g", "j"), ("c", "h", "k", "l"), ("d", "e", "f"))


def bouts(n, seed):
    rng = np.random.default_rng(seed)
    return [derive(BOUTS, rng).leaves() for _ in range(n)]


def test_rules_over_classes_are_spelled_out_with_their_bits():
    # S -> a X b | a X X b with X for c and d: 2 + 5 terminals of the classes a, b, c
    classes = (("a",), ("b",), ("c", "d"))
    sentences = [tuple("acb"), tuple("adb"), tuple("acdb")]
    assert by_class(sentences, classes) == [tuple("acb"), tuple("acb"), tuple("accb")]
    rules = RuleSet(3, {3: {(0, 2, 1): 2, (0, 2, 2, 1): 1}})
    spelled = spelled_out(rules, classes, occurrences(sentences))
    assert spelled.rules == {4: {(0, 5, 1): 2, (0, 5, 5, 1): 1}, 5: {(2,): 2, (3,): 2}}
    # symbols: (3 + 4 + 1 + 1 of right sides, 2 for each of 4 rules, less 1) of 7 kinds; each of
    # three sentences and of four classes chooses between two rules
    assert spelled.bits() == pytest.approx((9 + 8 - 1) * np.log2(7) + 3 + 4)
    grammar = as_grammar(spelled, sorted("abcd"))
    assert {rule.right for rule in grammar.rules if rule.left == "A"} == {("c",), ("d",)}


def test_ways_of_an_action_no_longer_hide_the_rules():
    sentences = bouts(20, 1)
    plain, classed = induce_with_bits(sentences), induce_in_classes(sentences, (WRONG, WAYS))
    rng = np.random.default_rng(0)
    assert classed.bits.total < plain.bits.total
    assert match_languages(classed.grammar, BOUTS, rng).precision == 1.0
    assert match_languages(classed.grammar, BOUTS, rng).recall == 1.0
    assert match_languages(plain.grammar, BOUTS, rng).recall < 0.5


def test_classes_that_cost_bits_are_not_used():
    sentences = [tuple("abab"), tuple("ababab"), tuple("ab"), tuple("abababab")] * 5
    levels = [(("a", "b"), ("c",))]
    assert induce_in_classes(sentences, levels) == induce_with_bits(sentences)
    assert induce_in_classes(sentences).grammar == induce(sentences)


def test_only_names_that_occur_are_in_classes():
    sentences = [tuple("xay"), tuple("xby"), tuple("xaay")]
    rules = class_rules(sentences, [(("a", "b", "z"), ("x",), ("y",))])
    assert rules is not None
    assert rules.n_terminals == 4
    assert Counter(s for rights in rules.rules.values() for r in rights for s in r)[4] == 0
    assert class_rules(sentences, [(("a", "z"), ("b",), ("x", "w"), ("y",))]) is None


STEPS = read_grammar("S -> r X Y i | r Y Y X i\nX -> a | b | c\nY -> d | e | f")
STEP_WAYS = (("r",), ("i",), ("a", "b", "c"), ("d", "e", "f"))


def test_sentences_are_found_in_classes():
    rng = np.random.default_rng(2)
    sentences = [derive(STEPS, rng).leaves() for _ in range(16)]
    joined = tuple(name for sentence in sentences for name in sentence)
    partition = find_sentences(
        [joined], np.random.default_rng(0), evaluations=80, levels=(STEP_WAYS,)
    )
    assert partition.sentences == tuple(sentences)
    assert match_languages(partition.grammar, STEPS, rng).recall == 1.0
    assert match_languages(partition.grammar, STEPS, rng).precision == 1.0


def test_given_sentences_may_be_learned_in_classes():
    rng = np.random.default_rng(3)
    sentences = [derive(STEPS, rng).leaves() for _ in range(16)]
    learned = sentences_between(sentences, [()] * 16, (STEP_WAYS,))
    assert learned.sentences == tuple(sentences)
    assert learned.grammar == induce_in_classes(sentences, (STEP_WAYS,)).grammar
