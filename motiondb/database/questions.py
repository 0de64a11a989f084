"""Many questions, answered by this process or by the workers of a cluster.

Workers open the database under its path, as on one machine or in a folder that several machines
share. Each answers some of the questions, and maps what it needs of the database from its cache.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec, TypeAlias, TypeVar

from motiondb import store
from motiondb.database.catalogue.parts import load_example
from motiondb.database.session import Lent, Session
from motiondb.database.values import Where, check_least, listed
from motiondb.errors import ClusterError, MotionDBError, QueryError, StoreError
from motiondb.workers import runs

if TYPE_CHECKING:
    from motiondb.database.cluster import Cluster
    from motiondb.records import Motion
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer

    Found: TypeAlias = WordAnswer | ExampleAnswer
    Answer: TypeAlias = Found | MotionDBError
    """An answer, or the error that says why there is none."""

T = TypeVar("T")
Given = ParamSpec("Given")


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
    where : str or names
        A filter on the catalogue, or names: the captures that are searched.
    limit : int
        Largest number of matches.
    exact : bool
        Whether unknown words are left as they are, instead of being replaced by known ones.
    """

    words: str = ""
    like: str = ""
    start: float | None = None
    end: float | None = None
    where: Where = ""
    limit: int = 10
    exact: bool = False


def check(question: Question) -> None:
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
    """A question with all that the process that asks looks up."""

    question: Question
    allowed: list[int] | None  # Numbers of the captures that are searched; None: all
    motion: Motion | None  # The example


def ask_many(
    session: Session, questions: Iterable[Question | str], workers: Cluster | None
) -> Iterator[Answer]:
    """The answers in the order of the questions, as ``MotionDB.ask_many`` gives them.

    No block reads while an answer is looked at: its reader may change the database.
    """
    if isinstance(questions, str):
        listed("questions", questions)  # refuses it
    asked = (Question(each) if isinstance(each, str) else each for each in questions)
    if workers is None:
        for question in asked:
            with session.reading():
                found = _or_error(lambda one: _answer(session, _pose(session, one)), question)
            yield found
        return
    with session.reading():
        posed = [_or_error(_pose, session, question) for question in asked]
        errors = [each for each in posed if isinstance(each, MotionDBError)]
        file = _file_for(workers, session) if len(errors) < len(posed) else None
    if file is None:  # such as of a database that has not learned
        yield from errors
        return
    try:
        for part in workers.map(_answer_some, runs(posed, workers.n_pieces()), file):
            yield from part
    finally:
        with suppress(ClusterError):  # of a scheduler that went away
            workers.each(close, file)


def _pose(session: Session, question: Question) -> _Posed:
    """Look up what is searched, and the example."""
    from motiondb.database import searching

    check(question)
    check_least("limit", question.limit, 1)
    motion = None
    if question.like:
        motion = load_example(session, question.like, question.start, question.end)
    allowed = None  # said in a word, and not by as many numbers for each of many questions
    if question.where:
        allowed = searching.allowed_captures(session, question.where, question.exact)
    searching.check_any(session.searchable)
    return _Posed(question, allowed, motion)


def _answer(session: Session, posed: _Posed) -> Found:
    from motiondb.database import searching
    from motiondb.search.by_example import search_motion

    asked, learned = posed.question, session.searchable
    allowed = list(learned.captures) if posed.allowed is None else posed.allowed
    if posed.motion is not None:
        return search_motion(learned, session.frames, posed.motion, allowed, asked.limit)
    return searching.answer_words(session, asked.words, allowed, asked.limit, asked.exact)


def _or_error(
    ask: Callable[Given, T], *given: Given.args, **named: Given.kwargs
) -> T | MotionDBError:
    """The answer, or the error that says why there is none."""
    try:
        return ask(*given, **named)
    except MotionDBError as error:
        return error.with_traceback(None)  # which would keep all that the frames hold


@dataclass(frozen=True)
class DatabaseFile:
    """A database that workers open themselves."""

    path: Path
    state: str  # Another one when anything in it has changed


def _state(opened: store.Store) -> str:
    return repr((store.revision(opened), store.learning_mark(opened)))


def _file_for(workers: Cluster, session: Session) -> DatabaseFile:
    """The database of a session; ClusterError where workers cannot open it."""
    file = DatabaseFile(session.store.path.resolve(), _state(session.store))
    if not session.store.read_only:
        raise ClusterError(
            f"{file.path}: expected a database that workers can open, too, found one that this "
            "process may change, which keeps others out. Open it with read_only=True."
        )
    for worker, fault in workers.each(why_not_opened, file).items():
        if fault:
            workers.each(close, file)
            raise ClusterError(
                f"{worker}: expected a worker that can open {file.path}, found one that cannot "
                f"({str(fault).rstrip('.')}). Put the database or a copy of it, with its cache, "
                "into a folder that all workers see under the same path, and ask it there."
            )
    return file


_lent = dict[DatabaseFile, "Lent[Session]"]()
"""The database that this process answers from for another one, if any."""


@contextmanager
def _opened(file: DatabaseFile) -> Iterator[Session]:
    """A session that reads a database; StoreError if it is not the one that asks.

    What was loaded of it stays until all questions are answered.
    """
    if file not in _lent:
        _lent.clear()  # of a process that ended before it could say so
        session = Session(file.path, read_only=True)
        _lent[file] = Lent(session, session.store.lend)
    with _lent[file].use() as session, session.reading():
        if _state(session.store) != file.state:
            raise StoreError(
                f"{file.path}: expected the database that asks, found another state of it."
            )
        yield session


def why_not_opened(file: DatabaseFile) -> str:
    """Why this worker cannot map what it needs of the database that asks; "" if it can."""
    from motiondb.database.loading import FRAMES

    try:
        with _opened(file) as session:
            is_cached = store.is_cached(session.store, FRAMES)
            return "" if is_cached else f"{file.path}: expected its cache beside it, found none."
    except MotionDBError as error:
        return str(error)


def close(file: DatabaseFile) -> None:
    """Forget the database of questions that were answered."""
    _lent.pop(file, None)


def _answer_there(session: Session, posed: _Posed) -> Found:
    """The answer of a worker, without the functions that hold the learned model."""
    from motiondb.search.by_words import WordAnswer

    found = _answer(session, posed)
    if not isinstance(found, WordAnswer):
        return found
    told = tuple(partial(tuple[str, ...], suggests()) for suggests in found.suggests)
    return replace(found, suggests=told)


def _answer_some(posed: Sequence[_Posed | MotionDBError], file: DatabaseFile) -> list[Answer]:
    """Answers to some questions; errors stay as they are."""
    try:
        with _opened(file) as session:
            return [
                each if isinstance(each, MotionDBError) else _or_error(_answer_there, session, each)
                for each in posed
            ]
    except MotionDBError as error:
        raise ClusterError(
            f"{file.path}: expected a database that every worker can open while questions are "
            f"answered, found a worker that cannot ({error}) Ask again; give new workers the "
            "folder, too."
        ) from None
