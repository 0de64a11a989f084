"""A learned database whose motions, originals and scores lie in a folder: the same answers."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

import motiondb
from motiondb import store

NAME = "ana/walk_1"


def answers(db: motiondb.MotionDB) -> list[Any]:
    """What is asked of words, of motion, and of originals."""
    made = db.generate("walk then jump", seed=3)
    return [
        db.search("walk then jump").matches,
        db.like(NAME, start=0.5, end=2.0).matches,
        db.describe(NAME),
        made.motion.root_positions.tobytes(),
    ]


@pytest.fixture
def moved(few_copy: Path, tmp_path: Path) -> Path:
    """A learned database of which the motions were moved."""
    done = motiondb.compact(few_copy, motions_to=str(tmp_path / "out"))
    assert done.moved == 12
    assert done.after < done.before
    return few_copy


def test_the_answers_are_the_same(learned_few: Path, moved: Path) -> None:
    with motiondb.open(learned_few, read_only=True) as db:
        expected = answers(db)
    for _ in range(2):  # then without the cache beside it
        with motiondb.open(moved) as db:
            assert str(answers(db)) == str(expected)
            assert db.check() == []
        shutil.rmtree(moved.with_name(f"{moved.name}.cache"))


def test_words_are_answered_without_the_folder_and_the_rest_says_what_is_missing(
    moved: Path, tmp_path: Path
) -> None:
    with motiondb.open(moved) as db:
        expected = [(m.capture, m.start) for m in db.search("walk then jump").matches]
    (tmp_path / "out").rename(tmp_path / "away")
    with motiondb.open(moved) as db:
        assert [(m.capture, m.start) for m in db.search("walk then jump").matches] == expected
        assert len(db.captures()) == 12
        assert db.info().captures == 12
        for ask in (
            lambda: db.like(NAME),
            lambda: db.generate("walk", seed=3),
            lambda: db.export(NAME, tmp_path / "w.bvh"),
        ):
            with pytest.raises(motiondb.StoreError, match="--motions-to PLACE"):
                ask()
        assert db.damage_note == ""  # no capture is left out of answers


def test_it_is_copied_merged_and_rescued(moved: Path, tmp_path: Path, samples_folder: Path) -> None:
    original = (samples_folder / f"{NAME}.bvh").read_bytes()
    with motiondb.open(moved, read_only=True) as db:
        motion = db.motion(NAME)
        db.backup(tmp_path / "copy.duckdb")
    with motiondb.open(tmp_path / "merged.duckdb") as db:
        assert len(db.merge(tmp_path / "copy.duckdb").added) == 12
    report = motiondb.rescue(moved, tmp_path / "rescued.duckdb")
    assert (len(report.captures), report.mended, report.lost) == (12, (), ())
    shutil.rmtree(tmp_path / "out")  # which neither of the two needs
    for name in ("merged", "rescued"):
        with motiondb.open(tmp_path / f"{name}.duckdb") as db:
            assert (db.motion(NAME).root_positions == motion.root_positions).all()
            db.export(NAME, tmp_path / f"{name}.bvh")
            assert (tmp_path / f"{name}.bvh").read_bytes() == original
            assert db.info().motions_at is None


def test_a_moved_capture_is_removed_and_comes_back(moved: Path, tmp_path: Path) -> None:
    with motiondb.open(moved) as db:
        before = db.motion(NAME)
        db.captures.remove([NAME])
        db.undo()
        assert (db.motion(NAME).root_positions == before.root_positions).all()
        assert db.check() == []


def test_the_command_moves_and_brings_back(command: Any, few_copy: Path) -> None:
    ended = command("compact", "--motions-to", "out")
    assert ended.code == 0, ended.err
    assert ended.out.startswith("motions or scores of 12 captures moved\n")
    told = command("info").out
    assert f"motions at:            {few_copy.parent / 'out'}\n" in told
    ended = command("compact", "--motions-to", "here")
    motions, scores = sorted((few_copy.parent / "out").iterdir())
    assert ended.out.endswith(
        "2 Parquet files no longer needed. Delete what no copy of the database needs:\n"
        f"  {motions}\n  {scores}\n"
    )
    assert "motions at" not in command("info").out


def bits_of_scores(path: Path) -> dict[int, bytes]:
    with store.open_store(path, read_only=True) as opened:
        return {number: part.tobytes() for number, part in store.load_scores(opened).items()}


def test_scores_are_made_anew_by_learning_and_brought_back(some: Path, tmp_path: Path) -> None:
    path, settings = tmp_path / "m.duckdb", motiondb.LearnSettings(n_symbols=3)
    with motiondb.open(path) as db:
        db.add(some)
        db.learn(settings)
        expected = db.like("ana/bow_1").matches
    before = bits_of_scores(path)
    assert motiondb.compact(path, motions_to=str(tmp_path / "out")).moved == 4
    assert bits_of_scores(path) == before
    (scores,) = (tmp_path / "out").glob("scores-*")
    shutil.rmtree(path.with_name(f"{path.name}.cache"))
    scores.rename(tmp_path / "away")
    with motiondb.open(path) as db:
        for ask in (lambda: db.like("ana/bow_1"), lambda: db.captures.remove(["ana/bow_1"])):
            with pytest.raises(motiondb.StoreError) as error:
                ask()
            assert str(error.value).startswith(f"{scores}: expected a file or folder, found none.")
            assert str(error.value).endswith(f"make them anew (motiondb learn --db {path}).")
        assert len(db.captures()) == 4  # nothing was removed
        db.learn(settings)
        assert db.like("ana/bow_1").matches == expected
        assert db.check() == []
    assert bits_of_scores(path) == before
    done = motiondb.compact(path, motions_to=str(tmp_path / "out"))
    assert (done.moved, done.unused) == (4, (str(scores),))
    done = motiondb.compact(path, motions_to="here")
    assert (done.moved, len(done.unused)) == (4, 2)
    shutil.rmtree(tmp_path / "out")
    shutil.rmtree(path.with_name(f"{path.name}.cache"))
    assert bits_of_scores(path) == before
    with motiondb.open(path) as db:
        assert db.like("ana/bow_1").matches == expected
        assert db.check() == []


def test_a_capture_is_removed_and_comes_back_beside_moved_scores(moved: Path) -> None:
    before = bits_of_scores(moved)
    with motiondb.open(moved) as db:
        number = next(info.capture_id for info in db.captures() if info.name == "boris/kick_1")
        db.captures.remove(["boris/kick_1"])
        assert db.check() == []
    others = {n: part for n, part in before.items() if n != number}
    assert bits_of_scores(moved) == others
    with motiondb.open(moved) as db:
        db.undo()
    again = bits_of_scores(moved)
    assert {n: part for n, part in again.items() if n != number} == others
    assert len(again[number]) == len(before[number])
    assert motiondb.compact(moved, motions_to=str(moved.parent / "out")).moved == 1
    assert bits_of_scores(moved) == again
    with motiondb.open(moved) as db:
        assert db.check() == []


def test_rescue_names_a_missing_parquet_file(moved: Path, tmp_path: Path) -> None:
    for scores in (tmp_path / "out").glob("scores-*"):
        scores.unlink()  # which rescue does without
    (file, *_) = (tmp_path / "out").iterdir()
    data = file.read_bytes()
    file.unlink()
    with pytest.raises(motiondb.StoreError) as error:
        motiondb.rescue(moved, tmp_path / "rescued.duckdb")
    assert str(error.value).startswith(f"{file}: expected a file or folder, found none.")
    assert not (tmp_path / "rescued.duckdb").exists()
    file.write_bytes(data[: len(data) // 2])  # what is damaged is lost, and the rest is saved
    report = motiondb.rescue(moved, tmp_path / "rescued.duckdb")
    assert report.captures
    assert report.mended or report.lost
