"""Loops as text and in trees: the same strings, fewer levels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import read_grammar
from motiondb.grammar.cfg.loops import format_loops, with_loops
from motiondb.grammar.derivation.derive import derive


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
