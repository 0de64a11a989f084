"""Pose and segment distances: what they do not see, worked numbers, the slow twin."""

import naive_terminals as naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import rotation
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.terminals import distances
from motiondb.grammar.terminals.distances import (
    segment_distance,
)
from motiondb.records import Motion


def line(*places: float) -> np.ndarray:
    return np.array(places, dtype=np.float32)[:, None]


def test_segments_of_one_length_are_compared_frame_by_frame() -> None:
    values = line(0, 1, 2, 4, 4, 4)
    assert segment_distance(values, 0, 3, 3, 6) == pytest.approx((4 + 3 + 2) / 3)


def test_the_shorter_segment_is_stretched_evenly() -> None:
    values = line(0, 1, 2, 3, 4, 10, 20)
    # frames 0..4 against floor(m 2 / 5) = 0, 0, 0, 1, 1
    assert segment_distance(values, 0, 5, 5, 7) == pytest.approx((10 + 9 + 8 + 17 + 16) / 5)
    assert segment_distance(values, 5, 7, 0, 5) == segment_distance(values, 0, 5, 5, 7)


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 10_000))
def test_it_is_the_printed_formula_symmetric_and_zero_for_itself(n: int, m: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(n + m, 3)).astype(np.float32)
    actual = segment_distance(values, 0, n, n, n + m)
    assert actual == pytest.approx(naive.segment_distance(values, 0, n, n, n + m), rel=1e-5)
    assert actual == segment_distance(values, n, n + m, 0, n)
    assert segment_distance(values, 0, n, 0, n) == 0.0


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 8), st.integers(1, 4), st.integers(1, 3), st.integers(0, 10_000))
def test_repeating_every_frame_changes_nothing(
    length: int, slower: int, times: int, seed: int
) -> None:
    """Where one length is a multiple of the other; rounding down is exact there."""
    values = np.random.default_rng(seed).normal(size=(length * (slower + 1), 3)).astype(np.float32)
    twice = np.repeat(values, times, axis=0)
    a, b = length * slower, len(values)
    assert segment_distance(twice, 0, a * times, a * times, b * times) == pytest.approx(
        segment_distance(values, 0, a, a, b), rel=1e-5
    )
    one = values[:length]
    both = np.concatenate([one, np.repeat(one, times, axis=0)])
    assert segment_distance(both, 0, length, length, len(both)) == 0.0


def test_poses_do_not_see_place_and_heading() -> None:
    motion = naive.swinging_motion(60)
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(1.1))
    rotations = motion.local_rotations.astype(np.float64)
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    root = rotation.rotate(turn, motion.root_positions.astype(np.float64)) + np.array(
        [3.0, 0.0, -2.0]
    )
    moved = Motion(rotations.astype(np.float32), root.astype(np.float32))
    assert np.allclose(distances.pose_vectors(motion), distances.pose_vectors(moved), atol=2e-5)


def test_principal_axes_keep_the_distances() -> None:
    motion = naive.swinging_motion(80)
    raw = distances.pose_vectors(motion)
    values = distances.make_poses([motion]).values
    assert values.shape[1] < raw.shape[1]
    full = np.linalg.norm(raw[:, None] - raw[None], axis=2)
    kept = np.linalg.norm(values[:, None] - values[None], axis=2)
    assert (kept <= full + 1e-4).all()
    assert (kept**2).sum() >= distances.KEPT * (full**2).sum() - 1e-6


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 60), st.integers(1, 4), st.integers(0, 10_000))
def test_the_largest_distance_is_exact(n: int, dimensions: int, seed: int) -> None:
    values = np.random.default_rng(seed).standard_t(2, size=(n, dimensions))
    full = np.linalg.norm(values[:, None] - values[None], axis=2)
    assert distances.largest_distance(values, block=5) == pytest.approx(full.max(), rel=1e-9)


def test_takes_that_cannot_be_used_are_named() -> None:
    good = naive.swinging_motion(20)
    broken = Motion(good.local_rotations, np.full((20, 3), np.nan, dtype=np.float32))
    empty = Motion(good.local_rotations[:0], good.root_positions[:0])
    with pytest.raises(GrammarError, match=r"expected at least one take, found none\. Name"):
        distances.make_poses([])
    with pytest.raises(GrammarError, match=r"take 2: expected frames, found none\. Leave it out"):
        distances.make_poses([good, empty])
    with pytest.raises(GrammarError, match=r"take 2: expected numbers, found NaN or infinity"):
        distances.make_poses([good, broken])
