"""Read every column of every table, and compare the tables with ``schema.sql``."""

from __future__ import annotations

from functools import cache
from importlib import resources

import duckdb

from motiondb.errors import StoreError
from motiondb.store.connection.handle import Store

Columns = tuple[tuple[str, str, bool], ...]
"""Of a table, in order: name, type, whether NULL is allowed."""

_COLUMNS = (
    "SELECT table_name, column_name, data_type, is_nullable FROM duckdb_columns() "
    "WHERE NOT internal AND database_name = current_database() AND schema_name = 'main' "
    "ORDER BY table_name, column_index"
)


@cache
def expected_tables() -> dict[str, Columns]:
    """The tables of ``schema.sql``: name -> columns."""
    text = (resources.files("motiondb.schema") / "schema.sql").read_text(encoding="utf-8")
    with duckdb.connect() as connection:
        connection.execute(text)
        return _to_tables(connection.execute(_COLUMNS).fetchall())


def wrong_tables(store: Store) -> list[str]:
    """A sentence for every table that differs from ``schema.sql``; others are not looked at."""
    columns_of = _to_tables(store.connection.execute(_COLUMNS).fetchall())
    faults = []
    for table, columns in expected_tables().items():
        if table not in columns_of:
            faults.append(
                f"{store.path}: expected the table {table} as in schema.sql, found none. "
                "The file was changed by another program: restore a copy."
            )
        elif columns_of[table] != columns:
            faults.append(
                f"{store.path}: expected the table {table} with the columns {_listed(columns)} as "
                f"in schema.sql, found {_listed(columns_of[table])}. "
                "The file was changed by another program: restore a copy."
            )
    return faults


def unreadable_columns(store: Store) -> dict[str, list[str]]:
    """Table -> its columns that cannot be read to the end; tables without any are left out."""
    connection = store.connection
    damaged = {}
    for table, columns in _to_tables(connection.execute(_COLUMNS).fetchall()).items():
        names = [name for name, _type, _null in columns]
        if not _is_readable(store, table, names):
            wrong = [name for name in names if not _is_readable(store, table, [name])]
            damaged[table] = wrong or names
    return damaged


def _is_readable(store: Store, table: str, columns: list[str]) -> bool:
    """Whether every value of some columns can be read; each goes into a hash."""
    hashes = ", ".join(f'bit_xor(hash("{column}"))' for column in columns)
    try:
        store.connection.execute(f'SELECT {hashes} FROM "{table}"').fetchall()
    except StoreError:
        return False
    return True


def _to_tables(rows: list[tuple[str, str, str, bool]]) -> dict[str, Columns]:
    tables: dict[str, list[tuple[str, str, bool]]] = {}
    for table, *column in rows:
        name, kind, nullable = column
        tables.setdefault(table, []).append((str(name), str(kind), bool(nullable)))
    return {table: tuple(columns) for table, columns in tables.items()}


def _listed(columns: Columns) -> str:
    return ", ".join(f"{name} {kind}" for name, kind, _null in columns)
