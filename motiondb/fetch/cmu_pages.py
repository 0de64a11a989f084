"""The trials of a subject and their descriptions, from the search page of the CMU database.

``search.php?subjectnumber=14`` is a table with a row a trial: an empty cell, the trial's number,
its description, links to the files (tvd, c3d, amc, mpg, avi), the frame rate and a feedback link.
The markup is old (upper case, cells without end tags), so rows are separated only by their
``<tr>``, and a trial is a row that links to an AMC file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

_AMC_LINK = re.compile(r"(?:^|/)0{0,3}([0-9]{1,3})_0{0,3}([0-9]{1,3})\.amc$", re.IGNORECASE)
_NUMBER = re.compile(r"[0-9]{1,4}")
_FASTEST = 2000
"""Frames a second that no optical system of the site reaches; a larger number is not believed."""
_LONGEST_WORDS = 1000  # Letters of a description; the site's longest has 100


@dataclass(frozen=True)
class Trial:
    """A capture that the page lists; ``fps`` is None if the page names no frame rate."""

    subject: int
    number: int
    words: str
    fps: int | None

    @property
    def name(self) -> str:
        """Path of the capture below the folder of subjects, without its ending."""
        return f"{self.subject:02d}/{self.subject:02d}_{self.number:02d}"


@dataclass
class _Row:
    cells: list[str] = field(default_factory=list)
    links: list[str] = field(default_factory=list)


class _RowReader(HTMLParser):
    """Rows of all tables of a page, each as the texts of its cells and the targets of its links."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.rows: list[_Row] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Open a row or a cell, or note a link."""
        if tag == "tr":
            self.rows.append(_Row())
        elif self.rows and tag in ("td", "th"):
            self.rows[-1].cells.append("")
        elif self.rows and tag == "a":
            self.rows[-1].links.append(dict(attrs).get("href") or "")

    def handle_data(self, data: str) -> None:
        """Add text to the open cell."""
        if self.rows and self.rows[-1].cells:
            self.rows[-1].cells[-1] += data


def read_trials(page: str, subject: int) -> tuple[Trial, ...]:
    """The trials of one subject on a search page, by number; none when the page lists none.

    >>> row = '<TR><TD></TD><TD>3</TD><TD>run/jog</TD><TD><A HREF="/subjects/16/16_03.amc">amc'
    >>> read_trials(row + '</A></TD><TD>120</TD></TR>', 16)
    (Trial(subject=16, number=3, words='run/jog', fps=120),)
    """
    reader = _RowReader()
    reader.feed(page)
    reader.close()
    trials = (_trial(row, subject) for row in reader.rows)
    trial_of = {trial.number: trial for trial in trials if trial is not None}
    return tuple(trial_of[number] for number in sorted(trial_of))


def _trial(row: _Row, subject: int) -> Trial | None:
    matches = [match for link in row.links if (match := _AMC_LINK.search(link))]
    if not matches or int(matches[0][1]) != subject:
        return None
    number = int(matches[0][2])
    cells = [" ".join(cell.split()) for cell in row.cells]
    at = next((n for n, cell in enumerate(cells) if _number(cell) == number), None)
    if at is None or at + 1 >= len(cells):
        return Trial(subject, number, "", None)
    rates = [rate for cell in cells[at + 2 :] if 0 < (rate := _number(cell)) <= _FASTEST]
    return Trial(subject, number, cells[at + 1][:_LONGEST_WORDS], rates[-1] if rates else None)


def _number(cell: str) -> int:
    """The number of a cell; -1 where it is none of up to four digits."""
    return int(cell) if _NUMBER.fullmatch(cell) else -1
