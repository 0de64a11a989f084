"""Arrays of all motions, memory-mapped from files beside the database.

The folder ``motions.duckdb.cache/`` holds files ``KIND-KEY-DIGEST.arrays``. A file is written once,
under a temporary name, flushed to the disk, and renamed. It has a head, which gives names, shapes,
types and checksums of its arrays, and the arrays themselves. DIGEST is that of the head. KEY is a
digest of what the arrays follow from, such as the random mark that the store renews with every
change of its motions.

Rows that belong to captures lie in batches, one file each, where every capture has a mark: a digest
of its number, its file, and the run that made it. New captures make a new batch. Then, or where
more than half of a batch belongs to captures that were removed, small batches are joined.

An array that does not match its head is rebuilt from the store, so the folder can be deleted or
damaged at any time. If the folder cannot be written, the arrays stay in memory. No link is
followed, to the folder or in it (:mod:`motiondb.files.own_folder`).

The checksums are compared whenever arrays are mapped, once for each opening of a database; those of
a batch when its rows are looked at.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from functools import cache, partial
from itertools import chain, islice
from types import MappingProxyType
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from motiondb.files.json_text import parse_json
from motiondb.files.own_folder import OwnFolder, own_folder
from motiondb.files.safe_files import MOST_TEXT
from motiondb.records import FloatArray, IntArray, Motion
from motiondb.store.catalogue.captures import load_motion, readable_motions
from motiondb.store.catalogue.joined_rows import JoinedRows, page_checksum
from motiondb.store.connection.handle import Store
from motiondb.store.connection.migrations import motiondb_version
from motiondb.store.connection.transactions import read_meta

Arrays = dict[str, NDArray[Any]]
_AT_ONCE = 64  # Captures whose rows are made together: bounds memory
_BATCH = 2**25  # Bytes of rows after which a batch is closed
_LEAST = 0.5  # Share of it that is not small, and of its rows that are still of captures
_ALIGNED = 64  # Arrays begin at multiples of so many bytes of a file

_FORMAT = 2  # Version of the files' format
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
    key = _key(read_meta(store, "motion_revision") if of_motions else "", mark)
    with suppress(OSError), _cache(store) as folder:
        for name in _names(folder, kind, key):
            with suppress(*_UNUSABLE):
                return _read_whole(folder, name)
    arrays = dict(build())
    with suppress(*_UNUSABLE), _cache(store, make=True) as folder:
        name = _write(folder, kind, key, arrays)
        _remove_all_but(folder, kind, {name})
        return _read_whole(folder, name)
    return arrays


@dataclass(frozen=True, eq=False)
class CaptureRows:
    """Arrays of every capture, end to end, in order of capture number."""

    capture_ids: IntArray  # (captures,): their numbers, ascending; none whose motion is damaged
    bounds: IntArray  # (captures + 1,): capture n has the rows from bounds[n] to bounds[n + 1]
    rows: JoinedRows  # (rows, columns)
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
    mark: str = "",
) -> CaptureRows:
    """Rows that follow from the motion of each capture and a mark, from the cache where possible.

    Only those of new captures are made. Rows are used only for a capture with the same number,
    file, and run that added it. Within a transaction the cache is read but not written.

    `make`: Makes rows and number of some motions, in their order.

    `ready`: Capture number -> rows and number that were made already (:func:`lacking_rows`).

    `mark`: What rows follow from beside the motion.
    """

    def of_captures(numbers: Sequence[int]) -> Mapping[int, Made]:
        motions = dict(readable_motions(store, numbers))
        return dict(zip(motions, make(list(motions.values()))))

    return _cached(store, kind, _marks(store, _CAPTURES, mark), of_captures, ready)


def cached_segment_rows(
    store: Store,
    kind: str,
    make: Make,
    ready: Mapping[int, Made] = MappingProxyType({}),
    only: Iterable[int] | None = None,
) -> CaptureRows:
    """As :func:`cached_rows`, of rows that follow from the motion and the segments of a capture.

    Rows are used for a capture whose segments are of the same run.

    `only`: The numbers of captures; then nothing is written.
    """
    marks = _marks(store, _SEGMENTS)
    if only is not None:
        wanted = set(only)
        marks = {number: mark for number, mark in marks.items() if number in wanted}
    return _cached(store, kind, marks, make, ready, may_write=only is None)


def lacking_rows(store: Store, kind: str, mark: str = "") -> dict[int, Motion]:
    """Motions of the captures whose rows are not in the cache, by number."""
    held = {mark for batch in _load_batches(store, kind) for mark in batch.marks.tolist()}
    marks = _marks(store, _CAPTURES, mark)
    new = [number for number, mark_of in marks.items() if mark_of not in held]
    return dict(readable_motions(store, new))


def is_cached(store: Store, kind: str) -> bool:
    """Whether the cache holds rows of captures; they may yet prove to be damaged."""
    return bool(_load_batches(store, kind))


@dataclass(frozen=True, eq=False)
class _Batch:
    """Rows of some captures, end to end, in a file or in memory."""

    marks: IntArray  # (captures,)
    bounds: IntArray  # (captures + 1,): those with the nth mark are from bounds[n] to bounds[n + 1]
    values: FloatArray  # (captures,)
    rows: NDArray[Any]
    name: str = ""  # Of the file
    checksum: int | None = None  # That its rows should have

    def is_sound(self) -> bool:
        return self.checksum is None or page_checksum(self.rows) == self.checksum

    def places(self, numbers: Mapping[int, int]) -> list[tuple[int, int]]:
        """Place and number of the captures whose mark -> number is known."""
        marks = enumerate(self.marks.tolist())
        return [(n, numbers[mark]) for n, mark in marks if mark in numbers]

    def share(self, numbers: Mapping[int, int]) -> float:
        """The share of the rows that belong to these captures."""
        sizes = np.diff(self.bounds)
        live = sum(int(sizes[n]) for n, _ in self.places(numbers))
        return live / len(self.rows) if len(self.rows) else 1.0


def _cached(
    store: Store,
    kind: str,
    marks: Mapping[int, int],
    make: Make,
    ready: Mapping[int, Made],
    *,
    may_write: bool = True,
) -> CaptureRows:
    """Rows of captures, given by number -> mark (:func:`_marks`)."""
    batches = _load_batches(store, kind)
    held = {mark for batch in batches for mark in batch.marks.tolist()}
    new = _make_some([n for n, mark in marks.items() if mark not in held], make, ready)
    if not may_write or store.in_transaction:
        batches += _to_batches(marks, new)
        return _join(store, batches, marks, make)
    left, first = {mark: number for number, mark in marks.items()}, list(islice(new, 1))
    kept, small, is_worn = list[_Batch](), list[Iterator[tuple[int, Made]]](), False
    # The largest first: after a kill, smaller ones may hold a capture once more
    for batch in sorted(batches, key=lambda one: -len(one.rows)):
        own = {mark: left.pop(mark) for mark in batch.marks.tolist() if mark in left}
        share = batch.share(own)
        is_worn |= share < _LEAST
        if share >= _LEAST <= share * batch.rows.nbytes / _BATCH:
            kept.append(batch)
        else:
            small.append(_live_rows(batch, own, make))
    if not (first or is_worn):
        return _join(store, batches, marks, make)
    former = chain.from_iterable(small)
    for batch in _to_batches(marks, chain(former, first, new)):
        kept.append(_keep(store, kind, batch))
    current = {batch.name for batch in kept}
    if "" not in current:  # else there is no room
        with suppress(OSError), _cache(store) as folder:
            _remove_all_but(folder, kind, current)
    return _join(store, kept, marks, make)


def _make_some(
    numbers: Sequence[int], make: Make, ready: Mapping[int, Made]
) -> Iterator[tuple[int, Made]]:
    """Rows and number of captures, made a few captures at a time."""
    for first in range(0, len(numbers), _AT_ONCE):
        some = numbers[first : first + _AT_ONCE]
        new = [number for number in some if number not in ready]
        made = make(new) if new else {}
        for number in some:  # ready ones may be computed when they are asked for
            if number in ready or number in made:
                yield number, ready[number] if number in ready else made[number]


def _live_rows(batch: _Batch, numbers: Mapping[int, int], make: Make) -> Iterator[tuple[int, Made]]:
    """Rows and number of the captures of a batch; made anew where it is damaged."""
    places, bounds = batch.places(numbers), batch.bounds
    if not batch.is_sound():
        yield from _make_some([number for _, number in places], make, {})
        return
    for n, number in places:
        yield number, (batch.rows[bounds[n] : bounds[n + 1]], float(batch.values[n]))


def _to_batches(marks: Mapping[int, int], parts: Iterable[tuple[int, Made]]) -> Iterator[_Batch]:
    """Join rows of captures until a batch is full."""
    some, n_bytes = dict[int, Made](), 0
    for number, made in parts:
        some[number] = made
        n_bytes += made[0].nbytes
        if n_bytes >= _BATCH:
            yield _to_batch(marks, some)
            some, n_bytes = {}, 0
    if some:
        yield _to_batch(marks, some)


def _to_batch(marks: Mapping[int, int], made: Mapping[int, Made]) -> _Batch:
    rows, values = zip(*made.values())
    return _Batch(
        np.array([marks[number] for number in made], dtype=np.int64),
        np.cumsum([0, *map(len, rows)], dtype=np.int64),
        np.array(values, dtype=np.float64),
        np.concatenate(rows),
    )


def _keep(store: Store, kind: str, batch: _Batch) -> _Batch:
    """The batch as a file, or as it is where none can be written."""
    arrays = {name: getattr(batch, name) for name in ("marks", "bounds", "values", "rows")}
    with suppress(*_UNUSABLE), _cache(store, make=True) as folder:
        return _read_batch(folder, _write(folder, kind, _key(), arrays))
    return batch


def _load_batches(store: Store, kind: str) -> list[_Batch]:
    """The batches of rows that can be read; the rows themselves are not looked at."""
    batches = list[_Batch]()
    with suppress(OSError), _cache(store) as folder:
        for name in _names(folder, kind, _key()):
            with suppress(*_UNUSABLE):
                batches.append(_read_batch(folder, name))
    return batches


def _read_batch(folder: OwnFolder, name: str) -> _Batch:
    arrays, sums = _read(folder, name)
    rows = arrays.pop("rows")
    _check(arrays, sums)
    return _Batch(rows=rows, name=name, checksum=sums["rows"], **arrays)


def _join(
    store: Store, batches: Sequence[_Batch], marks: Mapping[int, int], make: Make
) -> CaptureRows:
    """The rows of the captures that have some, in their order."""
    numbers = {mark: number for number, mark in marks.items()}
    placed = [(batch, own) for batch in batches if (own := batch.places(numbers))]
    batches = [batch for batch, _ in placed]
    found = {number: (which, n) for which, (_, own) in enumerate(placed) for n, number in own}
    order = sorted(found)
    places = [found[number] for number in order]
    firsts, ends = (
        np.array([batches[which].bounds[n + k] for which, n in places], dtype=np.int64)
        for k in (0, 1)
    )

    @cache
    def rows_of(which: int) -> NDArray[Any]:
        return _mended(store, batches[which], numbers, make)

    rows = JoinedRows(
        [partial(rows_of, which) for which in range(len(batches))],
        batches[0].rows if batches else np.zeros((0, 0)),
        np.array([which for which, _ in places], dtype=np.int64),
        firsts,
        bounds := np.append(0, np.cumsum(ends - firsts)).astype(np.int64),
    )
    values = np.array([batches[which].values[n] for which, n in places], dtype=np.float64)
    return CaptureRows(np.array(order, dtype=np.int64), bounds, rows, values)


def _mended(store: Store, batch: _Batch, numbers: Mapping[int, int], make: Make) -> NDArray[Any]:
    """The rows of a batch; of a damaged one they are made anew, and its file is removed."""
    if batch.is_sound():
        return batch.rows
    with suppress(OSError), _cache(store) as folder:
        folder.remove(batch.name)
    places = batch.places(numbers)
    rows, made = np.zeros_like(batch.rows), make([number for _, number in places])
    for n, number in places:
        if number not in made:
            load_motion(store, number)  # tells the damage of the motion
        rows[batch.bounds[n] : batch.bounds[n + 1]] = made[number][0]
    return rows


_CAPTURES = (
    "SELECT capture_id, sha256, run_id FROM capture WHERE leg_length > 0 ORDER BY capture_id"
)
_SEGMENTS = "SELECT DISTINCT capture_id, '', run_id FROM segment ORDER BY capture_id"
"""What tells the motions, and the segments, of captures from all others."""


def _marks(store: Store, captures: str, mark: str = "") -> dict[int, int]:
    """Capture number -> 56 bits of its number, digest and run, which a query gives, and a mark."""
    runs = store.connection.execute("SELECT run_id, started, version, parameters FROM run")
    made_by = {run: repr(facts) for run, *facts in runs.fetchall()}
    texts = (
        (number, f"{number} {digest} {made_by.get(run)}{mark}")
        for number, digest, run in store.connection.execute(captures).fetchall()
    )
    return {
        number: int.from_bytes(hashlib.sha256(text.encode()).digest()[:7], "big")
        for number, text in texts
    }


def _cache(store: Store, *, make: bool = False) -> AbstractContextManager[OwnFolder]:
    """Open the folder of the cache."""
    return own_folder(store.path.with_name(f"{store.path.name}.cache"), store.tell, make=make)


def _key(*facts: str) -> str:
    """A digest of what arrays follow from, and of motiondb: another one may make other arrays."""
    return _digest(" ".join([str(_FORMAT), motiondb_version(), *facts]).encode())


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:32]


def _names(folder: OwnFolder, kind: str, key: str) -> list[str]:
    """The files of a key, in a fixed order."""
    pattern = re.compile(rf"{kind}-{key}-[0-9a-f]{{32}}\.arrays")
    return sorted(name for name in folder.names() if pattern.fullmatch(name))


def _remove_all_but(folder: OwnFolder, kind: str, current: set[str]) -> None:
    """Remove the other files of a kind, and those of former formats (``features``, ``.npy``)."""
    ours = re.compile(rf"({kind}|features)-[0-9a-f]{{32}}(-[0-9a-z_]+\.(arrays|npy)|\.json)")
    folder.sweep(ours.pattern)
    names = set(folder.names()) - current  # a user may keep files here, such as motions-2024.json
    folder.remove(*(name for name in names if ours.fullmatch(name)))


def _write(folder: OwnFolder, kind: str, key: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    """Write arrays into one file; return its name."""
    arrays = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    facts = {n: [a.dtype.str, list(a.shape), page_checksum(a)] for n, a in arrays.items()}
    head = json.dumps(facts).encode()
    name = f"{kind}-{key}-{_digest(head)}.arrays"
    with folder.draft(name) as file:
        _write_padded(file, len(head).to_bytes(8, "little") + head)
        for array in arrays.values():
            _write_padded(file, array.reshape(-1).view(np.uint8).data)
    return name


def _write_padded(file: BinaryIO, content: bytes | memoryview) -> None:
    file.write(content)
    file.write(bytes(-len(content) % _ALIGNED))


def _read(folder: OwnFolder, name: str) -> tuple[Arrays, dict[str, int]]:
    """The arrays of a file, memory-mapped, and the checksums that they should have."""
    with folder.open(name) as file:
        # slices and sums of a memory map take 20 times as long
        content: NDArray[np.uint8] = np.memmap(file, np.uint8, "r").view(np.ndarray)
    end = 8 + min(int.from_bytes(content[:8].tobytes(), "little"), MOST_TEXT)
    head = content[8:end].tobytes()
    if not name.endswith(f"-{_digest(head)}.arrays"):
        raise ValueError("the head is damaged")
    arrays, sums = Arrays(), dict[str, int]()
    for each, (kind, shape, checksum) in parse_json(head).items():
        start = -(-end // _ALIGNED) * _ALIGNED
        end = start + np.dtype(kind).itemsize * int(np.prod(shape))
        arrays[each] = content[start:end].view(kind).reshape(shape)
        sums[each] = checksum
    return arrays, sums


def _check(arrays: Arrays, sums: Mapping[str, int]) -> None:
    """Compare arrays with their checksums."""
    for name, array in arrays.items():
        if page_checksum(array) != sums[name]:
            raise ValueError(f"the array {name} is damaged")


def _read_whole(folder: OwnFolder, name: str) -> Arrays:
    arrays, sums = _read(folder, name)
    _check(arrays, sums)
    return arrays
