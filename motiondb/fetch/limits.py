"""How long a download may wait, how much it may take, and how it fails."""

from __future__ import annotations

import errno
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from motiondb.errors import MotionDBError, QueryError


class RefusedError(MotionDBError):
    """One file that cannot be downloaded, while others may."""


class NotFoundError(RefusedError):
    """A file that the server does not have."""


class TooLongError(RefusedError):
    """A file that is longer than a file may be."""


class UnreachableError(MotionDBError):
    """No server answers, the disk is full, or a limit is reached: no further file can be had."""


@dataclass(frozen=True)
class Patience:
    """How long to wait for a server."""

    timeout: float = 30.0  # Seconds to wait for the next bytes of an answer. Chosen by hand
    attempts: int = 4  # Largest number of consecutive attempts without new bytes. Chosen by hand
    pause: Callable[[float], None] = time.sleep  # Waits for so many seconds


@dataclass(frozen=True)
class FetchLimits:
    """Limits of one download; real downloads of subjects are far smaller.

    Attributes
    ----------
    seconds : float
        From beginning to end. The default is six hours: all 2,500 captures at 1 Mbit a second
        would take longer, and should come as the site's one archive.
    pages : int
        Pages of descriptions, one for each subject. The site has 144 subjects.
    files : int
        Files of all subjects together. The site has about 2,700.
    page_bytes : int
        Of one page. The longest of the site's has 0.1 MB.
    file_bytes : int
        Of one file. The longest of the site's has 25 MB.
    total_bytes : int
        Of everything. The site's captures have 4 GB.
    """

    seconds: float = 6 * 3600.0
    pages: int = 200
    files: int = 5000
    page_bytes: int = 10_000_000
    file_bytes: int = 500_000_000
    total_bytes: int = 20_000_000_000


def check_limits(limits: FetchLimits) -> None:
    """Refuse limits that are no numbers above 0."""
    for name, value in vars(limits).items():
        if not (value > 0 and value < float("inf")):
            raise QueryError(f"{name}: expected a number above 0, found {value!r}.")


@dataclass
class Budget:
    """The share of the limits that one download has used."""

    limits: FetchLimits  # What it may take
    clock: Callable[[], float] = time.monotonic  # Gives seconds that only rise
    n_bytes: int = 0  # Bytes that came so far, of pages and files
    began: float = field(init=False)

    def __post_init__(self) -> None:
        self.began = self.clock()

    def seconds_left(self) -> float:
        """Seconds until the download must be done."""
        return self.limits.seconds - (self.clock() - self.began)

    def spend(self, url: str, n_bytes: int) -> None:
        """Count bytes that came."""
        self.n_bytes += n_bytes
        if self.seconds_left() <= 0.0:
            raise UnreachableError(
                f"{url}: expected to be done within {self.limits.seconds:g} s, found more to fetch."
                " Run the same command again to continue, or allow more time with --deadline; "
                "downloaded files are kept."
            )
        if self.n_bytes > self.limits.total_bytes:
            raise UnreachableError(
                f"{url}: expected at most {self.limits.total_bytes} bytes in all, found more. "
                "Fetch fewer subjects at once; downloaded files are kept."
            )

    @staticmethod
    def check_size(url: str, n_bytes: int, most: int) -> None:
        """Refuse a page or a file that is longer than it may be."""
        if n_bytes > most:
            raise TooLongError(
                f"{url}: expected at most {most} bytes, found {n_bytes} or more. "
                "Captures are not that large; it was not kept."
            )


def disk_fault(path: Path, error: OSError) -> UnreachableError:
    """Return why a file or folder cannot be written, and what to do."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return UnreachableError(
            f"{path}: expected room on the disk, found it full. "
            "Make room and run the same command again; downloaded files are kept."
        )
    return UnreachableError(
        f"{path}: expected a file that can be written, found: {error.strerror}. "
        "Choose another folder with --dir."
    )
