"""Download captures and their words from the CMU Graphics Lab Motion Capture Database.

The site's layout: ``subjects/14/14.asf``, ``subjects/14/14_02.amc``, and a page of descriptions for
a subject, ``search.php?subjectnumber=14``. The folder that :func:`fetch_cmu` fills is laid out for
``motiondb add FOLDER --words FOLDER/cmu-captions.tsv``: ``14/14.asf``, ``14/14_02.amc``, the sheet.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import urlsplit

from motiondb.errors import MotionDBError, QueryError
from motiondb.fetch.captions import read_rows, write_rows
from motiondb.fetch.checks import check_amc, check_asf
from motiondb.fetch.cmu_pages import Trial, read_trials
from motiondb.fetch.limits import Budget, FetchLimits, Patience, RefusedError, check_limits
from motiondb.fetch.transfer import Check, fetch_file, fetch_page, make_folder

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
    # File and reason for every file that could not be downloaded
    refused: tuple[tuple[str, str], ...]
    n_bytes: int  # Bytes of the files downloaded, with those that were resumed


@dataclass(frozen=True)
class FetchSettings:
    """Where to download from, how long to wait, and how much to take.

    Attributes
    ----------
    base_url : str
        Address of the site.
    patience : Patience
        How long to wait for answers.
    limits : FetchLimits
        How much one download may take.
    """

    base_url: str = CMU_URL
    patience: Patience = field(default_factory=Patience)
    limits: FetchLimits = field(default_factory=FetchLimits)


@dataclass(frozen=True)
class _Item:
    """A file to download: its path below the folder, its check, and its description on the site."""

    file: str
    check: Check
    trial: Trial | None = None


@dataclass
class _Download:
    """A download that is running; ``trials`` are those whose capture is there and whole."""

    folder: Path
    settings: FetchSettings
    budget: Budget
    fetched: list[str] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    n_bytes: int = 0


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
    settings = replace(settings, base_url=_check_base_url(settings.base_url))
    check_limits(settings.limits)
    _check_count("subjects", len(numbers), settings.limits.pages)
    download = _Download(Path(folder), settings, Budget(settings.limits))
    sheet = download.folder / CMU_SHEET
    rows = read_rows(sheet)
    items = [item for number in numbers for item in _items(number, download)]
    _check_count("files", len(items), settings.limits.files)
    try:
        for number, item in enumerate(items, start=1):
            _fetch_item(item, download, _teller(on_progress, item.file, number, len(items)))
    finally:
        if download.trials:
            write_rows(sheet, rows, download.trials)
    return FetchReport(
        download.folder,
        sheet,
        tuple(download.fetched),
        tuple(download.skipped),
        tuple(download.refused),
        download.n_bytes,
    )


def _teller(
    on_progress: Callable[[FetchProgress], None] | None, file: str, number: int, n_files: int
) -> Callable[[int, int | None], None]:
    """Tell of a file's bytes by ``on_progress``."""

    def tell(n_bytes: int, total_bytes: int | None) -> None:
        if on_progress is not None:
            on_progress(FetchProgress(file, number, n_files, n_bytes, total_bytes))

    return tell


def _check_count(what: str, count: int, most: int) -> None:
    if count > most:
        raise QueryError(
            f"{what}: expected at most {most} at once, found {count}. Fetch fewer subjects at once."
        )


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


def _check_base_url(base_url: str) -> str:
    parts = urlsplit(base_url)
    if parts.scheme not in ("http", "https") or not parts.netloc:
        raise QueryError(
            f"base URL: expected an address such as {CMU_URL}, found {base_url!r}. "
            "Begin with http:// or https://."
        )
    return base_url.rstrip("/")


def _items(subject: int, download: _Download) -> list[_Item]:
    """The skeleton and the captures of one subject, from its page."""
    base_url = download.settings.base_url
    url = f"{base_url}/search.php?subjectnumber={subject}"
    page = fetch_page(url, download.settings.patience, download.budget)
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
    skeleton = _Item(f"{subject:02d}/{subject:02d}.asf", check_asf)
    return [skeleton, *(_Item(f"{trial.name}.amc", check_amc, trial) for trial in trials)]


def _fetch_item(
    item: _Item, download: _Download, on_bytes: Callable[[int, int | None], None]
) -> None:
    """Download one file unless it is there, and note which it was."""
    path, settings = download.folder / item.file, download.settings
    if _is_whole(path, item.check, settings.limits.file_bytes):
        download.skipped.append(item.file)
        on_bytes(path.stat().st_size, path.stat().st_size)
    else:
        try:
            make_folder(path.parent)
            url = f"{settings.base_url}/subjects/{item.file}"
            download.n_bytes += fetch_file(
                url, path, item.check, settings.patience, download.budget, on_bytes
            )
        except RefusedError as error:
            download.refused.append((item.file, str(error)))
            return
        download.fetched.append(item.file)
    if item.trial is not None:
        download.trials.append(item.trial)


def _is_whole(path: Path, check: Check, longest: int) -> bool:
    return path.is_file() and path.stat().st_size <= longest and check(path.read_bytes()) is None
