"""Feet that slide at a seam take a step: bodies that stand, whose ankles are moved by hand."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body import body, retarget
from motiondb.body.contacts import find_contacts, foot_heights
from motiondb.records import Motion
from motiondb.scene.polish.splicing import (
    ANKLES,
    LIFT,
    LIFTED,
    SWING,
    find_slides,
    move_ankles,
    step_at_seams,
)
from motiondb.scene.report.visible_motion import airborne, foot_jump, on_the_ground

N_FRAMES = 60
BLENDED = np.zeros(N_FRAMES, dtype=bool)
BLENDED[20:40] = True


def standing() -> Motion:
    """Somebody who stands, knees bent a little, the pelvis 4 cm lower than upright."""
    rotations = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (N_FRAMES, len(body.JOINTS), 1))
    roots = np.zeros((N_FRAMES, 3))
    roots[:, 1] = body.LEG_LENGTH + body.ANKLE_HEIGHT - 0.04
    motion = Motion(rotations.astype(np.float32), roots.astype(np.float32), body.LEG_LENGTH)
    target = joints_of(motion)[:, ANKLES]
    target[:, :, 1] = body.ANKLE_HEIGHT
    return moved(motion, target)


def joints_of(motion: Motion) -> np.ndarray:
    return retarget.motion_positions(motion)[0].astype(np.float64)


def moved(motion: Motion, target: np.ndarray) -> Motion:
    joints = retarget.motion_positions(motion)
    return move_ankles(motion, joints, target, np.ones(N_FRAMES, dtype=bool))


def sliding(feet: dict[int, float], frames: tuple[int, int] = (28, 32)) -> Motion:
    """Somebody whose feet slide ahead by some metres between two frames."""
    motion = standing()
    target = joints_of(motion)[:, ANKLES]
    share = np.clip((np.arange(N_FRAMES) - frames[0]) / (frames[1] - frames[0]), 0.0, 1.0)
    for foot, metres in feet.items():
        target[:, foot, 2] += metres * share
    return moved(motion, target)


def jump(joints: np.ndarray) -> float:
    planted = on_the_ground(joints, find_contacts(joints), BLENDED)
    return foot_jump(joints, planted).metres


def test_a_slide_is_found_with_its_frames_and_length() -> None:
    (slide,) = find_slides(joints_of(sliding({0: 0.2})), BLENDED)
    assert (slide.foot, slide.start, slide.end) == (0, 28, 32)
    assert slide.metres == pytest.approx(0.2, abs=2e-3)


@pytest.mark.parametrize("foot", [0, 1])
def test_a_slide_becomes_a_step_from_the_old_place_to_the_new(foot: int) -> None:
    before = sliding({foot: 0.2})
    old, new = joints_of(before), joints_of(step_at_seams(before, BLENDED))
    assert jump(old) == pytest.approx(0.2, abs=2e-3)
    assert jump(new) < 0.03
    heights = foot_heights(new)[:, foot]
    assert heights.max() == pytest.approx(LIFT, abs=0.01)
    up = np.flatnonzero(heights > LIFTED)
    assert len(up) <= SWING
    assert 25 <= up[0] <= up[-1] <= 35
    np.testing.assert_allclose(new[:25], old[:25], atol=1e-5)
    np.testing.assert_allclose(new[36:], old[36:], atol=1e-5)
    np.testing.assert_allclose(new[:, ANKLES[1 - foot]], old[:, ANKLES[1 - foot]], atol=1e-4)


def test_feet_that_slide_at_once_step_one_after_the_other() -> None:
    before = sliding({0: 0.15, 1: 0.25})
    after = joints_of(step_at_seams(before, BLENDED))
    assert jump(joints_of(before)) > 0.2
    assert jump(after) < 0.03
    assert not airborne(after).any()
    left, right = (foot_heights(after)[:, foot] > LIFTED for foot in (0, 1))
    assert not (left & right).any()
    assert np.flatnonzero(right)[-1] < np.flatnonzero(left)[0]  # the farther one first


def test_what_is_short_lifted_slow_or_not_blended_is_left_alone() -> None:
    assert find_slides(joints_of(sliding({0: 0.04})), BLENDED) == []
    assert find_slides(joints_of(sliding({0: 0.2}, (5, 9))), BLENDED) == []
    assert find_slides(joints_of(sliding({0: 0.2}, (10, 40))), BLENDED) == []  # 0.2 m/s
    step = step_at_seams(sliding({0: 0.2}), BLENDED)
    assert find_slides(joints_of(step), BLENDED) == []
    assert step_at_seams(step, BLENDED) is step
    still = standing()
    assert step_at_seams(still, np.zeros(N_FRAMES, dtype=bool)) is still


def test_a_step_keeps_away_from_frames_in_which_its_foot_is_lifted() -> None:
    motion = sliding({1: 0.2})
    target = joints_of(motion)[:, ANKLES]
    target[10:27, 1, 1] += 0.06  # lifted until just before the slide
    lifted = moved(motion, target)
    old, new = joints_of(lifted), joints_of(step_at_seams(lifted, BLENDED))
    assert [slide.start for slide in find_slides(old, BLENDED)] == [28]
    np.testing.assert_allclose(new[:27], old[:27], atol=1e-5)
    assert foot_heights(new)[29:32, 1].min() > LIFTED
