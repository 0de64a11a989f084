"""The heads of actions, by the forms and places of words."""

from __future__ import annotations

import pytest

from motiondb.language.question.heads import heads_of, missing_heads, verbs_in
from motiondb.language.question.parse import parse
from motiondb.language.question.tree import actions_of


@pytest.mark.parametrize(
    ("text", "heads"),
    [
        ("clapping hands", [("clap",)]),
        ("crawling on hands and knees", [("crawl",)]),
        ("throw a ball", [("throw",)]),
        ("zombie walk", [("walk",)]),
        ("moonwalk", [("moonwalk",)]),
        ("a ballet dancer does a pirouette", [("pirouette",)]),
        ("he juggles balls", [("juggle",)]),
        ("play the violin, then bow", [("play",), ("bow",)]),
        ("picks up a box", [("pick",)]),
        ("walks carrying a box", [("walk", "carry")]),
        ("tennis serve", [("tennis", "serve")]),
        ("eat pizza", [("eat",)]),
        ("fighter stance", [("stance",)]),
        ("left hand up", [()]),
    ],
)
def test_heads_by_form_and_place(text: str, heads: list[tuple[str, ...]]) -> None:
    verbs = verbs_in(text)
    found = [heads_of(action.words, verbs) for action in actions_of(parse(text).tree)]
    assert found == heads


@pytest.mark.parametrize(
    ("text", "known", "missing"),
    [
        ("clapping hands", {"hand"}, (("clap",),)),
        ("walk, then juggle with balls", {"walk", "ball"}, (("juggle",),)),
        ("walk or juggle", {"walk"}, ()),
        ("juggle or crawl", {"walk"}, (("juggle",), ("crawl",))),
        ("zombie walk", {"walk"}, ()),
        ("walk, not juggling", {"walk"}, ()),
    ],
)
def test_missing_heads(text: str, known: set[str], missing: tuple[tuple[str, ...], ...]) -> None:
    assert missing_heads(parse(text).tree, verbs_in(text), known) == missing
