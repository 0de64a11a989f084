"""Diagrams: the format, the shipped ones, who has the ball, and what cannot be played."""

from __future__ import annotations

import numpy as np
import pytest
from activities import read_diagram

from motiondb.database.scenes import scene_texts
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.errors import SceneError
from motiondb.scene.energy import energy
from motiondb.scene.language import tactics_file
from motiondb.scene.language.activity import Ground
from motiondb.scene.language.expressions import smooth_curve
from motiondb.scene.language.possession import first_holder, has_ball
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import BODY_WIDTH

PLAYERS = """attack A1 at 0 8
attack A2 at 4 5
attack A3 at -4 5
defence D1 at 0 7 guards A1
"""


def read(text: str):
    return read_diagram(PLAYERS + text, "x.tactics")


def refusal(text: str, players: str = PLAYERS) -> str:
    with pytest.raises(SceneError) as caught:
        read_diagram(players + text, "x.tactics")
    return str(caught.value)


TABLE_2 = {
    "pass-and-shoot": 4,
    "screen": 5,
    "backdoor": 4,
    "give-and-go": 6,
    "double-team": 4,
    "passing-drills": 3,
    "weave-pass": 3,
}
"""Table 2 of the paper: the number of characters."""


def test_the_shipped_diagrams_have_the_characters_of_the_paper() -> None:
    names = scene_texts.shipped(scene_texts.TACTICS)
    assert set(names) == {*TABLE_2, "figure-3", "carrying", "delivery", "meeting", "sparring"}
    for name, count in TABLE_2.items():
        diagram = read_scene_text(name).diagram
        assert len(diagram.players) == count
        assert first_holder(diagram) == "A1"
    assert {"A1", "A2", "A3", "D2"} <= set(read_scene_text("figure-3").diagram.player)


def test_elements_are_read_with_their_ways() -> None:
    diagram = read("2 cut A2 via 3 3, 2 2 to 1 1.5\n1 pass A1 to A3 caught 4")
    cut, passed = diagram.elements
    assert (cut.step, cut.via, cut.to) == (2, (Spot(3, 3), Spot(2, 2)), Spot(1, 1.5))
    assert (passed.step, passed.other, passed.caught) == (1, "A3", 4)
    assert diagram.grammar == "basketball"
    assert diagram.name == "x.tactics"


def test_other_grounds_and_places() -> None:
    text = (
        'diagram "Carrying"\ngrammar carrying\ncourt 8 x 6\nplace object at 1 0\n'
        "player C1 at -3 0\n1 walk C1 to 1 -0.4"
    )
    diagram = tactics_file.read_diagram(text)
    assert diagram.court == Ground.field(8.0, 6.0)
    assert dict(diagram.places)["object"] == Spot(1.0, 0.0)
    assert (diagram.name, diagram.grammar) == ("Carrying", "carrying")
    assert first_holder(diagram) == ""


def test_the_holder_is_traced_back_from_pass_and_shot() -> None:
    assert first_holder(read("1 pass A2 to A1\n2 shoot A1")) == "A2"
    assert first_holder(read("3 shoot A3")) == "A3"
    assert first_holder(read("1 dribble A2 to 3 4")) == "A2"
    assert first_holder(read("1 run A2 to 3 4")) == ""
    assert first_holder(read("ball A3\n1 run A2 to 3 4")) == "A3"


def test_the_ball_goes_from_hand_to_hand() -> None:
    diagram = read("1 pass A1 to A2\n2 run A1 to 1 4\n3 pass A2 to A1\n4 layup A1")
    assert [act.part for act in diagram.acts["A1"]] == [(), (), ("catch",), ()]
    assert has_ball(diagram, "A1") == (True, False, False, True)
    assert has_ball(diagram, "A2") == (False, True)


def test_opponents_are_who_guards_else_who_is_near() -> None:
    text = (
        "attack A1 at 0 8\nattack A2 at 4 5\ndefence D1 at 4 4 guards A1\ndefence D2 at 3 4\n"
        "1 pass A1 to A2"
    )
    diagram = read_diagram(text)
    assert [diagram.opponent_of(n) for n in ("A1", "A2", "D1", "D2")] == ["D1", "D1", "A1", "A2"]
    assert read_diagram("attack A1 at 0 8").opponent_of("A1") == ""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "1 pass A1 to A2\n2 shoot A3",
            "x.tactics:6: 'shoot A3': expected one player with the ball at the beginning, found "
            "2: A1"
            " ('pass A1 to A2', line 5) and A3 ('shoot A3', line 6). Let it be given to A3 before.",
        ),
        (
            "ball A2\n1 shoot A1",
            "x.tactics:6: 'shoot A1': expected one player with the ball at the beginning, found "
            "2: A2"
            " ('ball A2') and A1 ('shoot A1', line 6). Let it be given to A1 before.",
        ),
        (
            "1 pass A1 to A2\n2 shoot A1",
            "x.tactics:6: 'shoot A1': expected A1 to have the ball, found A1 without the ball since"
            " 'pass A1 to A2' (line 5). Let it be given back.",
        ),
        (
            "3 pass A1 to A2 caught 2",
            "x.tactics:5: 'pass A1 to A2': expected a step from 3 on for the catch, found step 2,"
            " back in time. A pass is caught after it is thrown.",
        ),
        (
            "1 pass A1 to A2 caught 4\n3 shoot A2",
            "x.tactics:6: 'shoot A2': expected one player with the ball at the beginning, found "
            "2: A1 (",
        ),
        (
            "1 pass A1 to A9",
            "x.tactics:5: 'pass A1 to A9': expected one of the players A1, A2, A3, D1, found 'A9'."
            " Add the player, or name another.",
        ),
        ("1 pass A1 to A1", "'pass A1 to A1': expected two players, found A1 twice."),
        ("1 screen A2 on A3", "'screen A2 on A3': expected an opponent of A2, found A3, a team-ma"),
        (
            "1 run A2 to 9 0",
            "'run A2': expected a point on the ground (x -7.5 to 7.5 m, z -1.575 to 12.425 m),"
            " found 9 0. x grows to the right",
        ),
        (
            "1 pass A1 to A2\n2 run A2 to 1 1",
            "'run A2': expected A2 without the ball, found A2 with it. Choose an action",
        ),
        (
            "1 pass A1 to A2\n2 run A1 to 0 3\n3 dribble A1 to 0 2",
            "'dribble A1': expected A1 to have the ball, found A1 without the ball since 'pass A1",
        ),
        ("1 fly A1 to 0 0", "x.tactics:5:3: expected what is done (move, walk, run, cut, dribble,"),
        ("pass A1 to A2", "found 'pass'. Write the step before it: '1 pass ...'."),
        ("1.5 shoot A1", "x.tactics:5:1: expected a whole number from 1 on, found '1.5'."),
        (
            "1 run A2 2 3",
            "x.tactics:5:7: expected 'to' behind A2, found no way. Write where A2 goes:",
        ),
        ("1 run A2 to 3", "x.tactics:5:14: expected z, metres, found the end of the line."),
        ("court 1 x 6", "x.tactics:5:7: expected 2 to 100 metres, found '1'. Lengths are metres."),
        ("attack A1 at 2 2", "x.tactics:5:8: expected a name of their own, found 'A1'. Line 1 has"),
        ("ball B1", "x.tactics: 'ball B1': expected one of the players A1, A2, A3, D1, found 'B1'"),
        (
            "20000 shoot A1",
            "x.tactics:5:1: expected a whole number from 1 to 10000, found '20000'",
        ),
        ("1 run A2 to 1e999 0", "x.tactics:5:13: expected x, metres: a finite number, found '1e"),
        ("court half\ncourt half", "x.tactics:6:1: expected 'court' once, found 'court'. Line 5"),
        ("place q at 1 1\nplace q at 2 2", "x.tactics:6:1: expected 'place q' once, found 'place'"),
        ("place q at 1 400", "x.tactics:5:12: expected a place within 100 metres, found '1'."),
        (
            "attack A4 at 4.3 5",
            "x.tactics:5: 'A4': expected a place at least 0.5 m from A2 (line 2), found 0.3 m.",
        ),
        (
            "attack rim at 3 3",
            "x.tactics:5: 'rim': expected a player's name, found the name",
        ),
        ("attack A4 at 3 3 guards A4", "x.tactics:5: 'A4 guards A4': expected an opponent of A4,"),
        ("attack A4 at 3 3 guards A1", "found a team-mate. Name a player of the other team."),
        (f"attack A{60 * 'x'} at 3 3", "x.tactics:5:8: expected a name of at most 60 characters,"),
        ("1 shoot A1 A2", "found the end of the line. Write '1 shoot A1 at D1'."),
    ],
)
def test_what_cannot_be_played_is_refused_by_name(text: str, message: str) -> None:
    assert message in refusal(text)


def test_all_faults_are_told_at_once() -> None:
    told = refusal("1 run A2 to 9 0\n1 run A3 to 0 20\n3 pass A1 to A2 caught 1").splitlines()
    assert [line.split(":")[1] for line in told] == ["5", "6", "7"]


def test_players_must_be_there_and_on_court() -> None:
    assert "expected at least one player, found none" in refusal("", players="court half")
    assert "'A1': expected a point on the ground" in refusal("", players="attack A1 at 0 40")
    assert "(x -4 to 4 m, z -3 to 3 m), found 0 4. x grows" in refusal(
        "", players="court 8 x 6\nattack A1 at 0 4"
    )
    assert "'D1 guards A1': expected one of the players D1, found 'A1'." in refusal(
        "", players="defence D1 at 0 4 guards A1"
    )


def test_curves_pass_through_their_points() -> None:
    points = np.array([[0.0, 0.0], [1.0, 2.0], [4.0, 2.0], [4.0, -1.0]])
    curve = smooth_curve(points, 10)
    assert curve.shape == (31, 2)
    assert np.allclose(curve[::10], points)
    # no corner: the steps turn by little, also at the points in between
    steps = np.diff(smooth_curve(points, 200), axis=0)
    headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    assert np.abs(np.diff(headings)).max() < 0.1


def test_two_who_stand_so_near_touch() -> None:
    """What the reader refuses is what the sampler would call a collision for ever."""
    assert pytest.approx(2.0 * energy.RADIUS) == BODY_WIDTH
    assert len(read("attack A4 at 4.5 5").players) == 5
