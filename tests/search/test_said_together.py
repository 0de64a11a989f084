"""Captions as evidence for an action of several words."""

from pathlib import Path

import pytest

import motiondb
from motiondb.search.asked_words import words_apart


def written_of(db: motiondb.MotionDB, question: str, capture: str) -> dict[str, float]:
    """What captions of a capture add for every word of a question."""
    answer = db.search(question, where=f"name={capture}", limit=1)
    (explained,) = answer.explanations
    return {word.word: word.written for word in explained.words}


def test_words_of_different_actions_are_not_written_together(learned_file: Path) -> None:
    """The caption says "walk forward, catch ball, pivot left"."""
    with motiondb.open(learned_file, read_only=True) as db:
        captures = [
            info.name
            for capture, info in db.learned.captures.items()
            for caption in db.learned.captions.get(capture, ())
            if "walk forward, catch ball, pivot left" in caption.words and caption.start is None
        ]
        name = captures[0]
        assert written_of(db, "pivot left", name)["left"] > 0.0
        walking = written_of(db, "walk left", name)
        assert walking["walk"] > 0.0
        assert "left" not in walking  # it is measured
        assert written_of(db, "walk, not walk left", name)  # what is excluded keeps its evidence


@pytest.mark.parametrize(
    ("action", "heads", "captions", "apart"),
    [
        # a verb with another direction or limb is another action, one with none may be the same
        (("turn", "left"), ("turn",), [("turn", "right")], {"turn"}),
        (("turn", "left"), ("turn",), [("turn", "around"), ("run", "turn", "left")], set()),
        (("kick", "forward"), ("kick",), [("kick",)], set()),
        (("wave", "hand"), ("wave",), [("wave", "arm")], set()),
        (("push", "up"), ("push",), [("leg", "push", "off")], {"push"}),
        # a part of the body belongs to the verb beside it, a thing to whatever is done with it
        (("stand", "hand"), ("stand",), [("sit",), ("hand", "chin")], {"hand"}),
        (("roll", "floor"), ("roll",), [("mop", "floor")], set()),
    ],
)
def test_what_captions_say_of_another_action_is_apart(
    action: tuple[str, ...],
    heads: tuple[str, ...],
    captions: list[tuple[str, ...]],
    apart: set[str],
) -> None:
    assert words_apart(action, heads, captions) == apart


def test_the_words_of_a_phrase_are_said_together() -> None:
    captions, phrase = [("front", "kick")], ("martial", "art")
    assert words_apart((*phrase, "kick"), ("kick",), captions, [phrase]) == set()
    assert words_apart(("hand", "stand"), ("stand",), [("stand",)], [("hand", "stand")]) == {
        "stand"
    }
