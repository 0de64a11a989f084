"""The functions that come before an open database: open it, rewrite its file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motiondb.database import MotionDB
    from motiondb.database.catalogue.cataloguing import Progress
    from motiondb.store.compaction import Compacted


def open(
    path: str | Path = "motions.duckdb", *, read_only: bool = False, wait: float = 0.0
) -> MotionDB:
    """Open a motion database, or make a new one.

    Parameters
    ----------
    path : str or Path
        The DuckDB file.
    read_only : bool
        Whether only to ask; several processes may do so at once.
    wait : float
        Seconds to wait for another process that holds the file.

    Raises
    ------
    MotionDBError
        When another process holds the file, or it is not a database of motiondb, or was written by
        a newer motiondb.
    """
    from motiondb.database import MotionDB

    return MotionDB(path, read_only=read_only, wait=wait)


def compact(
    path: str | Path,
    wait: float = 0.0,
    motions_to: str | None = None,
    progress: Progress | None = None,
) -> Compacted:
    """Rewrite a database file without the space that removed rows left.

    Parameters
    ----------
    path : str or Path
        The DuckDB file; no process may have it open.
    wait : float
        Seconds to wait for another process that holds the file.
    motions_to : str, optional
        Where motions, original files and scores of segments are to lie: a folder, or a URL that
        fsspec knows, such as "s3://bucket/motions"; "here": in the database file. None leaves them
        where they are.
    progress : callable, optional
        Called with the name of the step, the number done, and the total number.

    Returns
    -------
    Compacted
        Size in bytes before and after, and what was moved.

    Raises
    ------
    MotionDBError
        When another process holds the file, it is not a database of motiondb, or the place cannot
        be written. What was moved until then stays moved; the others are as they were.
    """
    from motiondb import store

    return store.compact(path, wait=wait, motions_to=motions_to, progress=progress)


def check_merge(other: str | Path, prefix: str = "", wait: float = 0.0) -> None:
    """Refuse what :meth:`MotionDB.merge` would refuse, before a database is made for it."""
    from motiondb.database.catalogue import merging

    merging.check(Path(other), prefix, wait)


def changes_saved() -> bool:
    """Whether this process has saved a change to a database, for messages after an interrupt."""
    handle = sys.modules.get("motiondb.store.connection.handle")  # absent: nothing was opened
    return handle is not None and bool(handle.Store.changes_saved)
