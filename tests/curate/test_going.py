"""How a body goes, of a body that slides over the ground as it is told."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body import body, rotation
from motiondb.curate import going
from motiondb.records import FloatArray, Motion

UP = np.array([0.0, 1.0, 0.0])


def gliding(
    speeds: FloatArray, headings: FloatArray, aside: float = 0.0, leg: float = 0.85
) -> Motion:
    """Frame by frame: m/s, heading in radians, direction from the heading; of legs of a length."""
    n = len(speeds)
    rotations = np.zeros((n, len(body.JOINTS), 4), dtype=np.float32)
    rotations[..., 0] = 1.0
    rotations[:, 0] = rotation.from_axis_angle(UP, headings)
    way = np.stack([np.sin(headings + aside), np.zeros(n), np.cos(headings + aside)], axis=1)
    places = np.cumsum(way * speeds[:, None] / 30.0, axis=0) * (body.LEG_LENGTH / leg)
    places[:, 1] = body.LEG_LENGTH + body.ANKLE_HEIGHT
    return Motion(rotations, places.astype(np.float32), leg)


def kind_of(speed: float, aside: float = 0.0, turn: float = 0.0, leg: float = 0.85) -> list[str]:
    t = np.arange(90) / 30.0
    found = going.going_of(gliding(np.full(90, speed), np.radians(turn) * t, aside, leg))
    middle = slice(20, 70)
    kinds, turns = set(found.kinds[middle].tolist()), set(found.turns[middle].tolist())
    assert len(kinds) == len(turns) == 1
    return [going.KINDS[kinds.pop()][0], going.TURNS[turns.pop()]]


@pytest.mark.parametrize(
    ("speed", "aside", "turn", "expected"),
    [
        (0.0, 0.0, 0.0, ["stand", "none"]),
        (0.0, 0.0, 90.0, ["stand", "sharp left"]),
        (0.5, 0.0, 0.0, ["walk slowly", "none"]),
        (1.2, 0.0, -40.0, ["walk", "right"]),
        (1.6, 0.0, 0.0, ["walk fast", "none"]),
        (2.4, 0.0, 40.0, ["jog", "left"]),
        (4.0, 0.0, -80.0, ["run", "sharp right"]),
        (0.8, np.pi / 2, 0.0, ["go left sideways", "none"]),
        (0.8, -np.pi / 2, 0.0, ["go right sideways", "none"]),
        (0.8, np.pi, 0.0, ["go backward", "none"]),
        (0.3, np.pi / 2, 0.0, ["stand", "none"]),
    ],
)
def test_kinds_and_turns(speed: float, aside: float, turn: float, expected: list[str]) -> None:
    assert kind_of(speed, aside, turn) == expected


def test_speeds_are_metres_of_the_performer() -> None:
    assert kind_of(1.2, leg=0.60) == kind_of(1.2, leg=1.0) == ["walk", "none"]


def changes(*parts: tuple[float, float]) -> list[str]:
    """Changes of a body that goes at some speeds, each for some seconds."""
    speeds = np.concatenate([np.full(round(30 * seconds), speed) for speed, seconds in parts])
    found = going.going_of(gliding(speeds, np.zeros(len(speeds))))
    return [going.CHANGES[each.kind] for each in going.changes_of(found)]


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        (((0.0, 1.0), (1.2, 2.0)), ["start to walk"]),
        (((1.2, 2.0), (0.0, 1.0)), ["stop from a walk"]),
        (((0.0, 1.0), (4.0, 2.0)), ["start to run"]),
        (((0.0, 1.0), (1.2, 0.8), (4.0, 2.0)), ["start to run"]),
        (((0.0, 1.0), (1.2, 2.5), (4.0, 2.0)), ["start to walk", "walk to run"]),
        (((4.0, 2.0), (1.2, 0.8), (0.0, 1.0)), ["stop from a run"]),
        (((4.0, 2.0), (1.2, 2.5), (0.0, 1.0)), ["run to walk", "stop from a walk"]),
        (((1.2, 2.0), (0.1, 0.2), (1.2, 2.0)), []),
        (((4.0, 2.0), (1.2, 0.3), (4.0, 2.0)), []),
    ],
)
def test_a_run_that_passes_through_a_walk_is_seen(
    parts: tuple[tuple[float, float], ...], expected: list[str]
) -> None:
    assert changes(*parts) == expected


def test_the_foot_ahead_is_told_after_a_start_and_before_a_stop() -> None:
    n = 90
    ahead = np.zeros(n)
    ahead[40:50], ahead[50:60] = 0.4, -0.4  # first the left foot, then the right
    speed = np.where((np.arange(n) >= 35) & (np.arange(n) < 65), 1.2, 0.0)
    told = going.Going(speed, np.zeros(n), np.zeros(n), np.ones(n, dtype=bool), ahead)
    found = [(going.CHANGES[c.kind], going.FEET[c.foot]) for c in going.changes_of(told)]
    assert found == [("start to walk", "left foot"), ("stop from a walk", "right foot")]


def test_who_lies_is_not_counted() -> None:
    motion = gliding(np.zeros(60), np.zeros(60))
    rotations = motion.local_rotations.copy()
    rotations[:, 0] = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.full(60, np.pi / 2))
    found = going.going_of(Motion(rotations, motion.root_positions, 0.85))
    assert set(found.kinds.tolist()) == {-1}
    assert np.isnan(going.moments(found)).all()


def test_the_middle_of_every_cell_lies_in_the_cell() -> None:
    for kind in range(len(going.KINDS)):
        for turn in range(len(going.TURNS)):
            speed, left, ahead, turned = going.wanted(kind, turn)
            told = going.Going(
                np.array([speed * 1.4]),
                np.array([np.arctan2(left, ahead)]),
                np.array([turned * np.pi / 2]),
                np.array([True]),
                np.zeros(1),
            )
            assert (told.kinds[0], told.turns[0]) == (kind, turn)
