"""What the CMU database holds: its page of descriptions, and how a whole ASF or AMC file ends.

A transfer can be cut, or answered by an error page. Either would otherwise be taken for a capture.
So the ends of a file are looked at, without reading the motion. A check gives None for a whole
file, or the end of a sentence: ``expected ..., found ...``.

>>> check_amc(b"<html>Not here</html>")
'expected an AMC file, found a web page'
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser
from itertools import pairwise

_FRAME = re.compile(rb"^[ \t]*0{0,9}([0-9]{1,9})[ \t\r]*$", re.MULTILINE)
_ASF_SECTIONS = (b":root", b":bonedata", b":hierarchy")
_AMC_LINK = re.compile(r"(?:^|/)0{0,3}([0-9]{1,3})_0{0,3}([0-9]{1,3})\.amc$", re.IGNORECASE)
_NUMBER = re.compile(r"[0-9]{1,4}")
_FASTEST = 2000  # Frames a second that no optical system reaches; more is not believed
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
    """The trials of one subject on its search page, by number; none when the page lists none.

    The page is a table with a row a trial: an empty cell, the trial's number, its description,
    links to the files (tvd, c3d, amc, mpg, avi), the frame rate and a feedback link. The markup is
    old (upper case, cells without end tags), so rows are separated only by their ``<tr>``, and a
    trial is a row that links to an AMC file.

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


def check_amc(data: bytes) -> str | None:
    """The fault of an AMC file, or None: frames are numbered, and the last is as the first."""
    fault = _wrong_kind(data, "an AMC file", (b"#", b":"))
    if fault:
        return fault
    frames = list(_FRAME.finditer(data))
    if not frames:
        return "expected frames after the header, found none"
    numbers = [int(frame[1]) for frame in frames]
    for before, after in pairwise(numbers):
        if after != before + 1:
            return f"expected frame {before + 1} after frame {before}, found frame {after}"
    first_end = frames[1].start() if len(frames) > 1 else len(data)
    first = _bone_sizes(data[frames[0].end() : first_end])
    last = _bone_sizes(data[frames[-1].end() :])
    if not first or last != first:
        place = f"in the last frame (number {numbers[-1]})"
        return f"expected {_amount(first)} {place}, found {_amount(last)}"
    if not data.endswith((b"\n", b"\r")):
        return "expected a line end at the end of the file, found a line cut short"
    return None


def check_asf(data: bytes) -> str | None:
    """The fault of an ASF file, or None: it has its sections, and an ``end`` for each ``begin``."""
    fault = _wrong_kind(data, "an ASF file", (b"#", b":"))
    if fault:
        return fault
    for section in _ASF_SECTIONS:
        if not re.search(rb"^[ \t]*" + section, data, re.MULTILINE):
            return f"expected a section {section.decode()}, found none"
    words = data.split()
    opened, closed = words.count(b"begin"), words.count(b"end")
    if opened != closed or words[-1] != b"end":
        return f"expected an end for each of {opened} begin, found {closed} end"
    return None


def _wrong_kind(data: bytes, kind: str, starts: tuple[bytes, ...]) -> str | None:
    """Return the fault of bytes that do not begin as a kind of file does, or None."""
    text = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if not text:
        return f"expected {kind}, found an empty file"
    if text.startswith(b"<"):
        return f"expected {kind}, found a web page"
    if not text.startswith(starts):
        return f"expected {kind}, found something else"
    return None


def _bone_sizes(frame: bytes) -> list[tuple[bytes, int]]:
    """Names of the bones of a frame, each with its number of values."""
    rows = (line.split() for line in frame.splitlines())
    return [(row[0], len(row) - 1) for row in rows if row]


def _amount(bones: list[tuple[bytes, int]]) -> str:
    return f"{len(bones)} bones with {sum(size for _, size in bones)} values"
