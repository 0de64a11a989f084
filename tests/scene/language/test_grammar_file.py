"""The text format of motion grammars: the shipped ones, repetitions, defaults, every refusal."""

from __future__ import annotations

import math
from itertools import product

import pytest

from motiondb.database.scenes.scene_texts import read_grammar, shipped
from motiondb.errors import SceneError
from motiondb.grammar.cfg.parse import accepts
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.semantic_rules import (
    DirectionRule,
    DistanceRule,
    LineRule,
    PositionRule,
    SynchronisationRule,
)

HEAD = 'start S\nplace object\na := "a"\nb := "b"\n'


def read(text: str) -> MotionGrammar:
    return read_motion_grammar(HEAD + text, "x.grammar")


def rules(grammar: MotionGrammar, symbol: str, *above: str) -> dict[type, object]:
    return {type(rule): rule for rule in grammar.rules_of(symbol, above)}


def test_the_shipped_grammars() -> None:
    assert shipped(".grammar") == ("basketball", "carrying", "delivery", "meeting", "sparring")
    grammar = read_grammar("basketball")
    assert len(grammar.grammar.nonterminals) == 19
    assert len(grammar.terminals) == 17
    assert [(start.symbol, start.team) for start in grammar.starts] == [
        ("S_A", "attack"),
        ("S_D", "defence"),
    ]
    carrying = read_grammar("carrying")
    assert sorted(carrying.grammar.nonterminals) == ["B", "P", "S", "W"]
    assert set(carrying.terminal) == {"walk", "pickup", "carry", "putdown"}


FACES = {DirectionRule: {"target": "opponent"}}
ON_LINE = {LineRule: {"first": "opponent", "second": "rim"}}


@pytest.mark.parametrize(
    ("action", "above", "wanted"),
    [
        (
            "pass",
            ("S_A",),
            {
                DirectionRule: {"target": "receiver"},
                SynchronisationRule: {"partner": "receiver", "actions": ("catch",), "lag": None},
            },
        ),
        ("layup", ("S_A",), {DirectionRule: {"target": "target"}, DistanceRule: {"far": 2.5}}),
        ("shoot", ("S_A",), {DirectionRule: {"target": "target"}, DistanceRule: {"near": 1.5}}),
        ("feint", ("S_A",), {DistanceRule: {"target": "opponent", "near": 0.0, "far": 1.0}}),
        ("fake_shot", ("S_A",), {DistanceRule: {"target": "opponent", "near": 0.0, "far": 1.0}}),
        (
            "screen",
            ("S_A",),
            {
                DirectionRule: {"target": "receiver"},
                SynchronisationRule: {"partner": "opponent", "actions": ("push",), "lag": 0.0},
            },
        ),
        ("run", ("S_A",), {}),
        ("run", ("S_D", "Defense"), FACES | ON_LINE),
        ("walk", ("S_D", "Defense"), FACES | ON_LINE),
        ("guard", ("S_D", "Defense"), {DistanceRule: {"near": 0.5, "far": 2.0}}),
        (
            "block",
            ("S_D", "Defense"),
            FACES | ON_LINE | {SynchronisationRule: {"actions": ("shoot", "fake_shot")}},
        ),
    ],
)
def test_all_semantic_rules_of_the_appendix(action: str, above: tuple, wanted: dict) -> None:
    grammar = read_grammar("basketball")
    actual = rules(grammar, action, *above)
    assert set(actual) == set(wanted)
    for kind, fields in wanted.items():
        assert {name: getattr(actual[kind], name) for name in fields} == fields
    assert len(grammar.annotations) == 18


def test_carrying_asks_to_face_the_object_and_be_near() -> None:
    grammar = read_grammar("carrying")
    actual = rules(grammar, "pickup", "S", "P")
    assert actual[DirectionRule].target == "object"
    assert actual[DistanceRule].far == 0.5
    first, last = grammar.rules_of("S", ())
    assert (first.target, first.moment.name) == ("origin", "start")
    assert (last.target, last.moment.name) == ("goal", "end")
    assert accepts(grammar.grammar, ["walk", "walk", "pickup", "carry", "putdown", "walk"])
    assert not accepts(grammar.grammar, ["walk", "pickup", "putdown", "walk"])


@pytest.mark.parametrize(
    ("rule", "matches"),
    [
        ("S -> a*", {"", "a", "aa", "aaa"}),
        ("S -> a+", {"a", "aa", "aaa"}),
        ("S -> a b? a", {"aa", "aba"}),
        ("S -> (a | b a)* b", {"b", "ab", "aab", "bab"}),
        ("S -> (a b)+ | b", {"b", "ab"}),
        ("S -> ((a | b) a)?", {"", "aa", "ba"}),
        ("S -> a | empty\n  | b b", {"a", "", "bb"}),
        ("S -> (a & b & a b)", set()),  # four letters
        ("S -> (a & b)", {"ab", "ba"}),
        ("S -> (a & b?) | b b", {"a", "ab", "ba", "bb"}),
        ("S -> a*\nS -> b b*", {"", "a", "aa", "aaa", "b", "bb", "bbb"}),
    ],
)
def test_repetitions_mean_what_they_say(rule: str, matches: set[str]) -> None:
    grammar = read(f"{rule}\n").grammar
    strings = ["".join(s) for n in range(4) for s in product("ab", repeat=n)]
    assert {string for string in strings if accepts(grammar, string)} == matches


def test_probabilities_are_shared_out() -> None:
    grammar = read("S -> a [0.5] | b | S b").grammar
    assert [rule.probability for rule in grammar.rules] == [0.5, 0.25, 0.25]


def test_an_alternative_that_is_repeated_weighs_more() -> None:
    once = read("S -> a [0.75] | (a b)+ [0.25]").grammar
    said = read("S -> a | a | (a b)+\nS -> a").grammar
    assert said == once
    said = read("S -> a [0.25] | a [0.5] | (a b)+").grammar
    assert said == once


def test_units_moments_and_weights() -> None:
    grammar = read_motion_grammar(
        """
        start S
        place object
        S -> a b
        a := "a" event release
        b := "b"
        a: position(object), direction(90 deg) at start weight 0.5 rad
        b: position(object) weight 20 cm, line(object, object) throughout
        b: distance(object, 50 cm .. 2 m), synchronisation(opponent, a | b, 3 frames)
        S: position(object) at end
        weight position 2 m
        weight collision 0.5
        weight effort 30 m
        """,
        "x.grammar",
    )
    at_event, turned = grammar.rules_of("a", ())
    assert (at_event.moment.name, at_event.weight) == ("release", 2.0)
    assert (turned.target, turned.moment.name, turned.weight) == (math.pi / 2, "start", 0.5)
    placed, line, distance, synchronised = grammar.rules_of("b", ())
    assert (placed.moment.name, placed.weight) == ("throughout", 0.2)
    assert (line.moment.name, line.weight) == ("throughout", LineRule.weight)
    assert (distance.near, distance.far) == (0.5, 2.0)
    assert (synchronised.lag, synchronised.actions) == (0.1, ("a", "b"))
    (last,) = grammar.rules_of("S", ())
    assert isinstance(last, PositionRule)
    assert (grammar.weights.collision, grammar.weights.effort) == (0.5, 30.0)
    assert grammar.weights.user == 0.1


def test_rules_may_hold_below_a_nonterminal_only() -> None:
    grammar = read("S -> a T\nT -> a\na in T: position(object)")
    assert len(grammar.rules_of("a", ("S", "T"))) == 1
    assert grammar.rules_of("a", ("S",)) == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("S -> a ?b(", "5:11: expected '(' or a symbol, found the end of the line."),
        ("S -> a ) b", "5:8: expected the end of the line, found ')'. Write one statement a line."),
        ("S -> (a | b", "5:12: expected ')', found the end of the line. Close the bracket."),
        ("S -> a | empty b", "5:10: expected 'empty' alone, found 'empty'."),
        ("S -> a [0]", "5:9: expected a probability above 0 and at most 1, found '0'."),
        ("S -> a %", "5:8: expected a name, a number or a sign, found '%'. Correct it."),
        ("S -> a\nplce x", "6:1: expected 'place', found 'plce'. Did you mean place?"),
        ("S -> a\nplace x hight 1 m", "6:9: expected 'height', found 'hight'. Did you mean"),
        ("S -> a\na: distnce(object, < 1 m)", "6:4: expected 'distance', found 'distnce'. Did"),
        ("S -> a\na: position(object) wieght 1 m", "6:21: expected 'weight', found 'wieght'."),
        ("S -> a\na, b answrs a", "6:6: expected 'answers', found 'answrs'."),
        ("S -> a\nverb v = a tehn b to X Z", "6:12: expected 'then', found 'tehn'. Did you mean"),
        ("S -> a\nverb v = a wth partner", "6:12: expected 'with', found 'wth'."),
        ("S -> a\nweight colision 1", "Did you mean collision"),
        ("S -> a\nverb a = b\nverb a = a", "7:6: expected the verb a once, found 'a'. Line 6"),
        ("S -> a\nrole r, r", "6:9: expected every role once, found 'r'. Line 6 says it already"),
        ("S -> a\nrest a\nrest a", "7:6: expected every rest once"),
        ("S -> a\nground 8 x 6\nground 9 x 6", "expected 'ground' once"),
        ("S -> a\na answers b\na, b answers b", "7:1: expected once that a answers b"),
        (
            "S -> a\na: position(object)\nb, a: position(object) weight 1 m",
            "7:4: expected every rule of a once, found 'a'. Line 6 says it already",
        ),
        (
            "S -> a\nobject cup\na: take(cup)\na: keep(cup)",
            "8:1: expected one thing that a does with the object, found 'a'. Line 7",
        ),
        ("S -> c", "5:6: expected a nonterminal with rules, or a terminal declared with ':=',"),
        ("T -> a", "1:7: expected a start symbol that has a rule, found 'S'."),
        ("S -> a\na -> b", "3:1: expected a terminal, found 'a'. a has rules, so it is a"),
        (
            'S -> a\na := "x"',
            "6:1: expected a terminal that is not declared yet, found 'a'. Line 3",
        ),
        (
            'S -> c\nc := without "x"',
            "6:6: expected quoted words that find the action's clips or 'terminal',",
        ),
        ('S -> c\nc := "', "6:6: expected a closing quote, found '\"'."),
        ("S -> a S", "5:1: expected S to end in actions, found only rules that lead to what never"),
        ("S -> a\na: far(object)", "6:4: expected a kind of rule (position, direction, distance,"),
        ("S -> a\na: distance(rim, < 1 m)", "6:13: expected a place or a role, found 'rim'."),
        ("S -> a\na: distance(object, 1 m)", "6:24: expected '..', found ')'. Write <= 2.5 m,"),
        ("S -> a\na: distance(object, 2 m .. 1 m)", "6:21: expected distances of 0 or more, the"),
        ("S -> a\na: distance(object, < 1 km)", "6:25: expected a unit of length (m, cm), found"),
        ("S -> a\na: position(objct)", "found 'objct'. Did you mean object?"),
        ("S -> a\na: position(object) weight 0 m", "6:28: expected a weight above 0, found '0'."),
        ("S -> a\nc: position(object)", "6:1: expected a symbol of the grammar, found 'c'."),
        ("S -> a\na in b: position(object)", "6:6: expected a nonterminal, found 'b'."),
        ("S -> a\na: line(object)", "6:15: expected ',', found ')'. A line has two ends:"),
        (
            "S -> a\na: synchronisation(object, b, 0 s)",
            "6:20: expected a role, found 'object'",
        ),
        ("S -> a\na: synchronisation(opponent, c, 0 s)", "6:30: expected an action declared with"),
        ("S -> a\nweight smooth 1e-300", "6:15: expected a weight from 1e-06 to 1e+06, found '1e"),
        (
            "S -> a\nweight user 1\nweight user 2",
            "7:8: expected the weight of user once, found 'user'. Line 6 says it already",
        ),
        ("S -> a\na: direction(1e20 deg)", "6:14: expected a heading from -360 to 360 deg, found"),
        (
            "S -> a\na: synchronisation(opponent, b, 1000000 s)",
            "6:33: expected a time from -60 to 60 s, found '1000000'.",
        ),
        (
            "S -> a\na: position(object) at release",
            "6:1: expected a moment of a (start, end, throughout), found 'release'. Write 'event",
        ),
        (
            'S -> a c\nc := "c" event catch\nc: position(object) at release',
            "7:1: expected a moment of c (start, end, throughout, catch), found 'release'. Write",
        ),
        ("S -> a\nS: position(object) at release", "Name the instant at one of its actions."),
        ("S -> a [0.9] | b [0.9]", "5:1: expected probabilities of S that sum to 1, found a sum"),
        ("S -> a [0.5] | b [0.5] | b a", "expected probabilities of S that sum to less than 1,"),
        ("S -> " + 60 * "(" + "a" + 60 * ")", "5:56: expected at most 50 brackets in one another"),
        ("S -> a\nplace goal, object", "6:13: expected every place once, found 'object'."),
        (
            "S -> a\nplace receiver",
            "6:7: expected a name of a place, found 'receiver'. receiver",
        ),
        (
            "S -> a\nstart S for attack",
            "6:7: expected one start symbol for the role attack, found 'S'. Line 1 says where",
        ),
        ("S -> a\ngrammar x\ngrammar y", "7:1: expected 'grammar' once, found 'grammar'. Line 6"),
        (
            "S -> a\na: synchronisation(opponent, b, 0 s) at start",
            "expected a synchronisation at the events of both, found 'a'. Leave 'at start' out.",
        ),
    ],
)
def test_refusals_name_the_place_and_what_was_expected(text: str, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        read(text)
    assert message in str(caught.value)
    assert str(caught.value).startswith("x.grammar:")


def test_a_grammar_needs_rules_and_a_start() -> None:
    with pytest.raises(SceneError) as caught:
        read_motion_grammar("grammar x", "x.grammar")
    assert str(caught.value) == (
        "x.grammar: expected at least one rule such as 'S -> run', found none."
        " Write the rules of order."
    )
    with pytest.raises(SceneError) as caught:
        read_motion_grammar('S -> a\na := "a"', "x.grammar")
    assert "expected a line 'start SYMBOL', found none. Write 'start S'" in str(caught.value)


def test_teams_and_start_symbols() -> None:
    grammar = read_grammar("basketball")
    assert grammar.start_of("defence") == "S_D"
    assert read_grammar("carrying").start_of("attack") == "S"
    with pytest.raises(SceneError) as caught:
        grammar.start_of("player")
    assert "expected a start symbol for the role 'player'" in str(caught.value)
    with pytest.raises(SceneError) as caught:
        grammar.started("S_B")
    assert "Did you mean S_D or S_A?" in str(caught.value)


def test_what_is_no_grammar_file(tmp_path) -> None:
    with pytest.raises(SceneError) as caught:
        read_grammar("basketbal")
    assert str(caught.value) == (
        "basketbal: expected a motion grammar, found: No such file or directory."
        " Did you mean basketball?"
    )
    (tmp_path / "x.grammar").write_text('\ufeffstart S\r\nS -> a\r\na := "a"\r\n', "utf-8")
    assert read_grammar(tmp_path / "x.grammar").grammar.nonterminals == ("S",)
    (tmp_path / "x.grammar").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError) as caught:
        read_grammar(tmp_path / "x.grammar")
    assert "expected text in UTF-8" in str(caught.value)
