"""events: instants of captures, such as foot strikes, catches and releases."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from motiondb.cli.options import DEFAULT_DB, Commands, Db, Json, database, print_json, print_table


def register(app: typer.Typer) -> None:
    """Put the commands into the app."""
    group = Commands(
        help="Instants of captures: feet that strike, balls that are caught and released.",
        invoke_without_command=True,
    )
    group.callback()(events)
    group.command("show")(show_events)
    group.command("import")(import_events)
    app.add_typer(group, name="events")


def events(context: typer.Context, db: Db = DEFAULT_DB, json: Json = False) -> None:
    """List which instants the database knows, how often, and in how many captures."""
    if context.invoked_subcommand is not None:
        return
    with database(db) as base:
        known = base.all_events()
    counts = Counter(event.name for of_one in known.values() for event in of_one)
    captures = Counter(name for of_one in known.values() for name in {e.name for e in of_one})
    rows = [
        {"event": name, "count": count, "captures": captures[name]}
        for name, count in sorted(counts.items())
    ]
    if json:
        print_json(rows)
    elif rows:
        table = [[str(value) for value in row.values()] for row in rows]
        print_table("", ["event", "count", "captures"], table)
    else:
        typer.echo("no events; motiondb events import SHEET brings some")


def show_events(
    name: Annotated[str, typer.Argument(metavar="CAPTURE", help="A capture's name.")],
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """List the instants of one capture."""
    from motiondb.records import MOTION_FPS

    with database(db) as base:
        rows = [
            {**asdict(event), "seconds": round(event.frame / MOTION_FPS, 3)}
            for event in base.events(name)
        ]
    if json:
        print_json(rows)
        return
    table = [
        [f"{row['seconds']:.3f}", *(str(row[key]) for key in ("frame", "name", "joint", "other"))]
        for row in rows
    ]
    print_table("", ["seconds", "frame", "event", "joint", "other"], table)


def import_events(
    sheet: Annotated[Path, typer.Argument(help="A sheet of instants (TSV or CSV).")],
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Replace the instants of the captures that a sheet names; unknown rows are listed (exit 1)."""
    with database(db, writing=True) as base:
        report = base.import_events(sheet)
    if json:
        print_json(asdict(report))
    else:
        typer.echo(
            f"{report.events} events of {report.captures} captures kept, "
            f"{len(report.problems)} problems"
        )
        for note in report.notes:
            typer.echo(f"  note: {note}")
    for problem in report.problems:
        typer.echo(f"  {problem}", err=True)
    if report.problems:
        raise typer.Exit(1)
