"""Inverse kinematics, keys and words of the sample data's program, by hand-worked numbers."""

from __future__ import annotations

import doctest
from types import ModuleType

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from motiondb.body import kinematics, rotation
from sample_data import grammars, performers, repertoire, rig
from sample_data.grammars import GRAMMARS, derive
from sample_data.performers import INDEX, PERFORMERS, ROLES, Performer, skeleton, spelled
from sample_data.phrases import PHRASES, short_captions
from sample_data.repertoire import ACTIONS, coarse
from sample_data.score import STAND, Take
from sample_data.takes import captures


def test_two_equal_bones_bend_to_a_right_angle() -> None:
    """Legs of 1 and 1 m over sqrt(2) m: 45 degrees at the hip, 90 at the knee."""
    start = np.zeros((1, 3))
    target = np.array([[0.0, -np.sqrt(2.0), 0.0]])
    first, bent, angle = rig.two_bones(start, target, np.array([[0.0, 0.0, 1.0]]), 1.0, 1.0)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(first, [[0.0, -half, half]], atol=1e-12)
    np.testing.assert_allclose(bent, [[0.0, half, half]], atol=1e-12)
    np.testing.assert_allclose(angle, [np.pi / 2], atol=1e-12)


def test_out_of_reach_the_limb_points_at_the_target() -> None:
    start, target = np.zeros((1, 3)), np.array([[0.0, -9.0, 0.0]])
    first, _, angle = rig.two_bones(start, target, np.array([[0.0, 0.0, 1.0]]), 0.5, 0.5)
    assert first[0, 1] < -0.99
    assert angle[0] == pytest.approx(2 * np.arccos(rig.REACH), abs=1e-9)


@given(arrays(float, 3, elements=st.floats(-0.55, 0.55)), st.floats(0.0, 6.28))
def test_two_bones_end_on_any_target_within_reach(target: np.ndarray, way: float) -> None:
    """The lower bone leaves the upper one by the angle, away from the pole."""
    upper, lower = 0.5, 0.45
    assume(0.2 < np.linalg.norm(target) < 0.94)
    pole = np.array([[np.cos(way), 0.3, np.sin(way)]])
    assume(np.linalg.norm(np.cross(pole[0], target)) > 0.05)
    first, bent, angle = rig.two_bones(np.zeros((1, 3)), target[None], pole, upper, lower)
    second = np.cos(angle) * first - np.sin(angle) * bent
    np.testing.assert_allclose(upper * first + lower * second, target[None], atol=1e-9)
    assert np.sum(bent * pole) > 0 or np.sum(first * pole) > 0


@pytest.mark.parametrize("person", PERFORMERS.values(), ids=lambda person: person.name)
def test_a_standing_take_reaches_its_feet_and_hands(person: Performer) -> None:
    take = Take(person, "stand", 1)
    take.end("idle", 0.2)
    channels = take.curves()
    bones = skeleton(take.person)
    local, root = rig.solve(channels, take.person, bones)
    positions, _ = kinematics.forward(bones.parents, bones.offsets, local, root)
    for side in "lr":
        ankle = positions[0, INDEX[f"{side}_ankle"]]
        foot = np.array([channels[side + axis][0] for axis in "xyz"])
        foot[1] += 0.08 * take.person.scale
        np.testing.assert_allclose(ankle, foot, atol=1e-3)
        shoulder, wrist = (positions[0, INDEX[f"{side}_{j}"]] for j in ("shoulder", "wrist"))
        reach = np.linalg.norm(wrist - shoulder)
        hang = np.linalg.norm([STAND[f"{side}h{axis}"] for axis in "xyz"])
        assert reach == pytest.approx(hang * take.person.arm, rel=1e-2)
        assert wrist[1] < shoulder[1]


def test_knees_and_elbows_bend_one_way_only() -> None:
    take = Take(PERFORMERS["ana"], "squat", 1)
    ACTIONS["pick_up"](take)
    local, _ = rig.solve(take.curves(), take.person, skeleton(take.person))
    for side, sign in (("l", -1.0), ("r", 1.0)):
        knee = rotation.log(local[:, INDEX[f"{side}_knee"]])
        assert knee[:, 0].min() >= 0.0
        np.testing.assert_allclose(knee[:, 1:], 0.0, atol=1e-9)
        elbow = rotation.log(local[:, INDEX[f"{side}_elbow"]])
        assert (sign * elbow[:, 1]).min() >= 0.0
        np.testing.assert_allclose(elbow[:, [0, 2]], 0.0, atol=1e-9)


def test_a_step_keeps_the_foot_flat_and_still_before_and_after() -> None:
    take = Take(PERFORMERS["ana"], "step", 1)
    take.begin()
    x, z, yaw = take.stance("l")
    take.step("l", 0.5, 1.0, (x, z + 0.5, yaw))
    take.end("step", 1.5)
    channels = take.curves()
    np.testing.assert_array_equal(channels["lz"][:16], z)
    np.testing.assert_allclose(channels["lz"][30:], z + 0.5)
    assert channels["ly"].max() == pytest.approx(0.06, abs=1e-3)
    assert take.events == [
        (0.5, "foot_off", "l_ankle", "ground"),
        (1.0, "foot_strike", "l_ankle", "ground"),
    ]


def test_turning_left_ends_90_degrees_to_the_left() -> None:
    take = Take(PERFORMERS["boris"], "turn", 1)
    ACTIONS["turn_left"](take)
    assert take.place[2] == pytest.approx(90.0)
    assert take.segments[0][0] == "turn_left"
    assert take.curves()["yaw"][-1] == pytest.approx(90.0, abs=0.5)


def test_both_namings_spell_every_role() -> None:
    for naming in ("leg", "knee"):
        names = [spelled(role, naming) for role, _ in ROLES]
        assert len(set(names)) == len(ROLES)
    assert spelled("r_wrist", "leg") == "RightHand"
    assert spelled("r_wrist", "knee") == "RightWrist"


def test_sentences_of_the_toy_grammar_are_its_fourteen_strings() -> None:
    letters = {
        "catch": "r",
        "fake_shot": "f",
        "dribble": "d",
        "pass": "p",
        "shoot": "s",
        "run": "m",
    }
    middles = ("", "f", "d", "ff", "fd", "df", "fdf")
    strings = {f"r{middle}{end}m" for middle in middles for end in "ps"}
    assert len(strings) == 14
    random = np.random.RandomState(0)
    drawn = [derive("play", random).words() for _ in range(300)]
    assert {"".join(letters[word] for word in words) for words in drawn} == strings


def test_every_terminal_is_an_action_with_words() -> None:
    for rules in GRAMMARS.values():
        symbols = {s for choices in rules.values() for choice in choices for s in choice}
        assert symbols - set(rules) <= set(ACTIONS) & set(PHRASES)
    assert {coarse(move) for c in captures() for move, _ in c.moves} <= set(PHRASES)


@pytest.mark.parametrize("module", [grammars, performers, repertoire], ids=lambda m: m.__name__)
def test_the_examples_in_the_docstrings_run(module: ModuleType) -> None:
    failed, tried = doctest.testmod(module)
    assert tried > 0
    assert failed == 0


def test_hands_clap_before_the_chest() -> None:
    take = Take(PERFORMERS["goran"], "clap", 1)
    ACTIONS["dance_clap"](take)
    frame = round(take.events[0][0] * 30)
    clip = take.clip()
    positions, _ = kinematics.clip_positions(clip)
    apart = positions[frame, INDEX["l_wrist"]] - positions[frame, INDEX["r_wrist"]]
    assert 0.03 < np.linalg.norm(apart) < 0.20


def test_captions_are_a_sentence_and_keywords() -> None:
    sentence, keywords = short_captions("boris", ["walk", "kick"], np.random.RandomState(3))
    assert "walk" in keywords
    assert len(sentence.split()) > 3
    assert "woman" not in sentence
