"""Questions of every kind: restated, written as JSON, refused, and never failing."""

from __future__ import annotations

import json
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.answers.plain import to_json
from motiondb.answers.questions import question_tree
from motiondb.errors import QueryError
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import say
from motiondb.language.question.tokens import MOST_CHARACTERS, MOST_TOKENS
from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Lasting,
    Node,
    NotUsed,
    Repeated,
    Without,
    actions_of,
    at_once,
    join,
    walk,
    without,
)

WALK, RUN, SIT = (Action((word,)) for word in ("walk", "run", "sit"))
PIECES_TEXT = """
walk run jump sit wave turn left right forward hand arm slowly quickly twice three times
for ten seconds at least 5 s and or then but not without no while , ; . ( ) ? " " after before
either neither nor a person don't two -run simultaneously 3x only walking waving 2.5 \u00b2
"""
PIECES = PIECES_TEXT.split()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a person walks, then runs or jumps, but does not sit",
         "walk, then (run or jump), not sit"),
        ("walk but not run then jump", "(walk, not run), then jump"),
        ("don't walk", "not walk"),
        ("neither walk nor run", "not walk, not run"),
        ("a person walks and waves while turning left", "walk while wave while turn left"),
        ("walk slowly for ten seconds", "walk slowly for 10 s"),
        ("jump at least three times", "jump at least 3 times"),
        ("walk ? sit", "walk, then ?, then sit"),
        ('"walk then sit"', "walk sit"),
        ('"slowly"', '"slowly"'),
    ],
)  # fmt: skip
def test_restatement(text: str, said: str) -> None:
    assert say(parse(text).tree) == said


def test_tree_as_json() -> None:
    tree = parse("kick twice with the left leg, ? for 2 s, not (walk slowly)").tree
    assert to_json(question_tree(tree)) == {
        "kind": "without",
        "part": {
            "kind": "in_order",
            "parts": [
                {
                    "kind": "repeated", "at_least": 2, "at_most": 2,
                    "part": {
                        "kind": "action", "words": ["kick", "left", "leg"],
                        "sides": [{"side": "left", "limb": "leg"}], "manner": [],
                    },
                },
                {
                    "kind": "lasting", "least_seconds": 2.0, "most_seconds": 2.0,
                    "part": {"kind": "anything"},
                },
            ],
        },
        "excluded": [{"kind": "action", "words": ["walk"], "sides": [], "manner": ["slow"]}],
    }  # fmt: skip


def test_normal_form_of_joined_parts() -> None:
    assert join(InOrder, [join(InOrder, [WALK, RUN]), SIT]) == InOrder((WALK, RUN, SIT))
    assert join(AnyOf, [WALK]) == WALK
    assert at_once([Both((WALK, RUN)), SIT]) == AtOnce((WALK, RUN, SIT))
    assert without(without(WALK, [RUN]), [AnyOf((SIT, RUN))]) == Without(WALK, (RUN, SIT, RUN))
    assert without(WALK, []) == WALK


def test_actions_are_those_asked_for() -> None:
    tree = parse("walk or run, then sit, but not jump").tree
    assert actions_of(tree) == (WALK, RUN, SIT)
    assert [node for node in walk(tree) if isinstance(node, Action)][-1] == Action(("jump",))


def test_synonyms_are_followed() -> None:
    assert parse("stroll, not jog", {"stroll": "walk", "jog": "run"}).tree == Without(WALK, (RUN,))


def test_what_has_no_use_is_named_with_the_reason() -> None:
    assert parse("only walk at 30 fps").not_used == (
        NotUsed("only", "what else a capture shows is not compared"),
        NotUsed("at 30 fps", "what it measures is not compared"),
    )
    assert parse("walk, not twice").not_used == (
        NotUsed("not 2 times", "no action follows that could be excluded"),
    )
    assert parse("walk while not ?").not_used[0].text == "not ?"
    assert parse("walk OR").not_used == (NotUsed("OR", "no action follows it"),)
    assert parse("or walk").not_used == (NotUsed("or", "no action stands before it"),)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("the ?", "query: expected words that describe a motion, found 'the ?'. "
         "Ask for example for 'walk, turn left, sit down'."),
        ("twice for 5 s", "query: expected words that describe a motion, found 'twice for 5 s'. "
         "Ask for example for 'walk, turn left, sit down'."),
        ("(walk", "question: expected ')' for every '(', found the end. Close the parentheses."),
        ("walk)", "question 'walk)': expected '(' before ')', found none. Leave out ')'."),
        ("(" * 21 + "walk" + ")" * 21, "question: expected at most 20 nested "
         "parentheses, found more. Ask for less at a time."),
        ("walk " * 251, "question: expected at most 250 words, found 251. "
         "Ask for fewer actions at a time."),
        ("a" * 5_001, "question: expected at most 5,000 characters, found 5,001. "
         "Ask for fewer actions at a time."),
    ],
)  # fmt: skip
def test_refusals(text: str, message: str) -> None:
    with pytest.raises(QueryError) as error:
        parse(text)
    assert str(error.value) == message


def test_longest_questions_are_understood() -> None:
    assert len(actions_of(parse(", ".join(["walk"] * (MOST_TOKENS // 2))).tree)) == 125
    assert parse("walk" + " the" * ((MOST_CHARACTERS - 4) // 4)).tree == WALK
    assert parse("(" * 20 + "walk" + ")" * 20).tree == WALK
    assert isinstance(parse("walk" + " twice" * 249).tree, Repeated)


def amounts(part: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
    counts = st.tuples(st.integers(1, 9), st.integers(0, 3), st.booleans())
    seconds = st.tuples(st.integers(1, 200), st.integers(0, 9), st.booleans())
    return st.one_of(
        st.builds(lambda p, c: Repeated(p, c[0], c[0] + c[1] if c[2] else None), part, counts),
        st.builds(
            lambda p, c: Lasting(p, c[0] / 4, (c[0] + c[1]) / 4 if c[2] else None), part, seconds
        ),
    )


def joined(part: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
    several = st.lists(part, min_size=2, max_size=3)
    excluded = st.lists(part, min_size=1, max_size=2)
    return st.one_of(
        st.builds(lambda parts: join(InOrder, parts), several),
        st.builds(lambda parts: join(Both, parts), several),
        st.builds(lambda parts: join(AnyOf, parts), several),
        st.builds(lambda parts: at_once(parts), several),
        st.builds(lambda p, e: without(p, e), part, excluded),
        amounts(part),
    )


ACTIONS = st.builds(
    lambda verb, more, manner: Action((verb, *more), manner),
    st.sampled_from(("walk", "run", "jump", "kick")),
    st.sampled_from(((), ("left",), ("right", "leg"), ("down",))),
    st.sampled_from(((), ("slow",), ("happy",), ("fast",))),
)
TREES: st.SearchStrategy[Node] = st.recursive(ACTIONS, joined, max_leaves=7)


@settings(max_examples=300, deadline=None)
@given(TREES)
def test_any_tree_comes_back_from_its_restatement(tree: Node) -> None:
    assert parse(say(tree)).tree == tree


@settings(max_examples=300, deadline=None)
@given(st.one_of(
    st.text(max_size=80),
    st.lists(st.sampled_from(PIECES), max_size=25).map(" ".join),
    st.lists(st.sampled_from(PIECES), max_size=12).map("".join),
))  # fmt: skip
def test_any_text_is_understood_or_refused(text: str) -> None:
    with suppress(QueryError):
        question = parse(text)
        assert any(isinstance(node, Action) for node in walk(question.tree))
        assert all(a.words or a.manner for a in walk(question.tree) if isinstance(a, Action))
        json.dumps(to_json(question_tree(question.tree)))
        assert say(question.tree).strip()
        assert all(left.text and left.reason for left in question.not_used)


def test_wildcards_alone_ask_for_nothing() -> None:
    assert parse("?, walk").tree == InOrder((Anything(), WALK))
    with pytest.raises(QueryError, match="expected words that describe a motion"):
        parse("?, ?")
    assert isinstance(parse("? for 5 s, walk").tree.parts[0], Lasting)
