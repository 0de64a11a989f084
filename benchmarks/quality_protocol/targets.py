"""Targets and results, taken from the sections of ``quality.md`` and put at its top.

python benchmarks/quality_protocol/targets.py [docs/measured/quality.md]
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

OURS = "motiondb"
CHANCE = "random"
_SECTION = re.compile(r"<!-- task targets -->\n.*?<!-- end -->\n\n?", re.DOTALL)
BEYOND, LEVEL, NO_DIFFERENCE, MISSED = "yes, beyond the interval", "yes", "no difference", "no"


@dataclass(frozen=True)
class Table:
    """columns, and the cells of every row, as they are written."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def row(self, *first: str) -> tuple[str, ...]:
        """The row that begins with these cells."""
        return next(row for row in self.rows if row[: len(first)] == first)

    def cell(self, column: str, *first: str) -> str:
        """The cell of a column in the row that begins with these cells."""
        return self.row(*first)[self.columns.index(column)]


def tables(text: str) -> dict[str, Table]:
    """Heading -> the first table below it.

    >>> tables("## A\\n\\n| m | x |\\n| --- | --- |\\n| a | .5 |\\n")["A"].cell("x", "a")
    '.5'
    """
    rows_of: dict[str, list[tuple[str, ...]]] = {}
    heading, ended = "", False
    for line in text.splitlines():
        if line.startswith("#"):
            heading, ended = line.lstrip("# "), False
        elif line.startswith("| ") and not ended:
            rows_of.setdefault(heading, []).append(tuple(c.strip() for c in line.split("|")[1:-1]))
        elif heading in rows_of:
            ended = True
    return {name: Table(rows[0], tuple(rows[2:])) for name, rows in rows_of.items()}


def number(cell: str) -> float:
    """The first number of a cell.

    >>> number(".488 (.445 to .533)"), number("1.000"), number("x")
    (0.488, 1.0, nan)
    """
    matched = re.match(r"-?\d*\.?\d+", cell)
    return float(matched[0]) if matched else float("nan")


def beaten(table: Table, measure: str) -> tuple[str, str]:
    """motiondb compared with the best other method: better, worse or no difference."""
    at = table.columns.index(measure)
    others = [r for r in table.rows if not r[0].startswith(OURS) and r[0] != CHANCE]
    best = max(others, key=lambda row: number(row[at]))
    ours, ahead = table.row(OURS)[at], best[at + 1]
    low, high = (float(x) for x in re.findall(r"-?\d*\.\d+", ahead)[1:])
    level = number(ours) >= number(best[at])
    met = BEYOND if low > 0 else LEVEL if level else NO_DIFFERENCE if high >= 0 else MISSED
    return f"{ours}; {best[0]} {best[at]}, motiondb better by {ahead}", met


def reached(cell: str, least: float) -> tuple[str, str]:
    """A figure and whether it is large enough."""
    return cell, LEVEL if number(cell) >= least else MISSED


def targets(tables_of: dict[str, Table]) -> Iterator[tuple[str, str, str, str]]:
    """Target, figure, met or not, heading."""
    for name, measure in (
        ("Words to motion", "mean average precision"),
        ("Motion to words", "reciprocal rank"),
        ("Motion to words", "F1"),
        ("Query by example: CMU main verb, unseen performer", "1-NN accuracy"),
        ("Query by example: CMU main verb, unseen performer", "mAP"),
        ("Query by example: Bandai-Namco, unseen style", "1-NN accuracy"),
        ("Query by example: Bandai-Namco, unseen style", "mAP"),
    ):
        yield (
            f"at least the best other method, {measure}", *beaten(tables_of[name], measure), name,
        )  # fmt: skip
    yield from _times(tables_of)
    name = "Interval in a long take"
    for column, least in (
        ("R@1, IoU 0.5", 0.92), ("R@1, IoU 0.7", 0.75),
        ("per query and take, IoU 0.5", 0.85), ("per query and take, IoU 0.7", 0.68),
    ):  # fmt: skip
        cell = tables_of[name].cell(column, "motiondb (like)")
        yield f"by example, {column}: at least {least}", *reached(cell, least), name
    for row, least in (
        ("words of whole captures", 0.52), ("words of the parts of the other takes", 0.6),
    ):  # fmt: skip
        cell = tables_of["By word"].cell("R@1, IoU 0.5", row)
        yield f"by word, {row}, R@1, IoU 0.5: at least {least}", *reached(cell, least), "By word"
    yield from _places(tables_of)
    name = "Segmentation without labels"
    for row, column, least in (
        ("true number", "frame accuracy", 0.88), ("own number", "frame accuracy", 0.82),
        ("own number", "boundary F1", 0.75), ("true number", "boundary F1", 0.75),
    ):  # fmt: skip
        cell = tables_of[name].cell(column, f"motiondb, {row}")
        yield f"{column}, {row}: at least {least}", *reached(cell, least), name
    for cells in tables_of["Order"].rows:
        yield f"order, {cells[0]}: at least 0.9", *reached(cells[2], 0.9), "Order"
    name = "Analogy: word sequences never seen"
    for cells in tables_of[name].rows[1::2]:
        asked = f"{cells[0]} words: at least twice as many usable as by the plain bigram"
        yield asked, *reached(cells[4], 2.0), name
    yield from _generation(tables_of["Generation"])


def _places(tables_of: dict[str, Table]) -> Iterator[tuple[str, str, str, str]]:
    """Places by captions of whole takes, with one label, and boundaries."""
    column, row = "R@1, IoU 0.5", "the same, words that the take's own captions say"
    cell = tables_of["By word"].cell(column, row)
    yield f"by word, {row}, {column}: at least 0.7", *reached(cell, 0.7), "By word"
    name = "By word, with one part labelled"
    if name in tables_of:
        cell = tables_of[name].cell(column, "one part labelled")
        asked = f"by word, one part labelled, {column}: at least 0.7"
        yield asked, *reached(cell, 0.7), name
    name = "Boundaries of short actions"
    for cells in tables_of[name].rows if name in tables_of else ():
        if cells[0] in ("real captures", "sample data (synthetic)"):
            met = LEVEL if number(cells[2]) <= 0.3 else MISSED
            yield f"boundaries, {cells[0]}: within 0.3 s in the median", cells[2], met, name


def _times(tables_of: dict[str, Table]) -> Iterator[tuple[str, str, str, str]]:
    column = "ms a query, searching"
    for name in (
        "Query by example: CMU main verb, unseen performer",
        "Query by example: Bandai-Namco, unseen style",
    ):
        table = tables_of[name]
        ours, warping = table.cell(column, OURS), table.cell(column, "DTW, whitened features")
        share = number(ours) / number(warping)
        met = LEVEL if share <= 0.01 else MISSED
        yield (
            "at most a hundredth of time warping's time, ms a query",
            f"{ours} against {warping} ({100 * share:.1f} %)", met, name,
        )  # fmt: skip


def _generation(table: Table) -> Iterator[tuple[str, str, str, str]]:
    name, real = "Generation", table.rows[-1][0]
    cell = table.cell("recognised by motiondb", "stitched")
    yield "recognised by motiondb: at least 0.95", *reached(cell, 0.95), name
    for judge in ("by logistic regression", "by DTW 1-NN"):
        made, natural = table.cell(judge, "stitched"), table.cell(judge, real)
        met = LEVEL if number(made) >= number(natural) else MISSED
        yield (
            f"recognised {judge}: as often as real captures of unseen performers",
            f"{made} against {natural}", met, name,
        )  # fmt: skip
    for column, unit in (("foot slip, cm/s", "foot slip"), ("jerk, m/s³", "jerk")):
        yield (
            f"{unit} within the real captures' 95th percentile (sentences, with the other measure)",
            f"median {table.cell(column, 'stitched')}; {table.cell('within 95 %', 'stitched')} of "
            "the sentences",
            LEVEL if number(table.cell("within 95 %", "stitched")) >= 0.95 else MISSED, name,
        )  # fmt: skip
    cell = table.cell("bone change, mm", "stitched")
    yield "bone lengths constant", cell, LEVEL if number(cell) == 0.0 else MISSED, name


def section(text: str) -> str:
    """The table of targets of a page."""
    lines = [
        "## Targets",
        "",
        "Taken from the sections below by `benchmarks/quality_protocol/targets.py`. "
        "*No difference*: motiondb is below, but the paired interval contains 0.",
        "",
        "| target | reached | met | section |",
        "| --- | --- | --- | --- |",
    ]
    lines += [f"| {' | '.join(row)} |" for row in targets(tables(_SECTION.sub("", text)))]
    return "<!-- task targets -->\n" + "\n".join(lines) + "\n<!-- end -->\n\n"


def write_targets(path: Path) -> None:
    """Put the table before the first section, in place of the one before."""
    text = _SECTION.sub("", path.read_text(encoding="utf-8"))
    place = text.index("<!-- task ")
    path.write_text(text[:place] + section(text) + text[place:], encoding="utf-8")


if __name__ == "__main__":
    write_targets(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/measured/quality.md"))
