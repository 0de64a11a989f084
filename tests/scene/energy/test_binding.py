"""Which rules a scene's trees come under, with everybody they are about."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motiondb.database.scenes import scene_texts
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.errors import SceneError
from motiondb.grammar.cfg.parse import parse
from motiondb.scene.energy.binding import (
    AT_END,
    AT_EVENT,
    AT_START,
    DIRECTION,
    DISTANCE,
    KINDS,
    LINE,
    ON_THE_WAY,
    ORDER,
    POINT,
    POSITION,
    SYNCHRONISATION,
    THROUGHOUT,
    UNMET,
    bind,
)
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.services import casting

DIAGRAMS = scene_texts.shipped(".tactics")


def table_of(name: str, **strings: str):
    """The table of a shipped diagram, some players' strings given."""
    text = read_scene_text(name)
    diagram, grammar = text.diagram, text.grammar
    trees = casting.cast(diagram, grammar)
    for player, string in strings.items():
        start = grammar.start_of(diagram.player[player].team)
        trees[player] = parse(grammar.started(start), string.split())
    return bind(diagram, grammar, trees)


def rows(table, player: str, kind: int) -> list[dict]:
    """A player's rows of a kind."""
    number = table.players.index(player)
    names = table.rows.dtype.names
    actual = table.rows[(table.rows["player"] == number) & (table.rows["kind"] == kind)]
    return [dict(zip(names, row.tolist(), strict=True)) for row in actual]


def test_a_pass_and_its_catch() -> None:
    table = table_of("give-and-go")
    numbers = {name: number for number, name in enumerate(table.players)}
    (facing,) = [r for r in rows(table, "A1", DIRECTION) if r["target"] >= 0]
    assert (facing["target"], facing["moment"]) == (numbers["A2"], AT_EVENT)
    assert table.actions[0][facing["first"]] == "pass"
    (flight,) = rows(table, "A1", SYNCHRONISATION)
    assert flight["partner"] == numbers["A2"]
    assert math.isnan(flight["lag"])
    partner = table.partners[flight["partner_first"] : flight["partner_last"]].tolist()
    assert [table.actions[numbers["A2"]][k] for k in partner] == ["catch"]
    (back,) = rows(table, "A2", SYNCHRONISATION)
    caught = table.partners[back["partner_first"] : back["partner_last"]].tolist()
    assert [table.actions[0][k] for k in caught] == ["catch"]


def test_a_screen_and_its_push_may_touch() -> None:
    table = table_of("figure-3", A3="run run screen", D2="guard push run")
    a3, d2 = table.players.index("A3"), table.players.index("D2")
    assert table.contacts.tolist() == [[a3, 2, d2, 1]]
    (row,) = rows(table, "A3", SYNCHRONISATION)
    assert (row["partner"], row["lag"]) == (d2, 0.0)
    (facing,) = rows(table, "A3", DIRECTION)
    assert facing["target"] == d2


def test_moves_end_once_and_pass_their_points() -> None:
    """Three runs are one move: its circle is for the last, a defender's line, too."""
    table = table_of("give-and-go", A1="hold pass run run run catch layup", D3="run run run")
    ends = [r for r in rows(table, "A1", POSITION) if r["moment"] == AT_END]
    assert [(r["first"], r["last"], r["x"], r["z"]) for r in ends] == [(2, 5, -0.9, 3.1)]
    on_the_way = [r for r in rows(table, "A1", POSITION) if r["moment"] == ON_THE_WAY]
    assert [(r["first"], r["last"]) for r in on_the_way] == [(2, 5), (2, 5)]
    assert 0.0 < on_the_way[0]["fraction"] < on_the_way[1]["fraction"] < 1.0
    starts = [r for r in rows(table, "A1", POSITION) if r["moment"] == AT_START]
    before, behind = (0.4, 8.2), (-0.9, 3.1)  # all of the string, and every class of it
    places = [(0, *before), (0, *before), (1, *before), (2, *before), (5, *behind), (6, *behind)]
    assert [(r["first"], r["x"], r["z"]) for r in starts] == places
    (line,) = rows(table, "D3", LINE)
    assert (line["first"], line["last"], line["moment"]) == (2, 3, AT_END)
    assert table.players[line["target"]] == "A3"
    assert (line["other"], line["other_x"], line["other_z"]) == (POINT, 0.0, 0.0)


def test_an_opponent_is_whom_the_element_names() -> None:
    """D2 of Double Team guards A2, but runs at A1."""
    table = table_of("double-team")
    for kind in (LINE, DIRECTION, DISTANCE):
        for row in rows(table, "D2", kind):
            assert table.players[row["target"]] == "A1", kind
    (guard,) = rows(table, "D1", DISTANCE)
    assert (guard["near"], guard["far"], guard["moment"]) == (0.5, 2.0, THROUGHOUT)


def test_a_block_means_the_shot_that_it_fits_best() -> None:
    table = table_of("pass-and-shoot", A2="run catch pivot_left fake_shot shoot")
    (row,) = rows(table, "D2", SYNCHRONISATION)
    partner = table.partners[row["partner_first"] : row["partner_last"]].tolist()
    theirs = table.actions[row["partner"]]
    assert [theirs[k] for k in partner] == ["fake_shot", "shoot"]


def test_a_pass_that_nobody_asks_for_has_no_receiver() -> None:
    table = table_of("give-and-go", A3="run catch pass run")
    unmet = rows(table, "A3", UNMET)
    assert len(unmet) == 2
    assert {row["weight"] for row in unmet} == {0.1}
    assert {table.actions[2][row["first"]] for row in unmet} == {"pass"}
    assert table_of("give-and-go").rows["kind"].max() < UNMET


def test_order_is_wished_for_where_no_link_ensures_it_and_tables_are_in_the_way() -> None:
    grammar = read_motion_grammar(
        "start S\nobject cup\nplace table height 70 cm size 60 cm\nplace mark\n"
        "S -> do S | do | hand S | hand | get S | get | sit S | sit\n"
        'do := "do"\nhand := "hand"\nget := "get"\nsit := "sit"\n'
        "hand: give(cup)\nget: take(cup)\nsit: distance(table, <= 20 cm)\n",
        "x",
    )
    text = (
        "place table at 2 0\nplace mark at 0 3\nplayer A at 0 0\nplayer B at 3 3\n"
        "1 do A\n2 hand A to B\n3 do B\n4 do A\n5 sit B"
    )
    diagram = read_diagram(text, "x", grammar.activity)
    table = bind(diagram, grammar, casting.cast(diagram, grammar, "x"))
    assert table.actions == (("do", "hand", "do"), ("get", "do", "sit"))
    orders = [row for row in table.wishes.tolist() if row[0] == ORDER]
    # player, action, other, action; the hand-over ensures that A's first two come before B's do
    assert [(row[1], row[2], row[6], row[16]) for row in orders] == [(0, 2, 1, 2), (1, 1, 0, 2)]
    assert [(row[4], row[5]) for row in orders] == [(AT_EVENT, 0.0)] * 2  # no ways
    (way,) = [row for row in table.wishes.tolist() if row[0] == DISTANCE]
    assert (way[1:5], way[7:9], way[12]) == ((0, 0, 3, THROUGHOUT), (2.0, 0.0), 0.3)
    assert len(table.weighed.rows) == len(table.rows) + 3


def test_rules_of_a_nonterminal_are_about_what_it_derives() -> None:
    grammar = read_motion_grammar(
        """
        grammar small
        start S
        place goal
        S -> W stop
        W -> walk | walk W
        walk := "walk"
        stop := "stop"
        S: position(goal) at end
        W: position(goal) at start
        walk in W: direction(90 deg) at end
        """
    )
    diagram = read_diagram(
        """
        diagram "small"
        grammar small
        court 8 x 6
        place goal at 1 2
        player C at 0 0
        """
    )
    tree = parse(grammar.grammar, ["walk", "walk", "stop"])
    table = bind(diagram, grammar, [tree])
    places = [(r["first"], r["last"], r["moment"]) for r in rows(table, "C", POSITION)]
    assert sorted(places) == [(0, 2, AT_START), (0, 3, AT_START), (0, 3, AT_END), (1, 2, AT_START)]
    (facing,) = rows(table, "C", DIRECTION)
    assert (facing["first"], facing["target"], facing["x"]) == (1, -2, pytest.approx(math.pi / 2))


@pytest.mark.parametrize("name", DIAGRAMS)
def test_tables_hold_together(name: str) -> None:
    """Every shipped diagram: all within its strings, every kind as its rule, none unmet."""
    table = table_of(name)
    assert len(table.rows) == len(table.rules) == len(table.items) > 0
    lengths = np.array([len(actions) for actions in table.actions])
    assert (table.rows["first"] >= 0).all()
    assert (table.rows["first"] < table.rows["last"]).all()
    assert (table.rows["last"] <= lengths[table.rows["player"]]).all()
    assert [KINDS[type(rule)] for rule in table.rules] == table.rows["kind"].tolist()
    assert table.rows["weight"].tolist() == [rule.weight for rule in table.rules]


def test_actions_that_no_element_asks_for_are_counted() -> None:
    few = table_of("figure-3", A1="hold pass run", A2="walk run run catch dribble shoot")
    many = table_of("figure-3", A1="hold pivot_left pass idle run", A2="run catch dribble shoot")
    assert many.stray == few.stray + 1
    assert table_of("figure-3", A2="run run run catch dribble shoot").stray == few.stray - 1


def test_strings_that_do_not_fit_are_refused() -> None:
    text = read_scene_text("give-and-go")
    diagram, grammar = text.diagram, text.grammar
    trees = casting.cast(diagram, grammar)
    with pytest.raises(SceneError, match="expected 6 trees, one for each player, found 1"):
        bind(diagram, grammar, [trees["A1"]])
    trees["A2"] = trees["A3"]
    with pytest.raises(SceneError, match=r"expected of A2 actions that fit \(catch\)\(pass\)"):
        bind(diagram, grammar, trees)
