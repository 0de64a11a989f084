"""Commands selections: captures, and parts of them, that are kept under a name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()
selecting = app.group(
    "selections", "Captures, and parts of them, that are kept under a name.", alone=True
)

Name = Annotated[str, options.argument("Name of the selection.", "NAME")]
Parts = Annotated[
    list[str] | None,
    options.argument("Captures, or parts of them in seconds.", "[CAPTURE[:FROM-TO]]..."),
]


@selecting.callback()
def selections(shared: options.Shared) -> None:
    """List the selections with their captures, parts and seconds."""
    with shared.database() as base:
        rows = base.selections()
    columns = ["selection", "captures", "parts", "seconds"]
    printing.print_rows(
        shared, rows, columns, lambda r: [r.selection, r.captures, r.parts, f"{r.seconds:.2f}"]
    )


@selecting.command("show")
def show(shared: options.Shared, name: Name) -> None:
    """Show what a selection holds, by capture and time."""
    with shared.database() as base:
        rows = base.selections.show(name)
    columns = ["part", "capture", "start", "end", "performer", "licence"]
    printing.print_rows(
        shared,
        rows,
        columns,
        lambda r: [
            *(r.interval, r.capture, f"{r.start:.2f}", f"{r.end:.2f}"),
            *(r.performer, r.licence),
        ],
    )


@selecting.command("add")
def add(
    shared: options.Shared,
    name: Name,
    parts: Parts = None,
    where: options.Where = "",
    search: Annotated[str, "Add the answers to a question in words."] = "",
    limit: options.Limit = 10,
) -> None:
    """Add captures, parts such as `walk:0.5-2`, or all that match --where, to a selection.

    With --search, the answers among these are added, each as the interval that was found.
    """
    _check_given("add", parts, where or search)
    with shared.database(writing=True) as base:
        if search:
            found = base.search(search, where, limit)
            given = [*(parts or ()), *(found.matches if not found.nothing else ())]
            changed = base.selections.add(name, given) if given else []
        else:
            changed = base.selections.add(name, parts or (), where)
    _say_changed(shared, name, changed)


@selecting.command("take")
def take(
    shared: options.Shared, name: Name, parts: Parts = None, where: options.Where = ""
) -> None:
    """Take captures, with all their parts, or single parts out of a selection."""
    _check_given("take", parts, where)
    with shared.database(writing=True) as base:
        changed = base.selections.take(name, parts or (), where)
    _say_changed(shared, name, changed)


@selecting.command("remove")
def remove(shared: options.Shared, name: Name) -> None:
    """Forget a selection; its captures stay, and motiondb undo brings it back."""
    with shared.database(writing=True) as base:
        changed = base.selections.remove(name)
    _say_changed(shared, name, changed)


@selecting.command("export")
def export(
    shared: options.Shared,
    changes: options.Changes,
    name: Name,
    output: Annotated[
        Path,
        options.option("New folder.", "-o", "--output", parser=options.a_path, metavar="FOLDER"),
    ],
    ending: Annotated[
        str, options.option("Format of the files: bvh, npz, csv, or as export writes.", "--as")
    ] = "bvh",
) -> None:
    """Write a selection into a new folder: a file for each part, and a manifest.

    The manifest (CSV and JSON) has source, interval, performer and licence of every file.
    """
    with shared.database() as base:
        done = base.selections.export(name, output, ending, changes.read())
    if not printing.as_json(shared, done):
        licences = ", ".join(done.licences)
        printing.say(
            f"{name}: {printing.number(done.motions, 'motion')} in {done.folder}; "
            f"licences: {licences}"
        )


def _check_given(command: str, parts: Sequence[str] | None, where: str) -> None:
    if not parts and not where.strip():
        raise motiondb.QueryError(
            f"selections {command}: expected names of captures or --where, found neither."
        )


def _say_changed(shared: options.Shared, name: str, changed: list[str]) -> None:
    if not printing.as_json(shared, answers.SelectionChanged(name, tuple(changed))):
        printing.say(f"{name}: {printing.number(len(changed), 'capture')} changed")
