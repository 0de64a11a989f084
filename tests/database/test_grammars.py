"""Grammars on sample takes, the whole way: learn, show, parse, suggest, generate, edit, remove."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.database import MotionDB, grammar_facts, grammar_sequences
from motiondb.database.grammar_learning import GrammarSettings
from motiondb.database.showing import describe_capture
from motiondb.errors import MotionDBError, NotLearnedError, QueryError
from motiondb.grammar import cfg
from motiondb.grammar.cfg import derive_by, read_grammar
from motiondb.grammar.edit import region_at
from motiondb.grammar.parse import ParseError, accepts
from motiondb.grammar.terminals import TerminalSettings

TAKES = ("ana/long_dance_2", "dora/long_dance_1")
QUICK = TerminalSettings(n_starts=1, n_trials=150)
SETTINGS = GrammarSettings(n_terminals=8, seed=1, search=QUICK, evaluations=300)


@pytest.fixture(scope="module")
def learned_dance(tmp_path_factory: pytest.TempPathFactory, samples_folder: Path) -> Path:
    """Two dances and a third capture, and the grammar of the dances."""
    folder = tmp_path_factory.mktemp("dances")
    for name in (*TAKES, "fatou/dance_1"):
        target = folder / "captures" / f"{name}.bvh"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(samples_folder / f"{name}.bvh", target)
    sheet = folder / "words.tsv"
    rows = (samples_folder.parent / "captions.tsv").read_text().splitlines()
    own = [row for row in rows if row.startswith(("file", *TAKES))]
    sheet.write_text("\n".join(own) + "\n")
    path = folder / "motions.duckdb"
    with motiondb.open(path) as db:
        db.add(folder / "captures", words=sheet)
        db.grammars.learn(TAKES, "dance", SETTINGS)
        keep_nested_grammar(db)
    return path


@pytest.fixture
def db(tmp_path: Path, learned_dance: Path) -> Iterator[MotionDB]:
    path = shutil.copy(learned_dance, tmp_path / "motions.duckdb")
    with motiondb.open(path) as opened:
        yield opened


def keep_nested_grammar(db: MotionDB) -> None:
    """The grammar "nested": each take of "dance" one sentence of three parts, to be exchanged."""
    learned = db.grammars.load("dance")
    edges = [np.flatnonzero(learned.terminals.takes == take)[[0, -1]] + [0, 1] for take in (0, 1)]
    strings = [learned.string(int(first), int(end)) for first, end in edges]
    thirds = [(s[: 6 + n], s[6 + n : -3 - n], s[-3 - n :]) for n, s in enumerate(strings)]
    rules = [cfg.Rule("S", ("A", "B")), cfg.Rule("B", ("C", "D"))]
    rules += [cfg.Rule(left, t[k], 0.5) for k, left in enumerate("ACD") for t in thirds]
    nested = replace(
        learned,
        name="nested",
        grammar=cfg.Grammar("S", tuple(rules), learned.terminals.names),
        sentences=np.array(edges),
        parses=tuple((0, 2 + take, 1, 4 + take, 6 + take) for take in (0, 1)),
    )
    with store.transaction(db.store):
        run_id = store.start_run(db.store, "grammar", {"name": "nested"})
        store.save_grammar(db.store, nested, run_id)
        store.finish_run(db.store, run_id)


@pytest.fixture(scope="module")
def asked(learned_dance: Path) -> Iterator[MotionDB]:
    with motiondb.open(learned_dance, read_only=True) as opened:
        yield opened


def test_a_learned_grammar_is_whole_and_gives_its_strings_back(asked: MotionDB) -> None:
    learned = asked.grammars.load("dance")
    terminals = learned.terminals
    assert len(terminals.names) == 8
    assert set(terminals.labels.tolist()) == set(range(8))
    assert [source.name for source in learned.sources] == list(TAKES)
    derived = [derive_by(learned.grammar, rules).leaves() for rules in learned.parses]
    assert tuple(derived) == learned.strings
    whole = tuple(terminal for string in learned.strings for terminal in string)
    assert whole == learned.string(0, len(terminals.takes))
    assert asked.check() == []
    run = next(r for r in store.load_runs(asked.store) if r.run_id == learned.run_id)
    assert (run.kind, run.seed) == ("grammar", 1)
    assert run.parameters["captures"] == list(TAKES)
    assert run.finished is not None


def test_same_seed_learns_the_same(db: MotionDB) -> None:
    before = db.grammars.load("dance")
    again, _ = db.grammars.learn(TAKES, "again", SETTINGS)
    assert again.grammar == before.grammar
    assert again.parses == before.parses
    np.testing.assert_array_equal(again.terminals.ends, before.terminals.ends)
    np.testing.assert_array_equal(again.terminals.labels, before.terminals.labels)
    assert db.grammars.names() == ["again", "dance", "nested"]


def test_show_tells_terminals_rules_and_bits(asked: MotionDB) -> None:
    facts = asked.grammars.show("dance")
    json.dumps(facts)
    assert sum(t["count"] for t in facts["terminals"]) == facts["segments"]
    assert facts["bits"]["sum"] == pytest.approx(
        sum(bits for part, bits in facts["bits"].items() if part != "sum")
    )
    assert read_grammar(facts["text"]).nonterminals[0] == "S"
    assert facts["rules"] == len(asked.grammars.load("dance").grammar.rules)
    assert all(capture["there"] for capture in facts["captures"])
    assert all(t["words"] == [] for t in facts["terminals"])  # the database has not learned


def test_a_learned_take_parses_as_stored(asked: MotionDB) -> None:
    found = asked.grammars.parse("dance", "dora/long_dance_1")
    assert found.stored
    assert found.fault is None
    derived = tuple(terminal for tree in found.trees for terminal in tree.leaves())
    assert derived == found.string
    assert found.ends[-1] == pytest.approx(772 / 30)


def test_a_take_never_seen_is_read_and_parsed_or_its_fault_told(
    asked: MotionDB, samples_folder: Path
) -> None:
    by_name = asked.grammars.parse("dance", "fatou/dance_1")
    by_file = asked.grammars.parse("dance", samples_folder / "fatou" / "dance_1.bvh")
    for found in (by_name, by_file):
        assert not found.stored
        assert found.string == by_name.string
        assert set(found.string) <= set(asked.grammars.load("dance").terminals.names)
        assert found.ends[:-1] == found.starts[1:]
        assert bool(found.trees) != bool(found.fault)
        if found.fault is not None:
            assert found.string[found.fault.position : found.fault.position + 1] in (
                (found.fault.found,),
                (),
            )


def test_suggestions_sum_to_one_and_lead_into_the_language(asked: MotionDB) -> None:
    grammar = asked.grammars.load("dance").grammar
    string: list[str] = []
    while True:
        found = asked.grammars.suggest("dance", string)
        assert sum(p for _, p in found) == pytest.approx(1.0)
        following = found[0][0]
        if following is None or len(string) > 60:
            break
        string.append(following)
    assert accepts(grammar, string)
    assert asked.grammars.suggest("dance", " ".join(string)) == found


def test_generated_sequences_obey_the_grammar_and_know_their_frames(asked: MotionDB) -> None:
    learned = asked.grammars.load("dance")
    for seed in range(3):
        made = asked.grammars.generate("dance", seed, length=9)
        assert accepts(learned.grammar, made.string)
        assert made.choice.cost <= made.greedy + 1e-9
        assert made.made.slip <= made.made.source_slip
        assert len(made.provenance.source_numbers) == made.motion.n_frames
        assert set(made.provenance.licences) == {"CC0-1.0"}
        again = asked.grammars.generate("dance", seed, length=9)
        assert again.motion.local_rotations.tobytes() == made.motion.local_rotations.tobytes()
        assert again.motion.root_positions.tobytes() == made.motion.root_positions.tobytes()


def test_a_kept_sequence_is_a_capture_that_can_be_edited(db: MotionDB, tmp_path: Path) -> None:
    made = db.grammars.generate("nested", 4)
    info = db.grammars.save("new/dance", made, 4)
    assert info.kind == "generated"
    assert store.load_derivation(db.store, info.capture_id) is not None
    assert db.check() == []
    assert db.export("new/dance", tmp_path / "a.bvh").stat().st_size > 1000
    facts = describe_capture(db, "new/dance")
    assert (facts["grammar"], facts["string"]) == ("nested", " ".join(made.string))
    at = len(made.tree.children[0].children)  # the first position of the middle part, C
    edited = db.grammars.edit("nested", "new/dance", at, n=3, seed=2)
    assert edited.before == made.tree
    assert edited.region == region_at(made.tree, at)
    assert (edited.region.symbol, edited.region.path) == ("C", (1, 0))
    assert edited.clips == made.choice.clips
    (alternative,) = edited.alternatives
    start, end = edited.region.start, edited.region.end
    assert 0 < start < end < len(made.string)
    new = db.grammars.play("nested", edited, 0)
    assert accepts(db.grammars.load("nested").grammar, new.string)
    assert new.string == made.string[:start] + alternative.string + made.string[end:]
    assert new.choice.clips[:start] == made.choice.clips[:start]
    assert new.choice.clips[start + len(alternative.string) :] == made.choice.clips[end:]
    db.grammars.save("new/edited", new, 2, {"edited": "new/dance", "at": at})
    twice = db.grammars.edit("nested", "new/edited", 0)
    assert twice.before == new.tree
    assert db.check() == []
    gone = {int(db.grammars.load("nested").terminals.takes[c]) for c in edited.pinned(0).values()}
    db.remove([TAKES[min(gone)]])  # what lies outside the region is never played by something else
    with pytest.raises(QueryError, match=f"found {TAKES[min(gone)]} removed. Add them again"):
        db.grammars.play("nested", edited, 0)


def test_a_region_grows_to_the_whole_sentence_and_shrinks_again(asked: MotionDB) -> None:
    string = asked.grammars.load("nested").strings[0]
    at = len(string) - 1
    first = asked.grammars.edit("nested", string, at)
    assert (first.region.symbol, first.region.end - first.region.start) == ("D", 3)
    wider = asked.grammars.edit("nested", string, at, (1, 0))
    assert (wider.region.symbol, wider.region.end) == ("B", len(string))
    whole = asked.grammars.edit("nested", string, at, (2, 0))
    assert (whole.region.symbol, whole.region.start, whole.region.end) == ("S", 0, len(string))
    assert asked.grammars.edit("nested", string, at, (2, 1)).region == wider.region
    assert asked.grammars.edit("nested", string, at, (2, 2)).region == first.region
    assert first.clips == ()  # a string has no clips yet
    with pytest.raises(MotionDBError, match="levels up from"):
        asked.grammars.edit("nested", string, at, (3, 0))


def test_replacing_or_removing_a_grammar_says_what_cannot_be_edited_any_more(
    db: MotionDB,
) -> None:
    db.grammars.save("new/dance", db.grammars.generate("dance", 4), 4)
    _, lost = db.grammars.learn(TAKES, "dance", SETTINGS)
    assert lost == ["new/dance"]
    with pytest.raises(QueryError, match="expected a capture that a grammar derived"):
        db.grammars.edit("dance", "new/dance", 0)
    first = db.grammars.generate("dance", 4).string
    drawn = (db.grammars.generate("dance", seed) for seed in range(5, 50))
    db.grammars.save("new/other", next(s for s in drawn if s.string != first), 5)
    assert db.grammars.remove("dance") == ["new/other"]
    assert db.grammars.names() == ["nested"]
    assert [i.name for i in db.captures("kind=generated")] == ["new/dance", "new/other"]
    assert db.check() == []


def test_a_grammar_outlives_its_captures(db: MotionDB) -> None:
    assert db.grammars.material("dance").missing == ()
    db.remove(["dora/long_dance_1"])
    assert db.grammars.material("dance").missing == ("dora/long_dance_1",)
    assert [c["there"] for c in db.grammars.show("dance")["captures"]] == [True, False]
    material = db.grammars.material("dance")
    learned, rng = material.learned, np.random.default_rng(0)
    here = set(learned.terminals.labels[learned.terminals.takes == 0].tolist())
    for string, rules in zip(learned.strings, learned.parses):
        tree = derive_by(learned.grammar, rules)
        if {learned.terminals.names.index(terminal) for terminal in string} <= here:
            made = grammar_sequences.play(material, tree, rng)
            assert {s.name for s in made.provenance.sources} == {"ana/long_dance_2"}
        else:
            with pytest.raises(QueryError, match="found all of them removed"):
                grammar_sequences.play(material, tree, rng)
    assert db.check() == []
    db.remove(["ana/long_dance_2"])
    with pytest.raises(QueryError, match="expected captures of the grammar, found none left"):
        db.grammars.generate("dance", 1)
    assert db.grammars.suggest("dance", "")


def test_sentences_may_be_captures_or_begin_where_timed_words_do(db: MotionDB) -> None:
    whole, _ = db.grammars.learn(
        TAKES, "whole", GrammarSettings(8, search=QUICK, sentences="captures")
    )
    assert len(whole.sentences) == 2
    timed, _ = db.grammars.learn(
        TAKES, "timed", GrammarSettings(8, search=QUICK, sentences="captions")
    )
    assert len(timed.sentences) > 10
    assert db.check() == []


def test_motion_symbols_may_be_terminals(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        settings = GrammarSettings(None, from_symbols=True, sentences="captures")
        learned, _ = db.grammars.learn(["goran/long_fight_2"], "fight", settings)
        table = db.learned.segments
        number = next(i.capture_id for i in db.captures() if i.name == "goran/long_fight_2")
        own = table.symbols[table.capture_ids == number]
        assert learned.strings == (tuple(f"s{s}" for s in own),)
        assert learned.symbols.tolist() == sorted(set(own.tolist()))
        facts = db.grammars.show("fight")
        for terminal in facts["terminals"]:
            symbol, share = terminal["symbols"][0].values()
            assert (f"s{symbol}", share) == (terminal["terminal"], 1.0)
        said = {t["terminal"]: [w["word"] for w in t["words"]] for t in facts["terminals"]}
        assert any("kick" in words for words in said.values())
        db.grammars.save("new/fight", db.grammars.generate("fight", 1), 1)
        assert db.like("new/fight", limit=1)[0].capture == "new/fight"
        assert db.check() == []


def test_files_and_pictures(asked: MotionDB, tmp_path: Path) -> None:
    made = asked.grammars.generate("dance", 3)
    facts = grammar_facts.write_sequence(made, 3, tmp_path / "new.bvh")
    written: dict[str, Any] = json.loads((tmp_path / "new.provenance.json").read_text())
    assert written["string"] == facts["string"] == list(made.string)
    assert written["frames"][0]["start"] == 0
    assert written["frames"][-1]["end"] == made.motion.n_frames
    edited = asked.grammars.edit("dance", made, 0)
    found = asked.grammars.parse("dance", TAKES[0])
    for name, draw in {
        "trees": lambda path: asked.grammars.draw_trees("dance", path),
        "strings": lambda path: asked.grammars.draw_strings("dance", path),
        "parse": lambda path: asked.grammars.draw_parse("dance", found, path),
        "edit": lambda path: asked.grammars.draw_edit("dance", edited, path),
        "sequence": lambda path: asked.grammars.draw_sequence(made, path),
    }.items():
        assert draw(tmp_path / f"{name}.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("captures", "settings", "sentence"),
    [
        ([], SETTINGS, "captures: expected at least one to learn from, found none."),
        (["ana/long_dance_2"] * 2, SETTINGS, "expected every capture once, found it twice"),
        (["ana/long_dnce_2"], SETTINGS, "Did you mean"),
        (["ana/long_dance_2"], GrammarSettings(300, search=QUICK), "expected"),
        (
            ["ana/long_dance_2"],
            GrammarSettings(8, search=QUICK, sentences="all"),
            "expected one of auto",
        ),
        (
            ["fatou/dance_1"],
            GrammarSettings(2, search=QUICK, sentences="captions"),
            "with timed words",
        ),
        (
            ["ana/long_dance_2"],
            GrammarSettings(8, search=QUICK, shortest=9, longest=3),
            "shortest <= longest, found 9 and 3",
        ),
    ],
)
def test_what_cannot_be_learned_is_told_and_nothing_is_stored(
    db: MotionDB, captures: list[str], settings: GrammarSettings, sentence: str
) -> None:
    rows = store.count_rows(db.store)
    with pytest.raises(MotionDBError, match=sentence):
        db.grammars.learn(captures, "dance", settings)
    assert store.count_rows(db.store) == rows


def test_generated_captures_and_untaught_databases_are_refused(db: MotionDB) -> None:
    db.grammars.save("new/dance", db.grammars.generate("dance", 4), 4)
    with pytest.raises(QueryError, match="found a generated one"):
        db.grammars.learn(["new/dance"])
    with pytest.raises(NotLearnedError):
        db.grammars.learn(TAKES, "s", GrammarSettings(from_symbols=True))
    with pytest.raises(QueryError, match="expected a name of 1 to 80 letters"):
        db.grammars.learn(TAKES, " ")


def test_wrong_questions_are_told(db: MotionDB) -> None:
    for ask in (db.grammars.show, db.grammars.generate, db.grammars.remove):
        with pytest.raises(QueryError, match=r"'danec': .* Did you mean dance\?"):
            ask("danec")
    with pytest.raises(QueryError, match="'zz': expected terminals of the grammar"):
        db.grammars.suggest("dance", "a zz")
    with pytest.raises(QueryError, match="expected at least 1 terminal, found 0"):
        db.grammars.generate("dance", 1, 0)
    string = db.grammars.load("dance").strings[0]
    with pytest.raises(MotionDBError, match="position 99: expected 0 to"):
        db.grammars.edit("dance", string, 99)
    with pytest.raises(ParseError):
        db.grammars.edit("dance", (*string, *string, *string), 0)
    with pytest.raises(QueryError, match="expected a capture that a grammar derived"):
        db.grammars.edit("dance", TAKES[0], 0)
    edited = db.grammars.edit("dance", string, 0, n=2)
    with pytest.raises(QueryError, match="alternative 9: expected 1 to"):
        db.grammars.play("dance", edited, 8)
    rows = store.count_rows(db.store)
    with pytest.raises(QueryError, match="expected a name that is free"):
        db.grammars.save(TAKES[0], db.grammars.generate("dance", 1), 1)
    assert store.count_rows(db.store) == rows


def test_a_tree_on_a_line() -> None:
    toy = read_grammar("S -> a B c\nB -> b B | empty")
    assert grammar_facts.format_tree(derive_by(toy, (0, 1, 2))) == "S(a B(b B()) c)"
    deep = derive_by(read_grammar("S -> a S | a"), (0,) * 3000 + (1,))
    assert grammar_facts.format_tree(deep).count("S(a") == 3001


def test_the_number_of_terminals_may_be_the_data_s(db: MotionDB) -> None:
    settings = GrammarSettings(None, search=QUICK, evaluations=100)
    learned, _ = db.grammars.learn(["fatou/dance_1"], "short", settings)
    run = next(r for r in store.load_runs(db.store) if r.run_id == learned.run_id)
    tried = run.parameters["tried"]
    assert isinstance(tried, dict)
    chosen = str(len(learned.terminals.names))
    assert sum(learned.bits.values()) == pytest.approx(tried[chosen])
    enough = min(tried.values()) + run.parameters["noise"] / 2**0.5
    assert int(chosen) == min(int(number) for number, bits in tried.items() if bits <= enough)
    assert set(learned.bits) == {"motion", "sentences", "rules"}
