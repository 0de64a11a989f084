"""What players play: clips cut short, pauses between them, steps into rest, all worked by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.context_free import Tree
from motiondb.scene.clips.clips import ClipLibrary, ClipSource
from motiondb.scene.energy.scene_arrays import PlayerState
from motiondb.scene.language.activity import GIVE, KEEP, Activity, Rest
from motiondb.scene.polish.splicing import Spliced
from motiondb.scene.timing.playing import (
    Pause,
    kept_frames,
    lead_in,
    lead_out,
    least_lengths,
    may_pause,
    pause_entry,
    play,
)
from motiondb.scene.timing.scheduling import SHORTEST_PAUSE, SLOWEST, Meeting, Strings, schedule

NAMES = ("run", "hold", "pass", "idle")
LENGTHS = (20, 10, 100, 40, 30)
"""Frames of a run in full flow, of a step into rest, of holding, of a pass, of idling."""

RESTS = Activity(
    deeds=(("hold", KEEP, ""), ("pass", GIVE, "")),
    rests=(Rest("idle"), Rest("hold", with_object=True)),
)


def library() -> ClipLibrary:
    terminal = np.array([0, 0, 1, 2, 3])
    rest = np.array([[2.0, 2.0], [2.0, 0.1], [0.0, 0.0], [0.1, 0.1], [0.0, 0.0]])
    step = np.zeros((5, 3))
    step[:2, 1] = (1.0, 0.4)
    return ClipLibrary(
        NAMES,
        terminal.astype(np.int32),
        np.array([0, 2, 3, 4, 5], dtype=np.int32),
        np.array(LENGTHS, dtype=np.int32),
        step,
        np.array([-1, -1, -1, 25, -1], dtype=np.int32),
        np.concatenate([[0], np.cumsum(LENGTHS)[:-1]]).astype(np.int32),
        np.zeros((sum(LENGTHS), 3)),
        np.full((5, 5), 0.5, dtype=np.float32),
        np.arange(5, dtype=np.int32),
        np.zeros((5, 3)),
        tuple(ClipSource(f"clip{k}", 100, 100 + n) for k, n in enumerate(LENGTHS)),
        rest=rest.astype(np.float32),
    )


def player(*entries: int) -> PlayerState:
    return PlayerState(Tree("a"), np.array(entries), (0.0, 0.0, 0.0))


def test_a_string_is_played_end_to_end() -> None:
    out = play(player(2, 3, 0), library())
    assert out.begins.tolist() == [0, 100, 140, 160]
    assert out.ends.tolist() == [100, 140, 160]
    assert out.instants.tolist() == [49, 125, 149]
    assert out.rows.tolist() == list(range(160))
    assert out.pauses == ()


def test_cuts_and_pauses_move_what_is_behind_them() -> None:
    pause = Pause(1, ClipSource("clip4", 100, 130), 12)
    out = play(player(2, 3, 0), library(), (15, 40, 20), (pause,))
    assert out.begins.tolist() == [0, 15, 67, 87]
    assert out.ends.tolist() == [15, 55, 87]
    assert out.instants[1] == 15 + 25
    assert out.rows[:15].tolist() == list(range(85, 100))  # the first clip lost its beginning
    assert out.rows[55:67].tolist() == [139] * 12
    assert out.pauses == ((55, 67),)
    assert [part.clip for part in out.parts] == [0, 1, 1, 2]
    assert out.knots.tolist() == [0, 15, 55, 67, 87]


def test_the_middle_of_a_clip_between_others_is_left_out() -> None:
    out = play(player(0, 2, 3), library(), (20, 15, 40))
    assert [(part.source.start, part.source.end) for part in out.parts[1:3]] == [
        (100, 108),
        (193, 200),
    ]
    assert out.rows[20:35].tolist() == [*range(20, 28), *range(113, 120)]


@settings(max_examples=50, deadline=None)
@given(st.integers(2, 200), st.data(), st.booleans(), st.booleans())
def test_as_many_frames_are_kept_as_are_asked(
    whole: int, data: st.DataObject, first: bool, last: bool
) -> None:
    length = data.draw(st.integers(2, whole))
    kept = kept_frames(whole, length, first, last)
    frames = [f for start, end in kept for f in range(start, end)]
    assert len(frames) == length == len(set(frames))
    assert min(frames) >= 0
    assert max(frames) < whole


def test_only_standing_may_be_cut_and_only_rest_may_pause() -> None:
    entries = np.array([2, 3, 0, 1, 4])
    assert least_lengths(library(), entries, RESTS).tolist() == [15, 40, 20, 10, 15]
    assert may_pause(library(), entries, RESTS).tolist() == [1, 0, 0, 1, 0]


def test_a_clip_of_standing_with_an_event_stays_whole() -> None:
    touched = replace(library(), event_frame=np.array([-1, -1, 90, 25, -1], dtype=np.int32))
    assert least_lengths(touched, np.array([2, 4]), RESTS).tolist() == [100, 15]


def test_nobody_pauses_where_there_is_nothing_to_stand_in() -> None:
    bare = replace(library(), terminals=("run", "carry", "pass", "rest"))
    assert pause_entry(bare, np.array([2, 3]), 0, RESTS) == -1
    assert may_pause(bare, np.array([2, 3, 0, 1, 4]), RESTS).tolist() == [0] * 5


def test_who_has_the_ball_holds_it_while_waiting() -> None:
    entries = np.array([2, 3, 4])
    assert pause_entry(library(), entries, 0, RESTS) == 2
    assert pause_entry(library(), entries, 1, RESTS) == 4  # passed: idle


def test_a_run_that_ends_in_flow_comes_to_rest() -> None:
    step, stood = lead_out(library(), np.array([0]), 50, RESTS)
    assert (step.source.capture, step.n_frames, step.waits, step.clip) == ("clip1", 10, False, 1)
    assert (stood.source.capture, stood.n_frames, stood.waits) == ("clip4", 50, True)
    (only,) = lead_out(library(), np.array([1]), 50, RESTS)  # is at rest already
    assert only.waits
    (before,) = lead_in(library(), np.array([0]), 50, RESTS)  # no step out of rest in the library
    assert (before.clip, before.waits, before.source.capture) == (-1, True, "clip4")


def strings(*lengths: int, least: dict[int, int] | None = None, delay: int = 0) -> Strings:
    cut = [(least or {}).get(k, n) for k, n in enumerate(lengths)]
    return Strings(
        np.array(lengths), np.array(cut), np.ones(len(lengths), dtype=int), delay,
        np.zeros(len(lengths), dtype=int),
    )  # fmt: skip


def test_who_is_early_waits_between_clips_at_an_even_pace() -> None:
    one, other = strings(30, 30), strings(30, 90, 30)
    meetings = [Meeting(0, 10.0, 1, 10.0, 0.0), Meeting(0, 40.0, 1, 130.0, 0.0)]
    scheduled, there = schedule([one, other], meetings)
    assert scheduled.lengths == (30, 30)
    assert scheduled.pauses[0] == 90  # 130 - 40
    assert there.pauses == (0, 0, 0)


def test_standing_is_cut_where_nobody_needs_it_and_kept_where_somebody_does() -> None:
    one = strings(100, 30, least={0: 15})
    (alone,) = schedule([one], [])
    assert alone.lengths == (15, 30)
    other = strings(70, 30)
    scheduled, _ = schedule([one, other], [Meeting(0, 115.0, 1, 85.0, 0.0)])
    assert 15 <= scheduled.lengths[0] <= 70
    assert scheduled.delay + scheduled.lengths[0] + 15 == pytest.approx(85.0, abs=1.0)


def test_who_guards_stays_with_the_run_that_is_guarded() -> None:
    runner = strings(100, 20, 40, 20, least={0: 15})
    guard = strings(30, delay=130)
    beside = [Meeting(1, 0.0, 0, 130.0, 0.0)]  # as the third clip has lasted 10 frames
    ran, guarded = schedule([runner, guard], [], beside)
    assert ran.lengths == (15, 20, 40, 20)
    assert guarded.delay == pytest.approx(45.0, abs=1.0)


def test_who_hurries_waits_where_they_have_come_to() -> None:
    meetings = [Meeting(0, 45.0, 1, 130.0, 0.0)]  # as sampled, with a delay of 85
    for hurries, waited in ((False, (85.0, 0)), (True, (0.0, 85))):
        one = replace(strings(30, 30, delay=85), hurries=hurries)
        scheduled, _ = schedule([one, strings(200)], meetings)
        assert (scheduled.delay, scheduled.pauses[0]) == pytest.approx(waited, abs=1.0)


def test_a_later_step_waits_for_an_earlier_one_and_not_the_other_way_round() -> None:
    for own, theirs in ((100.0, 10.0), (10.0, 100.0)):  # as they would be done at once
        order = Meeting(0, own, 1, theirs, 6.0, weight=30.0, at_least=True)
        one, other = schedule([strings(120), strings(120)], [], [order])
        assert one.delay == 0.0
        assert other.delay == pytest.approx(max(own + 6.0 - theirs, 0.0), abs=1.0)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 60), st.integers(0, 29), st.integers(0, 79), st.floats(-30, 30))
def test_schedules_stay_within_their_bounds(delay: int, a: int, b: int, lag: float) -> None:
    players = [strings(50, 30, least={0: 20}, delay=delay), strings(30, 50)]
    for actual, one in zip(
        schedule(players, [Meeting(0, 50.0 + a, 1, float(b), lag)]), players, strict=True
    ):
        assert (np.array(actual.lengths) >= one.least).all()
        assert (np.array(actual.lengths) <= one.lengths).all()
        assert actual.delay >= 0.0
        assert all(p == 0 or p >= SHORTEST_PAUSE for p in actual.pauses)
        assert actual.pauses[-1] == 0
    assert SLOWEST > 1.0


def test_frames_lie_between_those_of_one_capture_never_of_two() -> None:
    none = np.zeros((6, 0))
    part = np.array([0, 0, 0, 1, 1, 1])
    frames = np.array([100, 101, 102, 7, 8, 7])  # the second is a wait, played forth and back
    spliced = Spliced(0, none, np.zeros(6), none, (), part, frames, np.ones(6), none.astype(bool))
    shown, rate = spliced.shown_frames(np.array([0.25, 1.5, 2.25, 2.75, 3.5, 4.25, 5.0]))
    assert shown.tolist() == [100.25, 101.5, 102.0, 7.0, 7.5, 7.75, 7.0]
    assert rate.tolist() == [1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0]
