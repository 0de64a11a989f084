"""Learning with a start: a database without captions answers, own words win as captions come."""

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
from motiondb.database import MotionDB
from motiondb.database.learn import start
from motiondb.errors import KnowledgeError, NotLearnedError, QueryError
from motiondb.learn.checking import NO_EXAMPLES_CHECKED
from motiondb.learn.joining import start_weight
from motiondb.learn.learned_model import from_stored, to_stored
from motiondb.meaning.regression import Certainties, Certainty
from motiondb.search.asking import understand_learned
from motiondb.search.by_example import search_motion
from motiondb.search.by_words import search_words
from motiondb.search.described import describe

NAMES = (
    "ana/walk_1", "ana/jump_1", "ana/bow_1", "boris/kick_1", "boris/punch_1", "boris/walk_1",
    "chidi/walk_1", "fatou/kick_1",
)  # fmt: skip


@pytest.fixture(scope="module")
def handed_on(learned_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the sample database learned, as a file."""
    path = tmp_path_factory.mktemp("knowledge") / "samples.knowledge"
    with motiondb.open(learned_file, read_only=True) as db:
        db.symbols.export_knowledge(path, credit="Made by a program.")
    return path


@pytest.fixture(scope="module")
def bare_file(samples_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight captures that nobody wrote about."""
    folder = tmp_path_factory.mktemp("bare")
    for name in NAMES:
        target = folder / "captures" / f"{name}.bvh"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(samples_folder / f"{name}.bvh", target)
    with motiondb.open(folder / "bare.duckdb") as db:
        assert db.add(folder / "captures").problems == ()
    return folder / "bare.duckdb"


@pytest.fixture(scope="module")
def started_file(
    bare_file: Path, handed_on: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """The same, learned with the start."""
    path = shutil.copy(bare_file, tmp_path_factory.mktemp("started") / "started.duckdb")
    with motiondb.open(path) as db:
        db.learn(start=handed_on)
    return path


@pytest.fixture
def started(started_file: Path, tmp_path: Path) -> Iterator[MotionDB]:
    with motiondb.open(shutil.copy(started_file, tmp_path / "started.duckdb")) as db:
        yield db


@pytest.fixture
def bare(bare_file: Path, tmp_path: Path) -> Iterator[MotionDB]:
    with motiondb.open(shutil.copy(bare_file, tmp_path / "bare.duckdb")) as db:
        yield db


def test_no_caption_and_no_name_of_a_capture_stands_in_the_file(
    handed_on: Path, learned_file: Path
) -> None:
    header = handed_on.read_bytes().split(b"\n")[1].decode()
    with motiondb.open(learned_file, read_only=True) as db:
        texts = {
            c.words for rows in db.words.all_captions().values() for c in rows if " " in c.words
        }
        names = {info.name for info in db.captures()}
    assert texts
    assert not [text for text in texts | names if text in header]
    assert str(learned_file.parent) not in header


def test_without_a_caption_words_are_found_described_and_generated(started: MotionDB) -> None:
    answer = started.search("kick", limit=8)
    assert {m.capture for m in answer.matches[:2]} == {"boris/kick_1", "fatou/kick_1"}
    assert {m.probability for m in answer.matches} == {None}
    assert answer.unchecked == "no probabilities: no caption of this database has checked them"
    assert (answer.threshold, answer.matches_anything) == (None, None)
    assert {m.words for m in answer.matches} == {()}
    (source,) = answer.sources
    assert (source.word, source.start, source.own_captions) == ("kick", "samples", 0)
    assert source.start_captions > 0
    described = started.describe("ana/jump_1")
    assert "jump" in {word for d in described for word, _ in d.words[:2]}
    assert {p for d in described for _, p in d.words} == {None}
    assert started.like("ana/jump_1").unchecked == answer.unchecked
    assert {m.probability for m in started.like("ana/jump_1")} == {None}
    made = started.generate("a person walks", seed=1)
    assert made.motion.n_frames > 20
    assert [s.word for s in made.sources] == ["walk"]
    assert made.facts().words_from[0].start == "samples"


def test_probabilities_stand_beside_words_that_own_captions_hold(
    started: MotionDB, samples_folder: Path
) -> None:
    """Own captions checked the certainty of answers, but say nothing of some words of the start."""
    started.add(samples_folder / "goran" / "walk_1.bvh")
    started.set_words("walk_1", "walk")
    assert "at least 50 captions of this database, and it has 1" in started.search("walk").unchecked
    sure = Certainty(np.array([1.0]), 0.0, 0.0)
    learned = replace(started.learned, certainties=Certainties(words=sure))

    def ask(text: str) -> tuple[str, set[bool]]:
        every = search_words(understand_learned(learned, text), sorted(learned.rows))
        return every.unchecked, {m.probability is not None for m in every.matches}

    reason = "no probabilities: no caption of this database holds 'kick'"
    assert ask("walk") == ("", {True})
    assert ask("kick") == (reason, {False})
    assert ask("walk or kick") == (reason, {False})
    assert ask("walk then kick") == (reason, {False})
    assert ask("walk but not kick") == (reason, {False})
    example = started.motion("ana/walk_1")
    alike = search_motion(learned, started.session.frames, example, sorted(learned.rows))
    assert {m.probability for m in alike} == {None}
    assert alike.unchecked == NO_EXAMPLES_CHECKED  # the words' certainty says nothing of examples
    said = [pair for d in describe(learned, started.motion("ana/walk_1")) for pair in d.words]
    assert {word for word, p in said if p is not None} == {"walk"}


def test_a_caption_alone_tells_no_place_without_checked_probabilities(started: MotionDB) -> None:
    name = max(started.learned.captures.values(), key=lambda info: info.duration).name
    started.set_words(name, "a person bows")
    bow = [m for m in started.search("bow", limit=20).matches if m.capture == name]
    assert [(m.probability, m.place) for m in bow] == [(None, "unknown")]


def test_what_was_learned_with_a_start_comes_back_from_the_store(
    bare: MotionDB, handed_on: Path
) -> None:
    model = bare.learn(start=handed_on)
    for other in (from_stored(to_stored(model)), bare.learned):
        assert other.started is not None
        assert other.started.names == model.started.names
        assert other.started.knowledge.origin == model.started.knowledge.origin
        np.testing.assert_array_equal(other.transition_counts, model.transition_counts)
        np.testing.assert_array_equal(
            other.counted.counts.transitions,
            model.counted.counts.transitions,
        )
        assert other.counted.counts.said.sum() == 0


def test_captions_that_come_later_count_at_once_and_leave_no_trace(
    started: MotionDB, samples_folder: Path
) -> None:
    before = started.learned
    started.add(samples_folder / "goran" / "walk_1.bvh")
    started.set_words("walk_1", "walk")
    (source,) = started.word_sources(["walk"])
    assert (source.own_captions, source.weight) == (1, pytest.approx(start_weight(1)))
    changed = started.learned
    assert np.abs(changed.word_map.weights - before.word_map.weights).max() > 0.0
    started.remove(["walk_1"])
    after = started.learned
    np.testing.assert_array_equal(after.word_map.weights, before.word_map.weights)
    np.testing.assert_array_equal(after.association.translation, before.association.translation)
    np.testing.assert_array_equal(after.transition_counts, before.transition_counts)
    assert after.lengths == before.lengths


def test_own_words_join_the_vocabulary(bare: MotionDB, handed_on: Path) -> None:
    for name in NAMES:
        bare.set_words(name, f"zigzag {Path(name).name[:-2]}")
    bare.learn(start=handed_on)
    facts = bare.info().start
    assert facts.own_captions == 8
    assert facts.words_of_own_captions_alone == 1
    assert facts.weight == pytest.approx(start_weight(8), abs=1e-4)
    assert bare.search("zigzag").matches
    sources = {s.word: s for s in bare.word_sources(["zigzag", "kick", "sit"])}
    assert sources["zigzag"].start_captions == 0
    assert sources["kick"].own_captions == 2
    assert sources["sit"].own_captions == 0
    assert sources["sit"].weight == 1.0


def test_a_start_is_told_without_motions_and_scores(
    started: MotionDB, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lost(*_: object) -> None:
        raise motiondb.StoreError("the folder is away")

    told = started.info()
    monkeypatch.setattr(store, "load_scores", lost)
    monkeypatch.setattr(store, "cached_rows", lost)
    assert started.info() == told
    assert told.start is not None


def test_learning_again_keeps_the_start_and_none_drops_it(started: MotionDB) -> None:
    handed = started.start_facts()
    started.learn()
    assert started.start_facts() == handed
    assert started.runs()[-1]["parameters"]["start"]["sha256"] == handed.sha256
    started.learn(motiondb.LearnSettings(n_symbols=3), start="none")
    assert started.start_facts() is None
    with pytest.raises(NotLearnedError, match="captures with words"):
        started.search("walk")


def test_the_shipped_start_is_sound_and_holds_lemmas_alone() -> None:
    assert start.shipped_names() == ["cmu"]
    knowledge = start.load_knowledge("cmu")
    assert "mocap.cs.cmu.edu" in knowledge.origin.credit
    assert knowledge.origin.licences == {"CMU": knowledge.origin.captures}
    assert {"walk", "run", "jump"} <= set(knowledge.taught.words)
    assert "person" not in knowledge.taught.words
    (facts,) = motiondb.shipped_starts()
    assert facts["words"] == len(knowledge.words)
    assert facts["captions"] == knowledge.origin.captions


def test_the_shipped_start_finds_kicks_among_captures_that_a_program_made(bare: MotionDB) -> None:
    bare.learn(start="cmu")
    assert bare.search("walk", limit=1).matches[0].capture.endswith("walk_1")
    assert bare.info().start.name == "cmu"


def test_events_in_words_of_the_start_are_looked_for_in_the_motion(started: MotionDB) -> None:
    """Words that were learned from others' motion rank the captures; flights and kicks decide."""
    for word, shown in (
        ("kick", {"boris/kick_1", "fatou/kick_1"}),
        ("jump", {"ana/jump_1"}),
        ("sit down", set[str]()),
    ):
        matches = started.search(word, limit=8).matches
        free = {match.capture for match in matches if not match.contradicted}
        assert free == shown
        assert {match.contradicted for match in matches[len(shown) :]} == {(f"does not {word}",)}
    started.words.set("ana/walk_1", "jump on the spot")
    own = next(m for m in started.search("jump", limit=8).matches if m.capture == "ana/walk_1")
    assert not own.contradicted  # the word is one's own now


def test_what_cannot_be_started_from_is_refused(
    bare: MotionDB, started: MotionDB, handed_on: Path, tmp_path: Path
) -> None:
    with pytest.raises(KnowledgeError, match=r"found neither\. Did you mean cmu\?"):
        bare.learn(start="cmuu")
    with pytest.raises(QueryError, match="a number of symbols or the start 'samples', found both"):
        bare.learn(motiondb.LearnSettings(n_symbols=5), start=handed_on)
    (tmp_path / "broken").write_bytes(handed_on.read_bytes()[:5000])
    with pytest.raises(KnowledgeError, match="get it again"):
        bare.learn(start=tmp_path / "broken")
    assert not bare.is_learned()
    with pytest.raises(NotLearnedError):
        bare.export_knowledge(tmp_path / "mine")
    with pytest.raises(KnowledgeError, match="found one that started from 'samples'"):
        started.export_knowledge(tmp_path / "mine")
    assert not (tmp_path / "mine").exists()


def test_commands_offer_start_and_say_what_comes_from_it(
    command: Any, bare_file: Path, learned_file: Path, tmp_path: Path
) -> None:
    db, captures = tmp_path / "own.duckdb", bare_file.parent / "captures"
    added = command("add", captures, "--db", db)
    assert "no captions were added: motiondb learn --start cmu provides" in added.out
    written = command("knowledge", "export", "k.knowledge", "--db", learned_file)
    assert "Start from it: motiondb learn --start k.knowledge" in written.out
    shown = command("knowledge", "show", "k.knowledge")
    assert shown.out.startswith("k: ")
    learned = command("learn", "--start", "k.knowledge", "--db", db)
    assert "Started from k: " in learned.out
    assert "No own captions: all words are those of the start." in learned.out
    reason = "no probabilities: no caption of this database has checked them"
    assert f"Answers carry {reason}." in learned.out
    ended = command("search", "walk", "--db", db)
    assert "known from the start k alone (captions there): walk (" in ended.err
    assert f"note: {reason}" in ended.err
    explained = command("search", "walk", "--explain", "--db", db)
    assert "walk: known from the start k alone (" in explained.out
    like = command("like", "ana/walk_1", "--db", db)
    assert f"note: {reason}" in like.err
    answers = [line.split() for line in like.out.splitlines() if line.strip()[:1].isdigit()]
    assert {row[5] for row in answers} == {"-"}
    said = command("describe", "ana/walk_1", "--db", db)
    assert said.err.count(reason) == 1
    facts = json.loads(command("search", "walk", "--json", "--db", db).out)
    assert (facts["sources"][0]["start"], facts["unchecked"]) == ("k", reason)
    assert "Started from k: " in command("info", "--db", db).out
    assert command("knowledge", "show", "--db", db).out == shown.out
    none = command("knowledge", "show", "--db", learned_file)
    assert (none.code, "learned from its own captures only" in none.err) == (2, True)
    assert "learn --start" not in command("add", captures, "--db", db).out
    wrong = command("learn", "--start", "nothing", "--db", db)
    assert "expected a file of knowledge or one of cmu, none" in wrong.err


def test_a_start_that_does_not_fit_is_told_and_set_aside(
    bare: MotionDB, handed_on: Path, monkeypatch: pytest.MonkeyPatch, command: Any
) -> None:
    monkeypatch.setattr("motiondb.learn.joining.STRANGE", -1.0)
    monkeypatch.setattr("motiondb.learn.joining.ENOUGH", 2)
    path = str(bare.store.path)
    bare.close()
    told = command("learn", "--start", handed_on, "--db", path)
    assert "% of the motion is unlike anything that the symbols of the start model" in told.out
    for name in NAMES[:2]:
        command("words", "set", name, "zigzag", "--db", path)
    aside = command("learn", "--start", handed_on, "--db", path)
    assert aside.code == 0
    assert "is not used: its symbols do not fit these captures" in aside.out
    with motiondb.open(path, read_only=True) as db:
        assert db.symbols.start_facts() is None
        assert db.words.vocabulary() == ("zigzag",)


def test_with_a_start_words_are_told_by_the_joint_word_map(started_file: Path) -> None:
    """A start keeps no sums for captions as wholes, nor pooled statistics."""
    with motiondb.open(started_file, read_only=True) as db:
        assert (db.learned.pooled, db.learned.description_calibration) == (None, None)
        assert db.describe("ana/bow_1")[0].words


def test_knowledge_names_its_origin(handed_on: Path) -> None:
    origin = start.load_knowledge(handed_on).origin
    assert (origin.name, origin.captures, origin.credit) == ("samples", 101, "Made by a program.")
    assert origin.runs[0]["kind"] == "learn"
    assert sum(origin.licences.values()) == 101
