"""Grammars edited by hand: rules, names of terminals, and everything taken back exactly."""

from __future__ import annotations

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
    assert grammars.show("nested") == before
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
    for to in (other, "S", "empty", "two words", ""):
        with pytest.raises(QueryError, match="expected a new name of letters"):
            grammars.rename_terminal("nested", name, to)
    with pytest.raises(QueryError, match="terminal: expected one of nested"):
        grammars.rename_terminal("nested", "no-such", "hop")
    assert grammars.show("nested") == before
