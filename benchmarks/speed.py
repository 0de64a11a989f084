"""How fast questions are answered, in one run, against the targets; writes a page.

    python benchmarks/speed.py --database FILE [--output docs] [--repeats 40]

FILE is a learned database of the real captures (see ``real_captures.py --database``). Questions are
asked in an open database after one of each kind, so that what is loaded and compiled once is not
counted; commands are whole processes with files in the system's cache. The comparisons with
hmmlearn and nltk are benchmarks of their own, run here once each. Beside each comparison stand the
multiply-adds and the bytes that the work needs at least, and what the slower of both would take of
the time: multiply-adds at the rate of this machine in the product of two large matrices, bytes at
the rate at which it reads a large array.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import psutil
from measured_run import machine, motiondb_command, run_measured, versions

import motiondb
from motiondb.body.features import FEATURE_FPS
from motiondb.database import MotionDB
from motiondb.learn.recognition import decode
from motiondb.meaning import alignment
from real_tasks.questions import EXAMPLES, SENTENCES, WORDS
from real_tasks.real_page import table

HERE = Path(__file__).parent
EXAMPLE_SECONDS = 3.0
"""Seconds of an example."""
PART, FEW_PARTS = 6, 5
"""Symbols of a part of a capture, some 13 s; parts that are also found by their frames."""
DECODED_WORDS = 6
"""Words that are decoded together. Chosen by hand; not tuned."""
PACKAGES = ("motiondb", "numpy", "scipy", "numba", "duckdb", "hmmlearn", "nltk")


@dataclass(frozen=True)
class Timing:
    """A row: median and 95th percentile of the time that passed, median of the processor's time
    (on a machine with other work the first two are larger); the target is for ``judged``
    ("median" or "p95")."""

    name: str
    median: float
    p95: float
    processor: float
    unit: str
    n: int
    target: float
    judged: str = "p95"

    @property
    def met(self) -> bool:
        """Whether the judged figure is within the target."""
        return (self.median if self.judged == "median" else self.p95) <= self.target


@dataclass(frozen=True)
class Ratio:
    """How many times faster than a reference, at equal results or not."""

    name: str
    times: float
    target: float  # 0: none
    difference: str
    work: float  # Multiply-adds that the results need at least
    read: float  # Bytes that must be read or written at least: each array once
    seconds: float  # Of motiondb
    kind: str = "float64"  # Of the numbers


def time_each(name: str, asks: Sequence[Callable[[], object]], target_ms: float) -> Timing:
    """Every question once in turn, after a first round that is not counted."""
    for ask in dict.fromkeys(asks):
        ask()
    seconds, worked = [], []
    for ask in asks:
        started, began = time.perf_counter(), time.process_time()
        ask()
        seconds.append(time.perf_counter() - started)
        worked.append(time.process_time() - began)
    low, high = np.quantile(seconds, [0.5, 0.95]) * 1e3
    processor = float(np.median(worked)) * 1e3
    return Timing(name, float(low), float(high), processor, "ms", len(seconds), target_ms)


def time_questions(db: MotionDB, repeats: int) -> list[Timing]:
    """Word search, search by example, decoding: each over many different questions."""
    rng = np.random.default_rng(0)
    word_asks = [lambda w=w: db.search(w) for w in WORDS]
    motions = [
        db.motion(e.capture, e.start or 0.0, (e.start or 0.0) + EXAMPLE_SECONDS)
        for e in EXAMPLES
        if e.capture not in ("16/16_35", "16/16_05", "07/07_01")  # shorter than the example
    ]
    like_asks = [lambda m=m: db.like(m) for m in motions]
    counts = db.learned.association.counts
    common = [w for w, n in zip(db.learned.association.words, counts) if n >= 2]
    sentences = [
        [common[i] for i in rng.integers(0, len(common), DECODED_WORDS)] for _ in range(repeats)
    ]
    decode_asks = [lambda s=s: decode(db.learned, s) for s in sentences]
    make_asks = [lambda s=s: db.generate(s, 7) for s in SENTENCES]
    return [
        time_each("word search", word_asks * max(1, repeats // 10), 50.0),
        time_each("search by a 3 s example", like_asks * max(1, repeats // 8), 300.0),
        time_each(f"decoding of {DECODED_WORDS} random words", decode_asks * 2, 20.0),
        time_each("generating a sentence", make_asks * max(1, repeats // 20), float("inf")),
    ]


def time_command(
    name: str, command: list[str], repeats: int, target_s: float
) -> tuple[Timing, int]:
    """Whole processes; the peak memory of the largest, bytes."""
    runs = [run_measured(command) for _ in range(repeats + 1)][1:]
    for run in runs:
        if run.exit_code:
            raise SystemExit(f"{' '.join(command)}: exit code {run.exit_code}\n{run.complaints}")
    low, high = np.quantile([run.seconds for run in runs], [0.5, 0.95])
    processor = float(np.median([run.processor_seconds for run in runs]))
    timing = Timing(name, float(low), float(high), processor, "s", repeats, target_s, "median")
    return timing, max(run.peak_bytes for run in runs)


def compare() -> list[Ratio]:
    """The ratios to hmmlearn and nltk, from their own benchmarks."""
    hmm, words = _run_json("hmm.py"), _run_json("association.py")
    score, fit = hmm["score"], hmm["fit"]
    score_gap = f"relative difference of scores {score['largest_relative_difference']:.0e}"
    fit_gap = f"difference of means {fit['largest_difference_of_means']:.0e}"
    return [
        Ratio(
            "scoring, against hmmlearn",
            score["times_faster"],
            40.0,
            score_gap,
            score["multiply_adds"],
            score["bytes"],
            score["motiondb_s"],
            "float32",
        ),
        Ratio(
            "fitting, against hmmlearn",
            fit["times_faster"],
            10.0,
            fit_gap,
            fit["multiply_adds"],
            fit["bytes"],
            fit["motiondb_s"],
        ),
        Ratio(
            "IBM Model 2, against nltk",
            words["ratio"],
            50.0,
            f"difference of t {words['largest_difference_of_t']:.0e}",
            words["multiply_adds"],
            words["bytes"],
            words["motiondb_s"],
        ),
    ]


def compare_parts(db: MotionDB, repeats: int) -> tuple[Timing, Ratio]:
    """Parts of captures, found by their symbols, and by the frames with compiled time warping."""
    learned, pool, rng = db.learned, db.session.pool, np.random.default_rng(0)
    table_, scale = learned.segments, alignment.distance_scale(learned.distances)
    frames = {c: pool.whitened(c) for c in learned.rows}
    long = [c for c, rows in learned.rows.items() if rows.stop - rows.start > PART]
    parts = []
    for capture in rng.choice(long, repeats).tolist():
        rows = learned.rows[capture]
        first = rows.start + int(rng.integers(rows.stop - rows.start - PART))
        parts.append((capture, first))

    def by_symbols(first: int) -> dict[int, float]:
        symbols, weights = table_.symbols[first : first + PART], np.full(PART, 1.0 / PART)
        return {
            c: -alignment.align(symbols, weights, table_.symbols[r], learned.distances, scale)[0]
            for c, r in learned.rows.items()
        }

    def by_frames(capture: int, first: int) -> dict[int, float]:
        low, high = table_.starts[first] // 2, table_.ends[first + PART - 1] // 2
        query = frames[capture][low:high]
        return {c: alignment.best_part(query, whole.T)[0] for c, whole in frames.items()}

    minutes = sum(len(whole) for whole in frames.values()) / FEATURE_FPS / 60.0
    name = f"part of {PART} symbols in {minutes:.0f} minutes, by symbols"
    timing = time_each(name, [partial(by_symbols, f) for _, f in parts], 5.0)
    began = time.perf_counter()
    slow = [by_frames(*part) for part in parts[:FEW_PARTS]]
    seconds = (time.perf_counter() - began) / FEW_PARTS
    found = [found[c] <= min(found.values()) + 1e-9 for (c, _), found in zip(parts, slow)]
    own = [by_symbols(f)[c] <= min(by_symbols(f).values()) + 1e-9 for c, f in parts]
    difference = (
        f"finds its own place first: {sum(own)} of {len(own)}, {sum(found)} of {len(found)}"
    )
    work = 3.0 * PART * len(table_.symbols)  # a pair, a gap in either
    times = seconds / (timing.median / 1e3)
    what = "part by symbols, against compiled time warping of frames"
    read = float(table_.symbols.nbytes + learned.distances.nbytes)
    return timing, Ratio(what, times, 0.0, difference, work, read, timing.median / 1e3)


def multiply_adds_a_second(kind: str, size: int = 1500) -> float:
    """Rate of this machine in the product of two square matrices; the best of three."""
    matrix = np.random.default_rng(0).random((size, size)).astype(kind)
    seconds = []
    for _ in range(3):
        began = time.perf_counter()
        matrix @ matrix
        seconds.append(time.perf_counter() - began)
    return size**3 / min(seconds)


def bytes_a_second(size: int = 2**28) -> float:
    """Rate at which this machine reads an array that no cache holds; the best of three."""
    array = np.ones(size // 8)
    seconds = []
    for _ in range(3):
        began = time.perf_counter()
        array.sum()
        seconds.append(time.perf_counter() - began)
    return array.nbytes / min(seconds)


def _run_json(name: str) -> dict:
    result = subprocess.run(
        [sys.executable, str(HERE / name), "--json"], capture_output=True, text=True, check=False
    )
    if not result.stdout.strip():
        raise SystemExit(f"{name}: exit code {result.returncode}\n{result.stderr}")
    return json.loads(result.stdout)


def write_page(
    timings: list[Timing], ratios: list[Ratio], memory: dict[str, int], path: Path
) -> Path:
    """The figures as Markdown."""
    held = [[name, f"{size / 2**20:.0f} MiB"] for name, size in memory.items()]
    blocks = [
        "# Speed",
        "How fast are questions answered? Measured by `python benchmarks/speed.py --database FILE` "
        "on a learned database of the CMU captures ([real-captures.md](real-captures.md)), on "
        f"{machine()}; "
        f"{versions(*PACKAGES)}. The times of adding and learning are in real-captures.md.",
        _timing_table(timings),
        "The questions were asked in an open database, after a first round; the commands are "
        "whole processes. Times are elapsed times; the processor times next to them are hardly "
        f"affected by other load on the machine ({psutil.getloadavg()[0]:.1f} on "
        f"{psutil.cpu_count()} cores at the end).",
        _ratio_table(ratios),
        table(["memory at most", ""], held),
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n\n".join(blocks) + "\n", encoding="utf-8")
    return path


def _timing_table(timings: list[Timing]) -> str:
    head = ["question", "median", "95th percentile", "processor, median", "of", "target met"]
    rows = [
        [
            t.name,
            *(_figure(value, t.unit) for value in (t.median, t.p95, t.processor)),
            str(t.n),
            _target(t),
        ]
        for t in timings
    ]
    return table(head, rows)


def _ratio_table(ratios: list[Ratio]) -> str:
    rates = {kind: multiply_adds_a_second(kind) for kind in {r.kind for r in ratios}}
    read = bytes_a_second()
    rows = [
        [
            r.name,
            f"{r.times:.0f} ×",
            f"{r.target:.0f} ×" if r.target else "",
            ("yes" if r.times >= r.target else "**no**") if r.target else "",
            r.difference,
            f"{r.work:.1e}",
            _size(r.read),
            f"{max(r.work / rates[r.kind], r.read / read) / r.seconds:.1%}",
        ]
        for r in ratios
    ]
    head = ["compared", "times faster", "target", "met", "equal up to", "multiply-adds at least"]
    return table([*head, "bytes at least", "share of the machine's limit, bytes from memory"], rows)


def _size(n_bytes: float) -> str:
    return f"{n_bytes / 1e6:.2g} MB"


def _figure(value: float, unit: str) -> str:
    return f"{value:.0f} ms" if unit == "ms" and value >= 10 else f"{value:.2g} {unit}"


def _target(timing: Timing) -> str:
    if not np.isfinite(timing.target):
        return "no target"
    which = "95th percentile" if timing.judged == "p95" else "median"
    met = "yes" if timing.met else "**no**"
    return f"{met} ({which} at most {timing.target:g} {timing.unit})"


def main() -> int:
    """Measure and write; 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--database", type=Path, required=True)
    parser.add_argument("--output", type=Path, default=Path("docs/measured"))
    parser.add_argument("--repeats", type=int, default=40)
    arguments = parser.parse_args()
    with motiondb.open(arguments.database, read_only=True) as db:
        timings = time_questions(db, arguments.repeats)
        timing, parts = compare_parts(db, arguments.repeats)
        timings.append(timing)
        memory = {"all of these questions in one process": psutil.Process().memory_info().rss}
    few = max(3, arguments.repeats // 4)
    search = motiondb_command("search", "walk, turn left", "--db", str(arguments.database))
    for name, command, target in (
        ("`motiondb search` from the shell", search, 1.5),
        ("`motiondb --help`", motiondb_command("--help"), 0.3),
    ):
        timing, peak = time_command(name, command, few, target)
        timings.append(timing)
        memory[name] = peak
    ratios = [*compare(), parts]
    path = write_page(timings, ratios, memory, arguments.output / "speed.md")
    print(path.read_text(encoding="utf-8"))
    missed = [t.name for t in timings if not t.met] + [r.name for r in ratios if r.times < r.target]
    print(f"missed: {', '.join(missed)}" if missed else "every target met")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
