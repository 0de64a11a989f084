"""Many questions to workers that can open the database: each answers some of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.database.lent import Lent
from motiondb.database.loading import FEATURES
from motiondb.database.questions import Posed, answer, or_error
from motiondb.database.searching import Searched, searched
from motiondb.database.session import Session
from motiondb.errors import ClusterError, MotionDBError, StoreError
from motiondb.search.by_words import WordAnswer
from motiondb.workers import Workers, runs

if TYPE_CHECKING:
    from motiondb.database.questions import Answer, Found


@dataclass(frozen=True)
class DatabaseFile:
    """A database that workers open themselves."""

    path: Path
    state: str  # Another one when anything in it has changed

    @classmethod
    def of(cls, session: Session) -> DatabaseFile:
        """The database of a session, in a ``reading`` block."""
        return cls(session.store.path.resolve(), _state(session.store))

    @contextmanager
    def opened(self) -> Iterator[Session]:
        """A session that reads it; StoreError if it is not the database that asks."""
        with _lend(self).use() as session, session.reading():
            if _state(session.store) != self.state:
                raise StoreError(
                    f"{self.path}: expected the database that asks, found another state of it."
                )
            yield session

    @contextmanager
    def searched(self) -> Iterator[Searched]:
        """What questions are asked of."""
        try:
            with self.opened() as session:
                yield searched(session)
        except MotionDBError as error:
            raise ClusterError(
                f"{self.path}: expected a database that every worker can open while questions are "
                f"answered, found a worker that cannot ({error}) Ask again; give new workers the "
                "folder, too."
            ) from None


def opened_by(workers: Workers, session: Session) -> DatabaseFile | None:
    """The database of a session if all workers can open it, in a ``reading`` block; else None."""
    if not session.store.read_only:  # no other process can open it
        return None
    file = DatabaseFile.of(session)
    if workers.agree(can_open, file):
        return file
    workers.agree(close, file)
    return None


def answers(
    file: DatabaseFile, posed: Sequence[Posed | MotionDBError], workers: Workers
) -> Iterator[Answer]:
    """Answers to questions in their order; errors stay as they are."""
    try:
        for part in workers.map(_answer_some, runs(posed, workers.n_pieces()), file):
            yield from part
    finally:
        with suppress(ClusterError):  # of a scheduler that went away
            workers.agree(close, file)


def _state(opened: store.Store) -> str:
    return repr((store.revision(opened), store.learning_mark(opened)))


_lent = dict[DatabaseFile, "Lent[Session]"]()
"""The database that this process answers from for another one, if any."""


def _lend(file: DatabaseFile) -> Lent[Session]:
    """The database of questions; what was loaded of it stays until they are answered."""
    if file not in _lent:
        _lent.clear()  # of a process that ended before it could say so
        session = Session(file.path, read_only=True)
        _lent[file] = Lent(session, session.store.lend)
    return _lent[file]


def can_open(file: DatabaseFile) -> bool:
    """Whether this worker can map what it needs of the database that asks."""
    try:
        with file.opened() as session:
            return store.is_cached(session.store, FEATURES)
    except MotionDBError:
        return False


def close(file: DatabaseFile) -> bool:
    """Forget the database of questions that were answered."""
    _lent.pop(file, None)
    return True


def _answer_there(asked: Searched, posed: Posed) -> Found:
    """The answer of a worker."""
    found = answer(asked, posed)
    if not isinstance(found, WordAnswer):
        return found
    told = tuple(partial(tuple[str, ...], suggests()) for suggests in found.suggests)
    return replace(found, suggests=told)  # the functions hold the learned model


def _answer_some(posed: Sequence[Posed | MotionDBError], file: DatabaseFile) -> list[Answer]:
    """Answers to some questions; errors stay as they are."""
    with file.searched() as asked:
        return [
            each if isinstance(each, MotionDBError) else or_error(_answer_there, asked, each)
            for each in posed
        ]
