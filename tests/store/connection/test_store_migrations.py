"""schema.sql is the truth, the migrations lead to it, and versions are told apart."""

from __future__ import annotations

import hashlib
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


RELEASED = {
    "0001_first.sql": "ae8714bd5bd0d6e39ec6f9bf7be0067fac95475748d49150e250ae9ef6e7bb83",
    "0002_movement.sql": "7d879bbf21fbd82955254dcc70502922946efccc3ff60c0433ea170543ad9184",
    "0003_grammar.sql": "ababcd7df6b5ff51003c1782482a91023fe753320366491d48505e2833c070f5",
    "0004_event.sql": "eaf3c3c88fd8b181d52f292aebe21f5cfd666de78de93df1064b46842afc00b0",
    "0005_scene.sql": "a31994f98648f6dbce7460c4834e237102150653635a15ca7f87f4adebade9ed",
    "0006_scene_rule.sql": "9e7fed5fb3da28a464fc7d9b35b8450b24f5a322494be9de70c36751cc5a3e75",
    "0007_revision.sql": "d1acfc36df98ca6d29e9cafb535b919e7488fbb9ebbd943c968171977b1c4955",
}
"""SHA-256 of every migration. A new one gets a row; a row never changes, because databases have
used the text: write a further migration instead."""


def test_a_released_migration_never_changes() -> None:
    folder = resources.files("motiondb.schema.migrations")
    texts = {f.name: f.read_bytes() for f in folder.iterdir() if f.name.endswith(".sql")}
    assert {name: hashlib.sha256(text).hexdigest() for name, text in texts.items()} == RELEASED


def _early_scene_migrations() -> tuple[str, ...]:
    """The first five, the last as it was before it was edited (its table lacked two columns)."""
    first = migrations.known_migrations()[:5]
    early = first[4].replace("    about VARCHAR NOT NULL,\n    unit VARCHAR NOT NULL,\n", "")
    assert early != first[4]
    return (*first[:4], early)


@pytest.mark.parametrize("is_early", [True, False])
def test_a_database_of_the_edited_migration_is_repaired(is_early: bool) -> None:
    about, unit = ("", "") if is_early else ("ball", "m")
    with duckdb.connect() as repaired, duckdb.connect() as written:
        used = _early_scene_migrations() if is_early else migrations.known_migrations()[:5]
        migrations.migrate(repaired, 0, used)
        columns = "" if is_early else f"'{about}', '{unit}',"
        repaired.execute(
            f"INSERT INTO scene_rule VALUES (1, 0, 'p', 'a', 2, 'meet', {columns}"
            " 1.5, 2.5, 3.5, 4, true, 5)"
        )
        migrations.migrate(repaired, 5)
        written.execute(_schema())
        assert _catalog(repaired) == _catalog(written)
        assert repaired.execute("FROM scene_rule").fetchall() == [
            (1, 0, "p", "a", 2, "meet", about, unit, 1.5, 2.5, 3.5, 4, True, 5)
        ]
        repaired.execute("INSERT OR REPLACE INTO scene_rule SELECT * FROM scene_rule")


def test_a_repaired_file_is_sound(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "m.duckdb"
    early = _early_scene_migrations()
    with monkeypatch.context() as patched:
        patched.setattr(migrations, "known_migrations", lambda: early)
        with duckdb.connect(str(path)) as connection:
            migrations.migrate(connection, 0)
    with store.open_store(path, read_only=True) as database:  # migrates first
        assert store.check_store(database, sources=True) == []
        assert store.revision(database) == 0


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
