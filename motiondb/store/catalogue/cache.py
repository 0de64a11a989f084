"""Arrays for passes over everything, memory-mapped from files beside the database.

``motions.duckdb.cache/`` holds ``KIND-REVISION-NAME.npy``. The revision is a random mark that the
store changes with every change of its motions, so a file is either right or not looked at. Files
are written under another name and moved into place. The folder can be deleted at any time; where
it cannot be written, the arrays stay in memory.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import QueryError
from motiondb.records import Float32Array, FloatArray, IntArray, Motion
from motiondb.store.catalogue.poses import POSE_SIZE, unflatten_motion
from motiondb.store.connection.columns import fetch, from_rows
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import read_meta

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class MotionPool:
    """All motions end to end, in order of capture number.

    Attributes
    ----------
    capture_ids : array (captures,), int64.
    offsets : array (captures + 1,), int64; capture n holds the rows offsets[n] to offsets[n + 1].
    leg_lengths : array (captures,), metres.
    poses : array (frames, 87), float32, root position and 21 quaternions; may be a memory map.
    """

    capture_ids: IntArray
    offsets: IntArray
    leg_lengths: FloatArray
    poses: Float32Array

    def motion(self, capture_id: int) -> Motion:
        """One capture's motion, as views into ``poses``; its notes are left out."""
        number = int(np.searchsorted(self.capture_ids, capture_id))
        if number == len(self.capture_ids) or self.capture_ids[number] != capture_id:
            raise QueryError(f"capture {capture_id}: expected a capture in the pool, found none.")
        rows = slice(*self.offsets[number : number + 2])
        return unflatten_motion(self.poses[rows], float(self.leg_lengths[number]))


def load_motion_pool(store: Store) -> MotionPool:
    """All motions at once; after the first call a memory map, until the motions change."""
    return MotionPool(**cached_arrays(store, "motions", lambda: _read_motions(store)))


def cached_arrays(
    store: Store, kind: str, build: Callable[[], Mapping[str, NDArray[Any]]]
) -> Arrays:
    """The arrays that ``build`` makes from the motions, kept until the motions change.

    Parameters
    ----------
    kind : letters and digits, one word for what the arrays are; part of the files' names.
    build : gives arrays by name; called when there are none for the motions of now.

    Returns
    -------
    dict : name -> array; memory maps (read only) where they come from or went to files.
    """
    if store.in_transaction:
        return dict(build())  # within a transaction that may yet be undone
    folder = store.path.with_name(f"{store.path.name}.cache")
    stem = f"{kind}-{read_meta(store, 'motion_revision')}"
    try:
        return _read_arrays(folder, stem)
    except (OSError, ValueError, EOFError):
        arrays = dict(build())
    with suppress(OSError, ValueError, EOFError):
        _write_arrays(folder, kind, stem, arrays)
        return _read_arrays(folder, stem)
    return arrays


def _read_motions(store: Store) -> Arrays:
    captures = fetch(
        store.connection,
        "SELECT capture_id, motion_frames, leg_length FROM capture ORDER BY capture_id",
    )
    query = "SELECT pose FROM motion_frame ORDER BY capture_id, frame"
    rows = fetch(store.connection, query)["pose"]
    return {
        "capture_ids": captures["capture_id"],
        "offsets": np.concatenate([[0], np.cumsum(captures["motion_frames"])]).astype(np.int64),
        "leg_lengths": captures["leg_length"],
        "poses": from_rows(rows, (POSE_SIZE,), np.float32),
    }


def _read_arrays(folder: Path, stem: str) -> Arrays:
    """Memory maps of all arrays that the list beside them names."""
    names = (folder / f"{stem}.names").read_text(encoding="utf-8").split()
    return {name: np.load(folder / f"{stem}-{name}.npy", mmap_mode="r") for name in names}


def _write_arrays(folder: Path, kind: str, stem: str, arrays: Arrays) -> None:
    """Write the arrays, then the list of their names, then delete those of other revisions."""
    folder.mkdir(exist_ok=True)
    for name, array in arrays.items():
        new = folder / f"{stem}-{name}.npy.new-{os.getpid()}"
        with new.open("wb") as file:
            np.save(file, array, allow_pickle=False)
        new.replace(folder / f"{stem}-{name}.npy")
    new = folder / f"{stem}.names.new-{os.getpid()}"
    new.write_text(" ".join(arrays), encoding="utf-8")
    new.replace(folder / f"{stem}.names")
    for old in folder.glob(f"{kind}-*"):
        if not old.name.startswith(stem):
            with suppress(OSError):
                old.unlink()
