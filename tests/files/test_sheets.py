"""Sheets of words: true line numbers, and quotes."""

from __future__ import annotations

from pathlib import Path

import pytest

from motiondb.errors import SheetError
from motiondb.files.sheets import read_event_sheet, read_sheet
from motiondb.records import Caption, Event


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


def events_written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "events.tsv"
    path.write_text(text)
    return path


def test_frames_and_seconds_give_frames_at_thirty_a_second(tmp_path: Path) -> None:
    sheet = read_event_sheet(
        events_written(
            tmp_path,
            "file\tframe\ttime\tevent\tjoint\tother\n"
            "a/shot.bvh\t35\t\trelease\tr_wrist\tball\n"
            "\n"
            "a/shot\t\t0.5\tfoot_strike\tl_ankle\tground\n"
            "b.bvh\t12.0\t\tcontact\t\t\n",
        )
    )
    assert sheet.entries == {
        "a/shot": (
            (2, Event(35, "release", "r_wrist", "ball")),
            (4, Event(15, "foot_strike", "l_ankle", "ground")),
        ),
        "b": ((5, Event(12, "contact")),),
    }
    assert sheet.n_events == 3
    assert sheet.notes == ()


def test_commas_and_other_names_of_columns(tmp_path: Path) -> None:
    sheet = read_event_sheet(
        events_written(tmp_path, "Filename,Name,Seconds,mood\na.bvh,catch,2,calm\n")
    )
    assert sheet.entries == {"a": ((2, Event(60, "catch")),)}


def test_a_repeated_row_is_noted_and_left_out(tmp_path: Path) -> None:
    text = "file\tevent\tframe\na\tcatch\t3\na.bvh\tcatch\t3\n"
    sheet = read_event_sheet(events_written(tmp_path, text))
    assert sheet.n_events == 1
    assert sheet.notes == (f"{tmp_path}/events.tsv:3: repeats line 2 and was left out",)


def test_all_faults_are_told_at_once_with_their_lines(tmp_path: Path) -> None:
    text = (
        "file\tevent\tframe\ttime\tjoint\n"
        "a\tcatch\t2.5\t\t\n"
        "a\tcatch\t\t-1\t\n"
        "\n"
        "a\tcatch\t\t\t\n"
        "a\t\t3\t\t\n"
        "\tcatch\t3\t\t\n"
        "a\tcatch\t3\t\tr_wirst\n"
        "a\tcatch\tnan\t\t\n"
        "a\tcatch\t3\t\t\tball\n"
    )
    with pytest.raises(SheetError) as error:
        read_event_sheet(events_written(tmp_path, text))
    lines = [line.removeprefix(f"{tmp_path}/events.tsv:") for line in str(error.value).split("\n")]
    assert lines == [
        "2: expected a whole number of at least 0 in column frame, found '2.5'. Frames count 30 a"
        " second.",
        "3: expected a number of at least 0 in column time, found '-1'. Times are seconds.",
        "5: expected a frame or a time, found neither. Give one of them.",
        "6: expected what happens in column event, found nothing. Fill it in or delete the row.",
        "7: expected a file name in column file, found nothing. Fill it in or delete the row.",
        "8: expected a joint of the canonical body, found 'r_wirst'. Did you mean r_wrist or"
        " l_wrist?",
        "9: expected a whole number of at least 0 in column frame, found 'nan'. Frames count 30 a"
        " second.",
        "10: expected 5 columns, found 6.",
    ]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", ": expected a header with the columns file, event and frame, found an empty sheet."),
        ("file\tframe\n", ":1: expected a column event, found file, frame."),
        ("\n\nevent\n", ":3: expected a column file and frame or time, found event."),
    ],
)
def test_a_header_that_lacks_columns_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(SheetError) as error:
        read_event_sheet(events_written(tmp_path, text))
    assert sentence in str(error.value)
    assert "Columns: file, event, frame, time, joint, other" in str(error.value)


def test_what_lies_outside_and_who_is_not_there_have_their_lines(tmp_path: Path) -> None:
    text = "file\tevent\tframe\nana/bow\tcatch\t9\nana/bow\trelease\t10\nana/bwo\tcatch\t1\n"
    sheet = read_event_sheet(events_written(tmp_path, text))
    problems: list[str] = []
    assert sheet.within("ana/bow", 10, problems) == (Event(9, "catch"),)
    assert problems == [
        f"{tmp_path}/events.tsv:3: expected an event before the end of ana/bow at 0.333 s "
        "(frame 10), found frame 10. Count frames at 30 a second, or give a column time."
    ]
    assert sheet.unknown(["ana/bow"]) == [
        f"{tmp_path}/events.tsv:4: expected an existing capture, found 'ana/bwo'. "
        "Did you mean ana/bow? Correct the file column."
    ]
    assert sheet.within("somebody", 10, problems) == ()


@pytest.mark.parametrize("column", ["Description", "captions", "label"])
def test_a_column_of_descriptions_holds_the_words_where_none_is_called_so(
    tmp_path: Path, column: str
) -> None:
    sheet = read_sheet(written(tmp_path, f"file,{column}\nwalk.bvh,a slow walk\n"))
    (entry,) = sheet.entries.values()
    assert sheet.notes[0].endswith(f"the words are those of the column '{column}'.")
    assert [caption.words for caption in entry.captions] == ["a slow walk"]
    sheet = read_sheet(written(tmp_path, f"file,words,{column}\nw.bvh,walk,slow\n"))
    (entry,) = sheet.entries.values()
    assert [caption.words for caption in entry.captions] == ["walk"]
    assert entry.tags == {column: "slow"}


def test_a_workbook_is_no_sheet(tmp_path: Path) -> None:
    path = tmp_path / "words.xlsx"
    path.write_bytes(b"PK\x03\x04...")
    with pytest.raises(SheetError, match="expected text, found a workbook"):
        read_sheet(path)
