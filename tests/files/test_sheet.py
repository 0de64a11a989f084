"""Sheets of words: true line numbers, and quotes."""

from __future__ import annotations

from pathlib import Path

import pytest

from motiondb.errors import SheetError
from motiondb.files.sheets import read_sheet
from motiondb.records import Caption


def written(folder: Path, text: str) -> Path:
    """A sheet with these very bytes."""
    path = folder / "words.tsv"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_are_those_of_the_file(tmp_path: Path, end: str) -> None:
    path = written(
        tmp_path, end.join(["", "file\twords\tfps", "", "a\twalk\t", "", "b\trun\tx", ""])
    )
    with pytest.raises(SheetError) as caught:
        read_sheet(path)
    assert str(caught.value) == f"{path}:6: expected a number in column fps, found 'x'."
    sheet = read_sheet(
        written(tmp_path, end.join(["", "file\twords", "", "a\twalk", "", "b\trun"]))
    )
    assert [entry.line for entry in sheet.entries.values()] == [4, 6]
    assert sheet.unknown(["a"])[0].startswith(f"{path}:6: expected a capture")
    assert sheet.entries["b"].captions == (Caption("run"),)


def test_a_repeated_row_names_both_lines(tmp_path: Path) -> None:
    path = written(tmp_path, "file\twords\na\twalk\n\n\na\twalk\n")
    assert read_sheet(path).notes == (f"{path}:5: repeats line 2 and was left out",)


def test_a_header_below_empty_lines_is_named_where_it_is(tmp_path: Path) -> None:
    path = written(tmp_path, "\n\nname\twords\na\twalk\n")
    with pytest.raises(SheetError, match=r":3: expected a column `file`, found name, words"):
        read_sheet(path)


def test_a_quote_that_stays_open_is_named_by_its_line(tmp_path: Path) -> None:
    path = written(tmp_path, 'file\twords\n\njump\t"jump high\nwalk\twalk\n')
    with pytest.raises(
        SheetError, match=r"words.tsv:3: expected a quote that ends in its own line"
    ):
        read_sheet(path)


def test_letters_that_break_lines_elsewhere_do_not_here(tmp_path: Path) -> None:
    sheet = read_sheet(written(tmp_path, "file\twords\na\twalk\u2028slowly\x0bthen run\nb\tsit\n"))
    assert sheet.entries["b"].line == 3


def test_a_column_that_stands_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SheetError) as caught:
        read_sheet(written(tmp_path, "file\tfile\twords\na\tb\twalk\n"))
    assert str(caught.value) == (
        f"{tmp_path}/words.tsv:1: expected each column once, found 'file' twice. Rename one."
    )


def test_of_many_repeated_rows_a_hundred_are_named(tmp_path: Path) -> None:
    notes = read_sheet(written(tmp_path, "file\twords\n" + "a\twalk\n" * 1000)).notes
    assert len(notes) == 101
    assert notes[0].endswith("words.tsv:3: repeats line 2 and was left out")
    assert notes[-1] == "... and 899 more notes like these"
