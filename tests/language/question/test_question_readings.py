"""Trees as flat readings and as plain actions, and questions held to known words."""

from __future__ import annotations

import pytest

from motiondb.errors import QueryError
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import hold_to_known, plain_actions, readings, say

COUNTS = {"walk": 9, "run": 5, "jump": 4, "sit": 3, "wave": 3, "slow": 2, "slowly": 1, "left": 4}


def read(text: str) -> list[str]:
    """Readings in one line each: parts by ">", actions at once by "+", then exclusions."""
    lines = []
    for reading in readings(parse(text).tree)[0]:
        parts = []
        for k, part in enumerate(reading.parts):
            line = "+".join(" ".join(action) for action in part.actions) or "?"
            line += f" {part.seconds:g}s" if part.seconds else ""
            parts.append(line + (f" ={part.repeat_of}" if part.repeat_of != k else ""))
        excluded = [
            f"not {'+'.join(' '.join(a) for a in e.actions)} {e.first}-{e.last}"
            for e in reading.exclusions
        ]
        lines.append("; ".join([" > ".join(parts), *excluded]))
    return lines


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("walk, turn left", ["walk > turn left"]),
        ("walk ? sit", ["walk > ? > sit"]),
        ("walk while waving", ["walk+wave"]),
        ("walk and wave", ["walk+wave", "walk > wave"]),
        ("walk or run", ["walk", "run"]),
        ("walk, then run or jump", ["walk > run", "walk > jump"]),
        ("(walk or run), then (sit or jump)",
         ["walk > sit", "walk > jump", "run > sit", "run > jump"]),
        ("walk or walk", ["walk"]),
        ("walk but not run", ["walk; not run 0-1"]),
        ("not walking", ["?; not walk 0-1"]),
        ("walk, then jump, not sit", ["walk > jump; not sit 0-2"]),
        ("walk, then jump without waving", ["walk > jump; not wave 1-2"]),
        ("(walk or run) but not jump", ["walk; not jump 0-1", "run; not jump 0-1"]),
        ("not (walk or run)", ["?; not walk 0-1; not run 0-1"]),
        ("walk, not (run while waving)", ["walk; not run+wave 0-1"]),
        ("walk slowly", ["walk+slow"]),
        ("jump 3 times", ["jump > jump =0 > jump =0"]),
        ("walk, jump twice, sit", ["walk > jump > jump =1 > sit"]),
        ("(walk, jump) twice", ["walk > jump > walk =0 > jump =1"]),
        ("(jump, not wave) twice", ["jump > jump =0; not wave 0-1; not wave 1-2"]),
        ("jump once", ["jump"]),
        ("walk for 10 s", ["walk 10s"]),
        ("walk for 4 s while waving", ["walk+wave 4s"]),
        ("(walk, jump) while waving", ["walk+wave > jump+wave"]),
        ("(walk, jump) while (wave, sit)", ["walk+wave > jump+sit"]),
        ("(jump twice) while waving", ["jump+wave > jump+wave =0"]),
        ("(walk, jump, sit) while (wave, turn)", ["walk > jump > sit > wave > turn"]),
        ("(walk, not run) while waving", ["walk+wave; not run 0-1"]),
        ("(walk, jump) while not waving", ["walk > jump; not wave 0-2"]),
    ],
)  # fmt: skip
def test_readings(text: str, expected: list[str]) -> None:
    assert read(text) == expected


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("walk, turn left", []),
        ("jump at least 3 times", []),
        ("jump 3 times", ["at most 3 times"]),
        ("walk for at least 5 s", []),
        ("walk for 5 s", ["for at most 5 s"]),
        ("walk for less than 5 s", ["for at most 5 s"]),
        ("(walk, jump) for 5 s", ["for 5 s"]),
        ("walk, not (run, jump)", ["the order of run, then jump"]),
        ("walk, not (jump twice)", ["2 times"]),
        ("walk, not (run for 2 s)", ["for 2 s"]),
        ("sit, not (walk, not wave)", ["not wave"]),
        ("(walk, sit) while (run, jump)", []),
        (
            "(walk, sit) while (run, jump, wave)",
            ["(walk, then sit) while (run, then jump, then wave)"],
        ),
    ],
)
def test_what_a_search_cannot_tell_is_named(text: str, left: list[str]) -> None:
    _, not_used = readings(parse(text).tree)
    assert [each.text for each in not_used] == left
    assert all(each.reason for each in not_used)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (", then ".join(["(walk or run)"] * 7),
         "question: expected at most 64 alternatives, found 128. Ask for fewer at a time."),
        (" or ".join(["walk"] * 65),
         "question: expected at most 64 alternatives, found 65. Ask for fewer at a time."),
        ("jump 1000 times",
         "question: expected at most 128 actions in order, found 1,000. Ask for fewer at a time."),
        ("((jump 100 times) 100 times) 100 times",
         "question: expected at most 128 actions in order, found 10,000. "
         "Ask for fewer at a time."),
    ],
)  # fmt: skip
def test_readings_are_bounded(text: str, message: str) -> None:
    with pytest.raises(QueryError) as error:
        readings(parse(text).tree)
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("text", "actions", "left"),
    [
        ("walk, turn left", "walk | turn left", []),
        ("walk and wave", "walk | wave", []),
        ("walk while waving", "walk wave", []),
        ("walk slowly", "walk slow", []),
        ("walk ? sit", "walk |  | sit", []),
        ("walk or run", "walk", ["or run"]),
        ("walk, not run", "walk", ["not run"]),
        ("jump 3 times", "jump", ["3 times"]),
        ("walk for 5 s", "walk", ["for 5 s"]),
    ],
)
def test_plain_actions(text: str, actions: str, left: list[str]) -> None:
    actual, not_used = plain_actions(parse(text).tree)
    assert " | ".join(" ".join(action) for action in actual) == actions
    assert [each.text for each in not_used] == left


@pytest.mark.parametrize(
    ("text", "said", "left"),
    [
        ("walk slowly", "walk slowly", []),
        ("walk quickly", "walk", ["quickly"]),
        ("moonwalk, walk", "walk", ["moonwalk"]),
        ("walk, not moonwalk", "walk", ["moonwalk"]),
        ("moonwalk, not walk", "not walk", ["moonwalk"]),
        ("walk or moonwalk", "walk", ["moonwalk"]),
        ("moonwalk slowly, walk", "walk", ["slowly", "moonwalk"]),
        ("(moonwalk twice), walk for 5 s", "walk for 5 s", ["moonwalk"]),
        ("walk left arm", "walk left", ["arm"]),
        ("only walk", "walk", ["only"]),
        ("walk, moonwalk left", "walk", ["left", "moonwalk"]),
    ],
)
def test_questions_are_held_to_known_words(text: str, said: str, left: list[str]) -> None:
    question = hold_to_known(parse(text), COUNTS)
    assert say(question.tree) == said
    assert [each.text for each in question.not_used] == left


def test_the_form_of_a_manner_that_captions_have_is_taken() -> None:
    assert hold_to_known(parse("walk slowly"), COUNTS).words == ("walk", "slow")
    assert hold_to_known(parse("walk slowly"), {"walk": 1, "slowly": 1}).words == (
        "walk", "slowly",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wlak, jmup", "query: expected a word that is in the captions, found 'wlak', 'jmup'. "
         "Perhaps walk or jump."),
        ("not zzz", "query: expected a word that is in the captions, found 'zzz'. "
         "`motiondb words` lists the words that are known."),
    ],
)  # fmt: skip
def test_questions_without_a_known_word_are_refused(text: str, message: str) -> None:
    with pytest.raises(QueryError) as error:
        hold_to_known(parse(text), COUNTS)
    assert str(error.value) == message
