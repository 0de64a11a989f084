"""A fault of every kind is found and told in its sentence."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from pathlib import Path
from types import ModuleType

import duckdb
import numpy as np
import pytest

from motiondb import store
from motiondb.errors import StoreError
from motiondb.store import DamagedFileError, checks, learned
from motiondb.store.catalogue.captures import POSE_SIZE, pack_poses
from motiondb.store.connection.migrations import present_schema

POSES = np.full((12, POSE_SIZE), 0.5, dtype=np.float32)
POSES[5] = 2.0  # Quaternions of length 4
LONG = pack_poses(POSES)


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
            "UPDATE motion SET n_frames = n_frames - 1 WHERE capture_id = 1",
            "a: expected one motion of as many frames as its row says, found others.",
        ),
        (
            "DELETE FROM motion WHERE capture_id = 2",
            "bb: expected one motion of as many frames as its row says, found others.",
        ),
        (
            f"UPDATE motion SET poses = from_hex('{LONG.hex()}') WHERE capture_id = 2",
            "bb: expected finite positions and quaternions of length 1, found others in frame 5.",
        ),
        (
            "UPDATE motion SET poses = 'walk'::BLOB WHERE capture_id = 2",
            "bb: {path}: expected tables that can be read, found: a motion (of the capture bb) "
            "that cannot be unpacked (Error -3 while decompressing data: incorrect header check). "
            "The file is damaged: restore a copy, or save what is readable: "
            "motiondb rescue {path} -o NEW.duckdb.",
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
            "UPDATE segment SET symbol_id = 77 WHERE capture_id = 1 AND start_frame = 0",
            "segment: expected every symbol_id in symbol, found 1 rows without, such as 77.",
        ),
        (
            "UPDATE segment_score SET scores = [1.0] WHERE capture_id = 2",
            "bb: expected a score of every segment for every symbol, found others.",
        ),
        (
            "UPDATE segment_score SET scores = [], scores_at = row(7, 0, 4, 0)",
            "a: expected a score of every segment for every symbol, found others.",
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
    assert sentence.replace("{path}", str(filled.path)) in store.check_store(filled)


@pytest.mark.parametrize(
    ("damage", "is_seen"),
    [
        ("DELETE FROM source WHERE file_name = 'a.bvh'", True),
        ("UPDATE segment SET symbol_id = 77 WHERE capture_id = 1 AND start_frame = 0", True),
        ("DROP TABLE event", True),
        ("DELETE FROM motion WHERE capture_id = 2", True),
    ],
)
def test_a_quick_check_leaves_out_large_tables(
    filled: store.Store, damage: str, is_seen: bool
) -> None:
    assert store.check_quickly(filled) == []
    filled.connection.execute(damage)
    assert bool(store.check_quickly(filled)) == is_seen


def test_a_killed_run_is_no_fault(filled: store.Store) -> None:
    store.start_run(filled, "add")
    store.start_run(filled, "learn")
    assert store.check_store(filled) == []


def test_a_damaged_block_is_told(filled: store.Store) -> None:
    pose_blocks = filled.connection.execute(
        "SELECT block_id FROM pragma_storage_info('motion') WHERE column_name = 'poses'"
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
    """Flip a bit of a block; a second time mends it."""
    with path.open("r+b") as file:
        file.seek(12_288 + 262_144 * number + 100)
        (byte,) = file.read(1)
        file.seek(-1, 1)
        file.write(bytes([byte ^ 1]))


def test_damage_in_any_table_and_in_the_indexes_of_names_is_told(filled: store.Store) -> None:
    """Flip a bit in every block that holds a column, then in every other one."""
    query = "SELECT unnest([block_id] || coalesce(additional_block_ids, [])) FROM "
    used = {
        number
        for table in store.count_rows(filled)
        for (number,) in filled.connection.execute(
            f"{query} pragma_storage_info('{table}') WHERE persistent"
        ).fetchall()
        if number >= 0
    }
    total = filled.connection.execute("CALL pragma_database_size()").fetchone()[3]
    filled.close()
    missed = set()
    for number in range(total):
        damage_block(filled.path, number)
        try:
            with store.open_store(filled.path, read_only=True) as opened:
                if not store.check_store(opened):
                    missed.add(number)
        except StoreError:
            pass
        damage_block(filled.path, number)
    assert not missed & used
    assert len(missed) < total // 2


def test_the_index_of_numbers_without_gaps_is_read(tmp_path: Path) -> None:
    """Asked for all of them, DuckDB would not look into it."""
    path, told = tmp_path / "m.duckdb", []
    with store.open_store(path) as opened:
        opened.connection.execute("CREATE TABLE many (number BIGINT PRIMARY KEY)")
        opened.connection.execute("INSERT INTO many FROM range(300)")
    whole = path.read_bytes()
    for block in range(len(whole) // 262_144):
        damage_block(path, block)
        with suppress(StoreError), store.open_store(path, read_only=True) as opened:
            if checks._is_readable(opened, "many", ["number"]):
                is_found = checks._is_indexed(opened, "many", "number")
                told.append(not is_found)
                with nullcontext() if is_found else pytest.raises(DamagedFileError):
                    opened.connection.execute("FROM many WHERE number = 7").fetchall()
        path.write_bytes(whole)
    assert any(told)


def test_a_file_whose_end_was_free_is_whole(tmp_path: Path) -> None:
    """DuckDB cuts free blocks off the end, and its head goes on counting them."""
    path = tmp_path / "m.duckdb"
    for change in ("CREATE TABLE big AS SELECT random() FROM range(1000000)", "DROP TABLE big"):
        with store.open_store(path) as opened:
            opened.connection.execute(change)
    with store.open_store(path, read_only=True) as opened:
        assert store.check_store(opened) == []
        ((counted,),) = opened.connection.execute(
            "SELECT block_size * total_blocks FROM pragma_database_size()"
        ).fetchall()
        assert counted > path.stat().st_size


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


def test_an_empty_store_is_whole(database: store.Store) -> None:
    assert store.check_store(database, sources=True) == []


def test_every_row_of_a_run_is_checked() -> None:
    with duckdb.connect() as written:
        written.execute(present_schema())
        query = "SELECT table_name FROM duckdb_columns() WHERE column_name = 'run_id'"
        named = {row[0] for row in written.execute(query).fetchall()}
    asked = "\n".join(query for _, query, _ in checks._rules())
    ours = {table for table in named if f"FROM {table}\n    WHERE run_id NOT IN" in asked}
    assert named == {"run", "capture", "edit", *ours}


def test_every_table_that_was_learned_belongs_to_the_run_of_learn() -> None:
    told = [
        sentence.partition(":")[0] for sentence, _, _ in checks._rules() if "of learn" in sentence
    ]
    assert told == list(learned.TABLES)


def test_every_rule_tells_what_its_query_gives(database: store.Store) -> None:
    for sentence, query, _ in checks._rules():
        columns = database.connection.execute(f"DESCRIBE {query}").fetchall()
        assert sentence.count("{}") == len(columns), sentence
        assert "{" not in sentence.replace("{}", "") + query
