"""Cutting: rest dropped, steps, pieces in place, instants; frames and speeds made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motiondb.records import Event, Motion
from motiondb.scene.clips import clip_cutting
from motiondb.scene.clips.clip_cutting import (
    AROUND,
    HELD,
    LANDED,
    WRISTS,
    BodyFrames,
    Piece,
    ShownMotion,
    cut_action,
    instant,
    throw_frames,
    without_rest,
)


def moving(speeds: np.ndarray, travel: bool = True, turn: float = 0.0) -> BodyFrames:
    """A body whose joints all move at given speeds (frames,), metres a second, along z."""
    n_frames = len(speeds)
    way = np.concatenate([[0.0], np.cumsum(speeds[:-1])]) / 30.0 * travel
    velocities = np.zeros((n_frames, 21, 3))
    velocities[..., 2] = speeds[:, None]
    places = np.column_stack([np.zeros(n_frames), way, np.linspace(0.0, turn, n_frames)])
    contacts = np.zeros((n_frames, 2), dtype=bool)
    return BodyFrames(places, np.zeros((n_frames, 21, 3)), velocities, contacts)


def shown(n_frames: int, event: str = "", events: tuple[Event, ...] = ()) -> ShownMotion:
    motion = Motion(np.zeros((n_frames, 21, 4), np.float32), np.zeros((n_frames, 3), np.float32))
    return ShownMotion("act", "take", motion, 0, n_frames, event, events)


def strikes(*frames: int) -> tuple[Event, ...]:
    return tuple(Event(f, "foot_strike", "l_ankle", "ground") for f in frames)


def speeds(*parts: tuple[int, float]) -> np.ndarray:
    return np.concatenate([np.full(count, speed) for count, speed in parts])


def test_rest_is_dropped_but_for_a_margin() -> None:
    frames = moving(speeds((10, 0.0), (30, 1.0), (20, 0.05)))
    assert without_rest(frames, 0, 60) == (8, 42)
    assert without_rest(frames, 15, 35) == (15, 35)
    waiting = moving(speeds((50, 0.0), (10, 1.0)))
    assert without_rest(waiting, 0, 60) == (0, 60)


def test_a_run_from_rest_to_rest_is_cut_into_steps() -> None:
    """Rest to 8, strikes at 20, 30, 40, rest from 52: edges 8 20 30 40 52, one or two spans."""
    frames = moving(speeds((10, 0.0), (40, 3.0), (10, 0.0)))
    cut = cut_action(shown(60, events=strikes(20, 30, 40)), frames)
    assert cut == [
        Piece(8, 20, "start"), Piece(8, 30, "start"), Piece(20, 30, "middle"),
        Piece(20, 40, "middle"), Piece(30, 40, "middle"), Piece(30, 52, "stop"),
        Piece(40, 52, "stop"),
    ]  # fmt: skip


def test_a_wave_that_is_asked_for_is_not_cut() -> None:
    wave = shown(90)
    frames = moving(np.full(90, 1.0), travel=False)
    assert len(cut_action(wave, frames)) > 1
    assert cut_action(replace(wave, is_whole=True), frames) == [Piece(0, 90)]


@pytest.mark.parametrize(
    ("struck", "contacts", "pieces"),
    [
        # 3 and 57 leave less than 6 frames at the ends, 23 less than 6 frames after 20
        ((3, 20, 23, 30, 57), (), [(20, 30)]),
        ((), ((20, 28, 0), (31, 38, 1), (42, 50, 0)), [(20, 31), (20, 42), (31, 42)]),
        ((30,), (), [(0, 60)]),  # one strike: the walk stays whole
    ],
)
def test_a_run_under_way_begins_and_ends_with_a_strike_or_a_contact(
    struck: tuple, contacts: tuple, pieces: list
) -> None:
    frames = moving(np.full(60, 3.0))
    for start, end, foot in contacts:
        frames.contacts[start:end, foot] = True
    cut = cut_action(shown(60, events=strikes(*struck)), frames)
    assert [(piece.start, piece.end) for piece in cut] == pieces


def test_dribbling_in_place_is_cut_where_the_ball_is_caught() -> None:
    frames = moving(np.full(70, 0.5), travel=False)
    events = tuple(Event(f, "catch", "r_wrist", "ball") for f in (15, 30, 45, 60))
    cut = cut_action(shown(70, events=events), frames)
    single = [(0, 15), (15, 30), (30, 45), (45, 60), (60, 70)]
    double = [(0, 30), (15, 45), (30, 60), (45, 70)]
    fourfold = [(0, 60), (15, 70)]
    assert [(p.start, p.end) for p in cut] == sorted(single + double + fourfold)


def test_waiting_is_cut_into_equal_pieces_and_short_or_turning_actions_are_not() -> None:
    still = np.full(72, 0.01)
    cut = cut_action(shown(72), moving(still, travel=False))
    assert [(p.start, p.end) for p in cut] == [(0, 24), (0, 48), (24, 48), (24, 72), (48, 72)]
    assert cut_action(shown(50), moving(still[:50], travel=False)) == [Piece(0, 50)]
    turning = moving(still, travel=False, turn=np.radians(90.0))
    assert cut_action(shown(72), turning) == [Piece(0, 72)]


def test_who_comes_back_has_travelled_too() -> None:
    frames = moving(np.full(80, 1.5))
    frames.places[:, 1] = 2.0 * np.sin(np.linspace(0.0, np.pi, 80))
    assert clip_cutting.travels(frames, 0, 80)
    assert not clip_cutting.travels(frames, 0, 10)
    assert len(cut_action(shown(80, events=strikes(20, 40, 60)), frames)) == 3


def test_an_action_with_an_instant_is_kept_about_it() -> None:
    frames = moving(np.full(200, 0.5))
    cut = cut_action(shown(200, "release", (Event(100, "release"),)), frames)
    assert cut == [Piece(100 - clip_cutting.AROUND, 100 + clip_cutting.AROUND)]


def test_of_several_instants_the_last_release_and_the_first_catch_count() -> None:
    frames = moving(np.full(60, 0.5))
    events = (Event(50, "release"), Event(10, "catch"), Event(20, "release"), Event(30, "catch"))
    assert instant(shown(60, "release", events), frames, 0, 60) == (50, "events")
    assert instant(shown(60, "release", events), frames, 0, 50) == (20, "events")
    assert instant(shown(60, "catch", events), frames, 0, 60) == (10, "events")
    assert instant(shown(60, "", events), frames, 0, 60) == (-1, "")


def test_where_nobody_wrote_an_instant_down_the_wrists_tell() -> None:
    frames = moving(np.full(60, 0.5))
    frames.joints[20, WRISTS[0]] = [0.0, 1.5, 0.6]  # one hand, up and ahead
    frames.joints[30, WRISTS] = [0.0, 1.1, 0.7]  # both hands, ahead
    assert instant(shown(60, "release"), frames, 0, 60) == (20, "wrists")
    assert instant(shown(60, "contact"), frames, 0, 60) == (20, "wrists")
    assert instant(shown(60, "catch"), frames, 0, 60) == (30, "wrists")
    assert instant(shown(60, "release"), frames, 25, 60) == (30, "wrists")


def made_hands(heights: np.ndarray, gaps: np.ndarray) -> BodyFrames:
    """Wrists at heights and so far apart, metres; all other joints are at 1 m."""
    joints = np.zeros((len(heights), 21, 3))
    joints[..., 1] = 1.0
    joints[:, WRISTS, 1] = heights[:, None]
    joints[:, WRISTS[0], 0] = gaps
    still = np.zeros((len(heights), 2), dtype=bool)
    return BodyFrames(np.zeros((len(heights), 3)), joints, np.zeros_like(joints), still)


def play(together: int = 60, n_frames: int = 160) -> BodyFrames:
    """Hands apart, together from a frame, up until 90 and apart from there, down from 120."""
    frame = np.arange(n_frames)
    heights = np.where(frame < 120, 0.8 + np.clip((frame - 70) / 20.0, 0.0, 1.0), 0.7)
    heights[90] += 0.1  # the highest
    gaps = np.where((frame >= together) & (frame < 90), HELD - 0.1, HELD + 0.3)
    return made_hands(heights, gaps)


def test_a_throw_lasts_from_the_hands_coming_together_to_their_sinking() -> None:
    assert throw_frames(play(), 0, 160) == (60, 120)
    assert throw_frames(play(), 65, 100) == (65, 100)  # nothing outside of what is asked about


def test_it_lasts_no_longer_than_clips_do() -> None:
    assert throw_frames(play(together=5), 0, 160) == (90 - AROUND, 120)
    up = play()
    up.joints[91:, WRISTS, 1] = 1.5
    assert throw_frames(up, 0, 160) == (60, 90 + AROUND)


def test_hands_that_were_together_before_do_not_count() -> None:
    """A catch at 10 to 20, a dribble, and then the shot."""
    frames = play()
    frames.joints[10:20, WRISTS[0], 0] = HELD
    assert throw_frames(frames, 0, 160) == (60, 120)


def test_one_hand_throws_too() -> None:
    frames = play(together=90)
    assert throw_frames(frames, 0, 160) == (90 - AROUND, 120)


def test_who_jumps_is_given_time_to_land() -> None:
    frames = play()
    frames.joints[95:, WRISTS, 1] = 0.7
    assert throw_frames(frames, 0, 160) == (60, 90 + LANDED)
