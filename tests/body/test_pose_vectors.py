"""Pose vectors: there and back, and the mean rotation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import features, pose_vectors, retarget, rotation
from motiondb.records import Motion

MotionMaker = Callable[..., Motion]
few = settings(deadline=None, max_examples=8)


def start_of(motion: Motion) -> tuple[tuple[float, float], float]:
    """Where a motion begins, (x, z), and its first heading."""
    _, world = retarget.motion_positions(motion)
    x, _, z = motion.root_positions[0]
    return (float(x), float(z)), float(features.headings(world)[0])


def to_vectors(motion: Motion, means: np.ndarray) -> np.ndarray:
    """The way there: rotations about their means."""
    path, local = pose_vectors.to_path(motion)
    turning = pose_vectors.TURNING
    relative = rotation.multiply(rotation.conjugate(means)[turning], local[:, turning])
    return np.concatenate([path, rotation.log(relative).reshape(len(path), -1)], axis=1)


@few
@given(st.integers(0, 10**6), st.floats(-3, 3))
def test_vectors_give_the_motion_back(make_motion: MotionMaker, seed: int, turn: float) -> None:
    motion = make_motion(50, seed, 0.7, turn)
    means = pose_vectors.mean_rotations(pose_vectors.to_path(motion)[1])
    vectors = to_vectors(motion, means)
    assert vectors.shape == (50, pose_vectors.N_VALUES) == (50, 52)
    back = pose_vectors.from_vectors(vectors, means, *start_of(motion), motion.leg_length)
    there, _ = retarget.motion_positions(motion)
    here, _ = retarget.motion_positions(back)
    np.testing.assert_allclose(here, there, atol=1e-4)
    assert back.leg_length == motion.leg_length


@few
@given(st.floats(-3, 3), st.floats(-5, 5), st.floats(-5, 5))
def test_start_and_heading_are_as_asked(
    make_motion: MotionMaker, heading: float, x: float, z: float
) -> None:
    path, local = pose_vectors.to_path(make_motion(20, 1))
    motion = pose_vectors.from_path(path, local, (x, z), heading)
    (found_x, found_z), actual = start_of(motion)
    np.testing.assert_allclose([found_x, found_z], [x, z], atol=1e-5)
    assert np.cos(actual - heading) == pytest.approx(1.0, abs=1e-6)


def test_a_straight_walk_by_hand() -> None:
    local = np.tile(rotation.IDENTITY, (4, 21, 1)).astype(np.float32)
    local[:, 0] = rotation.from_euler([90.0], "Y")
    root = np.array([[0.1 * t, 0.9, 2.0] for t in range(4)], dtype=np.float32)
    path, turned = pose_vectors.to_path(Motion(local, root))
    np.testing.assert_allclose(path, np.tile([0.9, 0.0, 3.0, 0.0], (4, 1)), atol=1e-5)
    np.testing.assert_allclose(turned[:, 0], np.tile(rotation.IDENTITY, (4, 1)), atol=1e-6)


def test_a_single_frame_stands_still(make_motion: MotionMaker) -> None:
    path, local = pose_vectors.to_path(make_motion(1))
    np.testing.assert_array_equal(path[:, 1:], 0.0)
    assert pose_vectors.from_path(path, local).n_frames == 1


@few
@given(st.integers(0, 10**6))
def test_the_mean_has_the_least_squared_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = rotation.exp(rng.normal(0, 0.4, size=(30, 1, 3))) * rng.choice([-1.0, 1.0], (30, 1, 1))
    mean = pose_vectors.mean_rotations(q)

    def cost(p: np.ndarray) -> float:
        return float(np.sum(1.0 - np.sum(q[:, 0] * p, axis=-1) ** 2))

    for _ in range(20):
        near = rotation.multiply(mean[0], rotation.exp(rng.normal(0, 0.1, size=3)))
        assert cost(mean[0]) <= cost(near) + 1e-12
