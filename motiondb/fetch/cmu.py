"""Download captures and their words from the CMU Graphics Lab Motion Capture Database.

The site has ``subjects/14/14.asf``, ``subjects/14/14_02.amc``, and a page of descriptions for each
subject, ``search.php?subjectnumber=14``. The folder that :func:`fetch_cmu` fills is laid out for
``motiondb add FOLDER --words FOLDER/cmu-captions.tsv``: ``14/14.asf``, ``14/14_02.amc``, the sheet.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from motiondb.errors import MotionDBError, QueryError, SheetError
from motiondb.fetch.cmu_files import Trial, check_amc, check_asf, read_trials
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
