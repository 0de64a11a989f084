"""Diagrams as pictures: every element has its symbol, in its place."""

from __future__ import annotations

import numpy as np
import pytest
from activities import read_diagram
from matplotlib.patches import Circle

from motiondb.database.scenes import scene_texts
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.pictures.tactics import tactics_figure


def axes_of(text: str):
    (axes,) = tactics_figure(read_diagram(text)).axes
    return axes


def lines(axes, gid: str) -> list[np.ndarray]:
    return [np.stack(line.get_data(), axis=1) for line in axes.lines if line.get_gid() == gid]


def test_circles_and_crosses_stand_where_the_players_do() -> None:
    axes = axes_of("attack A1 at 1 5\ndefence D1 at -2 3")
    (circle,) = (patch for patch in axes.patches if isinstance(patch, Circle))
    assert circle.center == (1.0, 5.0)
    assert {text.get_text() for text in axes.texts} == {"A1", "D1"}
    middles = [np.stack(line.get_data(), axis=1).mean(axis=0).tolist() for line in axes.lines]
    assert middles.count([-2.0, 3.0]) == 2


def test_a_pass_is_dashed_from_hand_to_hand_and_a_shot_ends_at_the_rim() -> None:
    axes = axes_of("attack A1 at 0 8\nattack A2 at 0 4\n1 pass A1 to A2\n2 shoot A2")
    passed, shot = lines(axes, "line")
    # from circle to circle, 0.36 m off either middle; a shot ends at the ring
    assert passed.tolist() == [[0.0, 7.64], [0.0, 4.36]]
    assert shot.tolist() == [[0.0, 3.64], [0.0, 0.25]]
    dashes = [line.is_dashed() for line in axes.lines if line.get_gid() == "line"]
    assert dashes == [True, False]
    assert [t.get_text() for t in axes.texts if t.get_gid() == "step"] == ["1", "2"]


def test_a_pass_goes_to_where_the_ball_is_caught() -> None:
    axes = axes_of("attack A1 at 0 8\nattack A2 at 4 8\n1 run A2 to 0 4\n2 pass A1 to A2")
    passed = next(line for line in lines(axes, "line") if len(line) == 2)
    assert passed[1].tolist() == [0.0, 4.36]


def test_moves_dribbles_and_feints_differ() -> None:
    head = "attack A1 at 0 8\ndefence D1 at 4 8\n"
    (run,) = lines(axes_of(head + "1 run A1 to 0 2"), "line")
    (dribble,) = lines(axes_of(head + "1 dribble A1 to 0 2"), "line")
    (feint,) = lines(axes_of(head + "1 feint A1 to 0 2"), "line")
    (pivot,) = lines(axes_of(head + "1 pivot_left A1"), "line")
    assert np.abs(run[:, 0]).max() < 1e-9
    turns = [int(np.sum(np.diff(np.sign(line[:, 0])) != 0)) for line in (dribble, feint)]
    assert turns[0] > 8
    assert turns[1] > 8
    assert np.abs(dribble[:, 0]).max() == pytest.approx(0.14, abs=0.01)
    assert np.abs(feint[:, 0]).max() == pytest.approx(0.20, abs=0.01)
    assert np.linalg.norm(pivot - (0.0, 8.0), axis=1).min() > 0.36


def test_a_screen_ends_in_a_bar_across_its_way() -> None:
    head = "attack A1 at 0 8\ndefence D1 at 0 3\n"
    (bar,) = lines(axes_of(head + "1 screen A1 on D1 to 0 4"), "screen")
    assert np.abs(bar).tolist() == [[0.42, 4.0], [0.42, 4.0]]
    assert len(lines(axes_of(head + "1 screen A1 on D1"), "screen")) == 1


def test_who_is_guarded_is_where_they_are_then() -> None:
    text = "attack A1 at 0 8\ndefence D1 at 4 4\n1 dribble A1 to 4 8\n2 guard D1 on A1"
    dotted = next(line for line in lines(axes_of(text), "line") if len(line) == 2)
    assert dotted[1].tolist() == [4.0, 7.64]


@pytest.mark.parametrize("name", scene_texts.shipped(scene_texts.TACTICS))
def test_every_shipped_diagram_has_all_its_numbers(name: str) -> None:
    diagram = read_scene_text(name).diagram
    (axes,) = tactics_figure(diagram).axes
    steps = sorted(t.get_text() for t in axes.texts if t.get_gid() == "step")
    assert steps == sorted(str(element.step) for element in diagram.elements)


def test_other_grounds_have_places_and_no_lines() -> None:
    axes = axes_of("court 8 x 6\nplace object at 1 0\nplayer C1 at -3 0\n1 walk C1 to 1 1")
    assert {text.get_text() for text in axes.texts} - {""} == {"C1", "object", "1"}
