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
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from motiondb.files.folder import holds_capture
from motiondb.page.errors import FULL_DISK, PageError, unknown
from motiondb.page.settings import UploadLimits, upload_kind

_FORBIDDEN = re.compile(r"[^\w .()+=@-]")
_DEEPEST = 8  # Largest number of folders in a name that are kept
_LONGEST_PART = 100  # Characters in one part of a path; file systems allow 255 bytes
_CHUNK = 2**20  # Bytes read at once


@dataclass(frozen=True)
class AcceptedFile:
    """A file that was accepted."""

    name: str  # Cleaned, with ``/`` between its parts
    ref: str
    bytes: int
    kind: str  # "capture", "skeleton" or "sheet"


@dataclass(frozen=True)
class RefusedFile:
    """A file that was refused."""

    name: str
    message: str


@dataclass(frozen=True)
class UploadReply:
    """Files that were uploaded together."""

    upload: str
    files: list[AcceptedFile]
    refused: list[RefusedFile]


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
        self._folder, self._limits = folder, limits
        self._uploads: OrderedDict[str, UploadReply] = OrderedDict()
        self._lock = threading.Lock()

    def path(self, upload_id: str, name: str = "") -> Path:
        """Return the folder of an upload, or one of its files by its cleaned name."""
        upload = self._uploads.get(upload_id)
        if upload is None:
            raise unknown("upload", upload_id, "Upload the files again.")
        if name and name not in {file.name for file in upload.files}:
            raise unknown("uploaded file", name, "Upload it again.")
        return self._folder / upload_id / name

    def receive(self, files: Iterable[tuple[str, BinaryIO]]) -> UploadReply:
        """Keep files with their names; drop the oldest uploads if they exceed the size limit."""
        upload = UploadReply(f"u{secrets.token_hex(8)}", [], [])
        folder = self._folder / upload.upload
        folder.mkdir(mode=0o700)
        try:
            for name, stream in files:
                self._take(upload, name, stream)
            if not upload.files:
                raise _nothing_taken(upload)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        with self._lock:
            self._uploads[upload.upload] = upload
            while len(self._uploads) > 1 and self._n_bytes() > self._limits.kept_bytes:
                oldest, _ = self._uploads.popitem(last=False)
                shutil.rmtree(self._folder / oldest, ignore_errors=True)
        return upload

    def _n_bytes(self) -> int:
        """Return the size of all uploads."""
        return sum(file.bytes for upload in self._uploads.values() for file in upload.files)

    def _take(self, upload: UploadReply, name: str, stream: BinaryIO) -> None:
        """Write a file, or note why it is refused."""
        shown = clean_name(name) or "a file without a name"
        kind = upload_kind(shown)
        if not kind:
            why = "expected a capture or a sheet, found another ending."
        elif why := _clash(shown, [file.name for file in upload.files]):
            pass
        else:
            try:
                size = self._write(self._folder / upload.upload / shown, stream)
            except OSError as error:
                if error.errno in FULL_DISK:
                    raise
                size, why = 0, f"expected a name that can be stored, found: {error.strerror}."
            if size > self._limits.file_bytes:
                why = f"expected at most {self._limits.file_bytes / 1e6:.0f} MB, {TOO_LARGE}"
            elif kind == "capture" and not why:
                why = _odd_content(self._folder / upload.upload / shown)
            if not why:
                ref = f"upload:{upload.upload}/{shown}"
                upload.files.append(AcceptedFile(shown, ref, size, kind))
                return
        upload.refused.append(RefusedFile(shown, why))

    def _write(self, path: Path, stream: BinaryIO) -> int:
        """Write a file and return its size; one that is too large is left out."""
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        size = 0
        with path.open("wb") as file:
            while size <= self._limits.file_bytes and (chunk := stream.read(_CHUNK)):
                size += len(chunk)
                file.write(chunk)
        if size > self._limits.file_bytes:
            path.unlink()
        return size


TOO_LARGE = "found more."  # End of the sentence on a file that is too large


def _nothing_taken(upload: UploadReply) -> PageError:
    """Return the error that no file of an upload is taken; 413 if all are too large."""
    why = "; ".join(f"{file.name}: {file.message}" for file in upload.refused[:5])
    message = f"upload: expected captures or sheets of words, found none. {why}".strip()
    if upload.refused and all(file.message.endswith(TOO_LARGE) for file in upload.refused):
        return PageError(message, "TooLargeError")
    return PageError(message, "KindError")


def _odd_content(path: Path) -> str:
    """Say that a file does not hold what its ending promises, and delete it; "" if it does."""
    if holds_capture(path):
        return ""
    with path.open("rb") as file:
        is_bvh = file.read(200).lstrip().startswith(b"HIERARCHY")
    path.unlink()
    found = "BVH. Let its name end in .bvh." if is_bvh else "something else."
    return f"expected DeepMimic's JSON in a file with the ending {path.suffix}, found {found}"


def _clash(name: str, others: Iterable[str]) -> str:
    """Say why a file cannot be stored beside others of an upload; "" if it can.

    >>> _clash("A.bvh", ["a.bvh"])
    'expected one file of this name, found a second.'
    >>> _clash("a.bvh/b.bvh", ["a.bvh"]), _clash("b.bvh", ["a.bvh"])
    ('expected a file or a folder of one name, found both.', '')
    """
    mine = name.casefold()
    for other in map(str.casefold, others):
        if mine == other:
            return "expected one file of this name, found a second."
        if mine.startswith(f"{other}/") or other.startswith(f"{mine}/"):
            return "expected a file or a folder of one name, found both."
    return ""


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
            "FolderError",
        )
    base = roots[root].resolve()
    parts = [part for part in path.split("/") if part not in ("", ".")]
    try:
        allowed = base.joinpath(*parts).resolve()
        inside = allowed.is_relative_to(base) and ".." not in parts and allowed.exists()
    # a loop of links, or characters that no path may have
    except (OSError, ValueError, RuntimeError):
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
            is_odd = entry.is_symlink() or not (entry.is_dir() or entry.is_file())
            if kind and not entry.name.startswith(".") and not is_odd:
                names[kind].append(without_surrogates(entry.name))
    except OSError as error:
        raise PageError(
            f"folder: expected one that can be read, found: {error.strerror}."
        ) from None
    return FolderReply(root, path, names["folder"], len(names["capture"]), names["sheet"])


def without_surrogates(name: str) -> str:
    """Return a name without lone surrogates, which JSON in UTF-8 cannot hold."""
    return name.encode("utf-8", "replace").decode()
