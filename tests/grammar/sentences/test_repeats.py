"""Sorted suffixes, common prefixes and the cover by repeats, against slow obvious twins."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.sentences.repeats import (
    common_prefixes,
    cover_repeats,
    join_strings,
    sorted_suffixes,
)

TEXTS = st.lists(st.integers(0, 3), min_size=1, max_size=40)


def naive_suffixes(text):
    return sorted(range(len(text)), key=lambda i: tuple(text[i:]))


def common(one, other):
    n = 0
    while n < min(len(one), len(other)) and one[n] == other[n]:
        n += 1
    return n


@settings(max_examples=50, deadline=None)
@given(TEXTS)
def test_suffixes_and_common_prefixes_are_those_of_sorting(text):
    suffixes = sorted_suffixes(text)
    assert suffixes.tolist() == naive_suffixes(text)
    ranked = [text[i:] for i in suffixes]
    expected = [0, *(common(a, b) for a, b in itertools.pairwise(ranked))]
    assert common_prefixes(text, suffixes) == expected


@settings(max_examples=50, deadline=None)
@given(TEXTS)
def test_the_cover_holds_repeats_that_do_not_overlap_and_leaves_none_out(text):
    starts, lengths = cover_repeats(text)
    taken = np.zeros(len(text), dtype=int)
    for start, length in zip(starts, lengths):
        taken[start : start + length] += 1
        word = text[start : start + length]
        assert any(
            text[i : i + length] == word and abs(i - start) >= length
            for i in range(len(text) - length + 1)
        )
    assert taken.max() <= 1
    for one, other in itertools.pairwise(naive_suffixes(text)):
        reach = min(common(text[one:], text[other:]), abs(one - other))
        for i in (one, other):
            free = next((k for k in range(reach) if taken[i + k]), reach)
            assert free < 2


def test_the_longest_repeat_is_always_in_the_cover():
    # abxcd occurs twice, and ab, cd beside it: what the paper names as not to be divided
    starts, lengths = cover_repeats([0, 1, 4, 2, 3, 0, 1, 5, 2, 3, 0, 1, 4, 2, 3])
    assert list(zip(starts.tolist(), lengths.tolist())) == [(0, 5), (5, 2), (8, 2), (10, 5)]


def test_a_run_is_cut_down_to_its_period():
    assert cover_repeats([0, 1] * 5)[1].tolist() == [2] * 5
    assert cover_repeats([0] * 50)[1].tolist() == []


def test_no_repeat_reaches_across_the_end_of_a_string():
    symbols, bounds = join_strings(["abc", "abc", "cab"])
    assert bounds.tolist() == [0, 4, 8, 12]
    starts, lengths = cover_repeats(symbols)
    assert list(zip(starts.tolist(), lengths.tolist())) == [(0, 3), (4, 3), (9, 2)]


@pytest.mark.parametrize("text", [[], [3]])
def test_texts_without_repeats(text):
    assert sorted_suffixes(text).tolist() == list(range(len(text)))
    assert cover_repeats(text)[0].size == 0
