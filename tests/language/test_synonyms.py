"""A table of synonyms: chains of entries are followed to their end, in linear time."""

from __future__ import annotations

import pytest

from motiondb.errors import SheetError
from motiondb.language.vocabulary import parse_synonyms


def letters(number: int) -> str:
    """A number as letters: words hold no digits."""
    return "x" + "".join(chr(ord("a") + int(digit)) for digit in str(number))


def test_a_chain_is_followed_to_its_end() -> None:
    assert parse_synonyms("jog = run\namble = jog\nstroll = amble") == {
        "jog": "run",
        "amble": "run",
        "stroll": "run",
    }


@pytest.mark.parametrize("is_reversed", [False, True])
def test_a_chain_of_ten_thousand_words_is_read(is_reversed: bool) -> None:
    """A walk from each word to the end would take 50 million steps; it took minutes once."""
    lines = [f"{letters(n)} = {letters(n + 1)}" for n in range(10_000)]
    table = parse_synonyms("\n".join(lines[::-1] if is_reversed else lines))
    assert len(table) == 10_000
    assert set(table.values()) == {letters(10_000)}


def test_a_chain_into_a_circle_names_every_word_of_it_and_before_it() -> None:
    with pytest.raises(SheetError) as error:
        parse_synonyms("hop = skip\nskip = leap\nleap = skip\njog = run")
    lines = str(error.value).splitlines()
    assert [line.split(":")[1] for line in lines] == ["1", "2", "3"]
    assert lines[0] == (
        "synonyms:1: expected synonyms that end in a word, found a circle through 'hop'. "
        "Leave one of its lines out."
    )
