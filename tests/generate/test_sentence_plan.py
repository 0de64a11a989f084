"""What a sentence asks to be made."""

import numpy as np
import pytest

from motiondb.errors import QueryError
from motiondb.generate.sentence_plan import Amount, PlannedAction, plan_sentence
from motiondb.language.question.parse import parse


def _plan(text: str, seed: int = 0) -> tuple[PlannedAction, ...]:
    return plan_sentence(parse(text).tree, np.random.default_rng(seed))[0]


def test_counts_durations_and_speeds_belong_to_their_action() -> None:
    walk, jump = _plan("walk slowly for ten seconds, then jump three times")
    assert (walk.words, walk.speed, walk.seconds) == (("walk",), "slow", Amount(10.0, 10.0))
    assert (jump.words, jump.times) == (("jump",), Amount(3, 3))


def test_actions_at_once_are_one_action() -> None:
    (both,) = _plan("walk while waving")
    assert both.groups == (("walk",), ("wave",))


def test_an_order_is_repeated_as_a_whole() -> None:
    assert [a.words[0] for a in _plan("(walk, then jump) twice")] == ["walk", "jump"] * 2


def test_an_order_shares_its_duration() -> None:
    assert [a.seconds for a in _plan("(walk, then jump) for 10 seconds")] == [Amount(5.0, 5.0)] * 2


def test_exclusions_hold_for_every_action_before_them() -> None:
    assert [a.excluded for a in _plan("walk, then run, but not jump")] == [(("jump",),)] * 2


def test_alternatives_are_drawn_and_told() -> None:
    tree = parse("walk or run").tree
    drawn = set()
    for seed in range(20):
        (action,), notes, not_used = plan_sentence(tree, np.random.default_rng(seed))
        drawn.add(action.words[0])
        assert "was drawn; another seed may draw" in notes[0]
        assert not_used == ()
    assert drawn == {"walk", "run"}


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("jump 5000 times", "expected at most 50 repetitions, found 5,000"),
        ("walk for 3 hours", "expected at most 600 seconds for an action, found 'for 10800 s'"),
        ("(" + "walk, then run, " * 30 + "sit) 3 times", "expected at most 128 actions in order"),
    ],
)
def test_too_much_is_refused(text: str, what: str) -> None:
    with pytest.raises(QueryError, match=what):
        _plan(text)


def test_and_keeps_what_it_joins_in_mind() -> None:
    both, ordered = _plan("run and veer left"), _plan("run, then veer left")
    assert [action.beside for action in both] == [("veer", "left"), ("run",)]
    assert [action.beside for action in ordered] == [(), ()]


def test_a_side_may_be_named_of_a_hand_and_of_its_place() -> None:
    (action,) = _plan("the left hand on the left hip")
    assert action.posture == "at left left hip"
