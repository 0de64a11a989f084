"""Commands check, info and compact: maintenance of the database."""

from __future__ import annotations

from dataclasses import asdict

import typer

from motiondb.cli.options import DEFAULT_DB, Db, Json, database, note_drift, print_json


def register(app: typer.Typer) -> None:
    """Add the commands to the app.

    Parameters
    ----------
    app : typer.Typer
        The app.
    """
    app.command()(check)
    app.command()(info)
    app.command()(compact)


def check(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """Check the database for faults; exit 1 if there are any."""
    with database(db) as base:
        faults = base.check()
    if json:
        print_json({"faults": faults})
    elif not faults:
        typer.echo(f"{db} is sound")
    for fault in faults:
        typer.echo(f"  {fault}", err=True)
    if faults:
        raise typer.Exit(1)


def info(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """Show what the database contains and the commands that changed it."""
    with database(db) as base:
        facts, runs = base.info(), base.runs()
        drift = base.drift()
    if json:
        print_json(facts | {"drift": asdict(drift) if drift else None, "runs": runs})
        return
    for key, value in facts.items():
        typer.echo(f"{key.replace('_', ' ') + ':':22} {value}")
    for run in runs[-10:]:
        what = f"run {run['run_id']:<4} {run['kind']:10}"
        typer.echo(f"{what} {run['started']} motiondb {run['version']}")
    if drift is None and facts["learned"] and not facts["current"]:
        typer.echo("Captures changed since it learned: run motiondb learn to bring it up to date.")
    note_drift(drift)


def compact(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """Rewrite the database file without the space of removed rows."""
    from motiondb import store

    before, after = store.compact(db)
    if json:
        print_json({"before": before, "after": after})
    else:
        typer.echo(f"{before / 1e6:.1f} MB before, {after / 1e6:.1f} MB after")
