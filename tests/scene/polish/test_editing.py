"""Time and ways edited: worked numbers, bounds that hold, rules that come true."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_values import direction_error

from motiondb.scene.energy.binding import (
    AT_END,
    AT_START,
    DIRECTION,
    DISTANCE,
    LINE,
    POSITION,
    THROUGHOUT,
)
from motiondb.scene.energy.energy import RADIUS
from motiondb.scene.polish import path_editing
from motiondb.scene.polish.path_editing import Edited, Facing, edit_paths, overlaps, pushes
from motiondb.scene.timing.scheduling import SLOWEST, Meeting, TimeMap, edit_times
from motiondb.scene.timing.timeline import Timeline, excess, moment_frames

from ..timing.test_timeline import a_row, a_table, still


def test_between_two_meetings_the_paces_share_what_is_missing() -> None:
    # 40 frames of one must last as long as 50 of the other: both give, in proportion to weight
    knots = [np.array([0.0, 60.0]), np.array([0.0, 60.0])]
    meetings = [Meeting(0, 5.0, 1, 5.0, 0.0), Meeting(0, 45.0, 1, 55.0, 0.0)]
    first, second = edit_times(knots, [0, 0], meetings)
    lasts = [float(first.frame_of(45.0) - first.frame_of(5.0)),
             float(second.frame_of(55.0) - second.frame_of(5.0))]  # fmt: skip
    # least (d - 40)^2 / 40 + (d - 50)^2 / 50 is at 2 / (1 / 40 + 1 / 50)
    assert lasts == pytest.approx([2.0 / (1.0 / 40.0 + 1.0 / 50.0)] * 2, abs=0.02)


@settings(max_examples=30, deadline=None)
@given(st.floats(5, 55), st.floats(5, 55), st.floats(5, 55), st.floats(0, 60))
def test_no_clip_is_shown_faster_or_slower_than_allowed(
    a: float, b: float, c: float, lag: float
) -> None:
    a, b, c = (round(frame, 3) for frame in (a, b, c))
    knots = [np.array([0.0, 20.0, 60.0]), np.array([0.0, 30.0, 60.0])]
    maps = edit_times(knots, [0, 7], [Meeting(0, a, 1, b, lag), Meeting(1, c, 0, 57.0, 3.0)])
    for one in maps:
        slope = np.diff(one.shown) / np.diff(one.source)
        assert slope.max() <= SLOWEST + 1e-6
        assert slope.min() >= 1.0 / SLOWEST - 1e-6
        assert one.shown[0] >= 0.0
    assert min(float(one.shown[0]) for one in maps) == 0.0


def test_a_time_map_is_read_both_ways() -> None:
    times = TimeMap(np.array([0.0, 10.0, 20.0]), np.array([5.0, 17.0, 25.0]))
    assert times.frame_of(np.array([5.0])).tolist() == [11.0]
    frames = np.array([3.0, 11.0, 21.0, 27.0])
    assert times.source_at(frames).tolist() == [-2.0, 5.0, 15.0, 22.0]
    assert times.slope_at(frames).tolist() == [1.0, pytest.approx(10 / 12), 1.25, 1.0]


def walking(*starts: tuple[float, float], frames: int = 61, speed: float = 1.5) -> Timeline:
    """Everybody walks along +z."""
    ahead = np.arange(frames) * speed / 30.0
    places = [np.column_stack([np.full(frames, x), z + ahead, np.zeros(frames)]) for x, z in starts]
    begins = tuple(np.array([0, frames]) for _ in starts)
    return Timeline(np.stack(places), begins, tuple(np.array([frames // 2]) for _ in starts))


def edited(table, timeline, *facings):
    return edit_paths(table, timeline, timeline.places, facings)


def test_a_walk_ends_where_it_should_and_steps_stay_even() -> None:
    timeline = walking((0.0, 0.0))
    rows = [
        a_row(kind=POSITION, last=1, moment=AT_START, weight=0.1),
        a_row(kind=POSITION, last=1, moment=AT_END, x=0.8, z=2.4, weight=0.1),
    ]
    out = edited(a_table(*rows, players=1), timeline)
    assert out.settled
    assert excess(a_table(*rows, players=1), out.timeline) == 0.0
    steps = np.linalg.norm(np.diff(out.timeline.places[0, :, :2], axis=0), axis=1)
    assert steps.max() / steps.min() < 2.0
    turns = np.diff(steps)
    assert np.abs(turns).max() < 0.004  # metres from one step to the next: no jerk


def test_a_guard_stays_within_reach_and_moves_more_than_the_guarded() -> None:
    timeline = walking((0.0, 0.0), (3.0, 0.0))
    row = a_row(kind=DISTANCE, player=0, last=1, moment=THROUGHOUT, target=1, near=0.5, far=2.0)
    table = a_table(row)
    out = edited(table, timeline)
    assert out.settled
    assert excess(table, out.timeline) == 0.0
    moved = np.abs(out.timeline.places - timeline.places)[:, :, 0].max(axis=1)
    assert moved[0] > moved[1] > 0.0


def test_two_who_walk_through_one_another_pass_by() -> None:
    there = walking((0.0, 0.0))
    back = there.places[:, ::-1] + np.array([0.05, 0.0, 0.0])
    timeline = Timeline(np.concatenate([there.places, back]), there.begins * 2, there.instants * 2)
    table = a_table()
    assert overlaps(table, timeline)
    out = edited(table, timeline)
    assert out.settled
    assert overlaps(table, out.timeline) == ()


def test_turning_begins_shortly_before_it_is_asked_for() -> None:
    there = walking((0.0, 0.0))  # along +z
    back = still((0.0, -9.0, 0.0), frames=there.n_frames).places
    timeline = Timeline(np.concatenate([there.places, back]), there.begins * 2, there.instants * 2)
    last = there.n_frames - 1
    facing = Facing(0, np.array([last]), 1, np.array([last]), math.radians(90.0))
    turned = edited(a_table(), timeline, facing).timeline.places[0]
    assert abs(turned[last, 2]) >= math.radians(89.0)  # the ball comes from behind
    assert abs(turned[last - 60, 2]) < math.radians(10.0)
    np.testing.assert_allclose(turned[: last - 60, :2], there.places[0, : last - 60, :2], atol=0.05)


def test_who_faces_somebody_for_long_turns_one_way_round() -> None:
    around = np.linspace(math.pi - 0.3, math.pi + 0.3, 60)  # the opponent passes behind
    target = np.column_stack([np.sin(around), np.cos(around), np.zeros(60)])
    path = np.zeros((60, 3))
    timeline = Timeline(
        np.stack([path, 3.0 * target]), (np.array([0, 60]),) * 2, (np.array([30]),) * 2
    )
    frames = np.arange(0, 60, 4)
    out = edited(a_table(), timeline, Facing(0, frames, 1, frames, math.radians(45.0)))
    assert np.abs(np.diff(out.timeline.places[0, :, 2])).max() < math.radians(6.0)
    off = direction_error(out.timeline.places[0, frames, 2], around[frames])
    assert off.max() <= math.radians(46.0)


def test_what_cannot_hold_is_said() -> None:
    timeline = still((0.0, 0.0, 0.0), frames=10)
    rows = [a_row(kind=POSITION, last=1, moment=AT_START, x=x, weight=0.1) for x in (-1.0, 1.0)]
    table = a_table(*rows, players=1)
    out = edited(table, timeline)
    assert not out.settled
    assert excess(table, out.timeline) > 0.0


def each_round_anew(table, spliced, wished, facings) -> Edited:
    """The slow twin: every way is solved and every rule looked at in every round."""
    everybody, n_frames = range(len(spliced.places)), spliced.n_frames
    places = [path_editing._Held(n_frames, 2) for _ in everybody]
    turns = [path_editing._Held(n_frames, 1) for _ in everybody]
    frames = [moment_frames(row, spliced) for row in table.rows]
    for done in range(path_editing.MOST_ROUNDS):
        ways = [
            path_editing._solve(spliced.places[p], wished[p], turns[p], places[p])
            for p in everybody
        ]
        now = replace(spliced, places=np.stack(ways))
        for row, at in zip(table.rows, frames, strict=True):
            path_editing._correct(row, at, now, places, turns)
        for facing in facings:
            path_editing._face(facing, now, turns)
        for p, at, by in pushes(table, now, path_editing.SLACK, RADIUS):
            places[p].move(at, by)
        moved = [places[p].settle(now.places[p, :, :2]) for p in everybody]
        turned = [turns[p].settle(now.places[p, :, 2:]) for p in everybody]
        if not any(moved) and not any(turned):
            return Edited(now, done, True)
    return Edited(now, path_editing.MOST_ROUNDS, False)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6))
def test_who_was_not_moved_need_not_be_looked_at_again(seed: int) -> None:
    rng = np.random.default_rng(seed)
    timeline = walking(*rng.uniform(-2.0, 2.0, (4, 2)), frames=21)
    rows = []
    for player in range(4):
        kind = int(rng.choice([POSITION, DIRECTION, DISTANCE, LINE]))
        ends = {name: int((player + rng.integers(1, 4)) % 4) for name in ("target", "other")}
        if kind != LINE or rng.random() < 0.5:
            ends.pop("other")
        if rng.random() < 0.3:
            ends = {"x": rng.uniform(-2.0, 2.0), "z": rng.uniform(-2.0, 2.0)}
        moment = int(rng.choice([AT_START, AT_END, THROUGHOUT]))
        bounds = {"near": 0.5, "far": 1.5, "weight": 0.3}
        rows.append(a_row(kind=kind, player=player, last=1, moment=moment, **bounds, **ends))
    table = a_table(*rows, players=4)
    facings = (Facing(0, np.array([12]), 1, np.array([10]), 0.5),)
    quick = edit_paths(table, timeline, timeline.places, facings)
    slow = each_round_anew(table, timeline, timeline.places, facings)
    assert (quick.rounds, quick.settled) == (slow.rounds, slow.settled)
    np.testing.assert_array_equal(quick.timeline.places, slow.timeline.places)
