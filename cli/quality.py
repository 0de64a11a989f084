"""Command quality: what captures lack; and the gait that ``describe --gait`` prints."""

from __future__ import annotations

from dataclasses import astuple, fields
from pathlib import Path
from typing import Annotated

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()


def _boxes_name(path: Path | None) -> Path | None:
    """Check the name of a file of boxes."""
    options.check_ending(path, (".json", ".xml"))
    return options.output_name(path)


@app.command()
def quality(
    shared: options.Shared,
    where: Annotated[
        str, options.argument("The captures, as for --where, or a name.", "[FILTER]")
    ] = "",
    again: Annotated[bool, "Measure anew what was measured before."] = False,
    boxes: Annotated[
        Path | None,
        options.option(
            "Write what the captures need as boxes into this file (.json; .xml of one).",
            callback=_boxes_name,
        ),
    ] = None,
    png: Annotated[
        Path | None, options.picture("Draw one capture with what it needs into this file (.png).")
    ] = None,
) -> None:
    """Say what captures lack: things they need, faults, wrong units and rates.

    Captures are measured once, and the findings are kept. Then filters know `quality`, `finding`
    and `needs`: --where "quality > .8 and not needs".
    """
    with shared.database(writing=True) as base:
        with printing.progress(shared) as tell:
            answer = base.captures.quality(where, again, tell)
        if png:
            if len(answer.captures) != 1:
                raise motiondb.QueryError(
                    f"{png}: expected one capture to draw, found {len(answer.captures)}. Name one."
                )
            base.captures.draw_quality(answer.captures[0].capture, png)
        if boxes:
            base.captures.write_boxes([each.capture for each in answer.captures], boxes)
    if not printing.as_json(shared, answer):
        _print(answer)
        printing.say_pictures(png)
        printing.say(*([f"boxes: {boxes}"] if boxes else []))
    printing.refuse(answer.problems)


def _print(answer: answers.QualityAnswer) -> None:
    """Print a line a finding; what cannot be told of one capture, or of how many."""
    for each in answer.captures:
        for finding in each.findings:
            printing.say(f"{each.capture}: {finding.sentence}")
    if len(answer.captures) == 1:
        printing.say(
            *(f"{answer.captures[0].capture}: {said}" for said in answer.captures[0].untold)
        )
    else:
        printing.say(*(rate.sentence for rate in answer.performers))
    lacking = sum(bool(each.findings) for each in answer.captures)
    needing = sum(any(f.family == "needs" for f in each.findings) for each in answer.captures)
    silent = sum("cannot say anything" in " ".join(each.untold) for each in answer.captures)
    printing.say(
        f"{printing.number(len(answer.captures), 'capture')}, {answer.measured} measured now; "
        f"{lacking} with findings, {needing} of them need something that was not captured"
        + (f"; of {silent} nothing can be said" * bool(silent))
        + (f"; {answer.without_body} more are markers without a body" * bool(answer.without_body))
    )


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
