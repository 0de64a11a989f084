"""Rotation algebra: by hand, against scipy, and as properties."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motiondb.body import rotation
from motiondb.records import FloatArray

HALF = np.sqrt(0.5)
ORDERS = ["".join(p) for p in permutations("XYZ")]
few = settings(deadline=None, max_examples=25)
seeds = st.integers(0, 10**6)


def quaternions(seed: int, *shape: int) -> FloatArray:
    return rotation.normalize(np.random.default_rng(seed).normal(size=(*shape, 4)))


def oracle(q: FloatArray) -> Rotation:
    return Rotation.from_quat(q, scalar_first=True)


def same(p: FloatArray, q: FloatArray, atol: float = 1e-9) -> bool:
    """Equal as rotations: up to sign."""
    return bool(np.allclose(np.abs(np.sum(p * q, axis=-1)), 1.0, atol=atol))


def test_quarter_turns_by_hand() -> None:
    about_y = np.array([HALF, 0, HALF, 0])
    np.testing.assert_allclose(
        rotation.rotate(about_y, np.array([0.0, 0, 1])), [1, 0, 0], atol=1e-15
    )
    np.testing.assert_allclose(rotation.multiply(about_y, about_y), [0, 0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(rotation.log(about_y), [0, np.pi / 2, 0])
    np.testing.assert_allclose(
        rotation.to_matrix(about_y), [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-15
    )
    np.testing.assert_allclose(rotation.from_axis_angle([0.0, 1, 0], np.pi / 2), about_y)


@few
@given(seeds)
def test_products_and_matrices_equal_scipy(seed: int) -> None:
    p, q = quaternions(seed, 5), quaternions(seed + 1, 5)
    v = np.random.default_rng(seed).normal(size=(5, 3))
    assert same(rotation.multiply(p, q), (oracle(p) * oracle(q)).as_quat(scalar_first=True))
    np.testing.assert_allclose(rotation.rotate(p, v), oracle(p).apply(v), atol=1e-12)
    np.testing.assert_allclose(rotation.to_matrix(p), oracle(p).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(rotation.log(p), oracle(p).as_rotvec(), atol=1e-9)


@few
@given(seeds, st.sampled_from(ORDERS))
def test_euler_angles_equal_scipy_and_come_back(seed: int, order: str) -> None:
    angles = np.random.default_rng(seed).uniform([-179, -89, -179], [179, 89, 179], size=(4, 3))
    q = rotation.from_euler(angles, order)
    assert same(q, Rotation.from_euler(order, angles, degrees=True).as_quat(scalar_first=True))
    np.testing.assert_allclose(rotation.to_euler(q, order), angles, atol=1e-6)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("middle", [90.0, -90.0])
def test_gimbal_lock_gives_the_same_rotation_with_last_angle_zero(
    order: str, middle: float
) -> None:
    q = rotation.from_euler([30.0, middle, 20.0], order)
    angles = rotation.to_euler(q, order)
    assert angles[2] == 0.0
    assert same(rotation.from_euler(angles, order), q, atol=1e-7)


@few
@given(seeds)
def test_matrix_and_log_go_back(seed: int) -> None:
    q = quaternions(seed, 3, 2)
    assert same(rotation.from_matrix(rotation.to_matrix(q)), q)
    assert same(rotation.exp(rotation.log(q)), q)
    assert same(
        rotation.multiply(q, rotation.conjugate(q)), np.broadcast_to([1.0, 0, 0, 0], q.shape)
    )


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_half_turns_go_through_every_branch_of_from_matrix(axis: int) -> None:
    q = np.zeros(4)
    q[1 + axis] = 1.0
    assert same(rotation.from_matrix(rotation.to_matrix(q)), q)
    np.testing.assert_allclose(np.linalg.norm(rotation.log(q)), np.pi)


@few
@given(seeds)
def test_between_is_the_smallest_rotation(seed: int) -> None:
    u, v = np.random.default_rng(seed).normal(size=(2, 6, 3))
    q = rotation.between(u, v)
    np.testing.assert_allclose(
        rotation.rotate(q, rotation.normalize(u)), rotation.normalize(v), atol=1e-9
    )
    cosine = np.sum(rotation.normalize(u) * rotation.normalize(v), axis=-1)
    np.testing.assert_allclose(np.linalg.norm(rotation.log(q), axis=-1), np.arccos(cosine))


@pytest.mark.parametrize("u", [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [1.0, -2.0, 0.5]])
def test_between_opposites_is_half_a_turn(u: list[float]) -> None:
    vector = np.array(u)
    q = rotation.between(vector, -vector)
    np.testing.assert_allclose(rotation.rotate(q, vector), -vector, atol=1e-7)
    assert np.linalg.norm(rotation.log(q)) == pytest.approx(np.pi)


def test_half_way_between_two_rotations_by_hand() -> None:
    p, q = rotation.from_euler([[10.0], [50.0]], "X")
    np.testing.assert_allclose(rotation.slerp(p, q, 0.5), rotation.from_euler([30.0], "X"))
    assert same(rotation.slerp(p, -q, 0.25), rotation.from_euler([20.0], "X"))


@few
@given(seeds)
def test_unrolled_quaternions_never_flip_and_stay_the_same_rotation(seed: int) -> None:
    path = np.cumsum(np.random.default_rng(seed).normal(0, 0.3, size=(40, 2, 3)), axis=0)
    smooth = rotation.exp(path)
    signs = np.random.default_rng(seed + 1).choice([-1.0, 1.0], size=(40, 2, 1))
    unrolled = rotation.unroll(smooth * signs)
    assert np.all(np.sum(unrolled[1:] * unrolled[:-1], axis=-1) >= 0)
    assert same(unrolled, smooth)


def test_zero_vectors_stay_zero() -> None:
    np.testing.assert_array_equal(rotation.normalize(np.zeros((2, 3))), np.zeros((2, 3)))
