"""Questions with "not" and "or" made from captions, and how sure their answers are."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.meaning.asked_certainty import (
    either_questions,
    without_questions,
)
from motiondb.meaning.regression import Certainty, KindCertainty, kind_cues
from motiondb.search.chances import Chances, PartChance, chances_of_kind

NAMES = ["walk", "run", "jump"]
SHOWN = np.array(
    [[True, False, False]] * 2 + [[True, True, False]] * 2 + [[False, True, False]]
    + [[False, False, True]] * 2
)  # fmt: skip
VERBS = np.arange(3)


def of(whole: float, part: float, weights: tuple[float, ...] = (0.0,)) -> KindCertainty:
    """Certainties whose constants are the log-odds of two probabilities."""

    def certainty(p: float) -> Certainty:
        return Certainty(np.array(weights), float(np.log(p / (1.0 - p))), float("nan"))

    return KindCertainty(certainty(whole), certainty(part))


def part_of(told: Chances) -> PartChance:
    """The only part."""
    (part,) = told.parts
    assert part is not None
    return part


def test_without_is_asked_where_captures_tell_it_apart() -> None:
    questions = list(without_questions(SHOWN, VERBS, NAMES))
    # walk stands twice with run and twice alone; run only once without walk
    assert [q.readings[0].parts[0].actions for q in questions] == [(("walk",),)]
    assert [q.readings[0].exclusions[0].actions for q in questions] == [(("run",),)]
    assert questions[0].right.tolist() == [True, True, False, False, False, False, False]
    assert questions[0].shown[0].tolist() == [True] * 4 + [False] * 3


def test_either_is_asked_where_each_stands_alone() -> None:
    questions = list(either_questions(SHOWN, VERBS, NAMES))
    read = [tuple(r.parts[0].actions[0][0] for r in q.readings) for q in questions]
    assert read == [("walk", "jump"), ("run", "jump")]
    assert questions[0].right.tolist() == [True] * 4 + [False] + [True] * 2
    assert questions[1].shown.tolist() == [SHOWN[:, 1].tolist(), SHOWN[:, 2].tolist()]


def test_what_all_captures_show_is_not_asked() -> None:
    shown = np.array([[True, False]] * 2 + [[False, True]] * 2)
    assert list(either_questions(shown, np.arange(2), NAMES)) == []


def test_cues_turn_what_is_excluded() -> None:
    assert kind_cues(2.0, None).tolist() == [2.0]
    assert kind_cues(2.0, 3.0).tolist() == [2.0, -3.0]


def test_chances_by_motion_are_those_learned() -> None:
    told = chances_of_kind(of(0.3, 0.6, (0.0, 0.0)), (1.0, 0.0), (1.0, 0.0))
    assert told.whole == pytest.approx(0.3)
    assert part_of(told).probability == pytest.approx(0.6)
    either = chances_of_kind(of(0.7, 0.5), (1.0, 0.0), None)
    assert either.whole == pytest.approx(0.7)
    assert part_of(either).by_motion == pytest.approx(0.5)


def test_captions_move_each_condition_by_their_log_odds() -> None:
    kind = of(0.3, 0.6, (0.0, 0.0))  # P(not b | a) = 1/2
    told = chances_of_kind(kind, (1.0, 0.0), (5.0, 4.0))
    assert told.whole == pytest.approx(0.6 / (1.0 + np.exp(4.0)))
    told = chances_of_kind(kind, (5.0, 4.0), (0.0, -1.0), True)
    shown = 1.0 / (1.0 + np.exp(-np.log(1.5) - 4.0))
    assert told.whole == pytest.approx(shown / (1.0 + np.exp(-1.0)))
    assert part_of(told).by_caption


def test_a_part_is_never_surer_than_the_alternatives_together() -> None:
    told = chances_of_kind(of(0.4, 0.8), (1.0, 0.0), None)
    assert told.whole == pytest.approx(0.4)
    assert part_of(told).probability == pytest.approx(0.4)


def test_the_whole_is_never_surer_than_its_part() -> None:
    told = chances_of_kind(of(0.9, 0.5, (0.0, 0.0)), (1.0, 0.0), (1.0, -8.0))
    assert told.whole is not None
    assert told.whole <= part_of(told).probability


def test_nothing_is_told_that_was_not_learned() -> None:
    assert chances_of_kind(KindCertainty(), (1.0, 0.0), None) == Chances(None, (None,))
