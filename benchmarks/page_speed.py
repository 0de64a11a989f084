"""How fast the page is: what its server answers, and what is drawn; writes docs/measured/page.md.

``--captures`` captures of a second or two are made from the sample data and added to a database,
which then learns (``--learn``). Every route is requested over HTTP on this computer: the first
time, and then the median of ten. ``--write`` also measures in headless Chromium
(``page_in_browser.py``) and writes the page.

    python benchmarks/page_speed.py --captures 10000
    python benchmarks/page_speed.py --captures 3000 --learn --learn-from 300 --keep learned.duckdb
    python benchmarks/page_speed.py --db learned.duckdb --learn --write
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import duckdb
import numpy as np
import page_in_browser
import psutil
from measured_run import machine

import motiondb
from motiondb import AddSettings, LearnSettings, store
from motiondb.body import rotation
from motiondb.files import packed_files
from motiondb.records import Caption, CaptureInfo
from real_tasks.real_page import table

ROOT = Path(__file__).resolve().parents[1]
AGAIN = 10
"""Requests after the first one, whose median counts. Chosen by hand; not tuned."""
SETTLED = 60.0
"""Seconds after the start of the server in which it loads what examples need, as in use."""
PAGE = ROOT / "docs" / "measured" / "page.md"
SAVED = 100
_NEXT = f"SELECT capture_id + {SAVED} * n"
REPEAT = (
    "INSERT INTO source SELECT sha256(concat(sha256, n)), t.* EXCLUDE (sha256)"
    " FROM source t, repeats",
    f"INSERT INTO capture {_NEXT}, concat(name, '_', n), sha256(concat(sha256, n)),"
    " t.* EXCLUDE (capture_id, name, sha256) FROM capture t, repeats",
    *(
        f"INSERT INTO {table} {_NEXT}, t.* EXCLUDE (capture_id) FROM {table} t, repeats"
        for table in ("motion", "capture_tag", "caption")
    ),
)
"""Statements that repeat all captures under other numbers and names."""


def make_captures(folder: Path, count: int, seed: int = 0) -> Path:
    """Write captures: parts of the sample data, turned and slightly changed; return their sheet."""
    rng = np.random.default_rng(seed)
    sources = sorted((ROOT / "sample_data" / "captures").rglob("*.bvh"))
    clips = [motiondb.read_capture(path) for path in sources]
    rows = ["file\twords\tperformer"]
    for number in range(count):
        which = int(rng.integers(len(clips)))
        clip = clips[which]
        length = min(int(rng.integers(45, 75)), clip.n_frames)
        start = int(rng.integers(clip.n_frames - length + 1))
        part = slice(start, start + length)
        angles = rng.normal(0.0, 0.01, (1, clip.local_rotations.shape[1], 3))
        turned = rotation.multiply(clip.local_rotations[part], rotation.exp(angles))
        made = replace(clip, local_rotations=turned, root_positions=clip.root_positions[part])
        performer = f"p{number % 40:02d}"
        name = f"{performer}/{sources[which].stem.rsplit('_', 1)[0]}_{seed}{number:05d}"
        (folder / performer).mkdir(exist_ok=True)
        motiondb.write_bvh(made, folder / f"{name}.bvh")
        words = sources[which].stem.rsplit("_", 1)[0].replace("_", " ")
        rows.append(f"{name}\ta person does {words}\t{performer}")
    sheet = folder / "words.tsv"
    sheet.write_text("\n".join(rows) + "\n")
    return sheet


def fill_catalogue(database: Path, count: int, seed: int = 0) -> None:
    """Save captures without reading files: parts of the sample data's motions, a second or two.

    The first :data:`SAVED` are saved; the others, a whole multiple, repeat their rows under other
    names.
    """
    rng = np.random.default_rng(seed)
    sources = sorted((ROOT / "sample_data" / "captures").rglob("*.bvh"))[:20]
    with motiondb.open(database) as db:
        motions = [db.motion(path) for path in sources]
        with store.transaction(db.store):
            run = store.start_run(db.store, "add", {})
            for number in range(min(count, SAVED)):
                which = int(rng.integers(len(motions)))
                motion, length = motions[which], int(rng.integers(45, 75))
                part = replace(
                    motion, local_rotations=motion.local_rotations[:length],
                    root_positions=motion.root_positions[:length],
                )  # fmt: skip
                action = sources[which].stem.rsplit("_", 1)[0]
                performer = f"p{number % 40:02d}"
                info = CaptureInfo(
                    0, f"{performer}/{action}_{number:05d}", "", "bvh", "captured", 30.0,
                    part.n_frames, part.duration, 0, 0.8, f"{action}.bvh", run,
                    {"performer": performer, "licence": "CC0-1.0"},
                )  # fmt: skip
                packed = packed_files.pack_source(f"{action}.bvh", str(number).encode(), "bvh")
                caption = Caption(f"a person does {action.replace('_', ' ')}")
                store.save_capture(db.store, info, part, packed, [caption])
            store.finish_run(db.store, run)
    with duckdb.connect(str(database)) as connection:
        connection.execute(
            "CREATE TEMP TABLE repeats AS SELECT unnest(range(1, ?)) AS n", [count // SAVED]
        )
        for statement in REPEAT:
            connection.execute(statement)


def make_database(database: Path, count: int, learned: int) -> None:
    """Make a database of many short captures.

    It learns from the first ``learned``; the others are added afterwards and only recognised, which
    takes less time and makes the same number of captures to search.
    """
    if not learned:
        fill_catalogue(database, count)
        return
    folders = [database.parent / name for name in ("first", "rest")]
    for seed, (folder, number) in enumerate(zip(folders, (learned, count - learned))):
        folder.mkdir()
        sheet = make_captures(folder, number, seed)
        with motiondb.open(database) as db:
            db.add(folder, sheet, AddSettings(jobs=1))
            if seed == 0:
                db.learn(LearnSettings(n_symbols=40))


@dataclass(frozen=True)
class Asked:
    """A question, or several of one kind that are asked one after the other."""

    what: str
    path: str
    queries: Sequence[Mapping[str, object]]
    target: float | None = None  # Of the median, seconds


@dataclass(frozen=True)
class Answered:
    """What a kind of question took, in seconds, and its kilobytes."""

    what: str
    first: float
    median: float
    processor: float  # Of the server, median
    kilobytes: float
    target: float | None


def ask(address: str, path: str, **query: object) -> tuple[float, int]:
    """Seconds until the whole answer is there, and its bytes."""
    text = urllib.parse.urlencode(query, doseq=True)
    began = time.perf_counter()
    with urllib.request.urlopen(f"{address}{path}?{text}", timeout=600) as answer:
        size = len(answer.read())
    return time.perf_counter() - began, size


def questions(names: Sequence[str], learned: bool) -> list[Asked]:
    """Every kind of question; captures are opened, and parts searched for, each the first time."""
    refs = [f"capture:{name}" for name in names]
    small: dict[str, object] = {"name": names}
    asked = [
        Asked("status", "api/status", ({},) * (AGAIN + 1)),
        Asked("first 100 rows", "api/captures", ({"limit": 100},) * (AGAIN + 1)),
        Asked("rows by duration, from 5,000", "api/captures",
              ({"sort": "-duration", "offset": 5000},) * (AGAIN + 1)),
        Asked("rows of a filter", "api/captures", ({"where": "performer=p07"},) * (AGAIN + 1)),
        Asked("facets", "api/facets", ({},) * (AGAIN + 1)),
        Asked("30 small motions", "api/thumbs", (small,) * (AGAIN + 1)),
        Asked("a motion, each another one", "api/motion", tuple({"ref": ref} for ref in refs)),
        Asked("a capture is opened, each another one", "api/capture",
              tuple({"name": name, "described": False} for name in names), 0.2),
    ]  # fmt: skip
    if learned:
        asked += [
            Asked("likely words of a capture, each another one", "api/describe",
                  tuple({"ref": ref} for ref in refs)),
            Asked("search, one action", "api/search", ({"q": "kick"},) * (AGAIN + 1), 0.3),
            Asked("search, two actions", "api/search",
                  ({"q": "walk, turn left"},) * (AGAIN + 1), 0.3),
            Asked("like by a dragged part, each another one", "api/like",
                  tuple({"ref": ref, "start": 0.3, "end": 1.3} for ref in refs), 1.0),
        ]  # fmt: skip
    return asked


def measure(address: str, server: psutil.Process, learned: bool) -> Iterator[Answered]:
    """Ask every kind of question."""
    for asked in questions(_names(address), learned):
        times, works = [], []
        for query in asked.queries[: AGAIN + 1]:
            before = _worked(server)
            seconds, size = ask(address, asked.path, **query)
            times.append(seconds)
            works.append(_worked(server) - before)
        yield Answered(
            asked.what, times[0], statistics.median(times[1:]), statistics.median(works[1:]),
            size / 1e3, asked.target,
        )  # fmt: skip


def _worked(server: psutil.Process) -> float:
    """Seconds of processor time that a process has used."""
    times = server.cpu_times()
    return float(times.user + times.system)


def _names(address: str) -> list[str]:
    with urllib.request.urlopen(f"{address}api/captures?limit=30") as answer:
        return [row["name"] for row in json.load(answer)["captures"]]


def write_page(answers: Sequence[Answered], drawn: Sequence[dict[str, object]], path: Path) -> None:
    """Write the measured times."""
    rows = [
        [one.what, *(f"{1000 * t:.0f} ms" for t in (one.first, one.median, one.processor)),
         f"{one.kilobytes:.0f}", _judge(one)]
        for one in answers
    ]  # fmt: skip
    seen = [
        [str(row["what"]), ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in row.items()
                                     if k != "what")]
        for row in drawn
    ]  # fmt: skip
    load = os.getloadavg()[0]
    head = ["asked over HTTP", "first", "median", "processor", "kB", "target met"]
    path.write_text(
        f"# Speed of the page\n\nMeasured by `python benchmarks/page_speed.py --db FILE --learn"
        f" --write` on a database of 3,000 captures of a second or two, on {machine()}, at a load"
        f" of {load:.1f} at the end. Times of a loaded machine are upper bounds; the processor"
        ' time of the server is hardly affected by other processes. "Each another one": every'
        " request is the first for its capture.\n\n"
        f"{table(head, rows)}\n\n{table(['in Chromium', 'measured'], seen)}\n",
        encoding="utf-8",
    )


def _judge(one: Answered) -> str:
    if one.target is None:
        return "no target"
    limit = f"at most {1000 * one.target:.0f} ms"
    if one.median <= one.target:
        return f"yes ({limit})"
    return f"**no** ({limit})" if one.processor > one.target else f"by processor time ({limit})"


def main() -> None:
    """Make the database, serve it, ask."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--captures", type=int, default=3000)
    options.add_argument("--learn", action="store_true")
    options.add_argument("--learn-from", type=int, help="learn from so many; add the rest after")
    options.add_argument("--db", type=Path, help="an existing database instead")
    options.add_argument("--keep", type=Path, help="copy the database to this file")
    options.add_argument("--write", action="store_true", help="write docs/measured/page.md")
    chosen = options.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        database = folder / "many.duckdb"
        if chosen.db:
            shutil.copy(chosen.db, database)
        else:
            learned = chosen.learn_from or chosen.captures
            make_database(database, chosen.captures, learned if chosen.learn else 0)
        if chosen.keep:
            shutil.copy(database, chosen.keep)
        code = "from motiondb.cli.main import main; main()"
        command = [sys.executable, "-c", code, "serve", "--no-open", "--port", "0"]
        with subprocess.Popen(
            [*command, "--db", str(database)], stdout=subprocess.PIPE, text=True
        ) as server:
            assert server.stdout is not None
            address = server.stdout.readline().removeprefix("The page is at ").split()[0]
            answers = []
            try:
                time.sleep(SETTLED if chosen.write else 0.0)
                for row in measure(address, psutil.Process(server.pid), chosen.learn):
                    answers.append(row)
                    print(json.dumps(asdict(row)), flush=True)
                if chosen.write:
                    drawn = page_in_browser.measure_views(address)
            finally:
                server.terminate()
        if chosen.write:
            write_page(answers, drawn, PAGE)


if __name__ == "__main__":
    main()
