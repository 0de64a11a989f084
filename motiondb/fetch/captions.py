"""The sheet of words of fetched captures, which the user may have edited.

Tab-separated with a header, UTF-8, one row a caption. Rows that are there are never changed: only
captures without a row get one. Double quotes inside words become single ones, because readers of
sheets disagree about them.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from motiondb.errors import SheetError
from motiondb.fetch.cmu_pages import Trial
from motiondb.fetch.limits import disk_fault

COLUMNS = ("file", "skeleton", "performer", "fps", "licence", "words")
_HEADER = "\t".join(COLUMNS)
_LICENCE = "CMU"


def caption_row(trial: Trial) -> str:
    r"""Row of a trial, without control characters.

    >>> caption_row(Trial(7, 1, 'a "slow" walk', 120)).split("\t")
    ['07/07_01.amc', '07/07.asf', '07', '120', 'CMU', "a 'slow' walk"]
    """
    performer = f"{trial.subject:02d}"
    words = " ".join(trial.words.replace('"', "'").split())
    words = "".join(letter for letter in words if letter.isprintable())
    fps = "" if trial.fps is None else str(trial.fps)
    fields = (f"{trial.name}.amc", f"{performer}/{performer}.asf", performer, fps, _LICENCE, words)
    return "\t".join(fields)


def read_rows(sheet: Path) -> list[str]:
    """The rows of a sheet, without its header; none when there is no sheet."""
    if not sheet.exists():
        return []
    lines = sheet.read_text(encoding="utf-8-sig").splitlines()
    if not lines:
        return []
    if lines[0] != _HEADER:
        raise SheetError(
            f"{sheet}:1: expected the columns {', '.join(COLUMNS)}, "
            f"found {', '.join(lines[0].split(chr(9)))}. Move this file away, or fetch to another "
            "folder."
        )
    return [line for line in lines[1:] if line.strip()]


def write_rows(sheet: Path, rows: Iterable[str], trials: Iterable[Trial]) -> None:
    """Write a sheet with its old rows and a row for every trial that has none, ordered by file."""
    rows = list(rows)
    known = {_file(row) for row in rows}
    rows += [row for row in map(caption_row, trials) if _file(row) not in known]
    draft = sheet.with_name(sheet.name + ".part")
    text = "\n".join([_HEADER, *sorted(rows, key=_file)]) + "\n"
    try:
        draft.write_text(text, encoding="utf-8", newline="\n")
        draft.replace(sheet)
    except OSError as error:
        raise disk_fault(sheet, error) from None


def _file(row: str) -> str:
    return row.split("\t", 1)[0]
