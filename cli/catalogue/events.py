"""Commands events, events show and events import: foot strikes, catches, releases and others."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from motiondb.cli.options import DEFAULT_DB, Commands, Db, Json, database
from motiondb.cli.printing import print_json, print_notes, print_table, refuse


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    group = Commands(
        help="Events of captures: foot strikes, catches and releases of a ball.",
        invoke_without_command=True,
    )
    group.callback()(events)
    group.command("show")(show_events)
    group.command("import")(import_events)
    app.add_typer(group, name="events")


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
    with database(db) as base:
        rows = [{**asdict(event), "seconds": event.seconds} for event in base.events(name)]
    if json:
        print_json(rows)
        return
    table = [
        [f"{row['seconds']:.3f}", *(str(row[key]) for key in ("frame", "name", "joint", "other"))]
        for row in rows
    ]
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
        print_json(asdict(report))
    else:
        typer.echo(
            f"{report.events} events of {report.captures} captures kept, "
            f"{len(report.problems)} problems"
        )
        print_notes(report.notes)
    refuse(report.problems)
