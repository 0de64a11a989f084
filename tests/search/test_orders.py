"""Answers to actions in order, on the sample data."""

import pytest

import motiondb


def test_an_order_that_is_not_seen_comes_behind_probable_answers(db: motiondb.MotionDB) -> None:
    matches = db.search("walk, jump, walk", limit=30).matches
    unseen = [match.reason.endswith("; not seen in this order") for match in matches]
    assert any(unseen)
    assert {match.probability for match, is_unseen in zip(matches, unseen) if is_unseen} == {None}
    probable = [(match.probability or 0.0) >= 0.5 for match in matches]
    assert probable == sorted(probable, reverse=True)
    scores = [match.score for match, is_probable in zip(matches, probable) if not is_probable]
    assert scores == sorted(scores, reverse=True)


@pytest.mark.parametrize("words", ["throw, catch, throw", "wave, bow, kick", "walk"])
def test_whether_anything_matches_does_not_depend_on_the_limit(
    db: motiondb.MotionDB, words: str
) -> None:
    answers = [db.search(words, limit=limit) for limit in (1, 12, 30, 101)]
    assert len({answer.matches_anything for answer in answers}) == 1
    assert len({answer.strength for answer in answers}) == 1
    assert len({answer.matches[0].capture for answer in answers}) == 1


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
