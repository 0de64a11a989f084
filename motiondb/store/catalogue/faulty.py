"""Files that could not be read when they were added, until they are added without fault."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


def save_faulty(store: Store, folders: Sequence[Path], problems: Mapping[str, str]) -> None:
    """Replace the faulty files of added files and folders.

    `problems`: Path of a file -> why it could not be read.
    """
    old, new = _of(store, folders), _absolute(problems)
    with transaction(store) as connection:
        for path in old:
            if old[path] != new.get(path):
                connection.execute("DELETE FROM faulty_file WHERE path = ?", [path])
        noted = datetime.now(UTC).isoformat(timespec="seconds")
        for path, problem in new.items():
            if problem != old.get(path):
                connection.execute(
                    "INSERT INTO faulty_file VALUES (?, ?, ?)", [path, problem, noted]
                )


def is_faulty_noted(store: Store, folders: Sequence[Path], problems: Mapping[str, str]) -> bool:
    """Whether the faulty files of added files and folders are those that are noted."""
    return _of(store, folders) == _absolute(problems)


def load_faulty(store: Store) -> list[tuple[str, str, str]]:
    """Load path, problem and time (ISO 8601, UTC) of the faulty files, by path."""
    query = "SELECT path, problem, noted FROM faulty_file ORDER BY path"
    return [
        (str(p), str(why), str(at)) for p, why, at in store.connection.execute(query).fetchall()
    ]


def _of(store: Store, folders: Sequence[Path]) -> dict[str, str]:
    """The noted files that are among added files, or below added folders."""
    roots = [os.path.abspath(folder) for folder in folders]  # noqa: PTH100  links stay
    return {
        path: problem
        for path, problem, _ in load_faulty(store)
        if any(path == root or path.startswith(os.path.join(root, "")) for root in roots)  # noqa: PTH118
    }


def _absolute(problems: Mapping[str, str]) -> dict[str, str]:
    return {os.path.abspath(path): problem for path, problem in problems.items()}  # noqa: PTH100
