"""Editing by regions: what changes, what stays, and that the language is never left."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_grammars import TOY, tree_log_probability

from motiondb.grammar.cfg.context_free import GrammarError, Tree, read_grammar
from motiondb.grammar.cfg.parse import ParseError, accepts, parse
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.derivation.edit import (
    Region,
    alternatives,
    narrower,
    region_at,
    replace_region,
    wider,
)
from motiondb.grammar.derivation.plan import plan


def test_the_generating_nonterminal_and_its_ancestors() -> None:
    tree = parse(TOY, tuple("rfdsm"))
    region = region_at(tree, 2)
    assert region == Region((1, 1), "X4", 2, 3, 2)
    assert wider(tree, region) == Region((1,), "X1", 1, 3, 2)
    assert wider(tree, region, 2) == Region((), "S", 0, 5, 2)
    assert narrower(tree, wider(tree, region, 2), 2) == region
    assert region_at(tree, 0).symbol == "S"


def test_all_other_strings_of_a_small_region_are_offered() -> None:
    tree = parse(TOY, tuple("rfdsm"))
    region = wider(tree, region_at(tree, 2))
    alternatives_offered = alternatives(TOY, tree, region, 20, np.random.default_rng(0))
    # X1 derives empty, f, d, fd, df, ff, fdf: all but fd, which is there already
    assert {"".join(a.string) for a in alternatives_offered} == {"", "f", "d", "df", "ff", "fdf"}
    assert alternatives_offered[0].string == ("f",)  # the only one of two trees
    assert [a.log_probability for a in alternatives_offered] == sorted(
        (a.log_probability for a in alternatives_offered), reverse=True
    )
    new = replace_region(tree, region, alternatives_offered[0].tree)
    assert new.leaves() == tuple("rfsm")
    assert new == parse(TOY, tuple("rfsm")) or accepts(TOY, new.leaves())


GRAMMARS = [
    TOY,
    read_grammar("S -> S S [0.3] | a S b [0.2] | c [0.4] | empty [0.1]"),
    read_grammar("S -> A S [0.4] | A [0.6]\nA -> B\nB -> a | b b | A [0.1]"),
]


@given(st.sampled_from(GRAMMARS), st.integers(0, 2**32 - 1), st.data())
@settings(max_examples=30, deadline=None)
def test_outside_stays_and_the_language_is_kept(
    grammar: object, seed: int, data: st.DataObject
) -> None:
    rng = np.random.default_rng(seed)
    tree = derive(grammar, rng, length=5)
    string = tree.leaves()
    region = region_at(tree, data.draw(st.integers(0, len(string) - 1)))
    assert region.start <= region.position < region.end
    region = wider(tree, region, data.draw(st.integers(0, len(region.path))))
    offered = alternatives(grammar, tree, region, 4, rng, most=10.0)
    assert len({a.string for a in offered}) == len(offered) <= 4
    for choice in offered:
        new = replace_region(tree, region, choice.tree)
        expected = string[: region.start] + choice.string + string[region.end :]
        assert new.leaves() == expected != string
        assert accepts(grammar, expected)
        for node in new.nodes():
            if not node.is_leaf:
                rule = grammar.rules[node.rule]
                assert (rule.left, rule.right) == (
                    node.symbol,
                    tuple(child.symbol for child in node.children),
                )


def test_wrong_places_are_refused() -> None:
    tree = parse(TOY, tuple("rpm"))
    with pytest.raises(GrammarError, match="position 7: expected 0 to 2, the symbols of the"):
        region_at(tree, 7)
    with pytest.raises(GrammarError, match="position -1: expected 0 to 2"):
        region_at(tree, -1)
    with pytest.raises(GrammarError, match="expected a symbol to pick, found an empty sentence"):
        region_at(parse(read_grammar("S -> empty"), ()), 0)
    region = region_at(tree, 1)
    with pytest.raises(GrammarError, match="expected 0 to 1 levels up from 'X2'"):
        wider(tree, region, 2)
    with pytest.raises(GrammarError, match="expected 0 to 0 levels down from 'X2'"):
        narrower(tree, region)
    with pytest.raises(GrammarError, match="expected a derivation of 'X2', found one of 'X3'"):
        replace_region(tree, region, Tree("X3", 5, (Tree("f"),)))
    with pytest.raises(GrammarError, match="alternatives: expected at least 1, found 0"):
        alternatives(TOY, tree, region, 0, np.random.default_rng(0))
    other = read_grammar("T -> r p m")
    with pytest.raises(GrammarError, match="expected a nonterminal of the grammar, found 'X2'"):
        alternatives(other, tree, region, 2, np.random.default_rng(0))


BALL = read_grammar("""
S -> hold A
A -> dribble A [0.7] | pass S [0.1] | shoot [0.2]
""")


PLANNED = [
    BALL,
    read_grammar("S -> S S [0.3] | a S b [0.2] | c [0.4] | empty [0.1]"),
    read_grammar("S -> A B\nA -> A a [0.4] | empty [0.6]\nB -> b [0.5] | c B [0.25] | A [0.25]"),
]


@given(st.sampled_from(PLANNED), st.data())
@settings(max_examples=40, deadline=None)
def test_no_completion_is_better(grammar: object, data: st.DataObject) -> None:
    names = grammar.terminals
    prefix = data.draw(st.lists(st.sampled_from(names), max_size=2).map(tuple))
    goal = data.draw(st.sampled_from([None, *names]))
    shortest = data.draw(st.booleans())
    costs = []
    for tail in (t for n in range(5) for t in product(names, repeat=n)):
        try:
            tree = parse(grammar, prefix + tail)
        except ParseError:
            continue
        if goal is None or goal in tail:
            chance = -tree_log_probability(grammar, tree)
            costs.append((len(tail), chance) if shortest else (chance, len(tail)))
    try:
        planned = plan(grammar, prefix, goal, shortest=shortest)
    except GrammarError:
        assert not costs
        return
    rest = planned.to_goal + planned.then
    assert planned.tree.leaves() == prefix + rest
    assert planned.log_probability == pytest.approx(tree_log_probability(grammar, planned.tree))
    if goal is not None:
        assert planned.to_goal[-1] == goal
        assert goal not in planned.to_goal[:-1]
    else:
        assert planned.to_goal == ()
    cost = (len(rest), -planned.log_probability)
    if costs:
        best = min(costs)
        assert (cost if shortest else cost[::-1]) <= (best[0] + 1e-6, best[1] + 1e-6)


def test_what_cannot_be_planned() -> None:
    once = read_grammar("S -> a b\n")
    with pytest.raises(GrammarError, match="expected that 'a' can come after 'a', found no"):
        plan(once, ["a"], "a")
    with pytest.raises(GrammarError, match=r"found 'shot'\. Did you mean shoot\?"):
        plan(BALL, [], "shot")
    with pytest.raises(ParseError, match=r"symbol 1 \('hold'\)"):
        plan(BALL, ["hold", "hold"], "shoot")
