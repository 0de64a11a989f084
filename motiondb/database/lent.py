"""A database that is open only while it is used, so that other processes can use it as well."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from motiondb.database.motion_db import MotionDB


class LentDatabase:
    """A database that is opened for those who use it, and released when the last has ended.

    Loaded values stay in memory until the database changes.
    """

    def __init__(self, path: Path, read_only: bool, wait: float = 0.0) -> None:
        self.path = path
        self.database = MotionDB(path, read_only=read_only, create=not read_only, wait=wait)
        self._lock = threading.Lock()
        self._users = 0
        self.database.release()

    @contextmanager
    def use(self) -> Iterator[MotionDB]:
        """Yield the database; it stays open for the length of the ``with`` block."""
        with self._lock:
            self._users += 1
        try:
            yield self.database
        finally:
            with self._lock:
                self._users -= 1
                if not self._users:
                    self.database.release()

    @property
    def is_used(self) -> bool:
        """Whether anybody uses it now."""
        return self._users > 0

    def close(self) -> None:
        """Close the file."""
        self.database.close()
