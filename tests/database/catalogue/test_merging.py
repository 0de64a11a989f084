"""Another database taken over, and a copy made while the database is used."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from holding import holding

import motiondb
from motiondb import Caption, MotionDBError, QueryError, StoreError, store


def test_what_two_databases_know_comes_together(
    tmp_path: Path, some: Path, samples_folder: Path
) -> None:
    more = tmp_path / "more"
    (more / "ana").mkdir(parents=True)
    shutil.copy(some / "ana" / "bow_1.bvh", more / "same.bvh")
    shutil.copy(samples_folder / "boris" / "idle_1.bvh", more / "ana" / "jump_1.bvh")
    shutil.copy(samples_folder / "boris" / "guard_1.bvh", more / "guard.bvh")
    with motiondb.open(tmp_path / "b.duckdb") as other:
        other.add(more, settings=motiondb.AddSettings(unit=0.01))
        other.set_words("same", "a bow")
        other.set_words("guard", "on guard", 0.5, 1.0)
        other.set_tags({"performer": "B", "mood": "glad"}, ["same"])
        synonyms = tmp_path / "synonyms.txt"
        synonyms.write_text("hop = jump\n")
        other.set_synonyms(synonyms)
        guard = other.clip("guard")
    with motiondb.open(tmp_path / "a.duckdb") as db:
        db.add(some)
        db.words.set("ana/bow_1", "she bows")
        db.captures.set_tags({"performer": "A"}, ["ana/bow_1"])
        report = db.merge(tmp_path / "b.duckdb")
        assert report.added == ("guard",)
        assert (report.known, report.changed) == ((("same", "ana/bow_1"),), ("ana/bow_1",))
        assert report.problems == (
            "ana/jump_1: expected a free name, found another capture of that name here. It was "
            "left out; rename one of them, or put a folder before the new names (--prefix).",
        )
        assert report.notes == (
            "ana/bow_1: performer stays 'A'; the other database has 'B'",
            "not taken over: synonyms (1), the history of its captions",
        )
        assert db.words.captions("ana/bow_1") == (Caption("she bows"), Caption("a bow"))
        assert db.captures("name=ana/bow_1")[0].tags == {"performer": "A", "mood": "glad"}
        assert db.words.captions("guard") == (Caption("on guard", 0.5, 1.0),)
        moved = db.clip("guard")  # read in the unit that it was added with
        assert (moved.unit, moved.root_positions.tolist()) == (0.01, guard.root_positions.tolist())
        assert db.merge(tmp_path / "b.duckdb", prefix="b/").added == ("b/ana/jump_1",)
        assert db.check() == []
        again = db.merge(tmp_path / "b.duckdb", prefix="b/")
        assert (again.added, again.changed, again.problems) == ((), (), ())
        db.undo()
        db.undo()
        assert [info.name for info in db.captures()] == [
            "ana/bow_1", "ana/jump_1", "boris/kick_1", "boris/punch_1"
        ]  # fmt: skip
        assert db.words.captions("ana/bow_1") == (Caption("she bows"),)
        with pytest.raises(MotionDBError, match="expected another database, found this one"):
            db.merge(tmp_path / "a.duckdb")


def test_generated_motion_comes_with_its_origin(learned_copy: Path, tmp_path: Path) -> None:
    with motiondb.open(learned_copy) as other:
        made = other.generate("walk")
        other.save_generated("made/walk", "walk", made, 0)
        origin = other.provenance("made/walk")
    with motiondb.open(tmp_path / "new.duckdb") as db:
        report = db.merge(learned_copy)
        assert len(report.added) == 102
        assert db.captures.provenance("made/walk").sources == origin.sources
        assert (
            db.captures.provenance("made/walk").source_frames.tolist()
            == origin.source_frames.tolist()
        )
        assert "what it learned" in report.notes[-1]


def test_a_copy_made_during_changes_is_one_state(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        stop = threading.Event()

        def change() -> None:
            number = 0
            while not stop.is_set():
                number += 1
                db.captures.set_tags({"a": str(number), "b": str(number)}, where="name~ana")

        thread = threading.Thread(target=change)
        thread.start()
        try:
            db.backup(tmp_path / "copy.duckdb")
        finally:
            stop.set()
            thread.join()
        with pytest.raises(QueryError, match="already exists"):
            db.backup(tmp_path / "copy.duckdb")
        with motiondb.open(tmp_path / "copy.duckdb") as copy:
            assert len({v for i in copy.captures("name~ana") for v in i.tags.values()}) <= 1
            assert len(copy.captures()) == 4
            assert copy.check() == []
            assert copy.undo().kind in ("tags", "add")
    assert [p.name for p in tmp_path.iterdir() if ".part" in p.name] == []


def test_a_database_without_its_log_is_not_merged_and_rescue_says_so(
    tmp_path: Path, some: Path
) -> None:
    path = tmp_path / "m.duckdb"
    with motiondb.open(path) as db:
        db.add(some / "ana")
    with motiondb.open(path) as db:
        db.words.set("bow_1", "she bows")
        shutil.copy(path, tmp_path / "lacking.duckdb")  # as after a kill, without the log
    lacking = tmp_path / "lacking.duckdb"
    with motiondb.open(tmp_path / "to.duckdb") as db:
        for refuse in (db.merge, motiondb.check_merge):
            with pytest.raises(
                StoreError, match=r"expected its log lacking\.duckdb\.wal beside it"
            ):
                refuse(lacking)
        assert (
            motiondb.rescue(lacking, tmp_path / "saved.duckdb")
            .lost[0]
            .startswith(f"{lacking}: expected its log")
        )
        with motiondb.open(lacking) as changed:
            changed.set_tags({"mood": "glad"}, ["bow_1"])
        assert "they are lost" in db.merge(lacking).notes[0]
    assert "they are lost" in motiondb.rescue(lacking, tmp_path / "again.duckdb").lost[0]


def test_names_of_another_database_that_cannot_be_names_are_told(
    tmp_path: Path, some: Path
) -> None:
    with motiondb.open(tmp_path / "other.duckdb") as other:
        other.add(some)
        odd = ("../../evil", "\x1b[31m", "", "C:\\x")
        for info, name in zip(other.captures(), odd):
            store.rename_captures(other.store, {info.capture_id: name})
    with motiondb.open(tmp_path / "m.duckdb") as db:
        problems = db.merge(tmp_path / "other.duckdb").problems
    found = ("one of dots alone", "that cannot be printed", "nothing", "a backslash")
    assert len(problems) == len(odd)
    for problem, name, fault in zip(problems, odd, found):
        assert problem.startswith(f"{name!r}: expected a name for the capture, found ")
        assert f"{fault}. Choose another name" in problem


def test_what_a_killed_copy_left_goes_with_the_next_of_any_name(tmp_path: Path, some: Path) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some / "ana")
        left, *others = (
            tmp_path / f".{name}.{process}.7.part"
            for name, process in (
                ("monday.duckdb", ended.pid),
                ("monday.txt", ended.pid),
                ("tuesday.duckdb", os.getpid()),
                ("wednesday.duckdb", ended.pid),
            )
        )
        for draft in (left, others[1], others[2]):
            store.open_store(draft).close()
        others[0].write_text("no database")
        left.with_name(f"{left.name}.wal").touch()
        with holding(others[2]):  # as a process of another machine
            db.backup(tmp_path / "copy.duckdb")
    found = {path.name for path in tmp_path.iterdir() if ".part" in path.name}
    assert found == {path.name for path in others}
