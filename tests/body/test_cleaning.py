"""Wild frames: a pose before the take, spikes, frames without numbers."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import body, cleaning
from motiondb.records import FloatArray

FPS = 30.0


def walk(n_frames: int = 90) -> FloatArray:
    """21 joints that move 1.2 m/s ahead."""
    points = np.cumsum(body.OFFSETS, axis=0)[None] + np.zeros((n_frames, 1, 1))
    points[:, :, 2] += 1.2 * np.arange(n_frames)[:, None] / FPS
    return points


def test_a_possible_take_is_left_as_it_is() -> None:
    points = walk()
    cleaned, notes = cleaning.clean(points, FPS, body.LEG_LENGTH)
    np.testing.assert_array_equal(cleaned, points)
    assert notes == ()


def test_a_pose_before_the_take_is_replaced_by_the_first_good_frame() -> None:
    points = walk()
    points[:8] = points[0] + [5.0, 0, 0]
    cleaned, notes = cleaning.clean(points, FPS, body.LEG_LENGTH)
    np.testing.assert_allclose(cleaned[:8], np.broadcast_to(points[8], (8, 21, 3)))
    np.testing.assert_array_equal(cleaned[8:], points[8:])
    assert notes == ("the first 8 frames jump; they were replaced by the first good frame",)


def test_ringing_after_the_leap_is_replaced_too() -> None:
    points = walk()
    points[:4] += [5.0, 0, 0]
    points[5, 3, 0] += 0.3
    bad = cleaning.wild_frames(points, FPS, body.LEG_LENGTH)
    assert np.flatnonzero(bad).tolist() == [0, 1, 2, 3, 4, 5]


def test_frames_without_numbers_are_interpolated() -> None:
    points = walk()
    wild = points.copy()
    wild[20:23, 2] = np.nan
    wild[60, 4, 1] = np.inf
    wild[-1] = np.nan
    cleaned, notes = cleaning.clean(wild, FPS, body.LEG_LENGTH)
    np.testing.assert_allclose(cleaned[:-1], points[:-1])
    np.testing.assert_allclose(cleaned[-1], points[-2])
    assert notes == ("5 frames jump faster than 14 m/s and were interpolated",)


def test_two_long_halves_are_both_believed() -> None:
    points = walk()
    points[45:] += [9.0, 0, 0]
    assert not cleaning.wild_frames(points, FPS, body.LEG_LENGTH).any()


def test_nothing_to_believe_gives_zeros_and_a_note() -> None:
    cleaned, notes = cleaning.clean(np.full((5, 21, 3), np.nan), FPS, body.LEG_LENGTH)
    np.testing.assert_array_equal(cleaned, np.zeros((5, 21, 3)))
    assert notes == ("no frame moves like a human",)


def test_the_speed_limit_grows_with_the_performer() -> None:
    points = walk() * 10.0  # 12 m/s for a giant with legs of 8.5 m is a stroll
    points[30:, :, 0] += 2.0
    assert not cleaning.wild_frames(points, FPS, 8.5).any()
    assert cleaning.wild_frames(walk() * 10.0 + 0.0, FPS, 0.2).any()


@settings(deadline=None, max_examples=100)
@given(st.sets(st.integers(31, 80), max_size=12), st.integers(0, 10**6))
def test_whatever_is_broken_the_result_is_finite_and_good_frames_stay(
    broken: set[int], seed: int
) -> None:
    """After the first second: before it, what a leap cuts off may be a pose before the take."""
    points = walk()
    wild = points.copy()
    for frame in broken:
        wild[frame] = np.random.default_rng(seed + frame).choice([np.nan, np.inf, 1e6], (21, 3))
    cleaned, _ = cleaning.clean(wild, FPS, body.LEG_LENGTH)
    assert np.isfinite(cleaned).all()
    bad = cleaning.wild_frames(wild, FPS, body.LEG_LENGTH)
    assert bad[sorted(broken)].all()
    np.testing.assert_array_equal(cleaned[~bad], wild[~bad])
    np.testing.assert_allclose(cleaned, points, atol=1e-9)


def test_a_plausible_capture_has_no_reason_against_it() -> None:
    assert cleaning.implausible(walk(), FPS, body.LEG_LENGTH) == ""
    assert cleaning.implausible(walk()[:1], FPS, body.LEG_LENGTH) == ""
    glitch = walk()
    glitch[40, 5] += 30.0  # one frame of one marker, at 900 m/s
    glitch[60:70] = np.nan
    assert cleaning.implausible(glitch, FPS, body.LEG_LENGTH) == ""


def test_sustained_speed_is_implausible() -> None:
    seconds = np.arange(len(walk())) / FPS
    fast = walk() + seconds[:, None, None] * np.array([0.0, 0.0, 1270.0])
    reason = cleaning.implausible(fast, FPS, body.LEG_LENGTH)
    assert reason.startswith("a motion faster than 14 m/s for ")
    assert reason.endswith(" s without interruption (in the median at 1271 m/s)")


def test_mostly_broken_frames_are_implausible() -> None:
    broken = walk()
    broken[::2] += 5.0
    assert "of the frames jumping" in cleaning.implausible(broken[:14], FPS, body.LEG_LENGTH)
    holed = walk()
    holed[: int(len(holed) * 0.6)] = np.nan
    assert cleaning.implausible(holed, FPS, body.LEG_LENGTH) == (
        "60% of the frames jumping or without numbers"
    )
