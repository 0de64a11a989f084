"""scene make, update, report, list, remove: what they print, write and refuse."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

DIAGRAM = """diagram "Two"
grammar basketball
attack A1 at 0 7
attack A2 at -3.5 5
1 pass A1 to A2
2 shoot A2
"""


def quick(*more: Any) -> tuple[Any, ...]:
    return ("--seed", 2, "--rounds", 2, *more)


@pytest.fixture
def diagram(tmp_path: Path) -> Path:
    path = tmp_path / "two.tactics"
    path.write_text(DIAGRAM)
    return path


def test_make_update_report_list_remove(
    command: Any, learned_copy: Path, tmp_path: Path, diagram: Path
) -> None:
    out, db = tmp_path / "scene", ("--db", learned_copy)
    made = command("scene", "make", diagram, "-o", out, *quick("--name", "play", *db))
    assert made.code == 0, made.err
    for name in ("A1.bvh", "A2.bvh", "scene.glb", "paths.png", "above.gif", "scene.gif"):
        assert (out / name).stat().st_size > 1000, name

    told = command("scene", "report", out, "--png", tmp_path / "p.png")
    assert told.code == 0, told.err
    assert told.out == (out / "report.txt").read_text()
    assert (tmp_path / "p.png").stat().st_size > 10_000
    facts = json.loads(command("scene", "report", "play", "--json", *db).out)
    assert facts["by_rule"] == json.loads((out / "report.json").read_text())["by_rule"]

    diagram.write_text(DIAGRAM.replace("-3.5 5", "-3.3 5"))
    changed = command("scene", "update", out, diagram, "--no-pictures", "--json", *db)
    assert changed.code == 0, changed.err
    assert json.loads(changed.out)["characters"] == 2
    assert "-3.3 5" in (out / "diagram.tactics").read_text()
    assert not (out / "scene.gif").exists()

    record = json.loads((out / "scene.json").read_text())
    record["report"]["impossible"] = [
        {
            "kind": "airborne", "players": ["A1"], "action": "pass", "start": 20, "end": 32,
            "frame": 26, "value": 12.0, "limit": 3.0, "unit": "frames",
        }
    ]  # fmt: skip
    (out / "scene.json").write_text(json.dumps(record))
    told = command("scene", "report", out)
    assert (told.code, "both feet in the air for 12 frames" in told.out) == (1, True)
    assert command("scene", "report", out, "--json").code == 1

    listed = json.loads(command("scene", "list", "--json", *db).out)
    assert [row["scene"] for row in listed] == ["play"]
    assert "play" in command("scene", "list", *db).out
    gone = command("scene", "remove", "play", *db)
    assert gone.out.strip() == "removed play with play/A1, play/A2"
    assert command("scene", "list", *db).out.startswith("no scenes; motiondb scene make DIAGRAM")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("-3.5 5", "-3.5 500"), "ground"),
        (("grammar basketball", "grammar curling"), "curling: expected a motion grammar"),
    ],
)
def test_bad_diagrams_leave_nothing(
    command: Any, learned_file: Path, tmp_path: Path, change: tuple[str, str], said: str
) -> None:
    path = tmp_path / "bad.tactics"
    path.write_text(DIAGRAM.replace(*change))
    ended = command("scene", "make", path, "-o", tmp_path / "s", *quick("--db", learned_file))
    assert ended.code != 0
    assert said in ended.err
    assert [p.name for p in tmp_path.iterdir()] == ["bad.tactics"]


def test_refusals_before_any_work(
    command: Any, learned_copy: Path, tmp_path: Path, diagram: Path
) -> None:
    db = ("--db", learned_copy)
    for words, said in {
        ("make", diagram, "-o", tmp_path): "expected a new folder, or one that holds a scene",
        ("make", "giv-and-go", "-o", tmp_path / "s"): "give-and-go",
        ("update", tmp_path / "none", diagram): "or the name of a kept one, found neither",
        ("report", tmp_path): "expected the record of a scene",
        ("remove", "none"): "none",
    }.items():
        ended = command("scene", *words, *db)
        assert (ended.code != 0, said in ended.err) == (True, True), ended.err
    assert {p.suffix for p in tmp_path.iterdir()} == {".tactics", ".duckdb", ".cache"}
