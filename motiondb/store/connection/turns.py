"""Fair turns: a process that waits for a database says so, and one that holds it can see that.

A server that answers one request after the other would never let go of the file. A process that
waits for it holds a shared lock on an empty file ``.NAME.waits`` beside the database. The system
ends the lock with the process, however that ends. Where no such file can be made, or where the
system has no such locks, nothing is announced, and the process waits by trying again alone.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from motiondb.files.safe_files import WAITS, beside

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]  # Windows has other locks

_FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0)


@contextmanager
def announced(database: Path) -> Iterator[None]:
    """Say, while the block runs, that this process waits for a database."""
    note = _note(database)
    descriptor = _lock(note)
    try:
        yield
    finally:
        if descriptor is not None:
            with suppress(OSError):  # another process still waits
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                note.unlink()
            os.close(descriptor)


def somebody_waits(database: Path) -> bool:
    """Return whether a process waits for a database; a note without one is removed."""
    if fcntl is None:  # a note on a shared disk is of another system
        return False
    note = _note(database)
    try:
        descriptor = os.open(note, _FLAGS)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        note.unlink()
    except OSError as error:
        return isinstance(error, BlockingIOError)
    finally:
        os.close(descriptor)
    return False


def _note(database: Path) -> Path:
    """Return the file by which waiting is announced, the same for all names of a database."""
    real = Path(os.path.realpath(database))
    return beside(real, WAITS)


def _lock(note: Path) -> int | None:
    """Return the note, open and with a shared lock; None if that cannot be had."""
    while fcntl is not None:
        try:
            descriptor = os.open(note, _FLAGS | os.O_CREAT, 0o644)
        except OSError:
            return None
        try:
            fcntl.flock(descriptor, fcntl.LOCK_SH)
            # another process may have removed it before it was locked
            if os.path.samestat(os.fstat(descriptor), note.stat()):
                return descriptor
        except FileNotFoundError:
            pass
        except OSError:
            os.close(descriptor)
            return None
        os.close(descriptor)
    return None
