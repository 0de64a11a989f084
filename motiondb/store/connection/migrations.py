"""Make the tables of a new database, and bring an older one to the present schema, forward only.

A new database is made by ``motiondb.schema/schema.sql``. The numbered files beside it change an
older one: ``0002_WHAT.sql`` leads from version 1 to version 2. Each step runs in one transaction
with the new value of ``schema`` in the table ``meta``, so that a killed migration leaves the
version before it.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib import metadata, resources
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from motiondb.errors import StoreError
from motiondb.records import Float32Array
from motiondb.store.poses import POSE_SIZE, pack_poses


@cache
def present_schema() -> str:
    """The text of ``schema.sql``, which makes the tables of the newest version."""
    return (resources.files("motiondb.schema") / "schema.sql").read_text(encoding="utf-8")


@cache
def known_migrations() -> tuple[str, ...]:
    """The SQL texts that change older databases: number n leads from version n + 1 to n + 2."""
    folder = resources.files("motiondb.schema")
    files = [item for item in folder.iterdir() if item.name[:4].isdecimal()]
    return tuple(
        item.read_text(encoding="utf-8") for item in sorted(files, key=lambda item: item.name)
    )


def newest_version() -> int:
    """The version of the tables that ``schema.sql`` makes."""
    return 1 + len(known_migrations())


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
    if row is None:  # versions before 0.1.0 wrote other tables and another key
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
        marks = {f"{kind}_revision": uuid.uuid4().hex for kind in ("motion", "content")}
        text = present_schema()
        marks |= {"next_capture_id": "1", "revision": "0", "log": ""}
        _run(connection, text, newest_version(), None, **marks)
        return
    for number, text in enumerate(known_migrations()[version - 1 :], start=version + 1):
        _run(connection, text, number, _THEN.get(number))


FRAME_SCHEMAS = (
    "SELECT schema_name FROM duckdb_tables() WHERE table_name = 'motion_frame' "
    "AND database_name = current_database()"
)  # Where motions are a row a frame, as before version 4: "main", and the trash
FRAMES = "SELECT frame, pose FROM {}.motion_frame WHERE capture_id = ? ORDER BY frame"


def poses_of_frames(columns: dict[str, NDArray[Any]]) -> Float32Array:
    """The poses (frames, 87) of a motion that is a row a frame; ValueError where one lacks."""
    frames, poses = columns["frame"], list(columns["pose"])
    if not np.array_equal(frames, np.arange(len(frames))):
        raise ValueError("a motion that lacks frames.")
    if any(np.shape(pose) != (POSE_SIZE,) for pose in poses):
        raise ValueError("a motion with incomplete frames.")
    return np.array(poses, np.float32).reshape(-1, POSE_SIZE)


def _pack_motions(connection: duckdb.DuckDBPyConnection) -> None:
    """Pack the motions of a file that has a row a frame, also those in the trash."""
    for (schema,) in connection.execute(FRAME_SCHEMAS).fetchall():
        frames, motions = f"{schema}.motion_frame", f"{schema}.motion"
        connection.execute(f"CREATE TABLE IF NOT EXISTS {motions} AS FROM main.motion LIMIT 0")
        numbers = connection.execute(f"SELECT DISTINCT capture_id FROM {frames}").fetchall()
        for (number,) in numbers:
            read = connection.execute(FRAMES.format(schema), [number])
            poses = poses_of_frames(read.fetchnumpy())
            connection.execute(
                f"INSERT INTO {motions} VALUES (?, ?, ?)", [number, len(poses), pack_poses(poses)]
            )
        connection.execute(f"DROP TABLE {frames}")


_THEN = {4: _pack_motions}  # What SQL cannot say, after the text that leads to a version


def _run(
    connection: duckdb.DuckDBPyConnection,
    text: str,
    version: int,
    then: Callable[[duckdb.DuckDBPyConnection], None] | None,
    **marks: str,
) -> None:
    """Run SQL and what follows, and save version and other marks, in one transaction."""
    connection.execute("BEGIN")
    try:
        connection.execute(text)
        if then is not None:
            then(connection)
        marks |= {"schema": str(version), "created_by": motiondb_version()}
        for key, value in marks.items():
            connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", [key, value])
        connection.execute("COMMIT")
    except BaseException:
        with suppress(duckdb.Error):  # the first error is the cause
            connection.execute("ROLLBACK")
        raise
