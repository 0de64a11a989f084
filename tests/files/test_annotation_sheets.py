"""Sheets of BORIS and ELAN as their programs write them, in and out."""

from __future__ import annotations

from pathlib import Path

import pytest

from motiondb.errors import SheetError
from motiondb.files.annotation_sheets import write_annotations
from motiondb.files.sheets import read_event_sheet, read_sheet, resolved
from motiondb.records import Caption, Event

AGGREGATED = (
    "Observation id,Media file,Total length,FPS,Subject,Behavior,Behavioral category,Modifiers,"
    "Behavior type,Start (s),Stop (s),Duration (s),Comment start,Comment stop\n"
    "t 1,C:\\videos\\walk_1.mp4,20,25,No focal subject,walk,NA,slow|left,STATE,1.5,4.25,2.75,,\n"
    "trial 1,C:\\videos\\walk_1.mp4,20,25,No focal subject,stop,NA,NA,POINT,4.5,4.5,NA,,\n"
)
TABULAR = (
    "Observation id,Source,Subject,Behavior,Behavioral category,Behavior type,Time,"
    "Media file name\n"
    "walk_1,player #1:a.mp4,,walk,,START,1.5,GX01.mp4\n"
    "walk_1,player #1:a.mp4,,stop,,POINT,3.0,GX01.mp4\n"
    "walk_1,player #1:a.mp4,,walk,,STOP,4.25,GX01.mp4\n"
)
OLDER = (
    "Observation id\twalk_1\n\nMedia file(s)\n\n"
    "Time\tMedia file path\tTotal length\tFPS\tSubject\tBehavior\tBehavioral category\t"
    "Comment\tStatus\n"
    "1.5\t/v/walk_1.avi\t20\t25\t\twalk\t\t\tSTART\n"
    "4.25\t/v/walk_1.avi\t20\t25\t\twalk\t\t\tSTOP\n"
)
ELAN = "action\t\t00:00:01.500\t1.5\t00:00:04.250\t4.25\t00:00:02.750\t2.75\twalk slowly\n"
ELAN_WITH_HEADER = (
    "Begin Time - hh:mm:ss.ms\tBegin Time - ss.msec\tEnd Time - hh:mm:ss.ms\tEnd Time - ss.msec\t"
    "action\tfeet\tFile\n"
    "00:00:01.500\t1.5\t00:00:04.250\t4.25\twalk\t\twalk_1.eaf\n"
    "00:01:02.000\t62.0\t00:01:02.000\t62.0\t\tstrike\twalk_1.eaf\n"
)


def written(folder: Path, text: str, name: str = "sheet.csv") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_intervals_of_boris_are_words_and_its_points_are_events(tmp_path: Path) -> None:
    path = written(tmp_path, AGGREGATED)
    sheet = resolved(read_sheet(path), ["ana/walk_1", "ana/run"])
    assert {n: e.captions for n, e in sheet.entries.items()} == {
        "ana/walk_1": (Caption("walk slow left", 1.5, 4.25),)
    }
    assert "1 instants are events" in sheet.notes[0]
    events = resolved(read_event_sheet(path), ["walk_1"])
    assert events.entries == {"walk_1": ((3, Event(135, "stop")),)}
    assert "1 intervals are words" in events.notes[0]


@pytest.mark.parametrize(("text", "name"), [(TABULAR, "s.csv"), (OLDER, "s.tsv")])
def test_starts_and_stops_become_intervals(tmp_path: Path, text: str, name: str) -> None:
    sheet = resolved(read_sheet(written(tmp_path, text, name)), ["walk_1"])
    assert sheet.entries["walk_1"].captions == (Caption("walk", 1.5, 4.25),)


@pytest.mark.parametrize("gone", ["START", "STOP"])
def test_a_state_without_its_other_end_is_refused(tmp_path: Path, gone: str) -> None:
    lines = [line for line in TABULAR.splitlines() if f",{gone}," not in line]
    with pytest.raises(SheetError, match=f"expected a {gone} of 'walk'"):
        read_sheet(written(tmp_path, "\n".join(lines)))


def test_annotations_of_elan_with_and_without_a_header(tmp_path: Path) -> None:
    plain = read_sheet(written(tmp_path, ELAN, "walk_1.txt"))
    assert plain.entries["walk_1"].captions == (Caption("walk slowly", 1.5, 4.25),)
    several = written(tmp_path, '"#file:///v/run_2.eaf\n' + ELAN, "all.txt")
    assert resolved(read_sheet(several), ["run_2"]).entries["run_2"].captions
    path = written(tmp_path, ELAN_WITH_HEADER, "b.txt")
    assert read_sheet(path).entries["walk_1"].captions == (Caption("walk", 1.5, 4.25),)
    assert read_event_sheet(path).entries == {"walk_1": ((3, Event(1860, "strike")),)}


@pytest.mark.parametrize(("form", "ending"), [("boris", "csv"), ("boris", "tsv"), ("elan", "txt")])
def test_what_is_written_is_read_again(tmp_path: Path, form: str, ending: str) -> None:
    path = tmp_path / f"out.{ending}"
    captions = (Caption('walk, then "stop"'), Caption("turn left", 1.0, 2.5))
    events = (Event(45, "foot_strike", "l_ankle", "ground"),)
    write_annotations(path, [("ana/walk_1", 4.0, 100.0, captions, events)], form)
    assert read_sheet(path).entries["ana/walk_1"].captions == (
        Caption('walk, then "stop"', 0.0, 4.0),
        Caption("turn left", 1.0, 2.5),
    )
    ((_, event),) = read_event_sheet(path).entries["ana/walk_1"]
    assert event == Event(45, "foot_strike")


def test_a_sheet_of_words_with_such_a_column_is_none_of_these(tmp_path: Path) -> None:
    path = written(tmp_path, "file,words,behavior,time\na.bvh,walk,calm,00:00:01.5\n")
    assert read_sheet(path).entries["a"].tags == {"behavior": "calm", "time": "00:00:01.5"}


def test_wrong_times_are_told_with_their_line(tmp_path: Path) -> None:
    with pytest.raises(SheetError, match=r"sheet\.csv:2: expected seconds from 0 on, found 'x'"):
        read_sheet(written(tmp_path, AGGREGATED.replace("1.5,4.25", "x,4.25")))
