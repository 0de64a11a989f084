"""Directions of travel and of turning, measured."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

import motiondb
from motiondb.answers.questions import search_answer
from motiondb.body.features import recognition_features
from motiondb.body.pose_vectors import from_path
from motiondb.language.vocabulary import IN_A_CIRCLE, IN_PLACE
from motiondb.meaning.travelled import (
    directions_to_measure,
    furthest,
    means_around,
    share_of_full,
    speeds_of,
)
from motiondb.records import Float32Array
from motiondb.search.asking import understand_learned
from motiondb.search.by_words import MEASURED, search_words

SECONDS = 2


def moving(left: float = 0.0, ahead: float = 0.0, turning: float = 0.0) -> Float32Array:
    """Features of a stiff figure at constant speeds (m/s, rad/s) of its own frame."""
    path = np.tile([0.9, left, ahead, turning], (30 * SECONDS, 1))
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(path), 21, 1))
    return recognition_features(from_path(path, still))


@pytest.mark.parametrize(
    ("direction", "speeds", "amount"),
    [
        ("forward", {"ahead": 0.5}, 1.0 / 0.25),
        ("backward", {"ahead": -0.3}, 0.6 / 0.15),
        ("sideways", {"left": -0.2}, 0.4 / 0.2),
        ("left", {"turning": 0.35}, 0.7 / 0.35),
        ("right", {"left": -0.2, "ahead": 0.1}, 0.4 / 0.2),
        ("around", {"turning": -2.1}, 4.2 / 2.1),
        (IN_A_CIRCLE, {"turning": -3.0, "ahead": 1.0}, 6.0 / 4.5),
        ("backward", {"ahead": 0.5}, 0.0),
        ("left", {"turning": -1.0}, 0.0),
        ("sideways", {"left": 0.4, "ahead": 0.5}, 0.0),  # mostly ahead
    ],
)
def test_amounts_by_hand(direction: str, speeds: dict[str, float], amount: float) -> None:
    actual, first, behind = furthest(speeds_of(moving(**speeds)), direction)
    assert actual == pytest.approx(amount, rel=0.05)
    assert (first, behind) == ((0, 15 * SECONDS) if amount else (0, 0))


@pytest.mark.parametrize(
    ("speeds", "amount"),
    [
        ({}, 1.25),
        ({"ahead": 0.2}, 1.25),  # 0.4 m in 2 s
        ({"ahead": 0.5}, 14 / 30 / 0.8),  # 0.43 m in 14 of 30 frames
        ({"ahead": 0.5, "turning": 3.0}, 1.25),  # on a circle of 0.17 m
    ],
)
def test_in_place_is_within_a_square(speeds: dict[str, float], amount: float) -> None:
    assert furthest(speeds_of(moving(**speeds)), IN_PLACE)[0] == pytest.approx(amount, rel=0.05)


def test_only_the_frames_that_show_an_action_count_as_in_place() -> None:
    speeds = np.zeros((90, 3))
    speeds[30:, 1] = 1.0  # stands, then walks
    assert furthest(speeds, IN_PLACE)[0] < 1.0
    assert furthest(speeds, IN_PLACE, shown=np.arange(90) < 30) == (1.25, 0, 30)
    assert furthest(speeds, IN_PLACE, shown=np.arange(90) < 10)[0] == 0.0  # too short


def test_a_turn_is_no_way_to_a_side() -> None:
    aside = speeds_of(moving(left=0.5))
    assert furthest(aside, "left")[0] > 1.0
    assert furthest(aside, "left", "turn") == (0.0, 0, 0)


def _turning(*steps: tuple[float, float, float]) -> np.ndarray:
    """Speeds (frames, 3) from steps of (m/s ahead, rad/s to the left, seconds)."""
    return np.concatenate([np.tile([0.0, v, w], (round(15 * t), 1)) for v, w, t in steps])


@pytest.mark.parametrize(
    ("steps", "amount"),
    [
        # a twist of the trunk: 0.7 rad to the left and back within 1.6 s
        (((0, 0, 3), (0, 1, 0.7), (0, 0, 0.2), (0, -1, 0.7), (0, 0, 3)), 0.0),
        # back after 3 s: first it was a turn
        (((0, 0, 3), (0, 1, 0.8), (0, 0, 3), (0, -1, 0.8), (0, 0, 3)), 0.8 / 0.35),
        # around an obstacle
        (((1, 0, 3), (1, 1, 0.8), (1, -1, 0.8), (1, 0, 3)), 0.8 / 0.35),
    ],
)
def test_a_turn_on_the_spot_that_is_taken_back_is_none(steps: tuple, amount: float) -> None:
    actual = furthest(_turning(*steps), "left", "turn")[0]
    assert actual == pytest.approx(amount, abs=0.01)


def test_a_spin_is_more_than_a_turn() -> None:
    quarter, round_about = _turning((0, 1.57, 1)), _turning((0, 4.7, 1))
    for direction in ("left", "around"):
        assert furthest(quarter, direction, "spin")[0] == pytest.approx(1.57 / 2.35, rel=0.01)
        assert furthest(round_about, direction, "spin")[0] == pytest.approx(2.0, rel=0.01)
    assert share_of_full(2.0, "around", "spin") == 1.0


def test_actions_in_place_and_limbs_have_no_measured_direction() -> None:
    assert directions_to_measure(("jump", "left")) == ("left",)
    assert directions_to_measure(("turn", "around")) == ("around",)
    for words in (("lean", "back"), ("look", "left"), ("walk", "left", "foot"), ("turn", "back")):
        assert directions_to_measure(words) == ()


def test_answers_that_turn_the_other_way_come_last_and_say_so(learned_file: Path) -> None:
    """By the motion alone; a caption that says the direction is believed."""
    with motiondb.open(learned_file, read_only=True) as db:
        learned, frames = db.learned, db.session.frames
        question = understand_learned(learned, "turn right", looks_at_motion=True)
        answer, said = (
            search_words(question, list(learned.rows), 30, written, frames)
            for written in (False, True)
        )
    gone = [not match.contradicted for match in answer.matches]
    assert set(gone) == {True, False}
    assert "/turn_right" in answer.matches[0].capture
    for match in answer.matches:
        if match.contradicted:
            assert match.contradicted == ("does not turn right",)
            assert match.reason.endswith("; measured: does not turn right")
            assert match.probability is None
        if "/turn_left" in match.capture:
            assert match.contradicted == ("does not turn right",)
    assert not any(m.contradicted for m in said.matches if "/turn_right" in m.capture)


def test_what_is_excluded_and_done_is_a_contradiction(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("turn but not left", limit=101)
    lefts = [match for match in answer.matches if "/turn_left" in match.capture]
    assert lefts
    for match in lefts:
        assert match.contradicted == ("turns left, which is excluded",)
        assert match.reason.endswith("; measured: turns left, which is excluded")
        assert match.probability is None
        assert match.parts[0].probability is None
    assert not any(m.contradicted for m in answer.matches if "/turn_right" in m.capture)


def test_a_replaced_verb_is_measured_as_the_known_one(learned_file: Path) -> None:
    """The table has "sideways" as "side" and "stroll" as "walk"; only the verb is replaced."""
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("stroll backwards", limit=101)
        assert answer.understood == "walk (for stroll); measured: backward"
        assert contradicted(answer, "/walk_1") == {("does not go backward",)}
        place = db.search("run in place", limit=101)
        and_wave = search_answer(db.search("run in place and wave", limit=1))
    assert place.understood == "run; measured: in place"
    assert (and_wave.unknown, list(and_wave.question.not_used)) == ({}, [])
    assert and_wave.question.understood == "run in place and wave"
    assert contradicted(place, "/run_") == {("does not stay in place",)}


def contradicted(answer: motiondb.WordAnswer, name: str) -> set[tuple[str, ...]]:
    """What the motion has against some captures, which come last."""
    found = [match.contradicted for match in answer.matches if name in match.capture]
    assert found
    against = [bool(match.contradicted) for match in answer.matches[:MEASURED]]
    assert against == sorted(against)
    return set(found)


@pytest.mark.parametrize(
    ("question", "against"),
    [
        ("run in place twice", "does not stay in place"),
        ("run in place for 2 seconds", "does not stay in place for at least 2 s"),
    ],
)
def test_an_action_with_a_count_or_a_duration_is_measured(
    learned_file: Path, question: str, against: str
) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search(question, limit=101)
    assert answer.measured == ("in place",)
    assert (against,) in contradicted(answer, "")
    assert answer.nothing == "probably nothing in this database matches"


@pytest.mark.parametrize(("n", "size"), [(40, 15), (40, 30), (3, 15), (1, 4), (0, 15)])
def test_means_around_are_those_of_scipy(n: int, size: int) -> None:
    values = np.random.default_rng(n).normal(size=(n, 2))
    expected = uniform_filter1d(values, size, axis=0, mode="nearest") if n else values
    assert means_around(values, size) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("question", "unmeasured"),
    [
        ("wave the left wrist or walk", ("left", "wrist")),
        ("walk while waving the right thumb", ("right", "thumb")),
    ],
)
def test_what_is_not_measured_has_no_probability(
    learned_file: Path, question: str, unmeasured: tuple[str, ...]
) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search(question, limit=3)
    assert answer.unmeasured == unmeasured
    assert answer.understood.endswith(f"; not measured: {', '.join(unmeasured)}")
    assert answer.matches_anything is None
    for match in answer.matches:
        assert {match.probability, *(part.probability for part in match.parts)} == {None}


def test_a_direction_that_no_caption_holds_is_measured_all_the_same(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("run backward", limit=101)
        assert answer.measured == ("backward",)
        assert answer.understood == "run; measured: backward"
        assert not answer.unknown
        assert not answer.not_used
        assert contradicted(answer, "/run_") == {("does not go backward",)}
        assert answer.nothing == "probably nothing in this database matches"


def test_how_long_an_action_goes_on_is_measured(learned_file: Path) -> None:
    """A walk of some seconds is shown where the person walks that long without a rest."""
    with motiondb.open(learned_file, read_only=True) as db:
        short = db.search("walk for at least 1 second", limit=5)
        long = db.search("walk for at least 60 seconds", limit=5)
    assert not any(match.contradicted for match in short.matches)
    for match in long.matches:
        assert re.fullmatch(r"goes on for \d+\.\d s, not at least 60 s", match.contradicted[0])
        assert match.probability is None
    assert long.nothing.endswith("nothing in this database matches")
