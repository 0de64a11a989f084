"""Forward kinematics and the two-bone solution: by hand, against matrices, as properties."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import body, kinematics, rotation
from motiondb.records import Clip, FloatArray, IntArray, Skeleton

few = settings(deadline=None, max_examples=25)
AHEAD = np.array([[0.0, 0.0, 1.0]])


def by_matrices(
    parents: IntArray, offsets: FloatArray, local: FloatArray, root: FloatArray
) -> FloatArray:
    """Positions of one frame by products of 4 x 4 matrices up to the root."""
    places = []
    for joint in range(len(parents)):
        point = np.array([0.0, 0, 0, 1])
        while joint >= 0:
            step = np.eye(4)
            step[:3, :3] = rotation.to_matrix(local[joint])
            step[:3, 3] = offsets[joint] if parents[joint] >= 0 else root
            point, joint = step @ point, parents[joint]
        places.append(point[:3])
    return np.array(places)


@few
@given(st.integers(0, 10**6))
def test_forward_equals_products_of_matrices(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = len(body.JOINTS)
    local, root = rotation.normalize(rng.normal(size=(2, n, 4))), rng.normal(size=(2, 3))
    positions, _ = kinematics.forward(body.PARENTS, body.OFFSETS, local, root)
    for frame in range(2):
        expected = by_matrices(body.PARENTS, body.OFFSETS, local[frame], root[frame])
        np.testing.assert_allclose(positions[frame], expected, atol=1e-12)
    bones = np.linalg.norm(positions[:, 1:] - positions[:, body.PARENTS[1:]], axis=-1)
    lengths = np.linalg.norm(body.OFFSETS[1:], axis=-1)
    np.testing.assert_allclose(bones, np.broadcast_to(lengths, bones.shape), atol=1e-12)


@few
@given(st.integers(0, 10**6), st.lists(st.integers(0, 20), min_size=1, max_size=3))
def test_joints_that_are_asked_for_are_as_among_all(seed: int, joints: list[int]) -> None:
    rng = np.random.default_rng(seed)
    local, root = rotation.normalize(rng.normal(size=(4, 21, 4))), rng.normal(size=(4, 3))
    whole = kinematics.forward(body.PARENTS, body.OFFSETS, local, root)
    part = kinematics.forward(body.PARENTS, body.OFFSETS, local, root, joints)
    for all_of_it, some in zip(whole, part, strict=True):
        np.testing.assert_array_equal(some[:, joints], all_of_it[:, joints])
    above = {0, *joints, *(int(body.PARENTS[joint]) for joint in joints)}
    blank = np.isnan(part[0]).all(axis=(0, 2))
    assert not blank[sorted(above - {-1})].any()
    assert blank[20] == (20 not in joints)  # a wrist lies on the way to nothing else


def test_joint_positions_of_a_clip_replace_its_offsets() -> None:
    skeleton = Skeleton(("a", "b"), np.array([-1, 0]), np.array([[0.0, 0, 0], [1, 0, 0]]))
    turns = np.tile(rotation.IDENTITY, (2, 2, 1))
    moved = np.array([[[0.0, 0, 0], [1, 0, 0]], [[0, 0, 0], [3, 0, 0]]])
    clip = Clip(skeleton, 30.0, turns, np.zeros((2, 3)), joint_positions=moved)
    positions, _ = kinematics.clip_positions(clip)
    np.testing.assert_allclose(positions[:, 1, 0], [1.0, 3.0])


def bend(
    hip: FloatArray, knee: FloatArray, ankle: FloatArray, target: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Where knee and ankle end when the two rotations are applied."""
    upper, lower = kinematics.two_bone(hip, knee, ankle, target, np.tile(AHEAD, (len(hip), 1)))
    new_knee = hip + rotation.rotate(upper, knee - hip)
    return new_knee, new_knee + rotation.rotate(lower, ankle - knee)


def test_a_straight_leg_bends_ahead_by_hand() -> None:
    hip, knee, ankle = (np.array([[0.0, y, 0.0]]) for y in (2.0, 1.0, 0.0))
    new_knee, new_ankle = bend(hip, knee, ankle, np.array([[0.0, 2.0 - np.sqrt(2.0), 0.0]]))
    np.testing.assert_allclose(new_ankle, [[0, 2.0 - np.sqrt(2.0), 0]], atol=1e-9)
    np.testing.assert_allclose(new_knee, [[0, 2.0 - HALF_ROOT, HALF_ROOT]], atol=1e-9)


HALF_ROOT = np.sqrt(0.5)


@few
@given(st.integers(0, 10**6))
def test_two_bones_reach_and_keep_their_lengths(seed: int) -> None:
    rng = np.random.default_rng(seed)
    hip, knee, ankle = rng.normal(size=(3, 6, 3))
    a, b = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    reach = rng.uniform(np.abs(a - b) + 0.01, (a + b) * 0.99)
    target = hip + rotation.normalize(rng.normal(size=(6, 3))) * reach[:, None]
    new_knee, new_ankle = bend(hip, knee, ankle, target)
    np.testing.assert_allclose(new_ankle, target, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(new_knee - hip, axis=1), a)
    np.testing.assert_allclose(np.linalg.norm(new_ankle - new_knee, axis=1), b)


def test_a_target_out_of_reach_is_approached() -> None:
    hip, knee, ankle = (np.array([[0.0, y, z]]) for y, z in ((2, 0), (1, 0.1), (0, 0)))
    length = 2 * np.hypot(1, 0.1)
    _, new_ankle = bend(hip, knee, ankle, np.array([[0.0, -3.0, 0.0]]))
    np.testing.assert_allclose(new_ankle, [[0, 2 - length, 0]], atol=1e-3)


def test_the_body_is_its_own_mirror_image() -> None:
    np.testing.assert_array_equal(body.MIRROR[body.MIRROR], np.arange(21))
    np.testing.assert_allclose(body.OFFSETS[body.MIRROR] * [-1, 1, 1], body.OFFSETS)
    assert body.JOINTS[body.MIRROR[body.INDEX["l_toe"]]] == "r_toe"
    assert body.MIRROR[body.INDEX["chest"]] == body.INDEX["chest"]


def test_the_standard_skeleton_scales_with_the_leg() -> None:
    skeleton = body.standard_skeleton(1.7)
    np.testing.assert_allclose(skeleton.offsets, 2 * body.OFFSETS)
    assert skeleton.end_sites[0] == (body.INDEX["head"], (0.0, 0.36, 0.0))
