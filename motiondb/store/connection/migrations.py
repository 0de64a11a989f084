"""Make the tables of a new database, and bring an older one to the present schema, forward only.

A new database is made by ``motiondb.schema/schema.sql``. Numbered files beside it change an older
one: ``0005_WHAT.sql`` leads from version 4, the first that is released, to version 5. Each step
runs in one transaction with the new value of ``schema`` in the table ``meta``, so that a killed
migration leaves the version before it.
"""

from __future__ import annotations

import uuid
from contextlib import suppress
from functools import cache
from importlib import metadata, resources

import duckdb

from motiondb.errors import StoreError

FIRST = 4  # Version of the tables of motiondb 0.1.0; those before were never released


@cache
def present_schema() -> str:
    """The text of ``schema.sql``, which makes the tables of the newest version."""
    return (resources.files("motiondb.schema") / "schema.sql").read_text(encoding="utf-8")


def rules_text() -> str:
    """The text of ``rules.sql``, which says what a sound database never holds."""
    return (resources.files("motiondb.schema") / "rules.sql").read_text(encoding="utf-8")


@cache
def known_migrations() -> tuple[str, ...]:
    """The SQL texts that change older databases, one a version from ``FIRST`` on."""
    folder = resources.files("motiondb.schema")
    files = [item for item in folder.iterdir() if item.name[:4].isdecimal()]
    return tuple(
        item.read_text(encoding="utf-8") for item in sorted(files, key=lambda item: item.name)
    )


def newest_version() -> int:
    """The version of the tables that ``schema.sql`` makes."""
    return FIRST + len(known_migrations())


@cache
def motiondb_version() -> str:
    """The version of this motiondb, such as "0.1.0"."""
    return metadata.version("motiondb")


def schema_version(connection: duckdb.DuckDBPyConnection, where: str) -> int:
    """The version of an open database, 0 without tables; one that cannot be read is refused."""
    names = [
        row[0] for row in connection.execute("SELECT table_name FROM duckdb_tables()").fetchall()
    ]
    if not names:
        return 0
    if "meta" not in names:
        raise StoreError(
            f"{where}: expected a database of motiondb, found another program's with the tables "
            f"{', '.join(sorted(names)[:5])}. Name another file with --db."
        )
    row = connection.execute("SELECT value FROM meta WHERE key = 'schema'").fetchone()
    # versions before 0.1.0 wrote other tables, and the earliest of them another key
    if row is None or (str(row[0]).isdecimal() and int(row[0]) < FIRST):
        raise StoreError(
            f"{where}: expected a database of motiondb 0.1.0 or later, found one of a version that "
            "was never released. Add the captures again to a new file: "
            "motiondb add FOLDER --db NEW.duckdb."
        )
    if not str(row[0]).isdecimal():
        raise StoreError(
            f"{where}: expected a number for the version of its schema, found {row[0]!r}. "
            "The file was changed by hand: restore a copy."
        )
    version, newest = int(row[0]), newest_version()
    if version > newest:
        row = connection.execute("SELECT value FROM meta WHERE key = 'created_by'").fetchone()
        writer = f"motiondb {row[0]}" if row else "a newer motiondb"
        raise StoreError(
            f"{where}: expected a schema of version {newest} or below, which motiondb "
            f"{motiondb_version()} reads, found version {version}, written by {writer}. "
            "Install that version of motiondb or a newer one."
        )
    return version


def migrate(connection: duckdb.DuckDBPyConnection, version: int) -> None:
    """Bring an open database from a version, 0 without tables, to the newest one."""
    if version == 0:
        marks = {f"{kind}_revision": uuid.uuid4().hex for kind in ("motion", "content", "segment")}
        text = present_schema()
        marks |= {"next_capture_id": "1", "revision": "0", "log": ""}
        _run(connection, text, newest_version(), **marks)
        return
    # DuckDB would write motions and files anew: a file of 40 hours grew to twice its size
    connection.execute("SET max_vacuum_tasks = 0")
    for number, text in enumerate(known_migrations()[version - FIRST :], start=version + 1):
        _run(connection, text, number)


def _run(
    connection: duckdb.DuckDBPyConnection,
    text: str,
    version: int,
    **marks: str,
) -> None:
    """Run SQL, and save version and other marks, in one transaction."""
    connection.execute("BEGIN")
    try:
        connection.execute(text)
        marks |= {"schema": str(version), "created_by": motiondb_version()}
        for key, value in marks.items():
            connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", [key, value])
        connection.execute("COMMIT")
    except BaseException:
        with suppress(duckdb.Error):  # the first error is the cause
            connection.execute("ROLLBACK")
        raise
