"""Many questions, answered by this process, or by workers with a share of the captures each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from motiondb.errors import MotionDBError, QueryError
from motiondb.workers import Workers

if TYPE_CHECKING:
    from motiondb.database.session import Session
    from motiondb.records import Motion
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
    from motiondb.database.asking_shares import AskedShares

    with session.reading():
        opened = _Opened(session, motion_of)
        posed = [_or_error(_Opened.pose, opened, question) for question in questions]
        errors = [each for each in posed if isinstance(each, MotionDBError)]
        if len(errors) < len(posed):
            asked = AskedShares(session, workers)
    if len(errors) == len(posed):  # such as of a database that has not learned
        yield from errors
        return
    with asked:
        yield from asked.answers(posed)


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
class Posed:
    """A question with all that only the process with the file can look up."""

    question: Question
    allowed: list[int] | None  # Numbers of the captures that are searched; None: all
    motion: Motion | None  # The example


@dataclass(frozen=True, eq=False)
class _Opened:
    """The process with the file."""

    session: Session
    motion_of: Callable[[Question], Motion]

    def pose(self, question: Question) -> Posed:
        """Look up what is searched, and the example."""
        from motiondb.database import arguments, searching

        _check(question)
        arguments.check_least("limit", question.limit, 1)
        motion = self.motion_of(question) if question.like else None
        allowed = None  # said in a word, and not by as many numbers for each of many questions
        if question.where.strip():
            allowed = searching.allowed_captures(self.session, question.where, question.exact)
        searching.check_any(self.session.searchable)
        return Posed(question, allowed, motion)


def _answer_here(opened: _Opened, question: Question) -> Found:
    """The answer of the process with the file."""
    from motiondb.database import searching
    from motiondb.search.by_example import search_motion

    posed, searched = opened.pose(question), searching.searched(opened.session)
    allowed = list(searched.learned.captures) if posed.allowed is None else posed.allowed
    if posed.motion is not None:
        pool = searched.pool()
        return search_motion(searched.learned, pool, posed.motion, allowed, question.limit)
    return searching.answer_words(
        searched, question.words, allowed, question.limit, False, True, question.exact
    )
