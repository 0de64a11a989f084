"""Words of a text and their values."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.files.number_words import count_values, read_words
from motiondb.files.text import number

FORMS = ("{!r}", "{:.6f}", "{:g}", "{:e}", "{:.17g}", "+{!r}", "{:.25f}")
written = st.builds(lambda form, x: form.format(x), st.sampled_from(FORMS), st.floats())
odd = st.text("0123456789+-.eE_x", min_size=1, max_size=24)


@given(st.lists(written | odd, max_size=8), st.sampled_from([" ", "\n", "\t \r\n", "\v"]))
def test_each_word_has_the_value_that_python_reads(words: list[str], space: str) -> None:
    text = (space + space.join(words) + space).encode()
    starts, ends, values = read_words(text)
    assert [text[a:b].decode() for a, b in zip(starts, ends, strict=True)] == words
    expected = np.array([math.nan if (x := number(word)) is None else x for word in words])
    np.testing.assert_array_equal(values, expected)
    np.testing.assert_array_equal(np.signbit(values[~np.isnan(expected)]),
                                  np.signbit(expected[~np.isnan(expected)]))  # fmt: skip


@pytest.mark.parametrize("text", [b"", b" ", b"\n\n"])
def test_a_text_without_words(text: bytes) -> None:
    assert len(read_words(text)[2]) == len(count_values(text)[0]) == 0


def test_values_are_counted_by_line() -> None:
    lines, counts = count_values(b"1 2\n\n \t\n3\r\n4 5 6")
    assert lines.tolist() == [0, 3, 4]
    assert counts.tolist() == [2, 1, 3]
