"""How fast the page's server answers: the first view of large catalogues, and searches.

``--captures`` captures of a second or two are made from the sample data and added to a database,
which then learns (``--learn``). Every route is requested over HTTP on this computer: the first
time, and then the median of ten.

    python benchmarks/page_speed.py --captures 10000
    python benchmarks/page_speed.py --captures 3000 --learn
    python benchmarks/page_speed.py --captures 3000 --learn --learn-from 300
"""

from __future__ import annotations

import argparse
import json
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request
from dataclasses import replace
from pathlib import Path

import duckdb
import numpy as np

import motiondb
from motiondb import AddSettings, LearnSettings, store
from motiondb.body import rotation
from motiondb.records import Caption, CaptureInfo

ROOT = Path(__file__).resolve().parents[1]
AGAIN = 10
"""Requests after the first one, whose median counts. Chosen by hand; not tuned."""
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
                packed = store.pack_source(f"{action}.bvh", str(number).encode(), "bvh")
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


def ask(address: str, path: str, **query: object) -> tuple[float, int]:
    """Seconds until the whole answer is there, and its bytes."""
    text = urllib.parse.urlencode(query, doseq=True)
    began = time.perf_counter()
    with urllib.request.urlopen(f"{address}{path}?{text}", timeout=600) as answer:
        size = len(answer.read())
    return time.perf_counter() - began, size


def measure(address: str, learned: bool) -> list[dict[str, object]]:
    """Ask every kind of question."""
    names = _names(address)
    asked: list[tuple[str, str, dict[str, object]]] = [
        ("status", "api/status", {}),
        ("first 100 rows", "api/captures", {"limit": 100}),
        ("rows by duration, from 5,000", "api/captures", {"sort": "-duration", "offset": 5000}),
        ("rows of a filter", "api/captures", {"where": "performer=p07"}),
        ("facets", "api/facets", {}),
        ("30 small motions", "api/thumbs", {"name": names}),
        ("a motion", "api/motion", {"ref": f"capture:{names[0]}"}),
    ]
    if learned:
        asked += [
            ("search, one action", "api/search", {"q": "kick"}),
            ("search, two actions", "api/search", {"q": "walk, turn left"}),
            ("like", "api/like", {"ref": f"capture:{names[0]}"}),
        ]
    rows = []
    for label, path, query in asked:
        first, size = ask(address, path, **query)
        later = [ask(address, path, **query)[0] for _ in range(AGAIN)]
        rows.append({
            "what": label, "first": round(first, 3),
            "median": round(statistics.median(later), 3), "kilobytes": round(size / 1e3, 1),
        })  # fmt: skip
    return rows


def _names(address: str) -> list[str]:
    with urllib.request.urlopen(f"{address}api/captures?limit=30") as answer:
        return [row["name"] for row in json.load(answer)["captures"]]


def main() -> None:
    """Make the database, serve it, ask."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--captures", type=int, default=3000)
    options.add_argument("--learn", action="store_true")
    options.add_argument("--learn-from", type=int, help="learn from so many; add the rest after")
    options.add_argument("--db", type=Path, help="an existing database instead")
    options.add_argument("--keep", type=Path, help="copy the database to this file")
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
            try:
                for row in measure(address, chosen.learn):
                    print(json.dumps(row), flush=True)
            finally:
                server.terminate()


if __name__ == "__main__":
    main()
