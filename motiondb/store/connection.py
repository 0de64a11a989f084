"""Opening the file, transactions, and what can go wrong with either.

One process may write, or several may read. A new database is built under another name and moved
into place, so that a kill in between never leaves half a file under the name the user gave.
"""

from __future__ import annotations

import glob
import os
import re
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar

import duckdb

from motiondb.errors import StoreError
from motiondb.store import migrations

_CONFIG: dict[str, Any] = {
    "autoinstall_known_extensions": False,
    "autoload_known_extensions": False,
}
_ABANDONED = 60.0
"""Seconds after which a half-made new file has no maker."""


class Store:
    """An open database file. Close it, or use it in a ``with`` statement.

    Attributes
    ----------
    path : the file. connection : for the functions of ``motiondb.store``. read_only : whether
        writing is refused. changes_saved : transactions that this process has saved, in all stores.
    """

    changes_saved: ClassVar[int] = 0

    def __init__(self, path: Path, connection: duckdb.DuckDBPyConnection, read_only: bool) -> None:
        self.path = path
        self.connection = connection
        self.read_only = read_only
        self.in_transaction = False
        self.changed: set[str] = set()

    def close(self) -> None:
        """Let go of the file; a second call does nothing."""
        self.connection.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def open_store(path: str | Path, *, read_only: bool = False, create: bool = True) -> Store:
    """Open the database file at ``path``, bringing an older one up to date.

    Parameters
    ----------
    read_only : other readers may have the file open at the same time.
    create : make a new database where there is no file (never when ``read_only``).

    Raises
    ------
    StoreError : no such file, not a database of motiondb, one of a newer motiondb, or the file is
        held by another process, which is named.
    """
    path = Path(path)
    if not path.exists() or (path.is_file() and path.stat().st_size == 0):
        if read_only or not create:
            found = "an empty file" if path.exists() else "no such file"
            raise StoreError(
                f"{path}: expected a database of motiondb, found {found}. "
                f"Make one: motiondb add FOLDER --db {path}."
            )
        _create(path)
    connection = _connect(path, read_only)
    try:
        version = migrations.schema_version(connection, str(path))
        migrations.check_not_newer(connection, str(path), version)
        if version < len(migrations.known_migrations()):
            if read_only:
                connection.close()
                open_store(path).close()
                return open_store(path, read_only=True)
            migrations.migrate(connection, version)
    except duckdb.Error as error:
        connection.close()
        raise StoreError(_unreadable(path, error)) from error
    except BaseException:
        connection.close()
        raise
    return Store(path, connection, read_only)


@contextmanager
def transaction(store: Store) -> Iterator[duckdb.DuckDBPyConnection]:
    """All or nothing: commit at the end of the block, undo on any exception.

    Inside another transaction the block becomes part of that one.

    Raises
    ------
    StoreError : the store was opened for reading, or DuckDB refuses (a full disk, for example).
    """
    if store.read_only:
        raise StoreError(
            f"{store.path}: expected a database opened for writing, found one opened for reading."
            " Open it without read_only."
        )
    if store.in_transaction:
        yield store.connection
        return
    store.connection.execute("BEGIN")
    store.in_transaction = True
    try:
        yield store.connection
        for key in store.changed:
            write_meta(store, key, uuid.uuid4().hex)
        store.connection.execute("COMMIT")
        Store.changes_saved += 1
    except BaseException as error:
        try:
            store.connection.execute("ROLLBACK")
        except duckdb.Error:  # no transaction any more: a failed COMMIT has undone everything,
            if not isinstance(error, duckdb.Error):  # or an interrupt came just after it was saved
                Store.changes_saved += 1
        if isinstance(error, duckdb.Error):
            raise StoreError(
                f"{store.path}: expected to save the change, found: {first_sentence(error)} "
                "Nothing was changed."
            ) from error
        raise
    finally:
        store.in_transaction = False
        store.changed.clear()


def read_meta(store: Store, key: str) -> str:
    """The value of ``key`` in the table ``meta``."""
    row = store.connection.execute("SELECT value FROM meta WHERE key = ?", [key]).fetchone()
    if row is None:
        raise StoreError(
            f"{store.path}: expected {key!r} in the table meta, found nothing. "
            "The file was changed by hand: restore a copy."
        )
    return str(row[0])


def content_revision(store: Store) -> str:
    """A mark that is new with every change of captures, of their words, or of synonyms."""
    return read_meta(store, "content_revision")


def write_meta(store: Store, key: str, value: str) -> None:
    """Set the value of an existing ``key`` in the table ``meta``."""
    with transaction(store) as connection:
        connection.execute("UPDATE meta SET value = ? WHERE key = ?", [value, key])


def touch(store: Store, *, motions: bool = False) -> None:
    """Mark, when the transaction commits, that what can be learnt from has changed.

    ``motions``: that motions have changed, too, so that arrays cached from them are stale.
    """
    with transaction(store):
        store.changed |= (
            {"content_revision", "motion_revision"} if motions else {"content_revision"}
        )


def _create(path: Path) -> None:
    """Build an empty database beside ``path`` and move it there, unless another was quicker."""
    new = path.with_name(f".{path.name}.new-{os.getpid()}")
    if not path.parent.is_dir():
        raise StoreError(
            f"{path}: expected the folder {path.parent}, found none. Make the folder first."
        )
    for left in path.parent.glob(f".{glob.escape(path.name)}.new-*"):  # by a kill
        if left == new or time.time() - left.stat().st_mtime > _ABANDONED:
            left.unlink(missing_ok=True)
    connection = _connect(new, read_only=False, named=path)
    try:
        migrations.migrate(connection, 0)
    finally:
        connection.close()
    if not path.exists() or path.stat().st_size == 0:
        new.replace(path)
    new.unlink(missing_ok=True)


def _connect(path: Path, read_only: bool, named: Path | None = None) -> duckdb.DuckDBPyConnection:
    try:
        return duckdb.connect(str(path), read_only=read_only, config=_CONFIG)
    except duckdb.Error as error:
        raise StoreError(_unreadable(named or path, error)) from error


def _unreadable(path: Path, error: duckdb.Error) -> str:
    """DuckDB's message as a sentence of ours."""
    text = str(error)
    if "Could not set lock" in text:
        holder = re.search(r"held in (\S+) \(PID (\d+)\)", text)
        who = f"process {holder[2]} ({Path(holder[1]).name})" if holder else "another process"
        return f"{path}: expected a free database, found it held by {who}. Wait until it has ended."
    if "different configuration" in text:
        return (
            f"{path}: expected a free database, found it held by this process ({os.getpid()}) "
            "in another mode. Close it first."
        )
    if "not a valid DuckDB" in text or "Is a directory" in text:
        found = "a folder" if path.is_dir() else "another kind of file"
        return (
            f"{path}: expected a database of motiondb, found {found}. Name another file with --db."
        )
    return (
        f"{path}: expected a database that can be opened, found: {first_sentence(error)} "
        "Look at the file's permissions and at the disk; if it is damaged, restore a copy."
    )


def first_sentence(error: duckdb.Error) -> str:
    """DuckDB's message up to the first stop."""
    text = re.split(r"(?<=\w)[.!] |\n", str(error))[0].rstrip(".!")
    return f"{text}."
