"""Writing files whole or not at all, reading no more than a file should hold, and names of files.

A draft has the name ``.NAME.PROCESS.THREAD.part`` beside the file, with NAME cut to
:data:`_LONGEST`. It is renamed when it is complete. A process that is killed leaves its draft; the
next one that writes the same file removes it.

A file that a user names may be larger than it should be, or have no end. A pipe is read like a
file, so that a shell may put a program in place of one; so what the system says of a file's size
does not count. And ``pathlib`` raises an error for a name that the system cannot have, such as one
of 300 characters; here such a name is that of no file.
"""

from __future__ import annotations

import errno
import glob
import io
import os
import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from motiondb.errors import StoreError

_LONGEST = 120
"""Bytes of a file's name that its draft keeps: a name has at most 255 on most file systems, and the
numbers of a process and a thread take about 35."""
_OWNER = re.compile(r"\.(\d+)\.\d+\.part$")

MOST_TEXT = 10_000_000
"""Bytes of a text that people write: joint maps, synonyms, diagrams, grammars. A thousand times
what such files hold."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a draft that is renamed to ``path`` at the end, or removed after an error."""
    if is_duckdb(path):
        raise FileExistsError(errno.EEXIST, "a database of that name, which is never overwritten")
    stem = path.name.encode("utf-8", "replace")[:_LONGEST].decode("utf-8", "ignore")
    _sweep(path.parent, stem)
    draft = path.with_name(f".{stem}.{os.getpid()}.{threading.get_ident()}.part")
    try:
        yield draft
        draft.replace(path)
    finally:
        delete_all(draft)


def delete_all(*files: Path) -> None:
    """Delete those of the files that are there and may be deleted."""
    for file in files:
        with suppress(OSError):
            file.unlink(missing_ok=True)


def is_duckdb(path: Path) -> bool:
    """Return whether there is a database file of this name, going by what stands in it."""
    try:
        with path.open("rb") if path.is_file() else io.BytesIO() as file:
            return file.read(12)[8:] == b"DUCK"
    except OSError:
        return False


def is_being_written(draft: Path, abandoned: float = 60.0) -> bool:
    """Tell whether a file ``NAME.new-PROCESS...`` is young and its process runs.

    Files that are ``abandoned`` seconds old count as left by a kill even if a process of this
    number runs: numbers are used again. Writing 1 GB takes about 5 s.
    """
    maker = re.search(r"\.new-([0-9]+)", draft.name)
    if maker is None or not is_running(int(maker[1])):
        return False
    return time.time() - draft.stat().st_mtime < abandoned


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


def _sweep(folder: Path, stem: str) -> None:
    """Delete drafts whose process has ended. Those of this process may be of another thread."""
    for left in folder.glob(f".{glob.escape(stem)}.*.part"):
        owner = _OWNER.search(left.name)
        if owner is None or left.name != f".{stem}{owner[0]}":
            continue
        if not is_running(int(owner[1])):
            delete_all(left)


def read_bounded(path: Path, most: int = MOST_TEXT) -> bytes:
    """Return the content of a file that is not too large."""
    with path.open("rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"more than {most / 1e6:g} MB")
    return data


def read_bounded_text(path: Path, encoding: str = "utf-8-sig") -> str:
    r"""Return the text of a file that is not too large, with ``\n`` for every end of line."""
    return io.TextIOWrapper(io.BytesIO(read_bounded(path)), encoding).read()


def is_file(name: str | os.PathLike[str]) -> bool:
    """Return whether there is a file of this name.

    >>> is_file("n" * 300)
    False
    """
    try:
        return Path(name).is_file()
    except OSError:
        return False


def is_folder(name: str | os.PathLike[str]) -> bool:
    """Return whether there is a folder of this name.

    >>> is_folder("."), is_folder("n" * 300)
    (True, False)
    """
    try:
        return Path(name).is_dir()
    except OSError:
        return False


def plain_name(path: Path) -> str:
    """Return the name of a file so that DuckDB takes it for no more than that.

    DuckDB keeps a database called ``:memory:`` nowhere, and looks for one called ``md:x`` or
    ``sqlite:x`` at other programs.

    >>> plain_name(Path(":memory:")), plain_name(Path("/data/a.duckdb"))
    ('./:memory:', '/data/a.duckdb')
    """
    return os.path.join(".", path)  # noqa: PTH118  pathlib drops the dot


def check_file_name(path: Path) -> None:
    """Refuse the name of a database that the system cannot have."""
    if not path.name:  # "", "." and "/"
        raise StoreError(
            f"{path}: expected a database of motiondb, found a folder. Name another file with --db."
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
        draft = f".{path.name}.new-{os.getpid()}-{threading.get_ident()}.wal"
        path.with_name(draft).exists()  # the longest name of a file made beside it
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise StoreError(
            f"{str(path)[:100]}: expected the name of a file, found: {reason}. Give another name."
        ) from None
