"""The commands of an archivist: what they print, and what they refuse."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
from command_answers import answer

import motiondb


def test_a_day_in_the_archive(command: Any, some: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert command("add", some / "ana", some / "boris").code == 0
    assert answer(command("rename", "bow_1", "ana/bow", "--json")) == {
        "renamed": {"bow_1": "ana/bow"}
    }
    assert command("tags", "set", "--where", "name~ana/", "performer=ana", "mood=").code == 0
    assert answer(command("tags", "--json")) == [{"tag": "performer", "captures": 1, "values": 1}]
    assert command("tags", "set", "ana/bow", "performer").code == 2
    command("words", "set", "ana/bow", "a bow")
    history = command("words", "history", "ana/bow").out
    assert "a bow" in history
    told = command("words", "export", "words.csv", "--where", "name~ana/").out
    assert told == "1 caption of 1 capture written to words.csv\n"
    assert Path("words.csv").read_text().endswith("\nana/bow,a bow,,,ana,\n")
    assert command("backup", "copy.duckdb").code == 0
    assert command("remove").code == 2
    assert command("remove", "--where", "name~1").code == 2  # nobody answers
    removed = answer(command("remove", "--where", "name~kick", "--yes", "--json"))
    assert removed == {"removed": ["kick_1"]}
    undone = answer(command("undo", "--json"))
    assert (undone["kind"], undone["restored"]) == ("remove", ["kick_1"])
    command("remove", "kick_1")
    ended = command("merge", "copy.duckdb")
    assert ended.out.startswith("1 capture added, 3 already there (0 of them changed), 0 problems")
    with motiondb.open("motions.duckdb", read_only=True) as db:
        assert len(db.captures()) == 4


def test_a_selection_is_made_shown_and_written(command: Any, some: Path) -> None:
    command("add", some)
    assert command("selections", "add", "day 2").code == 2
    made = command("selections", "add", "day 2", "ana/jump_1:0-1", "--where", "name~kick")
    assert made.out == "day 2: 2 captures changed\n"
    assert answer(command("selections", "--json"))[0]["parts"] == 2
    shown = command("selections", "show", "day 2").out
    assert "ana/jump_1" in shown
    assert "0.00" in shown
    assert "boris/kick_1" in command("list", "--where", "selection='day 2'").out
    written = command("selections", "export", "day 2", "-o", "pack", "--as", "glb").out
    assert written == "day 2: 2 motions in pack; licences: unknown\n"
    assert Path("pack/00001_ana-jump_1.glb").exists()
    command("selections", "take", "day 2", "ana/jump_1")
    assert answer(command("selections", "remove", "day 2", "--json")) == {
        "selection": "day 2", "captures": ["boris/kick_1"],
    }  # fmt: skip


def test_what_is_refused_leaves_nothing_behind(command: Any, some: Path, tmp_path: Path) -> None:
    command("add", some, "--db", "a.duckdb")
    assert command("merge", "none.duckdb", "--db", "new.duckdb").code == 1
    assert command("merge", "a.duckdb", "--prefix", "../", "--db", "new.duckdb").code == 2
    assert not Path("new.duckdb").exists()
    long = command("merge", "a.duckdb", "--prefix", 192 * "x" + "/", "--db", "new.duckdb")
    assert long.code == 1
    assert "expected a name for the capture, found more than 200 bytes." in long.err
    into = command("backup", "no/where.duckdb", "--db", "a.duckdb")
    assert (into.code, into.err) == (
        1,
        "error: no/where.duckdb: expected a folder that is there, found none. Make it, or give "
        "another name.\n",
    )
    assert command("backup", "new.duckdb", "--db", "a.duckdb").code == 2  # there is one already
    command("add", some / "ana" / "bow_1.bvh", "--prefix", "b/", "--db", "a.duckdb")
    asked = "list", "--duplicates", "--json", "--db", "a.duckdb", "--where"
    assert [f["capture"] for f in answer(command(*asked, "name~bow"))["same_files"]] == [
        "ana/bow_1"
    ]
    assert answer(command(*asked, "name~kick"))["same_files"] == []
