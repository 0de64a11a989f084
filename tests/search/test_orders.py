"""Answers to actions in order, on the sample data."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import motiondb


@pytest.fixture(scope="module")
def db(learned_file: Path) -> Iterator[motiondb.MotionDB]:
    with motiondb.open(learned_file, read_only=True) as opened:
        yield opened


def test_answers_in_which_the_order_is_not_seen_come_last(db: motiondb.MotionDB) -> None:
    matches = db.search("walk, jump, walk", limit=101).matches
    seen = ["not seen in this order" not in match.reason for match in matches]
    assert any(seen)
    assert not all(seen)
    assert seen == sorted(seen, reverse=True)
    assert {m.probability for m, is_seen in zip(matches, seen) if not is_seen} == {None}


def test_no_walk_follows_the_jump_of_a_take(db: motiondb.MotionDB) -> None:
    """ana/long_1 walks, jumps and bows; it stood first, with a probability of .98."""
    (first,) = db.search("walk, jump", limit=1, where="name=ana/long_1").matches
    assert first.probability is not None
    assert first.probability > 0.9
    answer = db.search("walk, jump, walk", limit=1, where="name=ana/long_1")
    assert answer.matches[0].probability is None
    assert answer.matches[0].reason.endswith("; not seen in this order")
    assert answer.matches_anything is None
    assert answer.nothing.startswith("probably nothing")


def test_a_place_with_a_label_in_other_words_is_seen_by_its_frames(db: motiondb.MotionDB) -> None:
    """The second walk of ana/long_1 is labelled "a person takes a few steps"."""
    answer = db.search("wave, walk, jump", limit=1)
    assert answer.matches[0].capture == "ana/long_1"
    assert answer.matches[0].probability is not None


def test_an_order_of_many_actions_that_a_take_shows_is_not_called_absent(
    db: motiondb.MotionDB,
) -> None:
    answer = db.search("walk, turn left, sit down, stand up, wave", limit=1)
    assert answer.matches[0].capture == "ana/long_1"
    assert answer.matches_anything is True
