"""The commands curate, coverage and diff."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from command_answers import answer


def test_a_library_is_chosen_from_told_and_compared(command: Any, some: Path) -> None:
    assert command("add", some).code == 0
    asked = ("curate", "--share", "50%", "--shortest", "1", "--quality", "0")
    told = answer(command(*asked, "--dry-run", "--json"))
    assert told["splits"][0]["bound"] <= told["splits"][0]["distance"]
    assert "folder" not in told
    ended = command(*asked, "-o", "train", "--as", "csv")
    assert ended.code == 0
    assert "written: train, with manifest.csv and manifest.json" in ended.out
    assert len(list(Path("train").glob("*.csv"))) == len(told["intervals"]) + 1
    assert command(*asked, "-o", "train").code == 2
    assert command("curate", "--share", "50%").code == 2
    assert command("curate", "--share", "lots", "-o", "x").code == 2
    assert command(*asked, "-o", "x", "--as", "docx").code == 2
    assert not Path("x").exists()
    ended = command("coverage", "--png", "coverage.png")
    assert ended.code == 0
    assert "To record: run with a sharp left turn (none)" in ended.out
    assert Path("coverage.png").exists()
    assert len(answer(command("coverage", "--json"))["shots"]) > 10
    shutil.copy("motions.duckdb", "other.duckdb")
    ended = command("diff", "other.duckdb")
    assert ended.code == 0
    assert "4 of 4 captures are in other.duckdb, 0 are not" in ended.out
    assert {e["kind"] for e in answer(command("diff", "other.duckdb", "--json"))["shared"]} == {
        "same file"
    }
