"""Feature frames of all captures in runs of captures, so that each of several workers holds some.

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
from motiondb.workers import HERE, Workers, runs

RUN_FRAMES = 2**17
"""Frames of a run (2.4 hours, 13 MB of 24 dimensions), unless one capture is longer. Sums run over
the segments of each run, and then over the runs: another number changes their last bits."""


@dataclass(frozen=True, eq=False)
class Run:
    """Frames of some captures that follow one another."""

    first: int  # Number of its first frame among those of all captures
    frames: FloatArray | Float32Array


@dataclass(frozen=True, eq=False)
class Spread:
    """Frames of all captures, and who works on them."""

    frames: FloatArray | Float32Array  # (frames, dimensions)
    runs: tuple[Run, ...]  # The same, whole captures in each
    workers: Workers = HERE

    def of_runs(self, starts: IntArray) -> Iterator[tuple[Run, IntArray]]:
        """Runs, each with the numbers of those intervals in it that begin at some frames."""
        number = np.searchsorted([run.first for run in self.runs], starts, side="right") - 1
        for n, run in enumerate(self.runs):
            if len(own := np.flatnonzero(number == n)):
                yield run, own

    def n_pieces(self, seconds: float) -> int:
        """Number of pieces into which the work on a run is divided; `seconds`: of all runs."""
        return math.ceil(self.workers.n_pieces(seconds) / len(self.runs))

    def captures(self, bounds: IntArray, seconds: float) -> list[Captures]:
        """Captures in pieces of work; `bounds`: their first frames, and end; `seconds`: a frame."""
        n_pieces = self.n_pieces(seconds * len(self.frames))
        spans = list(pairwise(bounds.tolist()))
        return [
            (run, [spans[n] for n in some])
            for run, own in self.of_runs(bounds[:-1])
            for some in runs(own.tolist(), n_pieces)
        ]


Frames: TypeAlias = FloatArray | Float32Array | Spread
Captures: TypeAlias = tuple[Run, Sequence[tuple[int, int]]]
"""Some captures of a run: their first frames and ends, among those of all captures."""


def spread(frames: FloatArray | Float32Array, bounds: IntArray, workers: Workers = HERE) -> Spread:
    """Divide frames (frames, dimensions) into runs; `bounds`: first frames of captures, and end.

    >>> [run.first for run in spread(np.zeros((9, 1)), np.array([0, 4, 9])).runs]
    [0]
    """
    n_runs = max(1, math.ceil(len(frames) / RUN_FRAMES))
    wanted = len(frames) * np.arange(1, n_runs) / n_runs
    edges = np.unique([0, *bounds[np.searchsorted(bounds, wanted)], len(frames)]).tolist()
    parts = tuple(Run(a, frames[a:b]) for a, b in pairwise(edges))
    return Spread(frames, parts or (Run(0, frames),), workers)


def as_spread(frames: Frames) -> Spread:
    """Frames in an array are one run, and this process works on them."""
    return frames if isinstance(frames, Spread) else Spread(frames, (Run(0, frames),))


def frames_of(some: Captures) -> Iterator[tuple[int, FloatArray | Float32Array]]:
    """First frame and frames of each of some captures."""
    run, spans = some
    for low, high in spans:
        yield low, run.frames[low - run.first : high - run.first]
