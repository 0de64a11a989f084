"""Many questions, answered by this process or by workers.

Workers that can open the database under its path, as on one machine or with a shared folder, map
what they need of it from its cache; to others it is sent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import numpy as np

from motiondb import store
from motiondb.database.lent import Lent
from motiondb.errors import ClusterError, MotionDBError, QueryError, StoreError
from motiondb.workers import Workers, runs

if TYPE_CHECKING:
    from motiondb.database.searching import Searched
    from motiondb.database.session import Session
    from motiondb.learn.learned import Learned
    from motiondb.learn.recognition import FeaturePool
    from motiondb.records import Motion
    from motiondb.search.asked_words import WrittenWord
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer

    Found: TypeAlias = WordAnswer | ExampleAnswer
    Answer: TypeAlias = Found | MotionDBError
    """An answer, or the error that says why there is none."""

T = TypeVar("T")
Given = TypeVar("Given")
Asked = TypeVar("Asked")


@dataclass(frozen=True)
class Question:
    """A question in words or by example; give one of ``words`` and ``like``.

    Parameters
    ----------
    words : str
        The question, such as "walk, turn left".
    like : str
        The name of a capture, or of a file, as the example.
    start, end : float, optional
        Part of the example, s.
    where : str
        A filter on the catalogue: the captures that are searched.
    limit : int
        Largest number of matches.
    exact : bool
        Whether unknown words are left as they are, instead of being replaced by known ones.
    """

    words: str = ""
    like: str = ""
    start: float | None = None
    end: float | None = None
    where: str = ""
    limit: int = 10
    exact: bool = False


def ask_many(
    session: Session,
    motion_of: Callable[[Question], Motion],
    questions: Iterable[Question],
    workers: Workers | None,
) -> Iterator[Answer]:
    """The answers in the order of the questions, as ``MotionDB.ask_many`` gives them.

    `motion_of`: Loads the example of a question. No block reads while an answer is looked at: its
    reader may change the database.
    """
    if workers is None:
        for question in questions:
            with session.reading():
                answer = _or_error(_answer_here, _Opened(session, motion_of), question)
            yield answer
        return
    with session.reading():
        opened = _Opened(session, motion_of)
        posed = [_or_error(_Opened.pose, opened, question) for question in questions]
        errors = [each for each in posed if isinstance(each, MotionDBError)]
        if len(errors) < len(posed):
            held = _held_by(workers, session)
    if len(errors) == len(posed):  # such as a database that has not learned
        yield from errors
        return
    try:
        for part in workers.map(_answer_some, runs(posed, workers.n_pieces()), held):
            yield from part
    finally:
        if isinstance(held, _File):
            with suppress(ClusterError):  # of a scheduler that went away
                workers.agree(_close, held)


def _held_by(workers: Workers, session: Session) -> _File | _Knowledge:
    """What workers answer from: the file, or what is sent to them."""
    file = _File.of(session)
    if session.store.read_only:  # otherwise no other process can open it
        if workers.agree(_can_open, file):
            return file
        workers.agree(_close, file)
    return _Knowledge(session.searchable, _in_memory(session.features))


def _or_error(ask: Callable[[Given, Asked], T], given: Given, asked: Asked) -> T | MotionDBError:
    """The answer, or the error that says why there is none."""
    try:
        return ask(given, asked)
    except MotionDBError as error:
        return error


def _check(question: Question) -> None:
    """Refuse a question without words and example, and one with both."""
    if bool(question.words.strip()) == bool(question.like):
        found = "both" if question.like else "neither"
        raise QueryError(f"question: expected words or an example (like), found {found}.")
    if question.words and (question.start is not None or question.end is not None):
        raise QueryError(
            "question: expected start and end for an example only, found them with words."
        )


@dataclass(frozen=True, eq=False)
class _Posed:
    """A question with all that only the process with the file can look up."""

    question: Question
    allowed: list[int] | None  # Numbers of the captures that are searched; None: all
    motion: Motion | None  # The example


@dataclass(frozen=True, eq=False)
class _Opened:
    """The process with the file."""

    session: Session
    motion_of: Callable[[Question], Motion]

    def pose(self, question: Question) -> _Posed:
        """Look up what is searched, and the example."""
        from motiondb.database import arguments, searching

        _check(question)
        arguments.check_least("limit", question.limit, 1)
        motion = self.motion_of(question) if question.like else None
        allowed = None  # said in a word, and not by as many numbers for each of many questions
        if question.where.strip():
            allowed = searching.allowed_captures(self.session, question.where, question.exact)
        searching.check_any(self.session.searchable)
        return _Posed(question, allowed, motion)


@dataclass(frozen=True, eq=False)
class _Knowledge:
    """What a worker needs to answer questions, where it cannot open the database."""

    learned: Learned
    pool: FeaturePool

    @cached_property
    def written(self) -> dict[str, WrittenWord]:
        """Words that were not learned and are written in captions or tags."""
        from motiondb.search.asked_words import find_written

        return find_written(self.learned)

    @contextmanager
    def searched(self) -> Iterator[Searched]:
        """What questions are asked of."""
        from motiondb.database import searching

        yield searching.Searched(self.learned, lambda: self.pool, lambda: self.written)


@dataclass(frozen=True)
class _File:
    """A database that workers open themselves."""

    path: Path
    state: str  # Another one when anything in it has changed

    @classmethod
    def of(cls, session: Session) -> _File:
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
        from motiondb.database import searching

        try:
            with self.opened() as session:
                yield searching.searched(session)
        except MotionDBError as error:
            raise ClusterError(
                f"{self.path}: expected a database that every worker can open while questions are "
                f"answered, found a worker that cannot ({error}) Ask again; give new workers the "
                "folder, too."
            ) from None


def _state(opened: store.Store) -> str:
    return repr((store.revision(opened), store.learning_mark(opened)))


_lent = dict[_File, "Lent[Session]"]()
"""The database that this process answers from for another one, if any."""


def _lend(file: _File) -> Lent[Session]:
    """The database of questions; what was loaded of it stays until they are answered."""
    from motiondb.database.session import Session

    if file not in _lent:
        _lent.clear()  # of a process that ended before it could say so
        session = Session(file.path, read_only=True)
        _lent[file] = Lent(session, session.store.lend)
    return _lent[file]


def _can_open(file: _File) -> bool:
    """Whether this worker can map what it needs of the database that asks."""
    from motiondb.database.loading import FEATURES

    try:
        with file.opened() as session:
            return store.is_cached(session.store, FEATURES)
    except MotionDBError:
        return False


def _close(file: _File) -> bool:
    """Forget the database of questions that were answered."""
    _lent.pop(file, None)
    return True


def _answer_here(opened: _Opened, question: Question) -> Found:
    """The answer of the process with the file."""
    from motiondb.database import searching

    posed = opened.pose(question)
    return _answer(searching.searched(opened.session), posed)


def _answer_there(searched: Searched, posed: _Posed) -> Found:
    """The answer of a worker."""
    from motiondb.search.by_words import WordAnswer

    answer = _answer(searched, posed)
    if not isinstance(answer, WordAnswer):
        return answer
    told = tuple(partial(tuple[str, ...], suggests()) for suggests in answer.suggests)
    return replace(answer, suggests=told)  # the functions hold the learned model


def _answer(searched: Searched, posed: _Posed) -> Found:
    from motiondb.database import searching
    from motiondb.search.by_example import search_motion

    asked, motion = posed.question, posed.motion
    allowed = list(searched.learned.captures) if posed.allowed is None else posed.allowed
    if motion is not None:
        return search_motion(searched.learned, searched.pool(), motion, allowed, asked.limit)
    return searching.answer_words(
        searched, asked.words, allowed, asked.limit, False, True, asked.exact
    )


def _in_memory(pool: FeaturePool) -> FeaturePool:
    """The pool with its features in memory, to be sent."""
    return replace(pool, features=np.asarray(pool.features))


def _answer_some(posed: Sequence[_Posed | MotionDBError], held: _File | _Knowledge) -> list[Answer]:
    """Answers to some questions; errors stay as they are."""
    with held.searched() as searched:
        return [
            each if isinstance(each, MotionDBError) else _or_error(_answer_there, searched, each)
            for each in posed
        ]
