"""Clips of the shipped basketball grammar from the sample data, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.database.scenes.scene_making import SceneClips, find_actions, scene_clips
from motiondb.database.scenes.scene_texts import read_grammar
from motiondb.errors import SceneError
from motiondb.records import Caption, Event
from motiondb.scene.clips.clip_cutting import (
    ShownMotion,
    body_frames,
    farthest_up,
    instant,
    throw_frames,
)
from motiondb.scene.clips.clips import VariantSettings
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar

_INSTANTS = {"pass": "release", "shoot": "release", "layup": "release", "catch": "catch",
             "screen": "contact", "push": "contact", "block": "contact"}  # fmt: skip
FEW = VariantSettings(bends=(0.0,), stretches=(1.0,), rest_bends=(0.0,), turns=(0.0,))


@pytest.fixture(scope="module")
def clips(db: motiondb.MotionDB) -> SceneClips:
    return scene_clips(db.session, read_grammar("basketball"))


def test_every_terminal_has_entries_with_licences(clips: SceneClips) -> None:
    library = clips.library
    assert len(library.terminals) == 17
    assert np.diff(library.first).min() >= 10
    assert {source.licence for source in library.source} == {"CC0-1.0"}
    assert {source.capture for source in library.source} == set(clips.motions)
    ends = [clips.motions[source.capture].n_frames for source in library.source]
    assert all(source.end <= end for source, end in zip(library.source, ends))


def test_instants_are_those_of_the_events(db: motiondb.MotionDB, clips: SceneClips) -> None:
    library = clips.library
    seen = {
        capture: {(e.frame, e.name) for e in db.captures.events(capture)}
        for capture in clips.motions
    }
    for name, event in _INSTANTS.items():
        for k in library.of(name):
            source = library.source[k]
            assert source.instant == "events"
            assert (source.start + int(library.event_frame[k]), event) in seen[source.capture]
    assert {library.source[k].instant for k in library.of("run")} == {""}


def test_steps_are_cut_at_foot_strikes(db: motiondb.MotionDB, clips: SceneClips) -> None:
    library = clips.library
    runs = [library.source[k] for k in library.of("run")]
    strikes = {
        (capture, e.frame)
        for capture in {run.capture for run in runs}
        for e in db.captures.events(capture)
        if e.name == "foot_strike"
    }
    for run in runs:
        assert {(run.capture, run.start), (run.capture, run.end)} & strikes, run
    steps = np.hypot(*library.step[list(library.of("run")), :2].T)
    assert 0.7 < np.median(steps) < 2.0
    dribbles = np.hypot(*library.step[list(library.of("dribble")), :2].T)
    assert (dribbles < 0.1).any()
    assert (dribbles > 0.5).any()


def test_shots_go_up_and_pivots_turn(clips: SceneClips) -> None:
    library = clips.library
    assert library.hand[list(library.of("shoot")), 1].min() > 1.6
    assert np.degrees(library.step[list(library.of("pivot_left")), 2]).min() > 45.0
    assert np.degrees(library.step[list(library.of("pivot_right")), 2]).max() < -45.0


def test_of_many_captures_few_are_looked_at(db: motiondb.MotionDB) -> None:
    """Two of the 20 walks are cut, the first and the last, and one of them is enough."""
    grammar = read_motion_grammar('start S\nS -> walk\nwalk := "walk"\n', "g")
    clips = scene_clips(db.session, grammar, replace(FEW, most=2))
    assert len(clips.motions) == 1
    assert len(clips.library.of("walk")) > 2


def test_a_library_is_kept_until_something_changes(
    db: motiondb.MotionDB, clips: SceneClips
) -> None:
    assert scene_clips(db.session, read_grammar("basketball")) is clips
    few = scene_clips(db.session, read_grammar("basketball"), FEW)
    assert few is not clips
    assert len(few.library.source) < len(clips.library.source)


def test_other_events_make_another_library(learned_copy: Path) -> None:
    grammar = read_motion_grammar('start S\nS -> shoot\nshoot := "jump shot" event release\n', "g")
    with motiondb.open(learned_copy) as db:
        first = scene_clips(db.session, grammar, FEW)
        source = first.library.source[0]
        number = store.load_capture(db.store, source.capture).capture_id
        frame = source.start + 10
        store.save_events(db.store, number, [Event(frame, "release")])
        second = scene_clips(db.session, grammar, FEW)
        assert second is not first
        assert frame in instants(second, source.capture)
        store.save_events(db.store, number, [])
        third = scene_clips(db.session, grammar, FEW)
        kinds = {s.instant for s in third.library.source if s.capture == source.capture}
        assert kinds == {"wrists"}


def instants(clips: SceneClips, capture: str) -> set[int]:
    """The frames of a capture at which its entries have their instants."""
    library = clips.library
    return {
        source.start + int(event)
        for source, event in zip(library.source, library.event_frame)
        if source.capture == capture
    }


def test_a_terminal_without_clips_is_named_with_its_phrases(db: motiondb.MotionDB) -> None:
    text = (
        'grammar odd\nstart S\nS -> a | b | c\na := "walk"\n'
        'b := "yodel", "throw up" without "ball"\nc := "moonwalk"\n'
    )
    with pytest.raises(SceneError) as error:
        scene_clips(db.session, read_motion_grammar(text, "odd.grammar"))
    assert str(error.value) == (
        "odd: expected captures for every terminal, found none for 2 terminals: b ('yodel',"
        " 'throw up' without 'ball'); c ('moonwalk'). Add captures whose words say so, one action"
        " a caption (motiondb words set CAPTURE), or change the phrases in the grammar's file."
    )


def test_the_wrists_alone_tell_instants_to_a_few_frames(clips: SceneClips) -> None:
    """Against the truth of the sample data; screens, which no hand shows, are left out."""
    library, errors = clips.library, []
    for name in ("pass", "shoot", "layup", "catch", "block", "push"):
        for k in library.of(name):
            source = library.source[k]
            if source.edit:
                continue
            motion, event = clips.motions[source.capture], _INSTANTS[name]
            bare = ShownMotion(name, source.capture, motion, source.start, source.end, event)
            frame, known = instant(bare, body_frames(motion), source.start, source.end)
            assert known == "wrists"
            errors.append(abs(frame - source.start - int(library.event_frame[k])))
    assert len(errors) > 30
    assert np.median(errors) <= 2
    assert max(errors) <= 4


@pytest.mark.parametrize(
    ("capture", "dribble", "throw", "end"),
    [
        ("chidi/long_8", 79, 173, 245),
        ("chidi/long_play_1", 360, 431, 485),
        ("goran/long_7", 300, 398, 456),
    ],
)
def test_hands_tell_a_throw_from_the_dribble_before(
    db: motiondb.MotionDB, capture: str, dribble: int, throw: int, end: int
) -> None:
    """Frames of the sample data's truth: a lay-up and two shots, each behind a dribble."""
    number = store.load_capture(db.store, capture).capture_id
    frames = body_frames(store.load_motion(db.store, number))
    release = [
        e.frame for e in db.captures.events(capture) if e.name == "release" and e.frame < end
    ]
    assert abs(farthest_up(frames, dribble, end) - release[-1]) <= 2
    first, last = throw_frames(frames, dribble, end)
    assert abs(first - throw) <= 8
    assert abs(last - end) <= 12


DRIBBLE_AND_SHOOT = """start S
S -> dribble* shoot
dribble := "dribble"
shoot := "shoot", "jump shot" without "fake" event release
"""


def test_a_caption_of_several_actions_with_a_throw(learned_copy: Path) -> None:
    told = {
        "basketball - dribble, shoot": {"dribble": "before", "shoot": "throw"},
        "crossover dribble, dribble, a jump shot": {"dribble": "before", "shoot": "throw"},
        "shoot, dribble": {"shoot": "throw"},
        "shoot": {"shoot": ""},
        "dribble, fake shot, shoot": {},  # hands do the same twice
        "dribble, shoot, dribble, shoot": {},
        "dribble, sing, shoot": {},  # nobody knows what hands do in a song
    }
    grammar = read_motion_grammar(DRIBBLE_AND_SHOOT, "g")
    with motiondb.open(learned_copy) as db:
        number = store.load_capture(db.store, "goran/shoot_1").capture_id
        for words, shown in told.items():
            store.save_captions(db.store, number, [Caption(words)])
            assert stretches(db, grammar) == shown, words
        timed = [Caption("dribble, shoot"), Caption("shoot", 0.5, 2.0)]
        store.save_captions(db.store, number, timed)
        assert stretches(db, grammar) == {"shoot": ""}


def stretches(db: motiondb.MotionDB, grammar: MotionGrammar) -> dict[str, str]:
    """Of each action that a capture shows, which stretch of it."""
    return {
        name: part.stretch
        for name, parts in find_actions(db.session, grammar).parts.items()
        for part in parts
        if part.capture == "goran/shoot_1"
    }
