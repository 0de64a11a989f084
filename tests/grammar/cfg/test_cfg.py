"""Grammars as records and as text."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_grammars import TOY, grammars

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
from motiondb.grammar.cfg.loops import format_loops, with_loops
from motiondb.grammar.derivation.derive import derive


def test_text_read_again_is_the_same_grammar():
    assert read_grammar(format_grammar(TOY)) == TOY


def test_probabilities_given_are_kept_and_the_rest_is_shared():
    grammar = read_grammar("S -> a [0.5] | b | c")
    assert [rule.probability for rule in grammar.rules] == [0.5, 0.25, 0.25]


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
        derive_by(TOY, choices)


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


@given(grammars())
def test_derived_symbols_equal_those_of_repeated_passes(grammar: Grammar) -> None:
    deriving = {s for s in grammar.terminals if not grammar.is_nonterminal(s)}
    leaves = set(deriving)
    for _ in grammar.rules:
        deriving |= {r.left for r in grammar.rules if deriving.issuperset(r.right)}
    assert derived_symbols(grammar.rules, leaves) == deriving


@pytest.mark.parametrize(
    ("rules", "shown"),
    [
        ("A -> x A | x", "A -> x+ [0.5]"),
        ("A -> x y A | empty", "A -> (x y)* [0.5]"),
        ("A -> A x | x", "A -> x+ [0.5]"),
        ("A -> x A | y", "A -> (x [0.5])* y"),
        ("A -> A x [0.2] | y A [0.3] | z [0.5]", "A -> (y [0.3])* z (x [0.2])*"),
        ("A -> l A r A | empty", "A -> (l A r)* [0.5]"),
        ("A -> l A r | x", "A -> l A r [0.5] | x [0.5]"),
        ("A -> x | y", "A -> x [0.5] | y [0.5]"),
    ],
)
def test_a_loop_is_shown_as_the_repetition_that_it_is(rules, shown):
    assert format_loops(read_grammar(f"S -> A\n{rules}")).splitlines()[1] == shown


@pytest.mark.parametrize(
    ("rules", "shown"),
    [
        ("S -> a A x y b\nA -> x y A | empty", "S -> a A b\nA -> (x y)+ [0.5]"),
        ("S -> x A b A x | c\nA -> A x | empty", "S -> A b A [0.5] | c [0.5]\nA -> x+ [0.5]"),
        ("S -> a A x A\nA -> x A | empty", "S -> a A x A\nA -> x* [0.5]"),  # one x for two
        ("S -> A B b\nA -> B A | empty\nB -> x", "S -> A b\nA -> B+ [0.5]\nB -> x"),
        ("A -> x A | empty", "A -> x* [0.5]"),
    ],
)  # fmt: skip
def test_a_repetition_beside_its_own_part_is_shown_as_once_or_more(rules, shown):
    grammar = read_grammar(rules)
    assert format_loops(grammar) == shown


CHAIN = read_grammar("S -> go A end\nA -> B A [0.7] | B [0.3]\nB -> x | y B y [0.2]")


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_a_tree_with_loops_has_the_same_leaves_and_no_chain(seed):
    tree = derive(CHAIN, np.random.default_rng(seed))
    drawn = with_loops(tree)
    assert drawn.leaves() == tree.leaves()
    rounds = sum(node.symbol == "A" for node in tree.nodes())
    (joined,) = [node for node in drawn.nodes() if node.symbol.startswith("A")]
    assert joined.symbol == ("A" if rounds == 1 else f"A x{rounds}")
    assert len(joined.children) == rounds
