"""Files that ``add`` has read, and those that it did not save: unreadable, or of known content.

What is noted of a folder is replaced when the folder is added again. Files that were read are kept
as they were then; what the texts hold is for ``add`` to say.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import columns_of
from motiondb.store.connection.transactions import transaction


@dataclass(frozen=True)
class NotSaved:
    """The files of added files and folders that are no captures of their own."""

    folders: Sequence[Path]
    faulty: dict[str, str] = field(default_factory=dict)  # Path -> why it could not be read
    same: dict[str, str] = field(default_factory=dict)  # Path -> name of the capture


def save_not_saved(store: Store, files: NotSaved) -> None:
    """Replace what is noted of the files and folders."""
    faulty, same = _noted(store, files.folders)
    new_faulty, new_same = _absolute(files.faulty), _absolute(files.same)
    numbers = dict(store.connection.execute("SELECT name, capture_id FROM capture").fetchall())
    noted = datetime.now(UTC).isoformat(timespec="seconds")
    with transaction(store) as connection:
        for path, _ in faulty.items() - new_faulty.items():
            connection.execute("DELETE FROM faulty_file WHERE path = ?", [path])
        for path, problem in new_faulty.items() - faulty.items():
            connection.execute("INSERT INTO faulty_file VALUES (?, ?, ?)", [path, problem, noted])
        for path, _ in same.items() - new_same.items():
            connection.execute("DELETE FROM same_file WHERE path = ?", [path])
        for path, name in new_same.items() - same.items():
            if name in numbers:
                connection.execute("INSERT INTO same_file VALUES (?, ?)", [path, numbers[name]])


def is_noted(store: Store, files: NotSaved) -> bool:
    """Whether this is what is noted of the files and folders."""
    return _noted(store, files.folders) == (_absolute(files.faulty), _absolute(files.same))


def load_faulty(store: Store) -> list[tuple[str, str, str]]:
    """Load path, problem and time (ISO 8601, UTC) of the faulty files, by path."""
    query = "SELECT path, problem, noted FROM faulty_file ORDER BY path"
    rows = store.connection.execute(query).fetchall()
    return [(str(path), str(problem), str(noted)) for path, problem, noted in rows]


def load_same_files(store: Store) -> list[tuple[str, str]]:
    """Load the path of files that have the content of a capture, and its name; by path."""
    query = "SELECT f.path, name FROM same_file f JOIN capture USING (capture_id) ORDER BY ALL"
    return [(str(path), str(name)) for path, name in store.connection.execute(query).fetchall()]


def _noted(store: Store, folders: Sequence[Path]) -> tuple[dict[str, str], dict[str, str]]:
    """What is noted of files and folders: faulty files, and those of known content."""
    roots = tuple(os.path.abspath(folder) for folder in folders)  # noqa: PTH100  links stay
    below = tuple(os.path.join(root, "") for root in roots)  # noqa: PTH118  ends in a slash

    def is_among(path: str) -> bool:
        return path in roots or path.startswith(below)

    faulty = {path: problem for path, problem, _ in load_faulty(store) if is_among(path)}
    return faulty, {path: name for path, name in load_same_files(store) if is_among(path)}


def _absolute(files: Mapping[str, str]) -> dict[str, str]:
    return {os.path.abspath(path): told for path, told in files.items()}  # noqa: PTH100


@dataclass(frozen=True)
class KnownFile:
    """A file when it was read."""

    state: str  # Size, time and access of the file and its skeleton file
    options: str  # How it was read
    readings: str  # What was found


def load_known_files(store: Store, paths: Sequence[str]) -> dict[str, KnownFile]:
    """Load those of some files that were read, by their absolute paths."""
    query = "FROM known_file WHERE path IN (SELECT unnest($1))"
    rows = store.connection.execute(query, [list(paths)]).fetchall()
    return {path: KnownFile(*row) for path, *row in rows}


def save_known_files(store: Store, files: Mapping[str, KnownFile]) -> None:
    """Note files that were read, in place of what was noted of them."""
    with transaction(store) as connection:
        columns = columns_of(KnownFile, list(files.values()))
        connection.insert_or_replace("known_file", path=list(files), **columns)
