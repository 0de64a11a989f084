"""Grammars on sample takes, the whole way: learn, show, parse, suggest, generate, edit, remove."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dances import QUICK, SETTINGS, TAKES

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from motiondb.database.grammars import grammar_learning, grammar_sequences
from motiondb.database.grammars.grammar_learning import GrammarSettings
from motiondb.errors import MotionDBError, QueryError
from motiondb.grammar.cfg.context_free import derive_by
from motiondb.grammar.cfg.parse import accepts
from motiondb.grammar.derivation.edit import region_at
from motiondb.grammar.sentences.doubtful import Doubtful
from motiondb.records import MOTION_FPS


def test_a_learned_grammar_is_whole_and_gives_its_strings_back(asked_dances: MotionDB) -> None:
    learned = asked_dances.grammars.load("dance")
    terminals = learned.terminals
    assert len(terminals.names) == 8
    assert set(terminals.labels.tolist()) == set(range(8))
    assert [source.name for source in learned.sources] == list(TAKES)
    derived = [derive_by(learned.grammar, rules).leaves() for rules in learned.parses]
    assert tuple(derived) == learned.strings
    whole = tuple(terminal for string in learned.strings for terminal in string)
    assert whole == learned.string(0, len(terminals.takes))
    assert asked_dances.check() == []
    run = next(r for r in store.load_runs(asked_dances.store) if r.run_id == learned.run_id)
    assert (run.kind, run.seed) == ("grammar", 1)
    assert run.parameters["captures"] == list(TAKES)
    assert run.finished is not None


def test_same_seed_learns_the_same(dances: MotionDB) -> None:
    before = dances.grammars.load("dance")
    again, _ = dances.grammars.learn(TAKES, "again", SETTINGS)
    assert again.grammar == before.grammar
    assert again.parses == before.parses
    np.testing.assert_array_equal(again.terminals.ends, before.terminals.ends)
    np.testing.assert_array_equal(again.terminals.labels, before.terminals.labels)
    assert dances.grammars.names() == ["again", "dance", "nested"]


def test_a_take_never_seen_is_read_and_parsed_or_its_fault_told(
    asked_dances: MotionDB, samples_folder: Path
) -> None:
    by_name = asked_dances.grammars.parse("dance", "fatou/dance_1")
    by_file = asked_dances.grammars.parse("dance", samples_folder / "fatou" / "dance_1.bvh")
    for actual in (by_name, by_file):
        assert not actual.stored
        assert actual.string == by_name.string
        assert set(actual.string) <= set(asked_dances.grammars.load("dance").terminals.names)
        assert actual.ends[:-1] == actual.starts[1:]
        assert bool(actual.trees) != bool(actual.fault)
        if actual.fault is not None:
            found = actual.string[actual.fault.position : actual.fault.position + 1]
            assert found in ((actual.fault.symbol,), ())


def test_a_file_with_the_bytes_of_a_learned_take_is_that_take(
    dances: MotionDB, samples_folder: Path
) -> None:
    file = samples_folder / "dora" / "long_dance_1.bvh"
    parsed = dances.grammars.parse("dance", file)
    assert parsed.stored
    assert parsed.string == dances.grammars.parse("dance", "dora/long_dance_1").string
    assert (parsed.distances, parsed.reach, parsed.unlike) == ((), None, ())
    dances.remove(["dora/long_dance_1"])
    assert dances.grammars.parse("dance", file).string == parsed.string


def test_what_is_unlike_anything_learned_is_told(
    asked_dances: MotionDB, samples_folder: Path
) -> None:
    parsed = asked_dances.grammars.parse("dance", asked_dances.motion("ana/long_dance_2"))
    assert parsed.reach is not None
    assert len(parsed.distances) == len(parsed.string)
    assert parsed.share_unlike < 0.5
    assert not parsed.is_unlike
    kick = asked_dances.grammars.parse("dance", samples_folder / "boris" / "kick_1.bvh")
    assert kick.is_unlike
    far = [n for n, distance in enumerate(kick.distances) if distance > parsed.reach]
    assert list(kick.unlike) == far
    spent = sum(kick.ends[n] - kick.starts[n] for n in far)
    assert kick.share_unlike == pytest.approx(spent / kick.ends[-1])
    assert kick.reach == parsed.reach


def test_generated_sequences_obey_the_grammar_and_know_their_frames(asked_dances: MotionDB) -> None:
    learned = asked_dances.grammars.load("dance")
    for seed in range(3):
        made = asked_dances.grammars.generate("dance", seed, length=9)
        assert accepts(learned.grammar, made.string)
        assert made.made.slip <= made.made.source_slip
        assert len(made.provenance.source_numbers) == made.motion.n_frames
        assert set(made.provenance.licences) == {"CC0-1.0"}
        again = asked_dances.grammars.generate("dance", seed, length=9)
        assert again.motion.local_rotations.tobytes() == made.motion.local_rotations.tobytes()
        assert again.motion.root_positions.tobytes() == made.motion.root_positions.tobytes()


def test_what_is_generated_is_new_or_told_to_be_known(asked_dances: MotionDB) -> None:
    for name, derives_new in (("nested", True), ("dance", False)):
        assert asked_dances.grammars.show(name).derives_new == derives_new
        made = asked_dances.grammars.generate(name, 0)
        facts, stretches = asked_dances.grammars.facts(made), made.made.stretches
        assert (made.string in asked_dances.grammars.load(name).strings) == (not derives_new)
        assert facts.new_sentences == derives_new
        assert sum(stretches) == made.motion.n_frames
        assert facts.longest_stretch == round(max(stretches) / MOTION_FPS, 3)
        assert facts.changes == len(stretches) - 1 > 0  # no replay, though known


def test_a_kept_sequence_is_a_capture_that_can_be_edited(dances: MotionDB, tmp_path: Path) -> None:
    made = dances.grammars.generate("nested", 4)
    info = dances.grammars.save("new/dance", made, 4)
    assert info.kind == "generated"
    assert store.load_derivation(dances.store, info.capture_id) is not None
    assert dances.check() == []
    assert dances.export("new/dance", tmp_path / "a.bvh").output.stat().st_size > 1000
    facts = dances.show("new/dance")
    assert (facts.grammar, facts.string) == ("nested", " ".join(made.string))
    at = len(made.tree.children[0].children)  # the first position of the middle part, C
    edited = dances.grammars.edit("nested", "new/dance", at, n=3, seed=2)
    assert edited.before == made.tree
    assert edited.region == region_at(made.tree, at)
    assert (edited.region.symbol, edited.region.path) == ("C", (1, 0))
    assert edited.clips == made.choice.clips
    (alternative,) = edited.alternatives
    start, end = edited.region.start, edited.region.end
    assert 0 < start < end < len(made.string)
    new = dances.grammars.play("nested", edited, 0)
    assert accepts(dances.grammars.load("nested").grammar, new.string)
    assert new.string == made.string[:start] + alternative.string + made.string[end:]
    assert new.choice.clips[:start] == made.choice.clips[:start]
    assert new.choice.clips[start + len(alternative.string) :] == made.choice.clips[end:]
    dances.grammars.save("new/edited", new, 2, {"edited": "new/dance", "at": at})
    twice = dances.grammars.edit("nested", "new/edited", 0)
    assert twice.before == new.tree
    assert dances.check() == []
    gone = {
        int(dances.grammars.load("nested").terminals.takes[c]) for c in edited.pinned(0).values()
    }
    dances.remove(
        [TAKES[min(gone)]]
    )  # what lies outside the region is never played by something else
    with pytest.raises(QueryError, match=f"found {TAKES[min(gone)]} removed. Add them again"):
        dances.grammars.play("nested", edited, 0)


def test_a_region_grows_to_the_whole_sentence_and_shrinks_again(asked_dances: MotionDB) -> None:
    string = asked_dances.grammars.load("nested").strings[0]
    at = len(string) - 1
    first = asked_dances.grammars.edit("nested", string, at)
    assert (first.region.symbol, first.region.end - first.region.start) == ("D", 3)
    wider = asked_dances.grammars.edit("nested", string, at, (1, 0))
    assert (wider.region.symbol, wider.region.end) == ("B", len(string))
    whole = asked_dances.grammars.edit("nested", string, at, (2, 0))
    assert (whole.region.symbol, whole.region.start, whole.region.end) == ("S", 0, len(string))
    assert asked_dances.grammars.edit("nested", string, at, (2, 1)).region == wider.region
    assert asked_dances.grammars.edit("nested", string, at, (2, 2)).region == first.region
    assert first.clips == ()  # a string has no clips yet
    with pytest.raises(MotionDBError, match="levels up from"):
        asked_dances.grammars.edit("nested", string, at, (3, 0))


def test_replacing_or_removing_a_grammar_says_what_cannot_be_edited_any_more(
    dances: MotionDB,
) -> None:
    dances.grammars.save("new/dance", dances.grammars.generate("dance", 4), 4)
    _, lost = dances.grammars.learn(TAKES, "dance", SETTINGS)
    assert lost == ["new/dance"]
    with pytest.raises(QueryError, match="expected a capture that a grammar derived"):
        dances.grammars.edit("dance", "new/dance", 0)
    first = dances.grammars.generate("dance", 4).string
    drawn = (dances.grammars.generate("dance", seed) for seed in range(5, 50))
    dances.grammars.save("new/other", next(s for s in drawn if s.string != first), 5)
    assert dances.grammars.remove("dance") == ["new/other"]
    assert dances.grammars.names() == ["nested"]
    assert [i.name for i in dances.captures("kind=generated")] == ["new/dance", "new/other"]
    assert dances.check() == []


def test_a_grammar_outlives_its_captures(dances: MotionDB) -> None:
    assert dances.grammars.material("dance").missing == ()
    dances.remove(["dora/long_dance_1"])
    assert dances.grammars.material("dance").missing == ("dora/long_dance_1",)
    assert [c.there for c in dances.grammars.show("dance").captures] == [True, False]
    material = dances.grammars.material("dance")
    learned = material.learned
    here = set(learned.terminals.labels[learned.terminals.takes == 0].tolist())
    for string, rules in zip(learned.strings, learned.parses):
        tree = derive_by(learned.grammar, rules)
        if {learned.terminals.names.index(terminal) for terminal in string} <= here:
            made = grammar_sequences.play(material, tree)
            assert {s.name for s in made.provenance.sources} == {"ana/long_dance_2"}
        else:
            with pytest.raises(QueryError, match="found all of them removed"):
                grammar_sequences.play(material, tree)
    assert dances.check() == []
    dances.remove(["ana/long_dance_2"])
    with pytest.raises(QueryError, match="expected captures of the grammar, found none left"):
        dances.grammars.generate("dance", 1)
    assert dances.grammars.suggest("dance", "")


def test_sentences_may_be_captures_or_begin_where_timed_words_do(dances: MotionDB) -> None:
    whole, _ = dances.grammars.learn(
        TAKES, "whole", GrammarSettings(8, search=QUICK, sentences="captures")
    )
    assert len(whole.sentences) == 2
    timed, _ = dances.grammars.learn(
        TAKES, "timed", GrammarSettings(8, search=QUICK, sentences="captions")
    )
    assert len(timed.sentences) > 10
    assert dances.check() == []


def test_motion_symbols_may_be_terminals(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        settings = GrammarSettings(None, from_symbols=True, sentences="captures")
        learned, _ = db.grammars.learn(["goran/long_fight_2"], "fight", settings)
        table = db.learned.segments
        number = next(i.capture_id for i in db.captures() if i.name == "goran/long_fight_2")
        symbols = table.symbols[table.capture_ids == number]
        assert learned.strings == (tuple(f"s{s}" for s in symbols),)
        assert learned.symbols.tolist() == sorted(set(symbols.tolist()))
        facts = motiondb.to_json(db.grammars.show("fight"))
        for terminal in facts["terminals"]:
            symbol, share = terminal["symbols"][0].values()
            assert (f"s{symbol}", share) == (terminal["terminal"], 1.0)
        said = {t["terminal"]: [w["word"] for w in t["words"]] for t in facts["terminals"]}
        assert any("kick" in words for words in said.values())
        db.grammars.save("new/fight", db.grammars.generate("fight", 1), 1)
        assert db.like("new/fight", limit=1)[0].capture == "new/fight"
        assert db.check() == []


def test_files_and_pictures(asked_dances: MotionDB, tmp_path: Path) -> None:
    made = asked_dances.grammars.generate("dance", 3)
    facts = asked_dances.grammars.write(made, tmp_path / "new.bvh", 3)
    written: dict[str, Any] = json.loads((tmp_path / "new.bvh.provenance.json").read_text())
    assert written["string"] == list(facts.string) == list(made.string)
    assert written["frames"][0]["start"] == 0
    assert written["frames"][-1]["end"] == made.motion.n_frames
    edited = asked_dances.grammars.edit("dance", made, 0)
    parsed = asked_dances.grammars.parse("dance", TAKES[0])
    for name, draw in {
        "trees": lambda path: asked_dances.grammars.draw_trees("dance", path),
        "strings": lambda path: asked_dances.grammars.draw_strings("dance", path),
        "parse": lambda path: asked_dances.grammars.draw_parse("dance", parsed, path),
        "edit": lambda path: asked_dances.grammars.draw_edit("dance", edited, path),
        "sequence": lambda path: asked_dances.grammars.draw_sequence(made, path),
    }.items():
        assert draw(tmp_path / f"{name}.png").stat().st_size > 1000


def test_sizes_are_those_of_what_is_shown(asked_dances: MotionDB) -> None:
    sizes = asked_dances.grammars.sizes()
    assert [size.name for size in sizes] == ["dance", "nested"]
    for size in sizes:
        facts = motiondb.to_json(asked_dances.grammars.show(size.name))
        assert (size.run_id, size.captures) == (facts["run"], len(facts["captures"]))
        assert size.seconds == pytest.approx(sum(c["seconds"] for c in facts["captures"]), abs=0.01)
        for key in ("frames", "segments", "sentences", "nonterminals", "rules"):
            assert getattr(size, key) == facts[key], key
        assert size.terminals == len(facts["terminals"])
        assert size.bits | {"sum": sum(size.bits.values())} == facts["bits"]


def test_sentences_left_out_as_errors_are_told_and_the_grammar_stays_whole(
    dances: MotionDB, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = dances.grammars.load("dance")
    odd = [Doubtful(1, 0, "a", "b", ("b",))]
    monkeypatch.setattr(
        grammar_learning, "find_doubtful", lambda _grammar, _sentences, _parses: odd
    )
    settings = dataclasses.replace(SETTINGS, without_errors=True)
    learned, _ = dances.grammars.learn(TAKES, "rest", settings)
    assert learned.strings == before.strings[:1] + before.strings[2:]
    assert dances.check() == []
    (gap,) = dances.grammars.show("rest").left_out
    first, end = before.sentences[1].tolist()
    assert gap.capture == TAKES[int(before.terminals.takes[first])]
    assert gap.start == round(before.terminals.starts[first] / MOTION_FPS, 3)
    assert gap.end == round(before.terminals.ends[end - 1] / MOTION_FPS, 3)
    assert dances.grammars.show("dance").left_out == ()
    trees = [tree for take in TAKES for tree in dances.grammars.parse("rest", take).trees]
    assert tuple(tree.leaves() for tree in trees) == learned.strings
