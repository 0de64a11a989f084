"""Processor time of small commands as whole processes, beside an earlier build.

    python benchmarks/small_commands.py DB FOLDER FORMER [--runs 5] [--out FILE.md]

DB has learned, and is copied; FOLDER holds captures that are in it; FORMER is the ``motiondb`` of
another environment, with the build to compare with. Each runs in turn on its own copy, after a run
that is not counted (it fills caches, and notes the known files).
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import tempfile
from collections.abc import Sequence
from pathlib import Path

from measured_run import machine, motiondb_command, run_measured

import motiondb


def commands(name: str, folder: Path, place: Path) -> dict[str, list[Sequence[str]]]:
    """What is measured, by its title: commands that leave the database as it was."""
    words, picture = ("walk, turn left",), ("--png", str(place / "picture.png"), "--force")
    made = str(place / "made.bvh")
    return {
        "`rename`, twice": [("rename", name, "renamed"), ("rename", "renamed", name)],
        "`tags set`, twice": [("tags", "set", name, "x=y"), ("tags", "set", name, "x=")],
        "`words set`, then `undo`": [("words", "set", name, "walking around"), ("undo",)],
        "`remove`, then `undo`": [("remove", name), ("undo",)],
        "`add` of a known folder": [("add", str(folder))],
        "`search`": [("search", *words)],
        "`search --png`": [("search", *words, *picture)],
        "`show --png`": [("show", name, *picture)],
        "`generate --png`": [("generate", "a person walks", "-o", made, *picture)],
        "`--help`": [("--help",)],
    }


def main() -> None:
    """Measure, and write a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("db", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("former")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path("docs/measured/small-commands.md"))
    asked = parser.parse_args()
    folder, rows = asked.folder.resolve(), []
    with tempfile.TemporaryDirectory() as place:
        builds = {Path(place) / "former.duckdb": asked.former}
        builds[Path(place) / "today.duckdb"] = motiondb_command()[0]
        for copy in builds:
            shutil.copyfile(asked.db, copy)
        with motiondb.open(next(reversed(builds))) as db:
            name = db.captures()[0].name
        for title, steps in commands(name, folder, Path(place)).items():
            seconds: dict[Path, list[float]] = {copy: [] for copy in builds}
            for _ in range(1 + asked.runs):
                for copy, program in builds.items():
                    settings = {"MOTIONDB": str(copy)}
                    runs = [run_measured([program, *step], settings) for step in steps]
                    seconds[copy].append(sum(run.processor_seconds for run in runs))
            former, today = (statistics.median(each[1:]) for each in seconds.values())
            rows.append(f"| {title} | {former:.2f} s | {today:.2f} s | {today / former:.2f} |")
            print(rows[-1], flush=True)
    text = (
        "# Small commands\n\nProcessor time (user and system) of whole commands, medians of "
        f"{asked.runs}, measured by `python benchmarks/small_commands.py` on {machine()}; each "
        "build in turn with the other, on its own copy of the database.\n\n"
        "| command | former build | this build | share |\n| --- | --- | --- | --- |\n"
    )
    asked.out.write_text(text + "\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
