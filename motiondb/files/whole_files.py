"""Files that appear whole or not at all, and drafts that a killed process left of them.

A draft has the name ``.NAME.PROCESS.THREAD.part`` beside the file, with NAME cut to
:data:`_LONGEST`. It is renamed when it is complete. A process that is killed leaves its draft; the
next one that writes the same file removes it.
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

_LONGEST = 120
"""Bytes of a file's name that its draft keeps: a name has at most 255 on most file systems, and the
numbers of a process and a thread take about 35."""
_OWNER = re.compile(r"\.(\d+)\.\d+\.part$")


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

    `abandoned`: Age in seconds at which it counts as left by a kill, even if a process of this
    number runs: numbers are used again. Chosen by hand; not tuned. Writing 1 GB takes about 5 s.
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
