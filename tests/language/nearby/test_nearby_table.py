"""The table of nearby words: what is written is read, and what is damaged is refused."""

from __future__ import annotations

import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.errors import SheetError
from motiondb.language.nearby.table import NearbyTable, read_table, write_table

LETTERS = st.text("abcdefghijklmnopqrstuvwxyz", min_size=1, max_size=8)


def table(pairs: dict[str, list[tuple[str, float]]], silent: tuple[str, ...] = ()) -> NearbyTable:
    words = {**pairs, **{t: pairs.get(t, []) for taken in pairs.values() for t, _ in taken}}
    units = {w: [(t, round(200 * p)) for t, p in taken] for w, taken in words.items()}
    return read_table(write_table(units, sorted(zlib.crc32(w.encode()) for w in silent)))


def test_an_entry_worked_by_hand() -> None:
    small = table({"amble": [("walk", 0.9), ("go", 0.125)]})
    assert small.words == ("amble", "go", "walk")
    assert small.starts.tolist() == [0, 2, 2, 2]
    assert small.targets.tolist() == [2, 1]
    assert small.entry("amble") == (("walk", 0.9), ("go", 0.125))
    assert small.entry("walk") == small.entry("zebra") == ()


def test_english_words_are_those_held_answered_and_silent() -> None:
    small = table({"amble": [("walk", 0.9)]}, silent=("zebra", "tax"))
    assert all(small.is_english(word) for word in ("amble", "walk", "zebra", "tax"))
    assert not any(small.is_english(word) for word in ("wlak", "", "ambl", "zzzz"))


@given(st.dictionaries(LETTERS, st.lists(st.tuples(LETTERS, st.integers(1, 200)), max_size=4)))
def test_what_is_written_is_read(drawn: dict[str, list[tuple[str, int]]]) -> None:
    pairs = {**drawn, **{t: drawn.get(t, []) for taken in drawn.values() for t, _ in taken}}
    written = write_table(pairs, [7, 9])
    read = read_table(written)
    assert {w: [(t, round(200 * p)) for t, p in read.entry(w)] for w in read.words} == pairs
    assert read.silent.tolist() == [7, 9]
    assert written == write_table(dict(reversed(pairs.items())), [7, 9])


def test_what_is_no_table_is_refused() -> None:
    with pytest.raises(SheetError, match=r"expected a table of nearby words .*Install motiondb"):
        read_table(b"word\tother\n", "here.table")


@pytest.mark.parametrize("left", [24, 30, 40, 50])
def test_a_table_cut_short_is_refused(left: int) -> None:
    whole = write_table({"amble": [("walk", 180)], "walk": []}, [3])
    with pytest.raises(SheetError, match=r"here\.table: expected"):
        read_table(whole[:left], "here.table")
