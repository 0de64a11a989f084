"""Download captures and their words from the CMU Graphics Lab Motion Capture Database.

The site has ``subjects/14/14.asf``, ``subjects/14/14_02.amc``, and a page of descriptions for each
subject, ``search.php?subjectnumber=14``. The folder that :func:`fetch_cmu` fills is laid out for
``motiondb add FOLDER --words FOLDER/cmu-captions.tsv``: ``14/14.asf``, ``14/14_02.amc``, the sheet.

What the CMU database holds: its page of descriptions, and how a whole ASF or AMC file ends.

A transfer can be cut, or answered by an error page. Either would otherwise be taken for a capture.
So the ends of a file are looked at, without reading the motion. A check gives None for a whole
file, or the end of a sentence: ``expected ..., found ...``.

>>> check_amc(b"<html>Not here</html>")
'expected an AMC file, found a web page'
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from urllib.parse import urlsplit

from motiondb.errors import MotionDBError, QueryError, SheetError
from motiondb.fetch.download import (
    Check,
    Download,
    FetchLimits,
    OnBytes,
    RefusedError,
    check_limits,
    disk_fault,
    size,
)
from motiondb.files.safe_files import read_bounded, read_bounded_text, whole_file

CMU_URL = "http://mocap.cs.cmu.edu"
CMU_SHEET = "cmu-captions.tsv"
CMU_TERMS = """\
CMU Graphics Lab Motion Capture Database, http://mocap.cs.cmu.edu
The data is free for use in research, and may be included in products that are sold, but may not be
resold directly, even in converted form. Please acknowledge it in what you publish:
    The data used in this project was obtained from mocap.cs.cmu.edu.
    The database was created with funding from NSF EIA-0196217.
Please do not crawl the whole database: the site's FAQs link to one archive of all ASF and AMC
files, which `motiondb add` reads as well.
"""
COLUMNS = ("file", "skeleton", "performer", "fps", "licence", "words")
_HEADER = "\t".join(COLUMNS)


@dataclass(frozen=True)
class FetchSettings:
    """Where to download from, how long to wait, and how much to take."""

    base_url: str = CMU_URL
    """Address of the site."""
    timeout: float = 30.0
    """Seconds to wait for the next bytes of an answer."""
    attempts: int = 4
    """Largest number of consecutive attempts without new bytes."""
    limits: FetchLimits = field(default_factory=FetchLimits)
    """How much one download may take."""


@dataclass(frozen=True)
class FetchProgress:
    """How far a download is."""

    file: str  # The file that is being downloaded, its path below the folder
    number: int  # Its number, from 1
    n_files: int  # How many there are
    n_bytes: int  # Bytes of the file that are there
    total_bytes: int | None  # Number of bytes of the whole file, if the server says so


@dataclass(frozen=True)
class FetchReport:
    """The result of a download."""

    folder: Path  # Where the captures are
    sheet: Path  # The sheet of their words
    fetched: tuple[str, ...]
    skipped: tuple[str, ...]  # Files that were there and whole
    refused: tuple[tuple[str, str], ...]  # Files that could not be downloaded, with the reasons
    n_bytes: int  # Bytes of the files downloaded, with those that were resumed


def fetch_cmu(
    subjects: Iterable[int | str],
    folder: str | Path,
    settings: FetchSettings | None = None,
    *,
    on_progress: Callable[[FetchProgress], None] | None = None,
    accept_terms: bool = False,
) -> FetchReport:
    """Download all captures of some subjects, with a sheet of their words.

    If it is run again, it skips complete files, resumes incomplete ones, and keeps the rows of the
    sheet.

    Parameters
    ----------
    subjects : iterable of int or str
        Numbers as the site has them, such as 14 or "14".
    folder : str or Path
        Where the files go; made when missing.
    settings : FetchSettings or None
        Where to download from, how long to wait, and how much to take.
    on_progress : callable or None
        Told how far the download is.
    accept_terms : bool
        True once the user has seen :data:`CMU_TERMS` and agreed.

    Raises
    ------
    MotionDBError
        The terms are not accepted, a subject is unknown, no server answers, the disk is full, or
        a limit is reached. A file that is missing or damaged is listed in the report instead.
    """
    if not accept_terms:
        raise MotionDBError(
            "fetch cmu: expected the terms to be accepted, found that they are not. "
            f"Read them, then pass --yes.\n{CMU_TERMS}"
        )
    numbers = check_subjects(subjects)
    settings = settings or FetchSettings()
    folder, url, limits = Path(folder), _check_base_url(settings.base_url), settings.limits
    check_limits(limits)
    _check_count("subjects", len(numbers), limits.pages)
    sheet = folder / CMU_SHEET
    rows = read_rows(sheet)
    download = Download(settings.timeout, settings.attempts, limits)
    items = [item for number in numbers for item in _items(number, url, download)]
    _check_count("files", len(items), limits.files)
    fetched: list[str] = []
    skipped: list[str] = []
    refused: list[tuple[str, str]] = []
    trials: list[Trial] = []
    n_bytes = 0
    try:
        for number, (file, check, trial) in enumerate(items, start=1):
            path, on_bytes = folder / file, _teller(on_progress, file, number, len(items))
            if _is_whole(path, check, limits.file_bytes):
                skipped.append(file)
                on_bytes(size(path), size(path))
            else:
                try:
                    n_bytes += download.file(f"{url}/subjects/{file}", path, check, on_bytes)
                except RefusedError as error:
                    refused.append((file, str(error)))
                    continue
                fetched.append(file)
            if trial is not None:
                trials.append(trial)
    finally:
        if trials:
            write_rows(sheet, rows, trials)
    return FetchReport(folder, sheet, tuple(fetched), tuple(skipped), tuple(refused), n_bytes)


def _teller(
    on_progress: Callable[[FetchProgress], None] | None, file: str, number: int, n_files: int
) -> OnBytes:
    """Return a function that reports the bytes of one file by ``on_progress``."""

    def tell(n_bytes: int, total_bytes: int | None) -> None:
        if on_progress is not None:
            on_progress(FetchProgress(file, number, n_files, n_bytes, total_bytes))

    return tell


def check_subjects(subjects: Iterable[int | str]) -> tuple[int, ...]:
    """Subjects as numbers, each once, in the order given.

    >>> check_subjects(["14", 7, "07"])
    (14, 7)
    """
    numbers: list[int] = []
    for subject in subjects:
        text = str(subject).strip()
        if not (re.fullmatch("[0-9]{1,9}", text) and 0 < int(text) < 1000):
            raise QueryError(
                f"subjects: expected numbers such as 14, found {text[:40]!r}. "
                f"The list is at {CMU_URL}/search.php."
            )
        if int(text) not in numbers:
            numbers.append(int(text))
    if not numbers:
        raise QueryError("subjects: expected at least one number such as 14, found none.")
    return tuple(numbers)


def _check_count(what: str, count: int, most: int) -> None:
    """Refuse more subjects or files than one download may take."""
    if count > most:
        raise QueryError(
            f"{what}: expected at most {most} at once, found {count}. Fetch fewer subjects at once."
        )


def _check_base_url(base_url: str) -> str:
    """Return an address without its last slash."""
    parts = urlsplit(base_url)
    if parts.scheme not in ("http", "https") or not parts.netloc:
        raise QueryError(
            f"base URL: expected an address such as {CMU_URL}, found {base_url!r}. "
            "Begin with http:// or https://."
        )
    return base_url.rstrip("/")


def _items(
    subject: int, base_url: str, download: Download
) -> list[tuple[str, Check, Trial | None]]:
    """Files of a subject: the skeleton and the captures that its page lists, with their checks."""
    url = f"{base_url}/search.php?subjectnumber={subject}"
    page = download.page(url)
    try:
        text = page.decode("utf-8")
    except UnicodeDecodeError:
        text = page.decode("latin-1")
    trials = read_trials(text, subject)
    if not trials:
        raise QueryError(
            f"{url}: expected captures of subject {subject}, found none listed. "
            f"Existing subjects are listed at {base_url}/search.php."
        )
    captures = [(f"{trial.name}.amc", check_amc, trial) for trial in trials]
    return [(f"{subject:02d}/{subject:02d}.asf", check_asf, None), *captures]


def _is_whole(path: Path, check: Check, longest: int) -> bool:
    """Whether a file is there and passes its check."""
    try:
        return check(read_bounded(path, longest)) is None
    except OSError:
        return False


def caption_row(trial: Trial) -> str:
    r"""Row of a trial, without control characters.

    >>> caption_row(Trial(7, 1, 'a "slow" walk', 120)).split("\t")
    ['07/07_01.amc', '07/07.asf', '07', '120', 'CMU', "a 'slow' walk"]
    """
    performer = f"{trial.subject:02d}"
    words = " ".join(trial.words.replace('"', "'").split())
    words = "".join(letter for letter in words if letter.isprintable())
    fps = "" if trial.fps is None else str(trial.fps)
    fields = (f"{trial.name}.amc", f"{performer}/{performer}.asf", performer, fps, "CMU", words)
    return "\t".join(fields)


def read_rows(sheet: Path) -> list[str]:
    """The rows of a sheet, which the user may have edited; none when there is no sheet."""
    if not sheet.exists():
        return []
    try:
        lines = read_bounded_text(sheet).splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "another encoding"
        raise SheetError(
            f"{sheet}: expected a sheet in UTF-8, found: {reason}. Move it away, or fetch to "
            "another folder."
        ) from None
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
    text = "\n".join([_HEADER, *sorted(rows, key=_file)]) + "\n"
    try:
        with whole_file(sheet) as draft:
            draft.write_bytes(text.encode())
    except OSError as error:
        raise disk_fault(sheet, error) from None


def _file(row: str) -> str:
    return row.split("\t", 1)[0]


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
