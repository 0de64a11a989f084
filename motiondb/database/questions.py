"""Questions as users ask them, and what the process with the database looks up of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from motiondb.errors import MotionDBError, QueryError

if TYPE_CHECKING:
    from motiondb.database.searching import Searched
    from motiondb.database.values import Where
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
class Posed:
    """A question with all that only the process with the file can look up."""

    question: Question
    allowed: list[int] | None  # Numbers of the captures that are searched; None: all
    motion: Motion | None  # The example


def or_error(ask: Callable[[Given, Asked], T], given: Given, asked: Asked) -> T | MotionDBError:
    """The answer, or the error that says why there is none."""
    try:
        return ask(given, asked)
    except MotionDBError as error:
        return error.with_traceback(None)  # which would keep all that the frames hold


def answer(searched: Searched, posed: Posed) -> Found:
    """The answer of a process that can look at all captures."""
    from motiondb.database import searching
    from motiondb.search.by_example import search_motion

    asked, motion = posed.question, posed.motion
    allowed = list(searched.learned.captures) if posed.allowed is None else posed.allowed
    if motion is not None:
        return search_motion(searched.learned, searched.pool(), motion, allowed, asked.limit)
    return searching.answer_words(
        searched, asked.words, allowed, asked.limit, False, True, asked.exact
    )
