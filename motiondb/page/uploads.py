"""Files to add: those that a browser sends, and folders of this computer that the user allowed.

Files that are sent are kept in a private folder. A name that a browser sends is never used as a
path. Its parts are reduced to letters, digits and a few signs, so that every file stays below the
folder of its upload. A path in a request is relative to an allowed folder; links that lead out of
it are refused.
"""

from __future__ import annotations

import re
import secrets
import shutil
import threading
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from motiondb.page.errors import PageError, unknown
from motiondb.page.settings import UploadLimits, upload_kind

_FORBIDDEN = re.compile(r"[^\w .()+=@-]")
_DEEPEST = 8  # Largest number of folders in a name that are kept
_LONGEST_PART = 100  # Characters in one part of a path; file systems allow 255 bytes
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


@dataclass(frozen=True)
class FolderReply:
    """What is in a folder that captures may be added from."""

    root: int
    path: str
    folders: list[str]
    captures: int
    sheets: list[str]


MOST_ENTRIES = 2000  # Largest number of entries of a folder that are listed


def allowed_path(roots: Sequence[Path], root: int, path: str) -> Path:
    """Return a path below one of the allowed folders."""
    if not 0 <= root < len(roots):
        raise PageError(
            "folder: expected one of the folders that the page was started with, found another."
            " Start motiondb serve with --folder FOLDER.",
            403,
            "FolderError",
        )
    base = roots[root].resolve()
    parts = [part for part in path.split("/") if part not in ("", ".")]
    try:
        allowed = base.joinpath(*parts).resolve()
        inside = allowed.is_relative_to(base) and ".." not in parts and allowed.exists()
    except (OSError, ValueError):  # a loop of links, or characters that no path may have
        inside = False
    if not inside:
        raise unknown("folder", path, "Choose one that is listed.")
    return allowed


def list_folder(roots: Sequence[Path], root: int, path: str) -> FolderReply:
    """Return the folders, the number of captures and the sheets in an allowed folder."""
    folder = allowed_path(roots, root, path)
    if not folder.is_dir():
        raise unknown("folder", path, "Choose one that is listed.")
    names: dict[str, list[str]] = {"folder": [], "capture": [], "skeleton": [], "sheet": []}
    try:
        for entry in sorted(folder.iterdir())[:MOST_ENTRIES]:
            kind = "folder" if entry.is_dir() else upload_kind(entry.name)
            if kind and not entry.name.startswith(".") and not entry.is_symlink():
                names[kind].append(without_surrogates(entry.name))
    except OSError as error:
        raise PageError(
            f"folder: expected one that can be read, found: {error.strerror}."
        ) from None
    return FolderReply(root, path, names["folder"], len(names["capture"]), names["sheet"])


def without_surrogates(name: str) -> str:
    """Return a name without lone surrogates, which JSON in UTF-8 cannot hold."""
    return name.encode("utf-8", "replace").decode()
