"""Rows of captures that lie in several memory maps, looked at as one array.

A map is compared with its checksum when it is first looked at. Every opening of a database compares
anew, so checksums must be cheap: sums of 8-byte words run at 5 GB a second, CRC-32 at 0.7 GB a
second (measured on 160 MB). The memory of maps is given back after the comparison, and after many
rows were looked at: a process would hold the whole cache, 16 MB an hour of motion.
"""

from __future__ import annotations

import mmap
import os
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, BinaryIO

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import DTypeLike, NDArray

from motiondb.records import IntArray

_PAGE = 4096
"""Bytes that are summed before weighting: the size of a page of memory and of most disks."""
_HELD, _LEAST = 2**26, 2**19
"""Bytes of joined rows that are looked at until memory is given back, and the least that a look at
successive rows counts: the system maps what lies around them, too. By hand: with these, a process
that asked in words of 93 hours held 970 MiB in place of 1,520, in the same processor time."""


class JoinedRows(NDArrayOperatorsMixin):
    """Rows (rows, columns) of captures, end to end, from several arrays.

    What is neither an index nor a shape is asked of the whole, as of any array, and copies it.
    """

    def __init__(
        self,
        parts: Sequence[Callable[[], NDArray[Any]]],
        like: NDArray[Any],
        which: IntArray,
        firsts: IntArray,
        bounds: IntArray,
    ) -> None:
        """Join rows of parts.

        `parts`: Give the arrays, which are checked, when they are first looked at.

        `like`: An array of the same type and columns.

        `which`, `firsts`: The part of every capture, and its first row there.

        `bounds`: Capture n has the rows from bounds[n] to bounds[n + 1].
        """
        follows = (np.diff(which) == 0) & (np.diff(firsts) == np.diff(bounds)[:-1])
        starts = np.flatnonzero(np.concatenate([np.ones(len(which[:1]), dtype=bool), ~follows]))
        self._parts, self._columns, self.dtype = parts, slice(None), like.dtype
        self._looked = Counter[int]()  # Part -> bytes looked at since memory was given back
        self._which, self._bounds = which[starts], np.append(bounds[starts], bounds[-1])
        self._shifts = firsts[starts] - bounds[starts]  # from a row to the one of its part
        self._edges, self._runs = (
            self._bounds.tolist(),
            list(zip(self._which.tolist(), self._shifts.tolist())),
        )
        self.shape = (int(bounds[-1]), like.shape[1])

    @classmethod
    def of(cls, array: NDArray[Any]) -> JoinedRows:
        """The rows of one array."""
        edges = np.array([0, len(array)])
        return cls([lambda: array], array, edges[:1], edges[:1], edges)

    def columns(self, low: int, high: int) -> JoinedRows:
        """Some of the columns, of the same memory."""
        part = object.__new__(JoinedRows)
        vars(part).update(vars(self))
        part._columns, part.shape = slice(low, high), (len(self), high - low)
        return part

    @property
    def size(self) -> int:
        """Number of values."""
        return int(np.prod(self.shape))

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, which: slice | NDArray[Any]) -> NDArray[Any]:
        if not isinstance(which, slice):
            return self._chosen(np.asarray(which))
        start, stop, step = which.indices(len(self))
        pieces: list[NDArray[Any]] = []
        run = bisect_right(self._edges, start) - 1
        while start < stop:
            end, (part, shift) = min(stop, self._edges[run + 1]), self._runs[run]
            rows = self._look_at(part, end - start)
            pieces.append(rows[start + shift : end + shift, self._columns])
            start, run = end, run + 1
        if not pieces:
            return np.empty((0, self.shape[1]), self.dtype)
        whole = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
        return whole[::step]

    def _chosen(self, which: NDArray[Any]) -> NDArray[Any]:
        """Rows by their numbers, or those that are true."""
        numbers = np.flatnonzero(which) if which.dtype == bool else which
        runs = np.searchsorted(self._bounds, numbers, side="right") - 1
        within, parts = numbers + self._shifts[runs], self._which[runs]
        found = np.empty((*numbers.shape, self.shape[1]), self.dtype)
        for part in np.unique(parts).tolist():
            here = parts == part
            rows = self._look_at(part, int(here.sum()))
            found[here] = rows[within[here], self._columns]
        return found

    def _look_at(self, part: int, n_rows: int) -> NDArray[Any]:
        """The array of a part, of which so many rows are looked at next."""
        rows = self._parts[part]()
        self._looked[part] += max(n_rows * rows.strides[0], _LEAST)
        if self._looked.total() > _HELD:
            for each in [*self._looked]:
                give_back(self._parts[each]())
            self._looked.clear()
        return rows

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        whole = self[:].astype(dtype or self.dtype, copy=False)
        return whole.copy() if copy else whole

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: object, **named: object
    ) -> object:
        arrays = (np.asarray(x) if isinstance(x, JoinedRows) else x for x in inputs)
        return getattr(ufunc, method)(*arrays, **named)

    def __getattr__(self, name: str) -> object:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(np.asarray(self), name)

    def __reduce__(self) -> tuple[Callable[..., NDArray[Any]], tuple[NDArray[Any]]]:
        """Another process gets the rows as an array."""
        return np.asarray, (np.asarray(self),)


def give_back(array: NDArray[Any]) -> None:
    """Give back the memory of the file that an array is mapped from; the array stays as it is."""
    base: object = array
    while isinstance(base, np.ndarray | memoryview):
        base = base.obj if isinstance(base, memoryview) else base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)


class FileRows:
    """Rows (rows, columns) in an open file, of which memory holds only those that are looked at."""

    def __init__(
        self, file: BinaryIO, shape: tuple[int, int], dtype: DTypeLike, first_byte: int = 0
    ) -> None:
        self._file, self.shape, self.dtype = file, shape, np.dtype(dtype)
        self._first, self._width = first_byte, shape[1] * self.dtype.itemsize
        self.size = shape[0] * shape[1]

    def __len__(self) -> int:
        return self.shape[0]

    def beside(self, shape: tuple[int, int], dtype: DTypeLike) -> FileRows:
        """Further rows, of zeros, behind all others in the same file."""
        first_byte = self._file.seek(0, os.SEEK_END)
        made = FileRows(self._file, shape, dtype, first_byte)
        self._file.truncate(first_byte + shape[0] * made._width)
        return made

    def __getitem__(self, which: slice | NDArray[Any]) -> NDArray[Any]:
        if not isinstance(which, slice):
            numbers = np.arange(len(self))[which]
            edges = np.flatnonzero(np.diff(numbers) != 1) + 1
            runs = np.split(numbers, edges) if len(numbers) else []
            parts = [self[int(run[0]) : int(run[-1]) + 1] for run in runs]
            return np.concatenate([self[:0], *parts])
        start, stop, step = which.indices(len(self))
        read = bytearray(max(stop - start, 0) * self._width)
        self._file.seek(self._first + start * self._width)
        if self._file.readinto(read) != len(read):  # type: ignore[attr-defined]  # of a raw file
            raise OSError("the file is shorter than its rows")
        return np.frombuffer(read, self.dtype).reshape(-1, self.shape[1])[::step]

    def __setitem__(self, which: slice, rows: NDArray[Any]) -> None:
        start, stop, _ = which.indices(len(self))
        self._file.seek(self._first + start * self._width)
        made = np.broadcast_to(rows, (stop - start, self.shape[1]))
        self._file.write(np.ascontiguousarray(made, self.dtype).data)


def page_checksum(array: NDArray[Any]) -> int:
    """Return the sum over pages k of (2 k + 1) times the sum of the page's words, modulo 2^64.

    A page has 4096 bytes and a word has 8. The bytes after the last whole word are added one by
    one. A change of any single word changes the checksum. Swapping two pages usually changes
    it too; it does not where the sums of their words agree. The memory of an array that is mapped
    from a file is given back.

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
    give_back(array)
    return (total + (int(words) + int(last)) * (2 * n_whole + 1)) % 2**64
