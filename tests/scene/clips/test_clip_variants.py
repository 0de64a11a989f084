"""Bent and stretched paths against a slow twin, and which variants are made."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import rotation
from motiondb.body.pose_vectors import yaw
from motiondb.scene.clips.clip_cutting import compose, inverse, relative
from motiondb.scene.clips.clips import (
    VariantSettings,
    edited_paths,
    edited_stretch,
    edits_of,
)


def slow(path: np.ndarray, bend: float, stretch: float) -> np.ndarray:
    """Step by step: each step is turned by the bend of its middle and scaled."""
    n = len(path) - 1
    edited = [path[0].copy()]
    for t in range(n):
        step = path[t + 1, :2] - path[t, :2]
        turn = np.array([0.0, 0.0, bend * (t + 0.5) / n])
        moved = compose(turn, np.array([stretch * step[0], stretch * step[1], 0.0]))
        heading = path[t + 1, 2] + bend * (t + 1) / n
        edited.append(np.array([*(edited[-1][:2] + moved[:2]), heading]))
    return np.array(edited)


@given(st.integers(1, 30), st.floats(-2.0, 2.0), st.floats(0.5, 2.0), st.integers(0, 99))
def test_bending_and_stretching_are_step_by_step(
    n: int, bend: float, stretch: float, seed: int
) -> None:
    path = np.vstack([np.zeros(3), np.random.default_rng(seed).normal(size=(n, 3))])
    (actual,) = edited_paths(path, np.array([[bend, stretch]]))
    np.testing.assert_allclose(actual, slow(path, bend, stretch), atol=1e-9)


def test_frames_around_a_clip_bend_no_further() -> None:
    path = np.column_stack([np.zeros(31), np.arange(31) / 10.0, np.zeros(31)])
    shares = np.clip((np.arange(31) - 10) / 10.0, 0.0, 1.0)
    around = edited_stretch(path, shares, 0.8, 1.2)
    (inside,) = edited_paths(path[10:21] - path[10], np.array([[0.8, 1.2]]))
    np.testing.assert_allclose(relative(around[10:21], around[10]), inside, atol=1e-9)
    np.testing.assert_allclose(around[:10, 2], 0.0)
    np.testing.assert_allclose(around[21:, 2], 0.8)


def way(length: float, n: int = 30) -> np.ndarray:
    return np.column_stack([np.zeros(n + 1), np.linspace(0.0, length, n + 1), np.zeros(n + 1)])


def test_variants_are_made_of_what_travels() -> None:
    settings = VariantSettings(
        bends=(-0.5, 0.0, 0.5), stretches=(0.8, 1.0), rest_bends=(-1.5, 0.0), turns=(0.0, 0.2)
    )
    assert edits_of(way(1.0), "middle", settings).tolist() == [
        [-0.5, 0.8], [-0.5, 1.0], [0.0, 0.8], [0.0, 1.0], [0.5, 0.8], [0.5, 1.0],
    ]  # fmt: skip
    assert edits_of(way(1.0), "start", settings).tolist() == [
        [-1.5, 0.8], [-1.5, 1.0], [0.0, 0.8], [0.0, 1.0],
    ]  # fmt: skip
    assert edits_of(way(0.2), "stop", settings).tolist() == [[-1.5, 1.0], [0.0, 1.0]]
    assert edits_of(way(0.05), "stop", settings).tolist() == [[0.0, 1.0], [0.2, 1.0]]
    assert edits_of(way(0.0), "whole", settings).tolist() == [[0.0, 1.0], [0.2, 1.0]]


def test_nobody_turns_faster_than_people_do() -> None:
    """240 degrees a second: 40 degrees take 5 frames, 41 take more."""
    bends = VariantSettings(bends=(np.radians(40.0), np.radians(41.0)), stretches=(1.0,))
    assert len(edits_of(way(1.0, 5), "middle", bends)) == 1
    assert len(edits_of(way(1.0, 6), "middle", bends)) == 2


number = st.floats(-20.0, 20.0)
places = st.builds(lambda x, z, t: np.array([x, z, t]), number, number, number)


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
