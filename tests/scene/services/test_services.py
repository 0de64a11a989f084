"""Checking, validating, suggesting and casting, on the shipped grammar and by brute force."""

from __future__ import annotations

from itertools import product

import pytest
from activities import read_diagram
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.database.scenes import scene_texts
from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import read_grammar
from motiondb.grammar.cfg.parse import accepts
from motiondb.scene.language.expressions import g_user
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.services import casting, services
from motiondb.scene.services.services import shortest_tree

SMALL = """
grammar small
start S for attack
start D for defence
S -> a S | b [0.5]
D -> a | empty
a := "a"
b := "b"
"""


@pytest.fixture(scope="module")
def basketball():
    return scene_texts.read_grammar("basketball")


def test_basketball_has_one_tree_for_each_string(basketball) -> None:
    report = services.check(basketball)
    assert (len(report.nonterminals), len(report.terminals)) == (19, 17)
    assert report.useless == ()
    for start in report.starts:
        assert (start.n_strings, start.ambiguous) == (50, ())
    attack, defence = report.starts
    assert attack.empty
    assert not defence.empty
    assert set(report.nullable) == {"S_A", "Attacks", "Runs", "Pivot", "Fake", "Dribble"}


def test_useless_symbols_and_ambiguous_strings_are_reported() -> None:
    text = 'start S\nS -> S S | a\nT -> b\na := "a"\nb := "b"'
    report = services.check(read_motion_grammar(text, "x.grammar"))
    assert report.useless == ("T", "b")
    (start,) = report.starts
    assert (start.ambiguous, start.n_trees) == (("a", "a", "a"), 2)


def test_a_cycle_gives_endlessly_many_trees() -> None:
    (start,) = services.check(read_motion_grammar('start S\nS -> S | a\na := "a"', "x")).starts
    assert (start.ambiguous, start.n_trees) == (("a",), float("inf"))


def test_a_sentence_has_a_tree(basketball) -> None:
    validation = services.validate(basketball, ["hold", "dribble", "shoot"])
    assert validation.allowed
    assert validation.start == "S_A"
    assert validation.tree is not None
    assert validation.tree.leaves() == ("hold", "dribble", "shoot")
    assert services.validate(basketball, ["guard", "run"]).start == "S_D"


def test_no_dribble_after_a_pivot_that_ended_one(basketball) -> None:
    validation = services.validate(basketball, ["hold", "dribble", "pivot_left", "dribble"])
    assert not validation.allowed
    assert validation.position == 3
    assert set(validation.expected) == {"pivot_left", "pass", "shoot", "layup", "fake_shot"}
    assert validation.message == (
        "action 4 after 'hold dribble pivot_left', from S_A: expected one of pivot_left, pass,"
        " shoot, layup, fake_shot, found 'dribble'. Put one of them there, or add a rule for it."
    )


def test_nobody_on_court_does_nothing(basketball) -> None:
    validation = services.validate(basketball, [], "S_A")
    assert (validation.allowed, validation.position) == (False, 0)
    assert validation.message == (
        "action 1, from S_A: expected one of run, walk, idle, screen, hold, catch, feint, found"
        " the end. Every player needs at least one action."
    )
    together = services.validate(basketball, [])
    assert together.start == "S_A or S_D"
    assert {"hold", "guard"} <= set(together.expected)


def test_the_end_is_named_where_more_must_follow(basketball) -> None:
    validation = services.validate(basketball, ["hold"])
    assert validation.position == 1
    assert "found the end. Go on with one of them." in validation.message
    assert "Did you mean walk?" in services.validate(basketball, ["wlak"]).message


def test_suggestions_are_all_that_may_follow(basketball) -> None:
    """Beside brute force: an action may follow exactly where some string goes on with it."""
    names = [terminal.name for terminal in basketball.terminals]
    for prefix in (["hold", "dribble"], ["run"], ["hold", "pass", "run", "feint"], ["push"]):
        suggestions = services.suggest(basketball, prefix)
        may = set()
        for name in names:
            fault = services.validate(basketball, [*prefix, name])
            if fault.allowed or fault.position > len(prefix):
                may.add(name)
        assert {name for name, _ in suggestions.actions} == may
        assert (suggestions.end > 0) == services.validate(basketball, prefix).allowed
        assert sum(p for _, p in suggestions.actions) + suggestions.end == pytest.approx(1.0)


def test_start_symbols_count_by_how_probable_the_string_is() -> None:
    grammar = read_motion_grammar(SMALL, "x.grammar")
    # P(a ...) is 0.5 from S and from D; behind it, S goes on with a or b alike, D ends
    suggestions = services.suggest(grammar, ["a"])
    assert dict(suggestions.actions) == pytest.approx({"a": 0.25, "b": 0.25})
    assert suggestions.end == pytest.approx(0.5)
    # nobody begins by ending: from D only a can come, so a has 0.5 + 0.5 and b 0.5
    assert dict(services.suggest(grammar, []).actions) == pytest.approx({"a": 2 / 3, "b": 1 / 3})
    assert services.suggest(grammar, ["a"], "S").end == 0.0


def test_suggestions_for_what_cannot_begin(basketball) -> None:
    with pytest.raises(SceneError) as caught:
        services.suggest(basketball, ["shoot"])
    assert str(caught.value).startswith(
        "basketball: action 1, from S_A or S_D: expected one of run, walk"
    )


def test_improbable_strings_have_suggestions_too(basketball) -> None:
    """The probability of this string, below 1e-324, is no number of its own."""
    string = ["hold", *["dribble"] * 150, "pass", *["run"] * 240]
    suggestions = services.suggest(basketball, string)
    assert "run" in dict(suggestions.actions)
    assert sum(chance for _, chance in suggestions.actions) + suggestions.end == pytest.approx(1.0)


def test_strings_that_would_take_minutes_are_refused(basketball) -> None:
    wanted = "basketball: expected at most 400 actions, found 5000. Ask for a shorter string."
    for ask in (services.validate, services.suggest, services.plan):
        with pytest.raises(SceneError, match=wanted):
            ask(basketball, ["run"] * 5000)


def test_every_plan_begins_as_asked_and_is_allowed(basketball) -> None:
    for goals in product(["pass", "dribble", "shoot"], repeat=2):
        wanted = [{goal} for goal in goals]
        try:
            tree = services.plan(basketball, ["hold"], wanted)
        except SceneError:
            assert goals[0] == "shoot"  # nothing comes behind a shot
            continue
        assert tree.leaves()[0] == "hold"
        assert g_user(tree.leaves()[1:], wanted) == 0
        assert services.validate(basketball, tree.leaves(), "S_A").allowed
    with pytest.raises(SceneError) as caught:
        services.plan(basketball, [], [{"sing"}])
    assert "expected an action, found 'sing'" in str(caught.value)


def test_what_the_grammar_does_not_allow_is_named(basketball) -> None:
    diagram = read_diagram("attack A1 at 0 5\ndefence D1 at 0 4\n1 guard A1 on D1", "x.tactics")
    with pytest.raises(SceneError) as caught:
        casting.cast(diagram, basketball)
    assert str(caught.value).startswith(
        "x.tactics:3: expected of A1 what the grammar basketball allows, found (guard)*."
    )


def test_rules_about_who_is_not_there_are_refused(basketball) -> None:
    diagram = read_diagram(
        "attack A1 at 0 5\nattack A2 at 3 5\n1 feint A2\n2 pass A1 to A2\n3 shoot A2", "x.tactics"
    )
    with pytest.raises(SceneError) as caught:
        casting.cast(diagram, basketball)
    assert str(caught.value) == (
        "x.tactics:3: 'feint A2': expected an opponent of A2, whom the rule distance of feint is"
        " about, found none. Add a player of the other team, or take the element out."
    )
    with pytest.raises(SceneError) as caught:
        casting.cast(diagram, scene_texts.read_grammar("carrying"))
    assert "expected the place 'origin', which rules of the grammar carrying are" in str(
        caught.value
    )


def test_what_nobody_can_do_is_told_with_file_and_line(basketball) -> None:
    def told(text: str) -> str:
        diagram = read_diagram(f'diagram "Title"\nattack A1 at 0 5\n{text}', "x.tactics")
        with pytest.raises(SceneError) as caught:
            casting.cast(diagram, basketball, "x.tactics")
        return str(caught.value)

    assert told(
        "defence D1 at 3 3\n1 screen A1 on D1\n2 guard D1 on A1\n3 block A1 on D1"
    ).startswith(
        "x.tactics:6: expected of A1 what the grammar basketball allows, found"
        " (walk|run)*(screen)(block)."
    )
    assert told("defence D1 at 3 3\n1 pass A1 to D1").startswith(
        "x.tactics:4: expected of D1 what the grammar basketball allows, found (catch),"
        " of which (catch) is for 'pass A1 to D1'. grammar:"
    )
    assert told("player C1 at 3 3\n1 shoot A1").startswith(
        "x.tactics:3: 'player C1': expected a start symbol for the role 'player'"
    )
    runs = "\n".join(f"{step} run A1 to {step % 5} 3" for step in range(1, 42))
    assert told(runs) == (
        "x.tactics:2: 'A1': expected at most 40 things to do, found 41. Make a scene of each part"
        " of the play."
    )


PLAYS = read_grammar(
    """
    S -> M A | A
    M -> run | run M
    A -> hold D pass M A | hold D shoot | empty
    D -> empty | dribble D
    """
)
ACTIONS = ("run", "hold", "pass", "dribble", "shoot")
STRINGS = [s for n in range(1, 6) for s in product(ACTIONS, repeat=n) if accepts(PLAYS, s)]


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
        tree = shortest_tree(PLAYS, prefix, goals)
    except SceneError:
        assert wanted is None
        return
    string = tree.leaves()
    assert accepts(PLAYS, string)
    assert list(string[: len(prefix)]) == prefix
    assert g_user(string[len(prefix) :], goals) == 0
    assert len(string) == wanted or (wanted is None and len(string) > 5)


def test_the_tree_is_one_of_the_grammar() -> None:
    tree = shortest_tree(PLAYS, ["hold"], [{"pass"}, {"shoot"}])
    assert tree.leaves() == ("hold", "pass", "run", "hold", "shoot")
    for node in tree.nodes():
        if not node.is_leaf:
            rule = PLAYS.rules[node.rule]
            assert rule.left == node.symbol
            assert rule.right == tuple(child.symbol for child in node.children)


def test_unit_cycles_and_empty_rules_end() -> None:
    grammar = read_grammar("S -> A | S\nA -> S | B B | empty\nB -> empty | b")
    assert shortest_tree(grammar, (), [{"b"}, {"b"}]).leaves() == ("b", "b")


@pytest.mark.parametrize(
    ("prefix", "goals", "why"),
    [
        (("shoot",), [], "that begins with 'shoot' with nothing more, found that no string of the"),
        ((), [{"shoot"}, {"run"}], "with shoot, then run, found that run cannot come then"),
        ((), [{"sing"}], "with sing, found that sing cannot come at all"),
        (("hold", "shoot"), [{"run"}], "with run, found that run cannot come at all"),
    ],
)
def test_what_cannot_be_planned_says_why(prefix, goals, why: str) -> None:
    with pytest.raises(SceneError) as caught:
        shortest_tree(PLAYS, prefix, goals)
    assert why in str(caught.value)


def test_a_long_beginning_is_no_hindrance() -> None:
    prefix = ["run"] * 150 + ["hold"] + ["dribble"] * 50
    tree = shortest_tree(PLAYS, prefix, [{"pass"}, {"shoot"}])
    assert tree.leaves() == (*prefix, "pass", "run", "hold", "shoot")
