"""Commands list and sql: the catalogue and all tables, as a table, CSV or JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()

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
