"""Files over HTTP that are whole or not there: resumed, verified, then given their name.

A file grows as ``NAME.part`` and is renamed only when its length is the one the server announced
and its contents pass a check, so that an interruption at any moment leaves nothing half written
under a final name. The next attempt asks for the missing bytes (``Range``, RFC 9110, section 14); a
server that sends the whole file again is believed. Attempts that bring nothing new are counted, and
wait 1, 2, 4, ... seconds.
"""

from __future__ import annotations

import errno
import http.client
import os
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, TypeVar, cast

from motiondb.errors import MotionDBError

Check = Callable[[bytes], str | None]
"""Bytes of a file -> None when whole, or ``expected ..., found ...``."""
OnBytes = Callable[[int, int | None], None]
"""Called with (bytes there, bytes in all or None)."""

T = TypeVar("T")

_CHUNK = 1 << 16
_PASSING = (408, 425, 429, 500, 502, 503, 504)
_NETWORK_FAULTS = (OSError, http.client.HTTPException)
"""URLError, time-outs and broken connections are all children of OSError."""


class RefusedError(MotionDBError):
    """One file that cannot be had, while others may."""


class NotFoundError(RefusedError):
    """A file that the server does not have."""


class UnreachableError(MotionDBError):
    """No server answers, or the disk takes no more: no further file can be had."""


class _CutError(Exception):
    """A transfer that ended early; holds what was expected and found."""


@dataclass(frozen=True)
class Patience:
    """How long to wait: seconds for a server's answer, fruitless attempts, and how to pause."""

    timeout: float = 30.0
    attempts: int = 4
    pause: Callable[[float], None] = time.sleep


def fetch_page(url: str, patience: Patience) -> bytes:
    """The bytes of a page, after as many attempts as patience allows.

    Raises
    ------
    NotFoundError, RefusedError
        when the server says so.
    UnreachableError
        when none answers.
    """

    def ask() -> bytes:
        with _open(url, 0, patience.timeout) as answer:
            data = answer.read()
            expected = answer.headers.get("Content-Length")
        if expected and expected.isdigit() and len(data) < int(expected):
            raise _CutError(f"expected {expected} bytes, found {len(data)}")
        return bytes(data)

    return _insist(url, ask, lambda: 0, patience)


def fetch_file(
    url: str, path: Path, check: Check, patience: Patience, on_bytes: OnBytes | None = None
) -> int:
    """Download one file, resuming what an earlier attempt left; return its bytes.

    Parameters
    ----------
    path : final name; the folder exists. Until the file is whole it is called ``path.part``.
    check : what must hold of the bytes.

    Raises
    ------
    NotFoundError, RefusedError
        when the server has no such file, or a damaged one; nothing is left behind.
    UnreachableError
        when no server answers or the disk is full; the part stays for the next time.
    """
    part = path.with_name(path.name + ".part")
    for is_resumed in (_size(part) > 0, False):
        _insist(
            url,
            lambda: _append(url, part, patience.timeout, on_bytes),
            lambda: _size(part),
            patience,
        )
        fault = check(part.read_bytes())
        if fault is None:
            part.replace(path)
            return _size(path)
        part.unlink()
        if not is_resumed:
            break
    raise RefusedError(
        f"{url}: {fault}. The server's copy is damaged or is no capture; it was not kept."
    )


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, or say why not."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise disk_fault(folder, error) from None


def _insist(url: str, ask: Callable[[], T], progress: Callable[[], int], patience: Patience) -> T:
    """Ask until it works, or until ``attempts`` in a row bring no progress."""
    fruitless = 0
    while True:
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
                "what is there already is kept."
            )
        fruitless = 0 if progress() > before else fruitless + 1
        if fruitless >= patience.attempts:
            raise fault
        patience.pause(2.0 ** max(fruitless - 1, 0))


def _append(url: str, part: Path, timeout: float, on_bytes: OnBytes | None) -> None:
    """Bring the missing bytes of ``part``; raise _CutError when the transfer ends early."""
    have = _size(part)
    try:
        answer = _open(url, have, timeout)
    except urllib.error.HTTPError as error:
        if error.code != 416:
            raise
        error.close()
        if error.headers.get("Content-Range", "") == f"bytes */{have}":
            return
        part.unlink(missing_ok=True)
        raise _CutError("expected the rest of the file, found that it has changed") from None
    with answer:
        if answer.status == 206 and not _starts_at(answer, have):
            part.unlink(missing_ok=True)
            raise _CutError(f"expected bytes from {have} on, found others")
        have = have if answer.status == 206 else 0
        length = answer.headers.get("Content-Length")
        total = have + int(length) if length and length.isdigit() else None
        have = _copy(answer, part, have, total, on_bytes)
    if total is not None and have < total:
        raise _CutError(f"expected {total} bytes, found {have}")


def _copy(
    answer: http.client.HTTPResponse,
    part: Path,
    have: int,
    total: int | None,
    on_bytes: OnBytes | None,
) -> int:
    """Write an answer behind the first ``have`` bytes of ``part``; return the bytes then there.

    ``read1`` hands over what has come: ``read`` would lose it when the next bytes are late.
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
            if on_bytes is not None:
                on_bytes(have, total)
        os.fsync(file.fileno())
    return have


def _open(url: str, start: int, timeout: float) -> http.client.HTTPResponse:
    headers = {"User-Agent": "motiondb", "Accept-Encoding": "identity"}
    if start:
        headers["Range"] = f"bytes={start}-"
    request = urllib.request.Request(url, headers=headers)
    answer: http.client.HTTPResponse = urllib.request.urlopen(request, timeout=timeout)
    return answer


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


def disk_fault(path: Path, error: OSError) -> UnreachableError:
    """What to say when a file or folder cannot be written."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return UnreachableError(
            f"{path}: expected room on the disk, found it full. "
            "Make room and run the same command again; what is there already is kept."
        )
    return UnreachableError(
        f"{path}: expected a file that can be written, found: {error.strerror}. "
        "Choose another folder with --dir."
    )


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0
