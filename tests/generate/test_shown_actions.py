"""Verdicts on motion: shown, not shown or not sure, and what they rest on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import motiondb
from motiondb.generate.sentence_plan import PlannedAction
from motiondb.generate.shown_actions import MEASURED, NOT_SHOWN, SHOWN, Asked, judge_motion
from motiondb.language.question.tree import NotUsed
from motiondb.meaning.occurrences import find_occurrences, measured_track
from motiondb.records import Motion


@pytest.fixture(scope="module")
def walk(db: motiondb.MotionDB) -> Motion:
    return db.motion("ana/walk_1")


def _asked(motion: Motion, words: str, *directions: str) -> Asked:
    action = PlannedAction((tuple(words.split()),))
    return Asked(action, 0, motion.n_frames, directions=directions)


def test_a_measured_direction_needs_no_judge_and_the_rest_does(
    db: motiondb.MotionDB, walk: Motion
) -> None:
    walks = judge_motion(db.learned, walk, [_asked(walk, "walk forward", "forward")], [])[0]
    assert (walks.shown, walks.reason) == (True, "walk by its looks, forward is measured")
    assert walks.probability >= SHOWN
    alone = judge_motion(db.learned, walk, [_asked(walk, "walk")], [])[0]
    assert walks.probability == pytest.approx(alone.probability)
    kicks = judge_motion(db.learned, walk, [_asked(walk, "kick forward", "forward")], [])[0]
    assert kicks.shown is False
    assert kicks.probability < NOT_SHOWN


def test_what_is_not_done_is_not_shown(db: motiondb.MotionDB, walk: Motion) -> None:
    back = judge_motion(db.learned, walk, [_asked(walk, "walk backward", "backward")], [])[0]
    assert (back.shown, back.reason) == (False, "it does not go backward")
    assert back.probability is None  # that of "walk" alone says nothing about it


def test_a_turn_to_a_side_is_measured_alone(db: motiondb.MotionDB) -> None:
    motion = db.motion("ana/turn_left_1")
    turned = judge_motion(db.learned, motion, [_asked(motion, "turn left", "turn left")], [])[0]
    assert (turned.shown, turned.probability) == (True, None)
    assert turned.reason == "turn left is measured"


def test_a_measured_direction_is_not_denied_and_a_small_one_is_not_shown(
    db: motiondb.MotionDB, walk: Motion
) -> None:
    denied = judge_motion(db.learned, walk, [_asked(walk, "run")], [])[0]
    unsure = judge_motion(db.learned, walk, [_asked(walk, "run forward", "forward")], [])[0]
    assert (denied.shown, unsure.shown) == (False, None)
    hardly = judge_motion(db.learned, walk, [_asked(walk, "walk both hand", "both hand")], [])[0]
    assert (hardly.shown, hardly.reason) == (True, "walk by its looks, both hands is measured")
    short = replace(_asked(walk, "walk forward", "forward"), end=37)
    part = judge_motion(db.learned, walk, [short], [])[0]
    assert part.shown is None


def test_what_is_hardly_done_is_not_sure_and_has_no_probability(db: motiondb.MotionDB) -> None:
    motion = db.motion("boris/turn_left_1")
    asked = replace(_asked(motion, "turn around", "turn around"), start=36, end=111)
    turned = judge_motion(db.learned, motion, [asked], [])[0]
    assert (turned.shown, turned.probability) == (None, None)
    assert turned.reason == "turn around only a little, as measured"


def test_an_excluded_direction_is_measured(db: motiondb.MotionDB, walk: Motion) -> None:
    asked = _asked(walk, "walk")
    for excluded, shown in (("forward", False), ("backward", True), ("turn", True)):
        action = replace(asked.action, excluded=((excluded,),))
        answer = judge_motion(db.learned, walk, [replace(asked, action=action)], [])[0]
        assert answer.shown is shown
        assert (answer.reason == f"{excluded} is measured, not wanted") is not shown


def test_a_measured_action_is_never_denied_for_its_looks(db: motiondb.MotionDB) -> None:
    motion = db.motion("ana/jump_1")
    asked = _asked(motion, "jump", "jump")
    jumps = judge_motion(db.learned, motion, [asked], [])[0]
    assert jumps.reason.endswith("jump is measured")
    assert jumps.shown is (None if (jumps.probability or 1.0) < MEASURED else True)
    less = replace(asked, not_done=(NotUsed("3 times", "found 1"),))
    unsure = judge_motion(db.learned, motion, [less], [])[0]
    assert (unsure.shown, unsure.reason) == (None, "'3 times' is not met: found 1")


def test_frames_that_a_seam_bends_do_not_take_back_what_was_done(db: motiondb.MotionDB) -> None:
    """Who went down and is lifted in the half second of the seam has gone down."""
    motion = db.motion("ana/sit_down_1")
    lifted = motion.root_positions.copy()
    lifted[-15:, 1] = motion.root_positions[0, 1]
    after = replace(
        motion,
        local_rotations=np.concatenate([motion.local_rotations] * 2),
        root_positions=np.concatenate([lifted, lifted]),
    )
    asked = _asked(motion, "go down", "down")
    bent = np.zeros(after.n_frames, dtype=bool)
    denied = judge_motion(db.learned, after, [asked], [])[0]
    assert (denied.shown, denied.reason) == (False, "it does not go down")
    bent[motion.n_frames - 15 : motion.n_frames + 15] = True
    assert judge_motion(db.learned, after, [asked], [], bent)[0].shown is not False


def test_who_sits_down_on_a_high_stool_sits_down(db: motiondb.MotionDB) -> None:
    """Hardly lower than before; thighs that become level tell it."""
    motion = db.motion("ana/sit_down_1")
    high = motion.root_positions.copy()
    high[:, 1] = high[0, 1]
    lifted = replace(motion, root_positions=high)
    sat, gone = (_asked(motion, words, "down") for words in ("sit down", "go down"))
    assert judge_motion(db.learned, lifted, [sat], [])[0].shown is not False
    assert judge_motion(db.learned, lifted, [gone], [])[0].shown is False


def test_a_measured_turn_needs_no_looks(db: motiondb.MotionDB) -> None:
    motion = db.motion("ana/turn_left_1")
    turned = judge_motion(db.learned, motion, [_asked(motion, "turn", "turn")], [])[0]
    assert (turned.shown, turned.probability, turned.reason) == (True, None, "turn is measured")


def test_words_that_no_other_capture_says_together_are_not_denied(
    db: motiondb.MotionDB, walk: Motion
) -> None:
    said: dict[int, set[str]] = {}
    for described in db.learned.described:
        said.setdefault(described.capture_id, set()).update(described.words)
    beside = set().union(*(words for words in said.values() if "kick" in words))
    other = min(set().union(*said.values()) - beside)
    alone = judge_motion(db.learned, walk, [_asked(walk, "kick")], [])[0]
    both = judge_motion(db.learned, walk, [_asked(walk, f"kick {other}")], [])[0]
    assert alone.shown is False
    assert both.shown is None
    assert both.probability < NOT_SHOWN


@pytest.mark.parametrize(
    ("sentence", "number", "posture"),
    [
        ("walk, then raise the left hand", 1, "raise left"),
        ("stand still for 2 seconds, then walk", 0, "still"),
        ("jump with the hands above the head", 0, "overhead"),
        ("wave while standing", 0, "stand"),
    ],
)
def test_postures_are_made_from_where_they_are_seen(
    db: motiondb.MotionDB, sentence: str, number: int, posture: str
) -> None:
    """Whatever captions say; each is measured again here, in its part of the motion."""
    made = db.generate(sentence, seed=0)
    part = made.shown[number]
    assert part.shown
    held = find_occurrences(measured_track(made.motion), posture)
    assert sum(max(min(b, part.end) - max(a, part.start), 0) for a, b in held) >= 15


def test_an_event_that_no_caption_says_is_made_from_where_it_is_seen(
    db: motiondb.MotionDB,
) -> None:
    assert "squat" not in db.learned.known_words
    made = db.generate("walk, then squat twice", seed=0)
    part = made.shown[1]
    assert (part.words, part.shown, part.reason) == (("squat",), True, "squat is measured")
    squats = find_occurrences(measured_track(made.motion), "squat")
    assert sum(part.start <= (a + b) / 2 < part.end for a, b in squats) == 2
    with pytest.raises(motiondb.UnknownWordsError, match="cartwheel"):
        db.generate("cartwheel")


def test_a_posture_is_counted_and_timed_in_the_made_motion(db: motiondb.MotionDB) -> None:
    made = db.generate("stand still for 9 seconds", seed=0)
    held = find_occurrences(measured_track(made.motion), "still")
    longest = max((end - start) / 30 for start, end in held)
    is_met = longest >= 9.0 - 0.6  # which a seam may bend
    assert (made.shown[0].shown is True) == is_met
    twice = db.generate("raise both hands three times", seed=0)
    n = len(find_occurrences(measured_track(twice.motion), "raise both"))
    assert (twice.shown[0].shown is True) == (n == 3)


def test_a_posture_that_nobody_takes_is_not_made(db: motiondb.MotionDB) -> None:
    with pytest.raises(motiondb.UnknownWordsError, match="kneel"):
        db.generate("kneel")
    rest = db.generate("kneel, then walk", anyway=True, seed=0)
    assert [(one.words, one.shown) for one in rest.shown] == [
        (("walk",), True),
        (("kneel",), False),
    ]
    walk = db.generate("walk with both arms up", seed=0)
    assert walk.shown[0].shown is False
    assert walk.shown[0].reason == "it does not raise both hands"
