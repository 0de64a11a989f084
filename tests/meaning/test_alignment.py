"""Local alignment: by hand, against plain Python, and as properties."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.meaning import alignment
from motiondb.records import FloatArray, IntArray

APART = np.array([[0.0, 2, 2, 2], [2, 0, 2, 2], [2, 2, 0, 2], [2, 2, 2, 0]])


def best_by_recursion(pairs: FloatArray, gaps: FloatArray) -> float:
    """Smith and Waterman's recursion, written out cell by cell without memory of where it began."""
    n_query, n_symbols = pairs.shape
    score = [[0.0] * (n_symbols + 1) for _ in range(n_query + 1)]
    for i in range(1, n_query + 1):
        for j in range(1, n_symbols + 1):
            score[i][j] = max(
                0.0,
                score[i - 1][j - 1] + pairs[i - 1, j - 1],
                score[i - 1][j] - gaps[i - 1],
                score[i][j - 1] - gaps.mean(),
            )
    return max(max(row) for row in score)


def global_score(pairs: FloatArray, gaps: FloatArray) -> float:
    """Best score of aligning all rows with all columns, or any run of rows with all columns."""
    n_query, n_symbols = pairs.shape
    best = -np.inf
    for first in range(n_query):
        for last in range(first + 1, n_query + 1):
            part = pairs[first:last]
            table = np.zeros((len(part) + 1, n_symbols + 1))
            table[0] = -gaps.mean() * np.arange(n_symbols + 1)
            table[1:, 0] = -np.cumsum(gaps[first:last])
            for i in range(1, len(part) + 1):
                for j in range(1, n_symbols + 1):
                    table[i, j] = max(
                        table[i - 1, j - 1] + part[i - 1, j - 1],
                        table[i - 1, j] - gaps[first + i - 1],
                        table[i, j - 1] - gaps.mean(),
                    )
            best = max(best, table[-1, -1])
    return float(best)


def random_problem(seed: int) -> tuple[IntArray, FloatArray, IntArray, FloatArray]:
    rng = np.random.default_rng(seed)
    distances = rng.uniform(0.2, 3.0, (5, 5))
    distances = distances + distances.T
    np.fill_diagonal(distances, 0.0)
    query, symbols = rng.integers(0, 5, rng.integers(1, 6)), rng.integers(0, 5, rng.integers(1, 9))
    weights = rng.uniform(0.1, 1.0, len(query))
    return query, weights / weights.sum(), symbols, distances


def test_a_perfect_match_scores_one_where_it_stands() -> None:
    query, thirds = np.array([0, 1, 2]), np.full(3, 1 / 3)
    actual = alignment.align(query, thirds, np.array([3, 3, 0, 1, 2, 3]), APART, 2.0)
    assert actual == (pytest.approx(1.0), 2, 5)


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6))
def test_score_and_place_equal_plain_python(seed: int) -> None:
    query, weights, symbols, distances = random_problem(seed)
    score, first, last = alignment.align(query, weights, symbols, distances, 2.0)
    pairs = (1.0 - distances[np.ix_(query, symbols)] / 2.0) * weights[:, None]
    assert score == pytest.approx(best_by_recursion(pairs, alignment.GAP * weights))
    if score > 0:
        inside = global_score(pairs[:, first:last], alignment.GAP * weights)
        assert inside == pytest.approx(score)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6))
def test_scores_lie_between_nothing_and_perfect(seed: int) -> None:
    query, weights, symbols, distances = random_problem(seed)
    assert 0.0 <= alignment.align(query, weights, symbols, distances, 2.0)[0] <= 1.0 + 1e-12
    around = np.concatenate([symbols, query, symbols])
    assert alignment.align(query, weights, around, distances, 2.0)[0] == pytest.approx(1.0)


def test_the_scale_is_the_median_distance() -> None:
    distances = np.array([[0.0, 1, 5], [1, 0, 3], [5, 3, 0]])
    assert alignment.distance_scale(distances) == 3.0
    assert alignment.distance_scale(np.zeros((1, 1))) == 1.0
    assert alignment.distance_scale(np.zeros((2, 2))) > 0.0


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
    distance, start, end = alignment.best_part(query.astype("f4"), capture.T)
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
    actual = alignment.best_part(capture[start : start + length], capture.T)
    assert actual == (0.0, start, min(start + length, 100))


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(0, 20), st.floats(0.0, 3.0))
def test_only_parts_that_are_too_far_are_given_up(
    seed: int, length: int, low: int, farthest: float
) -> None:
    query, capture = random_walk(seed, length).astype("f4"), random_walk(seed + 1, 40).astype("f4")
    distance, start, end = alignment.best_part(query, capture[low : low + 20].T)
    expected = (distance, low + start, low + end) if distance <= farthest else (np.inf, 0, 0)
    assert alignment.best_part(query, capture.T, low, low + 20, farthest) == expected


@pytest.mark.parametrize("n_frames", [0, 1, 3])
def test_too_short_a_capture_is_infinitely_far(n_frames: int) -> None:
    query = random_walk(0, 8).astype("f4")
    assert alignment.best_part(query, query[:n_frames].T) == (np.inf, 0, 0)


def test_no_query_is_infinitely_far() -> None:
    capture = random_walk(0, 8).astype("f4")
    assert alignment.best_part(capture[:0], capture.T) == (np.inf, 0, 0)
