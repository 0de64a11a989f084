"""Captures and their words from the CMU Graphics Lab Motion Capture Database.

The site's layout: ``subjects/14/14.asf``, ``subjects/14/14_02.amc``, and a page of descriptions for
a subject, ``search.php?subjectnumber=14``. The folder that :func:`fetch_cmu` fills is laid out for
``motiondb add FOLDER --words FOLDER/cmu-captions.tsv``: ``14/14.asf``, ``14/14_02.amc``, the sheet.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from motiondb.errors import MotionDBError, QueryError
from motiondb.fetch.captions import read_rows, write_rows
from motiondb.fetch.checks import check_amc, check_asf
from motiondb.fetch.cmu_pages import Trial, read_trials
from motiondb.fetch.transfer import (
    Check,
    Patience,
    RefusedError,
    fetch_file,
    fetch_page,
    make_folder,
)

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
    """Where a fetch stands: the file of ``n_files``, its number from 1, and its bytes."""

    file: str
    number: int
    n_files: int
    n_bytes: int
    total_bytes: int | None


@dataclass(frozen=True)
class FetchReport:
    """What a fetch brought.

    Attributes
    ----------
    folder, sheet : where the captures and the sheet of words are.
    fetched, skipped : files downloaded now, and files that were there and whole.
    refused : (file, reason) for every file that could not be had.
    n_bytes : downloaded, including what was resumed.
    """

    folder: Path
    sheet: Path
    fetched: tuple[str, ...]
    skipped: tuple[str, ...]
    refused: tuple[tuple[str, str], ...]
    n_bytes: int


@dataclass(frozen=True)
class _Item:
    """A file to have: its path below the folder, its check, and what its page says."""

    file: str
    check: Check
    trial: Trial | None = None


@dataclass
class _Tally:
    """What has happened so far; ``trials`` are those whose capture is there and whole."""

    fetched: list[str] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    n_bytes: int = 0


def fetch_cmu(
    subjects: Iterable[int | str],
    folder: str | Path,
    *,
    base_url: str = CMU_URL,
    on_progress: Callable[[FetchProgress], None] | None = None,
    accept_terms: bool = False,
    patience: Patience | None = None,
) -> FetchReport:
    """Download all captures of some subjects, with a sheet of their words.

    Run again, it skips what is whole, resumes what is not, and keeps the rows of the sheet.

    Parameters
    ----------
    subjects : numbers as the site has them, such as 14 or "14".
    folder : made when missing.
    accept_terms : True once the user has seen :data:`CMU_TERMS` and agreed.

    Raises
    ------
    MotionDBError
        when the terms are not accepted, a subject is unknown, no server answers or the disk is
        full. A single file that is missing or damaged is listed in the report instead.
    """
    if not accept_terms:
        raise MotionDBError(
            "fetch cmu: expected the terms to be accepted, found that they are not. "
            f"Read them, then pass --yes.\n{CMU_TERMS}"
        )
    numbers = check_subjects(subjects)
    base_url = _check_base_url(base_url)
    patience = patience or Patience()
    folder = Path(folder)
    sheet = folder / CMU_SHEET
    rows = read_rows(sheet)
    items = [item for number in numbers for item in _items(base_url, number, patience)]
    tally = _Tally()
    try:
        for number, item in enumerate(items, start=1):

            def tell(n: int, total: int | None, file: str = item.file, at: int = number) -> None:
                if on_progress is not None:
                    on_progress(FetchProgress(file, at, len(items), n, total))

            _fetch_item(item, folder, base_url, patience, tell, tally)
    finally:
        if tally.trials:
            write_rows(sheet, rows, tally.trials)
    return FetchReport(
        folder,
        sheet,
        tuple(tally.fetched),
        tuple(tally.skipped),
        tuple(tally.refused),
        tally.n_bytes,
    )


def check_subjects(subjects: Iterable[int | str]) -> tuple[int, ...]:
    """Subjects as numbers, each once, in the order given.

    >>> check_subjects(["14", 7, "07"])
    (14, 7)

    Raises
    ------
    QueryError
        for none, or for something that is no number from 1 to 999.
    """
    numbers: list[int] = []
    for subject in subjects:
        text = str(subject).strip()
        if not (text.isascii() and text.isdigit() and 0 < int(text) < 1000):
            raise QueryError(
                f"subjects: expected numbers such as 14, found {text!r}. "
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


def _items(base_url: str, subject: int, patience: Patience) -> list[_Item]:
    """The skeleton and the captures of one subject, from its page."""
    url = f"{base_url}/search.php?subjectnumber={subject}"
    page = fetch_page(url, patience)
    try:
        text = page.decode("utf-8")
    except UnicodeDecodeError:
        text = page.decode("latin-1")
    trials = read_trials(text, subject)
    if not trials:
        raise QueryError(
            f"{url}: expected captures of subject {subject}, found none listed. "
            f"The subjects there are, are listed at {base_url}/search.php."
        )
    skeleton = _Item(f"{subject:02d}/{subject:02d}.asf", check_asf)
    return [skeleton, *(_Item(f"{trial.name}.amc", check_amc, trial) for trial in trials)]


def _fetch_item(
    item: _Item,
    folder: Path,
    base_url: str,
    patience: Patience,
    on_bytes: Callable[[int, int | None], None],
    tally: _Tally,
) -> None:
    """Have one file, and note in the tally how."""
    path = folder / item.file
    if path.is_file() and item.check(path.read_bytes()) is None:
        tally.skipped.append(item.file)
        on_bytes(path.stat().st_size, path.stat().st_size)
    else:
        try:
            make_folder(path.parent)
            url = f"{base_url}/subjects/{item.file}"
            tally.n_bytes += fetch_file(url, path, item.check, patience, on_bytes)
        except RefusedError as error:
            tally.refused.append((item.file, str(error)))
            return
        tally.fetched.append(item.file)
    if item.trial is not None:
        tally.trials.append(item.trial)
