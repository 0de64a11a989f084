"""Plans to a goal: by hand, and against everything tried."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_grammars import tree_log_probability

from motiondb.grammar.cfg.context_free import GrammarError, read_grammar
from motiondb.grammar.cfg.parse import ParseError, parse
from motiondb.grammar.derivation.plan import plan

BALL = read_grammar("""
S -> hold A
A -> dribble A [0.7] | pass S [0.1] | shoot [0.2]
""")


def test_by_hand() -> None:
    planned = plan(BALL, ["hold", "dribble"], "pass")
    assert (planned.to_goal, planned.then) == (("pass",), ("hold", "shoot"))
    assert planned.tree == parse(BALL, ["hold", "dribble", "pass", "hold", "shoot"])
    assert planned.log_probability == pytest.approx(tree_log_probability(BALL, planned.tree))
    assert plan(BALL, ["hold"]).then == ("shoot",)
    assert plan(BALL, []).then == ("hold", "shoot")
    # the goal is to be reached once more
    again = plan(BALL, ["hold"], "hold")
    assert (again.to_goal, again.then) == (("pass", "hold"), ("shoot",))


GRAMMARS = [
    BALL,
    read_grammar("S -> S S [0.3] | a S b [0.2] | c [0.4] | empty [0.1]"),
    read_grammar("S -> A B\nA -> A a [0.4] | empty [0.6]\nB -> b [0.5] | c B [0.25] | A [0.25]"),
]


@given(st.sampled_from(GRAMMARS), st.data())
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
