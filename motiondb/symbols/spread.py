"""Feature frames of all captures in parts, whole captures in each, which workers hold.

A worker needs only the parts whose pieces of work it computes.

Whatever works on frames takes an array, or a :class:`Spread`, which says who works as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.workers import HERE, Workers, is_array, runs

PART_FRAMES = 2**17
"""Frames of a part (2.4 hours, 13 MB of 24 dimensions), unless one capture is longer. Sums run over
the segments of each part, and then over the parts: another number changes their last bits."""


@dataclass(frozen=True, eq=False)
class Part:
    """Frames of some captures that follow one another."""

    first: int  # Number of its first frame among those of all captures
    frames: FloatArray | Float32Array


@dataclass(frozen=True, eq=False)
class Spread:
    """Frames of all captures, and who works on them."""

    frames: FloatArray | Float32Array  # (frames, dimensions)
    parts: tuple[Part, ...]  # The same, whole captures in each
    workers: Workers = HERE

    def of_parts(self, starts: IntArray) -> Iterator[tuple[Part, IntArray]]:
        """Parts, each with the numbers of those intervals in it that begin at some frames."""
        number = np.searchsorted([part.first for part in self.parts], starts, side="right") - 1
        for n, part in enumerate(self.parts):
            if len(own := np.flatnonzero(number == n)):
                yield part, own

    def n_pieces(self, seconds: float) -> int:
        """Number of pieces into which the work on a part is divided; `seconds`: of all parts."""
        return math.ceil(self.workers.n_pieces(seconds) / len(self.parts))

    def captures(self, bounds: IntArray, seconds: float) -> list[Captures]:
        """Captures in pieces of work; `bounds`: their first frames, and end; `seconds`: a frame."""
        n_pieces = self.n_pieces(seconds * len(self.frames))
        spans = list(pairwise(bounds.tolist()))
        return [
            (part, [spans[n] for n in some])
            for part, own in self.of_parts(bounds[:-1])
            for some in runs(own.tolist(), n_pieces)
        ]


Frames: TypeAlias = FloatArray | Float32Array | Spread
Captures: TypeAlias = tuple[Part, Sequence[tuple[int, int]]]
"""Some captures of a part: their first frames and ends, among those of all captures."""


def spread(frames: FloatArray | Float32Array, bounds: IntArray, workers: Workers = HERE) -> Spread:
    """Divide frames (frames, dimensions) into parts; `bounds`: first frames of captures, and end.

    >>> [part.first for part in spread(np.zeros((9, 1)), np.array([0, 4, 9])).parts]
    [0]
    """
    n_parts = max(1, math.ceil(len(frames) / PART_FRAMES))
    wanted = len(frames) * np.arange(1, n_parts) / n_parts
    edges = np.unique([0, *bounds[np.searchsorted(bounds, wanted)], len(frames)]).tolist()
    parts = tuple(Part(a, frames[a:b]) for a, b in pairwise(edges))
    return Spread(frames, parts or (Part(0, frames),), workers)


def as_spread(frames: Frames) -> Spread:
    """Frames in an array are one part, and this process works on them."""
    return frames if isinstance(frames, Spread) else Spread(frames, (Part(0, frames),))


def frames_of(some: Captures) -> Iterator[tuple[int, FloatArray | Float32Array]]:
    """First frame and frames of each of some captures."""
    part, spans = some
    for low, high in spans:
        yield low, part.frames[low - part.first : high - part.first]


def are_segments(found: IntArray, some: Captures) -> bool:
    """Whether starts and ends (2, segments) tile some captures, and none reaches over two."""
    firsts = [low for low, high in some[1] if low < high]
    starts, ends = found
    return (
        is_array(found, (2, None), "i")
        and bool((starts < ends).all())
        and np.array_equal(starts[1:], ends[:-1])
        and {*firsts} <= {*starts.tolist()}
        and [*starts[:1], *ends[-1:]] == ([firsts[0], some[1][-1][1]] if firsts else [])
    )
