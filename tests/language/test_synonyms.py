"""A table of synonyms: chains of entries are followed to their end, in linear time."""

from __future__ import annotations

import pytest

from motiondb.language.synonyms import parse_synonyms


def letters(number: int) -> str:
    """A number as letters: words hold no digits."""
    return "x" + "".join(chr(ord("a") + int(digit)) for digit in str(number))


@pytest.mark.parametrize("is_reversed", [False, True])
def test_a_chain_of_ten_thousand_words_is_read(is_reversed: bool) -> None:
    """A walk from each word to the end would take 50 million steps; it took minutes once."""
    lines = [f"{letters(n)} = {letters(n + 1)}" for n in range(10_000)]
    table = parse_synonyms("\n".join(lines[::-1] if is_reversed else lines))
    assert len(table) == 10_000
    assert set(table.values()) == {letters(10_000)}
