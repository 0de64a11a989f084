"""New files have the tables of schema.sql, older ones are migrated, and others are refused."""

from __future__ import annotations

import hashlib
import re
import shutil
from importlib import resources
from pathlib import Path
from types import ModuleType

import duckdb
import pytest

from motiondb import store
from motiondb.database.checking import check_file
from motiondb.errors import StoreError
from motiondb.files.safe_files import log_of
from motiondb.store import checks
from motiondb.store.connection import migrations, opening

RELEASED = {
    4: "6aaa4d3c4936aaf3c811a169a73ee3797e00889b8c4e526ef6be9d0c7ea813c2",
    5: "cffbf88c1aef44219d0c6970f9327b1fe1c2f2290bad33fbb7a9b7a5627fa979",
    6: "2ab94e7df4613c04d0e56b366d02f9a703998a5f8ca84721a8d9f04f4bc75aa2",
    7: "62933493a19d253e04be87dfe7d0599a93a3504cb186cdf60ec15578c81ee060",
    8: "8f8446fdeb3a6a4ebd37ff69aa0c57bf1a7b021f288ba9f0d822994c238910d5",
    9: "c2e7b01a1ffe435108e741ee72cce2b398cae8db10faeb6171ce0deb5e9a67ae",
    10: "c2e7b01a1ffe435108e741ee72cce2b398cae8db10faeb6171ce0deb5e9a67ae",
    11: "c2e7b01a1ffe435108e741ee72cce2b398cae8db10faeb6171ce0deb5e9a67ae",
}
"""Version -> SHA-256 of the SQL of its tables, without comments. A further version gets a row, and
a row never changes after its release: write a migration instead."""

TODAY = migrations.newest_version()


def test_the_tables_of_a_released_version_never_change() -> None:
    sql = " ".join(re.sub(r"--.*", "", migrations.present_schema()).split())
    newest = migrations.newest_version()
    assert RELEASED[newest] == hashlib.sha256(sql.encode()).hexdigest()


def test_every_table_stands_in_the_diagram() -> None:
    diagram = (resources.files("motiondb.schema") / "README.md").read_text(encoding="utf-8")
    with duckdb.connect() as written:
        written.execute(migrations.present_schema())
        columns = written.execute(
            "SELECT table_name, column_name FROM duckdb_columns() WHERE NOT internal"
        ).fetchall()
    assert [pair for pair in columns if pair[0] not in diagram or pair[1] not in diagram] == []


def _add_a_version(patch: pytest.MonkeyPatch, text: str) -> None:
    """Let there be a further version, whose tables ``text`` makes of those of today."""
    schema, known = migrations.present_schema(), migrations.known_migrations()
    patch.setattr(migrations, "known_migrations", lambda: (*known, text))
    patch.setattr(migrations, "present_schema", lambda: schema + text)


def test_a_later_migration_is_applied_once_to_an_older_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old, new = tmp_path / "old.duckdb", tmp_path / "new.duckdb"
    store.open_store(old).close()
    _add_a_version(monkeypatch, "CREATE TABLE later (x BIGINT); INSERT INTO later VALUES (7);")
    for path in (old, new, old):  # a second CREATE TABLE would be refused
        with store.open_store(path, read_only=path.exists()) as database:
            assert database.connection.execute("FROM later").fetchall() == [(7,)]
            assert migrations.schema_version(database.connection, "") == TODAY + 1
            assert store.revision(database) == 0


def test_a_database_that_two_versions_wrote_stays_sound(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next version is made up."""
    motion = samples.add(database, "a").motion_frames
    infos = store.load_captures(database)
    learning = samples.learning(infos, store.start_run(database, "learn"))
    store.save_learning(database, learning)
    database.close()
    _add_a_version(
        monkeypatch,
        "ALTER TABLE synonym ADD COLUMN note VARCHAR;"
        " CREATE TABLE later (capture_id BIGINT, x BIGINT);"
        " INSERT INTO later SELECT capture_id, motion_frames FROM capture;",
    )
    monkeypatch.setattr(checks, "present_schema", migrations.present_schema)
    monkeypatch.setattr(checks, "_expected_tables", checks._expected_tables.__wrapped__)
    for _ in range(2):  # the second time without its free space
        with store.open_store(database.path) as newer:
            assert store.check_store(newer, sources=True) == []
            assert newer.connection.execute("SELECT x FROM later").fetchall() == [(motion,)]
            samples.assert_equal(store.load_symbols(newer), learning.symbols)
            samples.add(newer, "b" * (2 + len(store.load_captures(newer))))
            store.save_synonyms(newer, {"jog": "run"})
            assert store.check_store(newer, sources=True) == []
        store.compact(database.path)


_WITHOUT_PLACES = """
    DROP TABLE finding;
    DROP TABLE capture_quality;
    DROP TABLE known_file;
    ALTER TABLE segment_score DROP scores_at;
    DROP TABLE parquet_file;
    ALTER TABLE motion DROP poses_at;
    ALTER TABLE source DROP data_at;
    ALTER TABLE source DROP skeleton_data_at;
    UPDATE meta SET value = '5' WHERE key = 'schema';
"""  # From the tables of version 11 to those of version 5
_FORMER_SEGMENTS = """
    ALTER TABLE segment ADD COLUMN ordinal BIGINT;
    UPDATE segment SET ordinal = n FROM (SELECT capture_id AS c, start_frame AS f,
        row_number() OVER (ORDER BY capture_id, start_frame) - 1 AS n FROM segment)
        WHERE capture_id = c AND start_frame = f;
    ALTER TABLE segment_score RENAME TO present_score;
    CREATE TABLE segment_score AS SELECT ordinal, scores[from_here : from_here + n - 1] AS scores,
        run_id FROM (SELECT s.ordinal, t.scores, s.run_id, n_symbols AS n,
            1 + n_symbols * (ordinal - min(ordinal) OVER (PARTITION BY capture_id)) AS from_here
            FROM segment s JOIN present_score t USING (capture_id), learning);
    CREATE TABLE segment_movement AS SELECT ordinal, [0.5::FLOAT] AS movement, run_id FROM segment;
    DROP TABLE present_score;
    DELETE FROM meta WHERE key = 'segment_revision';
    UPDATE meta SET value = '4' WHERE key = 'schema';
"""  # From the tables of version 5 to those of version 4


def test_segments_of_version_4_come_to_today(database: store.Store, samples: ModuleType) -> None:
    for name in ("a", "bb"):
        samples.add(database, name)
    infos = store.load_captures(database)
    learning = samples.learning(infos, store.start_run(database, "learn"))
    store.save_learning(database, learning)
    database.close()
    with duckdb.connect(str(database.path)) as older:
        older.execute(_WITHOUT_PLACES + _FORMER_SEGMENTS)
    content, beside = database.path.read_bytes(), sorted(database.path.parent.iterdir())
    for is_others in (True, False):  # first as the file of somebody else
        with store.open_store(database.path, read_only=True, is_others=is_others) as newer:
            samples.assert_equal(store.load_segments(newer), learning.segments)
            assert store.check_store(newer, sources=True) == []
            assert store.check_quickly(newer) == []
        assert (database.path.read_bytes() == content) == is_others
        assert sorted(database.path.parent.iterdir()) == beside
        assert newer.notes == (
            []
            if is_others
            else [
                f"{database.path}: brought up to date from schema 4 to {TODAY}; earlier versions "
                "of motiondb cannot read it now"
            ]
        )
    assert check_file(database.path) == []


def test_an_older_file_of_somebody_else_is_read_with_its_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, copy = tmp_path / "m.duckdb", tmp_path / "copy.duckdb"
    with store.open_store(path) as database:
        store.save_synonyms(database, {"jog": "run"})
        for file in (path, log_of(path)):  # as a kill leaves them
            shutil.copy(file, tmp_path / file.name.replace("m.", "copy."))
    _add_a_version(monkeypatch, "CREATE TABLE later (x BIGINT);")
    with store.open_store(copy, read_only=True, is_others=True) as opened:
        assert store.load_synonyms(opened) == {"jog": "run"}
        assert not opened.lacked_log
    log_of(copy).unlink()
    with store.open_store(copy, read_only=True, is_others=True) as opened:
        assert opened.lacked_log


def test_an_older_file_that_cannot_be_written_is_told_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    _add_a_version(monkeypatch, "CREATE TABLE later (x BIGINT);")
    connect = opening.connect

    def reads_only(path: Path, read_only: bool, wait: float = 0.0) -> duckdb.DuckDBPyConnection:
        if read_only:
            return connect(path, read_only, wait)
        raise StoreError("cannot be opened") from duckdb.IOException("Permission denied")

    monkeypatch.setattr(opening, "connect", reads_only)
    with pytest.raises(StoreError) as error:
        store.open_store(path, read_only=True).connection.execute("SELECT 1")
    assert str(error.value) == (
        f"{path}: expected a schema of version {TODAY + 1}, found one of version {TODAY}, which "
        "this user may not bring up to date. Open it once with the right to write to it and its "
        "folder, or copy it."
    )


def test_a_failing_migration_leaves_the_version_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with store.open_store(tmp_path / "m.duckdb") as database:
        _add_a_version(monkeypatch, "CREATE TABLE later (x BIGINT); SELECT nothing;")
        with pytest.raises(StoreError, match='Referenced column "nothing"'):
            migrations.migrate(database.connection, TODAY)
        assert "later" not in store.count_rows(database)
        assert migrations.schema_version(database.connection, "") == TODAY


def test_a_newer_database_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    with store.open_store(path) as database:
        database.connection.execute("UPDATE meta SET value = '12' WHERE key = 'schema'")
        database.connection.execute("UPDATE meta SET value = '3.1' WHERE key = 'created_by'")
    for read_only in (False, True):
        with pytest.raises(StoreError) as error:
            store.open_store(path, read_only=read_only)
        assert str(error.value) == (
            f"{path}: expected a schema of version {TODAY} or below, which motiondb "
            f"{migrations.motiondb_version()} reads, found version 12, written by motiondb 3.1. "
            "Install that version of motiondb or a newer one."
        )


@pytest.mark.parametrize("change", ["key = 'schema_version'", "value = '3'"])
def test_a_database_of_an_unreleased_version_is_refused(tmp_path: Path, change: str) -> None:
    path = tmp_path / "m.duckdb"
    with store.open_store(path) as database:
        database.connection.execute(f"UPDATE meta SET {change} WHERE key = 'schema'")
    with pytest.raises(StoreError) as error:
        store.open_store(path)
    assert str(error.value) == (
        f"{path}: expected a database of motiondb 0.1.0 or later, found one of a version that was "
        "never released. Add the captures again to a new file: "
        "motiondb add FOLDER --db NEW.duckdb."
    )


def test_another_programs_database_is_refused_and_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    with duckdb.connect(str(path)) as other:
        other.execute("CREATE TABLE orders (x INT)")
    with pytest.raises(StoreError) as error:
        store.open_store(path)
    assert str(error.value) == (
        f"{path}: expected a database of motiondb, found another program's with the tables "
        "orders. Name another file with --db."
    )
    with duckdb.connect(str(path)) as other:
        assert other.execute("SELECT table_name FROM duckdb_tables()").fetchall() == [("orders",)]
