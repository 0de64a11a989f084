"""Actions whose event is seen in the motion, and the way of kicks, whatever captions say."""

from __future__ import annotations

from typing import Any

import pytest
from test_measured_questions import amounts, track_of

import motiondb
from motiondb.body.features import FEATURE_STEP
from motiondb.meaning.occurrences import find_occurrences
from motiondb.search import by_words
from motiondb.search.measured_answers import _found
from motiondb.search.seen_frames import SeenFrames


def test_an_event_that_no_caption_says_is_seen_in_the_motion(db: motiondb.MotionDB) -> None:
    """Before the known words that replace others: "sit" for "squat"."""
    assert not {"squat", "crouch"} & {*db.learned.known_words}
    answer = db.search("a deep squat", limit=200)
    assert answer.measured == ("squat", "deep")
    free = [match for match in answer.matches if not match.contradicted]
    shown = {i.name for i in db.captures() if find_occurrences(track_of(db, i.name), "squat")}
    assert shown == {match.capture for match in free} != set()
    assert amounts(answer) == sorted(amounts(answer), reverse=True)
    assert {match.probability for match in answer.matches} == {None}
    twice = db.search("squat twice", limit=200)
    for match in twice.matches:
        if not match.contradicted:
            assert len(find_occurrences(track_of(db, match.capture), "squat")) >= 2
    ordered = db.search("walk, then squat", limit=5).matches[0]
    assert ordered.capture in shown
    assert ordered.parts[0].end <= ordered.parts[1].start
    without = db.search("squat without stopping", limit=200)
    assert without.not_used == ()
    free = [match for match in without.matches if not match.contradicted]
    assert free
    assert {match.capture for match in free} <= shown
    lasting = db.search("squat for 3 seconds", limit=3)
    assert "how long it lasts is not measured" in {part.reason for part in lasting.not_used}


def test_how_many_captures_were_looked_at_is_told(
    db: motiondb.MotionDB, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert db.search("squat").looked_at == 0
    monkeypatch.setattr(by_words, "SEEN_ALONE", 40)
    answer = db.search("squat")
    assert answer.looked_at == 40
    assert "looked at the motion of 40 captures, not of all" in answer.remarks
    assert db.search("walk").looked_at == 0


def test_kicks_go_where_they_are_asked_to_go(db: motiondb.MotionDB) -> None:
    """Those of the sample data go ahead of the body, whatever their heading is."""
    kicks = {info.name for info in db.captures() if "kick_1" in info.name}
    against = dict[str, dict[str, tuple[str, ...]]]()
    for way in ("forward", "left", "right"):
        answer = db.search(f"kick {'to the ' * (way != 'forward')}{way}", limit=100)
        assert answer.left == ()
        against[way] = {match.capture: match.contradicted for match in answer.matches}
    assert {against["forward"][name] for name in kicks} == {()}
    for name in kicks:
        assert against["left"][name] or against["right"][name]
    assert {against["left"][name] for name in kicks} <= {(), ("does not kick left",)}


def test_what_an_event_alone_does_not_say_is_told(db: motiondb.MotionDB) -> None:
    answer = db.search("squat over a puddle", limit=3)
    assert [part.text for part in answer.not_used] == ["puddle"]
    assert answer.left == ("over",)
    answer = db.search("a slow squat while walking", limit=3)
    assert [part.text for part in answer.not_used] == ["slow"]


def test_a_walk_after_another_action_begins_behind_it() -> None:
    seen: Any = SeenFrames(*[None] * 3)  # type: ignore[arg-type]
    seen.__dict__["events"] = {"walk": [(0, 90)], "jump": [(36, 60)]}.get
    part: Any = None
    room = slice(20, 45)
    assert _found(seen, "walk", part, ("walk",), room) == [(FEATURE_STEP * 20, 90)]
    assert _found(seen, "jump", part, ("jump",), room) == [(36, 60)]  # its middle is inside
