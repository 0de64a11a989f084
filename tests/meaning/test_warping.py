"""Subsequence warping: by hand, against plain recursion, and as properties."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.meaning import alignment
from motiondb.records import FloatArray


def by_recursion(query: FloatArray, capture: FloatArray) -> float:
    """Least mean cost over all paths with steps (1, 1), (1, 2), (2, 1)."""

    def local(i: int, j: int) -> float:
        return float(np.linalg.norm(query[i] - capture[j]) / np.sqrt(query.shape[1]))

    @cache
    def cost(i: int, j: int) -> float:
        if i < 0 or j < 0:
            return np.inf
        if i == 0:
            return local(0, j)
        return min(
            cost(i - 1, j - 1) + local(i, j),
            cost(i - 1, j - 2) + local(i, j),
            cost(i - 2, j - 1) + local(i - 1, j) + local(i, j) if i > 1 else np.inf,
        )

    return min(cost(len(query) - 1, j) for j in range(len(capture))) / len(query)


def random_walk(seed: int, n_frames: int, n_dims: int = 3) -> FloatArray:
    return np.cumsum(np.random.default_rng(seed).normal(size=(n_frames, n_dims)), axis=0)


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(1, 14))
def test_distances_equal_plain_recursion(seed: int, n: int, m: int) -> None:
    query, capture = random_walk(seed, n), random_walk(seed + 1, m)
    distance, start, end = alignment.best_part(query.astype("f4"), capture.astype("f4"))
    expected = by_recursion(query, capture)
    if np.isinf(expected):
        assert (distance, start, end) == (np.inf, 0, 0)
    else:
        assert distance == pytest.approx(expected, rel=1e-4)
        assert 0 <= start < end <= m
        assert by_recursion(query, capture[start:end]) == pytest.approx(expected, rel=1e-4)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10**6), st.integers(0, 60), st.integers(5, 30))
def test_a_part_finds_itself_exactly(seed: int, start: int, length: int) -> None:
    capture = random_walk(seed, 100).astype("f4")
    actual = alignment.best_part(capture[start : start + length], capture)
    assert actual == (0.0, start, min(start + length, 100))


def test_a_part_at_double_speed_is_found() -> None:
    capture = random_walk(3, 100).astype("f4")
    distance, start, end = alignment.best_part(capture[20:60:2], capture)
    assert (distance, start, end) == (0.0, 20, 59)


def test_distance_by_hand() -> None:
    query, capture = np.array([[0.0], [1.0]], "f4"), np.array([[5.0], [1.0], [1.0]], "f4")
    assert alignment.best_part(query, capture) == (0.5, 1, 3)


@pytest.mark.parametrize("n_frames", [0, 1, 3])
def test_too_short_a_capture_is_infinitely_far(n_frames: int) -> None:
    query = random_walk(0, 8).astype("f4")
    assert alignment.best_part(query, query[:n_frames]) == (np.inf, 0, 0)


def test_no_query_is_infinitely_far() -> None:
    capture = random_walk(0, 8).astype("f4")
    assert alignment.best_part(capture[:0], capture) == (np.inf, 0, 0)
