"""The commands of scenes: what they print, their JSON, and exit codes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest


def test_check_tells_the_class_of_a_grammar(command: Any) -> None:
    ended = command("scene", "grammar", "check", "basketball")
    assert ended.code == 0, ended.err
    assert "basketball: 19 nonterminals, 17 terminals, 43 rules, 18 semantic rules" in ended.out
    assert "S_A (attack): one tree for each of its 50 most probable strings" in ended.out
    assert "useless: nothing" in ended.out
    assert "clips" not in ended.out


def test_check_names_ambiguous_strings_and_useless_symbols(command: Any, tmp_path: Path) -> None:
    file = tmp_path / "bad.grammar"
    file.write_text('start S\nS -> S S | a\nT -> b\na := "walk"\nb := "b"\n')
    ended = command("scene", "grammar", "check", file)
    assert "S: ambiguous, 'a a a' has 2 trees" in ended.out
    assert "useless: T, b" in ended.out


def test_check_counts_clips_and_names_what_has_none(
    command: Any, learned_file: Path, tmp_path: Path
) -> None:
    file = tmp_path / "new.grammar"
    file.write_text('start S\nS -> a | b\na := "dribble"\nb := "yodel"\n')
    asked = ("scene", "grammar", "check", file, "--db", learned_file)
    assert "no clips for b: caption captures that show them" in command(*asked).out
    facts = json.loads(command(*asked, "--json").out)
    assert facts["clips"]["a"] > 3
    assert facts["clips"]["b"] == 0
    assert facts["starts"][0]["ambiguous"] == ""


def test_validate_shows_the_tree_or_where_it_fails(command: Any) -> None:
    good = command("scene", "validate", "basketball", "hold shoot")
    assert good.code == 0
    assert good.out.splitlines()[:4] == ["S_A", "  Attacks", "    Ball", "      Catch"]
    assert "      Pivot  (nothing)" in good.out
    bad = command("scene", "validate", "basketball", "hold dribble pivot_left dribble")
    assert bad.code == 1
    assert bad.out == ""
    assert "expected one of pivot_left, pass, shoot, layup, fake_shot, found 'dribble'" in bad.err
    facts = json.loads(command("scene", "validate", "basketball", "hold", "--json").out)
    assert (facts["allowed"], facts["position"]) == (False, 1)
    tree = json.loads(command("scene", "validate", "basketball", "push", "--json").out)["tree"]
    assert tree == ["S_D", [["Defenses", [["Defense", ["push"]]]]]]


def test_validate_tells_when_a_string_is_ambiguous(command: Any, tmp_path: Path) -> None:
    file = tmp_path / "twice.grammar"
    file.write_text('start S\nS -> S S | a\na := "walk"\n')
    ended = command("scene", "validate", file, "a a a a")
    assert "ambiguous: the most probable of 5 trees" in ended.out
    assert "ambiguous" not in command("scene", "validate", file, "a a").out
    file.write_text('start S\nS -> S | a\na := "walk"\n')
    assert json.loads(command("scene", "validate", file, "a", "--json").out)["trees"] is None
    assert "of endlessly many trees" in command("scene", "validate", file, "a").out


def test_draw_draws_and_tells_what_is_asked(command: Any, tmp_path: Path) -> None:
    out = tmp_path / "x.png"
    ended = command("scene", "draw", "give-and-go", "-o", out)
    assert ended.code == 0, ended.err
    assert out.stat().st_size > 10_000
    assert "Give and Go drawn to" in ended.out
    assert "(hold)(pass)(run)*(catch)(layup)  hold pass run catch layup" in ended.out
    facts = json.loads(command("scene", "draw", "weave-pass", "-o", out, "--json").out)
    assert facts["ball"] == "A1"


def test_suggest_tells_probabilities_and_goes_on_to_goals(command: Any) -> None:
    assert "(the end)" in command("scene", "suggest", "basketball", "guard", "--start", "S_D").out
    facts = json.loads(command("scene", "suggest", "basketball", "hold", "--json").out)
    chances = {row["action"]: row["probability"] for row in facts["next"]}
    # Pivot is empty, left or right alike; behind an empty one, half go on to dribble
    assert chances["pivot_left"] == chances["pivot_right"] == pytest.approx(1 / 3)
    assert chances["dribble"] == pytest.approx(1 / 6)
    ended = command("scene", "suggest", "basketball", "shoot")
    assert ended.code == 1
    assert "error: basketball: action 1, from S_A or S_D: expected" in ended.err
    words = ("scene", "suggest", "basketball", "hold", "--goal", "pass", "--goal", "shoot")
    string = json.loads(command(*words, "--json").out)["string"]
    assert command(*words).out.split() == string
