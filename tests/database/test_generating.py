"""Generated motion: what is honoured, what it is said to show, and what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb import MotionDB
from motiondb.errors import QueryError
from motiondb.meaning.occurrences import find_occurrences, measured_track
from motiondb.records import MOTION_FPS


def test_every_asked_action_is_said_to_be_shown_or_not(db: MotionDB) -> None:
    made = db.generate("walk, then kick", seed=7)
    assert [one.words for one in made.shown] == [("walk",), ("kick",)]
    assert [one.shown for one in made.shown] == [True, True]
    assert made.shows_all
    assert made.facts().shown
    assert made.spans[-1][1] == made.motion.n_frames
    for one in made.shown:
        assert one.probability is not None
        assert {word for word, _ in one.described} & {*one.words}


def test_a_changed_motion_is_judged_and_told_as_it_is_written(db: MotionDB, tmp_path: Path) -> None:
    asked = motiondb.MotionChanges(mirror=True, fps=24.0)
    (made,) = db.generate_variants("a person turns left", 1, changes=asked)
    assert (made.shown[0].shown, made.shown[0].reason) == (False, "it does not turn left")
    assert not made.shown[0].done[0].endswith("measured in the motion")
    facts = made.write(tmp_path / "a.bvh", asked.of_file)
    assert facts.changes[0] == "mirrored: left and right are exchanged"
    told = json.loads((tmp_path / "a.bvh.provenance.json").read_text())
    assert told["fps"] == 24.0
    count = round(made.motion.n_frames / MOTION_FPS * 24.0)
    ends = [(run["start"], run["end"]) for run in told["frames"]]
    assert [ends[0][0], *(end for _, end in ends)] == [*(start for start, _ in ends), count]
    assert told["frames"][0]["source_step"] == 1.25
    assert "mirror" in told["frames"][0]["edit"]
    asked = motiondb.MotionChanges(loop=True)
    (made,) = db.generate_variants("a person walks then kicks", 1, changes=asked)
    walk, kick = made.shown
    assert (walk.shown, walk.end) == (True, made.motion.n_frames)
    assert (kick.shown, kick.reason) == (False, "the cycle that was cut out does not hold it")
    with pytest.raises(QueryError, match="nothing would use it"):
        made.write(tmp_path / "b.bvh", motiondb.MotionChanges(joint_map={"l_hip": "LeftUpLeg"}))


def test_the_judge_never_sees_the_captures_used(db: MotionDB) -> None:
    """Of a word that one capture alone shows, nothing can be confirmed."""
    learned = db.learned
    said: dict[int, set[str]] = {}
    for d in learned.described:
        said.setdefault(d.capture_id, set()).update(d.words)
    lonely = [
        word for word in learned.known_words
        if sum(word in words for words in said.values()) == 1 and not word.endswith("ly")
    ]  # fmt: skip
    told = []
    for word in lonely[:3]:
        try:
            made = db.generate(word, seed=0, exact=True)
        except QueryError:
            continue
        told += [one for one in made.shown if one.words == (word,)]
    assert told
    for one in told:
        assert one.shown is not True
        assert one.reason


def test_counts_and_durations_are_honoured(db: MotionDB) -> None:
    for number, word in ((1, "once"), (3, "three times")):
        made = db.generate(f"jump {word}")
        assert len(find_occurrences(measured_track(made.motion), "jump")) == number
        assert made.not_used == ()
    assert "3 times" in " ".join(made.shown[0].done)
    long = db.generate("walk for ten seconds", seed=3)
    assert long.motion.n_frames / MOTION_FPS == pytest.approx(10.0, rel=0.1) or long.not_used
    slowed = db.generate("bow for three seconds", seed=1)
    assert slowed.motion.n_frames / MOTION_FPS == pytest.approx(3.0, rel=0.1)
    assert slowed.not_used == ()
    assert "of its speed, so that it lasts" in " ".join(slowed.shown[0].done)
    assert slowed.shown[0].shown
    kick = db.generate("kick for three seconds", seed=1)  # a slow kick is none
    assert "of its speed" not in " ".join(kick.shown[0].done)
    assert db.generate("walk for at most 0 s").not_used
    least = db.generate("kick for at least seven seconds")
    assert least.motion.n_frames / MOTION_FPS >= 7.0 or least.not_used


def test_slow_and_fast_walks_differ_in_speed(db: MotionDB) -> None:
    speeds = {}
    for manner in ("slowly", "fast"):
        made = db.generate(f"walk {manner}", seed=3)
        assert any(line.startswith(manner) for line in made.shown[0].done), made.not_used
        steps = np.diff(made.motion.joint_positions(), axis=0)
        speeds[manner] = float(np.linalg.norm(steps, axis=-1).mean())
    assert speeds["slowly"] < speeds["fast"]


def test_variants_come_from_other_captures(db: MotionDB) -> None:
    made = db.generate_variants("kick", 3, seed=1)
    first = db.generate("kick", seed=1)
    np.testing.assert_array_equal(made[0].motion.local_rotations, first.motion.local_rotations)
    sources = [frozenset(s.name for s in one.provenance.sources) for one in made]
    assert len(set(sources)) == 3
    with pytest.raises(QueryError, match="expected 1 for trajectory, which is one motion"):
        db.generate_variants("kick", 2, method="trajectory")
    with pytest.raises(QueryError, match="variants: expected 1 to 100, found 0"):
        db.generate_variants("kick", 0)


def test_there_are_no_more_variants_than_places(db: MotionDB) -> None:
    made = db.generate_variants("throw", 3)
    assert len(made) == 1
    assert made[0].took_all_places
    assert made[0].shown[0].done[-1] == ("only one good excerpt, so --seed changes nothing here")
    kicks = db.generate_variants("kick", 8)
    assert (
        kicks[0].shown[0].done[-1]
        == f"{len(kicks)} similar excerpts found; this is number 1. --seed picks others"
    )
    places = {(s.name, kick.shown[0].done[0]) for kick in kicks for s in kick.provenance.sources}
    assert 1 < len(kicks) < 8
    assert len(places) == len(kicks)


def test_actions_come_from_the_places_that_were_asked_for(db: MotionDB) -> None:
    picked = motiondb.ActionPlace(capture="fatou/kick_1", start=0.2, end=1.6)
    first, other = (
        db.generate("kick, then walk", places=[picked, motiondb.ActionPlace(n)]) for n in (0, 1)
    )
    for made in (first, other):
        kick, _ = made.facts().shown_actions
        assert kick.done == ("fatou/kick_1 0.2-1.6 s", "the excerpt that was picked")
        assert made.places[0][0] == -1
    assert first.places[1] != other.places[1]
    walk = motiondb.ActionPlace(capture="boris/walk_1", start=0.0, end=2.5)
    not_kicked, _ = db.generate("kick, then walk", places=[walk, motiondb.ActionPlace()]).shown
    assert not_kicked.shown is not True  # judged by its motion, whoever picked it
    for words in ("walk, then cartwheel", "cartwheel, then walk", "walk, then kick while clapping"):
        at = motiondb.ActionPlace(), picked
        unsaid = db.generate(words, places=at if words.startswith("walk") else at[::-1])
        strange = next(one for one in unsaid.shown if one.words != ("walk",))
        assert strange.shown is None  # no caption says it, so nothing can confirm it
        assert strange.done == ("fatou/kick_1 0.2-1.6 s", "the excerpt that was picked")
    with pytest.raises(QueryError, match="expected one for each of 1 stitched actions"):
        db.generate("walk", places=[motiondb.ActionPlace()] * 2)
    with pytest.raises(QueryError, match=r"at least 0\.5 s within 0 to"):
        db.generate("walk", places=[motiondb.ActionPlace(capture="boris/walk_1", end=99.0)])
    wrong = motiondb.ActionPlace(capture="boris/walk_1", start=math.inf, end=2.5)
    with pytest.raises(QueryError, match=r"boris/walk_1: .* found inf to 2\.5 s"):
        db.generate("walk", places=[wrong])
    last = first.places[1][1] - 1
    for place in (last + 1, -1):
        told = rf"places: expected a number from 0 to {last} for action 2 \(walk\), found {place}\."
        with pytest.raises(QueryError, match=told):
            db.generate("kick, then walk", places=[picked, motiondb.ActionPlace(place)])


def test_variants_of_alternatives_show_each_of_them(db: MotionDB) -> None:
    """One place shows "throw", so its first motion must not be the last one."""
    made = db.generate_variants("throw or kick", 3)
    assert len(made) == 3
    assert {one.actions for one in made} == {(("throw",),), (("kick",),)}


def test_what_nothing_shows_is_refused_or_made_without(db: MotionDB) -> None:
    with pytest.raises(QueryError) as error:
        db.generate("walk, then moonwlak", exact=True)
    assert str(error.value).startswith(
        "generate: expected actions that are in the captions, found 'moonwlak', which nothing in "
        "the database shows. "
    )
    assert "--anyway" in str(error.value)
    made = db.generate("walk, then moonwlak", exact=True, anyway=True)
    assert [(one.words, one.shown) for one in made.shown] == [
        (("walk",), True), (("moonwlak",), False)
    ]  # fmt: skip
    assert not made.shows_all


def test_a_direction_alone_makes_no_motion_of_an_unknown_action(db: MotionDB) -> None:
    with pytest.raises(QueryError, match="found 'strafe left', which nothing in the database"):
        db.generate("strafe left", exact=True)


def test_an_action_that_lost_its_verb_is_made_but_not_shown(db: MotionDB) -> None:
    made = db.generate("swim with a ball", exact=True)
    assert made.actions == (("ball",),)
    lost = made.shown[-1]
    assert (lost.words, lost.shown) == (("swim",), False)
    assert lost.reason == "it was not made: not in the captions"
    assert not made.shows_all
    assert [one.words for one in db.generate("kick the ball", exact=True).shown][1:] == []
    assert [one.words for one in db.generate("swim with a ball, or kick", exact=True).shown][
        1:
    ] == []


def test_the_nearest_known_word_is_made_anyway_and_shows_nothing(db: MotionDB) -> None:
    with pytest.raises(QueryError, match=r"found 'wlak'\. Perhaps walk\."):
        db.generate("wlak")
    made = db.generate("wlak", anyway=True)
    assert [(one.words, one.shown) for one in made.shown] == [
        (("walk",), True), (("wlak",), False)
    ]  # fmt: skip
    assert made.shown[1].reason == (
        "not in the captions; 'walk', the nearest known word, was made instead"
    )
    assert not made.shows_all
    with pytest.raises(QueryError, match="in the captions, found 'zzzzzzzzzz'"):
        db.generate("zzzzzzzzzz", anyway=True)


def test_actions_never_said_together_are_refused(db: MotionDB) -> None:
    with pytest.raises(QueryError, match="Each by itself is known: bow, layup"):
        db.generate("bow while layup")
    assert db.generate("bow while layup", anyway=True).motion.n_frames > 30


def test_the_side_of_a_limb_that_no_caption_says_is_measured(db: MotionDB) -> None:
    """Captions have a kick and, in another action, a left turn, but no left foot."""
    made = db.generate("kick with the left foot")
    assert made.actions == (("kick",),)
    assert not made.not_used
    assert "left foot: measured in the motion" in made.shown[0].done


def test_sides_are_found_by_measurement_whatever_captions_say(db: MotionDB) -> None:
    """Captions that say "wave" and "hand" wave the right one; none jumps to the left."""
    (wave,) = db.generate("wave with the left hand").shown
    assert (wave.words, wave.shown) == (("wave", "left", "hand"), True)
    (jump,) = db.generate("jump to the left").shown
    assert "jump: measured in the motion" in jump.done
    assert (jump.words, jump.shown, jump.probability) == (("jump", "left"), False, None)


def test_only_the_action_of_a_replaced_word_says_so(db: MotionDB) -> None:
    moonwalk, walk = db.generate("moonwalk, then walk").shown
    assert (moonwalk.words, moonwalk.shown) == (("walk (for moonwalk)",), None)
    assert (walk.words, walk.shown) == (("walk",), True)


def test_a_direction_that_no_motion_goes_in_is_not_shown(db: MotionDB) -> None:
    """No caption says them; for once the words are not left out, but measured."""
    for sentence, reason in (
        ("run backwards", "it does not go backward"),
        ("walk in place", "it does not stay in place"),
    ):
        (run,) = db.generate(sentence).shown
        assert (run.shown, run.reason) == (False, reason)


def test_the_verb_of_an_action_is_kept_before_other_words(db: MotionDB) -> None:
    """No caption throws to the left or throws a ball; one has "pivot left" and a ball."""
    made = db.generate("throw a ball to the left", seed=0, anyway=True)
    assert "throw" in made.actions[0]


def test_words_with_one_meaning_are_asked_for_once(db: MotionDB) -> None:
    made = db.generate("walk on tiptoes", seed=0)  # taken as walk
    assert made.actions == (("walk",),)
    assert made.question.understood == "walk"


def test_directions_are_measured_in_the_motion(db: MotionDB) -> None:
    for words, sign in (("sit down", -1), ("stand up", 1)):
        made = db.generate(words)
        start, end = made.spans[0]
        height = made.motion.root_positions[start:end, 1]
        assert np.sign(height[-5:].mean() - height[:5].mean()) == sign


def test_the_command_ends_with_1_where_an_action_is_missing(
    command: Any, learned_file: Path
) -> None:
    common = ("-o", "new.bvh", "--db", learned_file)
    ended = command("generate", "walk, then moonwlak", "--exact", "--anyway", "--json", *common)
    assert ended.code == 1
    told = json.loads(ended.out)
    assert told["shown"] is False
    assert [one["shown"] for one in told["shown_actions"]] == [True, False]
    told = command("generate", "throw", "--variants", "3", *common).out
    assert told.endswith("1 of 3 written: no other excerpt shows this about as clearly\n")
    assert Path("new-1.bvh.provenance.json").exists()
