"""Sheets of words and of events: TSV or CSV with a header.

Words, one or more rows for each capture: ``file`` (path below the added folder, with or without its
ending) and any of ``words``, ``start``, ``end`` (seconds: the row's words describe this part),
``performer``, ``fps``, ``up`` (the axis that points up: x, y, z, -x, -y, -z), ``licence``,
``skeleton``; every further column is kept as a tag. The values of a sheet override those in the
file's header.

Sheets of BORIS and ELAN are recognised (:mod:`.annotation_sheets`): their intervals are words,
their instants events.

Events, one row for each instant: ``file``, ``event`` (what happens: foot_strike, catch, release,
contact, ...), ``frame`` (of the canonical motion, 30 per second) or ``time`` (seconds), and, where
it is known, ``joint`` (of the canonical body, such as r_wrist) and ``other`` (what takes part
besides the joint, such as ball). Further columns are ignored.
"""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from operator import add
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any, TypeVar, cast

from motiondb.body import body
from motiondb.body.world import UPS
from motiondb.errors import SheetError, suggestion
from motiondb.files.annotation_sheets import Annotation, read_annotations
from motiondb.files.folder import CAPTURE_ENDINGS, TAKE_ENDINGS
from motiondb.files.limits import MAX_GIVEN_FPS, MIN_FPS
from motiondb.files.safe_files import read_bounded
from motiondb.files.text import MAX_FAULTS, cut, number, quoted
from motiondb.records import MOTION_FPS, Caption, Event

T = TypeVar("T")
AnySheet = TypeVar("AnySheet", "Sheet", "EventSheet")

KNOWN = ("file", "words", "start", "end", "performer", "fps", "up", "licence", "skeleton")
_WORD_COLUMNS = ", ".join(KNOWN)
_WORD_SYNONYMS = MappingProxyType(
    {
        "license": "licence",
        "subject": "performer",
        "caption": "words",
        "start_s": "start",
        "end_s": "end",
        "filename": "file",
    }
)
_SAID = ("captions", "description", "descriptions", "text", "label", "labels", "annotation")
"""Columns that hold the words where none is called so; beside one that is, they are tags."""
MAX_BYTES = 100_000_000  # Largest sheet that is read; a million rows take about as much
EVENT_COLUMNS = ("file", "event", "frame", "time", "joint", "other")
_EVENT_SYNONYMS = MappingProxyType(
    {"filename": "file", "name": "event", "seconds": "time", "time_s": "time"}
)
MAX_VALUE = 1e9  # Frames and seconds beyond are faults: a year at 30 frames a second
_EVENT_COLUMNS = f"Columns: {', '.join(EVENT_COLUMNS)}; frame counts 30 a second, time seconds."

_MAX_LISTED = 100  # Faults that a message lists: enough to correct a sheet in a few rounds

Rows = list[tuple[int, list[str]]]  # (line number, cells) of each row that is not empty


@dataclass(frozen=True)
class SheetEntry:
    """The entries of a sheet for one capture."""

    file: str  # The capture as the sheet names it
    line: int  # Line where it is first named
    captions: tuple[Caption, ...] = ()  # Words, with intervals in seconds
    tags: dict[str, str] = field(default_factory=dict)  # Performer, licence and all further columns
    fps: float | None = None  # Frames per second, instead of the rate in the file
    skeleton: str | None = None  # The ASF file of an AMC
    up: str | None = None  # The axis that points up
    lines: tuple[int, ...] = ()  # Of each caption


@dataclass(frozen=True)
class Sheet:
    """A sheet that was read."""

    path: str
    entries: dict[str, SheetEntry]  # Entries by capture name (path without ending)
    notes: tuple[str, ...] = ()  # Sentences about unusual entries that were used
    others: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # Names it may mean, too

    def find(self, name: str) -> SheetEntry | None:
        """Entry of a capture, or None; a take without one has its file's, but no captions."""
        if name in self.entries:
            return self.entries[name]
        of_file = self.entries.get(name.rpartition("#")[0])
        return None if of_file is None else replace(of_file, captions=())

    def within(self, name: str, duration: float, problems: list[str]) -> tuple[Caption, ...]:
        """Return the captions that lie within a capture (seconds); others become problems."""
        entry = self.find(name)
        kept = []
        for caption, line in zip(entry.captions, entry.lines) if entry else ():
            if is_within(caption, duration):
                kept.append(caption)
            else:
                problems.append(
                    f"{self.path}:{line}: expected words about a part of {name}, which ends at "
                    f"{duration:.4g} s, found {spoken_part(caption)}. Times are seconds; the words "
                    "were left out."
                )
        return tuple(kept)

    def unknown(self, names: Iterable[str]) -> list[str]:
        """Return a sentence for every entry whose file is not among the captures."""
        files = {name: (entry.line, entry.file) for name, entry in self.entries.items()}
        return unknown_files(self.path, files, names, "a capture of the added folder")


_ROUNDED = 0.25  # Seconds by which the end of a caption may be beyond that of its capture


def is_within(caption: Caption, duration: float) -> bool:
    """Say whether a caption is about a part of a capture of this duration, seconds."""
    late = caption.start is not None and caption.start >= duration
    return not late and (caption.end is None or caption.end <= duration + _ROUNDED)


def spoken_part(caption: Caption) -> str:
    """Return words and the part that they are about, as a message shows them.

    >>> spoken_part(Caption("walk", None, 120.0))
    "'walk' to 120 s"
    """
    start = "" if caption.start is None else f" from {caption.start:g} s"
    return quoted(caption.words) + start + ("" if caption.end is None else f" to {caption.end:g} s")


def unknown_files(
    path: str, files: Mapping[str, tuple[int, str]], names: Iterable[str], expected: str
) -> list[str]:
    """A sentence for every file (name -> line, spelling) of a sheet that is no capture."""
    known = set(names)
    unknown = [(name, *place) for name, place in files.items() if name not in known]
    return [
        f"{path}:{line}: expected {expected}, found {quoted(file, 200)}."
        f"{suggestion(name, known) if number < MAX_FAULTS else ''} Correct the file column."
        for number, (name, line, file) in enumerate(unknown)
    ]


def capture_name(file: str) -> str:
    """Return a file's path below its folder without its ending, with forward slashes.

    >>> capture_name("16/16_01.amc"), capture_name("a.b/take 1.bvh")
    ('16/16_01', 'a.b/take 1')
    >>> capture_name("day2.fbx#walk")
    'day2#walk'
    """
    before, mark, take = file.strip().rpartition("#")
    if mark and PurePosixPath(before).suffix.lower() in TAKE_ENDINGS:
        return f"{capture_name(before)}#{take}"
    path = PurePosixPath(file.strip().replace("\\", "/"))
    return str(path.with_suffix("")) if path.suffix.lower() in CAPTURE_ENDINGS else str(path)


def _ending(file: str) -> str:
    """Return the ending of a file if it is that of captures, else ""."""
    suffix = PurePosixPath(file.strip().replace("\\", "/")).suffix
    return suffix if suffix.lower() in CAPTURE_ENDINGS else ""


def read_sheet(path: Path | str) -> Sheet:
    """Read a sheet of words."""
    path = Path(path)
    if (foreign := _foreign(path)) is not None:
        return _words_of(path, foreign)
    rows = read_rows(
        path, f"a column `file`, found an empty sheet. Known columns: {_WORD_COLUMNS}."
    )
    header_number, names = rows[0]
    header = [_WORD_SYNONYMS.get(c.strip().lower(), c.strip()) for c in names]
    header = [c.lower() if c.lower() in KNOWN else c for c in header]
    said = next((c for name in _SAID for c in header if c.lower() == name), None)
    notes = list[str]()
    if said is not None and "words" not in header:
        header[header.index(said)] = "words"
        notes.append(f"{path}: the words are those of the column {quoted(said)}.")
    if "file" not in header:
        raise SheetError(
            f"{path}:{header_number}: expected a column `file`, found {shown_row(header)}. "
            f"Known columns: {_WORD_COLUMNS}; others are kept as tags."
        )
    check_columns(path, header_number, header)
    advice = " Put text with separators in quotes."
    sheet = Sheet(str(path), *_gather(path, header, rows[1:], _read_words, _merged, advice))
    return replace(sheet, notes=(*notes, *sheet.notes))


_OTHERS = re.compile(r"\bbehavior\b|begin time|\d:\d\d:\d\d[.,]\d", re.IGNORECASE)
"""What the beginning of a sheet of BORIS or ELAN holds."""


def _foreign(path: Path) -> list[Annotation] | None:
    """Return what a sheet of BORIS or ELAN says; None if it is another one."""
    text = _read_text(path)
    head = text[:20_000]
    if not _OTHERS.search(head):
        return None
    text = re.sub(r'^"#', "#", text, flags=re.MULTILINE)  # ELAN does not close this quote
    delimiter = "\t" if "\t" in head else max(";,", key=head.count)
    try:
        rows = _split(path, text, delimiter)
    except SheetError:  # told by whoever reads it as another sheet
        return None
    return read_annotations(path, rows)


def _words_of(path: Path, foreign: list[Annotation]) -> Sheet:
    """Return the words of a sheet of BORIS or ELAN."""
    entries: dict[str, SheetEntry] = {}
    others: dict[str, tuple[str, ...]] = {}
    for each in foreign:
        name = capture_name(each.names[0])
        entry = entries.setdefault(name, SheetEntry(each.names[0], each.line))
        others[name] = each.names[1:]
        if each.end is not None:
            said = Caption(each.words, each.start, each.end)
            entries[name] = replace(
                entry, captions=(*entry.captions, said), lines=(*entry.lines, each.line)
            )
    left = sum(each.end is None for each in foreign)
    notes = (f"{path}: {left} instants are events (motiondb events import {path})",) * (left > 0)
    return Sheet(str(path), entries, notes, others)


def _events_of(path: Path, foreign: list[Annotation]) -> EventSheet:
    """Return the events of a sheet of BORIS or ELAN."""
    entries: dict[str, tuple[tuple[int, Event], ...]] = {}
    others: dict[str, tuple[str, ...]] = {}
    for each in foreign:
        name = capture_name(each.names[0])
        if each.end is None:
            event = Event(round(each.start * MOTION_FPS), each.words)
            entries[name] = (*entries.get(name, ()), (each.line, event))
            others[name] = each.names[1:]
    left = sum(each.end is not None for each in foreign)
    notes = (f"{path}: {left} intervals are words (motiondb words import {path})",) * (left > 0)
    return EventSheet(str(path), entries, notes, others)


def resolved(sheet: AnySheet, files: Mapping[str, str]) -> AnySheet:
    """Return a sheet whose rows name captures as they are called, where only one may be meant.

    `files`: The file of each capture, by name.
    """
    by_stem: dict[str, list[str]] = {}  # Of captures whose names have an ending
    for each in files:
        by_stem.setdefault(capture_name(each), []).append(each)

    def called(name: str) -> list[str]:
        if name in files:
            return [name]
        for other in (name, *sheet.others[name]) if name in sheet.others else ():
            fitting = [n for n in files if n == other] or [
                n for n in files if n.endswith(f"/{other}")
            ]
            if len(fitting) == 1:
                return fitting
        stem, ending = capture_name(name), _ending(name)
        alike = by_stem.get(stem, [])
        if ending:  # one of several files of this name in the sheet
            alike = [n for n in alike if n == name or files[n].endswith(ending)]
        return alike or [name]

    entries: dict[str, Any] = {}
    for name, entry in cast(Any, sheet).entries.items():
        spelled = name + _ending(getattr(entry, "file", ""))
        for each in [spelled] if spelled in files else called(name):
            entries.setdefault(each, entry)
    return cast(AnySheet, replace(cast(Any, sheet), entries=entries))


def check_columns(path: Path, line: int, header: list[str]) -> None:
    """Refuse a header that names a column twice: only one of them could be read."""
    twice = next((name for name in header if name and header.count(name) > 1), None)
    if twice is not None:
        raise SheetError(
            f"{path}:{line}: expected each column once, found {quoted(twice)} twice. Rename one."
        )


def tag_fault(key: str) -> str:
    """Say what keeps the name of a tag from being a column of a sheet of words, or "".

    >>> tag_fault("mood"), tag_fault("Start"), tag_fault("license")
    ('', 'a column of sheets with another meaning', 'another spelling of licence')
    """
    lower = key.lower()
    if lower in _WORD_SYNONYMS:
        return f"another spelling of {_WORD_SYNONYMS[lower]}"
    if lower in KNOWN and key not in ("performer", "licence"):
        return "a column of sheets with another meaning"
    if not key or key != key.strip() or not key.isprintable() or set(key) & set("=\"'"):
        return "no text, or outer spaces, quotes, '=' or characters that cannot be printed"
    return ""


def shown_row(cells: list[str]) -> str:
    """Return the cells of a row as a message shows them.

    >>> shown_row(["a", "b"])
    'a, b'
    """
    return cut(", ".join(cells), 400)


def read_rows(path: Path, header: str) -> Rows:
    """Read the rows of a TSV or CSV file, the header first."""
    text = _read_text(path)
    header_line = next((line for line in text.split("\n") if line.strip()), "")
    delimiter = "\t" if "\t" in header_line else (";" if header_line.count(";") else ",")
    rows = _split(path, text, delimiter)
    if not rows:
        raise SheetError(f"{path}: expected a header with {header}")
    return rows


def _read_text(path: Path) -> str:
    """Return the text of a sheet."""
    try:
        data = read_bounded(path, MAX_BYTES)
    except OSError as error:
        raise SheetError(
            f"{path}: expected a readable sheet, found: {error.strerror}. Check its name and "
            "its permissions."
        ) from None
    if data[:4] in (b"PK\3\4", b"\xd0\xcf\x11\xe0"):
        raise SheetError(f"{path}: expected text, found a workbook. Save its sheet as CSV or TSV.")
    utf_16 = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    try:
        text = data.decode("utf-16" if utf_16 else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", errors="replace")
    if "\0" in text:
        raise SheetError(f"{path}: expected text, found binary data. Save the sheet as CSV or TSV.")
    return text


def _split(path: Path, text: str, delimiter: str) -> Rows:
    """Split a text into rows of cells, none with a line break; empty lines are left out."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    rows: Rows = []
    before = 0
    try:
        for row in reader:
            if any("\n" in cell or "\r" in cell for cell in row):
                raise SheetError(
                    f"{path}:{before + 1}: expected a quote that ends in its own line, found one "
                    "that does not. Close it, or double a quote that is part of the words."
                )
            before = reader.line_num
            if any(cell.strip() for cell in row):
                rows.append((reader.line_num, row))
    except csv.Error as error:
        raise SheetError(
            f"{path}:{reader.line_num}: expected rows of cells, found: {error}."
        ) from None
    return rows


def _gather(
    path: Path,
    header: list[str],
    rows: Rows,
    read: Callable[[dict[str, str], int], tuple[str, Hashable, T]],
    join: Callable[[T, T], T],
    advice: str = "",
) -> tuple[dict[str, T], tuple[str, ...]]:
    """What rows say by capture name, and notes on repeated rows; raise all faults at once.

    `read`: Gives name, what rows that repeat it have too, and entry of the cells and line of a row.

    `join`: Joins two entries of one capture.
    """
    entries, seen = dict[str, T](), dict[Hashable, int]()
    column = header.index("file")
    spelled = {row[column].strip() for _, row in rows if len(row) > column}
    counts = Counter(capture_name(file) for file in spelled if _ending(file))
    several = {name for name, count in counts.items() if count > 1}  # names of several files
    faults, repeats = list[str](), list[str]()
    for line, row in rows:
        if len(row) > len(header):
            faults.append(
                f"{path}:{line}: expected {len(header)} columns, found {len(row)}.{advice}"
            )
            continue
        try:
            cells = {c: cell.strip() for c, cell in zip(header, row)}
            name, same, entry = read(cells, line)
            if name in several:
                name += _ending(cells["file"])
            first = seen.setdefault((name, same), line)
            if first == line:
                entries[name] = join(entries[name], entry) if name in entries else entry
            else:
                repeats.append(f"{path}:{line}: repeats line {first} and was left out")
        except ValueError as error:
            faults.append(f"{path}:{line}: {error}")
    if faults:
        raise SheetError("\n".join(_listed(faults, "faults like these.")))
    return entries, tuple(_listed(repeats, "notes like these"))


def _listed(sentences: list[str], what: str) -> list[str]:
    """Return the first hundred sentences, and how many more there are."""
    more = len(sentences) - _MAX_LISTED
    return sentences[:_MAX_LISTED] + ([f"... and {more} more {what}"] if more > 0 else [])


def _read_words(cells: dict[str, str], line: int) -> tuple[str, Hashable, SheetEntry]:
    """Turn the cells of a row into an entry."""
    file = cells.get("file", "")
    if not file:
        raise ValueError("expected a file name, found nothing. Name the file or delete the row.")
    start, end = _number(cells, "start"), _number(cells, "end")
    if start is not None and end is not None and end <= start:
        raise ValueError(
            f"expected an end after the start, found start {start:g}, end {end:g}. "
            "Times are seconds."
        )
    fps = _number(cells, "fps")
    if fps is not None and not MIN_FPS <= fps <= MAX_GIVEN_FPS:
        raise ValueError(f"expected an fps from {MIN_FPS:g} to {MAX_GIVEN_FPS:g}, found {fps:g}.")
    words = cells.get("words", "")
    captions = (Caption(words, start, end),) if words else ()
    tags = {
        c: v
        for c, v in cells.items()
        if v and c and c not in ("file", "words", "start", "end", "fps", "skeleton", "up")
    }
    up = cells.get("up", "").lower() or None
    if up and up not in UPS:
        raise ValueError(f"expected an axis up, one of {', '.join(UPS)}, found {quoted(up)}.")
    skeleton = cells.get("skeleton") or None
    entry = SheetEntry(file, line, captions, tags, fps, skeleton, up, (line,) * len(captions))
    return capture_name(file), frozenset(cells.items()), entry


_ONE = ("fps", "skeleton", "up")  # What a capture has once


def _merged(first: SheetEntry, second: SheetEntry) -> SheetEntry:
    """Merge two rows of one file: captions add up, tags are joined, all else must agree."""
    one_of = {what: (getattr(first, what), getattr(second, what)) for what in _ONE}
    one_of |= {tag: (first.tags.get(tag), second.tags.get(tag)) for tag in ("performer", "licence")}
    for what, (a, b) in one_of.items():
        if a is not None and b is not None and a != b:
            raise ValueError(
                f"expected one {what} for {shown_row([first.file])}, found {quoted(str(b))} here "
                f"and {quoted(str(a))} at line {first.line}."
            )
    tags = dict(first.tags)
    for key, value in second.tags.items():
        if value not in tags.setdefault(key, value).split("; "):
            tags[key] += f"; {value}"
    return replace(
        first,
        captions=first.captions + second.captions,
        tags=tags,
        lines=first.lines + second.lines,
        **{what: b if a is None else a for what, (a, b) in one_of.items() if what in _ONE},
    )


def _number(cells: dict[str, str], column: str) -> float | None:
    """Return the number in a column, None if the cell is empty."""
    text = cells.get(column, "")
    if not text:
        return None
    value = number(text)
    if value is None:
        raise ValueError(f"expected a number in column {column}, found {quoted(text)}.")
    if value < 0:
        raise ValueError(
            f"expected a number of at least 0 in column {column}, found {quoted(text)}."
        )
    return value


@dataclass(frozen=True)
class EventSheet:
    """A sheet of events that was read."""

    path: str
    # Events with their lines, by capture name (path without ending)
    entries: dict[str, tuple[tuple[int, Event], ...]]
    notes: tuple[str, ...] = ()  # Sentences about unusual entries that were used
    others: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # Names it may mean, too

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
    if (foreign := _foreign(path)) is not None:
        return _events_of(path, foreign)
    rows = read_rows(
        path, f"the columns file, event and frame, found an empty sheet. {_EVENT_COLUMNS}"
    )
    line, names = rows[0]
    header = [_EVENT_SYNONYMS.get(name.strip().lower(), name.strip().lower()) for name in names]
    missing = [column for column in ("file", "event") if column not in header]
    missing += ["frame or time"] if not {"frame", "time"} & set(header) else []
    if missing:
        raise SheetError(
            f"{path}:{line}: expected a column {' and '.join(missing)}, found "
            f"{shown_row(names)}. {_EVENT_COLUMNS}"
        )
    check_columns(path, line, header)
    return EventSheet(str(path), *_gather(path, header, rows[1:], _read_event, add))


def _read_event(
    cells: dict[str, str], line: int
) -> tuple[str, Hashable, tuple[tuple[int, Event], ...]]:
    """Turn the cells of a row into an event; ValueError with the fault of the row."""
    name = capture_name(_filled(cells, "file"))
    joint = cells.get("joint", "")
    if joint and joint not in body.INDEX:
        raise ValueError(
            f"expected a joint of the canonical body, found {quoted(joint)}."
            + (suggestion(joint, body.JOINTS) or f" They are {', '.join(body.JOINTS)}.")
        )
    event = Event(_frame(cells), _filled(cells, "event"), joint, cells.get("other", ""))
    return name, event, ((line, event),)


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
