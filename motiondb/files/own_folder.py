"""Folders of motiondb's own files, in which no link is followed.

A database may come from somebody else, together with its cache and its moved motions. A link among
these would have motiondb read, or replace, whatever it stands for. Such a folder is opened once,
and its files by their names in it, without following links; they are written new beside themselves
and renamed. What stands in the place of a file and is none (a link, a folder, a pipe, a device) is
removed and told, or refused. Where the system knows no files relative to an open folder (Windows),
what a name stands for is looked at before it is used.
"""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from motiondb.files.safe_files import check_not_held, draft_of, draft_stem, ended_drafts

_IS_RELATIVE = os.open in os.supports_dir_fd
_KINDS = (
    (stat.S_ISLNK, "a link"),
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
)
_FLAGS = sum(getattr(os, name, 0) for name in ("O_BINARY", "O_NOCTTY", "O_NOFOLLOW", "O_NONBLOCK"))
Tell = Callable[[str], None]


class OwnFolder:
    """An open folder (:func:`own_folder`); its methods raise OSError, and take names of files."""

    def __init__(self, path: Path, descriptor: int | None, tell: Tell | None) -> None:
        self.path, self._descriptor, self._tell = path, descriptor, tell

    def names(self) -> list[str]:
        """What stands in the folder."""
        with os.scandir(self.path if self._descriptor is None else self._descriptor) as found:
            return [entry.name for entry in found]

    def status(self, name: str) -> os.stat_result:
        """The status of a file, or of the link in its place."""
        return os.stat(self._at(name), dir_fd=self._descriptor, follow_symlinks=False)

    def open(self, name: str, flags: int = os.O_RDONLY) -> BinaryIO:
        """Open a file for reading, or with other flags of the system."""
        self._clear(name)
        with suppress(FileNotFoundError):
            check_not_held(self.status(name))
        descriptor = os.open(self._at(name), flags | _FLAGS, 0o666, dir_fd=self._descriptor)
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):  # it was put there meanwhile
            os.close(descriptor)
            raise OSError(errno.EINVAL, "not a file")
        return os.fdopen(descriptor, "wb" if flags & os.O_WRONLY else "rb")

    @contextmanager
    def draft(self, name: str) -> Iterator[BinaryIO]:
        """Open a new file that gets its name when it is complete and on the disk."""
        self.sweep(re.escape(draft_stem(Path(name))))
        draft = draft_of(Path(name)).name
        self.remove(draft)  # of an earlier process of the same number
        try:
            with self.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL) as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            self._clear(name)
            os.replace(
                self._at(draft),
                self._at(name),
                src_dir_fd=self._descriptor,
                dst_dir_fd=self._descriptor,
            )
        finally:
            self.remove(draft)

    def remove(self, *names: str) -> None:
        """Remove those of some files, or of the links in their place, that can be removed."""
        for name in names:
            with suppress(OSError):
                os.unlink(self._at(name), dir_fd=self._descriptor)

    def sweep(self, stem: str) -> None:
        """Remove drafts whose process has ended (:func:`ended_drafts`)."""
        self.remove(*ended_drafts(self.names(), stem))

    def sync(self) -> None:
        """See to it that the names, too, are on the disk."""
        if self._descriptor is not None:
            os.fsync(self._descriptor)

    def _at(self, name: str) -> str:
        """A name as the system takes it; ValueError for one that leads elsewhere."""
        if name in (".", "..") or {"/", "\0", os.sep, os.altsep or "/"} & set(name):
            raise ValueError(f"{name!r}: no name of a file")
        return name if self._descriptor is not None else str(self.path / name)

    def _clear(self, name: str) -> None:
        """Remove what stands in the place of a file and is none, and tell it."""
        try:
            mode = self.status(name).st_mode
        except FileNotFoundError:
            return
        if stat.S_ISREG(mode):
            return
        found = next((what for is_kind, what in _KINDS if is_kind(mode)), "a device")
        told = f"{self.path / name}: expected a file that motiondb made, found {found}"
        if self._tell is None:
            raise OSError(errno.ELOOP, f"{found} in the place of a file that motiondb made")
        try:
            (os.rmdir if stat.S_ISDIR(mode) else os.unlink)(self._at(name), dir_fd=self._descriptor)
        except OSError as error:
            self._tell(f"{told}, which could not be removed ({error.strerror}). Remove it.")
            raise
        self._tell(f"{told}. It was removed; what it stood for was not touched.")


@contextmanager
def own_folder(
    path: Path, tell: Tell | None = None, *, make: bool = False, is_users: bool = False
) -> Iterator[OwnFolder]:
    """Open a folder of motiondb's own files; OSError if it is none, or cannot be opened.

    `tell`: Called with a sentence for what was removed. None: nothing is removed but refused.

    `make`: Whether the folder is made if there is none.

    `is_users`: Whether a user has named the folder: then it may be a link to one.
    """
    if make:
        with suppress(FileExistsError):
            path.mkdir()
    if not is_users and path.is_symlink():
        if tell is not None:
            tell(
                f"{path}: expected a folder that motiondb made, found a link, which is not "
                "followed. Remove it; to have the folder on another disk, put the database there "
                "and leave a link to the database."
            )
        raise OSError(errno.ELOOP, "a link")
    if not _IS_RELATIVE:
        if not path.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        yield OwnFolder(path, None, tell)
        return
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | (0 if is_users else os.O_NOFOLLOW))
    try:
        yield OwnFolder(path, descriptor, tell)
    finally:
        os.close(descriptor)
