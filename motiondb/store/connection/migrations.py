"""Bring a database to the present schema by numbered SQL files, forward only.

Each file of ``motiondb.schema.migrations`` runs in one transaction, together with the new value of
``schema_version``, so that a killed migration leaves the version before it. A file that databases
have used never changes; a test compares digests.
"""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from importlib import metadata, resources

import duckdb

from motiondb.errors import StoreError


@cache
def known_migrations() -> tuple[str, ...]:
    """Read the SQL texts of all migrations, in order; number n has the index n - 1."""
    folder = resources.files("motiondb.schema.migrations")
    files = sorted(
        (item for item in folder.iterdir() if item.name.endswith(".sql")), key=lambda i: i.name
    )
    return tuple(item.read_text(encoding="utf-8") for item in files)


@cache
def motiondb_version() -> str:
    """The version of this motiondb, such as "0.1.0"."""
    return metadata.version("motiondb")


def schema_version(connection: duckdb.DuckDBPyConnection, where: str) -> int:
    """Read the schema version of an open database; 0 for one without tables."""
    names = [
        row[0] for row in connection.execute("SELECT table_name FROM duckdb_tables()").fetchall()
    ]
    if not names:
        return 0
    if "meta" in names:
        row = connection.execute("SELECT value FROM meta WHERE key = 'schema_version'").fetchone()
        if row is not None:
            if not str(row[0]).isdecimal():
                raise StoreError(
                    f"{where}: expected a number for the version of its schema, found {row[0]!r}. "
                    "The file was changed by hand: restore a copy."
                )
            return int(row[0])
    raise StoreError(
        f"{where}: expected a database of motiondb, found another program's with the tables "
        f"{', '.join(sorted(names)[:5])}. Name another file with --db."
    )


def check_not_newer(connection: duckdb.DuckDBPyConnection, where: str, version: int) -> None:
    """Refuse a database whose schema this motiondb does not know."""
    newest = len(known_migrations())
    if version <= newest:
        return
    row = connection.execute("SELECT value FROM meta WHERE key = 'created_by'").fetchone()
    writer = f"motiondb {row[0]}" if row else "a newer motiondb"
    raise StoreError(
        f"{where}: expected a schema of version {newest} or below, which motiondb "
        f"{motiondb_version()} reads, found version {version}, written by {writer}. "
        "Install that version of motiondb or a newer one."
    )


def migrate(
    connection: duckdb.DuckDBPyConnection, version: int, migrations: Sequence[str] | None = None
) -> None:
    """Bring an open database to the newest schema, one transaction for each step."""
    migrations = known_migrations() if migrations is None else migrations
    for number in range(version + 1, len(migrations) + 1):
        connection.execute("BEGIN")
        try:
            connection.execute(migrations[number - 1])
            _stamp(connection, number)
            connection.execute("COMMIT")
        except BaseException:
            with suppress(duckdb.Error):  # the first error is the cause
                connection.execute("ROLLBACK")
            raise


def _stamp(connection: duckdb.DuckDBPyConnection, version: int) -> None:
    values = {"schema_version": str(version), "created_by": motiondb_version()}
    if version == 1:
        values |= {"next_capture_id": "1"}
        values |= {f"{kind}_revision": uuid.uuid4().hex for kind in ("motion", "content")}
    for key, value in values.items():
        connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", [key, value])
