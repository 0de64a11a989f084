"""Bits of rules and sentences: the paper's worked numbers, economy, and codes that lead back."""

from __future__ import annotations

import math

import pytest

from motiondb.grammar.cfg.context_free import GrammarError, read_grammar
from motiondb.grammar.rules.description_length import (
    description_length,
    most_economical_tree,
    tree_bits,
)

WORKED = [
    ("S -> a b A c d\nA -> x | y", ["abxcd", "abycd", "abxcd"], 41.0391),
    ("S -> a b x c d | a b y c d", ["abxcd", "abycd", "abxcd"], 42.0),
    ("S -> a b x c d a b y c d a b x c d", ["abxcdabycdabxcd"], 48.0),
    ("S -> a b x c | d a b y c d a | b x c d", ["abxc", "dabycda", "bxcd"], 64.7549),
]


@pytest.mark.parametrize(("text", "sentences", "bits"), WORKED)
def test_the_worked_example_of_the_paper(text, sentences, bits):
    grammar = read_grammar(text)
    actual = description_length(grammar, [tuple(sentence) for sentence in sentences])
    assert round(actual.total, 4) == bits


def test_an_ambiguous_grammar_is_charged_for_its_most_economical_tree():
    # x by A costs log2 3 for S and nothing more; by B log2 3 and log2 2
    grammar = read_grammar("S -> B | A | y\nA -> x\nB -> x | z")
    tree = most_economical_tree(grammar, ("x",))
    assert tree.children[0].symbol == "A"
    assert tree_bits(grammar, tree) == pytest.approx(math.log2(3))


def test_learned_probabilities_do_not_change_the_bits():
    grammar = read_grammar("S -> B [0.99] | A [0.005] | y [0.005]\nA -> x\nB -> x | z")
    assert description_length(grammar, [("x",)]).sentences == pytest.approx(math.log2(3))


def test_a_sentence_outside_the_language_has_no_bits():
    with pytest.raises(GrammarError):
        description_length(read_grammar("S -> a"), [("b",)])
