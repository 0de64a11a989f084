"""Commands check, rescue, info, compact and knowledge: the database file, and what it learned."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from motiondb.cli.options import DEFAULT_DB, Commands, Db, Json, database, seconds_to_wait
from motiondb.cli.printing import note_drift, print_json, refuse


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    app.command()(check)
    app.command()(rescue)
    app.command()(info)
    app.command()(compact)
    group = Commands(
        help="Export what was learned, without motion and captions.", no_args_is_help=True
    )
    group.command("export")(export_knowledge)
    group.command("show")(show_knowledge)
    app.add_typer(group, name="knowledge")


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
        print_json(report)
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
        facts, runs, drift = vars(base.info()), base.runs(), base.drift()
    if json:
        print_json(facts | {"drift": drift, "runs": runs})
        return
    for key, value in facts.items():
        if value is not None and key != "start":
            typer.echo(f"{key.replace('_', ' ') + ':':22} {value}")
    if facts["start"]:
        print_start(facts["start"])
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


def export_knowledge(
    file: Annotated[Path, typer.Argument(help="The file to write.")],
    name: Annotated[
        str, typer.Option("--name", help="Its name.  [default: name of the file]")
    ] = "",
    credit: Annotated[
        str, typer.Option("--credit", help="The acknowledgement that users are asked to give.")
    ] = "",
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Write the learned model, without motion and captions (see learn --start)."""
    with database(db) as base:
        facts = base.export_knowledge(file, name, credit).facts()
    facts["file"], facts["bytes"] = str(file), file.stat().st_size
    if json:
        print_json(facts)
        return
    typer.echo(f"{file}: {facts['bytes'] / 1e6:.2f} MB, {say_origin(facts)}")
    typer.echo(f"Start from it: motiondb learn --start {file}")


def show_knowledge(
    what: Annotated[
        str | None,
        typer.Argument(
            help="A file, or the shipped knowledge: cmu.  [default: the start of the database]"
        ),
    ] = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Show the content and origin of knowledge; a file is checked."""
    from motiondb import load_knowledge

    if what is None:
        with database(db) as base:
            knowledge = base.start_knowledge()
    else:
        knowledge = load_knowledge(what)
    facts = knowledge.facts()
    if json:
        print_json(facts | {"vocabulary": list(knowledge.words)})
        return
    typer.echo(say_origin(facts))
    typer.echo(f"sha256: {facts['sha256']}")
    if facts["credit"]:
        typer.echo(f"credit: {facts['credit']}")
    typer.echo(f"words: {', '.join(knowledge.words)}")


def say_origin(facts: Mapping[str, Any]) -> str:
    """One line on the origin of knowledge."""
    licences = ", ".join(f"{name} ({n})" for name, n in facts["licences"].items())
    return (
        f"{facts['name']}: {facts['symbols']} symbols and {facts['words']} words of "
        f"{facts['captures']} captures, {facts['captions']} of them described, "
        f"{facts['performers']} performers; licences: {licences}; motiondb {facts['version']}"
    )


def print_start(first: Mapping[str, Any]) -> None:
    """Print the origin of the start of a database and its share."""
    typer.echo(f"Started from {say_origin(first)}.")
    if first["own_captions"]:
        typer.echo(
            f"{first['words_of_start_alone']} words are of the start alone, "
            f"{first['words_of_both']} of both, {first['words_of_own_captions_alone']} of own "
            f"captions alone; a caption of the start counts {first['weight']:.2g} of an own one."
        )
    else:
        typer.echo("No own captions: all words are those of the start.")
    if first["unchecked"]:
        typer.echo(f"Answers carry {first['unchecked']}.")
    if not first["fits"]:
        typer.echo(
            f"{first['strange_motion']:.0%} of the motion is unlike anything that the symbols of "
            f"the start model: its words are less reliable here."
        )
    if first["credit"]:
        typer.echo(f"Credit: {first['credit']}")
