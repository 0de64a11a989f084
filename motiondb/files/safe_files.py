"""Files that a user names: read within bounds, written whole or not at all.

Only regular files are opened for reading (:func:`open_file`): a pipe may never give a byte, and a
device may give bytes without end. Programs hand over their output in a file; ``/dev/stdin`` is read
where the shell has put a file in its place (``< FILE``), and ``-`` is a name like any other.

A draft has the name ``.NAME.PROCESS.THREAD.part`` beside the file, with NAME cut to
:data:`_LONGEST`. It is renamed when it is complete. A process that is killed leaves its draft; the
next one that writes the same file removes it. A symbolic link stays: the file that it stands for is
replaced. What belongs to a database is never written over (:func:`check_output`).

In a folder that others may fill (``within``), a link that leads out of it is refused: a path is
resolved first, and then opened one folder after the other without following links. So a link that
is put in its way after it was resolved is refused too.

``pathlib`` raises an error for a name that the system cannot have, such as one of 300 characters;
here such a name is that of no file.

Folders that are written whole (:func:`whole_folder`) have another name until they are complete.
"""

from __future__ import annotations

import errno
import glob
import io
import os
import re
import shutil
import stat
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from motiondb.errors import CaptureError, MotionDBError, StoreError

_LONGEST = 120
"""Bytes of a file's name that its draft keeps: a name has at most 255 on most file systems, and the
numbers of a process and a thread take about 35."""

MOST_TEXT = 10_000_000
"""Bytes of a text that people write: joint maps, synonyms, diagrams, grammars. A thousand times
what such files hold."""


_IS_LINK = (errno.ELOOP, errno.ENOTDIR)  # Errors of opening a link, as a file and as a folder
_OTHER_KINDS = (
    (stat.S_ISFIFO, "a pipe; save what it gives in a file, and name that file"),
    (stat.S_ISSOCK, "a socket; name a file"),
    (stat.S_ISCHR, "a device; name a file"),
    (stat.S_ISBLK, "a device; name a file"),
)


def _refuse_other_kinds(mode: int, is_folder_refused: bool) -> None:
    """Raise OSError for the mode of a pipe, a socket or a device, and of a folder where asked."""
    for is_kind, reason in _OTHER_KINDS:
        if is_kind(mode):
            raise OSError(errno.EINVAL, reason)
    if is_folder_refused and stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))


def open_file(path: str | os.PathLike[str], within: Path | None = None) -> BinaryIO:
    """Open a regular file for reading (OSError); links must not lead out of `within`."""
    flags = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NOCTTY", 0)
    try:
        if within is not None:
            check_inside(Path(path), within)
        _refuse_other_kinds(Path(path).stat().st_mode, True)  # opening a device may act on it
        check_not_held(Path(path).stat())
        # a pipe that has taken the name meanwhile is not waited for
        flags |= getattr(os, "O_NONBLOCK", 0)
        if within is None:
            descriptor = os.open(path, flags)
        else:
            descriptor = open_inside(Path(path), within, flags)
    except ValueError:  # a null character, or letters that no encoding has
        raise OSError(errno.EINVAL, "a name that no system accepts") from None
    try:
        _refuse_other_kinds(os.fstat(descriptor).st_mode, True)
    except OSError:
        os.close(descriptor)
        raise
    return os.fdopen(descriptor, "rb")


def leads_out(path: Path, folder: Path) -> bool:
    """Return whether a path leads out of a folder."""
    return not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def check_inside(path: Path, folder: Path) -> None:
    """Refuse a path that leads out of a folder (CaptureError)."""
    if leads_out(path, folder):
        raise _outside(path)


def open_inside(path: Path, folder: Path, flags: int) -> int:
    """Open a file in a folder (CaptureError: it leads out), and return its descriptor."""
    check_inside(path, folder)
    root, real = os.path.realpath(folder), os.path.realpath(path)
    if os.open not in os.supports_dir_fd:  # Windows
        return os.open(real, flags)
    descriptor = os.open(root, os.O_RDONLY)
    for part in Path(real).relative_to(root).parts:
        try:
            below = os.open(part, flags | os.O_NOFOLLOW, dir_fd=descriptor)
        except OSError as error:
            raise (_outside(path) if error.errno in _IS_LINK else error) from None
        finally:
            os.close(descriptor)
        descriptor = below
    return descriptor


def _outside(path: Path) -> CaptureError:
    return CaptureError(
        path,
        "expected a file inside the folder, found a link that leads out of it. Copy the file into "
        "the folder.",
    )


_HELD: Counter[tuple[int, int]] = Counter()
_HELD_LOCK = threading.Lock()


@dataclass(frozen=True)
class HeldFile:
    """A database that this process has open, which nothing else here may open and close.

    On POSIX, closing any descriptor of a file ends all locks that the process has on it. Another
    process could then write to the database at the same time.
    """

    key: tuple[int, int]

    @staticmethod
    def hold(path: Path) -> HeldFile:
        """Begin to hold a file."""
        status = path.stat()
        key = (status.st_dev, status.st_ino)
        with _HELD_LOCK:
            _HELD[key] += 1
        return HeldFile(key)

    def let_go(self) -> None:
        """End to hold the file."""
        with _HELD_LOCK:
            _HELD[self.key] -= 1


def check_not_held(status: os.stat_result) -> None:
    """Raise OSError for the status of a file that this process holds as a database."""
    if _HELD[status.st_dev, status.st_ino] > 0:
        raise OSError(errno.EBUSY, "the database that this program has open")


def link_target(path: Path) -> Path:
    """Return the file that a name stands for: the target of a symbolic link, else the name."""
    return Path(os.path.realpath(path)) if path.is_symlink() else path


LOGS = (".wal", ".wal.checkpoint", ".wal.recovery")  # Endings of DuckDB's logs
MARKING, WAITS, COPY = ".marking", ".waits", ".compact"
"""Endings of the files that motiondb keeps beside a database (:func:`beside`)."""
_BESIDE = re.compile(r"\.(.+)(?:" + "|".join(map(re.escape, (MARKING, WAITS, COPY))) + ")")


def log_of(path: Path) -> Path:
    """Return the log that DuckDB keeps beside a database."""
    return path.with_name(f"{path.name}.wal")


def beside(path: Path, ending: str) -> Path:
    """Return a hidden file that motiondb keeps beside a database."""
    return path.with_name(f".{path.name}{ending}")


def count_names(path: Path) -> int:
    """Return how many names (hard links) a file has; 1 for what is no regular file."""
    status = path.stat()
    return status.st_nlink if stat.S_ISREG(status.st_mode) else 1


def check_one_name(path: Path) -> None:
    """Raise OSError for a file with several names (hard links): only one would be replaced."""
    with suppress(FileNotFoundError):
        names = count_names(path)
        if names > 1:
            raise OSError(
                errno.EMLINK,
                f"a file with {names} names (hard links), of which only one would be "
                "replaced; remove names until it has one, or name another file",
            )


def check_output(path: Path, *, is_folder: bool = False) -> None:
    """Raise OSError for the name of an output that belongs to a database, or is no file."""
    if path.is_dir() and not is_folder:
        raise IsADirectoryError(errno.EISDIR, "a folder; name a file in it")
    if is_duckdb(path):
        raise FileExistsError(
            errno.EEXIST, "a database of that name, which is never overwritten; choose another name"
        )
    if path.name.endswith(LOGS):
        raise FileExistsError(errno.EEXIST, "the name of a database's log; choose another name")
    hidden = _BESIDE.fullmatch(path.name)
    if hidden and is_duckdb(path.with_name(hidden[1])):
        raise FileExistsError(
            errno.EEXIST, f"a file of the database {path.with_name(hidden[1])}; choose another name"
        )
    for folder in (path, *Path(os.path.realpath(path)).parents):
        if folder.suffix == ".cache" and is_duckdb(folder.with_suffix("")):
            raise FileExistsError(
                errno.EEXIST, f"the cache of the database {folder.stem}; choose another name"
            )
    if not is_folder and not path.parent.exists():
        raise FileNotFoundError(errno.ENOENT, f"no folder {path.parent}; make it first")
    with suppress(FileNotFoundError):
        _refuse_other_kinds(path.stat().st_mode, False)


check_replacing: ContextVar[Callable[[Path, Path], None]] = ContextVar(
    "called with a file and the draft that would replace it", default=lambda _path, _draft: None
)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a draft that is renamed to ``path`` at the end, or removed after an error.

    Of a link the target is replaced. OSError if ``path`` may not be written (:func:`check_output`).
    """
    path = link_target(path)
    check_output(path)
    check_one_name(path)
    sweep_drafts(path.parent, re.escape(draft_stem(path)))
    with free_draft(path) as draft:
        yield draft
        check_replacing.get()(path, draft)
        draft.replace(path)


@contextmanager
def free_draft(path: Path) -> Iterator[Path]:
    """Yield the name of a draft of a file, where nothing is, not even a link; it is deleted after.

    The draft of a database may have a log, and the mark of one.
    """
    draft = draft_of(path)
    files = draft, log_of(draft), beside(draft, MARKING)
    delete_all(*files)  # of an earlier process of the same number
    try:
        for file in files:
            if os.path.lexists(file):
                raise PermissionError(errno.EPERM, f"{file.name}, which cannot be removed")
        yield draft
    finally:
        delete_all(*files)


@contextmanager
def output_file(path: Path, kind: type[MotionDBError] = MotionDBError) -> Iterator[Path]:
    """Yield a draft as :func:`whole_file`; an error of the system becomes one of motiondb."""
    try:
        with whole_file(path) as draft:
            yield draft
    except OSError as error:
        reason = f"{path}: expected a file that can be written, found: {error.strerror or error}."
        is_told = isinstance(error, FileExistsError | IsADirectoryError | FileNotFoundError)
        advice = "" if is_told else " Check the folder and its disk."
        raise kind(reason + advice) from None


def write_bytes(path: Path, data: bytes, kind: type[MotionDBError] = MotionDBError) -> Path:
    """Write a file that a user names, whole or not at all."""
    with output_file(path, kind) as draft:
        draft.write_bytes(data)
    return path


def delete_all(*files: Path) -> None:
    """Delete those of the files that are there and may be deleted."""
    for file in files:
        with suppress(OSError):
            file.unlink(missing_ok=True)


def is_duckdb(path: Path) -> bool:
    """Return whether there is a database file of this name, going by what stands in it."""
    try:
        with open_file(path) as file:
            return file.read(12)[8:] == b"DUCK"
    except (OSError, ValueError) as error:
        return getattr(error, "errno", None) == errno.EBUSY  # this program has it open


def is_running(process: int) -> bool:
    """Return whether this host has a process of this number, or True if that is not known."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True  # of another user
    return True


def sweep_drafts(folder: Path, stem: str) -> None:
    """Delete drafts whose process has ended; those of this process may be of another thread.

    `stem`: Pattern of the names that were to be written. A draft may have a draft of its own,
    a log, and the mark of one.
    """
    names = [left.name for left in folder.glob(".*.part*")]
    delete_all(*(folder / name for name in ended_drafts(names, stem)))


def sweep_databases(folder: Path) -> None:
    """Delete drafts of databases of any name whose process has ended; a copy has a new name.

    A process of another machine that shares the folder holds a lock on its draft.
    """
    names = [left.name for left in folder.glob(".*.part")]
    for draft in (folder / name for name in ended_drafts(names, ".+")):
        if not draft.is_symlink() and is_duckdb(draft) and not _is_locked(draft):
            delete_all(draft, log_of(draft), beside(draft, MARKING))


def _is_locked(path: Path) -> bool:
    """Whether another process holds a lock on a file, or may."""
    try:
        import fcntl

        with path.open("r+b") as file:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (ImportError, OSError):
        return True
    return False


def ended_drafts(names: Iterable[str], stem: str) -> list[str]:
    """Those of some names that :func:`sweep_drafts` deletes."""
    draft = re.compile(rf"\.+(?:{stem})(?:\.(\d+)\.\d+\.part)+(?:\.wal|\.marking)?")
    owners = ((name, draft.fullmatch(name)) for name in names)
    return [name for name, owner in owners if owner and not is_running(int(owner[1]))]


def draft_of(path: Path) -> Path:
    """Return the draft of a file by this thread."""
    return path.with_name(f".{draft_stem(path)}.{os.getpid()}.{threading.get_ident()}.part")


def draft_stem(path: Path) -> str:
    """Return how the names of a file's drafts begin, after the dot."""
    return path.name.encode("utf-8", "replace")[:_LONGEST].decode("utf-8", "ignore")


def read_bounded(path: Path, most: int = MOST_TEXT) -> bytes:
    """Return the content of a regular file that is not too large."""
    with open_file(path) as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"more than {most / 1e6:g} MB")
    return data


def read_bounded_text(path: Path) -> str:
    r"""Return the text of a file that is not too large, with ``\n`` for every end of line."""
    return io.TextIOWrapper(io.BytesIO(read_bounded(path)), "utf-8-sig").read()


def read_user_text(path: Path, what: str) -> str:
    """Read a text that a person wrote, in UTF-8.

    Parameters
    ----------
    path : Path
        The file.
    what : str
        What it should be, such as "a file of questions".

    Raises
    ------
    MotionDBError
        When it cannot be read, or is not in UTF-8.
    """
    try:
        return read_bounded_text(Path(path))
    except FileNotFoundError:
        raise MotionDBError(f"{path}: expected {what}, found no such file.") from None
    except OSError as error:
        raise MotionDBError(
            f"{path}: expected {what} that can be read, found: {error.strerror}."
        ) from None
    except UnicodeDecodeError:
        raise MotionDBError(
            f"{path}: expected text in UTF-8, found another encoding. Save it as UTF-8."
        ) from None


def is_file(name: str | os.PathLike[str]) -> bool:
    """Return whether there is a file of this name.

    >>> is_file("n" * 300)
    False
    """
    try:
        return Path(name).is_file()
    except (OSError, ValueError):
        return False


def is_folder(name: str | os.PathLike[str]) -> bool:
    """Return whether there is a folder of this name.

    >>> is_folder("."), is_folder("n" * 300)
    (True, False)
    """
    try:
        return Path(name).is_dir()
    except (OSError, ValueError):
        return False


def odd_kind(name: str | os.PathLike[str]) -> str:
    """Return what a name stands for that is there but no file, with advice; or "".

    >>> odd_kind("."), odd_kind("n" * 300)
    ('a folder; name a file', '')
    """
    try:
        mode = Path(name).stat().st_mode
    except PermissionError:
        return "a folder on the way to it that this user may not read"
    except (OSError, ValueError):
        return ""
    kinds = ((stat.S_ISDIR, "a folder; name a file"), *_OTHER_KINDS)
    return next((reason for is_kind, reason in kinds if is_kind(mode)), "")


def plain_name(path: Path) -> str:
    """Return the name of a file so that DuckDB takes it for no more than that.

    DuckDB keeps a database called ``:memory:`` nowhere, and looks for one called ``md:x`` or
    ``sqlite:x`` at other programs.

    >>> plain_name(Path(":memory:")), plain_name(Path("/data/a.duckdb"))
    ('./:memory:', '/data/a.duckdb')
    """
    return os.path.join(".", path)  # noqa: PTH118  pathlib drops the dot


def check_file_name(path: Path) -> None:
    """Refuse the name of a database that the system cannot have, or of a database's log."""
    if not path.name:  # "", "." and "/"
        raise StoreError(
            f"{path}: expected a database of motiondb, found a folder. Name another file with --db."
        )
    if path.name.endswith(LOGS):
        raise StoreError(
            f"{path}: expected the name of a database, found that of a database's log. "
            "Give another name."
        )
    if "\0" in str(path):
        raise StoreError(
            f"{str(path)!r}: expected the name of a file, found: a name that no system accepts. "
            "Give another name."
        )
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        shown = os.fsencode(path).decode("utf-8", "backslashreplace")
        raise StoreError(
            f"{shown}: expected a file name in UTF-8, found other bytes. Give another name."
        ) from None
    try:
        path.exists()
        log_of(beside(path, COPY)).exists()  # the longest name beside it
    except PermissionError:
        raise StoreError(
            f"{path}: expected a file in a folder that this user may read, found: permission "
            "denied. Get the right to read the folder."
        ) from None
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise StoreError(
            f"{str(path)[:100]}: expected the name of a file, found: {reason}. Give another name."
        ) from None


def unwritable(folder: Path, error: OSError) -> MotionDBError:
    """The error for a folder that the system does not let be written."""
    return MotionDBError(
        f"{folder}: expected a folder that can be written, found: {error.strerror or error}."
        " Check its permissions and the room on its disk."
    )


def _mend(folder: Path) -> None:
    """Repair the state that killed processes left while they wrote this folder.

    An earlier folder that had been moved away is restored; partial folders are removed.
    """
    for left in folder.parent.glob(f".{glob.escape(folder.name)}.*.*"):
        owner, _, kind = left.name.removeprefix(f".{folder.name}.").rpartition(".")
        if kind not in ("part", "old") or not owner.isdigit() or is_running(int(owner)):
            continue
        if kind == "old" and not folder.exists():
            left.rename(folder)
        else:
            shutil.rmtree(left, ignore_errors=True)


@contextmanager
def whole_folder(folder: Path, check: Callable[[Path], None]) -> Iterator[Path]:
    """Give a folder to write into; rename it to ``folder`` on success, remove it otherwise.

    A link stays: the folder that it stands for is replaced. What a killed process left of it is
    removed first. `check`: Raises where the folder may not be replaced.
    """
    folder = link_target(folder)
    _mend(folder.absolute())
    check(folder)
    folder = folder.absolute()
    part = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    old = folder.with_name(f".{folder.name}.{os.getpid()}.old")
    try:
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir()
        yield part
        if folder.exists():
            folder.rename(old)
        try:
            part.rename(folder)
        except OSError:
            if old.exists():
                old.rename(folder)
            raise
    except OSError as error:
        raise unwritable(folder, error) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)
