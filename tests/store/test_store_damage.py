"""Damaged databases: none is called sound when a question fails, and what is readable is saved."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import damage_runs
import numpy as np
import pytest
from typer.testing import CliRunner

import motiondb
from motiondb import store
from motiondb.cli.main import make_app
from motiondb.database.catalogue.rescuing import rescue
from motiondb.errors import StoreError


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory, samples_folder: Path) -> Path:
    """A database of three captures that has learned, with a generated one."""
    folder = tmp_path_factory.mktemp("small")
    captures = folder / "captures"
    captures.mkdir()
    for name in ("bow_1", "walk_1", "jump_1"):
        shutil.copy(sorted(samples_folder.glob(f"*/{name}.bvh"))[0], captures)
    path = folder / "small.duckdb"
    with motiondb.open(path) as db:
        assert db.add(captures).problems == ()
        for name in ("bow", "walk", "jump"):
            db.words.set(f"{name}_1", f"{name} slowly")
        db.learn()
        db.captures.save_generated("made", "walk", db.generate("walk"), 0)
    return path


@pytest.mark.parametrize("kind", damage_runs.KINDS)
def test_no_damaged_database_is_called_sound(small: Path, kind: str) -> None:
    outcomes = list(damage_runs.runs(small, range(1), [kind]))
    assert [outcome for outcome in outcomes if outcome.is_missed] == []
    assert {outcome.wrong for outcome in outcomes} <= {"", "refused"}
    if kind in ("cut", "tail"):  # a file that is too short is never called sound
        assert all(outcome.faults != () for outcome in outcomes)


def damaged(path: Path, table: str, column: str, target: Path) -> Path:
    """A copy in which the blocks of a column are damaged."""
    with store.open_store(path, read_only=True) as database:
        numbers = {
            number
            for numbers in database.connection.execute(
                f"SELECT [block_id] || coalesce(additional_block_ids, []) FROM "
                f"pragma_storage_info('{table}') WHERE column_name = '{column}' AND persistent"
            ).fetchall()
            for number in numbers[0]
            if number >= 0
        }
    content = bytearray(path.read_bytes())
    for number in numbers:
        content[12_288 + 262_144 * number + 5000] ^= 4
    target.write_bytes(content)
    return target


def test_lost_motions_are_read_from_the_files_again(small: Path, tmp_path: Path) -> None:
    bad = damaged(small, "motion", "poses", tmp_path / "bad.duckdb")
    report = rescue(bad, tmp_path / "new.duckdb")
    assert report.captures == ("bow_1", "jump_1", "walk_1", "made")
    assert report.lost == ()
    assert report.was_learned
    assert (
        report.mended[0] == "bow_1: could not read motion; its motion was read from its file again"
    )
    with motiondb.open(small) as before, motiondb.open(tmp_path / "new.duckdb") as after:
        assert after.check() == []
        for name in report.captures[:3]:
            assert after.captions(name) == before.captions(name)
            np.testing.assert_array_equal(
                after.motion(name).root_positions, before.motion(name).root_positions
            )
        after.learn()
        assert after.search("bow").matches[0].capture == "bow_1"


def test_lost_files_are_written_from_the_motions(small: Path, tmp_path: Path) -> None:
    bad = damaged(small, "source", "data", tmp_path / "bad.duckdb")
    report = rescue(bad, tmp_path / "new.duckdb")
    assert report.captures == ("bow_1", "jump_1", "walk_1", "made")
    assert report.mended[0] == (
        "bow_1: could not read file; its file is now its motion on the canonical body, as BVH"
    )
    with motiondb.open(small) as before, motiondb.open(tmp_path / "new.duckdb") as after:
        assert after.check() == []
        np.testing.assert_array_equal(
            after.motion("walk_1").local_rotations, before.motion("walk_1").local_rotations
        )
        assert after.clip("walk_1").n_frames == before.motion("walk_1").n_frames


def test_without_a_catalogue_the_files_are_saved(small: Path, tmp_path: Path) -> None:
    bad = damaged(small, "capture", "name", tmp_path / "bad.duckdb")
    report = rescue(bad, tmp_path / "new.duckdb")
    with motiondb.open(tmp_path / "new.duckdb") as after:
        assert after.check() == []
        assert [info.name for info in after.captures()] == list(report.captures)
    assert set(report.captures) <= {"bow_1", "jump_1", "walk_1", "made"}
    assert report.captures or report.lost


@pytest.mark.parametrize(("kind", "seed"), [("page", 0), ("cut", 1), ("zero", 0)])
def test_every_rescued_database_is_sound(small: Path, tmp_path: Path, kind: str, seed: int) -> None:
    bad = tmp_path / "bad.duckdb"
    bad.write_bytes(damage_runs.damage(small.read_bytes(), kind, seed))
    try:
        report = rescue(bad, tmp_path / "new.duckdb")
    except StoreError:
        assert not (tmp_path / "new.duckdb").exists()
    else:
        assert motiondb.check_file(tmp_path / "new.duckdb") == []
        saved = {sentence.partition(":")[0] for sentence in report.lost} | set(report.captures)
        assert saved
    names = {file.name for file in tmp_path.iterdir()}
    assert names <= {"bad.duckdb", "new.duckdb", "bad.duckdb.cache"}


def test_everything_of_a_sound_database_is_saved(
    samples: ModuleType, database: store.Store, tmp_path: Path
) -> None:
    infos = [samples.add(database, name) for name in ("a", "bb")]
    run_id = store.start_run(database, "grammar")
    store.save_grammar(database, samples.grammar("dance", infos), run_id)
    store.finish_run(database, run_id)
    store.save_synonyms(database, {"stroll": "walk"})
    runs = store.load_runs(database)
    before = {i.name: vars(i) | {"capture_id": 0} for i in store.load_captures(database)}
    database.close()
    report = rescue(database.path, tmp_path / "new.duckdb")
    assert (report.mended, report.lost, report.was_learned) == ((), (), False)
    with store.open_store(tmp_path / "new.duckdb", read_only=True) as new:
        assert store.load_runs(new)[:-1] == runs
        assert store.load_synonyms(new) == {"stroll": "walk"}
        assert store.load_grammar(new, "dance").rules
        after = {i.name: vars(i) | {"capture_id": 0} for i in store.load_captures(new)}
        assert after == before
        assert store.check_store(new, sources=True) == []


_KILLED = """
import os, sys
from motiondb import store
database = store.open_store(sys.argv[1])
store.save_synonyms(database, {"dash": "run"})
os._exit(0)
"""


def test_a_damaged_log_is_left_out(small: Path, tmp_path: Path) -> None:
    bad = Path(shutil.copy(small, tmp_path / "bad.duckdb"))
    subprocess.run([sys.executable, "-c", _KILLED, str(bad)], check=True)
    log = tmp_path / "bad.duckdb.wal"
    content = bytearray(log.read_bytes())
    content[len(content) // 2] ^= 1
    log.write_bytes(content)
    with pytest.raises(StoreError, match="Corrupt WAL file"):
        motiondb.check_file(bad)
    report = rescue(bad, tmp_path / "new.duckdb")
    assert report.captures == ("bow_1", "jump_1", "walk_1", "made")
    assert report.lost == (f"{log}: could not be read; the latest changes are lost.",)
    assert log.read_bytes() == content
    assert motiondb.check_file(tmp_path / "new.duckdb") == []


def test_the_command_tells_what_was_saved(small: Path, tmp_path: Path) -> None:
    bad = damaged(small, "motion", "poses", tmp_path / "bad.duckdb")
    new = tmp_path / "new.duckdb"
    ended = CliRunner().invoke(make_app(), ["rescue", str(bad), "-o", str(new)])
    assert ended.exit_code == 0
    assert ended.stdout == (f"4 captures saved in {new}\nLearn again: motiondb learn --db {new}\n")
    assert "bow_1: could not read motion" in ended.stderr
    again = CliRunner().invoke(make_app(), ["rescue", str(bad), "-o", str(new)])
    assert isinstance(again.exception, StoreError)
    assert "expected the name of a new file, found a file of that name" in str(again.exception)
    ended = CliRunner().invoke(make_app(), ["check", "--db", str(bad)])
    assert ended.exit_code == 1
    assert "is sound" not in ended.stdout


def test_what_killed_rescues_left_is_deleted_and_others_go_on(small: Path, tmp_path: Path) -> None:
    part = "99999999.1.part"
    killed, other = tmp_path / f".new.duckdb.{part}", tmp_path / ".new.duckdb.1.1.part"
    for left in (killed, tmp_path / f"..new.duckdb.{part}.{part}", other):
        left.write_bytes(b"begun")
    rescue(small, tmp_path / "new.duckdb")
    assert {path.name for path in tmp_path.iterdir()} == {"new.duckdb", other.name}
