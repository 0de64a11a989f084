"""The page of the growth: a table by hours, exponents, and a picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import psutil
from matplotlib.figure import Figure
from measured_run import machine, versions

from real_tasks.real_page import table

Row = dict[str, float]
N_COLOURS = 10  # Colours of lines, after which they begin anew
PACKAGES = ("motiondb", "numpy", "scipy", "numba", "duckdb")
TIMES = (
    # name in rows, name on the page, target at 40 hours (s)
    ("add, s", "`add`", 1500.0),
    ("learn, s", "`learn`", 3600.0),
    ("first search, s", "`motiondb search` from the shell, the first after learning", None),
    ("first question, s", "opening and the first word question", None),
    ("word question, s", "word question, median", 0.05),
    ("example of 3 s, s", "example of 3 s, median", 0.2),
    ("two actions generated, s", "generating two actions", 2.0),
    ("motiondb search, s", "`motiondb search` from the shell", 1.5),
    ("adding 10 more, s", "adding 10 captures", None),
    ("10 more searched, s", "the same, and the first search after it", 10.0),
    ("info, s", "`info`", 0.5),
    ("list, s", "`list`", 0.5),
    ("check, s", "`check --quick`", 0.5),
)
SIZES = (
    # name in rows, name on the page, target at 40 hours (bytes)
    ("add, peak bytes", "memory of `add`", 3 * 2**30),
    ("learn, peak bytes", "memory of `learn`", 4 * 2**30),
    ("word questions, peak bytes", "memory of a process that asks in words", None),
    ("peak bytes", "the same, with examples and generation", None),
    ("motiondb search, peak bytes", "memory of `motiondb search`", None),
    ("file bytes", "file", None),
    ("originals bytes", "of it, kept originals", None),
    ("cache bytes", "cache beside it", None),
)


BESIDE = ("beside bytes", "file and cache beside the originals, an hour", None)


def with_beside(row: Row) -> Row:
    """A row with what file and cache take beside the originals, bytes an hour, where measured."""
    if "file bytes" not in row:
        return row
    taken = row["file bytes"] + row["cache bytes"] - row["originals bytes"]
    return row | {BESIDE[0]: taken / row["hours"]}


def exponent(hours: Sequence[float], values: Sequence[float]) -> float:
    """Slope of the logarithm of values over that of hours, by least squares."""
    pairs = [(h, v) for h, v in zip(hours, values) if h > 0 and v > 0]
    if len(pairs) < 2:
        return float("nan")
    x, y = np.log(np.array(pairs)).T
    return float(np.polyfit(x, y, 1)[0])


def write_page(rows: Sequence[Row], captures: Path, path: Path) -> None:
    """Write the page and its picture."""
    hours = [row.get("hours", row["asked hours"]) for row in rows]
    picture = path.parent / "pictures" / "scale.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    draw(rows, hours, picture)
    last = max(hours)
    head = [
        "",
        *(f"{h:.2g} hours" if h != 1 else "1 hour" for h in map(_rounded, hours)),
        "exponent",
        "target at 40 hours",
    ]
    blocks = [
        "# Growth with the hours of motion",
        f"How do time, memory and size grow? Measured by `python benchmarks/growth.py` on "
        f"{machine()}; {versions(*PACKAGES)}. The input is warped variants of "
        f"{'the sample data' if 'sample_data' in captures.parts else 'the captures given'}: "
        "other tempo, posture and size, "
        "some mirrored, none a copy of another; as BVH, "
        f"{_per_hour(rows, hours)} an hour. Times are processor times of whole processes with "
        "their children, or within one open database (questions). Exponent: the slope of log "
        f"value over log hours; the largest size here is {last:.2g} hours.",
        table(head, [_line(rows, hours, entry, _seconds) for entry in TIMES]),
        table(head, [_line(rows, hours, entry, _bytes) for entry in SIZES]),
        _beside(rows, hours),
        f"{_missing(rows)}Other load on a machine whose threads share cores changes processor "
        f"times too (load at the end {psutil.getloadavg()[0]:.1f} on {psutil.cpu_count()} cores).",
        f"![Growth of times and sizes](pictures/{picture.name})",
    ]
    path.write_text("\n\n".join(blocks) + "\n", encoding="utf-8")


TWO = "## Two builds, side by side"  # The section that :func:`write_beside` writes


def write_beside(
    rows: Sequence[Row], former: Sequence[Row], builds: tuple[str, str], path: Path
) -> None:
    """Write the last section of the page: what two builds took, where both were measured.

    `builds`: The commits of the former one and of this one.
    """
    both = [
        (row, old) for row in rows for old in former if row["asked hours"] == old["asked hours"]
    ]
    lines = []
    for key, name, _ in (*TIMES, *SIZES, BESIDE):
        shown = _bytes if "bytes" in key else _seconds
        pairs = [(row.get(key), old.get(key)) for row, old in both]
        cells = [
            f"{shown(old)} → {shown(new)} ({new / old:.2f})" if new and old else ""
            for new, old in pairs
        ]
        if any(cells):
            lines.append([name, *cells])
    blocks = [
        path.read_text(encoding="utf-8").partition(TWO)[0].rstrip(),
        TWO,
        f"The same variants of CMU captures, by the builds {builds[0]} and {builds[1]} at the same "
        f"time, on {machine()}, which other work kept busy: ratios in brackets.",
        table(["", *(f"{row['asked hours']:g} h" for row, _ in both)], lines),
    ]
    path.write_text("\n\n".join(blocks) + "\n", encoding="utf-8")


def draw(rows: Sequence[Row], hours: Sequence[float], path: Path) -> None:
    """Times and sizes over hours, both axes logarithmic."""
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    for place, (entries, unit, title) in enumerate(
        ((TIMES, 1.0, "processor seconds"), (SIZES, 2.0**20, "MiB")), start=1
    ):
        axes = figure.add_subplot(1, 2, place)
        for number, (key, name, _) in enumerate(entries):
            pairs = [(h, r[key] / unit) for h, r in zip(hours, rows) if r.get(key)]
            if pairs:
                style = "-" if number < N_COLOURS else "--"
                axes.plot(*zip(*pairs), style, marker="o", label=name.replace("`", ""))
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("hours of motion")
        axes.set_title(title)
        axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
    figure.savefig(path, dpi=110)


def _line(
    rows: Sequence[Row],
    hours: Sequence[float],
    entry: tuple[str, str, float | None],
    shown: Callable[[float], str],
) -> list[str]:
    key, name, target = entry
    values = [row.get(key) for row in rows]
    slope = exponent(hours, [value or 0.0 for value in values])
    return [
        name,
        *("" if value is None else shown(value) for value in values),
        "" if np.isnan(slope) else f"{slope:.2f}",
        "" if target is None else shown(target),
    ]


def _rounded(hours: float) -> float:
    return float(f"{hours:.2g}")


def _seconds(value: float) -> str:
    if value < 1.0:
        return f"{1000.0 * value:.0f} ms"
    return f"{value:.1f} s" if value < 10 else f"{value:.0f} s"


def _bytes(value: float) -> str:
    return f"{value / 2**30:.2f} GiB" if value >= 2**30 else f"{value / 2**20:.0f} MiB"


def _per_hour(rows: Sequence[Row], hours: Sequence[float]) -> str:
    return f"{rows[-1]['text bytes'] / hours[-1] / 1e6:.0f} MB"


def _missing(rows: Sequence[Row]) -> str:
    """That some figures are missing, where they are."""
    wanted = [key for key, _, _ in (*TIMES, *SIZES)]
    whole = all(key in row for row in rows for key in wanted)
    return "" if whole else "What is missing was not measured: the command was interrupted. "


def _beside(rows: Sequence[Row], hours: Sequence[float]) -> str:
    """What file and cache take beside the originals, for the largest size that was learned."""
    sized = [(row, h) for row, h in zip(rows, hours) if "file bytes" in row]
    if not sized:
        return ""
    row, length = sized[-1]
    taken = row["file bytes"] + row["cache bytes"] - row["originals bytes"]
    return (
        f"Beside the originals, file and cache take {taken / length / 1e6:.0f} MB an hour at "
        f"{length:.2g} hours (target: at most 60 MB)."
    )
