"""Segments as jobs: checked, sorted, grouped into blocks of frames and into shares of workers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import cache
from itertools import pairwise
from threading import Lock
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from motiondb.errors import MotionDBError
from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

FRAMES_AT_ONCE = 256
"""Frames whose densities are computed together, unless one segment is longer. By hand."""
FIT_SECONDS, SCORE_SECONDS, CUT_SECONDS = 4e-8, 1.5e-9, 4.5e-9
"""Time of one processor for a value of a symbol's states at a frame: in the E step, in scoring, and
in cutting by the symbols. Measured on real captures; they decide only how work is divided."""


def check_segments(
    symbols: MotionSymbols, frames: FloatArray | Float32Array, starts: ArrayLike, ends: ArrayLike
) -> tuple[IntArray, IntArray]:
    """Refuse frames of another dimension, and segments that are empty or leave the frames."""
    n_dims = symbols.means.shape[2]
    starts, ends = np.asarray(starts, dtype=np.int64), np.asarray(ends, dtype=np.int64)
    if frames.ndim != 2 or frames.shape[1] != n_dims:
        raise MotionDBError(
            f"frames: expected {n_dims} columns as the symbols have, found shape {frames.shape}. "
            "Project the features into the symbols' space."
        )
    wrong = np.flatnonzero((starts < 0) | (ends <= starts) | (ends > len(frames)))
    if len(wrong):
        i = int(wrong[0])
        raise MotionDBError(
            f"segment {i}: expected 0 <= start < end <= {len(frames)}, found "
            f"[{starts[i]}, {ends[i]}). "
            "Leave out empty segments and those beyond the frames."
        )
    return starts, ends


def check_assignment(
    symbols: MotionSymbols, starts: IntArray, ends: IntArray, assignment: ArrayLike
) -> IntArray:
    """Put segments with their symbols into one array, sorted by symbol."""
    symbol = np.asarray(assignment, dtype=np.int64)
    if len(symbol) != len(starts):
        raise MotionDBError(
            f"assignment: expected a symbol for each of {len(starts)} segments, found "
            f"{len(symbol)}. Give one number a segment."
        )
    if len(symbol) and (symbol.min() < 0 or symbol.max() >= symbols.n_symbols):
        wrong = int(symbol.max() if symbol.max() >= symbols.n_symbols else symbol.min())
        raise MotionDBError(
            f"assignment: expected symbols from 0 to {symbols.n_symbols - 1}, found {wrong}. "
            "Number the symbols from 0."
        )
    segments = np.stack([starts, ends, symbol, np.arange(len(symbol))], axis=1)
    return np.ascontiguousarray(segments[np.argsort(symbol, kind="stable")])


Block: TypeAlias = tuple[int, int, IntArray]
"""First frame, end, and segments (n, 3) in it: their starts and ends there, and their numbers."""


def frame_blocks(starts: IntArray, ends: IntArray, which: IntArray) -> Iterator[Block]:
    """Group some of the segments into ranges of frames; `starts`, `ends` (segments,)."""
    order = which[np.argsort(starts[which], kind="stable")]
    first = 0
    while first < len(order):
        low, high = int(starts[order[first]]), int(ends[order[first]])
        last = first + 1
        while last < len(order):
            reach = max(high, int(ends[order[last]]))
            if reach - low > FRAMES_AT_ONCE:
                break
            high, last = reach, last + 1
        some = order[first:last]
        yield low, high, np.stack([starts[some] - low, ends[some] - low, some], axis=1)
        first = last


def shares(work: IntArray, groups: IntArray, n_shares: int) -> list[slice]:
    """Divide jobs, sorted by group, into runs of about equal work without splitting a group.

    >>> shares(np.array([9, 9, 9]), np.array([0, 0, 1]), 8)
    [slice(0, 2, None), slice(2, 3, None)]
    >>> shares(np.array([1, 1, 1]), np.array([0, 0, 1]), 1)
    [slice(0, 3, None)]
    """
    total = np.cumsum(work)
    if len(work) == 0 or n_shares == 1:
        return [slice(0, len(work))]
    cuts = np.searchsorted(total, total[-1] * np.arange(1, n_shares) / n_shares)
    edges = np.unique([0, *np.searchsorted(groups, groups[cuts]), len(work)])
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def one_blas_thread() -> AbstractContextManager[object]:
    """Limit matrix products to one thread: two thread pools would compete for the processors.

    The limit is that of the process: it ends when the last of all blocks ends.
    """
    return _LIMIT


class _OneThread:
    """The blocks of all threads in which matrix products have one thread."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._n_inside = 0

    def __enter__(self) -> None:
        with self._lock:
            limiter = _thread_pools().limit(limits=1, user_api="blas")
            _release()
            if not self._n_inside:
                self._first = limiter  # knows the numbers of threads from before
            self._n_inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._n_inside -= 1
            if not self._n_inside:
                self._first.restore_original_limits()
                _release()


_LIMIT = _OneThread()


def _release() -> None:
    """Let other threads set the limit: newer threadpoolctl obeys one thread alone until then."""
    import threadpoolctl

    controller = getattr(threadpoolctl, "OpenBLASController", None)
    getattr(controller, "clear_controlling_thread", lambda: None)()


@cache
def _thread_pools() -> ThreadpoolController:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
