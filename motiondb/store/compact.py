"""Rewriting the file without the room that removed rows left behind."""

from __future__ import annotations

import os
from pathlib import Path

import duckdb

from motiondb.errors import StoreError
from motiondb.store.connection import Store, first_sentence, open_store


def compact(path: str | Path) -> tuple[int, int]:
    """Copy the database into a new file, check it, and put it in the old one's place.

    Nobody may have the file open. A kill in between leaves the old file.

    Returns
    -------
    before, after : sizes, bytes.

    Raises
    ------
    StoreError : the file cannot be opened, or the disk has no room for the copy.
    """
    path = Path(path)
    new = path.with_name(f".{path.name}.compact-{os.getpid()}")
    new.unlink(missing_ok=True)
    try:
        with open_store(path, create=False) as store:
            _copy(store, new)
        before = path.stat().st_size
        new.replace(path)
    except duckdb.Error as error:
        raise StoreError(
            f"{path}: expected room for a copy beside it, found: {first_sentence(error)} "
            "The old file was kept; look at the disk."
        ) from error
    finally:
        new.unlink(missing_ok=True)
    return before, path.stat().st_size


def _copy(store: Store, new: Path) -> None:
    connection = store.connection
    row = connection.execute("SELECT current_database()").fetchone()
    source = str(row[0]) if row else ""
    quoted, target = source.replace('"', '""'), str(new).replace("'", "''")
    connection.execute("CHECKPOINT")
    connection.execute(f"ATTACH '{target}' AS compacted")
    connection.execute(f'COPY FROM DATABASE "{quoted}" TO compacted')
    for table in count_rows(store):
        pair = [
            connection.execute(f'SELECT count(*) FROM {database}.main."{table}"').fetchone()
            for database in (f'"{quoted}"', "compacted")
        ]
        if pair[0] != pair[1]:
            raise StoreError(
                f"{store.path}: expected {pair[0]} rows of {table} in the copy, found {pair[1]}. "
                "The old file was kept; look at the disk."
            )
    connection.execute("DETACH compacted")


def count_rows(store: Store) -> dict[str, int]:
    """Number of rows of every table, by name."""
    tables = store.connection.execute(
        "SELECT table_name FROM duckdb_tables() WHERE database_name = current_database() "
        "ORDER BY table_name"
    ).fetchall()
    counts: dict[str, int] = {}
    for (table,) in tables:
        row = store.connection.execute(f'SELECT count(*) FROM "{table}"').fetchone()
        counts[table] = int(row[0]) if row else 0
    return counts
