"""One open database: the store, and the only cache of loaded data.

Everything that is kept belongs to one revision of the store, which every committed change raises
(:func:`motiondb.store.revision`). Cached values are used as long as the revision is the same, and
need not be removed by hand. Threads may share a session. What loads the learned model and the
features (:mod:`motiondb.database.loading`) is imported when it is asked for: listing needs none.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from motiondb import store

if TYPE_CHECKING:
    from motiondb.database.loading import FramesMade
    from motiondb.database.values import Where
    from motiondb.learn.learned import Learned
    from motiondb.learn.recognition import FramePool
    from motiondb.records import FloatArray, Motion
    from motiondb.search.seen_frames import Frames


T = TypeVar("T")


def damage_sentence(path: Path, names: Iterable[str]) -> str:
    """That the motions of some captures cannot be read, and what to do."""
    return (
        f"{path}: expected motions that can be read, found damaged ones of "
        f"{', '.join(sorted(names))}, which answers leave out. Restore a copy, save what is "
        f"readable: motiondb rescue {path} -o NEW.duckdb, or remove them and run motiondb learn."
    )


class Session:
    """The store of one open database, and the values kept for its present revision."""

    def __init__(
        self, path: str | Path, *, read_only: bool = False, create: bool = True, wait: float = 0.0
    ) -> None:
        self.store = store.open_store(path, read_only=read_only, create=create, wait=wait)
        self._lock = threading.RLock()
        self._revision = -1
        self._kept: dict[Hashable, Any] = {}
        self._loading: dict[Hashable, threading.RLock] = {}

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self.store.close()

    def filter(self, where: Where) -> str:
        """The text of a filter; a list of names becomes one for their captures alone."""
        if isinstance(where, str):
            return where
        with self.reading():
            numbers = [str(info.capture_id) for info in store.load_named(self.store, list(where))]
        return f"capture_id in ({', '.join(numbers or ['-1'])})"

    @contextmanager
    def reading(self) -> Iterator[None]:
        """One state of the database for the whole block, even if others save changes."""
        with store.reading(self.store):
            yield

    def kept(self, key: Hashable, load: Callable[[], T]) -> T:
        """A value for the revision that is being read: kept, or loaded now.

        `load`: Loads it; called in a ``reading`` block. It may ask for other values, but not for
        those that are loaded with this one. Other threads that ask for the same value wait for it.
        Nothing is kept where it raises, within a transaction, or while a block reads an earlier
        revision than the newest one read.
        """
        with store.reading(self.store) as revision:
            if self.store.in_transaction:  # it may yet be undone
                return load()
            with self._lock:
                if revision > self._revision:
                    self._revision, self._kept, self._loading = revision, {}, {}
                is_newest = revision == self._revision
                if is_newest and key in self._kept:
                    return cast(T, self._kept[key])
                loading = self._loading.setdefault(key, threading.RLock())
            if not is_newest:
                return load()
            with loading:  # of this value only: a long load keeps nobody from other values
                return self._loaded(key, revision, load)

    def _loaded(self, key: Hashable, revision: int, load: Callable[[], T]) -> T:
        """The value that another thread has loaded meanwhile, or a new one, which is kept."""
        with self._lock:
            if revision == self._revision and key in self._kept:
                return cast(T, self._kept[key])
        value = load()
        with self._lock:
            if revision == self._revision:
                self._kept[key] = value
        return value

    @property
    def without_rows(self) -> Learned:
        """The learned model and the catalogue, for which no motions and scores are looked at."""
        from motiondb.database import loading

        return self.kept("without_rows", lambda: loading.load_without_rows(self.store))

    @property
    def learned(self) -> Learned:
        """The learned model, with the catalogue of the same revision."""
        from motiondb.database import loading

        def load() -> Learned:
            held = loading.load_learned(self.store, self.without_rows, lambda: self.pool)
            return loading.prepared(self.store, held)

        return self.kept("learned", load)

    @property
    def damage_note(self) -> str:
        """Which captures were left out of answers, since their motions cannot be read; else ""."""
        with self._lock:
            learned = cast("Learned | None", self._kept.get("learned"))
        damaged = [] if learned is None else list(learned.damaged.values())
        return damage_sentence(self.store.path, damaged) if damaged else ""

    @property
    def searchable(self) -> Learned:
        """The learned model, with the generated captures in addition to those learned from.

        ``learn`` passes over generated captures, so that the database does not learn from itself.
        They take no part in counts, nor as material for further generation. Search finds them: here
        they are cut and scored by the learned symbols.
        """
        from motiondb.database import loading

        return self.kept("searchable", lambda: loading.searchable(self.store, self.learned))

    @property
    def pool(self) -> FramePool:
        """What questions look at in the frames of all captures."""
        from motiondb.database import loading

        return self.kept("pool", lambda: loading.load_frames(self.store, self.without_rows))

    @property
    def frames(self) -> Frames:
        """What questions look at in the captures."""
        from motiondb.meaning.occurrences import measured_track
        from motiondb.search.seen_frames import Frames

        opened = self.store

        def track(capture: int) -> FloatArray:
            return measured_track(store.unflatten_motion(store.load_poses(opened, capture)))

        return self.kept("frames", lambda: Frames(self.pool, track))

    def lacking_frames(self) -> dict[int, Motion]:
        """Motions of the captures whose frames are not in the cache of the database."""
        from motiondb.database import loading

        with self.reading():
            mark = loading.frames_mark(self.without_rows)
            return store.lacking_rows(self.store, loading.FRAMES, mark)

    def keep_frames(self, made: Mapping[int, FramesMade], model: Learned) -> None:
        """Keep frames that were computed by a model while the file was free.

        `made`: Those of captures by number; those that were removed meanwhile are left out, and all
        if another model was learned.
        """
        from motiondb.database import loading

        with self.reading():
            if loading.frames_mark(model) != loading.frames_mark(self.without_rows):
                made = {}
            self.kept("pool", lambda: loading.load_frames(self.store, self.without_rows, made))


class Topic:
    """The verbs of one topic, such as ``db.words``.

    Parameters
    ----------
    session : Session
        The open database.
    """

    def __init__(self, session: Session) -> None:
        self.session = session

    @property
    def store(self) -> store.Store:
        """The open store."""
        return self.session.store


Opened = TypeVar("Opened")


class Lent(Generic[Opened]):
    """A database or session that is released when the last of those who use it has ended.

    `release`: Closes its file until the next use, which opens it again.
    """

    def __init__(self, opened: Opened, release: Callable[[], None]) -> None:
        self.opened, self._release = opened, release
        self._lock = threading.Lock()
        self._users = 0
        release()

    @contextmanager
    def use(self) -> Iterator[Opened]:
        """Yield it; its file stays open for the length of the ``with`` block."""
        with self._lock:
            self._users += 1
        try:
            yield self.opened
        finally:
            with self._lock:
                self._users -= 1
                if not self._users:
                    self._release()

    @property
    def is_used(self) -> bool:
        """Whether anybody uses it now."""
        return self._users > 0
