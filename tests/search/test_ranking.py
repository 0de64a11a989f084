"""The order of answers, of which few are placed, and their probabilities."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.language.question.parse import parse
from motiondb.language.question.readings import readings
from motiondb.meaning.by_question import QuestionHit, Statement
from motiondb.meaning.regression import Certainties, Certainty
from motiondb.search.chances import LIKELY, Chances, Found, chances
from motiondb.search.placing import Placed
from motiondb.search.ranking import Judged

ODDS = st.sampled_from([-3.0, -1.0, 0.0, 1.0, 2.0, 5.0, 6.0])
ANSWERS = st.lists(
    st.tuples(
        ODDS,
        st.sampled_from([None, 0.1, 0.5, 0.9]),
        st.sampled_from([None, True, False]),
        st.booleans(),
        st.integers(0, 8),
    ),
    max_size=12,
)


def found(log_odds: float, whole: float | None, capture: int = 0) -> Found:
    hit = QuestionHit(0, 1, log_odds, ((0, 1),), ())
    return Found(capture, hit, lambda *_: Chances(whole, (None,)))


@given(ANSWERS, st.integers(1, 12))
def test_the_first_answers_are_those_of_a_full_sort(
    facts: list[tuple[float, float | None, bool | None, bool, int]], limit: int
) -> None:
    """Of the answers of one capture, as of a question of several readings, the best alone."""
    answers = [found(log_odds, whole, capture) for log_odds, whole, *_, capture in facts]
    placed = {
        id(answer): Placed((), in_order, ("against",) if contradicted else ())
        for answer, (*_, in_order, contradicted, _) in zip(answers, facts)
    }

    def rank(n: int) -> tuple[bool, int, float]:
        log_odds, whole, in_order, contradicted, _ = facts[n]
        likely = log_odds >= 0.0 if whole is None else whole >= LIKELY
        is_against = in_order is False or contradicted
        return contradicted, int(is_against) if likely else 2, -log_odds

    looked_at = list[Found]()

    def place(answer: Found) -> Placed:
        looked_at.append(answer)
        return placed[id(answer)]

    first = Judged(answers, place, True).first(limit)
    ranked = {}
    for n in sorted(range(len(facts)), key=rank):
        ranked.setdefault(answers[n].capture, answers[n])
    expected = list(ranked.values())[:limit]
    assert [id(answer) for answer in first] == [id(answer) for answer in expected]
    assert len({id(answer) for answer in looked_at}) == len(looked_at)


def test_answers_whose_turn_does_not_come_are_not_placed() -> None:
    answers = [found(odds, 0.9, n) for n, odds in enumerate((9.0, 8.0, 7.0, 2.0))]
    against, looked_at = Placed((), contradicted=("does not go left",)), list[Found]()

    def place(answer: Found) -> Placed:
        looked_at.append(answer)
        return against if answer is answers[0] else Placed(())

    judged = Judged(answers, place, True)
    assert judged.first(2) == answers[1:3]
    assert looked_at == answers[:3]
    assert not judged.is_doubtful(answers[1:3], True, 1.0)
    assert Judged(answers[:1], place, True).is_doubtful(answers[:1], True, 1.0)


def asked_with(written: np.ndarray) -> Any:
    sure = Certainty(np.array([2.0]), -1.0, 0.0)
    learned = SimpleNamespace(
        certainties=Certainties(words=sure),
        word_certainty=sure,
        segments=SimpleNamespace(starts=np.array([0, 30])),
        rows={7: slice(0, 2)},
    )
    return SimpleNamespace(
        learned=learned,
        numbers={"walk": 0, "jump": 1},
        evidence=SimpleNamespace(written={7: written}),
    )


def test_what_captions_add_is_not_calibrated() -> None:
    """By hand: sure has log-odds 2 x - 1, and captions add 1 to "jump", halfway between 2 and 0."""
    asked = asked_with(np.array([[0.0, 2.0], [0.0, 0.0]]))
    read, _ = readings(parse("walk, then jump").tree)
    walk = Statement((0,), 0, -1, ((0, 1.0),), 0.5, (0.5,))
    jump = Statement((1,), 1, -1, ((30, 1.0),), 0.5, (2.0,))
    hit = QuestionHit(0, 60, 0.0, ((0, 30), (30, 60)), (walk, jump))
    told = chances(asked, read, True, 7, hit)
    of_walk = 1 / (1 + math.exp(-(2.0 * 0.5 - 1.0)))
    of_jump = 1 / (1 + math.exp(-(2.0 * (2.0 - 1.0) - 1.0 + 1.0)))
    assert told.whole == pytest.approx(of_walk * of_jump)
    assert [part and part.probability for part in told.parts] == pytest.approx([of_walk, of_jump])
    assert [part and part.by_caption for part in told.parts] == [False, True]
