"""Download files over HTTP: resume, check the content, then rename the file to its final name.

A file grows as ``NAME.part``. It is renamed when it has the length that the server announced and
its contents pass a check, so that an interruption at any moment leaves nothing half written under a
final name. The next attempt asks for the missing bytes (``Range``, RFC 9110, section 14); a server
that sends the whole file again is believed.

A server may send without end, or so slowly that there is none. So a :class:`Download` counts the
bytes and the seconds of all its files together, and ends at its limits, or where bytes come at less
than :data:`SLOWEST` a second. The head of an answer must be there within one time-out, and each
piece of its body after it: a time-out of a socket would begin anew with every byte.
"""

from __future__ import annotations

import errno
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

import requests
from urllib3.exceptions import HTTPError, IncompleteRead, ProtocolError

from motiondb.errors import MotionDBError, QueryError
from motiondb.workers import within

_CHUNK = 1 << 16  # Bytes that are written at once
SLOWEST = 500.0  # Bytes a second, over one time-out, below which a server is given up

_PASSING = (408, 425, 429, 500, 502, 503, 504)
"""HTTP statuses of a server that may answer later (RFC 9110, section 15; RFC 6585)."""

Check = Callable[[bytes], str | None]
"""Bytes of a file -> None when whole, or ``expected ..., found ...``."""
OnBytes = Callable[[int, int | None], None]  # Called with (bytes there, bytes in all or None)
T = TypeVar("T")


class RefusedError(MotionDBError):
    """One file that cannot be downloaded, while others may."""


class UnreachableError(MotionDBError):
    """No server answers, the disk is full, or a limit is reached: no further file can be had."""


class _PassingError(Exception):
    """An attempt that failed and may be repeated; ``fault`` is what to raise in the end."""

    def __init__(self, fault: MotionDBError) -> None:
        super().__init__(str(fault))
        self.fault = fault


@dataclass(frozen=True)
class FetchLimits:
    """Limits of one download; real downloads of subjects are far smaller."""

    seconds: float = 6 * 3600.0
    """From beginning to end. The default is six hours: all 2,500 captures at 1 Mbit a second would
    take longer, and should come as the site's one archive."""
    pages: int = 200
    """Pages of descriptions, one for each subject. The site has 144 subjects."""
    files: int = 5000
    """Files of all subjects together. The site has about 2,700."""
    page_bytes: int = 10_000_000
    """Of one page. The longest of the site's has 0.1 MB."""
    file_bytes: int = 500_000_000
    """Of one file. The longest of the site's has 25 MB."""
    total_bytes: int = 20_000_000_000
    """Of everything. The site's captures have 4 GB."""


def check_limits(limits: FetchLimits) -> None:
    """Refuse limits that are no numbers above 0."""
    for name, value in vars(limits).items():
        if not 0 < value < float("inf"):
            raise QueryError(f"{name}: expected a number above 0, found {value!r}.")


class Download:
    """One download: its connection, and the share of the limits that it has used."""

    def __init__(self, timeout: float, attempts: int, limits: FetchLimits) -> None:
        self.timeout, self.attempts, self.limits = timeout, attempts, limits
        self.session = requests.Session()
        # compressed answers have no length that the bytes could be compared with
        self.session.headers.update({"User-Agent": "motiondb", "Accept-Encoding": "identity"})
        self.n_bytes = 0  # bytes that came so far, of pages and files
        self.end = time.monotonic() + limits.seconds

    def page(self, url: str) -> bytes:
        """Download a page into memory."""

        def attempt() -> bytes:
            with self._ask(url, 0) as answer:
                return b"".join(self._chunks(url, answer, 0, self.limits.page_bytes))

        return self._insist(url, attempt, lambda: 0)

    def file(self, url: str, path: Path, check: Check, on_bytes: OnBytes) -> int:
        """Download one file, resuming what an earlier attempt left; return its number of bytes."""
        part = path.with_name(path.name + ".part")
        with _writing(path.parent):
            path.parent.mkdir(parents=True, exist_ok=True)
        for is_resumed in (size(part) > 0, False):
            self._insist(url, lambda: self._append(url, part, on_bytes), lambda: size(part))
            fault = check(part.read_bytes())
            if fault is None:
                part.replace(path)
                return size(path)
            part.unlink()
            if not is_resumed:
                break
        raise RefusedError(
            f"{url}: {fault}. The server's copy is damaged or is not a capture; it was not kept."
        )

    def _append(self, url: str, part: Path, on_bytes: OnBytes) -> None:
        """Bring the missing bytes of ``part``."""
        have = size(part)
        with self._ask(url, have) as answer:
            if answer.status_code == 416 and (
                answer.headers.get("Content-Range") == f"bytes */{have}"
            ):
                return  # it was whole already
            if have and answer.status_code in (206, 416) and not _begins_at(answer, have):
                part.unlink(missing_ok=True)
                raise _cut(url, f"expected bytes from {have} on, found another version of the file")
            have = have if answer.status_code == 206 else 0
            total = _total(answer, have)
            try:
                with _writing(part):
                    file = part.open("ab" if have else "wb")
                with file:
                    for chunk in self._chunks(url, answer, have, self.limits.file_bytes):
                        with _writing(part):
                            file.write(chunk)
                            file.flush()
                        have += len(chunk)
                        on_bytes(have, total)
                    with _writing(part):  # some file systems find only now that it is full
                        os.fsync(file.fileno())
            except RefusedError:  # too long
                part.unlink(missing_ok=True)
                raise

    def _chunks(self, url: str, answer: requests.Response, have: int, most: int) -> Iterator[bytes]:
        """Yield the bytes of an answer; `have` are there already, and all may be `most`."""
        total = _total(answer, have)
        _check_size(url, total or 0, most)
        since, before = time.monotonic(), have
        while chunk := self._next_bytes(answer):
            yield chunk  # it is written before a limit ends the download
            have += len(chunk)
            self._spend(url, len(chunk))
            _check_size(url, have, most)
            if (span := time.monotonic() - since) >= self.timeout:
                if (rate := (have - before) / span) < SLOWEST:
                    raise UnreachableError(
                        f"{url}: expected {SLOWEST:g} bytes a second or more, found {rate:.3g}. "
                        "Run the same command again to continue, or name another server with "
                        "--base-url; downloaded files are kept."
                    )
                since, before = time.monotonic(), have
        if total is not None and have < total:
            raise _cut(url, f"expected {total} bytes, found {have}")

    def _insist(self, url: str, attempt: Callable[[], T], progress: Callable[[], int]) -> T:
        """Try until it works, or ``attempts`` in a row bring no byte; pauses of 1, 2, 4, ... s."""
        fruitless = 0
        while True:
            self._spend(url, 0)
            before = progress()
            try:
                return attempt()
            except _PassingError as error:
                fault = error.fault
            except (requests.RequestException, HTTPError, TimeoutError) as error:
                fault = UnreachableError(
                    f"{url}: expected an answer, found none ({_root(error)}). "
                    "Check the network, or name another server with --base-url; "
                    "downloaded files are kept."
                )
            fruitless = 0 if progress() > before else fruitless + 1
            if fruitless >= self.attempts:
                self._spend(url, 0)
                raise fault
            time.sleep(2.0 ** max(fruitless - 1, 0))

    def _ask(self, url: str, start: int) -> requests.Response:
        """Ask for the bytes from ``start`` on; refusals of the server are raised."""
        headers = {"Range": f"bytes={start}-"} if start else {}
        get = partial(self.session.get, url, headers=headers, timeout=self._patience, stream=True)
        answer = within(self._patience, get)
        status = answer.status_code
        if status < 400 or (status == 416 and start):
            return answer
        answer.close()
        if status in (404, 410):
            raise RefusedError(f"{url}: expected a file, found none there (HTTP {status}).")
        fault = RefusedError(
            f"{url}: expected a file, found that the server refuses (HTTP {status} "
            f"{answer.reason}). Try again later."
        )
        raise _PassingError(fault) if status in _PASSING else fault

    @property
    def _patience(self) -> float:
        """Seconds to wait for the next sign of the server."""
        return min(self.timeout, max(self.end - time.monotonic(), 0.01))

    def _next_bytes(self, answer: requests.Response) -> bytes:
        """Bytes that have arrived, b"" at the end.

        ``iter_content`` waits until a whole block is there, and loses it when the rest does not
        come.
        """
        try:
            return within(self._patience, lambda: bytes(answer.raw.read1(_CHUNK)))
        except TimeoutError:
            with suppress(OSError):
                answer.raw.shutdown()  # ends the reading that was left behind
            raise
        except ProtocolError as error:
            if not isinstance(error.__cause__, IncompleteRead):
                raise
            return b""  # the end came early, which is found by the length

    def _spend(self, url: str, n_bytes: int) -> None:
        """Count bytes that came; end the download at its limits."""
        self.n_bytes += n_bytes
        if time.monotonic() >= self.end:
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


def _begins_at(answer: requests.Response, have: int) -> bool:
    """Whether an answer holds the bytes from ``have`` on."""
    found = answer.headers.get("Content-Range", "")
    return answer.status_code == 206 and found.startswith(f"bytes {have}-")


def _total(answer: requests.Response, have: int) -> int | None:
    """Bytes of the whole file by the length that an answer announces, None without one."""
    length = read_count(answer.headers.get("Content-Length"))
    return None if length is None else have + length


def _cut(url: str, reason: str) -> _PassingError:
    """Return the fault of a transfer that may go better the next time."""
    return _PassingError(RefusedError(f"{url}: {reason}. The transfer was cut: try again later."))


def _check_size(url: str, n_bytes: int, most: int) -> None:
    """Refuse a page or a file that is longer than it may be."""
    if n_bytes > most:
        raise RefusedError(
            f"{url}: expected at most {most} bytes, found {n_bytes} or more. "
            "Captures are not that large; it was not kept."
        )


def _root(error: BaseException) -> BaseException:
    """Return the fault of the system below the layers of requests and urllib3."""
    while error.__context__ is not None:
        error = error.__context__
    return error


def read_count(text: str | None) -> int | None:
    """Read a number of bytes from a header; None if it is not a plain number below 10^15.

    >>> read_count("120"), read_count("12a"), read_count("9" * 5000), read_count("\u00b2")
    (120, None, None, None)
    """
    if text is None or not re.fullmatch("[0-9]{1,15}", text.strip()):
        return None
    return int(text)


def size(path: Path) -> int:
    """Bytes of a file, 0 where there is none."""
    return path.stat().st_size if path.exists() else 0


@contextmanager
def _writing(part: Path) -> Iterator[None]:
    """Tell a fault of the disk, such as a full one, from those of the network."""
    try:
        yield
    except OSError as error:
        raise disk_fault(part, error) from None


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
