"""docs/guide/scenes.md is true: its files can be read, its numbers are those of the program."""

from __future__ import annotations

import re
from pathlib import Path

from activities import BASKETBALL, read_diagram

from motiondb.database.scenes import scene_texts
from motiondb.scene.language import activity, tactics_file
from motiondb.scene.language.expressions import expressions
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.services import services
from motiondb.scene.services.casting import cast

PAGE = Path(__file__).resolve().parents[3] / "docs" / "guide" / "scenes.md"
STATEMENTS = ("verb", "role", "object", "ground", "mark", "rest", "answers", "place", "weight")
TEXT = PAGE.read_text(encoding="utf-8")


def block(language: str, number: int = 0) -> str:
    return str(re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)[number])


def test_the_grammar_of_the_page_is_one() -> None:
    grammar = read_motion_grammar(block("grammar", 1), "page")
    assert grammar.grammar.nonterminals == ("S", "Walk", "Walk.1", "Carry", "Carry.1")
    assert [rule.probability for rule in grammar.grammar.rules if rule.left == "Carry"] == [
        0.9,
        1 - 0.9,
    ]
    assert len(grammar.annotations) == 4
    (start,) = services.check(grammar).starts
    assert start.ambiguous == ()


def test_the_activity_of_the_page_is_the_shipped_one() -> None:
    grammar = read_motion_grammar(block("grammar"), "page")
    shipped = scene_texts.read_grammar("meeting")
    assert (grammar.grammar, grammar.activity) == (shipped.grammar, shipped.activity)
    assert {(a.symbol, a.rule) for a in grammar.annotations} == {
        (a.symbol, a.rule) for a in shipped.annotations
    }
    diagram = tactics_file.read_diagram(block("tactics"), "page", grammar.activity)
    assert cast(diagram, grammar).keys() == {"Anna", "Ben"}


def test_the_diagram_of_the_page_is_one() -> None:
    diagram = read_diagram(block("tactics", 1), "page")
    asked = ["".join(map(str, items)) for items in expressions(diagram).values()]
    assert asked == ["(hold)(pass)(run)*(catch)(layup)", "(catch)(pass)", "(guard)*"]


def test_the_diagram_with_real_captures_is_one() -> None:
    diagram = read_diagram(block("tactics", 2), "page")
    asked = ["".join(map(str, items)) for items in expressions(diagram).values()]
    assert asked == ["(hold)(dribble)*(shoot)", "(run)*", "(run)*"]


def test_every_element_and_shipped_file_stands_on_the_page() -> None:
    for verb in BASKETBALL.activity.declared:
        assert re.search(rf"[`\n ]{verb.name}\b", TEXT), verb.name
    for word in (*STATEMENTS, *activity.DEEDS, *activity.ROLES):
        assert re.search(rf"[`\n ]{word}\b", TEXT), word
    for ending in (scene_texts.GRAMMAR, scene_texts.TACTICS):
        for name in scene_texts.shipped(ending):
            assert f"`{name}`" in TEXT
