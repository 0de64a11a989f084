"""Directions of travel and of turning, measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.body.features import recognition_features
from motiondb.body.pose_vectors import from_path
from motiondb.meaning.travelled import directions_to_measure, furthest, speeds_of
from motiondb.records import Float32Array
from motiondb.search.asked_words import learned_words
from motiondb.search.by_words import search_words

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
        ("backward", {"ahead": 0.5}, 0.0),
        ("left", {"turning": -1.0}, 0.0),
        ("sideways", {"left": 0.4, "ahead": 0.5}, 0.0),  # mostly ahead
    ],
)
def test_amounts_by_hand(direction: str, speeds: dict[str, float], amount: float) -> None:
    actual, first, behind = furthest(speeds_of(moving(**speeds)), direction)
    assert actual == pytest.approx(amount, rel=0.05)
    assert (first, behind) == ((0, 15 * SECONDS) if amount else (0, 0))


def test_a_turn_is_no_way_to_a_side() -> None:
    aside = speeds_of(moving(left=0.5))
    assert furthest(aside, "left")[0] > 1.0
    assert furthest(aside, "left", turns=True) == (0.0, 0, 0)


def test_actions_in_place_and_limbs_have_no_measured_direction() -> None:
    assert directions_to_measure(("jump", "left")) == ("left",)
    assert directions_to_measure(("turn", "around")) == ("around",)
    for words in (("lean", "back"), ("look", "left"), ("walk", "left", "foot"), ("turn", "back")):
        assert directions_to_measure(words) == ()


def test_answers_that_turn_the_other_way_come_last_and_say_so(learned_file: Path) -> None:
    """By the motion alone; a caption that says the direction is believed."""
    with motiondb.open(learned_file, read_only=True) as db:
        learned = db.learned
        features = db.session.features.of_capture

    def ask(written: bool) -> motiondb.WordAnswer:
        words = learned_words(learned)
        rows = list(learned.rows)
        return search_words(words, "turn right", rows, 30, written=written, features=features)

    answer = ask(written=False)
    gone = [not match.contradicted for match in answer.matches]
    assert set(gone) == {True, False}
    assert "/turn_right" in answer.matches[0].capture
    for match in answer.matches:
        if match.contradicted:
            assert match.contradicted == ("not right",)
            assert match.reason.endswith("; measured: not right")
            assert match.probability is None
        if "/turn_left" in match.capture:
            assert match.contradicted == ("not right",)
    assert not any(m.contradicted for m in ask(written=True).matches if "/turn_right" in m.capture)


def test_what_is_excluded_and_done_is_a_contradiction(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("turn but not left", limit=101)
    lefts = [match for match in answer.matches if "/turn_left" in match.capture]
    assert lefts
    for match in lefts:
        assert match.contradicted == ("left",)
        assert match.reason.endswith("; measured: left")
        assert match.probability is None
    assert not any(m.contradicted for m in answer.matches if "/turn_right" in m.capture)


def test_a_direction_that_no_caption_holds_is_measured_all_the_same(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("run backward", limit=3)
        assert answer.measured == ("backward",)
        assert answer.understood == "run; measured: backward"
        assert not answer.unknown
        assert not answer.not_used
        assert {match.contradicted for match in answer.matches} == {("not backward",)}
        assert all("/run_" in match.capture for match in answer.matches)
        assert answer.nothing == "probably nothing in this database matches"
