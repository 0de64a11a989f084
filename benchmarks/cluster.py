"""Past one machine: what workers gain, what is sent, and what 300 hours would take on 16 of them.

    python benchmarks/cluster.py --out FOLDER [--hours .3 1 3] [--most 10] [--inputs FOLDER]

adds, learns and asks at several sizes, on this machine alone and with workers, each a process of
one thread. The input is that of ``benchmarks/growth.py``: its folder may be given, or it is
made. Each figure is written to ``FOLDER/rows.jsonl`` at once; what stands there is not measured
again, so that the command can be interrupted and continued. What workers and the asking process
take is processor time, so that other load changes it little. ``cluster_tasks/model.py`` has the
model, which is fitted to the smaller sizes and checked at the largest.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import shutil
import signal
import sys
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
from cluster_tasks.cluster_page import write_page
from cluster_tasks.processes import Row, measured, started
from growth import SAMPLES, lay_out_hours
from growth_tasks.asking import WORDS
from growth_tasks.warped import read_originals
from measured_run import motiondb_command, run_measured

import motiondb

COMMANDS = ("add", "learn", "batch")
NOT_THE_SAME = ("run", "meta", "learning")  # Tables with times and random marks
N_EXAMPLES = 34  # Examples in the questions of ``batch``, twice as many as words
EXAMPLE_SECONDS = 3.0
WARM_HOURS = 0.05  # Of motion, before anything is measured


@dataclass(frozen=True)
class Size:
    """The input of some hours, and where the databases of it go."""

    hours: float
    captures: Path
    sheet: Path
    out: Path

    def database(self, n_workers: int) -> Path:
        """The database that so many workers made."""
        return self.out / f"{self.hours:g}-hours-{n_workers}-workers.duckdb"


def command_of(command: str, size: Size, db: Path) -> list[str]:
    """The words of a command, to which those of a cluster may be added."""
    options: list[str] = []
    if command == "add":
        for old in (db, db.with_name(f"{db.name}.wal")):
            old.unlink(missing_ok=True)
        shutil.rmtree(db.with_name(f"{db.name}.cache"), ignore_errors=True)
        options = [str(size.captures), "--words", str(size.sheet)]
    elif command == "batch":
        options = [str(_questions(db))]
    return motiondb_command(command, *options, "--db", str(db))


def _questions(db: Path) -> Path:
    """Questions in words, and by parts of captures."""
    with motiondb.open(db, read_only=True) as opened:
        infos = [i for i in opened.captures() if i.duration > EXAMPLE_SECONDS]
        words = [word for word in WORDS if _is_known(opened, word)]
    examples = infos[:: max(1, len(infos) // N_EXAMPLES)][:N_EXAMPLES]
    path = db.with_suffix(".tsv")
    with path.open("w", newline="") as file:
        table = csv.writer(file, delimiter="\t")
        table.writerow(["question", "like", "start", "end"])
        table.writerows([word, "", "", ""] for word in words)
        table.writerows(["", info.name, 0, EXAMPLE_SECONDS] for info in examples)
    return path


def _is_known(db: motiondb.MotionDB, words: str) -> bool:
    """Whether a question is answered."""
    try:
        db.search(words)
    except motiondb.MotionDBError:
        return False
    return True


def run(command: str, size: Size, n_workers: int) -> Row:
    """Run a command with so many workers; 0: without a cluster."""
    db = size.database(n_workers)
    arguments = command_of(command, size, db)

    def alone(*more: str) -> Row:
        done = run_measured([*arguments, *more])
        if done.exit_code:
            raise SystemExit(f"{arguments}: exit code {done.exit_code}\n{done.complaints}")
        given = hashlib.sha256(done.output.encode()).hexdigest()
        return {
            "clock, s": done.seconds,
            "own, s": done.processor_seconds,
            "own peak, bytes": float(done.peak_bytes),
            **({"answers": float(int(given[:12], 16))} if command == "batch" else {}),
        }

    if n_workers == 0:
        row = alone()
    else:
        with started(n_workers, size.out) as processes:
            row = measured(processes, lambda: alone("--cluster", processes.address))
    if command == "learn":
        row["answers"] = _digest(db)
    return {"asked hours": size.hours, "workers": float(n_workers), "hours": _hours_of(db), **row}


def _digest(db: Path) -> float:
    """A number for all rows of a database, but times and random marks."""
    digest = hashlib.sha256()
    with closing(duckdb.connect(str(db), read_only=True)) as opened:
        tables = opened.execute("SELECT table_name FROM information_schema.tables").fetchall()
        for name in sorted(name for (name,) in tables if name not in NOT_THE_SAME):
            rows = sorted(map(repr, opened.execute(f'SELECT * FROM "{name}"').fetchall()))
            digest.update("\n".join([name, *rows]).encode())
    return float(int(digest.hexdigest()[:12], 16))  # a whole number that JSON keeps


def _hours_of(db: Path) -> float:
    with motiondb.open(db, read_only=True) as opened:
        return sum(info.duration for info in opened.captures()) / 3600.0


def inputs_of(hours: float, arguments: argparse.Namespace) -> Size:
    """The input of some hours: what is given, or the first files of more hours, or made here."""
    out: Path = arguments.out
    for given in (arguments.inputs or out, out):
        sizes = (float(folder.name.removeprefix("hours-")) for folder in given.glob("hours-*"))
        for size in sorted(size for size in sizes if size >= hours):
            folder = given / f"hours-{size:g}"
            captures, sheet = folder / "captures", folder / "captions.tsv"
            if captures.is_dir() and sheet.is_file():
                found = Size(size, captures, sheet, out)
                return found if size == hours else first_files(found, hours)
    originals = read_originals(arguments.captures, arguments.words, out / "originals.duckdb")
    made = lay_out_hours(originals, out, hours)
    return Size(hours, made.captures, made.sheet, out)


def first_files(size: Size, hours: float) -> Size:
    """The first files of a larger size, as many as their bytes make some hours."""
    folder = size.out / f"hours-{hours:g}"
    with size.sheet.open(newline="") as file:
        head, *rows = csv.reader(file, delimiter="\t")
    names = list(dict.fromkeys(row[0] for row in rows))
    sizes = np.cumsum([(size.captures / name).stat().st_size for name in names])
    kept = names[: int(np.searchsorted(sizes, sizes[-1] * hours / size.hours)) + 1]
    for name in kept:
        target = folder / "captures" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(size.captures / name, target)
    with (folder / "captions.tsv").open("w", newline="") as file:
        csv.writer(file, delimiter="\t").writerows([head, *(r for r in rows if r[0] in set(kept))])
    return Size(hours, folder / "captures", folder / "captions.tsv", size.out)


def warm_up(arguments: argparse.Namespace) -> None:
    """Have all kernels compiled, which is done once and kept."""
    size = inputs_of(WARM_HOURS, arguments)
    for command in COMMANDS:
        run(command, size, 0)


def rows_in(file: Path) -> list[dict[str, Any]]:
    """The rows of a file, if there is one."""
    lines = file.read_text().splitlines() if file.is_file() else []
    return [json.loads(line) for line in lines]


def measure(arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """All rows: those that were measured before, and the others now."""
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    file = out / "rows.jsonl"
    rows = rows_in(file)
    known = {(row["asked hours"], row["workers"], row["command"]) for row in rows}
    wanted = [
        (hours, n_workers, command)
        for hours in sorted([*arguments.hours, *arguments.most])
        for n_workers in arguments.workers
        if hours in arguments.hours or n_workers == max(arguments.workers)
        for command in COMMANDS
    ]
    missing = [each for each in wanted if each not in known]
    if missing:
        warm_up(arguments)
    for hours, n_workers, command in missing:
        print(f"{hours:g} hours, {n_workers} workers: {command}", file=sys.stderr, flush=True)
        row = run(command, inputs_of(hours, arguments), n_workers) | {"command": command}
        rows.append(row)
        with file.open("a") as written:
            written.write(json.dumps(row) + "\n")
    return rows


def main() -> None:
    """Measure what is missing, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="databases and figures")
    parser.add_argument("--hours", type=float, nargs="+", default=[0.3, 1.0, 3.0])
    parser.add_argument("--most", type=float, nargs="*", default=[], help="with most workers only")
    parser.add_argument("--workers", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--inputs", type=Path, help="the folder of benchmarks/growth.py")
    parser.add_argument("--captures", type=Path, default=SAMPLES / "captures")
    parser.add_argument("--words", type=Path, default=SAMPLES / "captions.tsv")
    parser.add_argument("--page", type=Path, help="where the page is written")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that workers end, too
    rows = measure(arguments)
    if arguments.page:
        growth = rows_in(arguments.inputs / "rows.jsonl") if arguments.inputs else []
        sizes = {row["asked hours"]: row for row in growth if "learn, s" in row}  # the last of each
        write_page(rows, list(sizes.values()), arguments.page)


if __name__ == "__main__":
    main()
