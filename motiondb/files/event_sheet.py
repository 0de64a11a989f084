"""Sheets of events: TSV or CSV with a header, one row for each instant.

Columns: ``file`` (path below the added folder, with or without its ending), ``event`` (what
happens: foot_strike, catch, release, contact, ...), ``frame`` (of the canonical motion, 30 per
second) or ``time`` (seconds), and, where it is known, ``joint`` (of the canonical body, such as
r_wrist) and ``other`` (what takes part besides the joint, such as ball). Further columns are
ignored.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from motiondb.body import body
from motiondb.errors import SheetError, suggestion
from motiondb.files.sheet import (
    Rows,
    all_faults,
    capture_name,
    check_columns,
    first_of,
    read_rows,
    shown_row,
    unknown_files,
)
from motiondb.files.text import number, quoted
from motiondb.records import MOTION_FPS, Event

COLUMNS = ("file", "event", "frame", "time", "joint", "other")
_SYNONYMS = MappingProxyType(
    {"filename": "file", "name": "event", "seconds": "time", "time_s": "time"}
)
MAX_VALUE = 1e9  # Frames and seconds beyond are faults: a year at 30 frames a second
_KNOWN = f"Columns: {', '.join(COLUMNS)}; frame counts 30 a second, time seconds."


@dataclass(frozen=True)
class EventSheet:
    """A sheet of events that was read."""

    path: str
    # Events with their lines, by capture name (path without ending)
    entries: dict[str, tuple[tuple[int, Event], ...]]
    notes: tuple[str, ...] = ()  # Sentences about unusual entries that were used

    @property
    def n_events(self) -> int:
        """Number of events in the sheet."""
        return sum(map(len, self.entries.values()))

    def unknown(self, names: Iterable[str]) -> list[str]:
        """Return a sentence for every file that is not among the captures."""
        files = {name: (rows[0][0], name) for name, rows in self.entries.items()}
        return unknown_files(self.path, files, names, "an existing capture")

    def within(self, name: str, n_frames: int, problems: list[str]) -> tuple[Event, ...]:
        """Return the events of a capture that lie within it."""
        kept = []
        for line, event in self.entries.get(name, ()):
            if event.frame >= n_frames:
                problems.append(
                    f"{self.path}:{line}: expected an event before the end of {name} at "
                    f"{n_frames / MOTION_FPS:.3f} s (frame {n_frames}), found frame {event.frame}. "
                    "Count frames at 30 a second, or give a column time."
                )
            else:
                kept.append(event)
        return tuple(kept)


def read_event_sheet(path: Path | str) -> EventSheet:
    """Read a sheet of events."""
    path = Path(path)
    rows = read_rows(path, f"the columns file, event and frame, found an empty sheet. {_KNOWN}")
    line, names = rows[0]
    header = [_SYNONYMS.get(name.strip().lower(), name.strip().lower()) for name in names]
    missing = [column for column in ("file", "event") if column not in header]
    missing += ["frame or time"] if not {"frame", "time"} & set(header) else []
    if missing:
        raise SheetError(
            f"{path}:{line}: expected a column {' and '.join(missing)}, found "
            f"{shown_row(names)}. {_KNOWN}"
        )
    check_columns(path, line, header)
    return _gather(path, header, rows[1:])


def _gather(path: Path, header: list[str], rows: Rows) -> EventSheet:
    """Turn rows into events; raise all faults at once."""
    entries: dict[str, list[tuple[int, Event]]] = {}
    seen: dict[tuple[str, Event], int] = {}
    faults: list[str] = []
    repeats: list[str] = []
    for line, row in rows:
        if len(row) > len(header):
            faults.append(f"{path}:{line}: expected {len(header)} columns, found {len(row)}.")
            continue
        cells = {column: cell.strip() for column, cell in zip(header, row)}
        try:
            name, event = capture_name(_filled(cells, "file")), _event(cells)
        except ValueError as error:
            faults.append(f"{path}:{line}: {error}")
            continue
        if (name, event) in seen:
            repeats.append(f"{path}:{line}: repeats line {seen[name, event]} and was left out")
            continue
        seen[name, event] = line
        entries.setdefault(name, []).append((line, event))
    if faults:
        raise SheetError(all_faults(faults))
    return EventSheet(
        str(path), {n: tuple(of_one) for n, of_one in entries.items()}, first_of(repeats)
    )


def _event(cells: dict[str, str]) -> Event:
    """Turn the cells of a row into an event; ValueError with the fault of the row."""
    joint = cells.get("joint", "")
    if joint and joint not in body.INDEX:
        raise ValueError(
            f"expected a joint of the canonical body, found {quoted(joint)}."
            + (suggestion(joint, body.JOINTS) or f" They are {', '.join(body.JOINTS)}.")
        )
    return Event(_frame(cells), _filled(cells, "event"), joint, cells.get("other", ""))


def _frame(cells: dict[str, str]) -> int:
    """Return the frame at 30 per second, from the frame or from the time."""
    frame, time = cells.get("frame", ""), cells.get("time", "")
    if not frame and not time:
        raise ValueError("expected a frame or a time, found neither. Give one of them.")
    column, text = ("frame", frame) if frame else ("time", time)
    value = number(text)
    if value is None or not 0 <= value < MAX_VALUE or (frame and value != round(value)):
        whole = "whole number" if frame else "number"
        raise ValueError(
            f"expected a {whole} of at least 0 in column {column}, found {quoted(text)}."
            f" {'Frames count 30 a second.' if frame else 'Times are seconds.'}"
        )
    return round(value) if frame else round(value * MOTION_FPS)


def _filled(cells: dict[str, str], column: str) -> str:
    """Return the cell of a column that may not be empty; ValueError if it is."""
    if not cells.get(column):
        what = "a file name" if column == "file" else "what happens"
        raise ValueError(
            f"expected {what} in column {column}, found nothing. Fill it in or delete the row."
        )
    return cells[column]
