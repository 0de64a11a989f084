"""A folder of motions with a manifest: what ``curate`` chose, or what a selection holds."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from motiondb import answers
from motiondb.database.catalogue import exporting
from motiondb.files.own_files import WRITER
from motiondb.files.safe_files import write_bytes
from motiondb.files.sheet_writer import write_table

if TYPE_CHECKING:
    from motiondb.database.session import Session

Row = TypeVar("Row", answers.ChosenInterval, answers.SelectedPart)
Progress = Callable[[str, float, float], None]


def write_motions(
    session: Session,
    rows: Sequence[Row],
    draft: Path,
    ending: str,
    changes: exporting.MotionChanges,
    tell: Progress,
) -> tuple[Row, ...]:
    """Write intervals into a folder; each then has the name of its file below it.

    Those of a split (to train on, to test with) stand in a folder of its own.
    """
    done, order = dict[int, str](), sorted(rows, key=lambda each: each.capture)
    for count, each in enumerate(order):
        tell("writing", count, len(order))
        split = each.split if isinstance(each, answers.ChosenInterval) else "all"
        within = draft if split == "all" else draft / split
        within.mkdir(exist_ok=True)
        plain = "".join(c if c.isalnum() or c in "-_." else "-" for c in each.capture)[:80]
        path = within / f"{each.interval:05d}_{plain}.{ending}"
        whole = isinstance(each, answers.SelectedPart) and each.whole
        start, end = (None, None) if whole else (each.start, each.end)
        exporting.export(session, each.capture, path, start, end, changes=changes)
        done[each.interval] = path.relative_to(draft).as_posix()
    return tuple(replace(each, file=done[each.interval]) for each in rows)


def write_manifest(rows: Sequence[Row], told: Mapping[str, object], folder: Path) -> None:
    """Write ``manifest.csv``, a row for each interval, and what is told as ``manifest.json``."""

    def cell(value: object) -> str:
        if isinstance(value, tuple):
            return " ".join(map(str, value))
        return "" if value is None else str(value)

    columns = [field.name for field in fields(rows[0])]
    cells = [[cell(getattr(each, name)) for name in columns] for each in rows]
    write_table(folder / "manifest.csv", columns, cells)
    facts = answers.to_json({"written_by": WRITER, **told})
    write_bytes(folder / "manifest.json", json.dumps(facts, indent=1).encode())
