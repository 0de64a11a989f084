"""Read a motion that the grammar was not learned from as a string of its terminals.

Notation: x_0 ... x_{T-1} the poses of the motion; s_k the medoid of terminal k. A transcription
cuts the motion into segments [t_i, t_{i+1}) with terminals k_i and costs

    C = sum over i of ( (t_{i+1} - t_i) D([t_i, t_{i+1}), s_{k_i}) + c )

where D is the distance under uniform time warping by which the terminals were found, so that a
segment costs what it would add to their error. The length of a segment is between the shortest and
the longest of its terminal, with a tolerance of a tenth. The transcription of least C is found
exactly, by dynamic programming over all cuts and terminals.

The price c of a segment prevents finer cuts than those of the takes. It is set so that
transcriptions of the grammar's own takes have about as many segments as the takes have.

Every segment gets the terminal of least cost, even if no terminal is near. A transcription
therefore includes D, and the reader has a reach, an estimate of how far members of terminals are
from their medoids. A segment that is farther than the reach is unlike any terminal. The reach is
the smaller of two bounds. The first is the distance within which 19 of 20 members lie. The second
is 2.5 standard deviations of log D above its median, robustly estimated. Terminals that collect
leftover segments would make the first too wide, and a few members that differ much would make the
second too wide.

Sources: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 4, for D and medoids; P. J. Rousseeuw and A. M. Leroy,
"Robust Regression and Outlier Detection" (1987), chapter 1, for 2.5 robust standard deviations. The
paper does not read unseen motion; this method is our own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from motiondb.errors import QueryError
from motiondb.grammar.kernels import maker
from motiondb.grammar.terminals.distances import pose_vectors
from motiondb.records import FloatArray, IntArray, Motion

if TYPE_CHECKING:
    from motiondb.grammar.terminals.terminals import Terminals

SLACK = 0.1
"""Tolerance of the length of a segment, as a share of the shortest and longest segment of its
terminal."""

WITHIN, DEVIATIONS = 0.95, 2.5
"""Share of the members within the first bound of the reach, and standard deviations of log D above
its median for the second: 19 of 20 by convention, and 2.5 after Rousseeuw and Leroy."""

FEWEST_MEMBERS = 5  # Smallest number of members, without medoids, for which a reach is estimated

_LEAST_DISTANCE = 1e-3  # Metres. Smaller distances are set to this before the logarithm

_HALVINGS = 7  # Bisection steps for the price. Chosen by hand: more steps change few segments

_LONGEST_PRICE = 120.0
"""Upper bound of the price: the cost of this many frames (four seconds) at the mean least
distance."""


@dataclass(frozen=True, eq=False)
class Reader:
    """Terminals in the form for reading: medoids, allowed lengths, price and reach."""

    names: tuple[str, ...]
    # (frames of all medoids, 70): poses of the medoids, one medoid after the other, from
    # :func:`motiondb.grammar.terminals.distances.pose_vectors`
    poses: FloatArray
    bounds: IntArray  # (K + 1,): first row of each medoid; the last entry is the number of rows
    shortest: IntArray  # (K,): fewest frames of a segment of each terminal
    longest: IntArray  # (K,): most frames of a segment of each terminal
    price: float = 0.0  # c, the price of a segment, metres times frames
    # Distance within which members usually are of their medoids, metres; NaN if there are too few
    # members
    reach: float = np.nan


@dataclass(frozen=True, eq=False)
class Transcription:
    """A motion as a string of terminals."""

    starts: IntArray  # (segments,): first frame of each segment; the segments tile the motion
    ends: IntArray  # (segments,): one past the last frame of each segment
    labels: IntArray  # (segments,): terminal of each segment, as index of ``names``
    distances: FloatArray  # (segments,): d of each segment to the medoid of its terminal, metres
    names: tuple[str, ...]  # Names of the terminals
    # Reach of the reader, metres. A segment that is farther is unlike any terminal
    reach: float = np.nan

    @property
    def string(self) -> tuple[str, ...]:
        """Name of the terminal of each segment, in order."""
        return tuple(self.names[k] for k in self.labels)


def make_reader(terminals: Terminals, motions: Mapping[int, Motion]) -> Reader:
    """Make a reader from terminals and their takes; set the price by reading these takes.

    If the take of a medoid is missing, the medoid is replaced by the member from an available take
    whose length is nearest. If there is none, the terminal is left out.
    """
    if not motions:
        raise QueryError(
            "reading: expected captures of the grammar, found none left. Add them again."
        )
    vectors = {take: pose_vectors(motion) for take, motion in motions.items()}
    clips = _stand_ins(terminals, vectors)
    lengths = [(terminals.ends - terminals.starts)[terminals.labels == k] for k in clips]
    shortest = [max(1, int(np.floor(some.min() * (1 - SLACK)))) for some in lengths]
    longest = [int(np.ceil(some.max() * (1 + SLACK))) for some in lengths]
    parts = [
        vectors[int(terminals.takes[c])][terminals.starts[c] : terminals.ends[c]]
        for c in clips.values()
    ]
    names = tuple(terminals.names[k] for k in clips)
    bounds = np.cumsum([0, *map(len, parts)])
    reader = Reader(names, np.concatenate(parts), bounds, np.array(shortest), np.array(longest))
    tables = {take: _table(reader, values) for take, values in vectors.items()}
    reach = find_reach(_member_distances(reader, terminals, clips, tables))
    wanted = sum(int((terminals.takes == take).sum()) for take in vectors)
    return replace(reader, price=_price(reader, list(tables.values()), wanted), reach=reach)


def find_reach(distances: FloatArray) -> float:
    """Return the distance within which members usually are of their medoids; see the module.

    Shapes: `distances` (members,).

    >>> round(find_reach(np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.5])), 6)
    0.1
    """
    if len(distances) < FEWEST_MEMBERS:
        return float(np.nan)
    logs = np.log(np.maximum(distances, _LEAST_DISTANCE))
    middle = float(np.median(logs))
    deviation = 1.4826 * float(np.median(np.abs(logs - middle)))  # for a normal distribution
    widest = float(np.exp(middle + DEVIATIONS * deviation))
    return min(float(np.quantile(distances, WITHIN)), widest)


def _member_distances(
    reader: Reader,
    terminals: Terminals,
    clips: Mapping[int, int],
    tables: Mapping[int, FloatArray],
) -> FloatArray:
    """Return D of all segments of available takes that do not represent their terminal."""
    distances = []
    for k, low, high in zip(clips, reader.bounds[:-1], reader.bounds[1:]):
        for clip in np.flatnonzero(terminals.labels == k).tolist():
            take = int(terminals.takes[clip])
            if take in tables and clip != clips[k]:
                start, end = int(terminals.starts[clip]), int(terminals.ends[clip])
                distances.append(_distance(tables[take], start, end - start, low, high - low))
    return np.array(distances)


def _stand_ins(terminals: Terminals, vectors: Mapping[int, FloatArray]) -> dict[int, int]:
    """Return the segment that represents each terminal: its medoid, or a member in its place."""
    lengths = terminals.ends - terminals.starts
    clips = {}
    for k, medoid in enumerate(terminals.medoids.tolist()):
        members = np.flatnonzero(terminals.labels == k)
        available = members[np.isin(terminals.takes[members], list(vectors))]
        if medoid in available:
            clips[k] = medoid
        elif len(available):
            clips[k] = int(available[np.argmin(np.abs(lengths[available] - lengths[medoid]))])
    return clips


def _price(reader: Reader, tables: Sequence[FloatArray], wanted: int) -> float:
    """Return the lowest price found by bisection that gives at most the wanted segments.

    If no tried price does, return the upper bound.
    """
    mean = float(np.mean([table.min(axis=1).mean() for table in tables]))
    low, high = 0.0, _LONGEST_PRICE * mean
    for step in range(_HALVINGS + 1):
        price = low if step == 0 else (low + high) / 2.0
        count = sum(len(_read(reader, table, price)[0]) for table in tables)
        if count <= wanted and step == 0:
            return low
        low, high = (price, high) if count > wanted else (low, price)
    return high


def read_string(reader: Reader, motion: Motion) -> Transcription:
    """Read a motion as a string of terminals, with least cost."""
    values = pose_vectors(motion)
    starts, ends, labels, distances = _read(reader, _table(reader, values), reader.price)
    if not len(starts):
        raise QueryError(
            "motion: expected frames that segments tile, each of at least"
            f" {reader.shortest.min()} and at most {reader.longest.max()} (30 a second), found"
            f" {len(values)} in all. Take a longer part."
        )
    return Transcription(starts, ends, labels, distances, reader.names, reader.reach)


def _table(reader: Reader, values: FloatArray) -> FloatArray:
    """Return the distances of all poses to those of the medoids (frames, frames of medoids)."""
    a, b = values, reader.poses
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    return np.sqrt(np.maximum(squares, 0.0))


def _read(
    reader: Reader, table: FloatArray, price: float
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Return starts, ends, labels and D of the segments; empty if no allowed segments tile it."""
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


@njit(cache=True, inline="always")
def _distance(table: FloatArray, start: int, length: int, low: int, size: int) -> float:
    """Return D between ``length`` frames from ``start`` and ``size`` medoid frames from ``low``."""
    total = 0.0
    if length >= size:
        for m in range(length):
            total += table[start + m, low + m * size // length]
    else:
        for m in range(size):
            total += table[start + m * length // size, low + m]
    return float(total / max(length, size))


@maker
def _best_cuts(
    table: FloatArray, bounds: IntArray, shortest: IntArray, longest: IntArray, price: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the last segment of the best transcription up to each frame: start, terminal and D.

    Each is an array (frames + 1,); start and terminal are -1 if there is none.
    """
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
                distance = _distance(table, start, length, low, size)
                cost = best[start] + length * distance + price
                if cost < best[start + length]:
                    best[start + length] = cost
                    starts[start + length] = start
                    labels[start + length] = k
                    costs[start + length] = distance
    return starts, labels, costs
