"""Which limb moves, measured."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body import body, rotation
from motiondb.body.features import VELOCITY_SECONDS, VELOCITY_WEIGHT, recognition_features
from motiondb.meaning.limb_sides import (
    HAND_PLACES,
    hands_are_at,
    limb_speeds,
    limbs_to_measure,
    moves_otherwise,
    places_of_hands,
    speeds_of_limbs,
)
from motiondb.records import Float32Array, FloatArray, Motion

FRAMES = 60


def swinging(*joints: str) -> Float32Array:
    """Features of a figure that swings some joints and is still otherwise."""
    turns = np.tile(rotation.IDENTITY, (FRAMES, len(body.JOINTS), 1))
    angle = 0.5 * np.sin(np.arange(FRAMES) / 3.0)
    for joint in joints:
        turns[:, body.INDEX[joint]] = rotation.from_axis_angle(np.array([0.6, 0.0, 0.8]), angle)
    root = np.tile([0.0, 0.9, 0.0], (FRAMES, 1))
    return recognition_features(Motion(turns.astype(np.float32), root.astype(np.float32)))


@pytest.mark.parametrize(
    ("joints", "limb", "moving"),
    [
        (("l_elbow",), "hand", {"left"}),
        (("r_shoulder",), "arm", {"right"}),
        (("l_knee",), "foot", {"left"}),
        (("l_knee",), "hand", {"left", "right", "both"}),  # both rest: nothing is contradicted
        (("l_shoulder", "r_shoulder"), "hand", {"left", "right", "both"}),
    ],
)
def test_the_limb_that_moves_is_seen(joints: tuple[str, ...], limb: str, moving: set[str]) -> None:
    speeds = limb_speeds(speeds_of_limbs(swinging(*joints)), limb)
    sides = ("left", "right", "both")
    assert {side for side in sides if not moves_otherwise(speeds, side)} == moving


def test_only_sides_before_limbs_are_measured() -> None:
    assert limbs_to_measure(("kick", "right", "leg")) == (("right", "leg"),)
    for words in (("turn", "left"), ("hop", "left", "leg"), ("left", "kick", "leg")):
        assert limbs_to_measure(words) == ()


def test_the_hand_that_is_drawn_back_does_not_punch() -> None:
    """A punch of karate: the right hand goes out as quickly as the left one comes back."""
    n = len(body.JOINTS)
    features = np.zeros((10, 6 * n + 4), dtype=np.float32)
    places, moving = (features[:, a : a + 3 * n].reshape(10, n, 3) for a in (0, 3 * n))
    for side, speed in (("l", -3.0), ("r", 3.0)):
        places[:, body.INDEX[f"{side}_wrist"]] = [0.0, 0.0, 0.4]
        moving[:, body.INDEX[f"{side}_wrist"], 2] = speed * VELOCITY_WEIGHT * VELOCITY_SECONDS
    features[:, : 3 * n], features[:, 3 * n : 6 * n] = (
        places.reshape(10, -1),
        moving.reshape(10, -1),
    )
    speeds = speeds_of_limbs(features)
    alike, punched = limb_speeds(speeds, "hand"), limb_speeds(speeds, "hand", ("punch", "left"))
    np.testing.assert_allclose(alike, np.full((10, 2), 9.0), rtol=1e-5)
    np.testing.assert_allclose(punched, np.tile([0.0, 9.0], (10, 1)), rtol=1e-5)
    assert not moves_otherwise(alike, "left")
    assert moves_otherwise(punched, "left")


def standing_at(**moved: tuple[float, float, float]) -> FloatArray:
    """Joints of a figure in T-pose on the ground, some moved to where they are said, one frame."""
    positions = np.tile([0.0, 0.93, 0.0], (1, len(body.JOINTS), 1))
    for joint, parent in enumerate(body.PARENTS.tolist()[1:], start=1):
        positions[0, joint] = positions[0, parent] + body.OFFSETS[joint]
    for name, place in moved.items():
        positions[0, body.INDEX[name]] = place
    return positions


@pytest.mark.parametrize(
    ("elbow", "wrist", "places"),
    [
        ((0.42, 1.41, 0.0), (0.67, 1.41, 0.0), {"side"}),
        ((0.17, 1.41, 0.25), (0.17, 1.41, 0.5), {"front"}),
        ((0.3, 1.6, 0.0), (0.4, 1.82, 0.0), set()),  # stretched up
        ((0.2, 1.3, 0.2), (0.08, 1.5, 0.1), {"head"}),
        ((0.35, 1.15, -0.1), (0.2, 1.03, 0.0), {"left hip"}),
        ((0.3, 0.8, 0.3), (0.12, 0.58, 0.1), {"left knee"}),
        ((0.1, 0.5, 0.3), (0.1, 0.2, 0.1), {"left foot"}),
        ((0.4, 0.4, 0.8), (0.5, 0.15, 0.9), {"floor"}),
        ((0.3, 1.15, -0.2), (0.1, 1.05, -0.2), {"back"}),
    ],
)
def test_a_hand_is_where_its_palm_is(
    elbow: tuple[float, float, float], wrist: tuple[float, float, float], places: set[str]
) -> None:
    positions = standing_at(l_elbow=elbow, l_wrist=wrist)
    bits = places_of_hands(positions, np.zeros(1))
    found = {place for place in HAND_PLACES if hands_are_at(bits, "left", place)[0]}
    assert found == places
    assert not hands_are_at(bits, "right", "head")[0]
    # turned about the vertical, it is at the same places
    turned = positions[..., [2, 1, 0]] * [1.0, 1.0, -1.0]
    assert places_of_hands(turned, np.full(1, np.pi / 2.0)) == bits


def test_hands_that_meet_are_together_and_crossed_arms_are_not() -> None:
    hands = {"l_wrist": (0.03, 1.2, 0.3), "r_wrist": (-0.03, 1.2, 0.3)}
    bits = places_of_hands(standing_at(**hands), np.zeros(1))
    assert hands_are_at(bits, "any", "other hand")[0]
    assert not hands_are_at(bits, "any", "other elbow")[0]
    crossed = {
        "l_elbow": (0.2, 1.2, 0.1),
        "r_elbow": (-0.2, 1.2, 0.1),
        "l_wrist": (-0.06, 1.22, 0.2),
        "r_wrist": (0.06, 1.18, 0.2),
    }
    bits = places_of_hands(standing_at(**crossed), np.zeros(1))
    assert hands_are_at(bits, "any", "other elbow")[0]
