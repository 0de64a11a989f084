"""The database, held only while requests are answered.

DuckDB lets one process write or several read. The page holds the file only while it answers, so
that commands can use the database as well. Loaded values stay in memory until the database changes.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from motiondb.database import MotionDB
from motiondb.database.session import feature_arrays
from motiondb.errors import MotionDBError
from motiondb.learn.drift import Drift

EXAMPLE = 2.0  # Longest example, in seconds, by which the data for examples are loaded


def database_facts(db: MotionDB) -> tuple[dict[str, Any], Drift | None]:
    """Return what ``info`` and ``drift`` give, computed once a revision; drift may be None."""

    def load() -> tuple[dict[str, Any], Drift | None]:
        facts = db.info()
        return facts, db.drift() if facts["learned"] else None

    return db.session.kept("facts of the page", load)


class HeldDatabase:
    """A database that is opened for requests, and released when the last running one has ended."""

    def __init__(self, path: Path, read_only: bool, wait: float) -> None:
        self.path = path
        self._database = MotionDB(path, read_only=read_only, create=not read_only, wait=wait)
        self._lock = threading.Lock()
        self._users = 0
        self._database.release()

    @contextmanager
    def use(self) -> Iterator[MotionDB]:
        """Yield the database; it stays open for the length of the ``with`` block."""
        with self._lock:
            self._users += 1
        try:
            yield self._database
        finally:
            with self._lock:
                self._users -= 1
                if not self._users:
                    self._database.release()

    def warm_view(self) -> None:
        """Load what the first view of the page needs."""
        with suppress(MotionDBError), self.use() as db:  # the first request will tell
            db.browse()
            database_facts(db)

    def warm(self) -> None:
        """Load the data that questions need, so that the first user does not wait for it."""
        self.warm_view()
        with suppress(MotionDBError):
            self._warm_features()
            with self.use() as db:
                learned = db.learned
                if learned.has_words:
                    db.search(db.vocabulary()[0], limit=1)
                if learned.rows:
                    first = learned.captures[min(learned.rows)]
                    db.like(first.name, 0.0, min(first.duration, EXAMPLE), limit=1)

    def _warm_features(self) -> None:
        """Compute the features of all captures, while the file is free.

        Of all data they take longest, and they are computed anew after every change of captures.
        """
        with self.use() as db:
            needed = db.is_learned() and not db.session.has_features()
            motions = db.session.motions if needed else None
        if motions is not None:
            arrays = feature_arrays(motions)
            with self.use() as db:
                db.session.keep_features(motions, arrays)

    def close(self) -> None:
        """Close the file."""
        self._database.close()
