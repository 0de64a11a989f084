"""Commands words, words set, import and synonyms: vocabulary and captions."""

from __future__ import annotations

from dataclasses import asdict
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
            r["word"],
            str(r["count"]),
            "  ".join(f"{s['symbol']}: {s['probability']:.2f}" for s in r["symbols"]),
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
        print_json(asdict(report))
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
