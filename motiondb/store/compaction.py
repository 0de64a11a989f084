"""Copies of a database: without the space that removed rows left, and beside its use."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import duckdb

from motiondb.errors import QueryError, StoreError
from motiondb.files import safe_files
from motiondb.store.catalogue import parquet_files
from motiondb.store.catalogue.runs import empty_trash
from motiondb.store.connection import log_mark
from motiondb.store.connection.faults import first_sentence, is_damage
from motiondb.store.connection.handle import Store, limit_memory
from motiondb.store.connection.opening import is_lock, open_store
from motiondb.store.connection.statements import Connection
from motiondb.store.connection.transactions import transaction
from motiondb.store.moving import Progress, check_place, find_place, move_motions


@dataclass(frozen=True)
class Compacted:
    """The size of a database file, bytes, and what became of motions, originals and scores."""

    before: int
    after: int
    moved: int  # Captures whose motions and originals, or scores, were moved
    unused: tuple[str, ...]  # Parquet files that this database no longer relies on
    notes: tuple[str, ...]  # What else was done to the file


def compact(
    path: str | Path,
    *,
    wait: float = 0.0,
    motions_to: str | None = None,
    progress: Progress | None = None,
) -> Compacted:
    """Empty the trash, move motions if asked (:mod:`moving`), and replace the file by a copy."""
    # Other processes may read the file meanwhile, but not write: it is held open for reading until
    # the copy has taken its place, so that no change can be lost. A kill leaves the old file, and a
    # copy that the next command deletes.
    safe_files.check_file_name(Path(path))
    path = safe_files.link_target(Path(path))
    place = None if motions_to is None else find_place(motions_to)  # before the trash is emptied
    try:
        safe_files.check_one_name(path)
    except OSError as error:
        raise StoreError(f"{path}: expected one name to replace, found {error.strerror}.") from None
    new = safe_files.beside(path, safe_files.COPY)
    with open_store(path, create=False, wait=wait) as store:  # brings the log into the file
        if store.lacked_log:  # the copy would no longer fit to the log
            raise StoreError(store.log_note)
        before = path.stat().st_size
        moved, unused = _prepare(store, place, progress)
        notes = tuple(store.notes)
    identity = _identity(path)
    with open_store(path, read_only=True, wait=wait) as store:
        if safe_files.log_of(path).exists():
            raise StoreError(
                f"{path}: expected all changes in the file, found some in the log beside it "
                f"({path.name}.wal): another program is writing, or the disk has no room to bring "
                "them in. Wait until it has ended, and look at the disk."
            )
        limit_memory(store)
        attach(store, new, "compacted")  # from here on no other process compacts
        try:
            if _identity(path) != identity:
                raise StoreError(
                    f"{path}: expected the file that was opened, found that another program put "
                    "one in its place. Nothing was changed; run the command again."
                )
            copy_tables(store, "compacted")
            store.connection.execute("DETACH compacted")
            if safe_files.log_of(new).exists():  # what it holds would be missing
                raise StoreError(
                    f"{path}: expected room for a copy beside it, found too little. "
                    "Nothing was changed; look at the disk."
                )
            if os.name == "nt":  # there, a file that is open cannot be replaced
                store.close()
            new.replace(path)
        except (StoreError, duckdb.Error) as error:
            cause = error if isinstance(error, duckdb.Error) else error.__cause__
            if not isinstance(cause, duckdb.Error) or is_damage(cause):
                raise
            raise StoreError(_no_room(path, new, cause)) from error
        except OSError as error:
            raise StoreError(_no_room(path, new, error)) from error
        finally:
            safe_files.delete_all(new, safe_files.log_of(new))
    _forget_told(path, unused, wait)
    return Compacted(before, path.stat().st_size, moved, tuple(unused), notes)


def _prepare(store: Store, place: str | None, progress: Progress | None) -> tuple[int, list[str]]:
    """Empty the trash and move motions; how many captures, and the Parquet files not needed now."""
    if place is not None:
        check_place(store, place)
    empty_trash(store)
    if store.loss_note:
        with transaction(store) as connection:
            connection.execute(log_mark.FORGET_LOSS)
    for kind in parquet_files.KINDS:
        parquet_files.forget_unused(store, kind)
    moved = move_motions(store, place, progress) if place else 0
    return moved, parquet_files.untold_files(store)


def _forget_told(path: Path, unused: Sequence[str], wait: float) -> None:
    """Forget the unused Parquet files, which are told now; else they are told once more."""
    if unused:
        with suppress(StoreError), open_store(path, create=False, wait=wait) as store:
            parquet_files.forget_untold(store)


def _identity(path: Path) -> tuple[int, int]:
    """Return what tells a file from one that takes its name later: its device and its number."""
    status = path.stat()
    return status.st_dev, status.st_ino


def attach(store: Store, new: Path, alias: str) -> None:
    """Make the copy's file and attach it, which keeps every other process from it."""
    target = safe_files.plain_name(new).replace("'", "''")
    try:
        store.connection.execute(f"ATTACH '{target}' AS {alias} (READ_WRITE)")
    except (StoreError, duckdb.Error) as error:
        cause = error if isinstance(error, duckdb.Error) else error.__cause__
        if isinstance(cause, duckdb.Error) and is_lock(cause):
            raise StoreError(
                f"{store.path}: expected no other process that compacts it, found one at work. "
                "Nothing was changed; wait until it has ended."
            ) from error
        if isinstance(cause, duckdb.PermissionException):  # it has shut DuckDB for both
            raise StoreError(
                f"{store.path}: expected no other part of this program that reads it while it is "
                "copied, found one. Close that first."
            ) from error
        raise StoreError(_no_room(store.path, new, cause or error)) from error


def _no_room(path: Path, new: Path, cause: BaseException) -> str:
    """What to say when the copy cannot be written."""
    return (
        f"{path}: expected room for a copy in {new.parent}, found: {first_sentence(cause)} "
        "Nothing was changed; look at the folder's permissions and at the disk."
    )


def backup(store: Store, path: Path, check: Callable[[Path], Sequence[str]]) -> None:
    """Copy one state into a new file, which gets its name when `check` finds no faults in it."""
    safe_files.check_file_name(path)
    if path.exists():
        raise QueryError(f"{path} already exists. Choose another name.")
    if not path.absolute().parent.is_dir():
        raise StoreError(
            f"{path}: expected a folder that is there, found none. Make it, or give another name."
        )
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        raise StoreError(_no_room(store.path, path, PermissionError("no right to write there.")))
    if store.lacked_log:  # the copy would not say so
        raise StoreError(store.log_note)
    safe_files.sweep_databases(path.absolute().parent)
    with safe_files.output_file(path, StoreError) as draft, store.may_make(draft):
        attach(store, draft, "backup_file")
        try:
            copy_tables(store, "backup_file")
        finally:
            store.connection.execute("DETACH backup_file")
        if safe_files.log_of(draft).exists():  # what it holds would be missing
            raise StoreError(
                f"{path}: expected room for a copy, found too little. Nothing was written; look "
                "at the disk."
            )
        known = store.loss_note.replace(str(store.path), str(draft))  # the copy says so, too
        faults = [fault for fault in check(draft) if fault != known]
        if faults:
            told = "\n".join(faults).replace(str(draft), str(path))
            raise StoreError(
                f"{path}: expected a copy without faults, found:\n{told}\nNothing was written."
            )


def unused_bytes(store: Store) -> int:
    """Return how many bytes of the file hold nothing; ``compact`` gives back about as many."""
    query = "SELECT free_blocks * block_size FROM pragma_database_size()"
    return int(store.connection.value(f"{query} WHERE database_name = current_database()") or 0)


def count_rows(store: Store) -> dict[str, int]:
    """Count the rows of every table, by name."""
    return _count(store.connection, "current_database()")


def copy_tables(store: Store, alias: str) -> None:
    """Copy one state of everything into an attached file, and compare the numbers of rows."""
    connection = store.connection
    source = str(connection.value("SELECT current_database()")).replace('"', '""')
    with store.in_use():
        connection.execute("BEGIN")
        try:
            connection.execute(f'COPY FROM DATABASE "{source}" TO {alias}')
            expected, copied = count_rows(store), _count(connection, f"'{alias}'")
            connection.execute(f"UPDATE {alias}.main.meta SET value = '' WHERE key = 'log'")
            connection.execute("COMMIT")
        except BaseException:
            with suppress(StoreError):  # the first error is the cause
                connection.execute("ROLLBACK")
            raise
    if copied != expected:
        raise StoreError(
            f"{store.path}: expected a copy with as many rows in every table, found {copied} for "
            f"{expected}. The old file was kept; look at the disk."
        )


def _count(connection: Connection, database: str) -> dict[str, int]:
    tables = connection.execute(
        "SELECT database_name, schema_name, table_name FROM duckdb_tables() "
        f"WHERE database_name = {database} ORDER BY schema_name, table_name"
    ).fetchall()
    counts: dict[str, int] = {}
    for name, schema, table in tables:
        name = str(name).replace('"', '""')
        counted = connection.value(f'SELECT count(*) FROM "{name}".{schema}."{table}"')
        counts[table if schema == "main" else f"{schema}.{table}"] = int(counted)
    return counts
