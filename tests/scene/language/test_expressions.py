"""Expressions of players, g_user, and the rules that follow from a diagram."""

from __future__ import annotations

import math
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from activities import BASKETBALL, read_diagram
from hypothesis import example, given
from hypothesis import strategies as st

from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.scene.energy.rule_kernels import segment_distance, wrapped
from motiondb.scene.language import tactics_file
from motiondb.scene.language.expressions import (
    MOST_ASSIGNMENTS,
    Item,
    assignments,
    auxiliary_rules,
    expressions,
    g_user,
    spans,
)
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.semantic_rules import (
    DirectionRule,
    PositionRule,
    Spot,
    SynchronisationRule,
)

THROWS = """
start S
place goal at 0 5 height 1 m size 3 x 2 m
object ball
S -> throw | catch kick_off
throw := "throw" event release
catch := "catch" event catch
kick_off := "kick"
throw: give(ball)
catch: take(ball)
kick_off: send(ball, goal)
"""

FIGURE_3 = [{"walk", "run"}, {"catch"}, {"dribble"}, {"shoot"}]


def texts(diagram) -> dict[str, str]:
    return {name: "".join(map(str, items)) for name, items in expressions(diagram).items()}


@pytest.mark.parametrize(
    ("string", "missing"),
    [
        ("walk run catch dribble dribble shoot", 0),
        ("walk catch shoot", 1),
        ("shoot dribble catch walk", 3),
        ("idle", 4),
        ("", 4),
        ("run hold pass run catch pivot_left dribble idle shoot", 0),
    ],
)
def test_missing_classes_are_counted(string: str, missing: int) -> None:
    assert g_user(string.split(), FIGURE_3) == missing


actions = st.lists(st.sampled_from("abc"), max_size=6)
classes = st.lists(st.sets(st.sampled_from("abc"), min_size=1, max_size=2), max_size=4)


@given(actions, classes)
def test_no_longer_subsequence_is_common(string: list[str], expression: list[set[str]]) -> None:
    """Beside all subsets of the expression, longest first."""
    n = len(expression)
    for size in range(n, -1, -1):
        for chosen in combinations(range(n), size):
            waiting = [expression[i] for i in chosen]
            for action in string:
                if waiting and action in waiting[0]:
                    waiting.pop(0)
            if not waiting:
                assert g_user(string, expression) == n - size
                return


@given(actions, classes)
def test_spans_are_disjoint_and_match(string: list[str], expression: list[set[str]]) -> None:
    items = [Item(tuple(sorted(c)), repeated=i % 2 == 0) for i, c in enumerate(expression)]
    actual = spans(string, items)
    assert (actual is None) == (g_user(string, expression) > 0)
    ends = 0
    for item, (first, end) in zip(items, actual or ()):
        assert ends <= first < end
        assert item.repeated or end == first + 1
        assert set(string[first:end]) <= set(item.actions)
        ends = end


def test_figure_3_asks_what_the_paper_says() -> None:
    diagram = read_scene_text("figure-3").diagram
    assert texts(diagram) == {
        "A1": "(hold)(pass)",
        "A2": "(run)*(catch)(dribble)*(shoot)",
        "A3": "(walk|run)*(screen)",
        "D1": "(guard)*",
        "D2": "(guard)*(push)",
    }


def test_a_move_is_what_its_player_can_do() -> None:
    diagram = read_diagram(
        "attack A1 at 0 8\nattack A2 at 4 5\n1 move A1 to 1 7\n1 move A2 to 3 4\n2 pivot_left A1\n"
        "2 fake A1\n3 pass A1 to A2\n4 move A2 to 2 2\n4 walk A1 to 0 5\n5 layup A2"
    )
    assert texts(diagram) == {
        "A1": "(hold)(dribble)*(pivot_left)*(fake_shot)*(pass)(walk)*",
        "A2": "(walk|run)*(catch)(dribble)*(layup)",
    }


def test_both_ends_of_a_link_know_one_another() -> None:
    items_of = expressions(read_scene_text("give-and-go").diagram)
    passed, caught = items_of["A1"][1], items_of["A2"][0]
    assert (passed.actions, passed.other, passed.other_item) == (("pass",), "A2", 0)
    assert (caught.actions, caught.other, caught.other_item) == (("catch",), "A1", 1)
    back = items_of["A2"][1]
    assert (back.other, items_of["A1"][back.other_item].actions) == ("A1", ("catch",))
    screen = expressions(read_scene_text("figure-3").diagram)
    assert screen["A3"][1].other_item == 1
    assert screen["D2"][1].other == "A3"


def test_the_rules_of_figure_3() -> None:
    diagram = read_scene_text("figure-3").diagram
    rules = auxiliary_rules(diagram, BASKETBALL)
    starts = {r.player: r.rule.target for r in rules if r.item == -1}
    assert starts == {player.name: player.at for player in diagram.players}
    run = [r.rule for r in rules if (r.player, r.item) == ("A2", 0)]
    assert [(r.target, r.moment.name) for r in run] == [
        (Spot(5.2, 6.6), "start"),
        (Spot(3.6, 6.4), "path"),
        (Spot(1.0, 4.6), "end"),
    ]
    assert 0.2 < run[1].moment.fraction < 0.5
    for player, item, at in (
        ("A1", 1, Spot(-3.2, 7.6)),
        ("A2", 3, Spot(0.5, 2.2)),
        ("A3", 1, Spot(3.75, 5.2)),
    ):
        (place,) = (r for r in rules if (r.player, r.item) == (player, item))
        assert (place.rule.target, place.rule.moment.name) == (at, "start")


def test_what_the_grammar_says_already_is_said_once() -> None:
    text = read_scene_text("give-and-go")
    rest = auxiliary_rules(text.diagram, text.grammar)
    assert {type(r.rule) for r in rest} == {PositionRule}


def test_who_gives_and_sends_faces_where_it_goes_without_a_rule_of_the_grammar() -> None:
    grammar = read_motion_grammar(THROWS, "throws")
    diagram = tactics_file.read_diagram(
        "player A at 0 0\nplayer B at 3 0\n1 throw A to B\n2 kick_off B at goal",
        "x",
        grammar.activity,
    )
    of = {r.player: [] for r in auxiliary_rules(diagram, grammar)}
    for r in auxiliary_rules(diagram, grammar):
        if not isinstance(r.rule, PositionRule):
            of[r.player].append(r)
    direction, synchronisation = of["A"]
    assert isinstance(direction.rule, DirectionRule)
    assert (direction.rule.target, direction.rule.moment.name) == ("B", "release")
    assert isinstance(synchronisation.rule, SynchronisationRule)
    assert synchronisation.rule.actions == ("catch",)
    assert (synchronisation.rule.lag, synchronisation.partner_item) == (None, 0)
    (shot,) = of["B"]
    assert (shot.rule.target, shot.rule.moment.name) == ("goal", "end")


def every_assignment(string: list[str], items: list[Item]) -> set:
    """All assignments by trying all intervals: the slow twin."""
    actual = set()
    n = len(string)
    intervals = [(a, b) for a in range(n) for b in range(a + 1, n + 1)]
    for choice in product(intervals, repeat=len(items)):
        if any(one[1] > other[0] for one, other in pairwise(choice)):
            continue
        taken = {k for a, b in choice for k in range(a, b)}
        for item, (a, b) in zip(items, choice):
            fits = all(action in item.actions for action in string[a:b])
            around = [k for k in (a - 1, b) if 0 <= k < n and k not in taken]
            left_over = item.repeated and any(string[k] in item.actions for k in around)
            if not fits or left_over or (b - a > 1 and not item.repeated):
                break
        else:
            actual.add(choice)
    return actual


WALKS = [Item(("walk",), True), Item(("walk",), True)]


@given(
    st.lists(st.sampled_from(["walk", "bow", "run"]), min_size=1, max_size=6),
    st.lists(
        st.tuples(st.sampled_from([("walk",), ("bow",), ("walk", "run")]), st.booleans()),
        min_size=1,
        max_size=3,
    ),
)
def test_assignments_beside_a_slow_twin(string: list[str], kinds: list) -> None:
    items = [Item(actions, repeated) for actions, repeated in kinds]
    assigned = assignments(string, items)
    first = spans(string, items)
    if first is None:
        assert assigned == ()
        return
    assert assigned[0] == first
    assert len(set(assigned)) == len(assigned)
    assert set(assigned) | {first} == every_assignment(string, items) | {first}


def test_many_assignments_are_thinned_out() -> None:
    string = ["walk"] * 12
    assigned = assignments(string, WALKS * 2)
    assert len(assigned) == MOST_ASSIGNMENTS
    assert assigned[0] == spans(string, WALKS * 2)
    assert set(assigned) <= {
        ((0, a), (a, b), (b, c), (c, 12))
        for a in range(1, 10)
        for b in range(a + 1, 11)
        for c in range(b + 1, 12)
    }


angles = st.floats(-20.0, 20.0)
lengths = st.floats(-10.0, 10.0)


@given(angles, angles)
def test_a_turn_is_what_the_arrows_enclose(one: float, other: float) -> None:
    arrows = [np.array([math.sin(a), math.cos(a)]) for a in (one, other)]
    enclosed = math.acos(np.clip(arrows[0] @ arrows[1], -1.0, 1.0))
    assert wrapped(one - other) == pytest.approx(enclosed, abs=1e-6)


@example([0.0, 0.0, 0.0, 1e-7, 0.0, 0.0])  # a line of a tenth of a micrometre
@example([1.0, 1.0, 2.0, 2.0, 2.0, 2.0])
@given(st.lists(lengths, min_size=6, max_size=6))
def test_a_line_is_as_far_as_its_nearest_point(values: list[float]) -> None:
    place, first, second = np.array(values).reshape(3, 2)
    share = np.linspace(0.0, 1.0, 4001)[:, None]
    nearest = np.linalg.norm(first + share * (second - first) - place, axis=1).min()
    actual = segment_distance(*place, *first, *second)
    assert actual == pytest.approx(nearest, abs=0.01)
    assert actual <= nearest + 1e-9
