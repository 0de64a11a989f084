"""Cuts: what must agree at a seam by hand, cuts that move, gestures and breaks that are avoided."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body import body, rotation
from motiondb.generate import cuts
from motiondb.generate.cuts import Position, Take, edges_of, moved_cuts, refine
from motiondb.generate.excerpts import UNSEEN_WEIGHT, Excerpt
from motiondb.records import FloatArray

STILL = np.tile(rotation.IDENTITY, (60, len(body.JOINTS), 1))


def _edges(**values: float) -> FloatArray:
    """Edges of a capture that stands still, but for the given path values."""
    path = np.zeros((60, 4))
    for name, value in values.items():
        path[:, ["height", "left", "ahead", "turning"].index(name)] = value
    return edges_of(path, STILL, np.zeros((60, 52)), np.ones(52))


@pytest.mark.parametrize(
    ("other", "unit"),
    [
        ("height", cuts.HEIGHT),
        ("ahead", cuts.SPEED),
        ("left", cuts.SPEED),
        ("turning", cuts.TURNING),
    ],
)
def test_one_unit_of_difference_costs_one(other: str, unit: float) -> None:
    apart = _edges(**{other: 2.0 * unit}) - _edges(**{other: unit})
    np.testing.assert_allclose(np.sum(apart**2, axis=1), 1.0)


def test_after_the_last_frame_a_capture_goes_on() -> None:
    path = np.zeros((60, 4))
    path[:, 0] = 0.01 * np.arange(60)
    edges = edges_of(path, STILL, np.zeros((60, 52)), np.ones(52))
    assert edges[60, 0] * cuts.HEIGHT == pytest.approx(0.6)


def _take(speeds: FloatArray | None = None, restless: FloatArray | None = None) -> Take:
    n = 200
    poses = np.cumsum(np.random.default_rng(1).normal(size=(n, 2)), axis=0)  # without a period
    zeros = np.zeros(n)
    return Take(
        np.arange(n + 1.0)[:, None],
        poses,
        zeros if restless is None else restless,
        zeros if speeds is None else speeds,
    )


def _best(take: Take, position: Position, start: int = 60, end: int = 140) -> tuple[int, int]:
    one = [Excerpt(7, start, end, 0.0, (start, end))]
    moved, owner = moved_cuts(one, {7: take}, {7: np.zeros(200)}, np.zeros(1), position)
    assert set(owner) == {0}
    best = int(np.argmin(moved.targets))
    return int(moved.starts[best]), int(moved.ends[best])


def test_a_gesture_is_cut_where_it_rests() -> None:
    restless = np.ones(200)
    restless[44:53] = restless[148:160] = 0.0
    assert _best(_take(restless=restless), Position(True, True)) == (52, 149 + 7)
    assert _best(_take(), Position(True, True)) == (60, 140)


def test_a_break_of_the_capture_is_left_out() -> None:
    """It stands for the first 72 frames and then moves at 2 m/s from one frame to the next."""
    speeds = np.where(np.arange(200) < 72, 0.0, 2.0)
    start, end = _best(_take(speeds), Position(False, False))
    assert start > 71
    assert end == 140


def test_frames_that_do_not_show_the_action_are_cut_away() -> None:
    """Who stands does not run."""
    one = [Excerpt(7, 60, 140, 0.0, (60, 140))]
    values = np.where(np.arange(200) < 120, 0.0, -UNSEEN_WEIGHT)
    moved, _ = moved_cuts(one, {7: _take()}, {7: values}, np.zeros(1), Position(False, False))
    assert moved.ends[np.argmin(moved.targets)] == 140 - cuts.MOST_MOVED


def test_chosen_cuts_are_moved_to_where_both_sides_agree() -> None:
    take = _take()  # at frame t its edges are t
    before, after = Excerpt(7, 0, 100, 0.0, (0, 100)), Excerpt(8, 103, 180, 0.0, (103, 180))
    moved = refine([before, after], {7: take, 8: take}, [False, False])
    assert moved[0].end == moved[1].start
    fixed = refine([before, after], {7: take, 8: take}, [True, False])
    assert (fixed[0].end, fixed[1].start) == (100, 100)
