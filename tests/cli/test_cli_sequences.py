"""The commands that generate, edit and complete sequences of a grammar: files, JSON, exit codes."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command_answers import answer, string_of

import motiondb
from motiondb.answers.grammars import WrittenSequence
from motiondb.cli import sequences
from motiondb.database.grammars.grammar_sequences import Edit
from motiondb.errors import QueryError
from motiondb.grammar.cfg.context_free import derive_by, read_grammar
from motiondb.grammar.derivation.edit import alternatives, region_at


def test_generate_edit_and_choose(command: Any, copy: Path) -> None:
    words = ("grammar", "generate", "fight", "-o", "new.bvh", "--seed", 3, "--length", 8)
    ended = command(*words, "--save", "new/fight", "--png", "new.png", "--db", copy)
    assert ended.code == 0, ended.err
    assert "s of motion written to new.bvh, kept as new/fight (seed 3)" in ended.out
    assert "seams cost " in ended.out
    assert json.loads(Path("new.bvh.provenance.json").read_text())["grammar"] == "fight"
    assert answer(command(*words, "--json", "--db", copy))["seed"] == 3

    edit = ("grammar", "edit", "fight", "new/fight", "--at", 0, "--number", 2)
    offered = answer(command(*edit, "-o", "way.bvh", "--json", "--db", copy))
    assert 1 <= len(offered["alternatives"]) <= 2
    for number, row in enumerate(offered["alternatives"], start=1):
        assert row["output"] == f"way-{number}.bvh"
        assert Path(row["output"]).stat().st_size > 1000
    ended = command(*edit, "--png", "edit.png", "--db", copy)
    region = offered["region"]
    assert f"{region['symbol']} derives {region['start']} to {region['end'] - 1}" in ended.out
    assert Path("edit.png").stat().st_size > 1000
    ended = command(*edit, "--choose", 1, "-o", "c.bvh", "--save", "new/edited", "--db", copy)
    assert ended.code == 0, ended.err
    assert Path("c.bvh").read_bytes() == Path("way-1.bvh").read_bytes()
    ended = command("grammar", "remove", "fight", "--db", copy)
    assert ended.out == "fight removed\n"
    assert ended.err.startswith("note: new/edited, new/fight can no longer be edited")


def test_sentences_follow_one_another_for_a_wanted_time(command: Any, copy: Path) -> None:
    words = ("grammar", "generate", "fight", "-o", "long.bvh", "--seconds", 40, "--db", copy)
    ended = command(*words, "--save", "new/long")
    assert ended.code == 0, ended.err
    assert re.search(r"\d+ sentences follow one another, each drawn by itself; a chain", ended.out)
    ended = command(*words, "--length", 8)
    assert (ended.code, "expected --seconds alone" in ended.err) == (2, True), ended.err


def test_nothing_is_kept_where_a_file_cannot_be_written(command: Any, copy: Path) -> None:
    words = ("grammar", "generate", "fight", "-o", "x.bvh", "--save", "new/fight", "--db", copy)
    ended = command(*words, "--png", "nowhere/x.png")
    assert (ended.code, "nowhere/x.png" in ended.err) == (2, True), ended.err
    with motiondb.open(copy) as db:
        assert len(db.captures()) == 2


def test_a_wish_that_no_sentence_fulfils_is_told(command: Any, copy: Path) -> None:
    ended = command("grammar", "generate", "fight", "-o", "x.bvh", "--length", 1, "--db", copy)
    n = len(next(x for x in ended.out.splitlines() if x.startswith("string: ")).split()) - 1
    assert (ended.code, n > 1) == (0, True)
    assert ended.err.endswith(f"note: no sentence has 1 terminals; the nearest has {n}\n")


def test_alternatives_that_cannot_be_played_are_offered_with_the_reason(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    toy = read_grammar("S -> a B\nB -> b | c | d")
    tree = derive_by(toy, (0, 1))
    region = region_at(tree, 1)
    alternatives_offered = alternatives(toy, tree, region, 2, np.random.default_rng(0))
    edited = Edit(tree, (), region, alternatives_offered)

    def play(_name: str, edited: Edit, number: int) -> tuple[str, ...]:
        if edited.tree(number).leaves()[1] in gone:
            raise QueryError("d: expected a capture with this terminal, found none. Add it.")
        return edited.tree(number).leaves()

    def written(
        _base: object, made: tuple[str, ...], _seed: int, _output: object
    ) -> WrittenSequence:
        facts = dict.fromkeys((f.name for f in fields(WrittenSequence)), ())
        return WrittenSequence(
            **facts | {"string": made, "seconds": 2.0, "join_cost": 0.5, "output": None}
        )

    gone = ["d"]
    base: Any = SimpleNamespace(grammars=SimpleNamespace(play=play))
    monkeypatch.setattr(sequences, "_written", written)
    facts = sequences._offer(base, "toy", edited, 0, None)
    rows = {row.string[1]: row for row in facts.alternatives}
    assert rows["d"].not_playable.startswith("d: expected a capture")
    assert rows["d"].region == ("d",)
    assert (rows["c"].seconds, hasattr(rows["c"], "not_playable")) == (2.0, False)
    sequences._say_offer(facts)
    out, err = capsys.readouterr()
    number = 1 + list(rows).index("d")
    assert f"note: {number} cannot be played: d: expected a capture" in err
    assert out.count("2.00") == 1
    gone = ["c", "d"]
    with pytest.raises(QueryError, match="d: expected a capture with this terminal"):
        sequences._offer(base, "toy", edited, 0, None)


def test_suggest_completes_a_pattern_and_generate_obeys_it(command: Any, copy: Path) -> None:
    first, *_, last = string_of(command, copy)
    asked = ("fight", "--like", f"{first} ... {last}", "--db", copy)
    facts = answer(command("grammar", "suggest", *asked, "--json"))
    strings = [one["string"] for one in facts["sentences"]]
    assert all((s[0], s[-1]) == (first, last) for s in strings)
    said = command("grammar", "suggest", *asked)
    assert " ".join(strings[0]) in said.out
    assert "of the sentences of fight match" in said.out
    made = answer(command("grammar", "generate", *asked, "-o", "made.bvh", "--json"))
    assert (made["string"][0], made["string"][-1]) == (first, last)
    ended = command("grammar", "generate", *asked, "-o", "made.bvh", "--length", 3)
    assert (ended.code, "expected none with a pattern, found 3" in ended.err) == (2, True)
