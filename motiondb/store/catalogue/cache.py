"""Arrays of all motions, memory-mapped from files beside the database.

The folder ``motions.duckdb.cache/`` holds the arrays as ``KIND-REVISION-NAME.npy``. A list,
``KIND-REVISION.json``, gives their names, shapes, types and checksums; it is written last. The
revision is a random mark that the store renews with every change of its motions, or a digest of it
and of what else the arrays follow from. Each file is written under a temporary name, flushed to the
disk, and renamed.

An array that does not match its list is rebuilt from the store, so the folder can be deleted or
damaged at any time. If the folder cannot be written, the arrays stay in memory. No link is
followed, to the folder or in it (:mod:`motiondb.files.own_folder`).

The file of rows that belong to captures grows at its end when captures are added: it gets a second
name, that of the new list, and the former list still holds for the rows before.

The checksums are compared whenever arrays are mapped, once for each opening of a database; those of
rows that belong to captures when the rows of a capture are looked at
(:mod:`motiondb.store.catalogue.checked_rows`).
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from itertools import islice, pairwise
from threading import Lock
from types import MappingProxyType
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from motiondb.files.json_text import parse_json
from motiondb.files.own_folder import OwnFolder, own_folder
from motiondb.files.safe_files import MOST_TEXT
from motiondb.records import FloatArray, IntArray, Motion
from motiondb.store.catalogue.captures import load_motion
from motiondb.store.catalogue.checked_rows import CheckedRows, page_checksum
from motiondb.store.connection.faults import DamagedMotionError
from motiondb.store.connection.handle import Store
from motiondb.store.connection.migrations import motiondb_version
from motiondb.store.connection.transactions import read_meta

Arrays = dict[str, NDArray[Any]]
_NONE: Mapping[str, NDArray[Any]] = MappingProxyType({})
_AT_ONCE = 64  # Captures whose rows are made together: bounds memory

_FORMAT = 1  # Version of the list's format
_parsing = Lock()
"""Held while a head is parsed: Python 3.11 can fail where two threads parse at once
(https://github.com/python/cpython/issues/106905)."""
_UNUSABLE = (OSError, ValueError, EOFError, KeyError, TypeError, AttributeError)
"""Exceptions that reading a missing or damaged file raises."""


def cache_bytes(store: Store) -> int:
    """Return the size of the folder with the cache, bytes; 0 if there is none."""
    total = 0
    with suppress(OSError), _cache(store) as folder:
        for name in folder.names():
            with suppress(OSError):  # another process may replace it
                total += folder.status(name).st_size
    return total


def cached_arrays(
    store: Store,
    kind: str,
    build: Callable[[], Mapping[str, NDArray[Any]]],
    mark: str = "",
    of_motions: bool = True,
) -> Arrays:
    """Return the arrays that ``build`` makes from the motions, from the cache where possible.

    The cached arrays are valid until the motions change, or the ``mark`` is another one. Within a
    transaction the cache is neither read nor written, because the transaction may yet be rolled
    back.

    `kind`: What the arrays are, one word of letters and digits; part of the files' names.

    `mark`: What the arrays follow from beside the motions.

    `of_motions`: Whether they follow from the motions otherwise than by the mark. If False, they
    stay valid when motions are added.

    `build`: Returns the arrays by name. It is called when the cache has no arrays for the current
    motions, or damaged ones.
    """
    if store.in_transaction:
        return dict(build())  # the transaction may yet be rolled back
    stem = _stem(store, kind, mark, of_motions)
    with suppress(*_UNUSABLE), _cache(store) as folder:
        return _read_arrays(folder, stem)
    arrays = dict(build())
    with suppress(*_UNUSABLE), _cache(store, make=True) as folder:
        _write_arrays(folder, kind, stem, arrays)
        return _read_arrays(folder, stem)
    return arrays


@dataclass(frozen=True, eq=False)
class CaptureRows:
    """Arrays of every capture, end to end, in order of capture number."""

    capture_ids: IntArray  # (captures,): their numbers, ascending; none whose motion is damaged
    bounds: IntArray  # (captures + 1,): capture n has the rows from bounds[n] to bounds[n + 1]
    rows: NDArray[Any] | CheckedRows  # (rows, columns)
    values: FloatArray  # (captures,): one number of every capture


Made = tuple[NDArray[Any], float]
"""Rows (rows, columns) of one capture, and its number."""
Make = Callable[[Sequence[int]], Mapping[int, Made]]
"""Makes rows and number of some captures, by number; those that are damaged are left out."""


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

    def of_captures(numbers: Sequence[int]) -> Mapping[int, Made]:
        motions = dict(readable_motions(store, numbers))
        return dict(zip(motions, make(list(motions.values()))))

    return _cached(store, kind, _CAPTURES, "", of_captures, ready)


def cached_segment_rows(
    store: Store, kind: str, make: Make, ready: Mapping[int, Made] = MappingProxyType({})
) -> CaptureRows:
    """As :func:`cached_rows`, of rows that follow from the motion and the segments of a capture.

    Rows of a former cache are used for a capture whose segments are of the same run.
    """
    revision = read_meta(store, "segment_revision")
    return _cached(store, kind, _SEGMENTS, revision, make, ready)


def segment_rows(store: Store, kind: str, make: Make, numbers: Iterable[int]) -> dict[int, Made]:
    """Rows of :func:`cached_segment_rows` of some captures: from the newest cache, or made."""
    marks, wanted = _marks(store, _SEGMENTS), set(numbers)
    some = {number: mark for number, mark in marks.items() if number in wanted}
    return _in_memory(some, _former_rows(store, kind), make)


def _cached(
    store: Store,
    kind: str,
    captures: str,
    mark: str,
    make: Make,
    ready: Mapping[int, Made],
) -> CaptureRows:
    """Rows of the captures that a query gives with what tells them apart (:func:`_marks`)."""
    stem = _stem(store, kind, mark)

    def mended(number: int) -> NDArray[Any]:
        with suppress(OSError), _cache(store) as folder:
            folder.remove(f"{stem}.json")
        made = make([number])
        if number not in made:
            load_motion(store, number)  # tells the damage of the motion
        return made[number][0]

    if not store.in_transaction:
        with suppress(*_UNUSABLE), _cache(store) as folder:
            held = _to_capture_rows(_read_arrays(folder, stem), mended)
            if _is_whole(store, captures, held.capture_ids, make):
                return held
    marks = _marks(store, captures)
    newest = _newest(store, kind)
    former = _rows_in(newest)
    if not store.in_transaction and marks:
        with suppress(*_UNUSABLE), _cache(store, make=True) as folder:
            begun, new = _begin_with_former(folder, newest, stem, marks, make)
            _write_rows(folder, kind, stem, marks, _rows_of(new, former, make, ready), begun)
            return _to_capture_rows(_read_arrays(folder, stem), mended)
    made = _in_memory(marks, former, make, ready)
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
    new = [number for number, mark in _marks(store, _CAPTURES).items() if mark not in former]
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


_CAPTURES = "SELECT capture_id, sha256, run_id FROM capture ORDER BY capture_id"
_SEGMENTS = "SELECT DISTINCT capture_id, '', run_id FROM segment ORDER BY capture_id"
"""What tells the motions, and the segments, of captures from all others."""


def _is_whole(store: Store, captures: str, held: IntArray, make: Make) -> bool:
    """Whether a cache has all captures but those whose motions still cannot be read."""
    if store.connection.value(f"SELECT count(*) FROM ({captures})") == len(held):
        return True
    lacking = set(store.connection.column(captures)) - set(held.tolist())
    return not make(sorted(lacking))


def _marks(store: Store, captures: str) -> dict[int, int]:
    """Capture number -> 56 bits of its number, digest and run, which a query gives."""
    runs = store.connection.execute("SELECT run_id, started, version, parameters FROM run")
    made_by = {run: repr(facts) for run, *facts in runs.fetchall()}
    texts = (
        (number, f"{number} {digest} {made_by.get(run)}")
        for number, digest, run in store.connection.execute(captures).fetchall()
    )
    return {
        number: int.from_bytes(hashlib.sha256(text.encode()).digest()[:7], "big")
        for number, text in texts
    }


@dataclass(frozen=True, eq=False)
class _Former:
    """Rows of a capture in a former cache, which are not checked yet."""

    rows: NDArray[Any]
    value: float
    checksum: int

    @property
    def is_sound(self) -> bool:
        return page_checksum(self.rows) == self.checksum


def _former_rows(store: Store, kind: str) -> dict[int, _Former]:
    """Mark of a capture -> its rows in the newest cache that can be read."""
    return _rows_in(_newest(store, kind))


_Newest = tuple[str, Arrays] | None
"""How the names of the files of a cache of rows begin, and its arrays; None if there is none."""


def _rows_in(newest: _Newest) -> dict[int, _Former]:
    """Mark of a capture -> its rows in a cache."""
    if newest is None:
        return {}
    _, arrays = newest
    rows = arrays["rows"]
    parts = (rows[low:high] for low, high in pairwise(arrays["bounds"].tolist()))
    facts = zip(parts, arrays["values"].tolist(), arrays["sums"].tolist())
    return dict(zip(arrays["marks"].tolist(), (_Former(*each) for each in facts)))


def _newest(store: Store, kind: str) -> _Newest:
    """The newest cache of rows that can be read."""
    with suppress(OSError), _cache(store) as folder:
        ours = [name for name in folder.names() if _ours(kind).fullmatch(name)]
        listed = [name.removesuffix(".json") for name in ours if name.endswith(".json")]
        for stem in sorted(listed, key=lambda stem: _written(folder, stem), reverse=True):
            with suppress(*_UNUSABLE):
                return stem, _read_arrays(folder, stem)
    return None


def _written(folder: OwnFolder, stem: str) -> float:
    """When a list was last written; 0 if another process has deleted it meanwhile."""
    with suppress(OSError):
        return folder.status(f"{stem}.json").st_mtime
    return 0.0


def _rows_of(
    marks: Mapping[int, int],
    former: Mapping[int, _Former],
    make: Make,
    ready: Mapping[int, Made],
) -> Iterator[tuple[int, Made | _Former]]:
    """Every capture with its rows and number, made a few captures at a time where they are new."""
    numbers = list(marks)
    for first in range(0, len(numbers), _AT_ONCE):
        some = numbers[first : first + _AT_ONCE]
        new = [number for number in some if number not in ready and marks[number] not in former]
        made = make(new) if new else {}
        for number in some:
            if number in ready:
                yield number, ready[number]
            elif number in made:
                yield number, made[number]
            elif marks[number] in former:
                yield number, former[marks[number]]


def _in_memory(
    marks: Mapping[int, int],
    former: Mapping[int, _Former],
    make: Make,
    ready: Mapping[int, Made] = MappingProxyType({}),
) -> dict[int, Made]:
    """Rows and number of captures, those of a former cache only where they are sound."""
    sound = {mark: former[mark] for mark in marks.values() if mark in former}
    sound = {mark: one for mark, one in sound.items() if one.is_sound}
    found = _rows_of(marks, sound, make, ready)
    return {n: (one.rows, one.value) if isinstance(one, _Former) else one for n, one in found}


def _begin_with_former(
    folder: OwnFolder, newest: _Newest, stem: str, marks: Mapping[int, int], make: Make
) -> tuple[Mapping[str, NDArray[Any]], Mapping[int, int]]:
    """Arrays of the former cache, whose file gets the new name, and the captures behind them.

    No arrays and all captures where the former ones are not the first now, where another list may
    use the file too, or where the file system has no links.
    """
    if newest is None:
        return _NONE, marks
    former, arrays = newest
    known = arrays["marks"].tolist()
    held = set(known)
    last = max((n for n, mark in enumerate(marks.values(), 1) if mark in held), default=0)
    first = dict(islice(marks.items(), last))
    damaged = [number for number, mark in first.items() if mark not in held]
    same = known == [mark for mark in first.values() if mark in held]
    if not (same and known) or len(damaged) > _AT_ONCE or (damaged and make(damaged)):
        return _NONE, marks
    name = f"{stem}-rows.npy"
    with suppress(OSError):
        folder.link(f"{former}-rows.npy", name)
        if folder.status(name).st_nlink == 2:
            return arrays, dict(islice(marks.items(), last, None))
        folder.remove(name)  # others write behind these rows, or keep the file as it is
    return _NONE, marks


def _write_rows(
    folder: OwnFolder,
    kind: str,
    stem: str,
    marks: Mapping[int, int],
    parts: Iterable[tuple[int, Made | _Former]],
    begun: Mapping[str, NDArray[Any]],
) -> None:
    """Write rows to the cache as they are made; former ones keep their checksums.

    `begun`: Arrays of the captures whose rows are in the file already.
    """
    name = f"{stem}-rows.npy"
    numbers, values, sums = (
        begun[each].tolist() if begun else [] for each in ("capture_ids", "values", "sums")
    )
    bounds: list[int] = begun["bounds"].tolist() if begun else [0]
    shape, kind_of_rows = (0, 0), np.dtype(np.float32)
    with _growing(folder, name, begun["rows"]) if begun else folder.draft(name) as file:
        if begun:
            shape, kind_of_rows = begun["rows"].shape, begun["rows"].dtype
        for number, one in parts:
            rows, value = (one.rows, one.value) if isinstance(one, _Former) else one
            if not numbers:
                shape, kind_of_rows = rows.shape, rows.dtype
                _write_head(file, shape, kind_of_rows)
            rows = np.ascontiguousarray(rows)
            file.write(rows.data)
            numbers.append(number)
            bounds.append(bounds[-1] + len(rows))
            sums.append(one.checksum if isinstance(one, _Former) else page_checksum(rows))
            values.append(value)
        file.seek(0)
        _write_head(file, (bounds[-1], shape[1]), kind_of_rows)
    arrays = {
        "capture_ids": np.array(numbers, dtype=np.int64),
        "bounds": np.array(bounds, dtype=np.int64),
        "values": np.array(values, dtype=np.float64),
        "marks": np.array([marks[number] for number in numbers], dtype=np.int64),
        "sums": np.array(sums, dtype=np.uint64),
    }
    written = {"rows": _mapped(folder, name)}
    _write_arrays(folder, kind, stem, arrays, written)


@contextmanager
def _growing(folder: OwnFolder, name: str, rows: NDArray[Any]) -> Iterator[BinaryIO]:
    """Open a file behind the rows of a list; what is behind them belongs to no list."""
    with folder.open(name, os.O_RDWR) as file:
        _read_head(file)
        file.seek(rows.nbytes, os.SEEK_CUR)
        yield file
        file.flush()
        os.fsync(file.fileno())


def _write_head(file: BinaryIO, shape: tuple[int, int], kind: np.dtype[Any]) -> None:
    """Write the head of a file of rows; it is as long for any number of rows."""
    head = {"descr": kind.str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, head)


def is_cached(store: Store, kind: str) -> bool:
    """Whether the cache holds arrays of the current motions; they may yet prove to be damaged."""
    name = f"{_stem(store, kind)}.json"
    with suppress(OSError), _cache(store) as folder:
        return name in folder.names()
    return False


def _cache(store: Store, *, make: bool = False) -> AbstractContextManager[OwnFolder]:
    """Open the folder of the cache."""
    return own_folder(store.path.with_name(f"{store.path.name}.cache"), store.tell, make=make)


def _stem(store: Store, kind: str, mark: str = "", of_motions: bool = True) -> str:
    """How the names of the files of these arrays begin."""
    revision = read_meta(store, "motion_revision") if of_motions else ""
    if mark:
        revision = hashlib.sha256(f"{revision} {mark}".encode()).hexdigest()[:32]
    return f"{kind}-{revision}"


def _read_arrays(folder: OwnFolder, stem: str) -> Arrays:
    """Map all arrays of the list, and check that each matches its entry."""
    with folder.open(f"{stem}.json") as file:
        listed = parse_json(file.read(MOST_TEXT))  # what is longer is cut, and not whole
    if listed["version"] != _version() or listed["checksum"] != _list_checksum(listed["arrays"]):
        raise ValueError("the list is damaged")
    arrays: Arrays = {}
    for name, facts in listed["arrays"].items():
        array = _mapped(folder, f"{stem}-{name}.npy")
        if facts["checksum"] is None:
            array = array[: facts["shape"][0]]  # the rows behind are of captures that came later
        if _facts(array, facts["checksum"] is not None) != facts:
            raise ValueError(f"the array {name} is damaged")
        # slices and sums of a memory map take 20 times as long
        arrays[name] = array.view(np.ndarray)
    return arrays


def _mapped(folder: OwnFolder, name: str) -> NDArray[Any]:
    """The array of a file, memory-mapped."""
    with folder.open(name) as file:
        shape, is_fortran, kind = _read_head(file)
        if kind.hasobject:
            raise ValueError(f"the array {name} holds no numbers")
        order: Literal["F", "C"] = "F" if is_fortran else "C"
        return np.memmap(file, kind, "r", file.tell(), shape, order)


def _read_head(file: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Read what stands before the values of an array."""
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("another format of arrays")
    with _parsing:
        return np.lib.format.read_array_header_1_0(file)


def _write_arrays(
    folder: OwnFolder,
    kind: str,
    stem: str,
    arrays: Arrays,
    written: Mapping[str, NDArray[Any]] = _NONE,
) -> None:
    """Write the arrays, then their list; then delete the files of other revisions.

    `written`: Arrays whose files are there already; they have checksums of their own.
    """
    for name, array in arrays.items():
        with folder.draft(f"{stem}-{name}.npy") as file:
            np.save(file, array, allow_pickle=False)
    arrays = {**arrays, **written}
    facts = {name: _facts(array, name not in written) for name, array in arrays.items()}
    listed = {"version": _version(), "checksum": _list_checksum(facts), "arrays": facts}
    with folder.draft(f"{stem}.json") as file:
        file.write(json.dumps(listed).encode())
    current = {f"{stem}-{name}.npy" for name in arrays} | {f"{stem}.json"}
    ours = _ours(kind)
    folder.sweep(ours.pattern)
    names = set(folder.names()) - current  # a user may keep files here, such as motions-2024.json
    folder.remove(*(name for name in names if ours.fullmatch(name)))


def _ours(kind: str) -> re.Pattern[str]:
    """Names of files of the cache."""
    return re.compile(rf"{kind}-[0-9a-f]{{32}}(-[a-z_]+\.npy|\.json)")


def _facts(array: NDArray[Any], checked: bool = True) -> dict[str, Any]:
    """Return the entry of an array in the list: shape, type and, if it is one, the checksum."""
    checksum = page_checksum(np.ascontiguousarray(array)) if checked else None
    return {"shape": list(array.shape), "dtype": array.dtype.str, "checksum": checksum}


def _version() -> str:
    """What a list must have to be read: another motiondb may make other arrays."""
    return f"{_FORMAT}, motiondb {motiondb_version()}"


def _list_checksum(facts: Mapping[str, Any]) -> int:
    """Return the checksum of the list itself, so that a changed name is noticed."""
    return zlib.crc32(json.dumps(facts, sort_keys=True).encode())
