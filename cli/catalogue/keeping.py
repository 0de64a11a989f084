"""Commands check, rescue, info and compact: maintenance of the database."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from motiondb.cli.catalogue.knowledge import print_start
from motiondb.cli.options import DEFAULT_DB, Db, Json, database, seconds_to_wait
from motiondb.cli.printing import note_drift, print_json, refuse


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    app.command()(check)
    app.command()(rescue)
    app.command()(info)
    app.command()(compact)


def check(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """Check the database for faults; exit 1 if there are any."""
    from motiondb import check_file

    faults = check_file(db, wait=seconds_to_wait())
    if json:
        print_json({"faults": faults})
    elif not faults:
        typer.echo(f"{db} is sound")
    refuse(faults)


def rescue(
    file: Annotated[
        Path | None, typer.Argument(metavar="FILE", help="The damaged database; by default --db.")
    ] = None,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="The new database, a new file.")
    ] = Path("rescued.duckdb"),
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Save every readable capture of a damaged database into a new file; exit 1 if any is lost."""
    import motiondb

    report = motiondb.rescue(file or db, output, wait=seconds_to_wait())
    if json:
        print_json(asdict(report))
    else:
        count = len(report.captures)
        typer.echo(f"{count} capture{'' if count == 1 else 's'} saved in {report.output}")
        if report.was_learned:
            typer.echo(f"Learn again: motiondb learn --db {report.output}")
    for sentence in (*report.mended, *report.lost):
        typer.echo(f"  {sentence}", err=True)
    if report.lost:
        raise typer.Exit(1)


def info(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """Show what the database contains and the commands that changed it."""
    with database(db) as base:
        facts, runs = base.info(), base.runs()
        drift = base.drift()
    if json:
        print_json(facts | {"drift": asdict(drift) if drift else None, "runs": runs})
        return
    first = facts.pop("start", None)
    for key, value in facts.items():
        typer.echo(f"{key.replace('_', ' ') + ':':22} {value}")
    if first:
        print_start(first)
    for run in runs[-10:]:
        what = f"run {run['run_id']:<4} {run['kind']:10}"
        typer.echo(f"{what} {run['started']} motiondb {run['version']}")
    if drift is None and facts["learned"] and not facts["current"]:
        typer.echo("Captures have changed since it learned: run motiondb learn to update it.")
    note_drift(drift)


def compact(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """Rewrite the database file without the space of removed rows."""
    import motiondb

    before, after = motiondb.compact(db, wait=seconds_to_wait())
    if json:
        print_json({"before": before, "after": after})
    else:
        typer.echo(f"{before / 1e6:.1f} MB before, {after / 1e6:.1f} MB after")
