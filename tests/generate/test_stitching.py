"""Stitching: the choice against enumeration, seams by hand, every frame with its source."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import rotation
from motiondb.generate import stitching
from motiondb.generate.stitching import Candidates, Piece
from motiondb.records import FloatArray

Sources = dict[int, tuple[FloatArray, FloatArray]]


def random_candidates(rng: np.random.Generator) -> Candidates:
    n = int(rng.integers(1, 5))
    starts = rng.integers(0, 4, n) * 10
    return Candidates(
        rng.integers(0, 2, n),
        starts,
        starts + 10,
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 3)),
        rng.uniform(0, 2, n),
    )


def cost_of(
    candidates: list[Candidates], path: tuple[int, ...], weight: float, continuing: float
) -> float:
    """Target and join costs of a path, written out."""
    total = sum(float(c.targets[i]) for c, i in zip(candidates, path))
    for k in range(1, len(path)):
        a, b, i, j = candidates[k - 1], candidates[k], path[k - 1], path[k]
        if a.captures[i] == b.captures[j] and a.ends[i] == b.starts[j]:
            total += weight * continuing
            continue
        total += weight * (float(np.sum((a.continuations[i] - b.entries[j]) ** 2)) + 1e-3)
        if a.captures[i] == b.captures[j] and set(range(a.starts[i], a.ends[i])) & set(
            range(b.starts[j], b.ends[j])
        ):
            total += weight * stitching.AGAIN_COST
    return total


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 4), st.floats(0, 2), st.sampled_from([0.0, 0.7]))
def test_the_choice_equals_enumeration(
    seed: int, length: int, weight: float, continuing: float
) -> None:
    rng = np.random.default_rng(seed)
    candidates = [random_candidates(rng) for _ in range(length)]
    chosen = stitching.choose(candidates, weight, continuing=continuing)
    every = product(*(range(len(c.targets)) for c in candidates))
    best = min(cost_of(candidates, path, weight, continuing) for path in every)
    assert cost_of(candidates, tuple(chosen), weight, continuing) == pytest.approx(best)


def sources(n_captures: int = 3, n_frames: int = 60) -> Sources:
    """Captures whose height is 100 * capture + frame, turned by as many milliradians."""
    made: Sources = {}
    for capture in range(n_captures):
        values = 100.0 * capture + np.arange(n_frames)
        path = np.repeat(values[:, None], 4, axis=1)
        turn = rotation.from_axis_angle(np.array([1.0, 0, 0]), values * 1e-3)
        made[capture] = (path, np.repeat(turn[:, None], 21, axis=1))
    return made


def steady(value: float, turn: float) -> tuple[FloatArray, FloatArray]:
    """60 frames of path values and rotations (radians about x) that do not change."""
    turned = rotation.from_axis_angle(np.array([1.0, 0, 0]), np.full(60, turn))
    return np.full((60, 4), float(value)), np.repeat(turned[:, None], 21, axis=1)


def least_jerk(n: int) -> FloatArray:
    """The step from 0 to 1 of least jerk over 2 n frames, at n frames on each side: (2 n,)."""
    x = (np.arange(-n, n) + n) / (2.0 * n)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x)


def test_a_seam_of_steady_motion_is_the_step_of_least_jerk() -> None:
    made = stitching.stitch(
        [Piece(0, 0, 60), Piece(1, 0, 60)], {0: steady(1, 0), 1: steady(3, 0.1)}
    )
    half = math.ceil(stitching.PEAK * np.hypot(2, 2) / stitching.MOST_SPEEDING)
    seam = slice(60 - half, 60 + half)
    np.testing.assert_allclose(made.path[seam, 0], 1.0 + 2.0 * least_jerk(half), atol=1e-9)
    angles = rotation.log(made.rotations[seam, 4])[:, 0]
    np.testing.assert_allclose(angles, 0.1 * least_jerk(half), atol=1e-9)
    assert np.abs(np.diff(np.hypot(*made.path[:, 1:3].T))).max() <= stitching.MOST_SPEEDING
    outside = np.r_[0 : 60 - half, 60 + half : 120]
    assert set(made.path[outside, 0]) == {1.0, 3.0}
    assert made.frames[58:62].tolist() == [58, 59, 0, 1]
    assert made.captures[58:62].tolist() == [0, 0, 1, 1]
    assert made.shares[60] == 0.5


def test_a_seam_of_motion_that_goes_on_changes_nothing() -> None:
    """Heights and angles that rise by 1 a frame, and pieces that follow one another in them."""
    path, turned = sources()[0]
    path[:, 1:] = 0.5
    made = stitching.stitch(
        [Piece(0, 10, 30), Piece(1, 30, 60)], {0: (path, turned), 1: (path, turned)}
    )
    np.testing.assert_allclose(made.path, path[10:60], atol=1e-9)
    np.testing.assert_allclose(made.rotations, turned[10:60], atol=1e-9)


def test_a_seam_is_as_smooth_as_both_sides() -> None:
    """A height that rises by .01 a frame and stops: no velocity changes by more than the step."""
    rising, _ = steady(0.0, 0.0)
    rising[:, 0] = 0.01 * np.arange(60)
    still, turned = steady(0.0, 0.0)
    still[:, 0] = 0.7
    made = stitching.stitch(
        [Piece(0, 0, 60), Piece(1, 0, 60)], {0: (rising, turned), 1: (still, turned)}
    )
    change = np.abs(np.diff(made.path[:, 0], 2))
    assert change.max() < 0.01  # at once it would be .09
    velocities = np.diff(made.path[:, 0])
    assert velocities[:40] == pytest.approx(0.01)
    assert velocities[-40:] == pytest.approx(0.0, abs=1e-12)


@st.composite
def pieces(draw: st.DrawFn) -> list[Piece]:
    made = []
    for _ in range(draw(st.integers(1, 6))):
        start = draw(st.integers(0, 58))
        end = draw(st.integers(start + 1, 60))
        made.append(Piece(draw(st.integers(0, 2)), start, end))
    return made


@settings(deadline=None, max_examples=60)
@given(pieces())
def test_frames_add_up_and_know_their_source(chosen: list[Piece]) -> None:
    made = stitching.stitch(chosen, sources())
    n_frames = sum(p.end - p.start for p in chosen)
    assert len(made.path) == len(made.rotations) == n_frames
    assert len(made.captures) == len(made.frames) == len(made.shares) == n_frames
    assert made.frames.min() >= 0
    assert made.frames.max() < 60
    assert made.shares.min() >= 0.5
    whole = made.shares == 1.0
    np.testing.assert_allclose(
        made.path[whole, 0], 100.0 * made.captures[whole] + made.frames[whole]
    )
    np.testing.assert_allclose(np.linalg.norm(made.rotations, axis=-1), 1.0)
