"""The commands of grammars: what they print, the promised JSON, exit codes."""

from __future__ import annotations

from inspect import signature
from pathlib import Path
from typing import Any

import pytest
from command_answers import answer, string_of

import motiondb
from motiondb.cli import grammars
from motiondb.database.grammars.grammar_facts import ParsedMotion
from motiondb.database.grammars.grammar_learning import GrammarSettings


def test_learn_says_what_was_learned(command: Any, copy: Path) -> None:
    words = ("grammar", "learn", "boris/punch_1", "--terminals", 3, "--sentences", "captures")
    ended = command(*words, "--name", "punch", "--db", copy)
    assert (ended.code, ended.out[:17]) == (0, "punch: 1 capture "), ended.err
    assert "of 3 terminals, 1 sentence, " in ended.out
    assert "note: punch only lists its sentences and derives nothing new." in ended.err
    facts = answer(command(*words, "--json", "--db", copy))
    assert facts["grammar"] == "punch_1"  # the capture's name, where none is given
    assert (facts["no_longer_editable"], facts["derives_new"]) == ([], False)
    actual = answer(command("grammar", "list", "--json", "--db", copy))
    assert [row["grammar"] for row in actual] == ["fight", "punch", "punch_1"]
    assert command("grammar", "list", "--db", copy).out.count("\n") == 3


def test_the_command_line_wishes_for_what_python_does_by_default() -> None:
    wished = {
        name: parameter.default for name, parameter in signature(grammars.learn).parameters.items()
    }
    settings = GrammarSettings()
    assert wished["shortest"] == settings.shortest
    assert wished["longest"] == settings.longest


def test_parse_tells_sentences_or_where_it_fails(command: Any, taught: Path) -> None:
    words = ("grammar", "parse", "fight")
    ended = command(*words, "boris/long_fight_1", "--png", "p.png", "--db", taught)
    assert ended.code == 0, ended.err
    first, *trees = ended.out.splitlines()
    assert first.endswith(" (as learned)")
    assert trees[0].startswith("1  S(")
    assert Path("p.png").stat().st_size > 1000
    ended = command(*words, "boris/punch_1", "--db", taught)
    assert " (read anew)" in ended.out
    facts = answer(command(*words, "boris/punch_1", "--json", "--db", taught), ended.code)
    assert (facts["fault"] is None) == (ended.code == 0)
    if facts["fault"]:
        assert facts["fault"]["says"] in ended.out
        assert "that is " in ended.out or facts["fault"]["found"] is None


def test_parse_tells_what_is_unlike_anything_learned(
    command: Any, taught: Path, samples_folder: Path
) -> None:
    words = ("grammar", "parse", "fight", samples_folder / "chidi" / "layup_1.bvh", "--db", taught)
    ended = command(*words)
    facts = answer(command(*words, "--json"), 1)
    assert facts["is_unlike"]
    said = f"is unlike what fight was learned from for {facts['share_unlike']:.0%} of its time"
    assert (ended.code, said in ended.out) == (1, True), ended.out
    worst = max(facts["unlike"], key=lambda n: facts["distances"][n])
    first = next(x for x in ended.out.splitlines() if x.split()[:1] == [str(worst)])
    assert first.split()[1] == facts["string"][worst]
    assert first.split()[-1] == f"{facts['distances'][worst]:.2f}"
    assert f"usual: within {facts['usual_distance']:.2f} m" in ended.out


@pytest.mark.parametrize(
    ("stored", "reach", "said"), [(False, None, True), (False, 0.5, False), (True, None, False)]
)
def test_parse_tells_when_terminals_have_too_few_members(
    capsys: pytest.CaptureFixture[str], stored: bool, reach: float | None, said: bool
) -> None:
    distances = () if stored else (0.1,)
    actual = ParsedMotion(("a",), (0.0,), (1.0,), stored, distances=distances, reach=reach)
    grammars._say_unlike(actual, "fight", "x")
    assert ("fight have too few members" in capsys.readouterr().err) == said


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (("show", "figth"), 2, "Did you mean fight?"),
        (("learn", "boris/punch_1", "--terminals", "auto"), 2, "is not a valid int"),
        (("learn", "boris/punch_1", "--from-symbols"), 2, "motiondb learn"),
        (
            ("learn", "boris/punch_1", "--from-symbols", "--terminals", "9"),
            2,
            "Leave one of them out",
        ),
        (("edit", "fight", "a zz", "--at", "0"), 2, "'zz'"),
        (("edit", "fight", "x", "--at", "0", "--save", ""), 2, "Add --choose"),
        (("edit", "fight", "x", "--at", "0", "--choose", "1"), 2, "-o FILE or --save NAME"),
        (
            ("generate", "fight", "-o", "x.txt"),
            2,
            "expected a name that ends in .bvh, .fbx, .glb",
        ),
        (("generate", "fight", "-o", "x.bvh", "--save", "boris/punch_1"), 2, "a name that is free"),
        (("generate", "fight", "-o", "x.bvh", "--save", ""), 2, "expected a name for the capture"),
        (("generate", "fight", "-o", "x.bvh", "--length", "20000"), 2, "--length"),
        (
            ("edit", "fight", "x", "--at", "0", "--choose", "1", "--save", ""),
            2,
            "expected a name for the capture, found nothing",
        ),
        (("suggest", "fight", "d d d d d d d"), 1, "expected"),
        (("edit", "fight", "", "--at", "0"), 1, "expected"),
        (("show", "fight", "--strings", "t"), 2, "expected a name that ends in .png"),
        (("edit", "fight", "x", "--at", "0", "--png", "t.gif"), 2, "expected a name that ends in"),
    ],
)
def test_what_cannot_be_done_is_told(
    command: Any, copy: Path, words: tuple[str, ...], code: int, says: str
) -> None:
    ended = command("grammar", *words, "--db", copy)
    assert (ended.code, says in ended.err) == (code, True), ended.err
    assert not Path("x.bvh").exists()
    with motiondb.open(copy) as db:
        assert [i.name for i in db.captures()] == ["boris/long_fight_1", "boris/punch_1"]
        assert db.grammars.names() == ["fight"]


def test_rules_are_edited_a_terminal_is_renamed_and_both_are_undone(
    command: Any, copy: Path, tmp_path: Path
) -> None:
    before = command("grammar", "rules", "fight", "--db", copy).out
    first = before.split("-> ")[1].split()[0]
    renamed = command("grammar", "rename", "fight", first, "step", "--db", copy)
    assert renamed.out == f"{first} of fight is now step\n"
    edited = tmp_path / "rules.txt"
    edited.write_text(command("grammar", "rules", "fight", "--db", copy).out)
    told = command("grammar", "rules", "fight", edited, "--db", copy).out
    assert told == "fight has these rules already\n"
    edited.write_text("S -> step")
    assert command("grammar", "rules", "fight", edited, "--db", copy).code == 2
    undone = answer(command("grammar", "undo", "fight", "--json", "--db", copy))
    said = {"grammar": "fight", "no_longer_editable": [], "undone": f"name of {first}"}
    assert undone == said
    assert command("grammar", "rules", "fight", "--db", copy).out == before
    missing = command("grammar", "rules", "fight", tmp_path / "none.txt", "--db", copy)
    assert missing.code == 1


def test_suggest_lists_what_may_come_next_and_leads_to_a_goal(command: Any, taught: Path) -> None:
    string = string_of(command, taught)
    words = ("grammar", "suggest", "fight", " ".join(string), "--db", taught)
    facts = answer(command(*words, "--json"))
    assert sum(row["probability"] for row in facts) == pytest.approx(1.0)
    assert "the end" in command(*words).out
    assert command("grammar", "suggest", "fight", "--db", taught).code == 0
    words = ("grammar", "suggest", "fight", string[0], "--goal", string[1], "--db", taught)
    way = answer(command(*words, "--json"))
    assert way["to_goal"][-1] == string[1]
    ended = command(*words)
    assert f"to {string[1]}: {' '.join(way['to_goal'])}" in ended.out
    assert f"tree:  {way['tree']}" in ended.out


def test_show_and_compare_answer_in_json(command: Any, taught: Path) -> None:
    facts = answer(command("grammar", "show", "fight", "--json", "--db", taught))
    assert len(facts["terminals"]) == 6
    assert facts["captures"][0]["capture"] == "boris/long_fight_1"
    learned, machine = answer(command("grammar", "compare", "fight", "--json", "--db", taught))
    assert learned["outside"] == 0.0
    assert machine["outside"] >= 0.0
