"""Diagrams of any activity: times, roles, places, distances, and slips that are told."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from made_activities import CUP, DANCE, refusal, texts

from motiondb.errors import SceneError
from motiondb.grammar.cfg.parse import parse
from motiondb.scene.energy.binding import (
    AT_START,
    DISTANCE,
    POSITION,
    SYNCHRONISATION,
    bind,
)
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics_file import format_diagram, read_diagram
from motiondb.scene.services.casting import cast, check_times

WAYS = read_motion_grammar(
    'start S\nS -> run | wait | run S | wait S\nrun := "run"\nwait := "wait"\n', "ways"
)


def times(text: str) -> str:
    diagram = read_diagram("player A at 0 0\nplayer B at 5 0\n" + text, "x", WAYS.activity)
    try:
        check_times(diagram, "x")
    except SceneError as error:
        return str(error)
    return ""


def test_a_circle_of_times_that_cannot_be_closed_is_told() -> None:
    run = "2 wait A\n3 run A to 0 8\n4 wait A\n"
    assert times(run + "step 4 comes 2 s after 2") == ""
    assert times(run + "step 4 comes 0.6 s after 2") == (
        "x: expected times that people can keep, found that A would have to run 8.0 m in 0.6 s"
        " between steps 2 and 4. Give them longer, or draw a shorter way."
    )


def test_steps_that_no_time_suits_or_that_are_not_drawn_are_told() -> None:
    waits = "1 wait A\n2 wait B\n3 wait A\n"
    told = times(
        waits + "step 2 comes 1 s after 1\nstep 3 comes 1 s after 2\nstep 3 comes .5 s after 1"
    )
    assert told.startswith("x: expected times that people can keep, found that one follows in ")
    assert "in 1 s between steps 1 and 2" in told
    assert refusal(WAYS, "player A at 0 0\n1 wait A\nstep 9 comes 1 s after 1") == (
        "x: 'step 9 comes 1 s after 1': expected a step of the diagram (1), found 9. Draw it, or"
        " name another."
    )
    assert "'A keeps moving from 1 to 7': expected a step of the diagram (1), found 7" in (
        refusal(WAYS, "player A at 0 0\n1 wait A\nA keeps moving from 1 to 7")
    )


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("plac bench at 1 2", "2:1: expected 'place', or a role of several players or of the"),
        ("plyer B at 5 0", "Did you mean player? Or write 'role plyer' in the grammar."),
        ("palyer B at 5 0", "2:1: expected 'player', or a role of several players"),
        ("grund 8 x 6", "2:1: expected 'ground', found 'grund'. Did you mean ground?"),
        ("stp 2 comes 1 s after 1", "2:1: expected 'step', found 'stp'. Did you mean step?"),
        ("A keep moving", "2:3: expected 'keeps', found 'keep'. Did you mean keeps?"),
        ("A keeps movin", "2:9: expected 'moving', found 'movin'. Did you mean moving?"),
        ("1 dos A run", "2:3: expected 'does', found 'dos'. Did you mean does?"),
        ("1 run A too 0 3", "2:9: expected 'to', found 'too'. Did you mean to?"),
        ("1 run A vai B", "2:9: expected 'via', found 'vai'. Did you mean via?"),
        ("1 wait A\n1 wait A", "3:8: expected 'wait A' once in step 1, found 'A'. Line 2 says it"),
        ("A keeps <= -1 m to B", "2:12: expected distances of 0 or more, the nearer first"),
        ("A keeps moving\nA keeps moving", "3:1: expected every line once, found 'A'. Line 2"),
        ("1 wait A caught 2", "2:8: expected 'caught' behind what gives"),
    ],
)
def test_slips_in_a_diagram_are_told_with_line_and_column(line: str, message: str) -> None:
    """Where any name may stand, too: a role that no grammar declares, the word before a player."""
    assert message in refusal(WAYS, f"player A at 0 0\n{line}")


ROLES = """
slayer layer keeper leader2 attack movers targetman groundsman eventer starter stepper courtier
catcher marker rounder playmaker objects diagrammer grammarian startled
"""


def test_people_name_roles_as_they_like() -> None:
    for role in ROLES.split():
        text = f"{role} A at 0 0\nplayer B at 2 0\n1 wait A"
        assert read_diagram(text, activity=WAYS.activity).player["A"].team == role


def test_a_role_like_a_keyword_is_one_if_several_have_it_or_the_grammar_declares_it() -> None:
    two = "players A at 0 0\nplayers B at 2 0\n1 wait A"
    assert read_diagram(two, activity=WAYS.activity).player["A"].team == "players"
    one = "prayer A at 0 0\nplayer B at 2 0\n1 wait A"
    declared = replace(WAYS.activity, roles=(("prayer", ""),))
    assert "Did you mean player" in refusal(WAYS, one)
    assert read_diagram(one, activity=declared).player["A"].team == "prayer"


def test_a_right_word_is_not_offered_for_itself() -> None:
    told = refusal(DANCE, "leader Lea to 0 0")
    assert "found 'leader'. Write 'leader Lea at 0 8'." in told


def test_a_place_spelt_like_one_of_the_grammar_is_told() -> None:
    assert "the place table of the grammar, found 'tabel'. Did you mean table?" in (
        refusal(CUP, "place tabel at 1 1\nplayer A at 0 0")
    )


NEARLY = read_motion_grammar(
    """
    start S
    ground 8 x 6
    place post at 0 2
    S -> walk | walk S | hug | hug S | wave | wave S
    walk := "walk"
    hug := "hug"
    wave := "wave"
    verb hug = hug with partner
    verb greet = hug | wave with partner
    verb go = walk to X Z
    verb lean = walk then wave at target to X Z
    hug: distance(partner, <= 1 m)
    wave: distance(post, <= 50 cm) at end
    """,
    "nearly",
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "2 hug A with B\nA keeps 2 m .. 4 m to B from 1 to 3",
            "'A keeps 2 m .. 4 m to B from 1 to 3', and at most 1 m from A to B in 'hug A with B'",
        ),
        ("2 hug B with A\nA keeps 2 m .. 4 m to B from 1 to 3", "at most 1 m from B to A in"),
        ("2 hug A with B\nA keeps 1 m .. 4 m to B from 1 to 3", ""),
        ("2 hug A with B\nA keeps 2 m .. 4 m to B from 3 to 3", ""),
        ("2 greet A with B\nA keeps 2 m .. 4 m to B from 1 to 3", ""),
        (
            "2 wave A\nA keeps 1 m .. 2 m to B from 2 to 2\nB keeps 2.5 m .. 4 m to A from 2 to 3",
            "distances that can be kept at once, found 'A keeps 1 m .. 2 m to B from 2 to 2', and",
        ),
        (
            "2 wave A\nA keeps 1 m .. 2 m to B from 2 to 2\nB keeps 2.5 m .. 4 m to A from 3 to 3",
            "",
        ),
        ("A keeps 11 m .. 12 m to B from 1 to 3", "expected places that are as far"),
        (
            "4 go B to 3.9 -2.9\nA keeps 6 m .. 9 m to B",
            "places to begin that keep it, found 2.0 m between them",
        ),
        ("2 lean A at post to 3 -2", "at most 0.5 m from A to post in 'lean A at post' (line 5),"),
        ("2 lean A at post to 0.4 1.6", ""),
        ("2 lean A at post via 0 2 to 3 2", "at most 0.5 m from A to post"),  # at its end
        ("place post at 4.3 0\n2 lean A at post to 4 0", ""),  # 30 cm beside the ground
        ("place post at 0 9\n2 lean A at post", "on a ground of 8 x 6 m"),
        (
            "4 go B to 3.9 -2.9\n5 go B to 0.9 1\n5 go A to 0.2 1\n"
            "A keeps 3.5 m .. 9 m to B from 5 to 5",
            "places to end that keep it, found 0.7 m between them",
        ),
    ],
)
def test_distances_that_nobody_can_keep_are_refused_before_sampling(
    text: str, message: str
) -> None:
    drawn = "player A at -1 0\nplayer B at 1 0\n1 go A to -1 1\n3 go B to 1 1\n" + text
    diagram = read_diagram(drawn, "x", NEARLY.activity)
    told = ""
    try:
        cast(diagram, NEARLY, "x")
    except SceneError as error:
        told = str(error)
    assert bool(message) == bool(told)
    assert message in told


def test_the_same_act_may_come_again_and_places_be_numbered() -> None:
    drawn = "player A at -1 0\nplayer B at 1 0\nplace post2 at 3 3\n"
    again = drawn + "1 go A to -1 1\n1 go A to 1 1\n1 go A to -1 1\n"
    assert len(read_diagram(again, "x", NEARLY.activity).elements) == 3
    with pytest.raises(SceneError, match="once in step 1"):
        read_diagram(drawn + "1 go A to -1 1\n1 go A to -1 1\n", "x", NEARLY.activity)
    with pytest.raises(SceneError, match="Did you mean post"):
        read_diagram(drawn + "place pots at 3 3\n", "x", NEARLY.activity)


def test_a_place_that_is_too_far_for_what_is_kept_is_told() -> None:
    kept = "A keeps 0 m .. 2 m to B from 1 to 2"
    assert times(f"1 run B to 0 2\n2 run A to 0 3\n{kept}") == ""
    told = times(f"1 run B to 5 3\n2 run A to -4 0\n{kept}")
    assert told.startswith("x:5: 'A keeps 0 m .. 2 m to B from 1 to 2': expected places that are")
    assert "A at 0 0 in 'run A' (line 4), 5.0 m from wherever B is drawn then" in told


def test_steps_that_come_at_a_time_are_synchronised() -> None:
    diagram = read_diagram(
        "player A at 0 0\nplayer B at 5 0\n1 wait A\n2 run B to 5 3\nstep 2 comes 1.5 s after 1\n"
        "B keeps 1 m .. 9 m to A",
        "x",
        WAYS.activity,
    )
    trees = [parse(WAYS.started(), [action]) for action in ("wait", "run")]
    rows = bind(diagram, WAYS, trees).rows
    (timed,) = rows[rows["kind"] == SYNCHRONISATION]
    assert (timed["player"], timed["partner"], timed["lag"]) == (0, 1, 1.5)
    kept = rows[rows["kind"] == DISTANCE]
    assert kept["player"].tolist() == [1, 0]
    trees = [parse(WAYS.started(), actions) for actions in (["wait"], ["run"] * 3)]
    rows = bind(diagram, WAYS, trees).rows
    (timed,) = rows[rows["kind"] == SYNCHRONISATION]  # a way begins then, however long it is
    assert bind(diagram, WAYS, trees).partners[timed["partner_first"]] == 0
    assert diagram.elements[1].to == Spot(5.0, 3.0)


def test_what_somebody_sends_may_be_drawn_to_be_caught() -> None:
    rally = read_motion_grammar(
        """
        start S
        object ball size 24 cm
        S -> serve | hit | catch | serve S | hit S | catch S
        serve := "serve" when asked
        hit := "hit" when asked
        catch := "catch" when asked
        serve: send(ball, receiver)
        hit: strike(ball, receiver)
        catch: take(ball)
        hit, catch answers serve | hit after 0.9 s
        """,
        "rally",
    )
    players = "player A at -2 0\nplayer B at 2 0\nball A\n"
    drawn = players + "1 serve A to B\n2 hit B to A\n"
    assert texts(rally, drawn + "3 catch A") == {"A": "(serve)(catch)", "B": "(hit)"}
    assert "found none that lies anywhere" in refusal(rally, players + "1 catch B\n2 serve A to B")


def test_a_distance_without_an_end_is_kept_and_written_as_it_is_read() -> None:
    text = "player A at 0 0\nplayer B at 2 0\n1 wait A\nA keeps >= 1 m to B\nB keeps <= 3 m to A"
    diagram = read_diagram(text, "x", WAYS.activity)
    assert [(one.near, one.far) for one in diagram.stretches] == [(1.0, math.inf), (0.0, 3.0)]
    assert read_diagram(format_diagram(diagram), "x", WAYS.activity).stretches[0].far == math.inf


WEDDING = read_motion_grammar(
    "start S\nrole bride, guest\nverb clap = clap with partner\nS -> clap | clap S\n"
    'clap := "clap"\nclap: direction(bride), synchronisation(partner, clap, 0 s)\n',
    "wedding",
)


def test_a_rule_about_a_role_that_only_its_own_player_fills_is_refused() -> None:
    told = refusal(WEDDING, "bride Mia at 0 0\nguest Gus at 2 0\n1 clap Gus with Mia")
    assert "expected a bride of Mia, whom the rule direction of clap is about, found none" in told
    assert "Write of whom the rule is: 'clap in SYMBOL: ...'" in told
    two = "bride Mia at 0 0\nguest Gus at 2 0\nbride Ida at 0 2\n1 clap Gus with Mia"
    assert cast(read_diagram(two, "x", WEDDING.activity), WEDDING, "x")


REACH = read_motion_grammar(
    "start S\nobject cup at table\nplace table height 70 cm size 60 cm\nS -> get | lean\n"
    'get := "get" event catch\nlean := "lean"\nget: take(cup), distance(cup, <= 60 cm)\n'
    "lean: distance(table, <= 60 cm)\n",
    "reach",
)


@pytest.mark.parametrize(("act", "goes"), [("get", True), ("lean", False)])
def test_who_takes_a_thing_goes_to_it_from_half_a_metre_beyond_their_reach(
    act: str, goes: bool
) -> None:
    drawn = f"place table at 0 1.4\nplayer A at 0 0\n1 {act} A"  # .8 m beyond
    diagram = read_diagram(drawn, "x", REACH.activity)
    rows = bind(diagram, REACH, [parse(REACH.started(), [act])]).rows
    positions = rows[(rows["kind"] == POSITION) & (rows["moment"] == AT_START)]
    assert len(positions) == 2 - goes  # where A begins, and where A is to act
