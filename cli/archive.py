"""Commands remove, undo, rename and tags: changes of captures, and back again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()
tagging = app.group("tags", "Tags of captures: performer, licence and any others.", alone=True)

MOST_LISTED = 20  # Names that a question lists


@app.command()
def remove(
    shared: options.Shared,
    names: Annotated[
        list[str] | None, options.argument("Names of captures.", "[CAPTURE]...")
    ] = None,
    where: options.Where = "",
    yes: Annotated[bool, "Do not ask before removing."] = False,
) -> None:
    """Remove captures from the database, all or none; motiondb undo brings them back.

    With --where, the captures are listed and a question is asked, unless --yes is given.
    """
    if not names and not where.strip():
        raise motiondb.QueryError("remove: expected names of captures or --where, found neither.")
    with shared.database(writing=True) as base:
        if where.strip():
            found = [info.name for info in base.captures(where, exact=True)]
            if found and not yes and not _is_sure(found):
                raise typer.Exit(1)
        gone = base.captures.remove(names or (), where)
    if not printing.as_json(shared, answers.Removed(gone)):
        printing.say(f"removed {_listed(gone)}" if gone else "no capture matches")


def _is_sure(names: list[str]) -> bool:
    """List captures that will be removed, and ask whether they should be."""
    for name in names[:MOST_LISTED]:
        printing.warn(f"  {name}")
    if len(names) > MOST_LISTED:
        printing.warn(f"  ... and {len(names) - MOST_LISTED} more")
    question = f"Remove {printing.number(len(names), 'capture')}?"
    return printing.confirmed(question, "remove: nothing was removed. Answer y, or pass --yes.")


def _listed(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return f"{', '.join(names[:MOST_LISTED])}{more}"


@app.command()
def undo(
    shared: options.Shared,
    run: Annotated[
        int | None,
        options.argument(
            "Number of a run, as motiondb info lists them.  [default: the latest]", min=1
        ),
    ] = None,
) -> None:
    """Take back the latest change of captures, their names, words, tags or events.

    Repeated, it goes further back. To do the change again, undo the run that this command prints.
    Removed captures can be brought back until motiondb compact is run.
    """
    with shared.database(writing=True) as base:
        done = base.undo(run)
    if printing.as_json(shared, done):
        return
    printing.say(f"undone: run {done.undone_run} ({done.kind}), by run {done.run}")
    for what, names in (
        ("brought back", done.restored),
        ("removed", done.removed),
        ("as before", done.changed),
    ):
        if names:
            printing.say(f"  {what}: {_listed(names)}")
    printing.say(f"  to redo: motiondb undo {done.run}")


@app.command()
def rename(
    shared: options.Shared,
    old: Annotated[
        str,
        options.argument("Name of a capture, a folder such as old/, or a pattern such as walk_*."),
    ],
    new: Annotated[
        str, options.argument("The new name, folder such as new/, or pattern such as ana/walk_*.")
    ],
) -> None:
    """Give a capture another name, or all that are in a folder or fit a pattern."""
    with shared.database(writing=True) as base:
        renamed = base.captures.rename(old, new)
    if printing.as_json(shared, answers.Renamed(renamed)):
        return
    for before, after in renamed.items():
        printing.say(f"{before} is now {after}")
    if not renamed:
        printing.say("nothing to rename")


@app.command()
def merge(
    shared: options.Shared,
    other: Annotated[Path, options.argument("Another database.", "OTHER")],
    prefix: options.Prefix = "",
) -> None:
    """Take over the captures of another database, with words, tags, events and provenance.

    Files with the same content are the same capture. What is not taken over is said; captures whose
    names are taken are left out (exit 1).
    """
    motiondb.check_merge(other, prefix, shared.wait)
    with (
        shared.database(writing=True, create=True) as base,
        printing.progress(shared) as tell,
    ):
        report = base.merge(other, prefix, shared.wait, tell)
    if not printing.as_json(shared, report):
        printing.say(
            f"{printing.number(len(report.added), 'capture')} added, {len(report.known)} already "
            f"there ({len(report.changed)} of them changed), "
            f"{printing.number(len(report.problems), 'problem')}"
        )
        printing.print_notes(report.notes)
    printing.refuse(report.problems)


@app.command()
def backup(
    shared: options.Shared,
    file: Annotated[Path, options.argument("The copy, a new file.", "FILE")],
) -> None:
    """Copy the database into a new file while others use it, and check the copy."""
    with shared.database() as base:
        base.backup(file)
    n_bytes = file.stat().st_size
    if not printing.as_json(shared, answers.BackedUp(file, n_bytes)):
        printing.say(f"{file}: {n_bytes / 1e6:.1f} MB, checked")


@tagging.callback()
def tags(shared: options.Shared) -> None:
    """List the tags with their number of captures and of different values."""
    with shared.database() as base:
        rows = base.captures.tag_rows()
    columns = ["tag", "captures", "values"]
    printing.print_rows(shared, rows, columns, lambda row: [row.tag, row.captures, row.values])


@tagging.command("set")
def set_tags(
    shared: options.Shared,
    items: Annotated[
        list[str],
        options.argument(
            "A capture's name, if there is no --where; tags, such as performer=ana. "
            "TAG= removes a tag.",
            "[CAPTURE] TAG=VALUE...",
        ),
    ],
    where: options.Where = "",
) -> None:
    """Set tags of one capture, or of all that match --where."""
    names = [] if where.strip() else items[:1]
    pairs = [item.partition("=") for item in items[len(names) :]]
    if not pairs or not all(key and sign for key, sign, _ in pairs):
        wrong = next((key for key, sign, _ in pairs if not (key and sign)), "none")
        raise motiondb.QueryError(
            f"tags set: expected {'' if where else 'a capture, then '}TAG=VALUE, found {wrong}."
        )
    given = {key: value for key, _, value in pairs}
    with shared.database(writing=True) as base:
        changed = base.captures.set_tags(given, names, where)
    if not printing.as_json(shared, answers.TagsSet(given, changed)):
        told = ", ".join(f"{key}={value}" for key, value in given.items())
        printing.say(f"{told}: {printing.number(len(changed), 'capture')} changed")
