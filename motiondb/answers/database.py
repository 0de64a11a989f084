"""Answers about a database as a whole: what is in it, its faults, its size, its copies."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motiondb.answers.knowledge import StartAnswer
from motiondb.learn.drift import Drift
from motiondb.tabled import Tabled


@dataclass(frozen=True, repr=False)
class DatabaseInfo(Tabled):
    """What is in a database; what it has not learned is None."""

    database: str
    bytes: int
    captures: int
    generated: int
    seconds: float
    performers: int
    captures_with_words: int
    copies: int
    grammars: int
    learned: bool
    cache_bytes: int = 0  # Of the folder beside it, which is made again when it is missing
    parquet_bytes: int | None = None  # Of Parquet files with motions, original files and scores
    motions_at: list[str] | None = None  # Folders and URLs of these
    unused_bytes: int = 0  # Of the file; ``compact`` gives them back
    removed: int = 0  # Captures in the trash, which ``compact`` empties
    compact_pays: bool = False  # Whether a quarter of the file is unused, or more
    faulty_files: int = 0  # That ``add`` could not read
    symbols: int | None = None
    clusters: int | None = None
    words: int | None = None
    current: bool | None = None
    not_yet_learned: int | None = None
    start: StartAnswer | None = None  # The start that was used for learning


@dataclass(frozen=True, kw_only=True)
class InfoAnswer(DatabaseInfo):
    """What is in a database, how far it has changed since it learned, and its runs."""

    drift: Drift | None
    runs: list[dict[str, Any]]


@dataclass(frozen=True)
class Faults:
    """The faults of a database."""

    faults: list[str]


@dataclass(frozen=True)
class Compacted:
    """The size of a database file, bytes, and what became of motions, original files and scores."""

    before: int
    after: int
    moved: int  # Captures whose motions and original files, or scores, were moved
    unused: tuple[str, ...]  # Parquet files that this database no longer relies on
    notes: tuple[str, ...] = ()  # What else was done to the file


@dataclass(frozen=True)
class BackedUp:
    """A copy of a database that was written and checked."""

    output: Path
    bytes: int
