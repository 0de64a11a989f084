"""What ``describe --gait`` prints."""

from __future__ import annotations

from dataclasses import astuple, fields
from pathlib import Path

import motiondb
from motiondb.cli import options, printing


def describe_gait(
    shared: options.Shared,
    example: str | None,
    where: str,
    start: float | None,
    end: float | None,
    up: str,
    output: Path | None,
    png: Path | None,
    as_csv: Path | None,
) -> None:
    """Print how somebody walks or runs."""
    if example is None or where.strip() or output:
        raise motiondb.QueryError(
            "describe: expected one capture or file with --gait, and --csv for its cycles, found "
            f"{'none' if example is None else '--where' if where.strip() else '-o'}."
        )
    read = motiondb.read_capture(example, up=motiondb.check_up(up, "--up")) if up else example
    with shared.database() as base:
        told = base.captures.gait(read, start, end, png)
    if as_csv:
        columns = [field.name for field in fields(motiondb.GaitCycle)]
        every = [[_exact(value) for value in astuple(cycle)] for cycle in told.cycles]
        printing.write_rows(columns, every, as_csv, "cycle")
        return
    if printing.as_json(shared, told):
        return
    printing.say(
        f"{printing.number(len(told.events), 'foot event')}, "
        f"{printing.number(len(told.cycles), 'cycle')} in {told.seconds:.2f} s"
    )
    printing.print_notes(told.notes)
    rows = [
        [m.measure, m.unit, *map(_three_digits, (m.left, m.right, m.both, m.deviation)), _uneven(m)]
        for m in told.measures
    ]
    if rows:
        columns = ["measure", "unit", "left", "right", "both", "deviation", "asymmetry"]
        printing.print_table(columns, rows)


def _exact(value: float | str | None) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:.4f}"


def _three_digits(value: float | None) -> str:
    return printing.NOT_MEASURED if value is None else f"{value:.3g}"


def _uneven(measure: motiondb.GaitMeasure) -> str:
    return printing.NOT_MEASURED if measure.asymmetry is None else f"{measure.asymmetry:+.1f} %"
