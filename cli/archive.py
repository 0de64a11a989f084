"""Commands list and sql: the catalogue; remove, undo, rename, merge and tags: its changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()
tagging = app.group("tags", "Tags of captures: performer, licence and any others.", alone=True)

LONGEST_CAPTION = 70  # Letters of captions in a table
FILE_COLUMNS = [
    "name",
    "duration",
    "fps",
    "n_frames",
    "format",
    "kind",
    "leg_length",
    "path",
    "sha256",
]
"""Columns of the catalogue in CSV; captions and tags follow."""
USUAL_COLUMNS = ["name", "duration", "fps", "format", "performer", "caption"]


@app.command("list")
def list_captures(
    shared: options.Shared,
    where: options.Where = "",
    limit: Annotated[int | None, options.option("Largest number of captures.", min=1)] = None,
    sort: Annotated[str, "Column or tag to sort by; with - in front, the largest first."] = "",
    columns: Annotated[str, "Columns and tags to print, such as name,duration,licence."] = "",
    as_csv: Annotated[
        bool, options.option("Print CSV with all columns and tags, or --columns.", "--csv")
    ] = False,
    duplicates: Annotated[bool, "List groups of copies, cuts and mirror images."] = False,
    faulty: Annotated[bool, "List the files that add could not read."] = False,
    exact: options.Exact = False,
) -> None:
    """List the captures; --where and --sort take the names of the columns, caption, and tags.

    --duplicates lists groups that repeat one another, and added files that have the content of a
    capture; --faulty lists files that could not be read.
    """
    if duplicates and faulty:
        raise motiondb.QueryError("list: expected --duplicates or --faulty, found both.")
    if duplicates or faulty:
        if sort or (faulty and (where or limit)):
            raise motiondb.QueryError(
                f"list: expected {'--duplicates' if duplicates else '--faulty'} without --sort"
                f"{', --where and --limit' if faulty else ''}, found both."
            )
        _list_faulty(shared, as_csv) if faulty else _list_duplicates(shared, where, limit, as_csv)
        return
    with shared.database() as base:
        infos = base.captures(where, exact, sort)
        printing.note_filter(base, where, exact)
        captions = base.words.all_captions()
    shown = infos[:limit]
    if printing.as_json(
        shared, (motiondb.listed_capture(i, captions.get(i.capture_id, ())) for i in shown)
    ):
        return
    said = {i.name: "; ".join(c.words for c in captions.get(i.capture_id, ())) for i in shown}
    _print_captures(infos, shown, said, columns, as_csv)


def _print_captures(
    infos: Sequence[motiondb.CaptureInfo],
    shown: Sequence[motiondb.CaptureInfo],
    said: Mapping[str, str],
    columns: str,
    as_csv: bool,
) -> None:
    """Print the shown ones of some captures, whose captions are said, as a table or CSV."""
    tags = {tag for info in infos for tag in info.tags} - {*FILE_COLUMNS, "caption"}
    known = [*FILE_COLUMNS, "caption", *sorted(tags)]
    chosen = [each.strip() for each in columns.split(",") if each.strip()]
    for column in chosen:
        if column not in known:
            raise motiondb.QueryError(
                f"list: expected columns among {', '.join(known)}, found {column!r}."
            )

    def cell(info: motiondb.CaptureInfo, column: str) -> object:
        if column == "caption":
            return said[info.name] if as_csv else said[info.name][:LONGEST_CAPTION]
        value = getattr(info, column) if column in FILE_COLUMNS else info.tags.get(column, "")
        if as_csv or not isinstance(value, float):
            return value
        return f"{value:g}" if column == "fps" else f"{value:.2f}"

    printed = chosen or (known if as_csv else USUAL_COLUMNS)
    rows = [[cell(info, column) for column in printed] for info in shown]
    if as_csv:
        printing.print_csv(printed, rows)
        return
    printing.print_table(printed, rows)
    fewer = f", {len(shown)} shown" if len(shown) < len(infos) else ""
    printing.say(f"{printing.number(len(infos), 'capture')}{fewer}")


@app.command()
def sql(
    shared: options.Shared,
    query: Annotated[str, options.argument("One SELECT about the tables of the database.")],
    as_csv: Annotated[bool, options.option("Print CSV.", "--csv")] = False,
) -> None:
    """Ask the tables of the database in SQL; schema/README.md describes them.

    Nothing is changed, and no other file is read.
    """
    with shared.database() as base:
        columns, rows = base.tables.sql(query)
    if printing.as_json(shared, {"columns": columns, "rows": rows}):
        return
    if as_csv:
        printing.print_csv(columns, rows)
        return
    printing.print_table(columns, rows)
    printing.say(printing.number(len(rows), "row"))


def _list_faulty(shared: options.Shared, as_csv: bool) -> None:
    with shared.database() as base:
        files = base.captures.faulty_files()
    if printing.as_json(shared, files):
        return
    rows = [[each.path, each.noted, each.problem] for each in files]
    if as_csv:
        printing.print_csv(["path", "noted", "problem"], rows)
        return
    for each in files:
        printing.say(*each.problem.split("\n"))
    printing.say(printing.number(len(files), "faulty file"))


def _list_duplicates(shared: options.Shared, where: str, limit: int | None, as_csv: bool) -> None:
    with shared.database() as base:
        infos = {info.name: info for info in base.captures()}
        groups = base.captures.duplicates(where)
        chosen = {info.name for info in base.captures(where)} if where.strip() else {*infos}
        files = [each for each in base.captures.same_files() if each.capture in chosen]
    if printing.as_json(shared, answers.Duplicates(tuple(groups[:limit]), tuple(files[:limit]))):
        return
    rows = [
        [
            number if name == group.captures[0] or as_csv else "",
            name,
            f"{infos[name].duration:.2f}",
            "; ".join(
                printing.say_relation(r).partition(" ")[2]
                for r in group.relations
                if r.capture == name
            ),
        ]
        for number, group in enumerate(groups[:limit], start=1)
        for name in group.captures
    ]
    columns = ["group", "name", "duration", "repeats"]
    if as_csv:
        printing.print_csv(columns, rows)
        return
    printing.print_table(columns, rows)
    extra = sum(len(group.captures) - 1 for group in groups)
    printing.say(f"{printing.number(len(groups), 'group')}, {extra} of the captures repeat others")
    for each in files[:limit]:
        printing.say(f"{each.path} is the same file as {each.capture}")


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
