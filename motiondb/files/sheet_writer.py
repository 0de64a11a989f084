"""Write a sheet of words that :func:`motiondb.files.sheets.read_sheet` reads without loss."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from motiondb.files.folder import CAPTURE_ENDINGS
from motiondb.files.safe_files import write_bytes
from motiondb.files.sheets import capture_name, tag_fault
from motiondb.files.text import csv_bytes
from motiondb.records import Caption

_FORMULA = tuple("=+-@|\t\r\uff1d\uff0b\uff0d\uff20")  # The last four are wide letters
FIRST_COLUMNS = ("file", "words", "start", "end", "performer", "licence")


def write_sheet(
    path: Path, rows: Sequence[tuple[str, Sequence[Caption], Mapping[str, str]]]
) -> list[str]:
    """Write names, captions and tags of captures; what a sheet cannot hold, as sentences."""
    delimiter = "," if path.suffix.lower() == ".csv" else "\t"
    notes: list[str] = []
    keys = {key for _, _, tags in rows for key, value in tags.items() if value}
    wrong = {key for key in keys if tag_fault(key) or (delimiter == "," and ";" in key)}
    notes += [f"the tag {key!r} is left out: a sheet has no such column" for key in sorted(wrong)]
    columns = [*FIRST_COLUMNS, *sorted(keys - wrong - set(FIRST_COLUMNS))]
    lines = [dict(zip(columns, columns))]
    for name, captions, tags in rows:
        kept = {key: _cell(name, value, notes) for key, value in tags.items() if key in columns}
        spoken = [_words(name, caption, notes) for caption in captions]
        different = [cells for cells in dict.fromkeys(map(tuple, spoken)) if cells[0]]
        if len(different) < len(spoken):
            notes.append(f"{name}: captions that repeat another, or have no words, are left out")
        for row, (words, start, end) in enumerate(different or [("", "", "")]):
            told = {"file": _file(name), "words": words, "start": start, "end": end}
            lines.append({**(kept if row == 0 else {}), **told})
    formulas = sum(plain_cell(cell) != cell for line in lines for cell in line.values())
    if formulas:
        notes.append(
            f"{formulas} cell{'s begin' if formulas > 1 else ' begins'} like a formula: in a "
            "spreadsheet, import the columns as text"
        )
    cells = ([line.get(column, "") for column in columns] for line in lines)
    write_bytes(path, csv_bytes(cells, delimiter))
    return notes


def plain_cell(cell: str) -> str:
    """Put an apostrophe before a cell that a spreadsheet would take for a formula.

    >>> plain_cell("=1+1"), plain_cell("-0.5"), plain_cell("walk")
    ("'=1+1", '-0.5', 'walk')

    Parameters
    ----------
    cell : str
        The cell of a table that no program reads back.
    """
    if not cell.startswith(_FORMULA) or cell == "-":  # which stands for what is not known
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def write_table(path: str | Path, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Write a table: CSV for the ending .csv, else TSV; formulas become text (`plain_cell`).

    Parameters
    ----------
    path : str or Path
        The file; it appears whole or not at all.
    columns : sequence of str
        The header.
    rows : iterable of sequences of str
        The cells of every row.

    Raises
    ------
    MotionDBError
        When the file cannot be written.
    """
    path = Path(path)
    delimiter = "," if path.suffix.lower() == ".csv" else "\t"
    cells = ([plain_cell(cell) for cell in row] for row in (columns, *rows))
    write_bytes(path, csv_bytes(cells, delimiter))


def _words(name: str, caption: Caption, notes: list[str]) -> list[str]:
    """The cells of a caption: words, start, end."""
    times = ["" if t is None else repr(float(t)) for t in (caption.start, caption.end)]
    return [_cell(name, caption.words, notes), *times]


def _file(name: str) -> str:
    """How a sheet names a capture: by its name, with an ending where the name would lose one.

    >>> _file("ana/walk_1"), _file("take.bvh")
    ('ana/walk_1', 'take.bvh.bvh')
    """
    return name if capture_name(name) == name else name + CAPTURE_ENDINGS[0]


def _cell(name: str, text: str, notes: list[str]) -> str:
    """A text as a cell can hold it; a note where it had to be changed."""
    cell = text.replace("\r", " ").replace("\n", " ").replace("\0", "").strip()
    if cell != text:
        notes.append(f"{name}: {cell[:60]!r} is written without its line breaks and outer spaces")
    return cell
