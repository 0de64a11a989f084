"""LR(1): textbook grammars, and what freedom from conflicts must mean."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule, read_grammar
from motiondb.grammar.cfg.parse import count_trees
from motiondb.scene.services.lr import (
    first_sets,
    lr1_automaton,
)

EXPRESSIONS = read_grammar(
    """
    E -> T R
    R -> plus T R | empty
    T -> F U
    U -> times F U | empty
    F -> open E close | id
    """
)


def test_first_of_the_textbook() -> None:
    first = first_sets(EXPRESSIONS)
    assert first["E"] == first["T"] == first["F"] == {"open", "id"}
    assert first["R"] == {"plus"}
    assert first["U"] == {"times"}


def test_ten_states_of_the_textbook() -> None:
    automaton = lr1_automaton(read_grammar("S -> C C\nC -> c C | d"))
    assert (automaton.n_states, automaton.conflicts) == (10, ())


def test_a_conflict_names_its_rules_and_the_way_to_it() -> None:
    grammar = read_grammar("S -> if S | if S else S | do")
    (conflict,) = lr1_automaton(grammar).conflicts
    assert conflict.describe(grammar) == (
        "shift-reduce: after 'if if S', before else, between 'S -> if S' and 'S -> if S else S'"
    )


def test_a_conflict_with_the_end_says_so() -> None:
    grammar = read_grammar("S -> T\nT -> S | a")
    (conflict,) = lr1_automaton(grammar).conflicts
    assert conflict.describe(grammar) == (
        "reduce-reduce: after 'S', before the end, between 'T -> S' and accepting the string"
    )


def test_too_many_states_are_refused() -> None:
    with pytest.raises(SceneError) as caught:
        lr1_automaton(EXPRESSIONS, max_states=5)
    assert "at most 5 states to test whether it is LR(1), found more" in str(caught.value)


def test_a_thousand_alternatives_are_tested_once_each() -> None:
    """States: the start, its end, one after each terminal, one at the end of each rule a S."""
    names = [f"a{n}" for n in range(400)]
    wide = read_grammar(f"S -> {' | '.join(f'{name} S' for name in names)} | last")
    automaton = lr1_automaton(wide)
    assert automaton.n_states == 1 + 1 + 401 + 400
    assert automaton.conflicts == ()


def test_too_many_items_are_refused() -> None:
    with pytest.raises(SceneError) as caught:
        lr1_automaton(EXPRESSIONS, max_items=50)
    assert "at most 50 items to test whether it is LR(1), found more" in str(caught.value)


symbols = st.sampled_from(["S", "A", "a", "b"])
rights = st.lists(symbols, max_size=3).map(tuple)
small_grammars = st.tuples(
    st.lists(rights, min_size=1, max_size=3, unique=True),
    st.lists(rights, min_size=1, max_size=3, unique=True),
).map(
    lambda pair: Grammar(
        "S", tuple(Rule(left, r, 1 / len(rows)) for left, rows in zip("SA", pair) for r in rows)
    )
)


@settings(max_examples=60, deadline=None)
@given(small_grammars)
def test_without_conflicts_no_string_has_two_trees(grammar: Grammar) -> None:
    if lr1_automaton(grammar).conflicts:
        return
    for n in range(4):
        for string in product("ab", repeat=n):
            try:
                trees = count_trees(grammar, string)
            except GrammarError:  # it derives nothing
                return
            assert trees <= 1, (str(grammar), string)
