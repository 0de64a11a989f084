"""Transactions, snapshots for reading, and the revision that every committed change raises.

The row ``revision`` of the table ``meta`` is a number. A transaction raises it first thing. Two
connections of one process that write at the same time therefore conflict there, before either has
done any work, and the second waits. A stored revision also shows whether anything has changed
since.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import duckdb

from motiondb.errors import StoreError
from motiondb.store.connection.faults import damage_sentence, first_sentence, is_damage
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import Connection

_OTHER_WRITER = 60.0
"""Seconds to wait for another connection of this process that writes. Chosen by hand: the longest
transaction seen, an ``add`` of 2,000 captures, takes about 20."""
_PAUSE = 0.02  # Seconds between two attempts to begin


@contextmanager
def transaction(store: Store) -> Iterator[Connection]:
    """All or nothing: commit at the end of the block, undo on any exception.

    Inside another transaction of the same thread the block becomes part of that one. Threads and
    connections of one process take turns.
    """
    check_writable(store)
    if store.in_transaction:
        yield store.connection
        return
    if store.local.depth:  # before any lock: whoever holds it may wait for the end of this block
        raise StoreError(
            f"{store.path}: expected to change the database outside `reading`, found it inside."
            " Save after that block."
        )
    with store.write_lock, store.open_for_writing(), store.in_use():
        store.mark_log()
        _begin(store)
        store.local.in_transaction = True
        try:
            yield store.connection
            for key in store.local.changed:
                write_meta(store, key, uuid.uuid4().hex)
            store.stand_in_for_log()
            store.connection.execute("COMMIT")
            Store.changes_saved += 1
            store.keep_log()
        except BaseException as error:
            _undo(store, error)
            raise
        finally:
            store.local.in_transaction = False
            store.local.changed.clear()


def check_writable(store: Store) -> None:
    """Refuse a store that was opened for reading."""
    if store.read_only:
        raise StoreError(
            f"{store.path}: expected a database opened for writing, found one opened for reading."
            " Open it without read_only."
        )


@contextmanager
def reading(store: Store) -> Iterator[int]:
    """One state of the database for all loads in the block, even if others save changes meanwhile.

    Inside a transaction or another such block of the same thread, the block sees what that one
    sees.
    """
    with store.in_use() as is_outermost:
        connection = store.connection
        if not is_outermost:
            known = store.local.snapshot_revision  # None in a transaction, which raises it
            yield revision(store) if known is None else known
            return
        fixed = store.fixed_revision(lambda: revision(store))
        if fixed is None:
            connection.execute("BEGIN")
        try:
            store.local.snapshot_revision = revision(store) if fixed is None else fixed
            yield store.local.snapshot_revision
        finally:
            store.local.snapshot_revision = None
            if fixed is None:
                with suppress(StoreError):  # an error has ended it, and is on its way up
                    connection.execute("ROLLBACK")  # nothing was changed


def revision(store: Store) -> int:
    """The number that every committed change raises; 0.5 ms."""
    return int(read_meta(store, "revision"))


def content_revision(store: Store) -> str:
    """A mark that is new with every change of captures, of their words, or of synonyms."""
    return read_meta(store, "content_revision")


def read_meta(store: Store, key: str) -> str:
    """The value of ``key`` in the table ``meta``."""
    value = store.connection.value("SELECT value FROM meta WHERE key = ?", [key])
    if value is None:
        raise StoreError(
            f"{store.path}: expected {key!r} in the table meta, found nothing. "
            "The file was changed by hand: restore a copy."
        )
    return str(value)


def write_meta(store: Store, key: str, value: str) -> None:
    """Set the value of an existing ``key`` in the table ``meta``."""
    with transaction(store) as connection:
        connection.execute("UPDATE meta SET value = ? WHERE key = ?", [value, key])


def touch(store: Store, *, motions: bool = False) -> None:
    """Mark, when the transaction commits, that the data for learning have changed."""
    with transaction(store):
        store.local.changed.add("content_revision")
        if motions:
            store.local.changed.add("motion_revision")


def _begin(store: Store) -> None:
    """Begin a transaction by raising the revision, once no other connection is in one."""
    deadline = time.monotonic() + _OTHER_WRITER
    while True:
        store.connection.execute("BEGIN")
        try:
            store.connection.execute(
                "UPDATE meta SET value = value::BIGINT + 1 WHERE key = 'revision'"
            )
            return
        except BaseException as error:
            _roll_back(store)
            cause = error.__cause__
            if not isinstance(cause, duckdb.TransactionException):
                raise
            if time.monotonic() > deadline:
                raise StoreError(
                    f"{store.path}: expected to save the change, found another part of this "
                    f"program saving for {_OTHER_WRITER:g} s. Nothing was changed. Try again."
                ) from error
        time.sleep(_PAUSE)


def _undo(store: Store, error: BaseException) -> None:
    """Roll back; raise the error of motiondb for an error of DuckDB."""
    if not _roll_back(store) and not isinstance(error.__cause__, duckdb.Error):
        Store.changes_saved += 1  # an interrupt that came just after COMMIT
    cause = error if isinstance(error, duckdb.Error) else error.__cause__
    if isinstance(cause, duckdb.Error):
        reason = first_sentence(cause)
        if is_damage(cause):
            raise type(error)(damage_sentence(store.path, reason)) from cause
        raise StoreError(
            f"{store.path}: expected to save the change, found: {reason} Nothing was changed."
        ) from cause


def _roll_back(store: Store) -> bool:
    """Whether there was a transaction to undo; a failed COMMIT has undone everything."""
    try:
        store.connection.execute("ROLLBACK")
    except StoreError:
        return False
    return True
