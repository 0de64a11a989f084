"""A motion that was not learned from, read as a string of a grammar's terminals.

Notation: x_0 ... x_{T-1} the poses of the motion; s_k the medoid of terminal k. A reading cuts the
motion into segments [t_i, t_{i+1}) with terminals k_i and costs

    C = sum over i of ( (t_{i+1} - t_i) D([t_i, t_{i+1}), s_{k_i}) + c )

with D the distance under uniform time warping by which terminals were found, so a segment costs
what it would add to their error. A segment is as long as those of its terminal are: between their
shortest and longest, a tenth more or less. The reading of least C is found exactly by dynamic
programming over all cuts and terminals.

c, the price of a segment, keeps the motion from being cut finer than the takes were: it is set so
that the takes that were learned from, read anew, have as many segments as they have.

Source: D and medoids as in J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from
Human Motion Data" (2011), section 4; the reading of unseen motion is not in print.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from motiondb.errors import QueryError
from motiondb.grammar.poses import pose_vectors
from motiondb.records import FloatArray, IntArray, Motion

if TYPE_CHECKING:
    from motiondb.grammar.terminals import Terminals

SLACK = 0.1
"""How much longer or shorter than those of its terminal a segment may be."""


@dataclass(frozen=True, eq=False)
class Reader:
    """What it takes to read: medoids end to end, the lengths allowed, and the price.

    Attributes
    ----------
    names : the terminals. poses : array (frames of all medoids, 70), ``poses.pose_vectors``.
    bounds : array (K + 1,), where each medoid begins.
    shortest, longest : arrays (K,), frames. price : c, metres times frames.
    """

    names: tuple[str, ...]
    poses: FloatArray
    bounds: IntArray
    shortest: IntArray
    longest: IntArray
    price: float = 0.0


@dataclass(frozen=True, eq=False)
class Reading:
    """A motion as a string: segments that tile it, their terminals and distances D (metres)."""

    starts: IntArray
    ends: IntArray
    labels: IntArray
    distances: FloatArray
    names: tuple[str, ...]

    @property
    def string(self) -> tuple[str, ...]:
        """The terminals in order."""
        return tuple(self.names[k] for k in self.labels)


def make_reader(terminals: Terminals, motions: Mapping[int, Motion]) -> Reader:
    """A reader from terminals and the takes that are there, priced by reading these takes.

    Terminals whose medoid's take is missing are read by the segment of a take that is there which
    lies nearest to the length of the medoid; where there is none, they are not read.

    Raises
    ------
    QueryError : there is no take.
    """
    if not motions:
        raise QueryError(
            "reading: expected captures of the grammar, found none left. Add them again."
        )
    vectors = {take: pose_vectors(motion) for take, motion in motions.items()}
    names, parts, shortest, longest = [], [], [], []
    lengths = terminals.ends - terminals.starts
    for k, name in enumerate(terminals.names):
        own = np.flatnonzero(terminals.labels == k)
        clip = _stand_in(terminals, k, own, vectors)
        if clip < 0:
            continue
        names.append(name)
        take = int(terminals.takes[clip])
        parts.append(vectors[take][terminals.starts[clip] : terminals.ends[clip]])
        shortest.append(max(1, int(np.floor(lengths[own].min() * (1 - SLACK)))))
        longest.append(int(np.ceil(lengths[own].max() * (1 + SLACK))))
    bounds = np.cumsum([0, *map(len, parts)])
    reader = Reader(
        tuple(names), np.concatenate(parts), bounds, np.array(shortest), np.array(longest)
    )
    wanted = sum(int((terminals.takes == take).sum()) for take in vectors)
    return _priced(reader, list(vectors.values()), wanted)


def _stand_in(
    terminals: Terminals, k: int, own: IntArray, vectors: Mapping[int, FloatArray]
) -> int:
    """The medoid of a terminal, or what stands for it where its take is missing; -1: nothing."""
    medoid = int(terminals.medoids[k])
    there = own[np.isin(terminals.takes[own], list(vectors))]
    if medoid in there or not len(there):
        return medoid if len(there) else -1
    lengths = (terminals.ends - terminals.starts)[there]
    wanted = terminals.ends[medoid] - terminals.starts[medoid]
    return int(there[np.argmin(np.abs(lengths - wanted))])


def _priced(reader: Reader, takes: Sequence[FloatArray], wanted: int, rounds: int = 7) -> Reader:
    """The reader whose price gives the takes as many segments as wanted, by halving."""
    tables = [_table(reader, values) for values in takes]
    low, high = 0.0, 4.0 * float(np.mean([table.min(axis=1).mean() for table in tables])) * 30.0
    for step in range(rounds + 1):
        price = low if step == 0 else (low + high) / 2.0
        count = sum(len(_read(reader, table, price)[0]) for table in tables)
        if count <= wanted and step == 0:
            high = low
            break
        low, high = (price, high) if count > wanted else (low, price)
    return Reader(reader.names, reader.poses, reader.bounds, reader.shortest, reader.longest, high)


def read_string(reader: Reader, motion: Motion) -> Reading:
    """The reading of least cost.

    Raises
    ------
    QueryError : the motion is shorter than any segment may be.
    """
    values = pose_vectors(motion)
    starts, ends, labels, distances = _read(reader, _table(reader, values), reader.price)
    if not len(starts):
        raise QueryError(
            "motion: expected frames that segments tile, each of at least"
            f" {reader.shortest.min()} and at most {reader.longest.max()} (30 a second), found"
            f" {len(values)} in all. Take a longer part."
        )
    return Reading(starts, ends, labels, distances, reader.names)


def _table(reader: Reader, values: FloatArray) -> FloatArray:
    """Distances of all poses to those of the medoids: array (frames, frames of medoids)."""
    a, b = values, reader.poses
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    return np.sqrt(np.maximum(squares, 0.0))


def _read(
    reader: Reader, table: FloatArray, price: float
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Starts, ends, labels and D; empty where no segments of the allowed lengths tile it."""
    n_frames = len(table)
    starts, labels, costs = _best_cuts(table, reader.bounds, reader.shortest, reader.longest, price)
    cuts, kinds, parts = [], [], []
    end = n_frames
    while end > 0:
        if starts[end] < 0:
            return (np.zeros(0, np.int64),) * 3 + (np.zeros(0),)
        cuts.append((int(starts[end]), end))
        kinds.append(int(labels[end]))
        parts.append(float(costs[end]))
        end = int(starts[end])
    pairs = np.array(cuts[::-1], dtype=np.int64).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1], np.array(kinds[::-1], dtype=np.int64), np.array(parts[::-1])


@njit(cache=True)
def _best_cuts(
    table: FloatArray, bounds: IntArray, shortest: IntArray, longest: IntArray, price: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Per end (0 ... frames) the start, terminal and D of the last segment of the best reading."""
    n_frames = len(table)
    best = np.full(n_frames + 1, np.inf)
    best[0] = 0.0
    starts = np.full(n_frames + 1, -1)
    labels = np.full(n_frames + 1, -1)
    costs = np.zeros(n_frames + 1)
    for start in range(n_frames):
        if best[start] == np.inf:
            continue
        for k in range(len(shortest)):
            low, size = bounds[k], bounds[k + 1] - bounds[k]
            for length in range(shortest[k], min(longest[k], n_frames - start) + 1):
                total = 0.0
                if length >= size:
                    for m in range(length):
                        total += table[start + m, low + m * size // length]
                else:
                    for m in range(size):
                        total += table[start + m * length // size, low + m]
                distance = total / max(length, size)
                cost = best[start] + length * distance + price
                if cost < best[start + length]:
                    best[start + length] = cost
                    starts[start + length] = start
                    labels[start + length] = k
                    costs[start + length] = distance
    return starts, labels, costs
