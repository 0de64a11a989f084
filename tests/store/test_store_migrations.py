"""schema.sql is the truth, the migrations lead to it, and versions are told apart."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import duckdb
import pytest

from motiondb import store
from motiondb.errors import StoreError
from motiondb.store.connection import migrations
from motiondb.store.grammars import grammars, scenes
from motiondb.store.learned import learning

_CATALOG = (
    "SELECT table_name, sql FROM duckdb_tables() ORDER BY ALL",
    "SELECT table_name, column_name, column_index, data_type, is_nullable, column_default "
    "FROM duckdb_columns() WHERE NOT internal ORDER BY ALL",
    "SELECT table_name, constraint_type, constraint_text FROM duckdb_constraints() ORDER BY ALL",
    "SELECT table_name, index_name, sql FROM duckdb_indexes() ORDER BY ALL",
    "SELECT view_name, sql FROM duckdb_views() WHERE NOT internal ORDER BY ALL",
    "SELECT sequence_name, sql FROM duckdb_sequences() ORDER BY ALL",
)


def _catalog(connection: duckdb.DuckDBPyConnection) -> list[list[tuple]]:
    return [connection.execute(query).fetchall() for query in _CATALOG]


def _schema() -> str:
    return (resources.files("motiondb.schema") / "schema.sql").read_text(encoding="utf-8")


def test_all_migrations_give_the_schema() -> None:
    with duckdb.connect() as migrated, duckdb.connect() as written:
        migrations.migrate(migrated, 0)
        written.execute(_schema())
        assert _catalog(migrated) == _catalog(written)
        assert len(_catalog(migrated)[0]) == 40


def test_every_table_stands_in_the_diagram() -> None:
    diagram = (resources.files("motiondb.schema") / "README.md").read_text(encoding="utf-8")
    with duckdb.connect() as written:
        written.execute(_schema())
        columns = written.execute(
            "SELECT table_name, column_name FROM duckdb_columns() WHERE NOT internal"
        ).fetchall()
    assert [pair for pair in columns if pair[0] not in diagram or pair[1] not in diagram] == []


def test_every_derived_row_names_its_run() -> None:
    with duckdb.connect() as written:
        written.execute(_schema())
        query = "SELECT table_name FROM duckdb_columns() WHERE column_name = 'run_id'"
        named = {row[0] for row in written.execute(query).fetchall()}
    assert named == {
        "run",
        "capture",
        *learning.DERIVED_TABLES,
        *grammars.TABLES,
        *scenes.TABLES,
    }


def test_a_later_migration_is_applied_once_to_an_older_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "m.duckdb"
    store.open_store(path).close()
    later = (*migrations.known_migrations(), "CREATE TABLE later (x BIGINT);")
    monkeypatch.setattr(migrations, "known_migrations", lambda: later)
    with store.open_store(path, read_only=True) as database:
        assert store.count_rows(database)["later"] == 0
        version = migrations.schema_version(database.connection, "")
    assert version == len(later)
    store.open_store(path).close()  # a second CREATE TABLE would be refused


def test_a_failing_migration_leaves_the_version_before(tmp_path: Path) -> None:
    with store.open_store(tmp_path / "m.duckdb") as database:
        bad = (*migrations.known_migrations(), "CREATE TABLE later (x BIGINT); SELECT nothing;")
        with pytest.raises(StoreError, match='Referenced column "nothing"'):
            migrations.migrate(database.connection, len(bad) - 1, bad)
        assert "later" not in store.count_rows(database)
        assert migrations.schema_version(database.connection, "") == len(bad) - 1


def test_a_newer_database_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    with store.open_store(path) as database:
        database.connection.execute("UPDATE meta SET value = '9' WHERE key = 'schema_version'")
        database.connection.execute("UPDATE meta SET value = '3.1' WHERE key = 'created_by'")
    for read_only in (False, True):
        with pytest.raises(StoreError) as error:
            store.open_store(path, read_only=read_only)
        assert str(error.value) == (
            f"{path}: expected a schema of version {len(migrations.known_migrations())} or below, "
            "which motiondb "
            f"{migrations.motiondb_version()} reads, found version 9, written by motiondb 3.1. "
            "Install that version of motiondb or a newer one."
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
