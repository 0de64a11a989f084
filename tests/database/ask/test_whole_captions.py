"""Questions compared with the captions that the motion suggests."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.learn.learned import Learned
from motiondb.search import reasons
from motiondb.search.asked_words import learned_words
from motiondb.search.by_words import CAPTION_WEIGHT, WordAnswer, search_words

LONG = '"walk, turn left, sit down"'


@pytest.fixture(scope="module")
def learned(learned_file: Path) -> Learned:
    with motiondb.open(learned_file, read_only=True) as db:
        return db.learned


def ask(learned: Learned, text: str) -> WordAnswer:
    return search_words(learned_words(learned), text, list(learned.rows), 200)


def test_a_long_question_is_ranked_by_its_likeness_too(learned: Learned) -> None:
    captions = learned.caption_map
    assert captions is not None
    answer = ask(learned, LONG)
    asked = [learned.word_numbers[word] for word in ("walk", "turn", "left", "sit", "down")]
    likeness = learned.suggested_captions[:, asked] @ captions.question(asked)
    numbers = {learned.captures[c].name: n for n, c in enumerate(learned.rows)}
    totals = [reasons.total(why) for why in answer.reasons]
    assert totals == sorted(totals, reverse=True)
    for match, why in zip(answer.matches, answer.reasons):
        added = math.fsum(reason.as_caption for reason in why)
        gain = likeness[numbers[match.capture]] - likeness.mean()
        assert added == pytest.approx(CAPTION_WEIGHT * gain)
        assert match.score == pytest.approx(1.0 / (1.0 + math.exp(-reasons.total(why))))
        plain = tuple(replace(reason, as_caption=0.0) for reason in why)
        assert reasons.total(why) == pytest.approx(reasons.total(plain) + added)
        assert reasons.by_action(why) == reasons.by_action(plain)


@pytest.mark.parametrize(
    "question",
    ["walk", "walk, turn left, sit down", '"walk or run or sit"', '"walk but not turn"',
     '"walk turn left twice"'],
)  # fmt: skip
def test_other_questions_are_not(learned: Learned, question: str) -> None:
    answer = ask(learned, question)
    for why in answer.reasons:
        assert {reason.as_caption for reason in why} == {0.0}
    named = [left.text for left in answer.not_used]
    assert ("quotation marks" in named) == question.startswith('"')


def test_a_repeated_word_counts_once(learned: Learned) -> None:
    for why in ask(learned, '"walk, turn left, walk"').reasons:
        added = [reason.as_caption for reason in why]
        assert np.count_nonzero(added) == 3  # walk, turn, left
        assert added[-1] == 0.0


def test_the_probability_is_that_of_the_actions(learned: Learned) -> None:
    plain = {m.capture: m.probability for m in ask(learned, LONG.strip('"')).matches}
    for match in ask(learned, LONG).matches:
        assert match.probability == plain[match.capture]
