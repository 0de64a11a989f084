"""Commands words and events: vocabulary, captions, synonyms; foot strikes, catches, releases."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()
speaking = app.group("words", "The vocabulary, and the captions of captures.", alone=True)
marking = app.group(
    "events", "Events of captures: foot strikes, catches and releases of a ball.", alone=True
)


@speaking.callback()
def words(shared: options.Shared) -> None:
    """List the words of the database with their most probable symbols."""
    with shared.database() as base:
        rows = base.words.rows()

    def cells(row: answers.WordRow) -> list[object]:
        symbols = (f"{each.symbol}: {each.probability:.2f}" for each in row.symbols)
        return [row.word, row.count, "  ".join(symbols)]

    printing.print_rows(shared, rows, ["word", "count", "symbols t(word | symbol)"], cells)


@speaking.command("set")
def set_words(
    shared: options.Shared,
    name: options.CaptureName,
    text: Annotated[str, options.argument("Words that describe it.", "WORDS")],
    start: options.From = None,
    end: options.To = None,
    keep: Annotated[bool, "Keep the present captions."] = False,
) -> None:
    """Set the caption of a capture or of a part of it."""
    with shared.database(writing=True) as base:
        change = base.words.set(name, text, start, end, keep)
        captions = base.words.captions(name)
    said = answers.CaptionsSet(
        name, [c.words for c in captions], bool(change.counted), list(change.new_words)
    )
    if printing.as_json(shared, said):
        return
    printing.say(f"{name}: {'; '.join(said.words)}")
    if said.new_words:
        printing.say(f"  not known until the next motiondb learn: {', '.join(said.new_words)}")
    elif not said.counted:
        printing.say("  to be counted at the next motiondb learn")


@speaking.command("import")
def import_words(
    shared: options.Shared, sheet: Annotated[Path, options.argument("A sheet (TSV or CSV).")]
) -> None:
    """Replace captions and tags by those of a sheet; rows without a capture are listed (exit 1)."""
    with shared.database(writing=True) as base:
        report = base.words.import_sheet(sheet)
        drift = base.symbols.drift()
    if not printing.as_json(shared, report):
        printing.say(
            f"{printing.number(report.captures, 'capture')} with the sheet's words and tags now, "
            f"{printing.number(len(report.problems), 'row')} without a capture"
        )
        printing.print_notes(report.notes)
        printing.note_drift(drift)
    printing.refuse(report.problems)


@speaking.command("export")
def export_words(
    shared: options.Shared,
    sheet: Annotated[
        Path, options.argument("The sheet: CSV if .csv, else TSV.", callback=options.output_name)
    ],
    where: options.Where = "",
    form: Annotated[
        str, options.option("Write a sheet of BORIS or ELAN.", "--as", metavar="boris|elan")
    ] = "",
) -> None:
    """Write captions and tags as a sheet, which words import reads again without loss.

    With --as, the sheet has words and events, and no tags.
    """
    with shared.database() as base:
        report = base.words.export(sheet, where, form)
    if not printing.as_json(shared, report):
        printing.say(
            f"{printing.number(report.captions, 'caption')} of "
            f"{printing.number(report.captures, 'capture')} written to {sheet}"
        )
        printing.print_notes(report.notes)


@speaking.command("history")
def show_history(shared: options.Shared, name: options.CaptureName) -> None:
    """List the captions that a capture has had, oldest first, with the runs that set them."""
    with shared.database() as base:
        versions = base.words.history(name)

    def cells(version: answers.CaptionVersion) -> list[object]:
        said = "; ".join(map(printing.say_caption, version.words)) or "-"
        return [version.run, version.kind, version.time, said]

    printing.print_rows(shared, versions, ["run", "command", "time", "words"], cells)


@speaking.command("synonyms")
def set_synonyms(
    shared: options.Shared, file: Annotated[Path, options.argument("Lines `word = canonical`.")]
) -> None:
    """Store a file of synonyms for captions and queries."""
    with shared.database(writing=True) as base:
        table = base.words.set_synonyms(file)
    if not printing.as_json(shared, dict(table)):
        printing.say(f"{printing.number(len(table), 'synonym')} kept")


@marking.callback()
def events(shared: options.Shared) -> None:
    """List the kinds of events with their number, and the number of captures."""
    with shared.database() as base:
        rows = base.captures.event_rows()
    if printing.as_json(shared, rows):
        return
    if not rows:
        printing.say("no events; add some with motiondb events import SHEET")
        return
    table = [[row.event, row.count, row.captures] for row in rows]
    printing.print_table(["event", "count", "captures"], table)


@marking.command("show")
def show_events(shared: options.Shared, name: options.CaptureName) -> None:
    """List the events of one capture."""
    with shared.database() as base:
        rows = [motiondb.shown_event(event) for event in base.captures.events(name)]

    def cells(row: answers.ShownEvent) -> list[object]:
        return [f"{row.seconds:.3f}", row.frame, row.name, row.joint, row.other]

    printing.print_rows(shared, rows, ["seconds", "frame", "event", "joint", "other"], cells)


@marking.command("import")
def import_events(
    shared: options.Shared,
    sheet: Annotated[Path, options.argument("A sheet of events (TSV or CSV).")],
) -> None:
    """Replace the events of the captures of a sheet; rows without a capture are listed (exit 1)."""
    with shared.database(writing=True) as base:
        report = base.captures.import_events(sheet)
    if not printing.as_json(shared, report):
        printing.say(
            f"{printing.number(report.events, 'event')} of "
            f"{printing.number(report.captures, 'capture')} kept, "
            f"{printing.number(len(report.problems), 'problem')}"
        )
        printing.print_notes(report.notes)
    printing.refuse(report.problems)
