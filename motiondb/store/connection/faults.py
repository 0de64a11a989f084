"""Translation of errors of DuckDB to messages of motiondb.

DuckDB names its errors by class. For users, errors are divided in another way:

====================  ==========================================================================
the file is damaged   a checksum that does not fit, a block beyond the end, a failed assertion
the disk is full      nothing was written
memory ran out        MemoryError: nothing is known of the file
the file was closed   a program error of the caller
anything else the message of DuckDB
====================  ==========================================================================
"""

from __future__ import annotations

import re
from pathlib import Path

import duckdb

from motiondb.errors import StoreError

ABORTED = "Current transaction is aborted"
"""DuckDB's message for every statement after the first failed one in a transaction."""
_DAMAGED = re.compile(
    r"checksum|corrupt|could not read|read out of|deserializ|serialization|failed to decompress"
    r"|unsupported compression|invalid unicode|invalid bitpacking|INTERNAL|FATAL|invalidated",
    re.IGNORECASE,
)
_FULL = re.compile(r"no space left|disk quota|could not write|file too large", re.IGNORECASE)


class DamagedFileError(StoreError):
    """A database file whose blocks cannot be read."""


class DamagedMotionError(DamagedFileError):
    """A motion that cannot be unpacked, in a file whose other rows can be read."""


class OtherModeError(StoreError):
    """A database file that this process has open for writing, or only for reading."""


def is_damage(error: BaseException) -> bool:
    """Whether an error of DuckDB says that the file is damaged."""
    if isinstance(error, DamagedFileError):
        return True
    if isinstance(error, duckdb.Error) and _FULL.search(str(error)):
        return False  # a full disk is called "invalidated" or "fatal" too
    if isinstance(
        error, duckdb.InternalException | duckdb.FatalException | duckdb.SerializationException
    ):
        return True
    return (
        isinstance(error, duckdb.Error)
        and not isinstance(error, duckdb.ConstraintException)
        and _DAMAGED.search(str(error)) is not None
    )


def translate(path: Path, error: duckdb.Error) -> StoreError | MemoryError:
    """The error of motiondb for an error of DuckDB in an open database."""
    if isinstance(error, duckdb.OutOfMemoryException):
        return MemoryError(
            f"{path}: expected enough memory, found that it ran out: {first_sentence(error)}"
        )
    if is_damage(error):
        return DamagedFileError(damage_sentence(path, first_sentence(error)))
    if _FULL.search(str(error)):
        return StoreError(
            f"{path}: expected room on the disk, found: {first_sentence(error)} "
            "Nothing was changed. Make room and run the command again."
        )
    if "already closed" in str(error):
        return StoreError(
            f"{path}: expected an open database, found it closed. Open it again with motiondb.open."
        )
    return StoreError(
        f"{path}: expected a database that answers, found: {first_sentence(error)} "
        f"Check it: motiondb check --db {path}."
    )


def damage_sentence(path: Path, reason: str) -> str:
    """The message for a damaged file, with advice."""
    return (
        f"{path}: expected tables that can be read, found: {reason} The file is damaged: "
        f"restore a copy, or save what is readable: motiondb rescue {path} -o NEW.duckdb."
    )


def first_sentence(error: BaseException) -> str:
    """DuckDB's message up to the first full stop; where it names an original error, that one."""
    message = str(error).rpartition("Original error: ")[2]
    text = re.split(r"(?<=\w)[.!] |\n", message)[0].rstrip(".!")
    return f"{text}."
