"""Sheets of BORIS and ELAN, as words with intervals and as events.

BORIS: aggregated events (a row an interval, ``Start (s)`` and ``Stop (s)``) and tabular events (a
row an instant; START and STOP of a state become an interval), CSV or TSV, of version 7 or 8.
ELAN: "Tab-delimited text", with or without a header, with a column for each tier or one for all. An
interval becomes words, an instant an event. Which capture a row is about is said by the name of its
media file, its observation, or, where no file is named, by the name of the sheet.

Sources: Friard, Gamba, "BORIS", Methods in Ecology and Evolution 7, 2016, and its user guide;
The Language Archive, "ELAN manual", section on tab-delimited text.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from motiondb.errors import SheetError
from motiondb.files.safe_files import write_bytes
from motiondb.files.text import csv_bytes, number, quoted
from motiondb.records import Caption, Event

Rows = Sequence[tuple[int, Sequence[str]]]
_CLOCK = re.compile(r"(\d+):(\d\d):(\d\d(?:[.,]\d+)?)")
_MEDIA = re.compile(r"\.(mp4|avi|mov|mkv|mpe?g|wmv|m4v|webm|wav|mp3|eaf|pfsx)$", re.IGNORECASE)
_PLAYER = re.compile(r"^player #\d+\s*:\s*", re.IGNORECASE)
_FILES = ("media file name", "media file path", "media file", "media file(s)", "source")
_ABOUT = ("tier", "participant", "annotator", "file", "file path", "file name")
_NONE = ("", "na", "nan", "none")
FORMS = ("boris", "elan")
_BORIS = (
    *("Observation id", "Observation date", "Description", "Media file", "Total length", "FPS"),
    *("Subject", "Behavior", "Behavioral category", "Modifiers", "Behavior type", "Start (s)"),
    *("Stop (s)", "Duration (s)", "Comment start", "Comment stop"),
)
_ELAN = ("Tier", "Begin Time - ss.msec", "End Time - ss.msec", "Annotation", "File")


@dataclass(frozen=True)
class Annotation:
    """A row of such a sheet; seconds."""

    names: tuple[str, ...]  # Which capture it may be about, the likeliest first
    line: int
    words: str
    start: float
    end: float | None  # None for an instant


def read_annotations(path: Path, rows: Rows) -> list[Annotation] | None:
    """Read the rows of a sheet of BORIS or ELAN; None if it is none (SheetError)."""
    for at, (_, cells) in enumerate(rows[:60]):
        header = [cell.strip().lower() for cell in cells]
        if "file" in header and {"words", "event"} & set(header):
            return None
        if "behavior" in header and {"start (s)", "time"} & set(header):
            return _boris(path, header, rows[at + 1 :])
        if any(cell.startswith("begin time") for cell in header):
            return _elan(path, header, rows[at + 1 :])
    first = next((cells for _, cells in rows if not _is_comment(cells)), ())
    is_elan = len([cell for cell in first if _CLOCK.fullmatch(cell.strip())]) >= 2
    return _elan(path, None, rows) if is_elan else None


def _boris(path: Path, header: Sequence[str], rows: Rows) -> list[Annotation]:
    """Read events of BORIS, aggregated or tabular."""
    found, open_states = list[Annotation](), dict[tuple[str, ...], tuple[int, float]]()
    for line, cells in rows:
        row = dict(zip(header, map(str.strip, cells)))
        row = {key: "" if value.lower() in _NONE else value for key, value in row.items()}
        behavior = row.get("behavior", "")
        if not behavior:
            continue
        more = [value for key, value in row.items() if key.startswith("modifier") and value]
        words = " ".join([behavior, *(part for value in more for part in value.split("|"))])
        observed = row.get("observation id", "")
        names = _names([*(row.get(key, "") for key in _FILES), observed], path)
        kind = row.get("behavior type") or row.get("status", "")
        if "start (s)" in row:
            start, end = (_seconds(row.get(key, ""), path, line) for key in _SPAN)
            found.append(Annotation(names, line, words, start, end if end > start else None))
            continue
        time = _seconds(row.get("time", ""), path, line)
        state = (observed, row.get("subject", ""), words)
        if kind.upper() == "START":
            open_states[state] = (line, time)
        elif kind.upper() != "STOP":
            found.append(Annotation(names, line, words, time, None))
        elif state in open_states:
            first, start = open_states.pop(state)
            found.append(Annotation(names, first, words, start, time if time > start else None))
        else:
            raise SheetError(
                f"{path}:{line}: expected a START of {quoted(words)} before its STOP, found none. "
                "Correct the observation in BORIS, and export it again."
            )
    for (_, _, words), (line, _) in open_states.items():
        raise SheetError(
            f"{path}:{line}: expected a STOP of {quoted(words)} after its START, found none. "
            "Correct the observation in BORIS, and export it again."
        )
    return sorted(found, key=lambda each: each.line)


_SPAN = ("start (s)", "stop (s)")


def _elan(path: Path, header: Sequence[str] | None, rows: Rows) -> list[Annotation]:
    """Read annotations of ELAN."""
    found, file = list[Annotation](), ""
    for line, cells in rows:
        cells = [cell.strip() for cell in cells]
        if _is_comment(cells):
            file = cells[0].lstrip('"#').removeprefix("file:") if "file:" in cells[0] else file
            continue
        if header is not None:
            row = dict(zip(header, cells))
            start, end = (_seconds(_time_cell(row, which), path, line) for which in _ENDS)
            told = [key for key in row if key not in _ABOUT and not key.startswith(_TIMES)]
            texts = [row[key] for key in told if row[key]]
            named = [row.get(key, "") for key in ("file path", "file", "file name")]
        else:
            clocks = [cell for cell in cells if _CLOCK.fullmatch(cell)]
            if len(clocks) < 2:
                raise SheetError(
                    f"{path}:{line}: expected begin and end as hh:mm:ss.ms, found "
                    f"{quoted(' | '.join(cells), 200)}. Export them from ELAN in that form."
                )
            start, end = (_seconds(clock, path, line) for clock in clocks[:2])
            named = [cell for cell in cells if _MEDIA.search(cell)]
            texts = [
                cell
                for cell in cells[1:]
                if cell and number(cell) is None and cell not in (*clocks, *named)
            ][-1:]
        names = _names([*named, file], path)
        found += [Annotation(names, line, t, start, end if end > start else None) for t in texts]
    return found


_ENDS = ("begin time", "end time")
_TIMES = (*_ENDS, "duration")  # How columns of times begin


def _time_cell(row: Mapping[str, str], which: str) -> str:
    """Return begin or end of a row, seconds or hh:mm:ss.ms."""
    for form in ("ss.msec", "hh:mm:ss.ms"):
        if value := row.get(f"{which} - {form}", ""):
            return value
    value = row.get(f"{which} - msec", "")
    milliseconds = number(value)
    return value if milliseconds is None else f"{milliseconds / 1000.0:.6f}"


def _is_comment(cells: Sequence[str]) -> bool:
    return bool(cells) and cells[0].lstrip('"').startswith("#")


def _seconds(text: str, path: Path, line: int) -> float:
    """Return a time in seconds (SheetError)."""
    clock = _CLOCK.fullmatch(text)
    value = number(text)
    if clock:
        hours, minutes, seconds = clock.groups()
        value = 3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds.replace(",", "."))
    if value is None or not 0 <= value < 1e9:
        raise SheetError(f"{path}:{line}: expected seconds from 0 on, found {quoted(text)}.")
    return value


def _names(files: Sequence[str], path: Path) -> tuple[str, ...]:
    """Return which captures files may name: with their folder, and without it; else the sheet's."""
    names = []
    for file in files:
        plain = _MEDIA.sub("", _PLAYER.sub("", file).replace("\\", "/").strip())
        names += [plain, PurePosixPath(plain).name] if plain else []
    return tuple(dict.fromkeys(names)) or (path.stem,)


def write_annotations(
    path: Path,
    rows: Sequence[tuple[str, float, float, Sequence[Caption], Sequence[Event]]],
    form: str,
) -> None:
    """Write words and events in the form of "boris" or "elan", whole or not at all.

    `rows`: name, seconds, frames a second, words and events of each capture. Words about a whole
    capture last from its start to its end.
    """
    delimiter = "\t" if form == "elan" or path.suffix.lower() == ".tsv" else ","
    lines: list[Sequence[str]] = [_BORIS if form == "boris" else _ELAN]
    for name, seconds, fps, captions, events in rows:
        spans = [
            (" ".join(c.words.split()), c.start or 0.0, seconds if c.end is None else c.end)
            for c in captions
        ]
        spans += [(event.name, event.seconds, event.seconds) for event in events]
        for said, start, end in sorted(spans, key=lambda span: span[1:]):
            times = (f"{start:.3f}", f"{end:.3f}")
            if form == "elan":
                tier = "words" if end > start else "events"
                lines.append([tier, *times, said, name])
            else:
                kind = "STATE" if end > start else "POINT"
                about = [name, "", "", name, f"{seconds:.3f}", f"{fps:g}", "No focal subject"]
                length = f"{end - start:.3f}"
                lines.append([*about, said, "", "", kind, *times, length, "", ""])
    write_bytes(path, csv_bytes(lines, delimiter))
