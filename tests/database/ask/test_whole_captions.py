"""Answers are ranked by the likeness of each word to the caption that the motion suggests, too."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import motiondb
from motiondb.learn.learned import Learned
from motiondb.search import reasons
from motiondb.search.asking import understand_learned
from motiondb.search.by_words import WordAnswer, search_words


@pytest.fixture(scope="module")
def learned(learned_file: Path) -> Learned:
    with motiondb.open(learned_file, read_only=True) as db:
        return db.learned


def ask(learned: Learned, text: str) -> WordAnswer:
    return search_words(understand_learned(learned, text), list(learned.rows), 200)


@pytest.mark.parametrize("text", ["walk", "walk, turn left, sit down", "walk but not turn"])
def test_the_likeness_of_a_word_is_a_part_of_its_log_odds(learned: Learned, text: str) -> None:
    answer = ask(learned, text)
    numbers = {learned.captures[c].name: n for n, c in enumerate(learned.rows)}
    assert [m.capture for m in answer.matches] == [
        m.capture for m in ask(learned, f'"{text}"').matches
    ]
    for match, why in zip(answer.matches, answer.reasons):
        n_words = sum(reason.exclusion < 0 for reason in why)
        n_actions = len({reason.action for reason in why if reason.exclusion < 0})
        for reason in why:
            if reason.exclusion < 0 and n_words == n_actions:
                like = learned.likeness[numbers[match.capture], reason.word]
                assert reason.likeness == pytest.approx(like / n_actions)
        assert match.score == pytest.approx(1.0 / (1.0 + math.exp(-reasons.total(why))))
