"""scene make, update, report, list, remove: what they print, write and refuse."""

from __future__ import annotations

import json
import shutil
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
    assert "play: 2 characters" in made.out
    assert "rules kept: " in made.out
    assert "impossible motion: none" in made.out
    said = "sampling was cut short by --minutes 0.005: the seed alone does not determine this scene"
    cut_short = json.loads((out / "report.json").read_text())["cut_short"]
    assert (said in made.out) == (said in (out / "report.txt").read_text()) == cut_short
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

    listed = json.loads(command("scene", "list", "--json", *db).out)
    assert [row["scene"] for row in listed] == ["play"]
    assert "play" in command("scene", "list", *db).out
    assert command("remove", "play/A1", *db).code == 0
    gone = command("scene", "remove", "play", *db)
    assert gone.code == 0, gone.err
    assert gone.out.strip() == "removed play with play/A2"
    assert command("check", *db).out.strip().endswith("is sound")
    assert command("scene", "list", *db).out.startswith("no scenes; motiondb scene make DIAGRAM")


def test_time_that_cuts_a_scene_short_is_told(
    command: Any, learned_copy: Path, tmp_path: Path, diagram: Path
) -> None:
    out = tmp_path / "scene"
    more = ("--minutes", 0.0001, "--no-pictures", "--db", learned_copy)
    made = command("scene", "make", diagram, "-o", out, *quick(*more))
    facts = json.loads((out / "report.json").read_text())
    assert made.code == bool(facts["impossible"])  # what one round makes may be anything
    assert facts["cut_short"]
    assert facts["cut_at"] == {"try": 1, "rounds": 1, "of": 2}
    said = (
        "sampling was cut short by --minutes 0.0001: the seed alone does not determine this scene"
    )
    assert said in made.out
    assert "it ended after 1 of 2 rounds of try 1" in made.out


def test_impossible_motion_ends_with_1_and_its_frame(
    command: Any, learned_copy: Path, tmp_path: Path, diagram: Path
) -> None:
    out = tmp_path / "scene"
    command("scene", "make", diagram, "-o", out, *quick("--no-pictures", "--db", learned_copy))
    record = json.loads((out / "scene.json").read_text())
    record["report"]["impossible"] = [
        {
            "kind": "airborne", "players": ["A1"], "action": "pass", "start": 20, "end": 32,
            "frame": 26, "value": 12.0, "limit": 3.0, "unit": "frames",
        }
    ]  # fmt: skip
    (out / "scene.json").write_text(json.dumps(record))
    told = command("scene", "report", out)
    assert told.code == 1
    assert "A1 pass, frames 20 to 31, most at 26: both feet in the air for 12 frames" in told.out
    told = command("scene", "report", out, "--json")
    assert told.code == 1
    assert [motion["frame"] for motion in json.loads(told.out)["impossible"]] == [26]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("attack A1 at 0 7", "court 4000 x 2\nattack A1 at 0 7"), "2:7: expected"),
        (("shoot A2", "shoot A9"), "A9"),
        (("-3.5 5", "-3.5 500"), "court"),
        (("grammar basketball", "grammar curling"), "curling: expected a motion grammar"),
    ],
)
def test_bad_diagrams_leave_nothing(
    command: Any, learned_file: Path, tmp_path: Path, change: tuple[str, str], said: str
) -> None:
    text = DIAGRAM.replace("grammar basketball\n", "", "court" in change[1])
    path = tmp_path / "bad.tactics"
    path.write_text(text.replace(*change))
    ended = command("scene", "make", path, "-o", tmp_path / "s", *quick("--db", learned_file))
    assert ended.code != 0
    assert said in ended.err
    assert [p.name for p in tmp_path.iterdir()] == ["bad.tactics"]


def test_a_weight_of_zero_is_refused(
    command: Any, learned_file: Path, tmp_path: Path, diagram: Path
) -> None:
    from motiondb.database.scenes.scene_texts import text_of

    text, _ = text_of("basketball", ".grammar")
    (tmp_path / "basketball.grammar").write_text(f"{text}\nweight collision 0\n")
    ended = command("scene", "make", diagram, "-o", tmp_path / "s", *quick("--db", learned_file))
    assert ended.code != 0
    assert "basketball.grammar:" in ended.err
    assert "expected a weight above 0" in ended.err
    assert not (tmp_path / "s").exists()


def test_refusals_before_any_work(
    command: Any, learned_file: Path, tmp_path: Path, diagram: Path
) -> None:
    db = ("--db", learned_file)
    full = tmp_path / "full"
    shutil.copytree(diagram.parent, full)
    ended = command("scene", "make", diagram, "-o", full, *quick(*db))
    assert "expected a new folder, or one that holds a scene" in ended.err
    ended = command("scene", "make", diagram, "-o", tmp_path / "s", "--chains", 0, *db)
    assert "chains: expected 1 to 64" in ended.err
    ended = command("scene", "make", "giv-and-go", "-o", tmp_path / "s", *db)
    assert "give-and-go" in ended.err
    ended = command("scene", "update", tmp_path / "none", diagram, *db)
    assert "expected the folder of a scene, or the name of a kept one, found neither" in ended.err
    ended = command("scene", "report", full)
    assert "expected the record of a scene" in ended.err
    ended = command("scene", "remove", "none", *db)
    assert ended.code != 0
