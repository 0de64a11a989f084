"""Bits of rules and sentences: the paper's worked numbers, economy, and codes that lead back."""

from __future__ import annotations

import math

import pytest

from motiondb.grammar.cfg.context_free import GrammarError, choices_of, derive_by, read_grammar
from motiondb.grammar.rules.description_length import (
    description_length,
    grammar_bits,
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


def test_the_rules_are_one_sequence_with_separators():
    # S a b A c d @ A x @ A y: 12 symbols of 2 + 6 + 1 kinds
    grammar = read_grammar("S -> a b A c d\nA -> x | y")
    assert grammar_bits(grammar) == pytest.approx(12 * math.log2(9))


def test_an_ambiguous_grammar_is_charged_for_its_most_economical_tree():
    # x by A costs log2 3 for S and nothing more; by B log2 3 and log2 2
    grammar = read_grammar("S -> B | A | y\nA -> x\nB -> x | z")
    tree = most_economical_tree(grammar, ("x",))
    assert tree.children[0].symbol == "A"
    assert tree_bits(grammar, tree) == pytest.approx(math.log2(3))


def test_learned_probabilities_do_not_change_the_bits():
    grammar = read_grammar("S -> B [0.99] | A [0.005] | y [0.005]\nA -> x\nB -> x | z")
    assert description_length(grammar, [("x",)]).sentences == pytest.approx(math.log2(3))


def encode(grammar, tree):
    """Code of a sentence: for each node in preorder, which rule of its nonterminal, from 0."""
    places = [grammar.rules_of[grammar.rules[n].left].index(n) for n in choices_of(tree)]
    return tuple(places)


def decode(grammar, code):
    """The sentence that a code stands for."""
    choices, waiting = [], [grammar.start]
    for place in code:
        while not grammar.is_nonterminal(waiting[-1]):
            waiting.pop()
        number = grammar.rules_of[waiting.pop()][place]
        choices.append(number)
        waiting.extend(reversed(grammar.rules[number].right))
    return derive_by(grammar, choices).leaves()


@pytest.mark.parametrize(("text", "sentences", "bits"), WORKED)
def test_codes_give_back_the_sentences(text, sentences, bits):
    grammar = read_grammar(text)
    said = [tuple(sentence) for sentence in sentences]
    codes = [encode(grammar, most_economical_tree(grammar, sentence)) for sentence in said]
    assert [decode(grammar, code) for code in codes] == said


def test_the_code_numbers_alternatives_from_0():
    grammar = read_grammar("S -> a b A c d\nA -> x | y")
    assert encode(grammar, derive_by(grammar, (0, 2))) == (0, 1)


def test_a_sentence_outside_the_language_has_no_bits():
    with pytest.raises(GrammarError):
        description_length(read_grammar("S -> a"), [("b",)])
