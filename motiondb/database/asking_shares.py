"""Many questions to workers with a share of the captures each, which answer together.

Nobody but the asking process needs the database. The steps of some questions are told at a time;
between them, the asking process joins what shares say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from motiondb.database.loading import nearby_table
from motiondb.database.questions import Posed
from motiondb.database.searching import steps_with_near
from motiondb.database.session import Session
from motiondb.database.shares import QUESTIONS, AskedStep, SentShare, Words, tell
from motiondb.errors import MotionDBError
from motiondb.learn.shares import divided, rest_of, share_of
from motiondb.search.asked_words import find_written
from motiondb.search.asking import AskedQuestion, ask
from motiondb.search.by_example import Example, example_steps, make_example
from motiondb.search.steps import Step, Steps
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.workers import Workers

if TYPE_CHECKING:
    from motiondb.database.questions import Answer, Found


class Shares:
    """The captures of a session in shares, one for each worker.

    It is made in a ``reading`` block, and is of the state that this block reads.
    """

    def __init__(self, session: Session, workers: Workers) -> None:
        learned, pool = session.searchable, session.features
        self._workers, self._rest = workers, rest_of(learned)
        self.learned, self.find_written = learned, cache(lambda: find_written(learned))
        runs = divided(learned, workers.n_workers)
        self.shares = [SentShare(share_of(learned, pool, run)) for run in runs]

    def answers(self, posed: Sequence[Posed | MotionDBError]) -> Iterator[Answer]:
        """Answers to questions, in their order; errors stay as they are."""
        for first in range(0, len(posed), QUESTIONS):
            answers: dict[int, Answer] = {}
            asking: dict[int, _Asking] = {}
            for n, each in enumerate(posed[first : first + QUESTIONS], start=first):
                if isinstance(each, MotionDBError):
                    answers[n] = each
                else:
                    asking[n] = _Asking(n, each, self)
            self._answer(asking, answers)
            yield from (answers[n] for n in sorted(answers))

    def _answer(self, asking: dict[int, _Asking], answers: dict[int, Answer]) -> None:
        """Put the answers of some questions, whose steps are told together, among the others."""
        told: dict[int, list[Any]] = {n: [] for n in asking}
        while asking:
            for n, each in list(asking.items()):
                answer = each.go_on(told[n])
                if answer is not None:
                    answers[n] = answer
                    del asking[n]
            if asking:
                told = self._tell(asking)

    def _tell(self, asking: dict[int, _Asking]) -> dict[int, list[Any]]:
        """What shares say to the present steps of some questions."""
        told: dict[int, list[Any]] = {n: [] for n in asking}
        numbers, pieces = list[list[int]](), list[tuple[SentShare, list[AskedStep]]]()
        for place, share in enumerate(self.shares):
            steps = {n: each.step_for(place) for n, each in asking.items()}
            sent = {n: step for n, step in steps.items() if step is not None}
            if sent:
                numbers.append(list(sent))
                pieces.append((share, list(sent.values())))
        for some, said in zip(numbers, self._workers.map(tell, pieces, self._rest), strict=True):
            for n, one in zip(some, said, strict=True):
                told[n].append(one)
        return told


class _Asking:
    """A question on its way, whose steps are told by shares of the captures."""

    def __init__(self, number: int, posed: Posed, asked: Shares) -> None:
        self._number, self._question = number, posed.question
        self._steps = _steps_of(posed, asked)
        self._asked: AskedQuestion | Example | None = None
        self._is_near = False  # Whether near words stand in place of the words that are asked
        self._step: Step[Any, Any] | None = None
        every, allowed = posed.allowed is None, set(posed.allowed or ())
        # Of each share the captures that are asked; None: all
        self._captures = [
            None if every else [capture for capture in share.captures if capture in allowed]
            for share in asked.shares
        ]

    def go_on(self, told: Sequence[Any]) -> Answer | None:
        """The answer, once the steps are told; `told`: by each share that was asked, none first."""
        error = next((each for each in told if isinstance(each, MotionDBError)), None)
        if error is not None:
            return error
        try:
            with one_blas_thread():
                joined = None if self._step is None else self._step.join(told)
                asked, self._step = self._steps.send(joined)
        except StopIteration as end:
            answer: Found = end.value
            return answer
        except MotionDBError as why:
            return why.with_traceback(None)
        self._is_near = self._is_near or (self._asked is not None and asked is not self._asked)
        self._asked = asked
        return None

    def step_for(self, share: int) -> AskedStep | None:
        """The present step to a share; None if none of its captures is asked."""
        captures = self._captures[share]
        assert self._asked is not None
        assert self._step is not None
        if captures is not None and not captures:
            return None
        asked: Words | Example
        if isinstance(self._asked, Example):
            asked = self._asked
        else:
            asked = Words(self._question.words, self._question.exact, self._is_near)
        return AskedStep((self._number, self._is_near), asked, captures, self._step)


def _steps_of(posed: Posed, searched: Shares) -> Steps[AskedQuestion | Example, Found]:
    """The steps of a question."""
    question, learned = posed.question, searched.learned
    if posed.motion is not None:
        example = make_example(learned, posed.motion, learned.has_words)
        allowed = learned.rows if posed.allowed is None else posed.allowed
        n_captures = sum(capture in learned.rows for capture in allowed)
        return (yield from example_steps(learned, example, n_captures, question.limit))
    asked = ask(learned, question.words, nearby_table(), searched.find_written, question.exact)
    return (yield from steps_with_near(asked, question.limit, question.exact))
