"""The database, held only while requests are answered.

DuckDB lets one process write or several read. The page holds the file only while it answers, so
that commands can use the database as well; new requests wait while another process waits for the
file. Loaded values stay in memory until the database changes.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from motiondb.answers.database import DatabaseInfo
from motiondb.database import MotionDB
from motiondb.database.loading import make_frames
from motiondb.database.session import Lent
from motiondb.errors import MotionDBError
from motiondb.files.safe_files import link_target, log_of
from motiondb.learn.drift import Drift
from motiondb.store import somebody_waits

_LEAVE, _PAUSE = 1.0, 0.01
"""Seconds for which the file is left to a process that waits for it, which tries five times a
second or more often; and between two checks whether it still waits."""
EXAMPLE = 2.0  # Longest example, in seconds, by which the data for examples are loaded


def info_and_drift(db: MotionDB) -> tuple[DatabaseInfo, Drift | None]:
    """Return what ``info`` and ``drift`` give, computed once a revision; drift may be None."""

    def load() -> tuple[DatabaseInfo, Drift | None]:
        info = db.info()
        return info, db.symbols.drift() if info.learned else None

    return db.session.kept("info and drift", load)


class HeldDatabase:
    """A database that is opened for requests, and released when the last running one has ended."""

    def __init__(self, path: Path, read_only: bool, wait: float) -> None:
        self.path = path
        self._database = MotionDB(path, read_only=read_only, create=not read_only, wait=wait)
        self._lent = Lent(self._database, self._database.release)

    @property
    def log_note(self) -> str:
        """That the file was brought up to date, or came without its log, when opened; or ""."""
        return "\n".join(filter(None, (*self._database.store.notes, self._database.store.log_note)))

    @contextmanager
    def use(self) -> Iterator[MotionDB]:
        """Yield the database; it stays open for the length of the ``with`` block.

        Blocks of one thread must not be nested: the inner one would wait for the outer one if
        another process waits for the file.
        """
        self._give_way()
        with self._lent.use() as db:
            yield db

    def _give_way(self) -> None:
        """Wait until a process that waits for the file has had it, for ``_LEAVE`` s at most."""
        free_since = None
        while somebody_waits(self.path):
            now = time.monotonic()
            if self._lent.is_used:  # running requests end first
                free_since = None
            elif free_since is None:
                free_since = now
            elif now - free_since > _LEAVE:
                return
            time.sleep(_PAUSE)

    def warm_view(self) -> None:
        """Load what the first view of the page needs."""
        with suppress(MotionDBError), self.use() as db:  # the first request will tell
            db.captures.browse()
            info_and_drift(db)

    def warm(self) -> None:
        """Load the data that questions need, so that the first user does not wait for it."""
        self.warm_view()
        with suppress(MotionDBError):
            self._warm_frames()
            with self.use() as db:
                learned = db.learned
                if learned.has_words:
                    db.search(db.words.vocabulary()[0], limit=1)
                if learned.rows:
                    first = learned.captures[min(learned.rows)]
                    db.like(first.name, 0.0, min(first.duration, EXAMPLE), limit=1)

    def _warm_frames(self) -> None:
        """Compute the frames of all captures, while the file is free.

        Of all data they take longest.
        """
        with self.use() as db:
            learned = db.session.without_rows if db.is_learned() else None
            motions = db.session.lacking_frames() if learned else {}
        if learned and motions:
            made = dict(zip(motions, make_frames(learned, list(motions.values()))))
            with self.use() as db:
                db.session.keep_frames(made, learned)

    def close(self) -> None:
        """Close the file."""
        self._database.close()


EVERY = 0.5  # Seconds between two checks of the file
# Number of checks without a change after which the data for questions are loaded: a command that
# follows another immediately can open the file first
QUIET = 3


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
        file = link_target(self._held.path)
        for path in (file, log_of(file)):
            with suppress(OSError):
                facts = path.stat()
                stamp += [facts.st_size, facts.st_mtime_ns, facts.st_ino]
        return tuple(stamp)
