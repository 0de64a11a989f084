"""Places outside the database where files lie: a folder of this machine, or a URL of fsspec.

A folder needs nothing else. A URL (``s3://bucket/motions``) is read and written by `fsspec
<https://filesystem-spec.readthedocs.io>`_, which is imported only then; passwords and keys are
those of its own configuration: URLs that hold them are refused, as the database would keep them.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO, Protocol, cast
from urllib.parse import urlsplit

from motiondb.errors import QueryError, StoreError
from motiondb.files.own_folder import own_folder
from motiondb.files.safe_files import check_output

_AT_ONCE = 2**20  # Bytes
_EXPECTED = "a folder or a URL that fsspec knows"
_NOT_KEPT = frozenset({"memory"})  # File systems whose files end with the process


class PlaceError(StoreError):
    """A place, or a file in it, that cannot be reached."""


class Place(Protocol):
    """Where files lie by their names; the errors of its methods are those of the file system."""

    def check(self) -> None:
        """StoreError if files cannot lie here, as far as this is known before one is written."""

    def open(self, name: str) -> BinaryIO:
        """Open a file for reading from its beginning to its end."""

    def read(self, name: str, start: int, stop: int) -> bytes:
        """Return some bytes of a file, fewer where it ends before."""

    def write(self, name: str, file: Path) -> None:
        """Copy a file of this machine here, under a name that is free."""

    def delete(self, name: str) -> None:
        """Delete a file."""


class _Folder:
    """A folder of this machine, or one that several machines share."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def check(self) -> None:
        if self._path.exists() and not self._path.is_dir():
            raise StoreError(f"{self._path}: expected a folder, found a file. Name another one.")
        if not self._path.parent.is_dir():
            raise StoreError(
                f"{self._path}: expected the folder {self._path.parent}, found none. Make the "
                "folder first."
            )

    def open(self, name: str) -> BinaryIO:
        with own_folder(self._path, is_users=True) as folder:
            return folder.open(name)

    def read(self, name: str, start: int, stop: int) -> bytes:
        with self.open(name) as file:
            file.seek(start)
            return file.read(stop - start)

    def write(self, name: str, file: Path) -> None:
        check_output(self._path, is_folder=True)
        with own_folder(self._path, make=True, is_users=True) as folder:
            with folder.draft(name) as written, file.open("rb") as read:
                shutil.copyfileobj(read, written, _AT_ONCE)
            folder.sync()  # the name, too, is on the disk before the database relies on it

    def delete(self, name: str) -> None:
        with own_folder(self._path, is_users=True) as folder:
            folder.remove(name)


class _Remote:
    """A folder that a file system of fsspec knows."""

    def __init__(self, system: Any, path: str) -> None:  # noqa: ANN401  of fsspec, without types
        self._system, self._path = system, path.rstrip("/")

    def check(self) -> None:
        """Do nothing: object stores have no folders."""

    def open(self, name: str) -> BinaryIO:
        return cast("BinaryIO", self._system.open(f"{self._path}/{name}", "rb"))

    def read(self, name: str, start: int, stop: int) -> bytes:
        return bytes(self._system.cat_file(f"{self._path}/{name}", start=start, end=stop))

    def write(self, name: str, file: Path) -> None:
        self._system.put_file(str(file), f"{self._path}/{name}")

    def delete(self, name: str) -> None:
        self._system.rm_file(f"{self._path}/{name}")


def place_name(text: str) -> str:
    """How a place is kept: a URL, or the real path of a folder; QueryError for what cannot be kept.

    >>> place_name("s3://bucket//motions/"), place_name("file:///shared/../motions")
    ('s3://bucket/motions', '/motions')
    """
    if not text:
        raise QueryError(f"'': expected {_EXPECTED}, found nothing. Name one.")
    try:
        scheme, host, path, query, _ = urlsplit(text)
        if scheme == "file" or "://" not in text:
            folder = _local_path(path) if scheme == "file" else text
            return os.path.realpath(Path(folder).expanduser())
    except (ValueError, RuntimeError) as error:  # a bracket, an unknown user, a null character
        raise QueryError(
            f"{_without_keys(text)}: expected {_EXPECTED}, found: {str(error).rstrip('.')}. "
            "Name another one."
        ) from None
    shown = _without_keys(text)
    if not host and not path.strip("/"):
        raise QueryError(f"{shown}: expected {_EXPECTED}, found no name in it. Name one.")
    if "::" in text or scheme in _NOT_KEPT:
        raise QueryError(
            f"{shown}: expected a URL whose files stay, found one of memory or of several file "
            "systems, whose files may end with this command. Name the place itself."
        )
    if "@" in text or query:  # a password may hold a slash
        raise QueryError(
            f"{shown}: expected a URL without a user, a password or a query, found one with them. "
            "The database would keep it; put it into the configuration of fsspec."
        )
    rest = re.sub("/+", "/", text.partition("://")[2].removeprefix(host))
    return f"{scheme}://{host}{rest}".rstrip("/")


def _local_path(path: str) -> str:
    """The path of this system that a file URL's is."""
    from urllib.request import url2pathname  # loads the client of HTTP

    return url2pathname(path)


def _without_keys(text: str) -> str:
    """A place without what may be a secret in each of its URLs."""
    return "::".join(re.sub(r"(?s)(?<=//).*@|\?.*", "", part) for part in text.split("::"))


@lru_cache(maxsize=16)
def open_place(name: str) -> Place:
    """The place of a name that :func:`place_name` returned; StoreError if nothing can read it."""
    try:  # another program may have written it into the database
        is_kept = place_name(name) == name if "://" in name else Path(name).is_absolute()
    except QueryError as error:
        raise PlaceError(str(error)) from error
    if not is_kept:
        raise PlaceError(
            f"{_without_keys(name)}: expected {_EXPECTED}, as motiondb writes it, found another "
            "form. The database was changed by another program: restore a copy."
        )
    if "://" not in name:
        return _Folder(Path(name))
    try:
        import fsspec
    except ImportError:
        raise PlaceError(
            f"{name}: expected the package fsspec, which reads such URLs, found that it is not "
            "installed: pip install 'motiondb[cluster]'."
        ) from None
    with told(name, "Look at the URL, and at the packages that fsspec needs for it."):
        return _Remote(*fsspec.core.url_to_fs(name))


@contextmanager
def told(where: str, advice: str) -> Iterator[None]:
    """Surround the use of a place: its errors become a PlaceError that names it."""
    try:
        yield
    except (StoreError, MemoryError):
        raise
    except FileNotFoundError as error:
        raise PlaceError(f"{where}: expected a file or folder, found none. {advice}") from error
    except Exception as error:  # what a file system of fsspec raises is its own choice
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise PlaceError(
            f"{where}: expected a folder that can be used, found: {reason.rstrip('.')}. {advice}"
        ) from error


def find_file(place: str, name: str) -> None:
    """Open a file and close it again; an error of the file system if it is not there."""
    open_place(place).open(name).close()


def read_pieces(place: Place, name: str) -> Iterator[bytes]:
    """The bytes of a file, in order."""
    with place.open(name) as file:
        while piece := file.read(_AT_ONCE):
            yield piece


def digest_of(place: Place, name: str) -> str:
    """SHA-256 of a file, which is read to its end."""
    counted = hashlib.sha256()
    for piece in read_pieces(place, name):
        counted.update(piece)
    return counted.hexdigest()
