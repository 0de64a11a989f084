"""Files that ``add`` has read, as they were then; what the texts hold is for ``add`` to say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import columns_of
from motiondb.store.connection.transactions import transaction


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
