"""Score vectors: by hand, against a loop, and as properties."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.meaning import score_vectors
from motiondb.meaning.score_vectors import unit
from motiondb.records import FloatArray, SegmentTable


def test_the_space_by_hand() -> None:
    scores = np.array([[1.0, 3.0], [5.0, 5.0]], dtype=np.float32)
    space = score_vectors.fit_score_space(scores, np.array([30, 10]))
    np.testing.assert_allclose(space.mean, [-0.75, 0.75])
    np.testing.assert_allclose(space.spread, np.sqrt([0.1875, 0.1875]), rtol=1e-4)
    expected = np.array([[-0.25, 0.25], [0.75, -0.75]]) / np.sqrt(0.1875)
    np.testing.assert_allclose(space.standardise(scores), expected, rtol=1e-4)


def test_standardised_scores_are_clipped() -> None:
    space = score_vectors.ScoreSpace(np.zeros(2), np.ones(2))
    wild = space.standardise(np.array([[100.0, -100.0]], dtype=np.float32))
    np.testing.assert_array_equal(wild, [[3.0, -3.0]])


def test_one_symbol_says_nothing() -> None:
    scores = np.array([[-4.0], [-9.0]], dtype=np.float32)
    space = score_vectors.fit_score_space(scores, np.array([8, 8]))
    np.testing.assert_array_equal(space.standardise(scores), [[0.0], [0.0]])


def by_loop(
    standardised: FloatArray, starts: list[int], ends: list[int], low: int, high: int
) -> FloatArray:
    """Frame by frame: the scores of the segment that each frame lies in, summed."""
    total = np.zeros(standardised.shape[1])
    for frame in range(low, high):
        for row, start, end in zip(standardised, starts, ends):
            if start <= frame < end:
                total += row
    length = np.sqrt(np.sum(total**2))
    return total / length if length else total


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6))
def test_interval_vectors_equal_a_loop_over_frames(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cuts = np.concatenate([[0], np.cumsum(rng.integers(1, 9, 5))])
    standardised = rng.normal(size=(5, 3))
    low = rng.integers(-3, cuts[-1], 4)
    high = low + rng.integers(1, 20, 4)
    vectors = score_vectors.interval_vectors(standardised, cuts[:-1], cuts[1:], low, high)
    for vector, a, b in zip(vectors, low, high):
        expected = by_loop(standardised, cuts[:-1].tolist(), cuts[1:].tolist(), int(a), int(b))
        np.testing.assert_allclose(vector, expected, atol=1e-12)


def test_an_interval_outside_has_no_direction() -> None:
    vectors = score_vectors.interval_vectors(
        np.ones((1, 2)), np.array([0]), np.array([5]), np.array([9]), np.array([12])
    )
    np.testing.assert_array_equal(vectors, [[0.0, 0.0]])


def test_windows_of_captures_are_those_of_each_alone() -> None:
    """Also where captures are left out, and where one has more segments than are made at once."""
    rng, sizes = np.random.default_rng(3), [3, 1, 500, 2, 200, 150, 60]
    ends = np.concatenate([np.cumsum(rng.integers(8, 60, n)) for n in sizes])
    bounds = np.cumsum([0, *sizes])
    firsts = np.insert(ends[:-1], 0, 0)
    firsts[bounds[:-1]] = 0
    rows = rng.normal(size=(len(ends), 7))
    none = np.zeros((len(ends), 0), dtype=np.float32)
    captures = np.repeat(np.arange(len(sizes)), sizes)
    table = SegmentTable(captures, firsts, ends, captures, np.zeros(0), np.zeros(0), none)
    for left_out in ([], [1, 5], [0, 2, 3, 4, 5, 6]):
        kept = [n for n in range(len(sizes)) if n not in left_out]
        parts = [slice(int(bounds[n]), int(bounds[n + 1])) for n in kept]
        seen = []
        for some, vectors in score_vectors.window_vectors_of(rows, table, parts, 22):
            assert len(vectors) % score_vectors.VECTORS_AT_ONCE == 0
            n_made = 0
            for part in parts[some]:
                starts, stops = table.starts[part], table.ends[part]
                low, high = np.append(starts - 22, 0), np.append(stops + 22, stops[-1])
                alone = score_vectors.interval_vectors(rows[part], starts, stops, low, high)
                made = vectors[n_made : n_made + len(alone)]
                np.testing.assert_allclose(made, alone, atol=1e-14)
                n_made += len(alone)
            assert not vectors[n_made:].any()
            seen += kept[some]
        assert seen == kept


def test_windows_reach_over_their_segment() -> None:
    starts, none = np.array([0, 44, 88]), np.zeros((3, 0), dtype=np.float32)
    table = SegmentTable(starts, starts, starts + 44, starts, starts, starts, none)
    ((_, vectors),) = score_vectors.window_vectors_of(np.eye(3), table, [slice(0, 3)], 22)
    expected = unit(np.array([[2.0, 1, 0], [1, 2, 1], [0, 1, 2], [1, 1, 1]]))
    np.testing.assert_allclose(vectors[:4], expected)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("n_words", [1, 7, 86, 199, 201])
def test_a_product_does_not_depend_on_other_rows(kind: type[np.floating], n_words: int) -> None:
    rng = np.random.default_rng(n_words)
    rows = rng.normal(size=(210, 260)).astype(kind)
    matrix = rng.normal(size=(260, n_words)).astype(kind)
    for at_once in (score_vectors.ROWS_AT_ONCE, score_vectors.VECTORS_AT_ONCE):
        whole = score_vectors.times(rows, matrix, at_once)
        np.testing.assert_allclose(whole, rows @ matrix, rtol=2e-4, atol=1e-4)
        for first, last in ((0, 1), (5, 70), (23, 49), (200, 210)):
            part = score_vectors.times(rows[first:last], matrix, at_once)
            np.testing.assert_array_equal(part, whole[first:last])


def test_rows_have_length_one() -> None:
    np.testing.assert_allclose(unit(np.array([[3.0, 4.0], [0, 0]])), [[0.6, 0.8], [0, 0]])


def test_no_last_columns_are_none() -> None:
    space = score_vectors.ScoreSpace(np.zeros(630), np.ones(630))
    assert space.standardise_last(np.zeros((4, 627), dtype=np.float32), 0).shape == (4, 0)
