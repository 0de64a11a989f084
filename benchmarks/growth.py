"""Growth of time, memory and size with the hours of motion; writes a page and a picture.

    python benchmarks/growth.py --out FOLDER [--hours 1 3 10 40] [--captures FOLDER --words SHEET]

Makes its own input: warped variants of the captures that it is given, or of the sample data. Every
stage is a process of its own, whose processor time and largest resident memory are measured (with
those of its children). Each figure is written to ``FOLDER/rows.jsonl`` at once; what stands there
is not measured again, so that the command can be interrupted and continued.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import duckdb
from growth_tasks.growth_page import with_beside, write_beside, write_page
from growth_tasks.warped import Original, lay_out, make_pool, read_originals
from measured_run import motiondb_command, run_measured

ROOT = Path(__file__).parent.parent
SAMPLES = ROOT / "sample_data"
N_MORE = 10  # Captures that are added in the end
QUESTION = "walk then jump"
CHECK = ["check", "--quick"]
Row = dict[str, float]


def stage(command: list[str], name: str) -> Row:
    """Processor and clock seconds and peak memory of a command."""
    run = run_measured(command)
    if run.exit_code:
        raise SystemExit(f"{' '.join(command)}: exit code {run.exit_code}\n{run.complaints}")
    return {
        f"{name}, s": run.processor_seconds,
        f"{name}, clock s": run.seconds,
        f"{name}, peak bytes": float(run.peak_bytes),
    }


def size_of(path: Path) -> int:
    """Bytes of a file, or of all files below a folder."""
    if path.is_dir():
        return sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
    return path.stat().st_size if path.is_file() else 0


@dataclass(frozen=True)
class Given:
    """The input of a size: captures, their sheet, the same of ten more, and the database."""

    captures: Path
    sheet: Path
    more: tuple[Path, Path]
    db: Path


def add(given: Given) -> Row:
    """``motiondb add`` into a new database."""
    captures, sheet, db = given.captures, given.sheet, given.db
    for old in (db, db.with_name(f"{db.name}.wal")):
        old.unlink(missing_ok=True)
    shutil.rmtree(db.with_name(f"{db.name}.cache"), ignore_errors=True)
    return stage(
        motiondb_command("add", str(captures), "--words", str(sheet), "--db", str(db)), "add"
    ) | {"text bytes": float(size_of(captures))}


def learn(given: Given) -> Row:
    """``motiondb learn``, and what file and cache then take."""
    db = given.db
    row = stage(motiondb_command("learn", "--db", str(db)), "learn")
    return row | _sizes(db)


def _sizes(db: Path) -> Row:
    run = run_measured(motiondb_command("info", "--db", str(db), "--json"))
    facts = json.loads(run.output)
    return {
        "captures": float(facts["captures"]),
        "hours": facts["seconds"] / 3600.0,
        "symbols": float(facts["symbols"]),
        "file bytes": float(size_of(db)),
        "cache bytes": float(size_of(db.with_name(f"{db.name}.cache"))),
        "originals bytes": _originals(db),
    }


def _originals(db: Path) -> float:
    """Bytes of the kept files, compressed."""
    query = "SELECT sum(octet_length(data) + coalesce(octet_length(skeleton_data), 0)) FROM source"
    with duckdb.connect(str(db), read_only=True) as connection:
        row = connection.execute(query).fetchone()
    return float(row[0] or 0) if row else 0.0


def ask(given: Given) -> Row:
    """Questions in an open database."""
    script = ROOT / "benchmarks/growth_tasks/asking.py"
    after = stage(motiondb_command("search", QUESTION, "--db", str(given.db)), "first search")
    run = run_measured([sys.executable, str(script), str(given.db)])
    if run.exit_code:
        raise SystemExit(f"asking: exit code {run.exit_code}\n{run.complaints}")
    row: Row = json.loads(run.output.splitlines()[-1])
    cache = size_of(given.db.with_name(f"{given.db.name}.cache"))
    return row | after | {"cache bytes": float(cache)}


def shell(given: Given) -> Row:
    """Commands from the shell."""
    db = given.db
    row = stage(motiondb_command("search", QUESTION, "--db", str(db)), "motiondb search")
    for name, words in (("info", ["info"]), ("list", ["list"]), ("check", CHECK)):
        row |= stage(motiondb_command(*words, "--db", str(db)), name)
    return row


def add_more(given: Given) -> Row:
    """Ten captures more, to a copy, and the first search for them."""
    (captures, sheet), db = given.more, given.db
    copy = db.with_name("copy.duckdb")
    shutil.copyfile(db, copy)
    cache = db.with_name(f"{db.name}.cache")
    shutil.copytree(cache, copy.with_name(f"{copy.name}.cache"), dirs_exist_ok=True)
    try:
        added = stage(
            motiondb_command("add", str(captures), "--words", str(sheet), "--db", str(copy)),
            f"adding {N_MORE} more",
        )
        found = stage(motiondb_command("search", QUESTION, "--db", str(copy)), "search after it")
        both = added[f"adding {N_MORE} more, s"] + found["search after it, s"]
        return added | found | {f"{N_MORE} more searched, s": both}
    finally:
        copy.unlink()
        shutil.rmtree(copy.with_name(f"{copy.name}.cache"), ignore_errors=True)


STAGES: dict[str, Callable[[Given], Row]] = {
    "add, s": add,
    "learn, s": learn,
    "first question, s": ask,
    "motiondb search, s": shell,
    f"{N_MORE} more searched, s": add_more,
}  # by a figure that each gives


def lay_out_hours(originals: list[Original], out: Path, hours: float) -> Given:
    """The input of some hours, and ten captures more."""
    folder, pool = out / f"hours-{hours:g}", out / "pool"
    made = make_pool(originals, pool, hours)
    more = make_pool(originals, pool, hours + 0.5)[len(made) :][:N_MORE]
    first, second = lay_out(made, pool, folder), lay_out(more, pool, folder / "more")
    return Given(*first, second, folder / "motions.duckdb")


def read_rows(out: Path) -> dict[float, Row]:
    """Rows that were measured before, by hours."""
    file, rows = out / "rows.jsonl", dict[float, Row]()
    for line in file.read_text().splitlines() if file.is_file() else []:
        entry = json.loads(line)
        rows.setdefault(entry["asked hours"], {}).update(entry)
    return rows


def measure(arguments: argparse.Namespace) -> list[Row]:
    """All rows: those that were measured before, and the others now."""
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    file, rows = out / "rows.jsonl", read_rows(out)
    originals: list[Original] = []
    for hours in sorted(arguments.hours):
        row = rows.setdefault(hours, {"asked hours": hours})
        if all(key in row for key in STAGES):
            continue
        originals = originals or read_originals(
            arguments.captures, arguments.words, out / "originals.duckdb"
        )
        given = lay_out_hours(originals, out, hours)
        for key, run in STAGES.items():
            if key in row:
                continue
            print(f"{hours:g} hours: {key.rpartition(',')[0]}", file=sys.stderr, flush=True)
            row |= run(given)
            with file.open("a") as written:
                written.write(json.dumps(row) + "\n")
    return [rows[hours] for hours in sorted(rows) if "add, s" in rows[hours]]


def main() -> None:
    """Measure what is missing, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="input, databases and figures")
    parser.add_argument("--hours", type=float, nargs="+", default=[1.0, 3.0, 10.0, 40.0])
    parser.add_argument("--captures", type=Path, default=SAMPLES / "captures")
    parser.add_argument("--words", type=Path, default=None)
    parser.add_argument("--page", type=Path, default=ROOT / "docs/measured/scale.md")
    parser.add_argument(
        "--former",
        nargs=3,
        metavar=("OUT", "COMMIT", "COMMIT"),
        help="write a last section: OUT of another build, its commit and that of this one",
    )
    arguments = parser.parse_args()
    if arguments.words is None and arguments.captures == SAMPLES / "captures":
        arguments.words = SAMPLES / "captions.tsv"
    rows = measure(arguments)
    if arguments.former is None:
        write_page(rows, arguments.captures, arguments.page)
        return
    folder, *builds = arguments.former
    former = [with_beside(row) for _, row in sorted(read_rows(Path(folder)).items())]
    write_beside([with_beside(row) for row in rows], former, tuple(builds), arguments.page)


if __name__ == "__main__":
    main()
