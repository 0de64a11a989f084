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


def write_page(rows: Sequence[Row], growth: Sequence[Row], path: Path) -> None:
    """Write the page; `growth`: rows of ``benchmarks/growth.py``, of one machine."""
    blocks = [
        "# Past one machine",
        f"What do workers gain, and what is sent? Measured by `python benchmarks/cluster.py` on "
        f"{machine()}; {versions(*PACKAGES)}. Workers are processes of one thread on the same "
        "machine; with two of them, the asking process and the scheduler share its two "
        "processors. All but the clock are processor times, which other load changes less. "
        "*Received* is all that workers read from their connections, also from one another; "
        f"*frames held* the most feature frames ({FRAMES_HOUR / 1e6:.1f} MB an hour) that one "
        "worker had at a time while it learned. Workers of `batch` open the database "
        "themselves.",
        _measured(rows),
        _same(rows),
        "## The model",
        "T(h, w) = own(h) + work(h) / w: processor seconds of the asking process and the "
        "scheduler at h hours, and of all workers. T is no duration: what processes wait for, one "
        "another or the network, is not in it. The last column above says how many times T the "
        "clock showed. Each quantity is a line through two sizes (the search for copies over "
        "the square of the hours). At the next size, lines through the two below it say:",
        *(_checks(rows, command) for command in PREDICTED),
        _beyond(rows, growth),
        f"## {HOURS:g} hours on {WORKERS} workers",
        *(_said(rows, growth, command) for command in PREDICTED),
    ]
    path.write_text("\n\n".join(block for block in blocks if block) + "\n", encoding="utf-8")


def _measured(rows: Sequence[Row]) -> str:
    head = ["command", "hours", "workers", "clock, s", "asking process, s", "workers, s"]
    head += ["scheduler, s", "tasks", "idle", "received, MB", "frames held, MB"]
    head += ["memory of a worker, MB", "of the scheduler", "of the asking process", "clock / T"]
    order = ("add", "learn", "batch")
    ordered = sorted(
        rows, key=lambda r: (order.index(r["command"]), r["asked hours"], r["workers"])
    )
    return table(head, [_line(row) for row in ordered])


def _line(row: Row) -> list[str]:
    first = [f"`{row['command']}`", f"{row['asked hours']:g}"]
    times = [f"{row['clock, s']:.0f}", f"{row['own, s']:.0f}"]
    own = f"{row['own peak, bytes'] / 1e6:.0f}"
    if not row["workers"]:
        return [*first, "none", *times, *[""] * 8, own, ""]
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
        f"{_clock(row):.1f}",
    ]


def _clock(row: Row) -> float:
    """How many times T the clock showed."""
    return row["clock, s"] / taken(row).seconds(row["workers"])


def _same(rows: Sequence[Row]) -> str:
    """Whether all numbers of workers gave the same answers."""
    given: dict[tuple[str, float], list[Row]] = {}
    for row in rows:
        if "answers" in row:
            given.setdefault((row["command"], row["asked hours"]), []).append(row)
    several = {what: some for what, some in given.items() if len(some) > 1}
    wrong = [
        f"NOT those of `{command}` at {hours:g} hours"
        for (command, hours), some in several.items()
        if len({row["answers"] for row in some}) > 1
    ]
    if not several:
        return ""
    compared = ", ".join(f"`{command}` at {hours:g} hours" for command, hours in several)
    return (
        "The derived tables of the databases that workers made, and all answers, are those of one "
        f"machine without workers, bit for bit{''.join(f', but {each}' for each in wrong)} "
        f"(compared: {compared})."
    )


def _of(rows: Sequence[Row], command: str) -> list[Row]:
    """The rows of a command with the most workers, by size."""
    n_workers = max(row["workers"] for row in rows)
    some = [r for r in rows if r["command"] == command and r["workers"] == n_workers]
    return sorted(some, key=lambda row: row["hours"])


def _checked(rows: Sequence[Row], command: str) -> list[tuple[Taken, Row]]:
    """What lines through two sizes say of the next, and what was measured there."""
    some = _of(rows, command)
    pairs = zip(pairwise(some), some[2:])
    return [(predict(known, row["hours"], row["workers"]), row) for known, row in pairs]


def _farther(
    rows: Sequence[Row], growth: Sequence[Row], command: str
) -> list[tuple[float, float, float]]:
    """Larger sizes on one machine: hours, own + work by the lines, and what was measured, s."""
    known = _of(rows, command)[-2:]
    if len(known) < 2:
        return []
    return [
        (
            row["hours"],
            predict(known, row["hours"], known[-1]["workers"]).seconds(1),
            row[f"{command}, s"],
        )
        for row in growth
        if row["hours"] > 1.5 * known[-1]["hours"]
    ]


def _checks(rows: Sequence[Row], command: str) -> str:
    lines = [
        [f"{row['hours']:.2g}", *map(_compared, astuple(said), astuple(taken(row)))]
        for said, row in _checked(rows, command)
    ]
    head = [f"`{command}` at hours", *(f.name.replace("_", " ") for f in fields(Taken))]
    return table(head, lines) if lines else ""


def _beyond(rows: Sequence[Row], growth: Sequence[Row]) -> str:
    lines = [
        [f"`{command}`", f"{hours:.0f}", _compared(said, found), f"{found:.0f} s"]
        for command in PREDICTED
        for hours, said, found in _farther(rows, growth, command)
    ]
    if not lines:
        return ""
    head = ["command", "hours", "own + work, by the lines", "measured on one machine"]
    return (
        "Farther away, the sum of own and work is compared with the processor seconds of one "
        "machine without a cluster, and so without a scheduler ([measured](scale.md)).\n\n"
        f"{table(head, lines)}"
    )


def _compared(said: float, found: float) -> str:
    unit, divisor = ("MB", 1e6) if found > 1e5 else ("s", 1.0)
    return f"{said / divisor:.0f} {unit} ({said / found - 1:+.0%})"


def _said(rows: Sequence[Row], growth: Sequence[Row], command: str) -> str:
    """What the lines through the two largest sizes say of 300 hours, and how they erred so far."""
    some = _of(rows, command)
    if len(some) < 2:
        return ""
    said = predict(some[-2:], HOURS, WORKERS)
    errors = [
        each.seconds(row["workers"]) / taken(row).seconds(row["workers"]) - 1
        for each, row in _checked(rows, command)
    ]
    errors += [one / found - 1 for _, one, found in _farther(rows, growth, command)]
    erred = ""
    if errors:
        span = f"{min(errors):+.0%} to {max(errors):+.0%}"
        erred = f" T erred by {span} of measured processor seconds."
    clocks = [_clock(row) for row in rows if row["command"] == command and row["workers"]]
    return (
        f"`{command}`: T = {said.seconds(WORKERS):,.0f} s, processor seconds on the longest path, "
        f"not a duration: {said.own:,.0f} s of the asking process and the scheduler, and "
        f"{said.work / WORKERS:,.0f} s of each worker. In the runs above, the clock showed "
        f"{min(clocks):.1f} to {max(clocks):.1f} times T. "
        f"All workers receive {said.received / GIGA:.0f} GB; a worker holds "
        f"{said.worker_peak / GIGA:.1f} GB at most, the asking process {said.own_peak / GIGA:.0f} "
        f"GB. That is {HOURS / some[-1]['hours']:.0f} times the largest size measured."
        f"{erred}"
    )
