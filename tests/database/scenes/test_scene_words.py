"""Phrases of a motion grammar in words that no caption holds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb.database.loading import nearby_table
from motiondb.grammar.terminals.terminals import TerminalSettings
from motiondb.language.nearby.table import UNIT, read_table, write_table
from motiondb.scene.clips.caption_actions import Phrases, take_phrases
from motiondb.scene.language.grammar_file import read_motion_grammar

STROLL = 'grammar odd\nstart S\nS -> amble\namble := "stroll"\n'
BOTH = 'grammar odd\nstart S\nS -> amble | walk\namble := "stroll"\nwalk := "walk"\n'


def phrases(*texts: str) -> Phrases:
    return tuple(frozenset(text.split()) for text in texts)


def test_words_are_taken_from_the_bound_up_and_phrases_without_a_sense_are_dropped() -> None:
    hurl = [("throw", 0.9), ("toss", 0.85), ("fling", 0.45)]
    pairs = {"hurl": [(w, round(p / UNIT)) for w, p in hurl], **{w: [] for w, _ in hurl}}
    table = read_table(write_table(pairs, []))
    asked = {"a": phrases("hurl ball", "hurl zzz"), "b": phrases("ball")}
    known = frozenset({"throw", "toss", "fling", "cube"})
    assert take_phrases(asked, ["a"], known, table).phrases == {}
    actual = take_phrases({"a": asked["a"]}, ["a"], known | {"ball"}, table)
    assert set(actual.phrases["a"]) == {frozenset({"throw", "ball"}), frozenset({"toss", "ball"})}
    assert [w for w, _ in actual.takings["hurl"].words] == ["throw", "toss"]


def test_a_word_is_not_taken_as_what_another_terminal_asks_for() -> None:
    asked = {"amble": phrases("stroll"), "walk": phrases("walk")}
    table, known = nearby_table(), frozenset({"walk", "run"})
    assert take_phrases(asked, ["amble"], known, table).phrases == {}
    alone = take_phrases({"amble": asked["amble"]}, ["amble"], known, table)
    assert alone.phrases == {"amble": phrases("walk")}


def test_a_terminal_is_shown_by_captions_in_nearby_words(db: motiondb.MotionDB) -> None:
    grammar = read_motion_grammar(STROLL, "odd.grammar")
    walk = read_motion_grammar(STROLL.replace("stroll", "walk"), "odd.grammar")
    assert db.scenes.find_actions(grammar) == db.scenes.find_actions(walk)
    assert db.scenes.taken_words(grammar)["stroll"].words[0][0] == "walk"
    assert db.scenes.taken_words(walk) == {}
    assert db.scenes.find_actions(grammar, exact=True) == {"amble": ()}
    apart = db.scenes.find_actions(read_motion_grammar(BOTH, "odd.grammar"))
    assert apart["amble"] == ()
    assert apart["walk"]


def test_the_command_says_what_a_phrase_is_taken_as(
    command: Any, learned_file: Path, tmp_path: Path
) -> None:
    (tmp_path / "odd.grammar").write_text(STROLL)
    asked = ("scene", "grammar", "check", tmp_path / "odd.grammar", "--db", learned_file)
    told = command(*asked)
    assert "odd: 'stroll' is not in the captions; replaced by walk (0.9)" in told.err
    assert "no clips" not in told.out
    exact = command(*asked, "--exact")
    assert exact.err == ""
    assert "no clips for amble" in exact.out


def test_a_pattern_of_a_learned_grammar_takes_nearby_words(
    command: Any, learned_copy: Path
) -> None:
    with motiondb.open(learned_copy) as db:
        search = TerminalSettings(n_starts=1, n_trials=150)
        settings = motiondb.GrammarSettings(6, search=search, evaluations=300)
        db.grammars.learn(["boris/long_fight_1"], "fight", settings)
        asked = db.grammars.complete("fight", "... punch ...", 3)
        assert db.grammars.complete("fight", "... jab ...", 3).sentences == asked.sentences
        assert db.grammars.taken_in_pattern("fight", "... jab ...")["jab"].words
        assert db.grammars.taken_in_pattern("fight", "... punch ...") == {}
        with pytest.raises(motiondb.QueryError, match="expected a terminal"):
            db.grammars.complete("fight", "... jab ...", 3, exact=True)
        made = db.grammars.generate("fight", 1, like="... jab ...")
        same = db.grammars.generate("fight", 1, like="... punch ...")
        np.testing.assert_array_equal(made.motion.root_positions, same.motion.root_positions)
    told = command("grammar", "suggest", "fight", "--like", "... jab ...", "--db", learned_copy)
    assert "'jab' is not in the captions; replaced by punch (0." in told.err
