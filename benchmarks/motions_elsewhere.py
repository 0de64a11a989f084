"""Motions in the database file, in folders and at URLs: sizes, and the time to move and to read.

    python benchmarks/motions_elsewhere.py DB PLACE... [--out FILE.md]

A database that has learned is copied for every place, with its cache, into a temporary folder. Its
motions, originals and scores are moved to the place and stay there. Times are of the clock, since
reading waits for the place; the page says on which machine. A URL needs the packages and the
configuration that fsspec needs for it.
"""

from __future__ import annotations

import argparse
import random
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

import numpy as np
from measured_run import machine

import motiondb
from motiondb import MotionDB, store

WORDS = ("walk", "run", "jump", "turn left", "walk then jump")
SENTENCES = ("walk then jump", "run then kick", "jump then walk")
N_READ, N_EXAMPLES = 100, 10
Row = dict[str, float]


def seconds_of(
    asks: Iterable[Callable[[], object]],
    times: int = 1,
    clock: Callable[[], float] = time.perf_counter,
) -> list[float]:
    """Seconds of every call; the least of several times, as others work on the machine too."""

    def taken(ask: Callable[[], object]) -> float:
        began = clock()
        ask()
        return clock() - began

    return [min(taken(ask) for _ in range(times)) for ask in asks]


def reading(db: Path) -> Row:
    """Milliseconds for motions and originals, at random and in order, and for all scores."""
    with store.open_store(db, read_only=True) as opened:
        numbers = [info.capture_id for info in store.load_captures(opened)]
        some = random.Random(0).sample(numbers, min(N_READ, len(numbers)))
        motions = seconds_of(partial(store.load_motion, opened, n) for n in some)
        files = seconds_of(partial(store.load_source, opened, n) for n in some)
        ordered = seconds_of(partial(store.load_motion, opened, n) for n in numbers)
        scores = seconds_of([partial(store.load_scores, opened)])
    return {
        "a motion, at random, ms": 1e3 * float(np.median(motions)),
        "an original, at random, ms": 1e3 * float(np.median(files)),
        "all motions in order, ms for each": 1e3 * float(np.mean(ordered)),
        "all scores of segments, ms": 1e3 * scores[0],
    }


def asking(db: Path) -> Row:
    """Medians of questions in an open database."""
    with motiondb.open(db, read_only=True) as opened:
        rows = [info for info in opened.captures() if info.duration > 4.0]
        names = [info.name for info in rows[:: max(1, len(rows) // N_EXAMPLES)]][:N_EXAMPLES]
        words = [lambda w=w: opened.search(w) for w in WORDS]
        likes = [lambda n=n: opened.like(n, start=0.5, end=3.5) for n in names]
        made = [lambda s=s: _generate(opened, s) for s in SENTENCES]
        return {
            "word question, ms of processor": 1e3
            * float(np.median(seconds_of(words, 3, time.process_time))),
            "example of 3 s of a capture, ms": 1e3 * float(np.median(seconds_of(likes, 3))),
            "two actions generated, s": float(np.median(seconds_of(made, 3))),
        }


def asking_first(db: Path) -> Row:
    """Seconds of the first question where there is no cache beside the database."""
    shutil.rmtree(db.with_name(f"{db.name}.cache"))
    with motiondb.open(db, read_only=True) as opened:
        first = seconds_of([lambda: opened.search(WORDS[0])])
    return {"first word question without a cache, s": first[0]}


def _generate(opened: MotionDB, words: str) -> None:
    opened.generate(words, 7, anyway=True)


def measured(original: Path, place: str) -> Row:
    """All figures of one place; "": in the database file."""
    with tempfile.TemporaryDirectory(dir=original.parent) as folder:
        db = Path(folder) / original.name
        shutil.copyfile(original, db)
        cache = original.with_name(f"{original.name}.cache")
        shutil.copytree(cache, db.with_name(cache.name))
        row: Row = {}
        if place:
            began, worked = time.perf_counter(), time.process_time()
            motiondb.compact(db, motions_to=place)
            row["moved, s"] = time.perf_counter() - began
            row["moved, s of processor"] = time.process_time() - worked
        with motiondb.open(db, read_only=True) as opened:
            facts = opened.info()
        row["database file, MB"] = facts.bytes / 1e6
        row["Parquet files, MB"] = (facts.parquet_bytes or 0) / 1e6
        return row | reading(db) | asking(db) | asking_first(db)


def main() -> None:
    """Measure every place, and write a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("db", type=Path)
    parser.add_argument("places", nargs="+")
    parser.add_argument("--note", default="", help="What else to say of the places.")
    parser.add_argument("--out", type=Path, default=Path("docs/measured/motions-elsewhere.md"))
    asked = parser.parse_args()
    with motiondb.open(asked.db) as opened:  # one of an earlier version is brought up to date
        hours = opened.info().seconds / 3600.0
        n_captures = len(opened.captures())
        opened.search(WORDS[0])
        opened.like(opened.captures()[0].name)
    columns = {"in the file": measured(asked.db, "")}
    for place in asked.places:
        kind = place.partition("://")[0] + "://" if "://" in place else "a folder"
        columns[kind] = measured(asked.db, place)
    rows = [
        "# Motions elsewhere\n",
        "Measured by `python benchmarks/motions_elsewhere.py` on a database of "
        f"{hours:.1f} hours, {n_captures} captures, on {machine()}, with other load. Times are of "
        "the clock, if nothing else is said: medians, and for questions of the least of three "
        f"times each. {asked.note}".rstrip()
        + "\n",
        f"| | {' | '.join(columns)} |",
        f"|---|{'---|' * len(columns)}",
    ]
    for name in next(reversed(columns.values())):
        figures = [f"{row[name]:.3g}" if name in row else "-" for row in columns.values()]
        rows.append(f"| {name} | {' | '.join(figures)} |")
    asked.out.write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
