"""Too little room on the disk: what is there stays, what is new is whole or not there, both told.

A limit on the size of files stands for the disk: the system refuses to write beyond either.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import duckdb
import pytest

import motiondb
from motiondb.store.connection import faults

pytest.importorskip("resource")
LIMITED = """
import resource, sys
from motiondb.cli.main import main
most = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
main()
"""


def run_limited(most: int, *words: object) -> subprocess.CompletedProcess[str]:
    """A command that can write no file above ``most`` bytes."""
    return subprocess.run(
        [sys.executable, "-c", LIMITED, str(most), *map(str, words)],
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory, samples_folder: Path) -> Path:
    """A database of two captures."""
    path = tmp_path_factory.mktemp("room") / "motions.duckdb"
    with motiondb.open(path) as db:
        db.add(samples_folder / "ana/bow_1.bvh")
        db.add(samples_folder / "ana/jump_1.bvh")
    return path


def test_a_rescued_database_without_room_is_not_there(tmp_path: Path, two: Path) -> None:
    size = two.stat().st_size
    saved = []
    for most in (200_000, 900_000, 4 * size):
        new = tmp_path / f"new{most}.duckdb"
        ended = run_limited(most, "rescue", two, "-o", new)
        if ended.returncode == 0:
            with motiondb.open(new, read_only=True) as db:
                assert len(db.captures()) == 2
            saved.append(new.name)
        else:
            assert ended.stderr.startswith("error: ")
            assert ".rescue:" not in ended.stderr
            assert ended.stderr.rstrip().endswith(("at the disk.", "run the command again."))
        assert names(tmp_path) == set(saved)
    assert saved


def test_a_new_database_without_room_leaves_nothing(tmp_path: Path, samples_folder: Path) -> None:
    path = tmp_path / "new.duckdb"
    ended = run_limited(100_000, "add", samples_folder / "ana/bow_1.bvh", "--db", path)
    assert ended.returncode == 1
    assert ended.stderr.splitlines()[-1].startswith(
        f"error: {path}: expected to make a new database, found: "
    )
    assert names(tmp_path) == set()


def test_a_full_disk_is_no_damage() -> None:
    full = duckdb.TransactionException(
        'Failed to commit: Checkpoint failed for database "compacted". The database has been '
        'invalidated. Original error: Could not write file "a.duckdb": No space left on device'
    )
    assert not faults.is_damage(full)
    assert faults.first_sentence(full) == (
        'Could not write file "a.duckdb": No space left on device.'
    )
    assert str(faults.translate(Path("a.duckdb"), full)).startswith(
        "a.duckdb: expected room on the disk, found: Could not write"
    )
    other = duckdb.FatalException("FATAL Error: Failed: database has been invalidated")
    assert faults.is_damage(other)


LEAVES_A_LOG = """
import os, sys
import motiondb
db = motiondb.open(sys.argv[1])
db.words.set("bow_1", "a bow")
os._exit(0)
"""


def test_a_log_that_stays_is_told_by_compact(tmp_path: Path, two: Path) -> None:
    path = tmp_path / "motions.duckdb"
    path.write_bytes(two.read_bytes())
    subprocess.run([sys.executable, "-c", LEAVES_A_LOG, str(path)], check=True)
    ended = run_limited(100_000, "compact", "--db", path)
    assert ended.stderr == (
        f"error: {path}: expected all changes in the file, found some in the log beside it "
        "(motions.duckdb.wal): another program is writing, or the disk has no room to bring them "
        "in. Wait until it has ended, and look at the disk.\n"
    )
    with motiondb.open(path) as db:
        assert db.words.captions("bow_1")[0].words == "a bow"
