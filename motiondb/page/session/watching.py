"""Noticing changes of the database, whoever makes them."""

from __future__ import annotations

import threading
from contextlib import suppress

from motiondb.errors import MotionDBError
from motiondb.page.session.held import HeldDatabase

EVERY = 0.5
"""Seconds between two looks at the file. Chosen by hand: below what a user waits for."""
QUIET = 3
"""Looks without a change after which what questions need is loaded. Chosen by hand: a command that
follows another at once gets its turn."""


class Watch:
    """The revision of a database, looked at in a thread.

    Only the size and the time of the file are looked at, so that the file is not held.

    Parameters
    ----------
    held : HeldDatabase
        The database.
    warm : bool
        Whether to load what questions need after a change.
    """

    def __init__(self, held: HeldDatabase, warm: bool) -> None:
        self._held, self._warms = held, warm
        self._ended = threading.Event()
        self._mark = self._stamp()
        self.revision = self._read()

    def start(self) -> None:
        """Begin to look."""
        threading.Thread(target=self._look, daemon=True).start()

    def stop(self) -> None:
        """Look no more."""
        self._ended.set()

    def _look(self) -> None:
        if self._warms:  # whoever starts the server opens the page next
            self._held.warm_view()
        quiet, is_warm = 0, not self._warms
        while not self._ended.wait(EVERY):
            mark = self._stamp()
            if mark != self._mark:
                quiet, is_warm = 0, not self._warms
                with suppress(MotionDBError):  # held by another process: look again
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
        """Return size and time of the file and of what DuckDB writes beside it."""
        stamp: list[int] = []
        for path in (self._held.path, self._held.path.with_name(f"{self._held.path.name}.wal")):
            with suppress(OSError):
                facts = path.stat()
                stamp += [facts.st_size, facts.st_mtime_ns, facts.st_ino]
        return tuple(stamp)
