"""Arrays of all motions, memory-mapped from files beside the database.

The folder ``motions.duckdb.cache/`` holds the arrays as ``KIND-REVISION-NAME.npy``. A list,
``KIND-REVISION.json``, gives their names, shapes, types and checksums; it is written last. The
revision is a random mark that the store renews with every change of its motions. Each file is
written under a temporary name, flushed to the disk, and renamed.

An array that does not match its list is rebuilt from the store, so the folder can be deleted or
damaged at any time. If the folder cannot be written, the arrays stay in memory.

The checksums are compared whenever arrays are mapped, once for each opening of a database; those of
rows that belong to captures when the rows of a capture are looked at (:class:`CheckedRows`). They
must therefore be cheap: sums of 8-byte words run at 5 GB a second, CRC-32 at 0.7 GB a second
(measured on 160 MB).
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import zlib
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import DTypeLike, NDArray

from motiondb.files.json_text import parse_json
from motiondb.files.safe_files import read_bounded, sweep_drafts, whole_file
from motiondb.records import FloatArray, IntArray, Motion
from motiondb.store.catalogue.captures import load_motion
from motiondb.store.connection.faults import DamagedMotionError
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import read_meta

Arrays = dict[str, NDArray[Any]]
_NONE: Mapping[str, NDArray[Any]] = MappingProxyType({})
_AT_ONCE = 64  # Captures whose rows are made together: bounds memory

_VERSION = 1  # Version of the list's format. A list of another version is not read
_PAGE = 4096
"""Bytes that are summed before weighting: the size of a page of memory and of most disks."""
_UNUSABLE = (OSError, ValueError, EOFError, KeyError, TypeError, AttributeError)
"""Exceptions that reading a missing or damaged file raises."""


def cache_bytes(store: Store) -> int:
    """Return the size of the folder with the cache, bytes; 0 if there is none."""
    folder = store.path.with_name(f"{store.path.name}.cache")
    total = 0
    for file in folder.glob("*"):
        with suppress(OSError):  # another process may replace it
            total += file.stat().st_size
    return total


def cached_arrays(
    store: Store, kind: str, build: Callable[[], Mapping[str, NDArray[Any]]], mark: str = ""
) -> Arrays:
    """Return the arrays that ``build`` makes from the motions, from the cache where possible.

    The cached arrays are valid until the motions change, or the ``mark`` is another one. Within a
    transaction the cache is neither read nor written, because the transaction may yet be rolled
    back.

    `kind`: What the arrays are, one word of letters and digits; part of the files' names.

    `mark`: What the arrays follow from beside the motions.

    `build`: Returns the arrays by name. It is called when the cache has no arrays for the current
    motions, or damaged ones.
    """
    if store.in_transaction:
        return dict(build())  # the transaction may yet be rolled back
    folder, stem = _place(store, kind, mark)
    try:
        return _read_arrays(folder, stem)
    except _UNUSABLE:
        arrays = dict(build())
    with suppress(*_UNUSABLE):
        _write_arrays(folder, kind, stem, arrays)
        return _read_arrays(folder, stem)
    return arrays


class CheckedRows:
    """Rows of captures in a memory map; those of a capture are checked when they are looked at.

    The rows of a capture whose checksum is wrong are made anew, and the list of the cache is
    deleted, so that the next opening makes all anew.
    """

    def __init__(
        self,
        rows: NDArray[Any],
        bounds: IntArray,
        sums: NDArray[np.uint64],
        make: Callable[[int], NDArray[Any]],
    ) -> None:
        # A plain array of the same memory: slices of a memory map take 20 times as long
        self.rows, self.shape, self.dtype = rows.view(np.ndarray), rows.shape, rows.dtype
        self._bounds, self._sums, self._make = bounds.tolist(), sums, make
        self._is_sound = [False] * len(sums)
        self._mended: dict[int, NDArray[Any]] = {}

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, which: slice | NDArray[Any]) -> NDArray[Any]:
        if not isinstance(which, slice):
            return np.asarray(np.asarray(self)[which])
        start, stop, step = which.indices(len(self.rows))
        if stop <= start:
            return self.rows[which]
        first, last = (bisect_right(self._bounds, row) - 1 for row in (start, stop - 1))
        touched = range(first, last + 1)
        for place in touched:
            self._check(place)
        if self._mended.keys().isdisjoint(touched):
            return self.rows[which]
        whole = self.rows[start:stop].copy()
        for place in self._mended.keys() & set(touched):
            low, high = self._bounds[place : place + 2]
            part = slice(max(low, start), min(high, stop))
            whole[part.start - start : part.stop - start] = self._mended[place][
                part.start - low : part.stop - low
            ]
        return whole[::step]

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        whole = self[:].astype(dtype or self.dtype, copy=False)
        return whole.copy() if copy else whole

    def _check(self, place: int) -> None:
        """Compare the rows of a capture with their checksum, once."""
        if self._is_sound[place] or place in self._mended:
            return
        low, high = self._bounds[place : place + 2]
        if page_checksum(self.rows[low:high]) == int(self._sums[place]):
            self._is_sound[place] = True
        else:
            self._mended[place] = self._make(place)


@dataclass(frozen=True, eq=False)
class CaptureRows:
    """Arrays of every capture, end to end, in order of capture number."""

    capture_ids: IntArray  # (captures,): their numbers, ascending; none whose motion is damaged
    bounds: IntArray  # (captures + 1,): capture n has the rows from bounds[n] to bounds[n + 1]
    rows: NDArray[Any] | CheckedRows  # (rows, columns)
    values: FloatArray  # (captures,): one number of every capture


Made = tuple[NDArray[Any], float]
"""Rows (rows, columns) of one capture, and its number."""


def cached_rows(
    store: Store,
    kind: str,
    make: Callable[[Sequence[Motion]], Sequence[Made]],
    ready: Mapping[int, Made] = MappingProxyType({}),
) -> CaptureRows:
    """Rows that follow from the motion of each capture alone, from the cache where possible.

    When captures are added or removed, the rows of the others are taken from the former cache: only
    those of new captures are made. Rows of a former cache are used only for a capture with the same
    number, file, and run that added it. Within a transaction the cache is read but not written.

    `make`: Makes rows and number of some motions, in their order.

    `ready`: Capture number -> rows and number that were made already (:func:`lacking_rows`).
    """
    folder, stem = _place(store, kind)

    def mended(number: int) -> NDArray[Any]:
        with suppress(OSError):
            (folder / f"{stem}.json").unlink()
        return make([load_motion(store, number)])[0][0]

    if not store.in_transaction:
        with suppress(*_UNUSABLE):
            return _to_capture_rows(_read_arrays(folder, stem), mended)
    marks = _capture_marks(store)
    former = _former_rows(store, kind)
    former |= {marks[number]: made for number, made in ready.items() if number in marks}
    parts = _rows_of(store, marks, former, make)
    if not store.in_transaction and marks:
        with suppress(*_UNUSABLE):
            _write_rows(folder, kind, stem, marks, parts)
            return _to_capture_rows(_read_arrays(folder, stem), mended)
        parts = _rows_of(store, marks, former, make)
    made = dict(parts)
    sizes = [len(rows) for rows, _ in made.values()]
    bounds = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    rows = np.concatenate([rows for rows, _ in made.values()]) if made else np.zeros((0, 0))
    values = np.array([value for _, value in made.values()], dtype=np.float64)
    return CaptureRows(np.array(list(made), dtype=np.int64), bounds, rows, values)


def lacking_rows(store: Store, kind: str) -> dict[int, Motion]:
    """Motions of the captures whose rows are not in the cache, by number."""
    if is_cached(store, kind):
        return {}
    former = _former_rows(store, kind)
    new = [number for number, mark in _capture_marks(store).items() if mark not in former]
    return dict(readable_motions(store, new))


def readable_motions(store: Store, numbers: Iterable[int]) -> Iterator[tuple[int, Motion]]:
    """Number and motion of the captures of some numbers, without those whose motion is damaged."""
    for number in numbers:
        with suppress(DamagedMotionError):
            yield number, load_motion(store, number)


def _to_capture_rows(arrays: Arrays, mended: Callable[[int], NDArray[Any]]) -> CaptureRows:
    """The rows of a cache; those of a damaged capture are made by its number."""
    numbers, bounds = arrays["capture_ids"], arrays["bounds"]
    checked = CheckedRows(
        arrays["rows"], bounds, arrays["sums"], lambda place: mended(int(numbers[place]))
    )
    return CaptureRows(numbers, bounds, checked, arrays["values"])


def _capture_marks(store: Store) -> dict[int, int]:
    """Capture number -> 64 bits that tell its motion from that of any other, by number."""
    runs = store.connection.execute("SELECT run_id, started, version, parameters FROM run")
    made_by = {run: repr(facts) for run, *facts in runs.fetchall()}
    query = "SELECT capture_id, sha256, run_id FROM capture ORDER BY capture_id"
    texts = (
        (number, f"{number} {sha256} {made_by.get(run)}")
        for number, sha256, run in store.connection.execute(query).fetchall()
    )
    return {
        number: int.from_bytes(hashlib.sha256(text.encode()).digest()[:7], "big")
        for number, text in texts
    }


def _former_rows(store: Store, kind: str) -> dict[int, Made]:
    """Mark of a capture -> its rows and its number, from the newest cache that can be read."""
    folder = _place(store, kind)[0]
    listed = [file for file in folder.glob(f"{kind}-*.json") if _ours(kind).fullmatch(file.name)]
    for file in sorted(listed, key=lambda one: -one.stat().st_mtime):
        with suppress(*_UNUSABLE):
            arrays = _read_arrays(folder, file.stem)
            bounds, rows = arrays["bounds"].tolist(), arrays["rows"]
            parts = [rows[low:high] for low, high in pairwise(bounds)]
            facts = zip(arrays["marks"].tolist(), parts, arrays["values"].tolist(), arrays["sums"])
            return {
                mark: (part, value)
                for mark, part, value, total in facts
                if page_checksum(part) == int(total)
            }
    return {}


def _rows_of(
    store: Store,
    marks: Mapping[int, int],
    former: Mapping[int, Made],
    make: Callable[[Sequence[Motion]], Sequence[Made]],
) -> Iterator[tuple[int, Made]]:
    """Every capture with its rows and number, made a few captures at a time where they are new."""
    numbers = list(marks)
    for first in range(0, len(numbers), _AT_ONCE):
        some = numbers[first : first + _AT_ONCE]
        new = [number for number in some if marks[number] not in former]
        motions = dict(readable_motions(store, new))
        made = dict(zip(motions, make(list(motions.values()))))
        known = {number: former[marks[number]] for number in some if number not in new}
        yield from ((n, (made | known)[n]) for n in some if n in made or n in known)


def _write_rows(
    folder: Path,
    kind: str,
    stem: str,
    marks: Mapping[int, int],
    parts: Iterable[tuple[int, Made]],
) -> None:
    """Write rows to the cache as they are made."""
    folder.mkdir(exist_ok=True)
    numbers, sizes, values, sums = list[int](), [0], list[float](), list[int]()
    file_name = folder / f"{stem}-rows.npy"
    with _draft(file_name) as file:
        shape, kind_of_rows = (0, 0), np.dtype(np.float32)
        for number, (rows, value) in parts:
            if not numbers:
                shape, kind_of_rows = (0, rows.shape[1]), rows.dtype
                _write_head(file, shape, kind_of_rows)
            rows = np.ascontiguousarray(rows)
            file.write(rows.data)
            numbers.append(number)
            sizes.append(len(rows))
            sums.append(page_checksum(rows))
            values.append(value)
        file.seek(0)
        _write_head(file, (sum(sizes), shape[1]), kind_of_rows)
    arrays = {
        "capture_ids": np.array(numbers, dtype=np.int64),
        "bounds": np.cumsum(sizes, dtype=np.int64),
        "values": np.array(values, dtype=np.float64),
        "marks": np.array([marks[number] for number in numbers], dtype=np.int64),
        "sums": np.array(sums, dtype=np.uint64),
    }
    written = {"rows": np.load(file_name, mmap_mode="r", allow_pickle=False)}
    _write_arrays(folder, kind, stem, arrays, written)


def _write_head(file: BinaryIO, shape: tuple[int, int], kind: np.dtype[Any]) -> None:
    """Write the head of a file of rows; it is as long for any number of rows."""
    head = {"descr": kind.str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, head)


def is_cached(store: Store, kind: str) -> bool:
    """Whether the cache holds arrays of the current motions; they may yet prove to be damaged."""
    folder, stem = _place(store, kind)
    return (folder / f"{stem}.json").is_file()


def _place(store: Store, kind: str, mark: str = "") -> tuple[Path, str]:
    """Folder of the cache, and how the names of the files of these arrays begin."""
    folder = store.path.with_name(f"{store.path.name}.cache")
    revision = read_meta(store, "motion_revision")
    if mark:
        revision = hashlib.sha256(f"{revision} {mark}".encode()).hexdigest()[:32]
    return folder, f"{kind}-{revision}"


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
        if _facts(array, facts["checksum"] is not None) != facts:
            raise ValueError(f"the array {name} is damaged")
        arrays[name] = array
    return arrays


def _write_arrays(
    folder: Path, kind: str, stem: str, arrays: Arrays, written: Mapping[str, NDArray[Any]] = _NONE
) -> None:
    """Write the arrays, then their list; then delete the files of other revisions.

    `written`: Arrays whose files are there already; they have checksums of their own.
    """
    folder.mkdir(exist_ok=True)
    for name, array in arrays.items():
        with _draft(folder / f"{stem}-{name}.npy") as file:
            np.save(file, array, allow_pickle=False)
    arrays = {**arrays, **written}
    facts = {name: _facts(array, name not in written) for name, array in arrays.items()}
    listed = {"version": _VERSION, "checksum": _list_checksum(facts), "arrays": facts}
    with _draft(folder / f"{stem}.json") as file:
        file.write(json.dumps(listed).encode())
    current = {f"{stem}-{name}.npy" for name in arrays} | {f"{stem}.json"}
    ours = _ours(kind)
    sweep_drafts(folder, ours.pattern)
    for old in folder.glob(f"{kind}-*"):  # a user may keep files here, such as motions-2024.json
        with suppress(OSError):
            if ours.fullmatch(old.name) and old.name not in current:
                old.unlink()


def _ours(kind: str) -> re.Pattern[str]:
    """Names of files of the cache."""
    return re.compile(rf"{kind}-[0-9a-f]{{32}}(-[a-z_]+\.npy|\.json)")


@contextmanager
def _draft(path: Path) -> Iterator[BinaryIO]:
    """Open a draft that is renamed to ``path`` once it is on the disk."""
    with whole_file(path, is_cache=True) as draft, draft.open("wb") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())


def _facts(array: NDArray[Any], checked: bool = True) -> dict[str, Any]:
    """Return the entry of an array in the list: shape, type and, if it is one, the checksum."""
    checksum = page_checksum(np.ascontiguousarray(array)) if checked else None
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
