"""Search by words within a capture: intervals, order, evidence."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_takes import all_of, take

from motiondb.meaning import by_question, word_evidence
from motiondb.meaning.counting import Described
from motiondb.records import FloatArray, SegmentTable

WALK, TURN, SIT = range(3)


def test_more_actions_than_segments_share_a_segment() -> None:
    one = take([[2.0, 4, 0]])
    hit = by_question.search_order(one, [[WALK], [TURN]])
    assert hit is not None
    end = int(one.ends[0])
    assert hit.parts == ((0, end // 2), (end // 2, end))
    assert hit.log_odds == pytest.approx(all_of(0.5 * 2.0, 0.5 * 4.0))


def test_more_actions_than_frames_are_not_found() -> None:
    one = word_evidence.TakeScores(np.array([0]), np.array([1]), np.ones((1, 3)), np.ones(3))
    assert by_question.search_order(one, [[WALK], [TURN]]) is None


def test_a_capture_that_says_the_same_throughout_is_found_whole() -> None:
    hit = by_question.search_order(take([[2.0, 0, 0], [2.4, 0, 0], [2.1, 0, 0]]), [[WALK]])
    assert hit is not None
    assert (hit.start, hit.end) == (0, 30)


def test_anything_leaves_room_for_itself() -> None:
    scores = take([[4.0, 0, 0], [4, 0, 0], [0, 0, 4], [0, 0, 4]])
    hit = by_question.search_order(scores, [[0], [], [2]])
    assert hit is not None
    assert hit.parts == ((0, 10), (10, 20), (20, 40))


def best_by_enumeration(values: FloatArray) -> float:
    n_actions, n_segments = values.shape
    return max(
        sum(values[k, i] for k, i in enumerate(picked))
        for picked in combinations(range(n_segments), n_actions)
    )


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10**6), st.integers(1, 4), st.integers(1, 7))
def test_peaks_equal_enumeration(seed: int, n_actions: int, n_segments: int) -> None:
    values = np.random.default_rng(seed).normal(size=(n_actions, n_segments))
    peaks = by_question.ordered_peaks(values)
    if n_segments < n_actions:
        assert peaks is None
        return
    assert peaks is not None
    assert all(a < b for a, b in pairwise(peaks))
    total = values[np.arange(n_actions), peaks].sum()
    assert total == pytest.approx(best_by_enumeration(values))


def test_growing_by_hand() -> None:
    values = np.array([-2.0, -2, 1, 4, 2, -2, 4, -2])
    assert by_question.grow(values, 3, 0, 8) == (2, 5)  # floor -2, threshold 1
    assert by_question.grow(values, 3, 3, 4) == (3, 4)
    assert by_question.grow(np.zeros(4), 2, 1, 4) == (1, 4)


def test_captions_of_all_segments_say_the_same_of_each() -> None:
    n, number = np.zeros(3), {"walk": 0, "sit": 1}
    ends = np.array([10, 20, 30])
    table = SegmentTable(n, ends - 10, ends, n, n, n, np.zeros((3, 0), dtype=np.float32))
    rows, yes, no = {7: slice(0, 3), 8: slice(0, 3)}, word_evidence.WRITTEN, word_evidence.UNWRITTEN
    described = [
        Described(7, 0, 3, 0.0, 30.0, ("walk",), 1),
        Described(8, 0, 3, 9.0, 21.0, ("sit", "cook"), 2),
        Described(8, 1, 2, 10.0, 20.0, ("walk",), 1),
    ]
    evidence = word_evidence.caption_evidence(described, table, rows, number)
    assert evidence[7].tolist() == 3 * [[yes, no]]
    assert evidence[8].tolist() == [[no, yes], [yes, yes], [no, yes]]


def test_written_words_count_where_they_were_written() -> None:
    starts, ends = np.array([0, 10, 20]), np.array([10, 20, 30])
    evidence = word_evidence.written_evidence(
        3, [(0, 15, np.array([0])), (12, 20, np.array([1]))], starts, ends, 2
    )
    yes, no = word_evidence.WRITTEN, word_evidence.UNWRITTEN
    np.testing.assert_array_equal(evidence, [[yes, no], [yes, yes], [0, 0]])


@settings(deadline=None, max_examples=50)
@given(st.lists(st.floats(-50, 50), min_size=1, max_size=12))
def test_the_lower_quartile_is_numpys(values: list[float]) -> None:
    assert by_question.lower_quartile(values) == pytest.approx(np.quantile(values, 0.25))
