"""Commands words and events: vocabulary, captions, synonyms; foot strikes, catches, releases."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from motiondb.cli.options import DEFAULT_DB, Commands, Db, From, Json, To, database
from motiondb.cli.printing import note_drift, print_json, print_notes, print_table, refuse


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    group = Commands(
        help="The vocabulary, and the captions of captures.", invoke_without_command=True
    )
    group.callback()(words)
    group.command("set")(set_words)
    group.command("import")(import_words)
    group.command("synonyms")(set_synonyms)
    app.add_typer(group, name="words")
    marks = Commands(
        help="Events of captures: foot strikes, catches and releases of a ball.",
        invoke_without_command=True,
    )
    marks.callback()(events)
    marks.command("show")(show_events)
    marks.command("import")(import_events)
    app.add_typer(marks, name="events")


def words(context: typer.Context, db: Db = DEFAULT_DB, json: Json = False) -> None:
    """List the words of the database with their most probable symbols."""
    if context.invoked_subcommand is not None:
        return
    with database(db) as base:
        rows = base.word_rows()
    if json:
        print_json(rows)
        return
    table = [
        [
            r.word,
            str(r.count),
            "  ".join(f"{s.symbol}: {s.probability:.2f}" for s in r.symbols),
        ]
        for r in rows
    ]
    print_table("", ["word", "count", "symbols t(word | symbol)"], table)


def set_words(
    name: Annotated[str, typer.Argument(metavar="CAPTURE", help="A capture's name.")],
    text: Annotated[str, typer.Argument(metavar="WORDS", help="Words that describe it.")],
    start: From = None,
    end: To = None,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the present captions.")] = False,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Set the caption of a capture or of a part of it."""
    with database(db, writing=True) as base:
        change = base.set_words(name, text, start, end, keep)
        captions = base.captions(name)
    said, new = [c.words for c in captions], list(change.new_words)
    if json:
        print_json(
            {"capture": name, "words": said, "counted": bool(change.counted), "new_words": new}
        )
        return
    typer.echo(f"{name}: {'; '.join(said)}")
    if new:
        typer.echo(f"  not known until the next motiondb learn: {', '.join(new)}")
    elif not change.counted:
        typer.echo("  to be counted at the next motiondb learn")


def import_words(
    sheet: Annotated[Path, typer.Argument(help="A sheet (TSV or CSV).")],
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Replace captions and tags by those of a sheet; rows without a capture are listed (exit 1)."""
    with database(db, writing=True) as base:
        report = base.import_words(sheet)
        drift = base.drift()
    if json:
        print_json(report)
    else:
        typer.echo(
            f"{report.captures} captures have the sheet's words and tags now, "
            f"{len(report.problems)} rows without a capture"
        )
        print_notes(report.notes)
        note_drift(drift)
    refuse(report.problems)


def set_synonyms(
    file: Annotated[Path, typer.Argument(help="Lines `word = canonical`.")],
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Store a file of synonyms for captions and queries."""
    with database(db, writing=True) as base:
        table = base.set_synonyms(file)
    if json:
        print_json(dict(table))
    else:
        typer.echo(f"{len(table)} synonyms kept")


def events(context: typer.Context, db: Db = DEFAULT_DB, json: Json = False) -> None:
    """List the kinds of events with their number, and the number of captures."""
    if context.invoked_subcommand is not None:
        return
    with database(db) as base:
        rows = base.event_rows()
    if json:
        print_json(rows)
    elif rows:
        table = [[str(value) for value in row.values()] for row in rows]
        print_table("", ["event", "count", "captures"], table)
    else:
        typer.echo("no events; add some with motiondb events import SHEET")


def show_events(
    name: Annotated[str, typer.Argument(metavar="CAPTURE", help="A capture's name.")],
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """List the events of one capture."""
    from motiondb import shown_event

    with database(db) as base:
        rows = [shown_event(event) for event in base.events(name)]
    if json:
        print_json(rows)
        return
    table = [[f"{row.seconds:.3f}", str(row.frame), row.name, row.joint, row.other] for row in rows]
    print_table("", ["seconds", "frame", "event", "joint", "other"], table)


def import_events(
    sheet: Annotated[Path, typer.Argument(help="A sheet of events (TSV or CSV).")],
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Replace the events of the captures of a sheet; rows without a capture are listed (exit 1)."""
    with database(db, writing=True) as base:
        report = base.import_events(sheet)
    if json:
        print_json(report)
    else:
        typer.echo(
            f"{report.events} events of {report.captures} captures kept, "
            f"{len(report.problems)} problems"
        )
        print_notes(report.notes)
    refuse(report.problems)
