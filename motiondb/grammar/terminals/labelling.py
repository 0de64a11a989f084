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

Every segment gets a terminal, the least unlike one, even where nothing is like it. So a reading
tells D, and the reader how far the members of terminals are from their medoids where they were
learned: a segment that is farther is unlike anything known. That reach is the lesser of two bounds:
19 in 20 members lie within the one; the other is 2.5 standard deviations of log D above its middle,
both told from medians. Terminals that gather what fits nowhere would widen the first, few members
that differ much the second.

Sources: D and medoids as in J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from
Human Motion Data" (2011), section 4; the reading of unseen motion is not in print. 2.5 robust
standard deviations: P. J. Rousseeuw and A. M. Leroy, "Robust Regression and Outlier Detection"
(1987), chapter 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from motiondb.errors import QueryError
from motiondb.grammar.terminals.pose_distance import pose_vectors
from motiondb.records import FloatArray, IntArray, Motion

if TYPE_CHECKING:
    from motiondb.grammar.terminals.terminals import Terminals

SLACK = 0.1
"""How much longer or shorter than those of its terminal a segment may be."""

WITHIN, DEVIATIONS = 0.95, 2.5
"""Share of the members, and standard deviations of log D above its middle, within reach."""

FEWEST_MEMBERS = 5
"""Members, medoids apart, that tell a reach."""

_LEAST_DISTANCE = 1e-3
"""Metres; what is nearer counts as this near, for logarithms."""


@dataclass(frozen=True, eq=False)
class Reader:
    """What it takes to read: medoids end to end, the lengths allowed, and the price.

    Attributes
    ----------
    names : the terminals. poses : array (frames of all medoids, 70), ``poses.pose_vectors``.
    bounds : array (K + 1,), where each medoid begins.
    shortest, longest : arrays (K,), frames. price : c, metres times frames.
    reach : how far members are from their medoids, metres; NaN where there are too few to tell.
    """

    names: tuple[str, ...]
    poses: FloatArray
    bounds: IntArray
    shortest: IntArray
    longest: IntArray
    price: float = 0.0
    reach: float = np.nan


@dataclass(frozen=True, eq=False)
class Reading:
    """A motion as a string: segments that tile it, their terminals and distances D (metres).

    reach : the reader's: a segment that is farther is unlike anything learned.
    """

    starts: IntArray
    ends: IntArray
    labels: IntArray
    distances: FloatArray
    names: tuple[str, ...]
    reach: float = np.nan

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
    clips = _stand_ins(terminals, vectors)
    lengths = [(terminals.ends - terminals.starts)[terminals.labels == k] for k in clips]
    shortest = [max(1, int(np.floor(own.min() * (1 - SLACK)))) for own in lengths]
    longest = [int(np.ceil(own.max() * (1 + SLACK))) for own in lengths]
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
    """How far members of terminals are usually from their medoids; see the module.

    distances : array (members,), metres, medoids left out. NaN where they are too few.

    >>> round(find_reach(np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.5])), 6)
    0.1
    """
    if len(distances) < FEWEST_MEMBERS:
        return float(np.nan)
    logs = np.log(np.maximum(distances, _LEAST_DISTANCE))
    middle = float(np.median(logs))
    deviation = 1.4826 * float(np.median(np.abs(logs - middle)))  # as of a normal distribution
    widest = float(np.exp(middle + DEVIATIONS * deviation))
    return min(float(np.quantile(distances, WITHIN)), widest)


def _member_distances(
    reader: Reader,
    terminals: Terminals,
    clips: Mapping[int, int],
    tables: Mapping[int, FloatArray],
) -> FloatArray:
    """D of all segments of the takes that are there, but those that terminals are read by."""
    found = []
    for k, low, high in zip(clips, reader.bounds[:-1], reader.bounds[1:]):
        for clip in np.flatnonzero(terminals.labels == k).tolist():
            take = int(terminals.takes[clip])
            if take in tables and clip != clips[k]:
                start, end = int(terminals.starts[clip]), int(terminals.ends[clip])
                found.append(_distance(tables[take], start, end - start, low, high - low))
    return np.array(found)


def _stand_ins(terminals: Terminals, vectors: Mapping[int, FloatArray]) -> dict[int, int]:
    """Terminal -> its medoid, or the segment that stands for it where its take is missing."""
    lengths = terminals.ends - terminals.starts
    clips = {}
    for k, medoid in enumerate(terminals.medoids.tolist()):
        own = np.flatnonzero(terminals.labels == k)
        there = own[np.isin(terminals.takes[own], list(vectors))]
        if medoid in there:
            clips[k] = medoid
        elif len(there):
            clips[k] = int(there[np.argmin(np.abs(lengths[there] - lengths[medoid]))])
    return clips


def _price(reader: Reader, tables: Sequence[FloatArray], wanted: int, rounds: int = 7) -> float:
    """The price that gives the takes as many segments as wanted, by halving."""
    low, high = 0.0, 4.0 * float(np.mean([table.min(axis=1).mean() for table in tables])) * 30.0
    for step in range(rounds + 1):
        price = low if step == 0 else (low + high) / 2.0
        count = sum(len(_read(reader, table, price)[0]) for table in tables)
        if count <= wanted and step == 0:
            return low
        low, high = (price, high) if count > wanted else (low, price)
    return high


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
    return Reading(starts, ends, labels, distances, reader.names, reader.reach)


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


@njit(cache=True, inline="always")
def _distance(table, start, length, low, size):  # type: ignore[no-untyped-def]
    """D of ``length`` frames from ``start`` on and the medoid whose frames begin at ``low``."""
    total = 0.0
    if length >= size:
        for m in range(length):
            total += table[start + m, low + m * size // length]
    else:
        for m in range(size):
            total += table[start + m * length // size, low + m]
    return total / max(length, size)


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
                distance = _distance(table, start, length, low, size)
                cost = best[start] + length * distance + price
                if cost < best[start + length]:
                    best[start + length] = cost
                    starts[start + length] = start
                    labels[start + length] = k
                    costs[start + length] = distance
    return starts, labels, costs
