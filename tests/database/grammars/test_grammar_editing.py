"""Grammars edited by hand: rules, names of terminals, and everything taken back exactly."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.grammar.cfg.context_free import derive_by


def listed(db: MotionDB) -> str:
    """Rules that only list the sentences of the captures."""
    strings = dict.fromkeys(db.grammars.load("nested").strings)
    return "S -> " + " | ".join(" ".join(string) for string in strings)


def test_edits_are_whole_and_taken_back_exactly(dances: MotionDB) -> None:
    grammars = dances.grammars
    sequence = next(
        made
        for made in (grammars.generate("nested", seed) for seed in range(100))
        if made.string not in grammars.load("nested").strings
    )
    grammars.save("mine/new", sequence)
    first = grammars.load("nested").terminals.names[0]
    before = grammars.show("nested")

    assert grammars.rename_terminal("nested", first, "hop") == []
    assert "hop" in grammars.show("nested").text
    assert grammars.open("mine/new").string == tuple(
        "hop" if one == first else one for one in sequence.string
    )
    assert grammars.edit_rules("nested", listed(dances)) == ["mine/new"]
    learned = grammars.load("nested")
    assert [derive_by(learned.grammar, p).leaves() for p in learned.parses] == list(learned.strings)
    assert not grammars.show("nested").derives_new
    with pytest.raises(QueryError, match="a capture that a grammar derived"):
        grammars.open("mine/new")
    assert grammars.edits("nested") == ("rules", f"name of {first}")
    assert dances.check() == []

    assert grammars.undo_edit("nested") == "rules"
    assert grammars.undo_edit("nested") == f"name of {first}"
    assert grammars.show("nested") == replace(before, run=grammars.load("nested").run_id)
    assert grammars.open("mine/new").string == sequence.string
    with pytest.raises(QueryError, match="expected a grammar that was edited, found none"):
        grammars.undo_edit("nested")


def test_an_edit_that_cannot_hold_changes_nothing(dances: MotionDB) -> None:
    grammars = dances.grammars
    before = grammars.show("nested")
    name, other = grammars.load("nested").terminals.names[:2]
    for text, told in {
        "S ->": "expected names after '->'",
        "S -> nothing": "expected terminals of the captures or nonterminals with rules",
        f"{name} -> {other}": "expected nonterminals on the left, found the terminal",
        f"S -> {name}": "expected rules that derive every sentence of the captures",
    }.items():
        with pytest.raises(QueryError, match=told):
            grammars.edit_rules("nested", text)
    for to in (other, "S", "empty", "two words", "", "é", "a" * 61):
        with pytest.raises(QueryError, match="expected a new name of at most 60 of the letters"):
            grammars.rename_terminal("nested", name, to)
    with pytest.raises(QueryError, match="terminal: expected one of nested"):
        grammars.rename_terminal("nested", "no-such", "hop")
    assert grammars.show("nested") == before


def test_no_edit_is_made_of_what_stays_the_same(dances: MotionDB) -> None:
    grammars = dances.grammars
    before = grammars.show("nested")
    name = grammars.load("nested").terminals.names[0]
    assert grammars.edit_rules("nested", before.text) == []
    assert grammars.rename_terminal("nested", name, name) == []
    assert grammars.edits("nested") == ()
    assert grammars.show("nested") == before
    assert grammars.rename_terminal("nested", name, "_a") == []


def test_a_sequence_of_undone_rules_comes_back_without_derivation(dances: MotionDB) -> None:
    grammars = dances.grammars
    grammars.edit_rules("nested", listed(dances))
    grammars.save("mine/new", grammars.generate("nested"))
    dances.remove(["mine/new"])
    grammars.undo_edit("nested")
    dances.undo()
    assert dances.check() == []
    with pytest.raises(QueryError, match="a capture that a grammar derived"):
        grammars.open("mine/new")
    assert grammars.edit_rules("nested", listed(dances)) == []
    assert grammars.undo_edit("nested") == "rules"
    assert grammars.edits("nested") == ()


def test_taking_an_edit_back_finds_sequences_by_their_content(dances: MotionDB) -> None:
    grammars = dances.grammars
    sequence = grammars.generate("nested")
    for name in ("mine/renamed", "mine/removed"):
        grammars.save(name, sequence if name == "mine/renamed" else grammars.generate("nested", 1))
    grammars.edit_rules("nested", listed(dances))
    dances.remove(["mine/removed"])
    dances.rename("fatou/dance_1", "mine/removed")
    dances.rename("mine/renamed", "mine/other")
    grammars.undo_edit("nested")
    assert grammars.open("mine/other").string == sequence.string
    assert grammars.saved("nested") == ["mine/other"]
    assert dances.check() == []
