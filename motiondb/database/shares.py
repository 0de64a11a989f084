"""A share of the captures of a database, which a worker asks the steps of questions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from motiondb.database.loading import nearby_table
from motiondb.errors import MotionDBError
from motiondb.learn.shares import Rest, Share, joined, segments_of
from motiondb.search.asked_words import find_written
from motiondb.search.asking import AskedQuestion, ask
from motiondb.search.by_example import AskedExample, Example
from motiondb.search.steps import Place, Step
from motiondb.symbols.hmm_jobs import one_blas_thread

if TYPE_CHECKING:
    from motiondb.learn.learned import Learned
    from motiondb.meaning.windows import ComparedSegments
    from motiondb.search.asked_words import WrittenWord

QUESTIONS = 32
"""Questions whose steps are told together. Of these a share keeps what it computed: for an example
some 3 MB with 3 hours of motion in the share, and more with more."""


@dataclass(frozen=True)
class Words:
    """A question in words, as it is sent: a share understands it as the asking process does."""

    text: str
    exact: bool
    is_near: bool  # Whether near words stand in place of its own


@dataclass(frozen=True, eq=False)
class AskedStep:
    """A step of a question to a share."""

    key: tuple[int, bool]  # Number of the question, and whether near words stand in its place
    asked: Words | Example
    captures: Sequence[int] | None  # Those of the share that are asked; None: all
    step: Step[Any, Any]


class SentShare:
    """A share as it is sent to a worker, which opens it with all the rest of the model."""

    def __init__(self, share: Share) -> None:
        self.captures, self.share = share.captures, share
        self._opened: tuple[Rest, _OpenShare] | None = None

    def opened(self, rest: Rest) -> _OpenShare:
        """The share, which stays open."""
        if self._opened is None or self._opened[0] is not rest:
            self._opened = rest, _OpenShare(joined(rest, self.share), self.share)
        return self._opened[1]

    def __reduce__(self) -> tuple[type[SentShare], tuple[Share]]:
        """Another process opens it itself."""
        return SentShare, (self.share,)


class _OpenShare:
    """Captures that follow one another, with their rows of a learned model."""

    def __init__(self, learned: Learned, share: Share) -> None:
        self._learned, self._share = learned, share
        self._every = Place(share.captures, share.pool.of_capture)
        self._asked: dict[tuple[int, bool], AskedQuestion | AskedExample] = {}

    def tell(self, step: AskedStep) -> Any:  # noqa: ANN401  of any step
        """What the captures say, or the error that says why they cannot."""
        every, some = self._every, step.captures
        place = every if some is None else Place(some, every.features)
        try:
            with one_blas_thread():
                told = step.step.tell(self._understood(step), place)
                return dict(told) if isinstance(told, Mapping) else told
        except MotionDBError as error:
            return error.with_traceback(None)

    def _understood(self, step: AskedStep) -> AskedQuestion | AskedExample:
        """What is asked; it is kept while its steps are told."""
        if step.key not in self._asked:
            together = step.key[0] // QUESTIONS
            for old in [key for key in self._asked if key[0] // QUESTIONS != together]:
                del self._asked[old]
            self._asked[step.key] = self._understand(step.asked)
        return self._asked[step.key]

    def _understand(self, asked: Words | Example) -> AskedQuestion | AskedExample:
        if isinstance(asked, Example):
            first = segments_of(self._learned, self._share.captures).start
            return AskedExample(self._learned, asked, self._compared, first)
        table = nearby_table()
        question = ask(self._learned, asked.text, table, lambda: self._written, asked.exact)
        if not asked.is_near:
            return question
        near = question.with_near_words(table)
        assert near is not None  # the asking process has understood it
        return near

    @cached_property
    def _compared(self) -> ComparedSegments:
        return self._learned.compared_rows(segments_of(self._learned, self._share.captures))

    @cached_property
    def _written(self) -> dict[str, WrittenWord]:
        """Words that were not learned and are written in captions or tags."""
        return find_written(self._learned)


def tell(piece: tuple[SentShare, Sequence[AskedStep]], rest: Rest) -> list[Any]:
    """What a share says to some steps, by a worker."""
    share, steps = piece
    opened = share.opened(rest)
    return [opened.tell(step) for step in steps]
