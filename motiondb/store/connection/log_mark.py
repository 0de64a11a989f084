"""Whether a file is complete, or its latest changes stand in the log beside it.

DuckDB writes every change into ``PATH.wal``, and brings that log into the file at a checkpoint, the
last one when the database is closed. After a kill the log stays, and the file alone lacks what the
log holds. Nothing of DuckDB's in the file tells so. Therefore the row ``log`` of the table ``meta``
says ``open`` in the file itself, by a checkpoint before the first change of an opening, and is
empty again once the file was closed. From the mark on there is always a log: a checkpoint of
DuckDB's own deletes it, so the mark is then written anew, with another value, since DuckDB logs no
change to the same one. Between a checkpoint and the log that follows, an empty file
``.PATH.marking`` stands for the log, so that a kill at that moment is not taken for a loss. A file
that says ``open`` and has neither beside it was moved or copied without its log.

A change of such a file gives up what the log holds: the log then no longer fits. The row
``lost_log`` says when that was, until the file is compacted.
"""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

import duckdb

from motiondb.errors import StoreError
from motiondb.files.safe_files import MARKING, beside, delete_all, is_file, log_of
from motiondb.store.connection.faults import translate
from motiondb.store.connection.statements import Connection

_OPEN = (
    "UPDATE meta SET value = CASE value WHEN 'open' THEN 'still open' ELSE 'open' END "
    "WHERE key = 'log'"
)
_LOST = "INSERT OR IGNORE INTO meta VALUES ('lost_log', ?)"
FORGET_LOSS = "DELETE FROM meta WHERE key = 'lost_log'"
_CLOSED = "UPDATE meta SET value = '' WHERE key = 'log' AND value <> ''"


def set_mark(root: duckdb.DuckDBPyConnection, path: Path, lacked_log: bool) -> bool:
    """Set the mark before the first change; False if others read or write, and nothing is marked.

    `lacked_log`: Whether the file came without its log, which is given up now.

    DuckDB makes no checkpoint while a transaction of another connection has begun, which an answer
    that was not fetched to its end also keeps open.
    """
    stand_in(path)
    try:
        root.execute(_OPEN)
        if lacked_log:
            root.execute(_LOST, [time.strftime("%Y-%m-%d %H:%M:%S")])
        root.execute("CHECKPOINT")
    except duckdb.TransactionException:
        clear_mark(root)
        delete_all(beside(path, MARKING))
        return False
    except duckdb.Error as error:
        raise translate(path, error) from error
    keep_log(root, path)
    return True


def stand_in(path: Path) -> None:
    """Let an empty file stand for the log: before each commit, at which DuckDB may delete it."""
    flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
    with suppress(OSError):  # a full disk, which the next statements tell
        os.close(os.open(beside(path, MARKING), flags, 0o666))


def keep_log(root: duckdb.DuckDBPyConnection, path: Path) -> None:
    """Write the mark again where a checkpoint has deleted the log; after every change."""
    if not is_file(log_of(path)):  # also where the folder was closed meanwhile
        with suppress(duckdb.Error):  # the change itself is saved
            root.execute(_OPEN)
    if is_file(log_of(path)):
        delete_all(beside(path, MARKING))


def clear_mark(root: duckdb.DuckDBPyConnection) -> None:
    """Clear the mark before a connection that may write is closed."""
    with suppress(duckdb.Error):  # a full disk, or another part of the program that writes
        root.execute(_CLOSED)


def is_log_missing(connection: Connection) -> bool:
    """Whether the file says that there is a log, and there is none."""
    try:
        rows = connection.execute("SELECT value FROM meta WHERE key = 'log'").fetchall()
    except StoreError:  # a damaged file, which is told elsewhere
        return False
    logs = (log_of(connection.path), beside(connection.path, MARKING))
    return bool(rows and rows[0][0]) and not any(path.exists() for path in logs)


def lost_sentence(connection: Connection) -> str:
    """The sentence for a file that was changed without its log; "" for others."""
    try:
        lost = connection.value("SELECT value FROM meta WHERE key = 'lost_log'")
    except StoreError:  # a damaged file, which is told elsewhere
        return ""
    if lost is None:
        return ""
    return (
        f"{connection.path}: expected all changes that were saved, found that the log with the "
        f"latest ones was missing when the file was changed on {lost}: they are lost. Restore a "
        "copy that has them, or go on without them: motiondb compact ends this note."
    )


def missing_sentence(path: Path) -> str:
    """The sentence for a file that lacks its log."""
    return (
        f"{path}: expected its log {log_of(path).name} beside it, found none: a program was ended "
        "by force, and the file moved or copied without the log, which holds the latest changes. "
        "Put the log beside the file; if it is gone, so are these changes."
    )


def left_sentence(path: Path) -> str:
    """The sentence for a log that stays when the file is closed."""
    return (
        f"{log_of(path)}: holds the latest changes, which are not in {path.name} yet. Keep the two "
        "files together; the next command that writes brings them in."
    )
