"""Scenes as pictures: who is where, from above and from the half line."""

from __future__ import annotations

from dataclasses import replace

import hand_made
import numpy as np
import pytest

from motiondb.pictures import style
from motiondb.pictures.scenes import performer_colours, scene_images, scene_paths_figure
from motiondb.scene.language.activity import Place
from motiondb.scene.language.semantic_rules import Spot


def test_ways_stand_in_metres_in_their_colours() -> None:
    figure = scene_paths_figure(hand_made.DIAGRAM, hand_made.people())
    ways = {line.get_gid(): line for line in figure.axes[0].lines if line.get_gid()}
    x, z = ways["way A1"].get_data()
    np.testing.assert_allclose([x[0], z[0]], [-3.0, 6.0], atol=1e-6)
    np.testing.assert_allclose(np.hypot(x[-1] + 3.0, z[-1] - 6.0), 3.0, atol=1e-5)
    assert ways["way A1"].get_color() == performer_colours(hand_made.DIAGRAM)["A1"]
    assert len(set(performer_colours(hand_made.DIAGRAM).values())) == len(hand_made.DIAGRAM.players)
    assert "ball" not in ways


def test_a_ball_that_flies_is_dashed_where_it_flies() -> None:
    ball = np.zeros((31, 3))
    ball[10:21, 0] = np.linspace(0.0, 3.0, 11)
    ball[21:, 0] = 3.0
    figure = scene_paths_figure(hand_made.DIAGRAM, hand_made.people(), ball)
    held, flown = (line for line in figure.axes[0].lines if line.get_gid() == "ball")
    assert np.isfinite(flown.get_xdata()).nonzero()[0].tolist() == list(range(10, 21))
    assert np.isnan(held.get_xdata()).nonzero()[0].tolist() == list(range(11, 20))


@pytest.mark.parametrize("above", [True, False])
def test_everybody_is_seen_where_they_are(above: bool) -> None:
    images = scene_images(hand_made.DIAGRAM, hand_made.people(), above=above, width=320)
    assert len(images) == 21  # 31 frames at 30 a second, 20 pictures a second
    pixels = np.asarray(images[0].convert("RGB")).astype(int)
    columns = {}
    for name, colour in performer_colours(hand_made.DIAGRAM).items():
        if name in hand_made.people():
            wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])
            near = np.abs(pixels - wanted).sum(axis=2) < 60
            near[: pixels.shape[0] // 3] &= name != "A1"  # the rim has its colour
            columns[name] = float(np.median(np.nonzero(near)[1]))
    assert columns["A1"] < columns["D1"]


def test_a_goal_is_wholly_in_the_picture() -> None:
    goal = Place("goal", Spot(4.0, 0.0), 1.2, 14.0, 2.4)
    activity = replace(hand_made.DIAGRAM.activity, places=(goal,))
    diagram = replace(hand_made.DIAGRAM, activity=activity)
    pixels = np.asarray(scene_images(diagram, hand_made.people(), width=240)[0].convert("RGB"))
    wanted = np.array([int(style.RIGHT[k : k + 2], 16) for k in (1, 3, 5)])
    edge = np.abs(pixels.astype(int) - wanted).sum(axis=2) < 60
    assert edge.any(axis=1).sum() > 5
    assert not edge[:, [0, -1]].any()


def test_who_ends_early_stands() -> None:
    moving = {
        "A1": hand_made.standing(0.0, 4.0, 0.0, 10, speed=3.0),
        "D1": hand_made.standing(3.0, 4.0, 0.0, 31),
    }
    images = scene_images(hand_made.DIAGRAM, moving, width=240)
    height = images[0].height
    last, before = (np.asarray(image)[height // 8 :] for image in (images[-1], images[-6]))
    np.testing.assert_array_equal(last, before)
