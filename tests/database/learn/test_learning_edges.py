"""Learning from almost nothing works, or says why not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.database.catalogue.parts import cut_clip
from motiondb.errors import MotionDBError, NotLearnedError, QueryError
from motiondb.files.formats import read_capture
from motiondb.learn.recognition import LearnSettings


def test_no_captures(tmp_path: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        with pytest.raises(MotionDBError, match="expected captures to learn from, found none"):
            db.learn()
        with pytest.raises(NotLearnedError, match="Run motiondb learn first"):
            db.search("walk")


def test_without_words_motion_is_found_and_words_are_asked_for(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        assert db.learn().association.words == ()
        assert db.like("ana/bow_1")[0].capture == "ana/bow_1"
        for ask in (lambda: db.search("bow"), lambda: db.generate("bow", 0)):
            with pytest.raises(MotionDBError, match="words"):
                ask()
        with pytest.raises(NotLearnedError, match="expected captures with words, found none"):
            db.describe("ana/bow_1")
        assert db.check() == []


@pytest.mark.parametrize("n_symbols", [None, 1])
def test_one_capture_with_one_caption(tmp_path: Path, some: Path, n_symbols: int | None) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some / "ana/bow_1.bvh")
        db.words.set("bow_1", "she bows")
        learning = db.learn(LearnSettings(n_symbols=n_symbols))
        if n_symbols:
            assert learning.symbols.n_symbols == 1
        (match,) = db.search("bow").matches
        assert match.capture == "bow_1"
        assert 0.0 <= match.score <= 1.0
        assert db.like("bow_1")[0].capture == "bow_1"
        assert all(p is None for d in db.describe("bow_1") for _, p in d.words)
        made = db.generate("bow", 1)
        assert np.isfinite(made.motion.local_rotations).all()
        assert db.check() == []


def test_a_handful_of_captions_checks_no_probability(tmp_path: Path, some: Path) -> None:
    names = {"ana/bow_1": "bow", "ana/jump_1": "jump", "boris/kick_1": "kick, bow"}
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        for name, words in names.items():
            db.words.set(name, words)
        db.learn()
        answer = db.search("bow")
        assert answer.unchecked == (
            "no probabilities: they are checked by at least 50 captions of this database, and it "
            "has 3"
        )
        assert all(m.probability is None for m in answer.matches)
        assert answer.matches_anything is None
        assert all(m.probability is None for m in db.like("ana/bow_1"))
        assert all(p is None for d in db.describe("boris/kick_1") for _, p in d.words)


def test_one_symbol_for_many_captures(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        db.words.set("ana/bow_1", "bow")
        db.words.set("boris/kick_1", "kick")
        learning = db.learn(LearnSettings(n_symbols=1))
        assert learning.symbols.n_symbols == 1
        assert np.allclose(learning.space.distances, 0.0)
        assert all(np.isfinite(m.score) for m in db.search("bow, kick").matches)
        assert db.like("boris/kick_1")[0].capture == "boris/kick_1"
        assert db.check() == []


@pytest.mark.parametrize("frames", [1, 5])
def test_captures_shorter_than_a_segment(tmp_path: Path, some: Path, frames: int) -> None:
    whole = read_capture(some / "boris/kick_1.bvh")
    folder = tmp_path / "short"
    folder.mkdir()
    for number in range(3):
        first = 20 + 10 * number
        part = cut_clip(whole, first / whole.fps, (first + frames) / whole.fps)
        motiondb.write_bvh(part, folder / f"{number}.bvh")
    with motiondb.open(tmp_path / "m.duckdb") as db:
        report = db.add(folder)
        assert report.added == ("0", "1", "2")
        for name in report.added:
            db.words.set(name, "kick")
        db.learn()
        assert db.search("kick").matches
        assert db.like(report.added[0])
        assert db.describe(report.added[0])
        assert db.check() == []


def test_what_is_added_after_learning_is_found_or_named(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some / "ana")
        assert db.captures.unlearned() == ["bow_1", "jump_1"]
        db.words.set("bow_1", "bow")
        db.learn()
        assert db.captures.unlearned() == []
        db.add(some / "boris")
        left_out = set(db.captures.unlearned())
        actual = {m.capture for m in db.search("bow").matches}
        assert db.search("bow").matches[0].capture == "bow_1"
        assert not actual & left_out
        assert actual | left_out == {"bow_1", "jump_1", "kick_1", "punch_1"}
        db.captures.remove(["jump_1"])
        assert {m.capture for m in db.search("bow").matches} == actual - {"jump_1"}
        db.learn()
        assert {m.capture for m in db.search("bow").matches} == {"bow_1", "kick_1", "punch_1"}
        assert db.captures.unlearned() == []


def test_all_removed_and_added_again(learned_copy: Path, samples_folder: Path) -> None:
    with motiondb.open(learned_copy) as db:
        db.captures.remove([info.name for info in db.captures()])
        report = db.add(samples_folder / "ana" / "bow_1.bvh")
        assert report.added == ("bow_1",)
        assert [match.capture for match in db.like("bow_1", limit=1)] == ["bow_1"]
        assert db.check() == []
        with pytest.raises(QueryError, match="walk"):
            db.search("walk")
        with pytest.raises(QueryError):
            db.generate("walk")
        assert all(d.words == () for d in db.describe("bow_1"))
