"""The part of a library that covers all of it best: facility location with a cost a second.

Notation: w_i the weight of point i (a window, or its mirror image), d_ij its distance to window j,
r_i about its distance to its K-th neighbour, c_J the seconds of interval J. A choice S of intervals
leaves point i at

    d_i(S) = min(r_i, min over J in S and j in J of d_ij),

and F(S) = sum_i w_i (r_i - d_i(S)) is monotone and submodular: what an interval adds becomes less,
the more there is. So the interval of the largest gain a second is taken, as long as it fits, and a
gain is computed anew only when it comes up (lazy greedy).

**The bound.** For any S and every other choice T of at most B seconds,

    F(T) <= F(S) + max { sum of gain_J(S) over J in T : sum of c_J <= B },

and the right side is at most that of the fractional knapsack. So no choice of B seconds has a mean
distance below (sum_i w_i r_i - bound) / sum_i w_i. It holds for the true distances, too, as d_i(S)
is never larger than these. It is printed in place of the share of F that was reached, which is as
near to 1 as one likes if the r_i are large.

Sources: Nemhauser, Wolsey and Fisher, An analysis of approximations for maximizing submodular set
functions, 1978; Minoux, Accelerated greedy algorithms, 1978; Leskovec et al., Cost-effective
outbreak detection in networks, 2007 (costs, and the bound).
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.records import Float32Array, FloatArray, IntArray

NEIGHBOURS = 200
"""Nearest windows that a point can be covered by, about. All distances of 10 hours would take
10 GB."""
MIN_PERFORMERS = 5  # From which on motion is covered by that of others
SHARED = 10  # Nearest chosen windows that a window is given to
_SAMPLED = 2000  # Windows by which it is told how far the neighbours of a point are
_BLOCK = 256  # Windows at a time; bounds memory


@dataclass(frozen=True, eq=False)
class Reach:
    """What every interval covers: those points that have one of its windows as a neighbour."""

    bounds: IntArray  # (intervals + 1,): interval n has the rows bounds[n] to bounds[n + 1]
    points: NDArray[np.int32]  # (rows,): points that are covered, each once an interval
    distances: Float32Array  # (rows,): how near the interval comes
    far: Float32Array  # (points,): r_i


@dataclass(frozen=True, eq=False)
class Chosen:
    """A choice of intervals."""

    intervals: IntArray  # Numbers, in the order in which they were taken
    nearest: IntArray  # (windows,): number of the nearest interval of the choice
    distances: FloatArray  # (windows,): distance to it
    stands: FloatArray  # (windows,): how many windows each stands for; 0 where it is not chosen
    mean: float  # Weighted mean of the distances of the points
    bound: float  # No choice of as many seconds has a smaller mean


def squared(a: Float32Array, b: Float32Array) -> Float32Array:
    """Squared distances of vectors: array (a, b), float32."""
    found = a @ b.T
    found *= -2.0
    found += np.einsum("ij,ij->i", a, a)[:, None]
    found += np.einsum("ij,ij->i", b, b)
    return np.maximum(found, 0.0, out=found)


def reach_of(
    points: Float32Array,
    vectors: Float32Array,
    owner: IntArray,
    groups: IntArray | None,
    neighbours: int,
) -> Reach:
    """What every interval covers.

    Shapes: `points` (points, axes): windows, once or more often; `vectors` (windows, axes), in the
    order of their intervals `owner` (windows,); `groups` (windows,): who moves.
    """
    step = max(1, len(vectors) // _SAMPLED)
    few = max(1, min(neighbours, len(vectors)) // step) - 1
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    far = np.empty(len(points), dtype=np.float32)
    found: list[tuple[NDArray[np.int32], NDArray[np.int32], Float32Array]] = []
    for low, block in _apart(points, vectors, groups, np.arange(len(vectors))):
        ends = np.partition(block[:, ::step], few, axis=1)[:, few]
        whole = ~np.isfinite(ends)  # fewer windows of others than neighbours
        ends[whole] = np.where(np.isfinite(block[whole]), block[whole], 0.0).max(axis=1, initial=0)
        far[low : low + _BLOCK] = np.sqrt(ends)
        nearest = np.minimum.reduceat(block, first, axis=1)
        point, interval = np.nonzero(nearest <= ends[:, None])
        numbers = owner[first][interval].astype(np.int32), (point + low).astype(np.int32)
        found.append((*numbers, np.sqrt(nearest[point, interval])))
    of, covered, distances = (np.concatenate(each) for each in zip(*found))
    order = np.argsort(of, kind="stable")
    bounds = np.searchsorted(of[order], np.arange(int(owner.max()) + 2))
    return Reach(bounds, covered[order], distances[order], far)


def _apart(
    points: Float32Array, vectors: Float32Array, groups: IntArray | None, inside: IntArray
) -> Iterator[tuple[int, Float32Array]]:
    """Squared distances of points to some windows, infinite between those of one person.

    In blocks, with the number of the first point.
    """
    for low in range(0, len(points), _BLOCK):
        block = squared(points[low : low + _BLOCK], vectors[inside])
        if groups is not None:
            whose = groups[np.arange(low, low + len(block)) % len(vectors)]
            block[whose[:, None] == groups[inside]] = np.inf
        yield low, block


def choose(
    vectors: Float32Array,
    owner: IntArray,
    costs: FloatArray,
    weights: FloatArray,
    budget: float,
    groups: IntArray | None = None,
    images: Float32Array | None = None,
    neighbours: int = NEIGHBOURS,
) -> Chosen:
    """The intervals that cover all points best for at most so many seconds; at least one.

    Shapes: `vectors` (windows, axes), in the order of their intervals `owner`; `owner`, `weights`
    (windows,); `costs` (intervals,), seconds. `groups` (windows,): who moves, where windows are to
    be covered by others alone; each weighs the root of what they have. `images` (windows, axes):
    the mirror images, which are points as well: what one person did with the right hand, the next
    one does with the left.
    """
    points = vectors
    if groups is not None:  # the next person is as likely to move like one as like another
        weights = weights / np.sqrt(np.bincount(groups))[groups]
    if images is not None:
        points, weights = np.concatenate([vectors, images]), np.tile(weights / 2.0, 2)
    reach = reach_of(points, vectors, owner, groups, neighbours)
    left, taken, spent = reach.far.astype(np.float64), list[int](), 0.0
    gains = np.array([_gain(reach, n, left, weights) for n in range(len(costs))])
    heap = [(-float(g / c), n) for n, (g, c) in enumerate(zip(gains, costs))]
    heapq.heapify(heap)
    computed = dict.fromkeys(range(len(costs)), 0)
    least, halves = _bound(reach, left, weights, costs, budget), budget / 2.0
    while heap:
        _, n = heapq.heappop(heap)
        if taken and spent + costs[n] > budget:
            continue
        if computed[n] == len(taken):
            taken.append(n)
            spent += float(costs[n])
            rows = slice(reach.bounds[n], reach.bounds[n + 1])
            at = reach.points[rows]
            left[at] = np.minimum(left[at], reach.distances[rows])
            if spent >= halves:  # the bound is tightest somewhere on the way
                halves += budget / 8.0
                least = max(least, _bound(reach, left, weights, costs, budget))
        else:
            computed[n] = len(taken)
            heapq.heappush(heap, (-_gain(reach, n, left, weights) / float(costs[n]), n))
    least = max(least, _bound(reach, left, weights, costs, budget), 0.0)
    chosen = np.array(taken, dtype=np.int64)
    nearest, distances, stands = nearest_of(vectors, owner, chosen)
    inside = np.flatnonzero(np.isin(owner, chosen))
    near = [block.min(axis=1) for _, block in _apart(points, vectors, groups, inside)]
    apart = np.sqrt(np.concatenate(near).astype(np.float64))
    mean = float(np.average(np.where(np.isfinite(apart), apart, reach.far), weights=weights))
    return Chosen(chosen, nearest, distances, stands, mean, least / float(weights.sum()))


def who_covers(performers: Sequence[str]) -> IntArray | None:
    """Numbers of performers (windows,), if windows are to be covered by others: enough, none alone.

    A choice is for motion of people who are not in the library. So each is taken as unseen in
    turn: that of others covers it. With fewer than ``MIN_PERFORMERS``, or one who has half of the
    windows, the others would be too few.

    >>> who_covers(["a"] * 3 + ["b"]) is None, who_covers(list("abcdef")).tolist()
    (True, [0, 1, 2, 3, 4, 5])
    """
    _, numbers, counts = np.unique(performers, return_inverse=True, return_counts=True)
    enough = len(counts) >= MIN_PERFORMERS and 2 * counts.max() < len(numbers)
    return numbers.astype(np.int64) if enough else None


def _gain(reach: Reach, n: int, left: FloatArray, weights: FloatArray) -> float:
    """What an interval adds to F."""
    rows = slice(reach.bounds[n], reach.bounds[n + 1])
    at = reach.points[rows]
    return float(weights[at] @ np.maximum(left[at] - reach.distances[rows], 0.0))


def _bound(
    reach: Reach, left: FloatArray, weights: FloatArray, costs: FloatArray, budget: float
) -> float:
    """Least sum of distances that any choice of so many seconds leaves (fractional knapsack)."""
    gains = np.array([_gain(reach, n, left, weights) for n in range(len(costs))])
    order = np.argsort(-gains / costs, kind="stable")
    room = budget - np.cumsum(costs[order]) + costs[order]  # before each is taken
    shares = np.clip(room / costs[order], 0.0, 1.0)
    return float(weights @ left - gains[order] @ shares)


def nearest_of(
    vectors: Float32Array, owner: IntArray, chosen: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """For every window the nearest interval of a choice, its distance, and what it stands for.

    A window is shared by the ``SHARED`` nearest chosen windows: what each stands for, in windows,
    then varies less, and a predictor that is trained with it errs less.
    """
    inside = np.flatnonzero(np.isin(owner, chosen))
    few = min(SHARED, len(inside))
    nearest = np.empty(len(vectors), dtype=np.int64)
    distances = np.empty(len(vectors))
    stands = np.zeros(len(vectors))
    for low in range(0, len(vectors), _BLOCK):
        block = squared(vectors[low : low + _BLOCK], vectors[inside])
        found = block.argmin(axis=1)
        nearest[low : low + _BLOCK] = owner[inside[found]]
        distances[low : low + _BLOCK] = np.sqrt(block[np.arange(len(block)), found])
        shared = np.argpartition(block, few - 1, axis=1)[:, :few]
        stands[inside] += np.bincount(shared.ravel(), minlength=len(inside)) / few
    own = np.isin(owner, chosen)
    nearest[own], distances[own] = owner[own], 0.0
    return nearest, distances, stands


def between(vectors: Float32Array, owner: IntArray, chosen: IntArray) -> FloatArray:
    """Mean distance of the windows of each chosen interval to each other: (chosen, chosen).

    The diagonal is infinite.
    """
    out = np.full((len(chosen), len(chosen)), np.inf)
    inside = np.flatnonzero(np.isin(owner, chosen))
    inside = inside[np.argsort(owner[inside], kind="stable")]
    owners, starts = np.unique(owner[inside], return_index=True)
    rank = np.argsort(chosen)  # of the intervals by number: their places in the choice
    for place, (a, b) in enumerate(zip(starts, [*starts[1:], len(inside)])):
        apart = np.sqrt(squared(vectors[inside[a:b]], vectors[inside]))
        out[rank[place], rank] = np.minimum.reduceat(apart, starts, axis=1).mean(axis=0)
    np.fill_diagonal(out, np.inf)
    assert len(owners) == len(chosen)
    return out


def balanced(classes: list[tuple[str, ...]]) -> FloatArray:
    """Weights of windows so that every class (a word, a symbol) has the same in all; mean 1.

    A window of several classes has the sum of their parts, one without any none of its own: all of
    these together are a class.

    >>> balanced([("walk",), ("walk",), ("kick",), ()])
    array([0.66666667, 0.66666667, 1.33333333, 1.33333333])
    """
    named = [each or ("",) for each in classes]
    counts: dict[str, int] = {}
    for each in named:
        for name in each:
            counts[name] = counts.get(name, 0) + 1
    found = np.array([sum(1.0 / counts[name] for name in each) for each in named])
    return np.asarray(found / found.mean())


def split(groups: dict[str, float], share: float, rng: np.random.Generator) -> set[str]:
    """The groups (performers, with their seconds) to set aside for a test: about a share of all.

    At least one is set aside and at least one stays. In random order, each is taken that brings the
    sum nearer to the share.
    """
    total, names = sum(groups.values()), sorted(groups)
    taken: set[str] = set()
    held = 0.0
    for n in rng.permutation(len(names)).tolist():
        name = names[n]
        nearer = abs(held + groups[name] - share * total) < abs(held - share * total)
        if nearer and len(taken) < len(names) - 1:
            taken.add(name)
            held += groups[name]
    return taken or {min(names, key=lambda name: (groups[name], name))}
