"""Grammars as records and as text."""

from __future__ import annotations

import pytest
from hypothesis import given
from random_grammars import grammars

from motiondb.grammar.cfg.context_free import (
    Grammar,
    GrammarError,
    Rule,
    check_grammar,
    choices_of,
    derive_by,
    derived_symbols,
    format_grammar,
    read_grammar,
)

TOY = """
S -> r X1 X2 m
X1 -> X3 X4 X3
X2 -> p | s
X3 -> f | empty
X4 -> d | empty
"""


def test_the_toy_grammar_has_eight_rules_as_the_paper_counts_them():
    # S and X1 one each, X2, X3, X4 two each
    grammar = read_grammar(TOY)
    assert len(grammar.rules) == 8
    assert grammar.nonterminals == ("S", "X1", "X2", "X3", "X4")
    assert grammar.terminals == ("d", "f", "m", "p", "r", "s")


def test_text_read_again_is_the_same_grammar():
    grammar = read_grammar(TOY)
    assert read_grammar(format_grammar(grammar)) == grammar


def test_probabilities_given_are_kept_and_the_rest_is_shared():
    grammar = read_grammar("S -> a [0.5] | b | c")
    assert [rule.probability for rule in grammar.rules] == [0.5, 0.25, 0.25]


def test_a_derivation_is_its_rules_in_preorder():
    grammar = read_grammar(TOY)
    tree = derive_by(grammar, [0, 1, 4, 6, 5, 2])
    assert tree.leaves() == ("r", "f", "d", "p", "m")
    assert choices_of(tree) == (0, 1, 4, 6, 5, 2)


def test_a_derivation_a_thousand_deep_is_read_back():
    grammar = read_grammar("S -> a S | a")
    tree = derive_by(grammar, [0] * 5000 + [1])
    assert len(tree.leaves()) == 5001
    assert choices_of(tree)[-1] == 1


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ([0, 1], "expected a rule of 'X3', found the end"),
        ([0, 2], "expected a rule of 'X1', found rule 2"),
        ([0, 1, 4, 6, 5, 2, 2], "expected 6 rules, found 7"),
    ],
)
def test_choices_that_are_no_derivation_are_refused(choices, message):
    with pytest.raises(GrammarError, match=message):
        derive_by(read_grammar(TOY), choices)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected at least one rule"),
        ("S = a b", "grammar:1: expected 'NAME -> symbols'"),
        ("S -> a\nA -> a || b", "grammar:2: expected names after"),
        ("S -> a [x]", r"grammar:1: expected names after|expected a probability"),
        ("S -> a empty", "alone for the empty string"),
        ("S -> a [-1]", "expected a probability of 0 or more"),
    ],
)
def test_text_that_is_no_grammar_is_refused(text, message):
    with pytest.raises(GrammarError, match=message):
        read_grammar(text)


@pytest.mark.parametrize(
    ("grammar", "message"),
    [
        (Grammar("S", ()), "expected a rule for the start symbol 'S', found none"),
        (Grammar("S", (Rule("S", ("a", "S")),)), "S never ends"),
        (read_grammar("S -> a\nB -> b"), "B never is"),
    ],
)
def test_useless_grammars_are_refused(grammar, message):
    with pytest.raises(GrammarError, match=message):
        check_grammar(grammar)


def test_an_empty_grammar_derives_nothing() -> None:
    with pytest.raises(GrammarError, match="expected a rule for the start symbol 'S', found none"):
        derive_by(Grammar("S", (), ("a",)), [0])


@given(grammars())
def test_derived_symbols_equal_those_of_repeated_passes(grammar: Grammar) -> None:
    deriving = {s for s in grammar.terminals if not grammar.is_nonterminal(s)}
    leaves = set(deriving)
    for _ in grammar.rules:
        deriving |= {r.left for r in grammar.rules if deriving.issuperset(r.right)}
    assert derived_symbols(grammar.rules, leaves) == deriving
