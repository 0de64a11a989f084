"""Plans through several goals, beside a search of all short strings."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import read_grammar
from motiondb.grammar.cfg.parse import accepts
from motiondb.scene.language.expressions import g_user
from motiondb.scene.services.planning import plan

GRAMMAR = read_grammar(
    """
    S -> M A | A
    M -> run | run M
    A -> hold D pass M A | hold D shoot | empty
    D -> empty | dribble D
    """
)
ACTIONS = ("run", "hold", "pass", "dribble", "shoot")
STRINGS = [s for n in range(1, 6) for s in product(ACTIONS, repeat=n) if accepts(GRAMMAR, s)]


def shortest(prefix: tuple[str, ...], goals: list[set[str]]) -> int | None:
    """The length of the shortest of all short strings that does."""
    lengths = [
        len(string)
        for string in STRINGS
        if string[: len(prefix)] == prefix and g_user(string[len(prefix) :], goals) == 0
    ]
    return min(lengths, default=None)


some = st.sets(st.sampled_from(ACTIONS), min_size=1, max_size=2)


@settings(max_examples=80, deadline=None)
@given(st.lists(st.sampled_from(ACTIONS), max_size=2), st.lists(some, max_size=3))
def test_no_string_is_shorter(prefix: list[str], goals: list[set[str]]) -> None:
    wanted = shortest(tuple(prefix), goals)
    try:
        tree = plan(GRAMMAR, prefix, goals)
    except SceneError:
        assert wanted is None
        return
    string = tree.leaves()
    assert accepts(GRAMMAR, string)
    assert list(string[: len(prefix)]) == prefix
    assert g_user(string[len(prefix) :], goals) == 0
    assert len(string) == wanted or (wanted is None and len(string) > 5)


def test_the_tree_is_one_of_the_grammar() -> None:
    tree = plan(GRAMMAR, ["hold"], [{"pass"}, {"shoot"}])
    assert tree.leaves() == ("hold", "pass", "run", "hold", "shoot")
    for node in tree.nodes():
        if not node.is_leaf:
            rule = GRAMMAR.rules[node.rule]
            assert rule.left == node.symbol
            assert rule.right == tuple(child.symbol for child in node.children)


def test_nobody_does_nothing() -> None:
    assert accepts(GRAMMAR, ())
    assert plan(GRAMMAR).leaves() == ("run",)


def test_unit_cycles_and_empty_rules_end() -> None:
    grammar = read_grammar("S -> A | S\nA -> S | B B | empty\nB -> empty | b")
    assert plan(grammar, (), [{"b"}, {"b"}]).leaves() == ("b", "b")


@pytest.mark.parametrize(
    ("prefix", "goals", "why"),
    [
        (("shoot",), [], "that begins with 'shoot' with nothing more, but no string of the"),
        ((), [{"shoot"}, {"run"}], "with shoot, then run, but run cannot come then"),
        ((), [{"sing"}], "with sing, but sing cannot come at all"),
        (("hold", "shoot"), [{"run"}], "with run, but run cannot come at all"),
    ],
)
def test_what_cannot_be_planned_says_why(prefix, goals, why: str) -> None:
    with pytest.raises(SceneError) as caught:
        plan(GRAMMAR, prefix, goals)
    assert why in str(caught.value)


def test_a_long_beginning_is_no_hindrance() -> None:
    prefix = ["run"] * 150 + ["hold"] + ["dribble"] * 50
    tree = plan(GRAMMAR, prefix, [{"pass"}, {"shoot"}])
    assert tree.leaves() == (*prefix, "pass", "run", "hold", "shoot")
