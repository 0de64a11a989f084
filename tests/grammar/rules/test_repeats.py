"""Suffix arrays, common prefixes, maximal repeats and the cover, against slow obvious twins."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.rules.repeats import (
    common_prefixes,
    cover_repeats,
    join_strings,
    maximal_repeats,
    suffix_array,
)

TEXTS = st.lists(st.integers(0, 3), min_size=1, max_size=40)


def naive_suffixes(text):
    return sorted(range(len(text)), key=lambda i: tuple(text[i:]))


def common(one, other):
    n = 0
    while n < min(len(one), len(other)) and one[n] == other[n]:
        n += 1
    return n


def naive_repeats(text, shortest):
    actual = set()
    n = len(text)
    for length in range(shortest, n):
        places = {}
        for i in range(n - length + 1):
            places.setdefault(tuple(text[i : i + length]), []).append(i)
        for word, starts in places.items():
            before = {text[i - 1] if i else None for i in starts}
            after = {text[i + length] if i + length < n else None for i in starts}
            alone = len(starts) == 1
            wide = len(before) > 1 or None in before
            if not alone and wide and (len(after) > 1 or None in after):
                actual.add((word, len(starts)))
    return actual


@settings(max_examples=200, deadline=None)
@given(TEXTS)
def test_suffixes_and_common_prefixes_are_those_of_sorting(text):
    suffixes = suffix_array(text)
    assert suffixes.tolist() == naive_suffixes(text)
    ranked = [text[i:] for i in suffixes]
    expected = [0, *(common(a, b) for a, b in itertools.pairwise(ranked))]
    assert common_prefixes(text, suffixes).tolist() == expected


@settings(max_examples=200, deadline=None)
@given(TEXTS)
def test_maximal_repeats_are_those_that_counting_finds(text):
    repeats = maximal_repeats(text)
    listed = {
        (tuple(text[start : start + length]), int(count))
        for start, length, count in zip(repeats.starts, repeats.lengths, repeats.counts)
    }
    assert listed == naive_repeats(text, 2)
    assert len(repeats.starts) == len(listed)


@settings(max_examples=200, deadline=None)
@given(TEXTS)
def test_the_cover_holds_repeats_that_do_not_overlap_and_leaves_none_out(text):
    starts, lengths = cover_repeats(text)
    taken = np.zeros(len(text), dtype=int)
    for start, length in zip(starts, lengths):
        taken[start : start + length] += 1
        word = text[start : start + length]
        twins = [
            i
            for i in range(len(text) - length + 1)
            if text[i : i + length] == word and abs(i - start) >= length
        ]
        assert twins
    assert taken.max() <= 1
    ranked = naive_suffixes(text)
    for one, other in itertools.pairwise(ranked):
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


def test_suffixes_of_a_long_text_are_sorted():
    text = np.random.default_rng(0).integers(0, 5, 20_000)
    suffixes = suffix_array(text)
    lcp = common_prefixes(text, suffixes)
    after_one = np.append(text, -1)[suffixes[:-1] + lcp[1:]]
    after_other = np.append(text, -1)[suffixes[1:] + lcp[1:]]
    assert np.all(after_one < after_other)
    assert sorted(suffixes.tolist()) == list(range(text.size))


@pytest.mark.parametrize("text", [[], [3]])
def test_texts_without_repeats(text):
    assert suffix_array(text).tolist() == list(range(len(text)))
    assert cover_repeats(text)[0].size == 0
    assert maximal_repeats(text).starts.size == 0
