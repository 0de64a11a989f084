"""Commands quality, curate, coverage and diff; and the gait that ``describe --gait`` prints.

What captures lack, what to train on, what a library lacks, and what another one has.
"""

from __future__ import annotations

from dataclasses import astuple, fields
from pathlib import Path
from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()
Filter = Annotated[str, options.argument("The captures, as for --where.", "[FILTER]")]
_N_SHOWN = 20  # Rows that are printed of a long table


def a_share(text: str) -> float:
    """A share that was typed: 3%, or 0.03."""
    try:
        number = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        number = -1.0
    if not 0.0 < number <= 1.0:
        raise typer.BadParameter(f"expected a share such as 3% or 0.03, found {text!r}.")
    return number


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
        _print_quality(answer)
        printing.say_pictures(png)
        printing.say(*([f"boxes: {boxes}"] if boxes else []))
    printing.refuse(answer.problems)


def _print_quality(answer: answers.QualityAnswer) -> None:
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


@app.command()
def curate(
    shared: options.Shared,
    changes: options.Changes,
    where: Filter = "",
    share: Annotated[
        float | None, options.option("Such as 3% or 0.03.", parser=a_share, metavar="SHARE")
    ] = None,
    hours: Annotated[
        float | None, options.option("Hours, in place of --share.", min=0.0, max=1e5)
    ] = None,
    output: Annotated[
        Path | None,
        options.option("New folder.", "-o", "--output", parser=options.a_path, metavar="FOLDER"),
    ] = None,
    ending: Annotated[
        str, options.option("Format of the files: npz, csv, bvh, or as export writes.", "--as")
    ] = "npz",
    dry_run: Annotated[bool, "Print the choice, and write nothing."] = False,
    quality: Annotated[
        float, options.option("Smallest number of a second.", min=0.0, max=1.0)
    ] = 0.8,
    with_needs: Annotated[bool, "Also motion that needs what was not captured."] = False,
    shortest: Annotated[float, options.option("Seconds of an interval.", min=1.0, max=300.0)] = 2.0,
    longest: Annotated[float, options.option("Seconds of an interval.", min=2.0, max=600.0)] = 10.0,
    balance: Annotated[str, "words or symbols: each counts the same."] = "",
    split: Annotated[str, "performer: others to test with than to train on."] = "",
    test_share: Annotated[float, options.option("Of the seconds, about.", min=0.0, max=1.0)] = 0.2,
    seed: options.Seed = 0,
) -> None:
    """Choose the part of a library that is worth training on, and write it with a manifest.

    Left out are copies, faults and what needs things that were not captured (`quality`); intervals
    are chosen that cover the rest. Every dropped second has its reason.
    """
    if output is None and not dry_run:
        raise motiondb.QueryError(
            "curate: expected a folder for the choice, found none. Give -o FOLDER, or --dry-run."
        )
    asked = motiondb.CurateSettings(
        share,
        hours,
        quality,
        with_needs,
        shortest,
        longest,
        balance,
        split,
        test_share,
        seed,
        ending.removeprefix("."),
        changes.read(),
    )
    with shared.database(writing=True) as base, printing.progress(shared) as tell:
        answer = base.curate(asked, where, None if dry_run else output, tell)
    if not printing.as_json(shared, answer):
        _print_choice(answer)


def _print_choice(answer: answers.CurateAnswer) -> None:
    columns = ("interval", "capture", "start", "end", "split", "weight", "licence", "reason")
    rows = [
        (
            *(e.interval, e.capture, f"{e.start:.2f}", f"{e.end:.2f}", e.split, e.weight),
            *(e.licence, e.reason),
        )
        for e in answer.intervals[:_N_SHOWN]
    ]
    printing.print_table(columns, rows)
    if len(answer.intervals) > _N_SHOWN:
        printing.say(f"... {len(answer.intervals) - _N_SHOWN} more: --json, or the manifest")
    for kind, seconds in answer.reasons.items():
        printing.say(f"not chosen, {kind}: {seconds:.1f} s")
    for each in answer.splits:
        printing.say(
            f"{each.split}: {printing.number(each.intervals, 'interval')}, {each.chosen:.1f} s of "
            f"{each.seconds:.1f} s that may be chosen, {len(each.performers)} performers; mean "
            f"distance to the choice {each.distance:.3f}, no {each.chosen:.0f} s can be under "
            f"{each.bound:.3f}"
        )
    printing.print_notes(answer.notes)
    if answer.folder is not None:
        printing.say(f"written: {answer.folder}, with manifest.csv and manifest.json")


@app.command()
def coverage(
    shared: options.Shared,
    where: Filter = "",
    words: Annotated[Path | None, "A file with a question in words a line."] = None,
    png: Annotated[
        Path | None, options.picture("Draw the tables of going into this file (.png).")
    ] = None,
) -> None:
    """Say what a library holds and lacks, and what to record next.

    Kinds of going by turns, starts, stops and changes by the foot ahead, symbols by their contexts,
    and words of a list. Beside what is not there stand the moments that are most like it.
    """
    with shared.database() as base, printing.progress(shared) as tell:
        answer = base.coverage(where, words or (), png, tell)
    if printing.as_json(shared, answer):
        return
    for table in ("going", "changes", "words"):
        _print_cells([cell for cell in answer.cells if cell.table == table])
    printing.say("s: seconds; x: times; 6p: of 6 performers", "")
    symbols = [c for c in answer.cells if c.table == "symbols"]
    if symbols:
        alone = [c for c in symbols if c.column == "all"]
        printing.say(
            f"{len(alone)} symbols in {len(symbols) - len(alone)} contexts (--json lists them); "
            f"{sum(c.performers == 1 for c in alone)} of one performer"
        )
    lacking = [cell for cell in answer.cells if cell.shot]
    n = _N_SHOWN + sum(cell.table != "symbols" for cell in lacking)
    for cell in lacking[:n]:
        printing.say(cell.shot)
        printing.say(*(f"    nearest: {_moment(each)}" for each in cell.nearest))
    if len(lacking) > n:
        printing.say(f"... {len(lacking) - n} more: --json")
    printing.say(
        f"{printing.number(answer.captures, 'capture')}, {answer.seconds:.1f} s, of which "
        f"{answer.not_upright:.1f} s are not upright; {len(answer.shots)} things to record"
    )
    printing.print_notes(answer.notes)
    printing.say_pictures(png)


def _print_cells(cells: list[answers.Cell]) -> None:
    """A table with a row a kind; seconds or times, and performers."""
    rows: dict[str, list[str]] = {}
    for each in cells:
        amount = f"{each.amount:.1f} s" if each.unit == "s" else f"{each.amount:.0f} x"
        said = f"{amount}, {each.performers}p" if each.amount else "none"
        rows.setdefault(each.row, [each.row]).append(said)
    if rows:
        columns = list(dict.fromkeys(each.column for each in cells))
        printing.print_table([cells[0].table, *columns], rows.values())
        printing.say("")


def _moment(each: answers.Moment) -> str:
    return f"{each.capture} {each.start:.1f} to {each.end:.1f} s, {each.what}"


@app.command()
def diff(
    shared: options.Shared,
    other: Annotated[Path, options.argument("Another database.", "OTHER")],
    where: options.Where = "",
) -> None:
    """Say which captures another database has too: copied, cut, mirrored or resampled.

    Licences of both stand beside. The other database is only read.
    """
    with shared.database() as base, printing.progress(shared) as tell:
        answer = base.diff(other, where, shared.wait, tell)
    if printing.as_json(shared, answer):
        return
    columns = ("capture", "other", "what", "start", "end", "licence", "other licence")
    rows = []
    for each in answer.shared:
        rates = f", {each.fps:g} to {each.other_fps:g} fps" if each.resampled else ""
        what = each.kind + rates, f"{each.start:.2f}", f"{each.end:.2f}"
        rows.append((each.capture, each.other, *what, each.licence, each.other_licence))
    if rows:
        printing.print_table(columns, rows)
    printing.say(
        f"{answer.captures - answer.only_here} of {printing.number(answer.captures, 'capture')} "
        f"are in {answer.other}, {answer.only_here} are not; "
        f"{answer.only_there} of its {answer.other_captures} are not here"
    )
    printing.print_notes(answer.notes)


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
