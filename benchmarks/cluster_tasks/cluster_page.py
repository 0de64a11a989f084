"""The page of the cluster: what was measured, what the model is worth, and what it says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, fields
from itertools import pairwise
from pathlib import Path

from measured_run import machine, versions

from cluster_tasks.model import Row, Taken, predict, taken
from real_tasks.real_page import table

PACKAGES = ("motiondb", "numpy", "scipy", "numba", "distributed")
PREDICTED = ("add", "learn")
HOURS, WORKERS = 300.0, 16
GIGA = 1e9
FRAMES_HOUR = 3600.0 * 15 * 24 * 4  # Bytes of the feature frames of an hour


def write_page(rows: Sequence[Row], path: Path) -> None:
    """Write the page."""
    blocks = [
        "# Past one machine",
        f"What do workers gain, and what is sent? Measured by `python benchmarks/cluster.py` on "
        f"{machine()}; {versions(*PACKAGES)}. Workers are processes of one thread on the same "
        "machine; with two of them, the asking process and the scheduler share its two "
        "processors. All but the clock are processor times, which other load changes less. "
        "*Received* is all that workers read from their connections, also from one another; "
        f"*frames held* the most feature frames ({FRAMES_HOUR / 1e6:.1f} MB an hour) that one "
        "worker had at a time while it learned.",
        _measured(rows),
        _same(rows),
        "## The model",
        "T(h, w) = own(h) + work(h) / w: processor seconds of the asking process at h hours, and "
        "of all workers. Each quantity is a line through two sizes (the search for copies over "
        "the square of the hours). At the next size, lines through the two below it say:",
        *(_checks(rows, command) for command in PREDICTED),
        f"## {HOURS:g} hours on {WORKERS} workers",
        *(_said(rows, command) for command in PREDICTED),
    ]
    path.write_text("\n\n".join(block for block in blocks if block) + "\n", encoding="utf-8")


def _measured(rows: Sequence[Row]) -> str:
    head = ["command", "hours", "workers", "clock, s", "asking process, s", "workers, s"]
    head += ["scheduler, s", "tasks", "idle", "received, MB", "frames held, MB"]
    head += ["memory of a worker, MB", "of the scheduler", "of the asking process"]
    order = {"add": 0, "learn": 1, "batch": 2}
    ordered = sorted(rows, key=lambda r: (order[r["command"]], r["asked hours"], r["workers"]))
    return table(head, [_line(row) for row in ordered])


def _line(row: Row) -> list[str]:
    first = [f"`{row['command']}`", f"{row['asked hours']:g}"]
    times = [f"{row['clock, s']:.0f}", f"{row['own, s']:.0f}"]
    own = f"{row['own peak, bytes'] / 1e6:.0f}"
    if not row["workers"]:
        return [*first, "none", *times, *[""] * 8, own]
    idle = 1.0 - row["worked, s"] / (row["workers"] * row["clock, s"])
    return [
        *first,
        f"{row['workers']:.0f}",
        *times,
        f"{row['worked, s']:.0f}",
        f"{row['scheduler, s']:.0f}",
        f"{row['tasks']:.0f}",
        f"{idle:.0%}",
        f"{row['received, bytes'] / 1e6:.0f}",
        f"{row['held, bytes'] / 1e6:.1f}" if row["command"] == "learn" else "",
        f"{row['worker peak, bytes'] / 1e6:.0f}",
        f"{row['scheduler peak, bytes'] / 1e6:.0f}",
        own,
    ]


def _same(rows: Sequence[Row]) -> str:
    """Whether all numbers of workers gave the same answers."""
    given: dict[tuple[str, float], list[Row]] = {}
    for row in rows:
        if "answers" in row:
            given.setdefault((row["command"], row["asked hours"]), []).append(row)
    sentences = []
    for (command, hours), some in sorted(given.items()):
        if len(some) > 1:
            same = "the same" if len({row["answers"] for row in some}) == 1 else "NOT the same"
            numbers = ", ".join(f"{row['workers']:.0f}" if row["workers"] else "no" for row in some)
            sentences.append(f"{same} for `{command}` at {hours:g} hours with {numbers} workers")
    if not sentences:
        return ""
    return f"All derived tables, and all answers, bit for bit: {'; '.join(sentences)}."


def _of(rows: Sequence[Row], command: str) -> list[Row]:
    """The rows of a command with the most workers, by size."""
    n_workers = max(row["workers"] for row in rows)
    some = [r for r in rows if r["command"] == command and r["workers"] == n_workers]
    return sorted(some, key=lambda row: row["hours"])


def _checks(rows: Sequence[Row], command: str) -> str:
    """What lines through two sizes say of the next."""
    some, lines = _of(rows, command), list[list[str]]()
    for known, row in zip(pairwise(some), some[2:]):
        said, found = predict(known, row["hours"], row["workers"]), taken(row)
        lines.append([f"{row['hours']:.2g}", *map(_compared, astuple(said), astuple(found))])
    head = [f"`{command}` at hours", *(f.name.replace("_", " ") for f in fields(Taken))]
    return table(head, lines) if lines else ""


def _compared(said: float, found: float) -> str:
    unit, divisor = ("MB", 1e6) if found > 1e5 else ("s", 1.0)
    return f"{said / divisor:.0f} {unit} ({said / found - 1:+.0%})"


def _said(rows: Sequence[Row], command: str) -> str:
    """What the lines through the two largest sizes say of 300 hours."""
    some = _of(rows, command)
    if len(some) < 2:
        return ""
    said = predict(some[-2:], HOURS, WORKERS)
    farther = HOURS / some[-1]["hours"]
    return (
        f"`{command}`: {said.seconds(WORKERS) / 3600:.1f} hours, of which the asking process "
        f"works {said.own / 3600:.1f} alone, and each worker {said.work / WORKERS / 3600:.1f}. "
        f"All workers receive {said.received / GIGA:.0f} GB; a worker holds "
        f"{said.worker_peak / GIGA:.1f} GB at most, the asking process {said.own_peak / GIGA:.0f} "
        f"GB. That is {farther:.0f} times the largest size measured."
    )
