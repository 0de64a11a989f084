"""Many questions, answered by this process or by workers.

Workers that can open the database under its path, as on one machine or with a shared folder, answer
some of the questions each; what they need of it they map from its cache. Others get a share of the
captures each, and answer together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from motiondb.database.questions import Posed, Question, answer, check, or_error
from motiondb.database.values import listed
from motiondb.errors import MotionDBError
from motiondb.workers import Workers

if TYPE_CHECKING:
    from motiondb.database.questions import Answer, Found
    from motiondb.database.session import Session
    from motiondb.records import Motion


def ask_many(
    session: Session,
    motion_of: Callable[[Question], Motion],
    questions: Iterable[Question | str],
    workers: Workers | None,
) -> Iterator[Answer]:
    """The answers in the order of the questions, as ``MotionDB.ask_many`` gives them.

    `motion_of`: Loads the example of a question. No block reads while an answer is looked at: its
    reader may change the database.
    """
    if isinstance(questions, str):
        listed("questions", questions)  # refuses it
    asked = (Question(each) if isinstance(each, str) else each for each in questions)
    if workers is None:
        for question in asked:
            with session.reading():
                found = or_error(_answer_here, _Opened(session, motion_of), question)
            yield found
        return
    from motiondb.database import asking_openers, asking_shares

    with session.reading():
        opened = _Opened(session, motion_of)
        posed = [or_error(_Opened.pose, opened, question) for question in asked]
        errors = [each for each in posed if isinstance(each, MotionDBError)]
        answers: Iterator[Answer]
        if len(errors) == len(posed):  # such as of a database that has not learned
            answers = iter(errors)
        elif (file := asking_openers.opened_by(workers, session)) is not None:
            answers = asking_openers.answers(file, posed, workers)
        else:
            answers = asking_shares.Shares(session, workers).answers(posed)
    yield from answers


@dataclass(frozen=True, eq=False)
class _Opened:
    """The process with the file."""

    session: Session
    motion_of: Callable[[Question], Motion]

    def pose(self, question: Question) -> Posed:
        """Look up what is searched, and the example."""
        from motiondb.database import searching, values

        check(question)
        values.check_least("limit", question.limit, 1)
        motion = self.motion_of(question) if question.like else None
        allowed = None  # said in a word, and not by as many numbers for each of many questions
        if question.where:
            allowed = searching.allowed_captures(self.session, question.where, question.exact)
        searching.check_any(self.session.searchable)
        return Posed(question, allowed, motion)


def _answer_here(opened: _Opened, question: Question) -> Found:
    """The answer of the process with the file."""
    from motiondb.database import searching

    posed = opened.pose(question)
    return answer(searching.searched(opened.session), posed)
