"""Read a motion that was not learned from as a string of a grammar's terminals.

Notation: x_0 ... x_{T-1} the poses of the motion; s_k the medoid of terminal k. A reading cuts the
motion into segments [t_i, t_{i+1}) with terminals k_i and costs

    C = sum over i of ( (t_{i+1} - t_i) D([t_i, t_{i+1}), s_{k_i}) + c )

with D the distance under uniform time warping by which terminals were found, so that a segment
costs what it would add to their error. A segment is as long as those of its terminal: between their
shortest and longest, a tenth more or less. The reading of least C is found exactly by dynamic
programming over all cuts and terminals.

The price c of a segment keeps the motion from being cut more finely than the takes were. It is set
so that the takes of the grammar, read in this way, have as many segments as they have.

Every segment gets its nearest terminal, even if nothing is near. So a reading holds D, and the
reader knows how far the members of terminals are from their medoids: a segment that is farther is
unlike anything known. This reach is the lesser of two bounds: 19 of 20 members lie within the
first; the second is 2.5 standard deviations of log D above its median, robustly estimated.
Terminals that gather leftover segments would widen the first, few members that differ much the
second.

Sources: D and medoids as in J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from
Human Motion Data" (2011), section 4; the reading of unseen motion is ours. 2.5 robust standard
deviations: P. J. Rousseeuw and A. M. Leroy, "Robust Regression and Outlier Detection" (1987),
chapter 1.
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
"""How much longer or shorter than those of its terminal a segment may be. Chosen by hand."""

WITHIN, DEVIATIONS = 0.95, 2.5
"""Share of the members, and standard deviations of log D above its median, within reach: 19 of 20
by convention, and 2.5 after Rousseeuw and Leroy."""

FEWEST_MEMBERS = 5
"""Members, medoids not counted, below which no reach is estimated. Chosen by hand."""

_LEAST_DISTANCE = 1e-3
"""Metres; smaller distances are raised to this before their logarithm is taken."""

_HALVINGS = 7
"""Halvings of the interval of prices. Chosen by hand: more change few segments."""

_LONGEST_PRICE = 120.0
"""Upper bound of the price, as frames at the mean least distance: four seconds."""


@dataclass(frozen=True, eq=False)
class Reader:
    """What a reading needs: medoids, lengths that are allowed, and the price.

    Attributes
    ----------
    names : tuple of str
        The terminals.
    poses : array (frames of all medoids, 70)
        Medoids end to end, as :func:`motiondb.grammar.terminals.pose_distance.pose_vectors`.
    bounds : array (K + 1,)
        Where each medoid begins.
    shortest, longest : arrays (K,)
        Frames of a segment of each terminal.
    price : float
        c, metres times frames.
    reach : float
        How far members are usually from their medoids, metres; NaN if there are too few members.
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
    """A motion as a string of terminals.

    Attributes
    ----------
    starts, ends : arrays (segments,)
        Frames; the segments tile the motion.
    labels : array (segments,)
        Terminals.
    distances : array (segments,)
        D, metres.
    names : tuple of str
        Names of the terminals.
    reach : float
        The reader's: a segment that is farther is unlike anything known.
    """

    starts: IntArray
    ends: IntArray
    labels: IntArray
    distances: FloatArray
    names: tuple[str, ...]
    reach: float = np.nan

    @property
    def string(self) -> tuple[str, ...]:
        """Names of the terminals in order."""
        return tuple(self.names[k] for k in self.labels)


def make_reader(terminals: Terminals, motions: Mapping[int, Motion]) -> Reader:
    """Make a reader from terminals and their takes; the price is set by reading these takes.

    A terminal whose medoid's take is missing is represented by the segment of an available take
    whose length is nearest to the medoid's; without one, the terminal is left out.

    Parameters
    ----------
    terminals : Terminals
        Segments and groups.
    motions : mapping
        Take number to motion, for the takes that are available.

    Raises
    ------
    QueryError
        There is no take.
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
    """Return how far members of terminals are usually from their medoids; see the module.

    Parameters
    ----------
    distances : array (members,)
        Metres, medoids left out.

    Returns
    -------
    float
        Metres; NaN if there are fewer than ``FEWEST_MEMBERS``.

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
    """Return the segment that represents each terminal.

    Its medoid, or another if that is missing.
    """
    lengths = terminals.ends - terminals.starts
    clips = {}
    for k, medoid in enumerate(terminals.medoids.tolist()):
        members = np.flatnonzero(terminals.labels == k)
        there = members[np.isin(terminals.takes[members], list(vectors))]
        if medoid in there:
            clips[k] = medoid
        elif len(there):
            clips[k] = int(there[np.argmin(np.abs(lengths[there] - lengths[medoid]))])
    return clips


def _price(reader: Reader, tables: Sequence[FloatArray], wanted: int) -> float:
    """Return the price that gives the takes the wanted number of segments, by bisection."""
    mean = float(np.mean([table.min(axis=1).mean() for table in tables]))
    low, high = 0.0, _LONGEST_PRICE * mean
    for step in range(_HALVINGS + 1):
        price = low if step == 0 else (low + high) / 2.0
        count = sum(len(_read(reader, table, price)[0]) for table in tables)
        if count <= wanted and step == 0:
            return low
        low, high = (price, high) if count > wanted else (low, price)
    return high


def read_string(reader: Reader, motion: Motion) -> Reading:
    """Return the reading of least cost.

    Raises
    ------
    QueryError
        No segments of the allowed lengths tile the motion; it is too short.
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
    """Return distances of all poses to those of the medoids: array (frames, frames of medoids)."""
    a, b = values, reader.poses
    squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1)[None] - 2.0 * (a @ b.T)
    return np.sqrt(np.maximum(squares, 0.0))


def _read(
    reader: Reader, table: FloatArray, price: float
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Return starts, ends, labels and D; empty if no segments of the allowed lengths tile it."""
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
    """Return D of ``length`` frames from ``start`` on to the medoid that begins at ``low``."""
    total = 0.0
    if length >= size:
        for m in range(length):
            total += table[start + m, low + m * size // length]
    else:
        for m in range(size):
            total += table[start + m * length // size, low + m]
    return float(total / max(length, size))


@njit(cache=True)
def _best_cuts(
    table: FloatArray, bounds: IntArray, shortest: IntArray, longest: IntArray, price: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return per end (0 ... frames) the last segment of the best reading: start, terminal, D."""
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
