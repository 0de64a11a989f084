"""Detection of changes of the database, by this or any other process."""

from __future__ import annotations

import threading
from contextlib import suppress

from motiondb.errors import MotionDBError
from motiondb.page.session.held import HeldDatabase

EVERY = 0.5
"""Seconds between two checks of the file. Chosen by hand: shorter than a user minds waiting."""
QUIET = 3
"""Number of checks without a change after which the data for questions are loaded. Chosen by
hand: a command that follows another immediately can open the file first."""


class Watch:
    """The revision of a database, watched by a thread.

    Only the size and the modification time of the file are checked, so that the file is not held.
    """

    def __init__(self, held: HeldDatabase, warm: bool) -> None:
        self._held, self._warms = held, warm
        self._ended = threading.Event()
        self._mark = self._stamp()
        self.revision = self._read()

    def start(self) -> None:
        """Start the thread."""
        threading.Thread(target=self._look, daemon=True).start()

    def stop(self) -> None:
        """Stop the thread."""
        self._ended.set()

    def _look(self) -> None:
        if self._warms:  # whoever starts the server opens the page next
            self._held.warm_view()
        quiet, is_warm = 0, not self._warms
        while not self._ended.wait(EVERY):
            mark = self._stamp()
            if mark != self._mark:
                quiet, is_warm = 0, not self._warms
                with suppress(MotionDBError):  # held by another process: try again later
                    revision = self._read()
                    self._mark, self.revision = mark, revision
            elif not is_warm:
                quiet += 1
                if quiet >= QUIET:
                    is_warm = True
                    self._held.warm()

    def _read(self) -> int:
        with self._held.use() as db:
            return db.revision()

    def _stamp(self) -> tuple[int, ...]:
        """Return size, time and inode of the file and of DuckDB's write-ahead log."""
        stamp: list[int] = []
        for path in (self._held.path, self._held.path.with_name(f"{self._held.path.name}.wal")):
            with suppress(OSError):
                facts = path.stat()
                stamp += [facts.st_size, facts.st_mtime_ns, facts.st_ino]
        return tuple(stamp)
