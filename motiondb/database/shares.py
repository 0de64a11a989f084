"""The captures of a database in shares, each of which a worker asks the steps of questions.

A worker that can open the database under its path, as on one machine or with a shared folder, maps
what it needs of it from its cache. To others, their shares are sent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from motiondb import store
from motiondb.database.lent import Lent
from motiondb.database.loading import FEATURES, nearby_table
from motiondb.database.session import Session
from motiondb.errors import ClusterError, MotionDBError, StoreError
from motiondb.learn import shares
from motiondb.search.asked_words import find_written
from motiondb.search.asking import AskedQuestion, ask
from motiondb.search.by_example import AskedExample, Example
from motiondb.search.steps import Place, Step
from motiondb.symbols.hmm_jobs import one_blas_thread

if TYPE_CHECKING:
    from motiondb.learn.learned import Learned
    from motiondb.learn.recognition import FeaturePool
    from motiondb.meaning.windows import ComparedSegments
    from motiondb.search.asked_words import WrittenWord

QUESTIONS = 32
"""Questions whose steps are told together. A share keeps what it computed of the last of them, some
5 MB for an example and 20 hours of motion."""


@dataclass(frozen=True)
class Words:
    """A question in words, as it is sent: a share understands it as the asking process does."""

    text: str
    exact: bool
    is_near: bool  # Whether near words stand in place of its own


@dataclass(frozen=True, eq=False)
class AskedStep:
    """A step of a question to a share."""

    key: tuple[str, int, bool]  # Of what is asked, the same for all its steps
    asked: Words | Example
    captures: Sequence[int] | None  # Those of the share that are asked; None: all
    step: Step[Any, Any]


class OpenShare:
    """Captures that follow one another, of a learned model that has their rows."""

    def __init__(
        self, learned: Learned, pool: Callable[[], FeaturePool], captures: Sequence[int]
    ) -> None:
        self._learned, self._pool, self._captures = learned, pool, dict.fromkeys(captures)
        self._rows = shares.segments_of(learned, captures)
        self._asked: dict[tuple[str, int, bool], AskedQuestion | AskedExample] = {}

    def tell(self, step: AskedStep) -> Any:  # noqa: ANN401  of any step
        """What the captures say, or the error that says why they cannot."""
        own = self._captures if step.captures is None else dict.fromkeys(step.captures)
        place = Place(own, lambda capture: self._pool().of_capture(capture))
        try:
            with one_blas_thread():
                told = step.step.tell(self._understood(step), place)
                return dict(told) if isinstance(told, Mapping) else told
        except MotionDBError as error:
            return error

    def _understood(self, step: AskedStep) -> AskedQuestion | AskedExample:
        """What is asked; that of the last questions is kept."""
        if step.key not in self._asked:
            self._asked[step.key] = self._understand(step.asked)
            for old in list(self._asked)[: -2 * QUESTIONS]:  # each may have a near one
                del self._asked[old]
        return self._asked[step.key]

    def _understand(self, asked: Words | Example) -> AskedQuestion | AskedExample:
        if isinstance(asked, Example):
            return AskedExample(self._learned, asked, self._compared, self._rows.start)
        question = ask(self._learned, asked.text, nearby_table(), self._find_written, asked.exact)
        if not asked.is_near:
            return question
        near = question.with_near_words(nearby_table())
        assert near is not None  # the asking process has understood it
        return near

    @cached_property
    def _compared(self) -> ComparedSegments:
        return self._learned.compared_rows(self._rows)

    @cached_property
    def _written(self) -> dict[str, WrittenWord]:
        return find_written(self._learned)

    def _find_written(self) -> dict[str, WrittenWord]:
        """Words that were not learned and are written in captions or tags."""
        return self._written


class SentShare:
    """A share that is sent to a worker, with its rows."""

    def __init__(self, share: shares.Share) -> None:
        self.captures, self.share = share.captures, share
        self._opened: tuple[shares.Rest, OpenShare] | None = None

    @contextmanager
    def opened(self, rest: shares.Rest | None) -> Iterator[OpenShare]:
        """The share with all the rest of the model; it stays open."""
        assert rest is not None
        if self._opened is None or self._opened[0] is not rest:
            learned, pool = shares.joined(rest, self.share), self.share.pool
            self._opened = rest, OpenShare(learned, lambda: pool, self.captures)
        yield self._opened[1]

    def __reduce__(self) -> tuple[type[SentShare], tuple[shares.Share]]:
        """Another process opens it itself."""
        return SentShare, (self.share,)


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


@dataclass(frozen=True)
class FileShare:
    """A share of a database that a worker opens itself."""

    file: DatabaseFile
    captures: tuple[int, ...]

    @contextmanager
    def opened(self, _rest: shares.Rest | None) -> Iterator[OpenShare]:
        """The share; what was loaded of it stays until the database is closed."""
        path = self.file.path
        try:
            with self.file.opened() as session:
                yield session.kept(self.captures, lambda: self._open(session))
        except MotionDBError as error:
            raise ClusterError(
                f"{path}: expected a database that every worker can open while questions are "
                f"answered, found a worker that cannot ({error}) Ask again; give new workers the "
                "folder, too."
            ) from None

    def _open(self, session: Session) -> OpenShare:
        return OpenShare(session.searchable, lambda: session.features, self.captures)


CaptureShare: TypeAlias = SentShare | FileShare


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


def tell(piece: tuple[CaptureShare, Sequence[AskedStep]], rest: shares.Rest | None) -> list[Any]:
    """What a share says to some steps, by a worker."""
    share, steps = piece
    with share.opened(rest) as opened:
        return [opened.tell(step) for step in steps]
