"""Files that a browser sends. They are kept in a private folder, under cleaned names.

A name that a browser sends is never used as a path. Its parts are reduced to letters, digits and a
few signs, so that every file stays below the folder of its upload.
"""

from __future__ import annotations

import re
import secrets
import shutil
import threading
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from motiondb.page.answers import PageError, unknown
from motiondb.page.settings import UploadLimits, upload_kind

_FORBIDDEN = re.compile(r"[^\w .()+=@-]")
_DEEPEST = 8
"""Largest number of folders in a name that are kept. Chosen by hand: data sets have two or
three."""
_LONGEST_PART = 100
"""Largest number of characters in one part of a path; file systems allow 255 bytes."""
_CHUNK = 2**20  # Bytes read at once


@dataclass(frozen=True)
class UploadedFile:
    """A file of an upload."""

    name: str  # Cleaned name, with ``/`` between its parts
    kind: str  # "capture", "skeleton" or "sheet"
    n_bytes: int


@dataclass(frozen=True)
class Upload:
    """The files of one request."""

    upload_id: str
    folder: Path  # Where the files are
    files: tuple[UploadedFile, ...]

    @property
    def n_bytes(self) -> int:
        """Size of all files."""
        return sum(file.n_bytes for file in self.files)

    def path(self, name: str) -> Path:
        """Return the path of one of the files, by its cleaned name."""
        if name not in {file.name for file in self.files}:
            raise unknown("uploaded file", name, "Upload it again.")
        return self.folder.joinpath(*name.split("/"))


def clean_name(name: str) -> str:
    r"""Return a relative path that stays below its folder; "" if no valid part is left.

    >>> clean_name("../../etc/passwd.bvh"), clean_name("C:\\takes\\walk 1.bvh")
    ('etc/passwd.bvh', 'C_/takes/walk 1.bvh')
    """
    parts = []
    for part in re.split(r"[/\\]", name):
        plain = _FORBIDDEN.sub("_", part).strip(" .")
        if plain:
            stem, dot, ending = plain.rpartition(".")
            stem = stem[: _LONGEST_PART - len(ending) - 1] if dot else plain[:_LONGEST_PART]
            parts.append(f"{stem}{dot}{ending}" if dot else stem)
    return "/".join(parts[-_DEEPEST:])


class Uploads:
    """The uploads of a server; the oldest are dropped when they exceed the size limit."""

    def __init__(self, folder: Path, limits: UploadLimits) -> None:
        self._folder, self.limits = folder, limits
        self._uploads: OrderedDict[str, Upload] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, upload_id: str) -> Upload:
        """Return an upload."""
        with self._lock:
            if upload_id not in self._uploads:
                raise unknown("upload", upload_id, "Upload the files again.")
            return self._uploads[upload_id]

    def begin(self) -> Receiving:
        """Begin an upload, and return the object that receives its files."""
        upload_id = f"u{secrets.token_hex(8)}"
        folder = self._folder / upload_id
        folder.mkdir(mode=0o700)
        return Receiving(upload_id, folder, self.limits)

    def keep(self, received: Receiving) -> Upload:
        """Keep the received files; drop the oldest uploads if they exceed the size limit."""
        if not received.files:
            shutil.rmtree(received.folder, ignore_errors=True)
            why = "; ".join(f"{name}: {reason}" for name, reason in received.refused[:5])
            raise PageError(
                f"upload: expected captures or sheets of words, found none. {why}".strip(),
                415,
                "KindError",
            )
        upload = Upload(received.upload_id, received.folder, tuple(received.files))
        with self._lock:
            self._uploads[upload.upload_id] = upload
            while sum(u.n_bytes for u in self._uploads.values()) > self.limits.kept_bytes:
                if len(self._uploads) == 1:
                    break
                _, oldest = self._uploads.popitem(last=False)
                shutil.rmtree(oldest.folder, ignore_errors=True)
        return upload


class Receiving:
    """An upload that receives files one after the other."""

    def __init__(self, upload_id: str, folder: Path, limits: UploadLimits) -> None:
        self.upload_id, self.folder, self._limits = upload_id, folder, limits
        self.files: list[UploadedFile] = []
        self.refused: list[tuple[str, str]] = []

    def take(self, name: str, stream: BinaryIO) -> None:
        """Receive a file, or note why it is refused."""
        shown = clean_name(name) or "a file without a name"
        kind = upload_kind(shown)
        if not kind:
            self.refused.append((shown, "expected a capture or a sheet, found another ending."))
        elif any(file.name.casefold() == shown.casefold() for file in self.files):
            self.refused.append((shown, "expected one file of this name, found a second."))
        else:
            self._write(shown, kind, stream)

    def _write(self, name: str, kind: str, stream: BinaryIO) -> None:
        path = self.folder.joinpath(*name.split("/"))
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        size = 0
        with path.open("wb") as file:
            for chunk in _chunks(stream):
                size += len(chunk)
                if size > self._limits.file_bytes:
                    break
                file.write(chunk)
        if size > self._limits.file_bytes:
            path.unlink()
            most = self._limits.file_bytes / 1e6
            self.refused.append((name, f"expected at most {most:.0f} MB, found more."))
            return
        self.files.append(UploadedFile(name, kind, size))


def _chunks(stream: BinaryIO) -> Iterator[bytes]:
    while chunk := stream.read(_CHUNK):
        yield chunk
