"""Recognition features: what they ignore, what they hold, and headings that never flip."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import body, features, kernels, kinematics, retarget, rotation
from motiondb.records import FloatArray, Motion

MotionMaker = Callable[..., Motion]


def turned(motion: Motion, angle: float, x: float, z: float) -> Motion:
    """The motion at another place and heading."""
    q = rotation.from_axis_angle(np.array([0.0, 1, 0]), angle)
    local = motion.local_rotations.astype(np.float64)
    local[:, 0] = rotation.multiply(np.broadcast_to(q, local[:, 0].shape), local[:, 0])
    root = rotation.rotate(q, motion.root_positions.astype(np.float64)) + np.array([x, 0, z])
    return replace(
        motion, local_rotations=local.astype(np.float32), root_positions=root.astype(np.float32)
    )


def rigid(pelvis: FloatArray) -> FloatArray:
    """World rotations (frames, 21, 4) of a body that turns as one."""
    return np.repeat(pelvis[:, None], 21, axis=1)


@settings(deadline=None, max_examples=10)
@given(st.floats(-4, 4), st.floats(-50, 50), st.floats(-50, 50), st.integers(0, 5))
def test_place_and_heading_do_not_matter(
    make_motion: MotionMaker, angle: float, x: float, z: float, seed: int
) -> None:
    motion = make_motion(40, seed)
    moved = features.recognition_features(turned(motion, angle, x, z))
    np.testing.assert_allclose(features.recognition_features(motion), moved, atol=2e-4)


@settings(deadline=None, max_examples=5)
@given(st.floats(0.2, 3.0), st.integers(0, 5))
def test_size_does_not_matter(make_motion: MotionMaker, size: float, seed: int) -> None:
    positions, _ = retarget.motion_positions(make_motion(40, seed))
    one = retarget.motion_from_positions(positions, 30.0)
    other = retarget.motion_from_positions(positions * size, 30.0)
    assert other.leg_length == pytest.approx(size * one.leg_length)
    np.testing.assert_allclose(
        features.recognition_features(one), features.recognition_features(other), atol=1e-3
    )


def test_a_step_ahead_by_hand() -> None:
    local = np.tile(rotation.IDENTITY, (11, 21, 1)).astype(np.float32)
    root = np.stack([0.3 * np.arange(11) / 30, np.full(11, 0.93), np.full(11, 5.0)], axis=1)
    facing_x = rotation.from_euler([90.0], "Y")
    local[:, 0] = facing_x
    values = features.recognition_features(Motion(local, root.astype(np.float32)))
    assert values.shape == (6, features.N_FEATURES) == (6, 130)
    np.testing.assert_allclose(values[:, :3], np.tile([0, 0.93, 0], (6, 1)), atol=1e-6)
    np.testing.assert_allclose(values[:, 3:6], np.tile([0.09, 0.93, 0], (6, 1)), atol=1e-6)
    np.testing.assert_allclose(values[:, 63:126], 0.0, atol=1e-4)
    expected = features.ROOT_WEIGHT * np.array([0, 0, 0.3, 0]) * features.VELOCITY_SECONDS
    np.testing.assert_allclose(values[:, 126:], np.tile(expected, (6, 1)), atol=1e-4)


def test_central_differences_by_hand() -> None:
    values = np.array([0.0, 1.0, 4.0, 9.0])
    np.testing.assert_allclose(features.velocity(values, 2.0), [2.0, 4.0, 8.0, 10.0])


def test_headings_of_two_full_turns_are_unwrapped() -> None:
    angles = np.linspace(0, 720, 100)
    actual = features.headings(rigid(rotation.from_euler(angles[:, None], "Y")))
    np.testing.assert_allclose(np.rad2deg(actual), angles, atol=1e-6)


def test_a_slanted_cartwheel_turns_smoothly() -> None:
    """Leaning into it, and a quarter turn on the way, as a gymnast does."""
    share = np.linspace(0, 1, 60)
    angles = np.stack([90 * share, 360 * share, 25 * np.sin(np.pi * share)], axis=1)
    actual = features.headings(rigid(rotation.from_euler(angles, "YZX")))
    assert actual[-1] - actual[0] == pytest.approx(np.pi / 2, abs=1e-6)
    assert np.abs(np.diff(actual)).max() < 0.2


def test_one_who_lies_and_rolls_ends_where_the_body_points() -> None:
    """Neither axis stays level in a roll on the ground: interpolated, finite, no leap over pi."""
    angles = np.stack([np.full(60, -90.0), np.linspace(0, 360, 60)], axis=1)
    actual = features.headings(rigid(rotation.from_euler(angles, "XY")))
    assert np.isfinite(actual).all()
    assert np.abs(np.diff(actual)).max() < np.pi


def test_where_no_frame_is_sure_the_surest_is_taken() -> None:
    upright_left = rotation.from_euler(np.array([[90.0], [90.0], [89.0]]), "Z")
    both = rotation.multiply(upright_left, np.tile(rotation.from_euler([-90.0], "X"), (3, 1)))
    actual = features.headings(rigid(both))
    assert actual.shape == (3,)
    assert np.isfinite(actual).all()


@settings(deadline=None, max_examples=10)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=8), st.integers(1, 60))
def test_features_of_many_motions_are_those_of_each(
    make_motion: MotionMaker, lengths: list[int], block: int
) -> None:
    motions = [make_motion(length, seed) for seed, length in enumerate(lengths)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(features, "BLOCK", block)
        together = features.features_of_motions(motions)
    assert len(together) == len(motions)
    for motion, actual in zip(motions, together):
        np.testing.assert_array_equal(actual, features.recognition_features(motion))


@pytest.mark.parametrize("length", [1, 2, 3, 40])
def test_features_are_those_of_the_whole_motion(make_motion: MotionMaker, length: int) -> None:
    """Twin: velocities by `velocity` of all frames, then every second frame."""
    motion = make_motion(length, 1)
    positions, rotations = retarget.motion_positions(motion)
    heading = features.headings(rotations)
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), -heading)
    local = rotation.rotate(facing[:, None], positions - positions[:, :1] * [1.0, 0.0, 1.0])
    root = rotation.rotate(facing, features.velocity(positions[:, 0], 30.0))
    parts = [
        local,
        0.6 * features.velocity(local, 30.0) / 3.0,
        2.0 * root / 3.0,
        2.0 * features.velocity(heading, 30.0) / 3.0,
    ]
    expected = np.concatenate([part.reshape(length, -1) for part in parts], axis=1)[::2]
    np.testing.assert_allclose(features.recognition_features(motion), expected, atol=1e-5)


def test_compiled_kinematics_are_those_of_numpy_to_the_last_bit(make_motion: MotionMaker) -> None:
    motion = make_motion(40, 3)
    local, root = motion.local_rotations, motion.root_positions
    actual = kernels.forward(body.PARENTS, body.OFFSETS, local, root)
    doubles = local.astype(np.float64), root.astype(np.float64)
    places, turns = kinematics.forward(body.PARENTS, body.OFFSETS, *doubles)
    np.testing.assert_array_equal(actual[0], places)
    np.testing.assert_array_equal(actual[1], turns)
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.linspace(-4.0, 4.0, 40))
    seen = rotation.rotate(facing[:, None], places - places[:, :1] * [1.0, 0.0, 1.0])
    np.testing.assert_array_equal(kernels.relative_to_heading(places, facing), seen)
    for axis, found in zip(np.eye(3), kernels.mean_axes(turns, (0, 4)), strict=True):
        both = rotation.rotate(turns[:, (0, 4)], axis[None, None])
        np.testing.assert_array_equal(found, (both[:, 0] + both[:, 1]) / 2.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("facing", [0.0, 1.0])
@pytest.mark.parametrize("order", ["YZ", "YX"])
def test_cartwheels_and_somersaults_keep_their_heading(
    order: str, facing: float, side: float
) -> None:
    angles = np.rad2deg(facing) * np.ones(60), np.linspace(0, 360 * side, 60)
    actual = features.headings(rigid(rotation.from_euler(np.stack(angles, axis=1), order)))
    np.testing.assert_allclose(actual, facing, atol=1e-9)
