"""What a viewer sees, on bodies moved by hand: motions that show a fault, and ones that do not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import body, retarget
from motiondb.records import Motion
from motiondb.scene.report.report_records import JumpReport, LimbReport
from motiondb.scene.report.visible_motion import (
    JUMP_LIMIT,
    STANDING,
    WAITING,
    FootJump,
    GaitRange,
    airborne,
    crossing_limbs,
    foot_jump,
    gait_range,
    impossible_gait,
    impossible_jump,
    limb_distances,
    near_limbs,
    on_the_ground,
    segment_distances,
    step_lengths,
    travel_speeds,
)

WALK = GaitRange(airborne=0, step=0.7, speed=1.6)
RANGES = {"walk": WALK, "run": GaitRange(airborne=8, step=1.0, speed=5.0), WAITING: STANDING}
FEET = {side: [body.INDEX[f"{side}_ankle"], body.INDEX[f"{side}_toe"]] for side in ("l", "r")}


def standing(n_frames: int) -> np.ndarray:
    """Joints of somebody who stands upright on flat feet: array (frames, 21, 3)."""
    rotations = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (n_frames, len(body.JOINTS), 1))
    roots = np.zeros((n_frames, 3))
    roots[:, 1] = body.LEG_LENGTH + body.ANKLE_HEIGHT
    motion = Motion(rotations.astype(np.float32), roots.astype(np.float32), body.LEG_LENGTH)
    return retarget.motion_positions(motion)[0]


def kinds(joints: np.ndarray, labels: list[str]) -> list[tuple[str, int, int]]:
    gaits = impossible_gait("A1", joints, labels, RANGES)
    return [(motion.kind, motion.start, motion.end) for motion in gaits]


def test_standing_is_possible() -> None:
    joints = standing(60)
    assert not airborne(joints).any()
    np.testing.assert_allclose(step_lengths(joints), 0.18, atol=1e-6)
    assert kinds(joints, ["walk"] * 60) == []
    assert kinds(joints, [WAITING] * 60) == []


@pytest.mark.parametrize(("frames", "seen"), [(3, False), (4, True), (12, True)])
def test_both_feet_in_the_air_are_no_walk(frames: int, seen: bool) -> None:
    joints = standing(60)
    joints[20 : 20 + frames, :, 1] += 0.1
    expected = [("airborne", 20, 20 + frames)] if seen else []
    assert kinds(joints, ["walk"] * 60) == expected
    assert kinds(joints, [WAITING] * 60) == expected


def test_the_middle_of_a_flight_is_named_with_its_limit() -> None:
    joints = standing(60)
    joints[20:32, :, 1] += 0.1
    (gaits,) = impossible_gait("A1", joints, ["walk"] * 60, RANGES)
    assert (gaits.players, gaits.action, gaits.frame) == (("A1",), "walk", 26)
    assert (gaits.value, gaits.limit, gaits.unit) == (12.0, 3.0, "frames")


def test_a_run_may_fly_as_long_as_its_captures_and_a_walk_beside_it_too() -> None:
    joints = standing(60)
    joints[20:32, :, 1] += 0.1  # 12 frames; 1.25 * 8 + 3 are allowed
    assert kinds(joints, ["run"] * 60) == []
    assert kinds(joints, ["run"] * 28 + ["walk"] * 32) == []
    joints[20:34, :, 1] += 0.1
    assert kinds(joints, ["run"] * 60) == [("airborne", 20, 34)]


def test_one_foot_in_the_air_is_a_step() -> None:
    joints = standing(60)
    joints[20:40, FEET["l"], 1] += 0.3
    assert kinds(joints, ["walk"] * 60) == []


@pytest.mark.parametrize(("speed", "seen"), [(2.6, False), (4.0, True)])
def test_four_metres_a_second_are_no_walk(speed: float, seen: bool) -> None:
    joints = standing(60)
    joints[:, :, 2] += np.arange(60)[:, None] * speed / 30.0
    np.testing.assert_allclose(travel_speeds(joints), speed)
    assert kinds(joints, ["walk"] * 60) == ([("speed", 0, 60)] if seen else [])
    assert kinds(joints, ["run"] * 60) == []


def test_a_sudden_step_is_averaged_over_half_a_second() -> None:
    joints = standing(60)
    joints[30:, :, 2] += 0.3
    assert travel_speeds(joints).max() == pytest.approx(0.3 / (14 / 30))


@pytest.mark.parametrize(("apart", "seen"), [(1.0, False), (1.3, True)])
def test_splits_are_no_step(apart: float, seen: bool) -> None:
    joints = standing(60)
    joints[20:30, FEET["l"], 2] += np.sqrt(apart**2 - 0.18**2)
    assert kinds(joints, ["walk"] * 60) == ([("step", 20, 30)] if seen else [])


def test_the_gait_of_captures_is_that_of_their_intervals() -> None:
    joints = standing(100)
    joints[10:20, :, 1] += 0.1
    joints[50:56, :, 1] += 0.1
    joints[70:80, FEET["r"], 2] += 0.6
    assert gait_range(joints, [(52, 90)]).airborne == 6  # as a whole, though it began before
    assert gait_range(joints, [(0, 15), (12, 40)]).airborne == 10
    assert gait_range(joints, [(52, 90)]).step == pytest.approx(np.hypot(0.18, 0.6))
    assert gait_range(joints, [(20, 40)]) == GaitRange(0, pytest.approx(0.18), 0.0)
    assert gait_range(joints, []) == GaitRange()


def test_a_planted_foot_that_jumps_is_found_and_a_slow_slide_is_not() -> None:
    joints = standing(60)
    planted = np.ones((60, 2), dtype=bool)
    assert foot_jump(joints, planted) == FootJump()
    joints[30:, FEET["r"], 0] += 0.13
    jump = foot_jump(joints, planted)
    assert (jump.metres, jump.foot) == (pytest.approx(0.13), 1)
    assert (jump.start, jump.end) == (28, 30)
    slow = standing(60)
    slow[:, FEET["r"], 0] += np.linspace(0.0, 0.13, 60)[:, None]
    assert foot_jump(slow, planted).metres == pytest.approx(0.13 * 9 / 59)


def test_a_foot_that_rolls_over_its_toe_does_not_jump() -> None:
    joints = standing(60)
    joints[30:, body.INDEX["l_ankle"], 2] += 0.1
    assert foot_jump(joints, np.ones((60, 2), dtype=bool)).metres == pytest.approx(0.0)


def test_a_foot_in_the_air_does_not_jump() -> None:
    joints = standing(60)
    joints[30:, FEET["r"], 0] += 0.13
    planted = np.ones((60, 2), dtype=bool)
    planted[26:34, 1] = False
    assert foot_jump(joints, planted).metres == 0.0
    edited, captured = np.ones(60, dtype=bool), np.zeros(60, dtype=bool)
    assert foot_jump(joints, on_the_ground(joints, planted, captured)).metres == 0.0
    assert foot_jump(joints, on_the_ground(joints, planted, edited)).metres == pytest.approx(0.13)
    joints[29, FEET["r"], 1] += 0.04  # now it is lifted: a step
    assert foot_jump(joints, on_the_ground(joints, planted, edited)).metres == 0.0


@settings(deadline=None)
@given(st.integers(2, 40), st.floats(0.0, 0.5))
def test_no_jump_is_larger_than_the_way_of_the_foot(frame: int, metres: float) -> None:
    joints = standing(42)
    joints[frame:, FEET["l"], 2] += metres
    jump = foot_jump(joints, np.ones((42, 2), dtype=bool))
    assert jump.metres <= metres + 1e-9


def test_jumps_are_impossible_beyond_the_limit_or_what_captures_show() -> None:
    labels = ["walk"] * 60
    for metres, source, seen in (
        (JUMP_LIMIT, 0.0, False),
        (0.2, 0.0, True),
        (0.2, 0.18, False),
        (0.3, 0.18, True),
    ):
        jump = JumpReport("A1", "left", metres, 10, 14, source)
        actual = impossible_jump(jump, labels)
        assert [(m.kind, m.start, m.end, m.frame) for m in actual] == (
            [("foot jump", 10, 15, 14)] if seen else []
        )


def naive_distance(a, b, c, d) -> float:
    """The distance of two segments by looking at many points of both."""
    share = np.linspace(0.0, 1.0, 201)[:, None]
    one, other = a + share * (b - a), c + share * (d - c)
    return float(np.linalg.norm(one[:, None] - other[None], axis=2).min())


@settings(deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=12, max_size=12))
def test_distances_of_segments_beside_a_slow_twin(values: list[float]) -> None:
    a, b, c, d = np.array(values).reshape(4, 3)
    fast = float(segment_distances(a, b, c, d))
    slow = naive_distance(a, b, c, d)
    assert fast <= slow + 1e-6  # segments shorter than a micrometre count as points
    assert slow <= fast + 0.02
    assert fast == pytest.approx(float(segment_distances(c, d, a, b)), abs=1e-6)


def test_parallel_and_degenerate_segments() -> None:
    zero, one = np.zeros(3), np.array([1.0, 0.0, 0.0])
    up = np.array([0.0, 2.0, 0.0])
    assert float(segment_distances(zero, one, zero + up, one + up)) == 2.0
    assert float(segment_distances(zero, zero, one, one)) == 1.0
    assert float(segment_distances(zero, one, 3 * one, 5 * one)) == 2.0


def test_limbs_that_come_near_and_limbs_that_cross() -> None:
    one, other = standing(10), standing(10)
    other[:, :, 0] += 3.0
    assert np.isinf(limb_distances(one, other)).all()  # out of reach
    assert list(near_limbs(("A1", "D1"), [one, other])) == []
    # arms reach 0.70 m to each side: in frame 4 the wrists are 3 cm apart, in frame 5 they cross
    reach = one[0, body.INDEX["l_wrist"], 0] - one[0, 0, 0]
    other[:, :, 0] -= 3.0
    other[:, :, 0] += 2.0 * reach + 0.2
    other[4, :, 0] -= 0.17
    assert limb_distances(one, other)[[0, 4]] == pytest.approx([0.2, 0.03])
    (pair,) = near_limbs(("A1", "D1"), [one, other])
    assert (pair.players, pair.frame, pair.n_frames) == (("A1", "D1"), 4, 1)
    assert pair.metres == pytest.approx(0.03)
    assert crossing_limbs([pair]) == []
    other[5, :, 0] -= 0.3
    (pair,) = near_limbs(("A1", "D1"), [one, other])
    assert (pair.frame, pair.n_frames) == (5, 2)
    (actual,) = crossing_limbs([pair])
    assert (actual.kind, actual.players, actual.frame) == ("limbs", ("A1", "D1"), 5)
    assert crossing_limbs([LimbReport(("A1", "D1"), 0.02, 3, 1)]) == []
