"""Verbs of the public class for everything that a command does."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import Motion, Scenes
from motiondb.answers.catalogue import EventRow
from motiondb.body import body

AMBIGUOUS = 'start S\nS -> S S | a\na := "walk"\n'


def test_pictures_of_answers_and_their_reasons(learned_file: Path, tmp_path: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("kick, not walk", limit=2)
        drawn = db.captures.draw_matches(answer, tmp_path / "hits.png", "kick")
        why = db.captures.draw_reasons(answer, tmp_path / "why.png", "kick")
        alike = db.like("goran/kick_1", limit=1)
        example = db.motion("goran/kick_1")
        db.captures.draw_matches(alike, tmp_path / "alike.png", example=example)
        with pytest.raises(motiondb.MotionDBError, match="expected at least 1 hit"):
            db.captures.draw_matches(db.search("kick", "performer=nobody"), tmp_path / "none.png")
        with pytest.raises(motiondb.QueryError, match="expected an answer with reasons"):
            db.captures.draw_reasons(
                db.search("kick", by_symbols=True), tmp_path / "none.png", "kick"
            )
    assert (drawn, why) == (tmp_path / "hits.png", tmp_path / "why.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["alike.png", "hits.png", "why.png"]


def test_many_questions_are_answered_in_their_order_and_errors_stand_in_for_answers(
    learned_file: Path,
) -> None:
    asked = [
        motiondb.Question("kick", where="performer=ana", limit=1),
        motiondb.Question("xqzzy"),
        motiondb.Question(like="ana/bow_1", start=0.5, limit=2),
        motiondb.Question("kick", like="ana/bow_1"),
        motiondb.Question("kick", end=1.0),
        motiondb.Question(),
    ]
    with motiondb.open(learned_file, read_only=True) as db:
        words, unknown, alike, both, cut, empty = db.ask_many(asked)
        assert words.matches == db.search("kick", "performer=ana", 1).matches
        assert alike.matches == db.like("ana/bow_1", 0.5, limit=2).matches
    assert isinstance(unknown, motiondb.UnknownWordsError)
    assert "found both" in str(both)
    assert "expected start and end for an example only" in str(cut)
    assert "found neither" in str(empty)


def test_an_answer_explains_itself_in_words_and_seconds(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("walk, turn left, not wave", limit=3)
        durations = {info.name: info.duration for info in db.captures()}
    assert answer.explanations
    for match, why in zip(answer.matches, answer.explanations, strict=True):
        # "left" is not listed where the head "turn" bounds its action
        assert {"walk", "turn"} <= {word.word for word in why.words} <= {"walk", "turn", "left"}
        assert [[w.word for w in one.words] for one in why.excluded] == [["wave"]]
        parts = [
            part
            for w in why.words
            for part in (w.prior, w.written, w.likeness, *(s.share for s in w.symbols))
        ]
        amounts = [one.amount for one in why.excluded]
        assert math.fsum([*parts, why.together, *amounts]) == why.log_odds
        assert match.score == pytest.approx(1.0 / (1.0 + math.exp(-why.log_odds)))
        for word in why.words:
            assert word.symbols[-1].to <= durations[match.capture] + 1.0
            strongest = math.fsum(s.share for s in word.strongest)
            rest = word.contribution - word.prior - word.written - word.likeness - strongest
            assert word.others == pytest.approx(rest, abs=1e-12)
            assert len(word.strongest) <= 3


def test_a_taken_word_is_explained_and_drawn_by_its_name(
    learned_file: Path, tmp_path: Path
) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.search("stroll", limit=1)
        assert "stroll" in answer.taken
        assert [word.word for word in answer.explanations[0].words] == ["stroll"]
        db.captures.draw_reasons(answer, tmp_path / "why.png", "stroll")
    assert (tmp_path / "why.png").stat().st_size > 5_000


def test_kinds_of_events_are_counted(some: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "events.tsv"
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some, settings=motiondb.AddSettings(jobs=1))
        first, second = (info.name for info in db.captures()[:2])
        sheet.write_text(
            "file\tframe\tevent\n"
            f"{first}\t15\tcatch\n{first}\t30\tcatch\n{second}\t3\tcatch\n{second}\t4\trelease\n"
        )
        assert db.captures.event_rows() == []
        db.captures.import_events(sheet)
        assert db.captures.event_rows() == [EventRow("catch", 3, 2), EventRow("release", 1, 1)]
        assert [event.seconds for event in db.captures.events(first)] == [0.5, 1.0]


def test_groups_of_copies_are_filtered_by_their_captures(some: Path, tmp_path: Path) -> None:
    moved = motiondb.read_capture(some / "boris" / "kick_1.bvh")
    motiondb.write_bvh(
        replace(moved, root_positions=moved.root_positions + np.array([2.0, 0.0, 1.0])),
        some / "boris" / "moved_1.bvh",
    )
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some, settings=motiondb.AddSettings(jobs=1))
        (group,) = db.captures.duplicates()
        assert set(group.captures) == {"boris/kick_1", "boris/moved_1"}
        assert db.captures.duplicates("name=boris/moved_1") == (group,)
        assert db.captures.duplicates("name=ana/bow_1") == ()


def test_a_grammar_is_checked_asked_and_planned_with_without_a_database(tmp_path: Path) -> None:
    grammar = Scenes.read_grammar("basketball")
    report = Scenes.check_grammar("basketball")
    assert (len(report.rules), report.n_semantic_rules) == (43, 18)
    assert Scenes.check_grammar(grammar) == report
    said = Scenes.validate(grammar, "hold shoot")
    assert (said.allowed, said.n_trees) == (True, 1)
    assert str(said.tree).startswith("S_A(Attacks(Ball(Catch(hold)")
    assert Scenes.validate("basketball", ["hold", "shoot"]).tree == said.tree
    assert Scenes.suggest("basketball", "hold") == Scenes.suggest(grammar, ["hold"])
    way = Scenes.plan("basketball", "hold", ["pass", ("shoot", "layup")])
    assert way[0] == "hold"
    assert way.index("pass") < min(n for n, a in enumerate(way) if a in ("shoot", "layup"))
    assert Scenes.validate("basketball", way).allowed
    with pytest.raises(motiondb.SceneError, match="expected an action, found 'yodel'"):
        Scenes.plan("basketball", "hold", ["yodel"])
    file = tmp_path / "twice.grammar"
    file.write_text(AMBIGUOUS)
    assert [Scenes.validate(file, "a " * n).n_trees for n in (1, 2, 3, 4)] == [1, 1, 2, 5]


def test_a_diagram_tells_what_it_asks_of_each_player(tmp_path: Path) -> None:
    text = Scenes.read_diagram("give-and-go")
    assert text.first_holder == "A1"
    assert text.expressions["A1"] == "(hold)(pass)(run)*(catch)(layup)"
    assert text.shortest["A2"] == ("catch", "pass", "run")
    assert set(text.actions) <= set(text.grammar.terminal)
    for name, string in text.shortest.items():
        start = text.grammar.start_of(text.diagram.player[name].team)
        assert Scenes.validate(text.grammar, string, start).allowed
    assert Scenes.draw_diagram(text, tmp_path / "one.png").stat().st_size > 10_000
    by_name = Scenes.draw_diagram("give-and-go", tmp_path / "two.png")
    assert by_name.read_bytes() == (tmp_path / "one.png").read_bytes()


def standing() -> Motion:
    """Two frames of the standard body with all rotations zero, the pelvis at 1, 2, 3 metres."""
    turned = np.zeros((2, len(body.JOINTS), 4), dtype=np.float32)
    turned[..., 0] = 1.0
    return Motion(turned, np.array([[1.0, 2.0, 3.0]] * 2, dtype=np.float32))


def test_joints_of_an_unturned_body_lie_at_the_sums_of_their_offsets() -> None:
    motion = standing()
    names, positions = motion.joint_names, motion.joint_positions()
    assert (len(names), positions.shape) == (21, (2, 21, 3))
    expected = np.zeros((21, 3))
    for joint, parent in enumerate(body.PARENTS):
        expected[joint] = [1, 2, 3] if parent < 0 else expected[parent] + body.OFFSETS[joint]
    np.testing.assert_allclose(positions, np.stack([expected, expected]), atol=1e-6)
    assert names[int(np.argmin(positions[0, :, 1]))] in ("l_toe", "r_toe")
    assert motion.duration == pytest.approx(2 / 30)


def test_a_generated_motion_writes_itself_with_its_provenance(
    learned_file: Path, tmp_path: Path
) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        made = db.generate("a person kicks", seed=3)
    facts = made.write(tmp_path / "kick.bvh")
    told = json.loads((tmp_path / "kick.bvh.provenance.json").read_text())
    assert (told["words"], told["seed"], told["method"]) == ("a person kicks", 3, "stitched")
    assert told["frames"][-1]["end"] == made.motion.n_frames
    assert facts.provenance == str(tmp_path / "kick.bvh.provenance.json")
    motiondb.write_bvh(made.motion, tmp_path / "plain.bvh")
    assert (tmp_path / "plain.bvh").read_bytes() == (tmp_path / "kick.bvh").read_bytes()
    with pytest.raises(motiondb.MotionDBError, match=r"expected an ending .bvh, .fbx, .glb"):
        made.write(tmp_path / "kick.txt")
    assert not (tmp_path / "kick.txt").exists()
    with pytest.raises(TypeError, match=r"or a motiondb\.Motion, found Generated"):
        motiondb.write_bvh(made, tmp_path / "made.bvh")  # what is tested
    with pytest.raises(TypeError, match="found NoneType"):
        motiondb.write_gltf(None, tmp_path / "none.glb")  # what is tested
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "kick.bvh",
        "kick.bvh.provenance.json",
        "plain.bvh",
    ]


def test_what_is_known_of_a_database_needs_no_command(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        facts = db.info()
        assert (facts.captures, facts.learned, facts.not_yet_learned) == (101, True, 0)
        assert [run["kind"] for run in db.runs()] == ["add", "learn"]
        assert db.words.rows()[0].count == max(row.count for row in db.words.rows())
        assert len(db.symbols.rows()) == facts.symbols
        assert db.captures.show("ana/walk_1").frames > 0
        assert len(db.words.vocabulary()) == facts.words


def test_features_are_what_the_models_of_symbols_score(learned_file: Path) -> None:
    name = "ana/walk_1"
    with motiondb.open(learned_file, read_only=True) as db:
        motion, plain = db.motion(name), db.captures.features(name)
        assert (plain.shape, plain.dtype) == ((math.ceil(motion.n_frames / 2), 130), np.float32)
        np.testing.assert_allclose(db.captures.features(db.clip(name)), plain, atol=1e-4)
        whitened = db.captures.features(name, whitened=True)
        rows = [row for row in db.tables.segments().to_pylist() if row["capture"] == name]
        for row in rows:
            first, end = (math.ceil(round(row[at] * 30) / 2) for at in ("start", "end"))
            part = whitened[first:end]
            score = db.learned.symbols.to_hmmlearn(row["symbol"]).score(part)
            assert score / len(part) == pytest.approx(row["log_likelihood"], abs=1e-3)


def test_questions_without_any_capture_left_say_so(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        db.captures.remove(where="not name in (ana/bow_1, boris/kick_1)")
        removed = db.captures.remove(where="fps>0")
        assert (db.info().captures, db.info().learned) == (0, True)
        for ask in (db.search, db.generate):
            with pytest.raises(motiondb.QueryError, match="captures that can be searched, found n"):
                ask("kick")
        assert set(db.undo().restored) == set(removed)
        assert db.search("kick", limit=1).matches
