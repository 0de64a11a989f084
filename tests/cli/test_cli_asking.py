"""The command `grammar ask`: questions, answers that are kept, and the learning that follows."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

from command_answers import answer

import motiondb
from motiondb import store
from motiondb.database.grammars import grammar_asking
from motiondb.grammar.cfg.context_free import derive_by
from motiondb.grammar.foresight import FEWEST_WINDOWS


def test_answers_are_kept_and_the_rules_keep_to_them(command: Any, copy: Path) -> None:
    words = ("grammar", "ask", "fight", "--db", copy)
    before = answer(command(*words, "--json"))
    assert before["kept"] == 0
    first, second = before["questions"][:2]
    said = (f"{first['first']} {first['then']} no", f"{second['first']} {second['then']} yes")
    options = ("--answer", said[0], "--answer", said[1], "--author", "Ana", "--png", "q.png")
    ended = command(*words, *options)
    assert ended.code == 0, ended.err
    assert "2 answers kept" in ended.out
    assert Path("q.png").stat().st_size > 1000
    after = answer(command(*words, "--json"))["questions"]
    asked = [(one["first"], one["then"]) for one in after]
    assert (first["first"], first["then"]) not in asked
    with motiondb.open(copy) as db:
        learned = db.grammars.load("fight")
        known = grammar_asking.load_answers(db.grammars.store, "fight")
        runs = [run for run in store.load_runs(db.grammars.store) if run.kind == "grammar answer"]
    assert [run.parameters["author"] for run in runs] == ["Ana", "Ana"]
    pairs = [(one["first"], one["then"]) for one in (first, second)]
    assert grammar_asking.terminal_answers(learned, known, grammar_asking.SAID) == dict(
        zip(pairs, ("no", "yes"))
    )
    answered, kept = grammar_asking.with_answers(learned, known)
    held = {pair for s in learned.strings for pair in pairwise(s)}
    assert kept == {pairs[1]: True} | ({} if pairs[0] in held else {pairs[0]: False})
    for sentence, rules in zip(learned.strings, answered.parses, strict=True):
        assert derive_by(answered.grammar, rules).leaves() == sentence


def test_answers_that_cannot_be_are_refused(command: Any, copy: Path) -> None:
    words = ("grammar", "ask", "fight", "--db", copy, "--author", "Ana", "--answer")
    for said, says in (
        ("a b", "expected 'FIRST THEN yes'"),
        ("a zz no", "expected terminals of fight"),
        ("a b perhaps", "yes, no or unknown"),
    ):
        ended = command(*words, said)
        assert (ended.code, says in ended.err) == (2, True), ended.err
    ended = command("grammar", "ask", "fight", "--db", copy, "--answer", "a b no")
    assert (ended.code, "author" in ended.err) == (2, True)


def test_learn_says_foresight_or_why_not(command: Any, taught: Path) -> None:
    facts = answer(command("grammar", "show", "fight", "--json", "--db", taught))
    assert facts["foresight"] is None  # one take
    assert f"{FEWEST_WINDOWS} windows" in facts["foresight_says"]
