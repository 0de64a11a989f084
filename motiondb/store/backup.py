"""A copy of the database into another file, of one state, while it is used."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from motiondb.errors import QueryError, StoreError
from motiondb.files.safe_files import check_file_name, log_of, output_file
from motiondb.store.compaction import attach, copy_tables
from motiondb.store.connection.handle import Store


def backup(store: Store, path: Path, check: Callable[[Path], Sequence[str]]) -> None:
    """Copy one state of the database into a new file, which gets its name when it is checked.

    Other processes may read the database meanwhile, and threads of this process may change it.

    `check`: Gives the faults of a database file.
    """
    check_file_name(path)
    if path.exists():
        raise QueryError(
            f"{path}: expected the name of a new file, found a file of that name. "
            "Give another name."
        )
    if not path.absolute().parent.is_dir():
        raise StoreError(
            f"{path}: expected a folder that is there, found none. Make it, or give another name."
        )
    if store.lacked_log:  # the copy would not say so
        raise StoreError(store.log_note)
    with output_file(path, StoreError) as draft:
        attach(store, draft, "backup_file")
        try:
            copy_tables(store, "backup_file")
        finally:
            store.connection.execute("DETACH backup_file")
        if log_of(draft).exists():  # what it holds would be missing
            raise StoreError(
                f"{path}: expected room for a copy, found too little. Nothing was written; look "
                "at the disk."
            )
        faults = check(draft)
        if faults:
            told = "\n".join(faults).replace(str(draft), str(path))
            raise StoreError(
                f"{path}: expected a copy without faults, found:\n{told}\nNothing was written."
            )
