"""Sheets of words: TSV or CSV with a header, one or more rows a capture.

Columns: ``file`` (path below the added folder, with or without its ending) and any of ``words``,
``start``, ``end`` (seconds: the row's words describe this part), ``performer``, ``fps``,
``licence``, ``skeleton``; every further column is kept as a tag. What a sheet says overrides the
file's header.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from motiondb.capture.formats import CAPTURE_ENDINGS
from motiondb.errors import SheetError, suggestion
from motiondb.records import Caption

KNOWN = ("file", "words", "start", "end", "performer", "fps", "licence", "skeleton")
_KNOWN = ", ".join(KNOWN)
_SYNONYMS = {"license": "licence", "subject": "performer", "caption": "words", "start_s": "start",
             "end_s": "end", "filename": "file"}  # fmt: skip


@dataclass(frozen=True)
class SheetEntry:
    """What a sheet says of one capture; ``line`` is where it is first named."""

    file: str
    line: int
    captions: tuple[Caption, ...] = ()
    tags: dict[str, str] = field(default_factory=dict)
    fps: float | None = None
    skeleton: str | None = None


@dataclass(frozen=True)
class Sheet:
    """A sheet's entries by capture name (path without ending), and what was odd about it."""

    path: str
    entries: dict[str, SheetEntry]
    notes: tuple[str, ...] = ()

    def find(self, name: str) -> SheetEntry | None:
        """The entry of a capture by its name."""
        return self.entries.get(name)

    def unknown(self, names: Iterable[str]) -> list[str]:
        """A sentence for every entry whose file is not among the captures."""
        known = set(names)
        return [
            f"{self.path}:{entry.line}: expected a capture of the added folder, found "
            f"{entry.file!r}.{suggestion(name, known)} Correct the file column."
            for name, entry in self.entries.items()
            if name not in known
        ]


def capture_name(file: str) -> str:
    """A file's path below its folder without its ending, with forward slashes.

    >>> capture_name("16/16_01.amc"), capture_name("a.b/take 1.bvh")
    ('16/16_01', 'a.b/take 1')
    """
    path = PurePosixPath(file.strip().replace("\\", "/"))
    return str(path.with_suffix("")) if path.suffix.lower() in CAPTURE_ENDINGS else str(path)


def read_sheet(path: Path | str) -> Sheet:
    """Read a sheet.

    Raises
    ------
    SheetError
        with all faults at once: no header, no ``file`` column, numbers that are none, intervals
        that end before they start, contradicting values for one file.
    """
    path = Path(path)
    rows = read_rows(path, f"a column `file`, found an empty sheet. Known columns: {_KNOWN}.")
    header_number, names = rows[0]
    header = [_SYNONYMS.get(c.strip().lower(), c.strip()) for c in names]
    header = [c.lower() if c.lower() in KNOWN else c for c in header]
    if "file" not in header:
        raise SheetError(
            f"{path}:{header_number}: expected a column `file`, found {', '.join(header)}. "
            f"Known columns: {_KNOWN}; others are kept as tags."
        )
    return _gather(path, header, rows[1:])


def read_rows(path: Path, header: str) -> list[tuple[int, list[str]]]:
    """Line numbers and cells of a TSV or CSV file, the header first, empty lines left out.

    Raises
    ------
    SheetError : the file cannot be read, holds nothing (``header`` tells what was expected of the
        first line, and what to do), or a quote does not end in its line.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise SheetError(f"{path}: expected a readable sheet, found {error.strerror}.") from None
    except UnicodeDecodeError:
        text = path.read_bytes().decode("cp1252", errors="replace")
    if not text.strip():
        raise SheetError(f"{path}: expected a header with {header}")
    header_line = next(line for line in text.split("\n") if line.strip())
    delimiter = "\t" if "\t" in header_line else (";" if header_line.count(";") else ",")
    return _split(path, text, delimiter)


def _split(path: Path, text: str, delimiter: str) -> list[tuple[int, list[str]]]:
    """Lines of the file and their cells, empty lines left out; a cell never holds a line break, so
    that no quote swallows the rows below."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    rows: list[tuple[int, list[str]]] = []
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


def _gather(path: Path, header: list[str], rows: list[tuple[int, list[str]]]) -> Sheet:
    entries: dict[str, SheetEntry] = {}
    faults: list[str] = []
    notes: list[str] = []
    seen: dict[tuple[str, ...], int] = {}
    for line, row in rows:
        if len(row) > len(header):
            faults.append(
                f"{path}:{line}: expected {len(header)} columns, found {len(row)}. "
                "Put text with separators in quotes."
            )
            continue
        cells = {c: v.strip() for c, v in zip(header, row)}
        key = tuple(sorted(cells.values()))
        if key in seen:
            notes.append(f"{path}:{line}: repeats line {seen[key]} and was left out")
            continue
        seen[key] = line
        try:
            entry = _entry(cells, line)
            name = capture_name(entry.file)
            entries[name] = _merged(entries[name], entry) if name in entries else entry
        except ValueError as error:
            faults.append(f"{path}:{line}: {error}")
    if faults:
        raise SheetError("\n".join(faults))
    return Sheet(str(path), entries, tuple(notes))


def _entry(cells: dict[str, str], line: int) -> SheetEntry:
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
    if fps is not None and not 1.0 <= fps <= 10_000.0:
        raise ValueError(f"expected an fps from 1 to 10000, found {fps:g}.")
    words = cells.get("words", "")
    captions = (Caption(words, start, end),) if words else ()
    tags = {
        c: v
        for c, v in cells.items()
        if v and c and c not in ("file", "words", "start", "end", "fps", "skeleton")
    }
    return SheetEntry(file, line, captions, tags, fps, cells.get("skeleton") or None)


def _merged(first: SheetEntry, second: SheetEntry) -> SheetEntry:
    """Rows of one file: captions add up, everything else must agree or differ by interval."""
    for what in ("fps", "skeleton"):
        a, b = getattr(first, what), getattr(second, what)
        if a is not None and b is not None and a != b:
            raise ValueError(
                f"expected one {what} for {first.file}, found {b} here and {a} at line "
                f"{first.line}."
            )
    tags = dict(first.tags)
    for key, value in second.tags.items():
        if key in ("performer", "licence") and tags.get(key, value) != value:
            raise ValueError(
                f"expected one {key} for {first.file}, found {value!r} here and {tags[key]!r} "
                f"at line {first.line}."
            )
        if value not in tags.get(key, value).split("; "):
            tags[key] = f"{tags[key]}; {value}"
        else:
            tags.setdefault(key, value)
    return SheetEntry(
        first.file,
        first.line,
        first.captions + second.captions,
        tags,
        first.fps if first.fps is not None else second.fps,
        first.skeleton or second.skeleton,
    )


def _number(cells: dict[str, str], column: str) -> float | None:
    text = cells.get(column, "")
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"expected a number in column {column}, found {text!r}.") from None
    if not value >= 0 or value == float("inf"):
        raise ValueError(f"expected a number of at least 0 in column {column}, found {text!r}.")
    return value
