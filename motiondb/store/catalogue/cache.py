"""Arrays of all motions, memory-mapped from files beside the database.

The folder ``motions.duckdb.cache/`` holds the arrays as ``KIND-REVISION-NAME.npy``. A list,
``KIND-REVISION.json``, gives their names, shapes, types and checksums; it is written last. The
revision is a random mark that the store renews with every change of its motions. Each file is
written under a temporary name, flushed to the disk, and renamed.

An array that does not match its list is rebuilt from the store, so the folder can be deleted or
damaged at any time. If the folder cannot be written, the arrays stay in memory.

The checksums are compared whenever arrays are mapped, once for each opening of a database. They
must therefore be cheap: sums of 8-byte words run at 5 GB a second, CRC-32 at 0.7 GB a second
(measured on 160 MB).
"""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import QueryError
from motiondb.files.json_text import parse_json
from motiondb.files.safe_files import read_bounded, sweep_drafts, whole_file
from motiondb.records import Float32Array, FloatArray, IntArray, Motion
from motiondb.store.catalogue.captures import POSE_SIZE, unflatten_motion
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import from_rows
from motiondb.store.connection.transactions import read_meta

Arrays = dict[str, NDArray[Any]]

_VERSION = 1  # Version of the list's format. A list of another version is not read
_PAGE = 4096
"""Bytes that are summed before weighting: the size of a page of memory and of most disks."""
_UNUSABLE = (OSError, ValueError, EOFError, KeyError, TypeError, AttributeError)
"""Exceptions that reading a missing or damaged file raises."""


@dataclass(frozen=True, eq=False)
class MotionPool:
    """All motions, concatenated in order of capture number."""

    capture_ids: IntArray  # (captures,): numbers of the captures, ascending
    # (captures + 1,): the rows of ``poses`` that hold capture n are [offsets[n], offsets[n + 1])
    offsets: IntArray
    leg_lengths: FloatArray  # (captures,): leg length of each performer, hip to ankle, metres
    # (frames, 87), float32: root position (metres) and 21 quaternions (w, x, y, z) of each frame,
    # as in :func:`flatten_motion`; may be a memory map
    poses: Float32Array

    def motion(self, capture_id: int) -> Motion:
        """Return the motion of one capture, as views into ``poses`` and without its notes."""
        number = int(np.searchsorted(self.capture_ids, capture_id))
        if number == len(self.capture_ids) or self.capture_ids[number] != capture_id:
            raise QueryError(f"capture {capture_id}: expected a capture in the pool, found none.")
        rows = slice(*self.offsets[number : number + 2])
        return unflatten_motion(self.poses[rows], float(self.leg_lengths[number]))


def load_motion_pool(store: Store) -> MotionPool:
    """Load all motions at once.

    The first call writes the arrays to the cache. Later calls map them, until the motions change.
    """
    return MotionPool(**cached_arrays(store, "motions", lambda: _read_motions(store)))


def cached_arrays(
    store: Store, kind: str, build: Callable[[], Mapping[str, NDArray[Any]]]
) -> Arrays:
    """Return the arrays that ``build`` makes from the motions, from the cache where possible.

    The cached arrays are valid until the motions change. Within a transaction the cache is neither
    read nor written, because the transaction may yet be rolled back.

    `kind`: What the arrays are, one word of letters and digits; part of the files' names.

    `build`: Returns the arrays by name. It is called when the cache has no arrays for the current
    motions, or damaged ones.
    """
    if store.in_transaction:
        return dict(build())  # the transaction may yet be rolled back
    folder, stem = _place(store, kind)
    try:
        return _read_arrays(folder, stem)
    except _UNUSABLE:
        arrays = dict(build())
    with suppress(*_UNUSABLE):
        _write_arrays(folder, kind, stem, arrays)
        return _read_arrays(folder, stem)
    return arrays


def is_cached(store: Store, kind: str) -> bool:
    """Whether the cache holds arrays of the current motions; they may yet prove to be damaged."""
    folder, stem = _place(store, kind)
    return (folder / f"{stem}.json").is_file()


def _place(store: Store, kind: str) -> tuple[Path, str]:
    """Folder of the cache, and how the names of the files of these arrays begin."""
    folder = store.path.with_name(f"{store.path.name}.cache")
    return folder, f"{kind}-{read_meta(store, 'motion_revision')}"


def _read_motions(store: Store) -> Arrays:
    captures = store.connection.arrays(
        "SELECT capture_id, motion_frames, leg_length FROM capture ORDER BY capture_id",
    )
    query = "SELECT pose FROM motion_frame ORDER BY capture_id, frame"
    rows = store.connection.arrays(query)["pose"]
    return {
        "capture_ids": captures["capture_id"],
        "offsets": np.concatenate([[0], np.cumsum(captures["motion_frames"])]).astype(np.int64),
        "leg_lengths": captures["leg_length"],
        "poses": from_rows(rows, (POSE_SIZE,), np.float32),
    }


def _read_arrays(folder: Path, stem: str) -> Arrays:
    """Map all arrays of the list, and check that each matches its entry."""
    listed = parse_json(read_bounded(folder / f"{stem}.json"))
    if listed["version"] != _VERSION or listed["checksum"] != _list_checksum(listed["arrays"]):
        raise ValueError("the list is damaged")
    arrays: Arrays = {}
    for name, facts in listed["arrays"].items():
        file = folder / f"{stem}-{name}.npy"
        if not file.is_file():  # a pipe would be waited for
            raise ValueError(f"the array {name} is no file")
        array = np.load(file, mmap_mode="r", allow_pickle=False)
        if _facts(array) != facts:
            raise ValueError(f"the array {name} is damaged")
        arrays[name] = array
    return arrays


def _write_arrays(folder: Path, kind: str, stem: str, arrays: Arrays) -> None:
    """Write the arrays, then their list; then delete the files of other revisions."""
    folder.mkdir(exist_ok=True)
    for name, array in arrays.items():
        with _draft(folder / f"{stem}-{name}.npy") as file:
            np.save(file, array, allow_pickle=False)
    facts = {name: _facts(array) for name, array in arrays.items()}
    listed = {"version": _VERSION, "checksum": _list_checksum(facts), "arrays": facts}
    with _draft(folder / f"{stem}.json") as file:
        file.write(json.dumps(listed).encode())
    current = {f"{stem}-{name}.npy" for name in arrays} | {f"{stem}.json"}
    ours = re.compile(rf"{kind}-[0-9a-f]{{32}}(-[a-z_]+\.npy|\.json)")
    sweep_drafts(folder, ours.pattern)
    for old in folder.glob(f"{kind}-*"):  # a user may keep files here, such as motions-2024.json
        with suppress(OSError):
            if ours.fullmatch(old.name) and old.name not in current:
                old.unlink()


@contextmanager
def _draft(path: Path) -> Iterator[BinaryIO]:
    """Open a draft that is renamed to ``path`` once it is on the disk."""
    with whole_file(path, is_cache=True) as draft, draft.open("wb") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())


def _facts(array: NDArray[Any]) -> dict[str, Any]:
    """Return the entry of an array in the list: shape, type and checksum."""
    checksum = page_checksum(np.ascontiguousarray(array))
    return {"shape": list(array.shape), "dtype": array.dtype.str, "checksum": checksum}


def page_checksum(array: NDArray[Any]) -> int:
    """Return the sum over pages k of (2 k + 1) times the sum of the page's words, modulo 2^64.

    A page has 4096 bytes and a word has 8. The bytes after the last whole word are added one by
    one. A change of any single word changes the checksum. Swapping two pages usually changes
    it too; it does not where the sums of their words agree.

    >>> page_checksum(np.array([7, 1])), page_checksum(np.ones(1024, dtype=np.int64))
    (8, 2048)
    """
    data = array.reshape(-1).view(np.uint8)
    n_whole = len(data) // _PAGE
    whole = data[: n_whole * _PAGE].view(np.uint64).reshape(n_whole, _PAGE // 8)
    sums = whole.sum(axis=1, dtype=np.uint64)
    weights = np.arange(1, 2 * n_whole + 1, 2, dtype=np.uint64)
    rest = data[n_whole * _PAGE :]
    words = rest[: len(rest) // 8 * 8].view(np.uint64).sum(dtype=np.uint64)
    last = rest[len(rest) // 8 * 8 :].sum(dtype=np.uint64)
    total = int((sums * weights).sum(dtype=np.uint64))
    return (total + (int(words) + int(last)) * (2 * n_whole + 1)) % 2**64


def _list_checksum(facts: Mapping[str, Any]) -> int:
    """Return the checksum of the list itself, so that a changed name is noticed."""
    return zlib.crc32(json.dumps(facts, sort_keys=True).encode())
