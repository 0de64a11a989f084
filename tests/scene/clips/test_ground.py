"""Places on the ground: worked numbers, the group's laws, and the same turn in space."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import rotation
from motiondb.body.pose_vectors import yaw
from motiondb.scene.clips.clip_cutting import compose, inverse, relative

number = st.floats(-20.0, 20.0)
places = st.builds(lambda x, z, t: np.array([x, z, t]), number, number, number)


def test_a_step_ahead_goes_where_one_looks() -> None:
    looking_right = np.array([1.0, 2.0, np.pi / 2])  # towards +x
    ahead, left = np.array([0.0, 3.0, 0.5]), np.array([3.0, 0.0, 0.0])
    np.testing.assert_allclose(compose(looking_right, ahead), [4.0, 2.0, np.pi / 2 + 0.5])
    np.testing.assert_allclose(compose(looking_right, left), [1.0, -1.0, np.pi / 2], atol=1e-12)


@given(places, places)
def test_it_is_a_turn_about_the_vertical_and_a_shift(first: np.ndarray, second: np.ndarray) -> None:
    point = np.array([second[0], 0.0, second[1]])
    turned = rotation.rotate(yaw(first[2]), point)
    actual = compose(first, second)
    np.testing.assert_allclose(actual[:2], first[:2] + turned[[0, 2]], atol=1e-9)
    ahead = rotation.rotate(yaw(actual[2]), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(ahead[[0, 2]], [np.sin(actual[2]), np.cos(actual[2])], atol=1e-9)


@given(places, places, places)
def test_order_of_brackets_does_not_matter_and_inverses_undo(
    a: np.ndarray, b: np.ndarray, c: np.ndarray
) -> None:
    np.testing.assert_allclose(compose(compose(a, b), c), compose(a, compose(b, c)), atol=1e-9)
    np.testing.assert_allclose(compose(inverse(a), compose(a, b)), b, atol=1e-9)
    np.testing.assert_allclose(compose(a, relative(b, a)), b, atol=1e-9)


def test_leading_axes_broadcast() -> None:
    many = np.random.default_rng(0).normal(size=(4, 5, 3))
    one = np.array([1.0, -2.0, 0.3])
    actual = compose(one, many)
    assert actual.shape == (4, 5, 3)
    np.testing.assert_allclose(actual[2, 3], compose(one, many[2, 3]))
