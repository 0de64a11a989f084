"""Download files over HTTP: resume, check the content, then rename the file to its final name.

A file grows as ``NAME.part``. It is renamed when it has the length that the server announced, and
its contents pass a check, so that an interruption at any moment leaves nothing half written under a
final name. The next attempt asks for the missing bytes (``Range``, RFC 9110, section 14); a server
that sends the whole file again is believed. Attempts without new bytes are counted; the next
one waits 1, 2, 4, ... seconds.

A server may send without end, or a byte at a time. So a :class:`Budget` counts the bytes and the
seconds of a whole download, and ends it at its limits.
"""

from __future__ import annotations

import http.client
import os
import re
import threading
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, TypeVar, cast

from motiondb.errors import MotionDBError
from motiondb.fetch.limits import (
    Budget,
    NotFoundError,
    Patience,
    RefusedError,
    TooLongError,
    UnreachableError,
    disk_fault,
)

Check = Callable[[bytes], str | None]
"""Bytes of a file -> None when whole, or ``expected ..., found ...``."""
OnBytes = Callable[[int, int | None], None]  # Called with (bytes there, bytes in all or None)

T = TypeVar("T")

_HEAD_SHARE = 4.0
"""Time-outs within which an answer's head must come: names are looked up, several addresses may be
tried, and redirections followed."""

_CHUNK = 1 << 16  # Bytes that are written at once
_PASSING = (408, 425, 429, 500, 502, 503, 504)
"""HTTP statuses of a server that may answer later (RFC 9110, section 15; RFC 6585)."""
_NETWORK_FAULTS = (OSError, http.client.HTTPException)
"""Errors of the network; URLError, time-outs and broken connections are children of OSError."""


class _CutError(Exception):
    """A transfer that ended early, with the expected and the received number of bytes."""


def fetch_page(url: str, patience: Patience, budget: Budget) -> bytes:
    """Download a page into memory, in as many attempts as patience allows."""

    def ask() -> bytes:
        data = bytearray()
        with _open(url, 0, patience.timeout, budget) as answer:
            expected = read_count(answer.headers.get("Content-Length"))
            budget.check_size(url, expected or 0, budget.limits.page_bytes)
            while chunk := answer.read1(_CHUNK):
                data += chunk
                budget.spend(url, len(chunk))
                budget.check_size(url, len(data), budget.limits.page_bytes)
        if expected is not None and len(data) < expected:
            raise _CutError(f"expected {expected} bytes, found {len(data)}")
        return bytes(data)

    return _insist(url, ask, lambda: 0, patience, budget)


def fetch_file(
    url: str,
    path: Path,
    check: Check,
    patience: Patience,
    budget: Budget,
    on_bytes: OnBytes | None = None,
) -> int:
    """Download one file, resuming what an earlier attempt left; return its bytes.

    `path`: Its final name; the folder exists. Until the file is whole it is called ``path.part``.
    """
    part = path.with_name(path.name + ".part")
    for is_resumed in (_size(part) > 0, False):
        try:
            _insist(
                url,
                lambda: _append(url, part, patience.timeout, budget, on_bytes),
                lambda: _size(part),
                patience,
                budget,
            )
        except TooLongError:
            part.unlink(missing_ok=True)
            raise
        fault = check(part.read_bytes())
        if fault is None:
            part.replace(path)
            return _size(path)
        part.unlink()
        if not is_resumed:
            break
    raise RefusedError(
        f"{url}: {fault}. The server's copy is damaged or is not a capture; it was not kept."
    )


def make_folder(folder: Path) -> None:
    """Make a folder and its parents, or raise the reason why not."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise disk_fault(folder, error) from None


def read_count(text: str | None) -> int | None:
    """Read a number of bytes from a header; None if it is not a plain number below 10^15.

    >>> read_count("120"), read_count("12a"), read_count("9" * 5000), read_count("\u00b2")
    (120, None, None, None)
    """
    if text is None or not re.fullmatch("[0-9]{1,15}", text.strip()):
        return None
    return int(text)


def _insist(
    url: str,
    ask: Callable[[], T],
    progress: Callable[[], int],
    patience: Patience,
    budget: Budget,
) -> T:
    """Ask until it works, or until ``attempts`` in a row bring no progress."""
    fruitless = 0
    while True:
        budget.spend(url, 0)
        before = progress()
        try:
            return ask()
        except MotionDBError:
            raise
        except urllib.error.HTTPError as error:
            error.close()
            if error.code not in _PASSING:
                raise _refusal(url, error) from None
            fault: MotionDBError = _refusal(url, error)
        except _CutError as error:
            fault = RefusedError(f"{url}: {error}. The transfer was cut: try again later.")
        except _NETWORK_FAULTS as error:
            reason = getattr(error, "reason", None) or error
            fault = UnreachableError(
                f"{url}: expected an answer, found none ({reason}). "
                "Check the network, or name another server with --base-url; "
                "downloaded files are kept."
            )
        fruitless = 0 if progress() > before else fruitless + 1
        if fruitless >= patience.attempts:
            raise fault
        patience.pause(2.0 ** max(fruitless - 1, 0))


def _append(url: str, part: Path, timeout: float, budget: Budget, on_bytes: OnBytes | None) -> None:
    """Bring the missing bytes of ``part``; raise _CutError when the transfer ends early."""
    have = _size(part)
    try:
        answer = _open(url, have, timeout, budget)
    except urllib.error.HTTPError as error:
        if error.code != 416:
            raise
        error.close()
        if error.headers.get("Content-Range", "") == f"bytes */{have}":
            return
        part.unlink(missing_ok=True)
        raise _CutError("expected the rest of the file, found another version of it") from None
    with answer:
        if answer.status == 206 and not _starts_at(answer, have):
            part.unlink(missing_ok=True)
            raise _CutError(f"expected bytes from {have} on, found others")
        have = have if answer.status == 206 else 0
        length = read_count(answer.headers.get("Content-Length"))
        total = None if length is None else have + length
        budget.check_size(url, total or 0, budget.limits.file_bytes)

        def tell(n_bytes: int, n_new: int) -> None:
            budget.spend(url, n_new)
            budget.check_size(url, n_bytes, budget.limits.file_bytes)
            if on_bytes is not None:
                on_bytes(n_bytes, total)

        have = _copy(answer, part, have, total, tell)
    if total is not None and have < total:
        raise _CutError(f"expected {total} bytes, found {have}")


def _copy(
    answer: http.client.HTTPResponse,
    part: Path,
    have: int,
    total: int | None,
    tell: Callable[[int, int], None],
) -> int:
    """Write an answer behind the first ``have`` bytes of ``part``; return the bytes then there.

    ``read1`` returns the bytes that have arrived: ``read`` would lose it when the next bytes are
    late. ``tell`` is called with the number of bytes present and the number of new bytes.
    """
    left = _CHUNK if total is None else min(_CHUNK, total - have)
    with _open_part(part, "ab" if have else "wb") as file:
        while left > 0 and (chunk := answer.read1(left)):
            try:
                file.write(chunk)
                file.flush()
            except OSError as error:
                raise disk_fault(part, error) from None
            have += len(chunk)
            left = _CHUNK if total is None else min(_CHUNK, total - have)
            tell(have, len(chunk))
        os.fsync(file.fileno())
    return have


def _open(url: str, start: int, timeout: float, budget: Budget) -> http.client.HTTPResponse:
    """Ask for the bytes from ``start`` on; the answer's head must come within the time left."""
    headers = {"User-Agent": "motiondb", "Accept-Encoding": "identity"}
    if start:
        headers["Range"] = f"bytes={start}-"
    request = urllib.request.Request(url, headers=headers)
    seconds = min(timeout, max(budget.seconds_left(), 0.01))

    def ask() -> http.client.HTTPResponse:
        answer: http.client.HTTPResponse = urllib.request.urlopen(request, timeout=seconds)
        return answer

    return within(_HEAD_SHARE * seconds, ask)


def within(seconds: float, work: Callable[[], T]) -> T:
    """Do something in a thread, for at most so many seconds.

    The time-out of a socket starts again with every byte, so a server that sends the head of its
    answer byte by byte would never reach it.
    """
    done: list[T] = []
    failed: list[BaseException] = []

    def run() -> None:
        try:
            done.append(work())
        except BaseException as error:
            failed.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(seconds)
    if failed:
        raise failed[0]
    if not done:
        raise TimeoutError("timed out")
    return done[0]


def _open_part(part: Path, mode: str) -> BinaryIO:
    try:
        return cast(BinaryIO, part.open(mode))
    except OSError as error:
        raise disk_fault(part, error) from None


def _starts_at(answer: http.client.HTTPResponse, have: int) -> bool:
    return answer.headers.get("Content-Range", "").startswith(f"bytes {have}-")


def _refusal(url: str, error: urllib.error.HTTPError) -> RefusedError:
    if error.code in (404, 410):
        return NotFoundError(f"{url}: expected a file, found none there (HTTP {error.code}).")
    return RefusedError(
        f"{url}: expected a file, found that the server refuses (HTTP {error.code} "
        f"{error.reason}). Try again later."
    )


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0
