"""A fault of every kind is found and told in its sentence."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from motiondb import store
from motiondb.errors import StoreError
from motiondb.store import DamagedFileError
from motiondb.store.checking import blocks


@pytest.fixture(scope="module")
def whole_file(tmp_path_factory: pytest.TempPathFactory, samples: ModuleType) -> Path:
    path = tmp_path_factory.mktemp("whole") / "motions.duckdb"
    with store.open_store(path) as database:
        infos = [samples.add(database, name) for name in ("a", "bb")]
        store.save_learning(database, samples.learning(infos, store.start_run(database, "learn")))
        assert store.check_store(database, sources=True) == []
    return path


@pytest.fixture
def filled(tmp_path: Path, whole_file: Path) -> Iterator[store.Store]:
    with store.open_store(shutil.copy(whole_file, tmp_path / "motions.duckdb")) as opened:
        yield opened


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (
            "DELETE FROM motion_frame WHERE capture_id = 1 AND frame = 3",
            "a: expected as many motion frames as its row says, numbered from 0, found others.",
        ),
        (
            "UPDATE motion_frame SET frame = 20 WHERE capture_id = 1 AND frame = 3",
            "a: expected as many motion frames as its row says, numbered from 0, found others.",
        ),
        (
            "DELETE FROM motion_frame WHERE capture_id = 2",
            "bb: expected as many motion frames as its row says, numbered from 0, found others.",
        ),
        (
            "UPDATE motion_frame SET pose = array_value("
            + ", ".join(["2.0"] * 87)
            + ")::FLOAT[87] WHERE capture_id = 2 AND frame = 5",
            "bb: expected finite positions and quaternions of length 1, found others in frame 5.",
        ),
        (
            "DELETE FROM source WHERE file_name = 'a.bvh'",
            "a: expected its file in the table source, found others.",
        ),
        (
            "UPDATE segment SET start_frame = 7 WHERE capture_id = 1 AND start_frame = 6",
            "a: expected segments that tile its motion, found others.",
        ),
        (
            "UPDATE segment SET end_frame = 11 WHERE capture_id = 1 AND end_frame = 12",
            "a: expected segments that tile its motion, found others.",
        ),
        (
            "UPDATE segment SET symbol_id = 77 WHERE ordinal = 0",
            "segment: expected every symbol_id in symbol, found 1 rows without, such as 77.",
        ),
        (
            "UPDATE segment_score SET scores = [1.0] WHERE ordinal = 2",
            "segment 2: expected a score for every symbol, found others.",
        ),
        (
            "UPDATE translation SET probability = probability + 0.1 WHERE symbol_id = -1",
            "symbol -1: expected the probabilities of its words to sum to 1, found others.",
        ),
        (
            "UPDATE translation SET probability = NULL WHERE symbol_id = 0",
            "symbol 0: expected the probabilities of its words to sum to 1, found others.",
        ),
        (
            "UPDATE alignment SET probabilities = [1.0] WHERE l = 1 AND m = 1",
            "alignment 1, 1, 0: expected l + 1 alignment probabilities that sum to 1, "
            "found others.",
        ),
        (
            "DELETE FROM symbol_state WHERE symbol_id = 0 AND state = 1",
            "symbol 0: expected states numbered from 0, as many as its row says, found others.",
        ),
        (
            "DELETE FROM symbol_distance WHERE symbol_id = 1 AND other_id = 1",
            "table symbol_distance: expected as many rows as the table learning says, "
            "found others.",
        ),
        (
            "INSERT INTO capture_tag VALUES (9, 'performer', 'x')",
            "capture_tag: expected every capture_id in capture, found 1 rows without, such as 9.",
        ),
        (
            "UPDATE run SET finished = NULL WHERE kind = 'learn'",
            "learning: expected rows of the finished run of learn, found 1 others.",
        ),
        (
            "UPDATE word SET run_id = 1",
            "word: expected rows of the finished run of learn, found 4 others.",
        ),
    ],
)
def test_damage_is_told(filled: store.Store, damage: str, sentence: str) -> None:
    filled.connection.execute(damage)
    assert sentence in store.check_store(filled)


def test_a_killed_run_is_no_fault(filled: store.Store) -> None:
    store.start_run(filled, "add")
    store.start_run(filled, "learn")
    assert store.check_store(filled) == []


def test_a_damaged_block_is_told(filled: store.Store) -> None:
    pose_blocks = filled.connection.execute(
        "SELECT block_id FROM pragma_storage_info('motion_frame') WHERE column_name = 'pose'"
    ).fetchall()
    filled.close()
    damage_block(filled.path, max(block for (block,) in pose_blocks))
    with store.open_store(filled.path, read_only=True) as opened:
        faults = store.check_store(opened)
        assert len(faults) == 1
        assert faults[0].startswith(
            f"{filled.path}: expected tables that can be read, found: damaged columns: "
        )
        assert faults[0].endswith(
            "The file is damaged: restore a copy, or save what is readable: "
            f"motiondb rescue {filled.path} -o NEW.duckdb."
        )
        with pytest.raises(DamagedFileError, match="Corrupt database file: computed checksum"):
            store.load_motion(opened, 1)


def damage_block(path: Path, number: int) -> None:
    content = bytearray(path.read_bytes())
    content[12_288 + 262_144 * number + 100] ^= 1
    path.write_bytes(content)


def test_a_block_that_no_query_reads_is_told(filled: store.Store) -> None:
    """Flip a bit in every block that is in use: each is told, whatever lies in it."""
    filled.connection.execute("CHECKPOINT")
    (_name, _size, _block, total, used, free, *_rest) = filled.connection.execute(
        "CALL pragma_database_size()"
    ).fetchone()
    filled.close()
    whole = filled.path.read_bytes()
    told = 0
    for number in range(total):
        damage_block(filled.path, number)
        told += blocks.find_damage(filled.path) == f"1 damaged of {total} blocks ({number})."
        filled.path.write_bytes(whole)
    assert (told, total - free) == (used, used)
    assert blocks.find_damage(filled.path) is None


def test_a_cut_file_is_told(filled: store.Store) -> None:
    filled.close()
    content = filled.path.read_bytes()
    filled.path.write_bytes(content[: -len(content) // 3])
    faults = store.check_file(filled.path)
    assert " damaged of " in faults[0]


def test_blocks_are_compared_beside_an_open_store(filled: store.Store) -> None:
    """Reading the file in this process would drop its lock: another one can still not write."""
    assert store.check_store(filled, sources=True) == []
    program = "import sys, duckdb; duckdb.connect(sys.argv[1])"
    ended = subprocess.run(
        [sys.executable, "-c", program, str(filled.path)], capture_output=True, text=True
    )
    assert "Could not set lock" in ended.stderr


def test_a_missing_or_changed_table_is_told(filled: store.Store) -> None:
    filled.connection.execute("DROP TABLE relation")
    filled.connection.execute("ALTER TABLE synonym ADD COLUMN extra INTEGER")
    assert store.check_store(filled) == [
        f"{filled.path}: expected the table relation as in schema.sql, found none. "
        "The file was changed by another program: restore a copy.",
        f"{filled.path}: expected the table synonym with the columns word VARCHAR, canonical "
        "VARCHAR as in schema.sql, found word VARCHAR, canonical VARCHAR, extra INTEGER. "
        "The file was changed by another program: restore a copy.",
    ]


def test_a_reader_that_dies_is_a_fault(
    filled: store.Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    dying = tmp_path / "python"
    dying.write_text("#!/bin/sh\nkill -SEGV $$\n")
    dying.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(dying))
    (fault,) = store.check_file(filled.path)
    assert "found: that reading it ends the program (SIGSEGV). The file is damaged" in fault


def test_what_keeps_the_check_from_looking_is_an_error(filled: store.Store, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="found it held by process"):
        store.check_file(filled.path)
    other = tmp_path / "walk.bvh"
    other.write_text("HIERARCHY")
    with pytest.raises(StoreError, match="found another kind of file"):
        store.check_file(other)
    with pytest.raises(StoreError, match="found no such file"):
        store.check_file(tmp_path / "none.duckdb")


def test_an_empty_store_is_whole(database: store.Store) -> None:
    assert store.check_store(database, sources=True) == []
