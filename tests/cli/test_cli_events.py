"""Events from the command line: added with captures, imported, listed, gone with their capture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

SHEET = (
    "file\tframe\tevent\tjoint\tother\n"
    "ana/jump_1.bvh\t20\ttake_off\tl_ankle\tground\n"
    "ana/jump_1.bvh\t20\ttake_off\tr_ankle\tground\n"
    "boris/kick_1\t15\tcontact\tr_toe\ttarget\n"
)


def sheet(folder: Path, text: str = SHEET) -> Path:
    path = folder / "events.tsv"
    path.write_text(text)
    return path


def test_events_come_with_captures_and_go_with_them(
    command: Any, some: Path, tmp_path: Path
) -> None:
    added = command("add", some, "--events", sheet(tmp_path))
    assert added.code == 0, added.err
    assert "  3 events added with them\n" in added.out
    assert command("events").out.splitlines() == [
        "event     count  captures",
        "contact       1  1       ",
        "take_off      2  1       ",
    ]
    assert "events:       take_off 2" in command("show", "ana/jump_1").out
    shown = json.loads(command("events", "show", "ana/jump_1", "--json").out)
    assert shown[0] == {
        "frame": 20, "name": "take_off", "joint": "l_ankle", "other": "ground", "seconds": 0.667,
    }  # fmt: skip
    assert "0.667  20     take_off  r_ankle  ground" in command("events", "show", "jump_1").out
    assert command("remove", "ana/jump_1").code == 0
    assert json.loads(command("events", "--json").out) == [
        {"event": "contact", "count": 1, "captures": 1}
    ]
    assert command("check").code == 0


def test_import_replaces_and_tells_what_it_left_out(
    command: Any, some: Path, tmp_path: Path
) -> None:
    assert command("add", some).code == 0
    assert command("events").out == "no events; add some with motiondb events import SHEET\n"
    file = sheet(tmp_path, SHEET + "boris/kick\t3\tcontact\t\t\nboris/kick_1\t999\tcontact\t\t\n")
    ended = command("events", "import", file)
    assert ended.code == 1
    assert ended.out == "3 events of 2 captures kept, 2 problems\n"
    assert f"{file}:5: expected an existing capture, found 'boris/kick'." in ended.err
    assert f"{file}:6: expected an event before the end of boris/kick_1" in ended.err
    file = sheet(tmp_path, "file\ttime\tevent\nboris/kick_1\t0.4\tfoot_strike\n")
    facts = json.loads(command("events", "import", file, "--json").out)
    assert facts == {"captures": 1, "events": 1, "problems": [], "notes": []}
    assert [e["frame"] for e in json.loads(command("events", "show", "kick_1", "--json").out)] == [
        12
    ]


def test_a_wrong_sheet_changes_nothing(command: Any, some: Path, tmp_path: Path) -> None:
    wrong_text = SHEET.replace("20", "21") + "ana/jump_1\tsoon\tcatch\t\t\n"
    wrong = sheet(tmp_path, wrong_text)
    ended = command("add", some, "--events", wrong)
    assert ended.code == 1
    assert f"error: {wrong}:5: expected a whole number" in ended.err
    assert command("add", some, "--events", sheet(tmp_path)).code == 0
    assert command("events", "import", sheet(tmp_path, wrong_text)).code == 1
    told = command("events", "show", "jump_1", "--json").out
    assert [event["frame"] for event in json.loads(told)] == [20, 20]


def test_adding_again_leaves_other_events_and_says_so(
    command: Any, some: Path, tmp_path: Path
) -> None:
    assert command("add", some, "--events", sheet(tmp_path)).code == 0
    again = command("add", some, "--events", sheet(tmp_path))
    assert "note" not in again.out
    other = sheet(tmp_path, SHEET.replace("15", "16"))
    again = command("add", some, "--events", other)
    assert (
        f"note: {other}: has other events for 1 captures that had been added before; they were "
        f"not changed (motiondb events import {other} replaces them)" in again.out
    )
