"""The part of a capture nearest to a query: by its symbols, and by the frames of its features.

**Local alignment of symbols**, with their distances as substitution costs. Notation: q the query's
symbols, x a capture's, D their distances. A pair scores 1 - D[q, x] / scale (1 for the same symbol,
negative beyond ``scale``), a gap costs ``GAP``. Pairs are weighted by the query segment's share of
the query's duration, so that the score of a perfect match is 1.

Source: Smith and Waterman, Identification of common molecular subsequences, 1981.

**Subsequence dynamic time warping of features.** Notation: q_i and x_j whitened features, d(i, j) =
|q_i - x_j| / sqrt(D). The path may begin and end anywhere in x and has steps (1, 1), (1, 2), (2,
1), so that a part is between half and twice as long as the query. The distance is the mean of d
over the query's frames.

Source: Mueller, Information Retrieval for Music and Motion, 2007, chapters 4 and 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray

GAP = 0.5  # Cost of a gap, where a match scores 1


def distance_scale(distances: FloatArray) -> float:
    """Distance above which two symbols count as unrelated: the median over pairs.

    Shapes: `distances` (symbols, symbols).
    """
    pairs = distances[np.triu_indices(len(distances), 1)]
    return max(float(np.median(pairs)), 1e-9) if len(pairs) else 1.0


@dataclass(frozen=True, eq=False)
class Aligned:
    """Best local alignments of a query with captures: arrays (captures,)."""

    score: FloatArray  # 1 for a perfect match
    first: IntArray  # Place in the capture of the first aligned symbol
    last: IntArray  # One past the place of the last one


def align_captures(
    query: IntArray,
    weights: FloatArray,
    symbols: IntArray,
    bounds: IntArray,
    distances: FloatArray,
) -> Aligned:
    """Best local alignments of a query with captures.

    Shapes: `query`, `weights` (l,); `symbols` (n,), capture after capture; `bounds` (captures, 2):
    first symbol of each, and one past its last; `distances` (symbols, symbols).
    """
    scale = distance_scale(distances)
    return Aligned(*_align_captures(query, weights, symbols, bounds, distances, scale))


@njit(cache=True)
def _align_captures(
    query: IntArray,
    weights: FloatArray,
    symbols: IntArray,
    bounds: IntArray,
    distances: FloatArray,
    scale: float,
) -> tuple[FloatArray, IntArray, IntArray]:
    """The fields of :class:`Aligned`."""
    n = len(bounds)
    score, first, last = np.empty(n), np.empty(n, np.int64), np.empty(n, np.int64)
    for capture in range(n):
        own = symbols[bounds[capture, 0] : bounds[capture, 1]]
        score[capture], first[capture], last[capture] = align(query, weights, own, distances, scale)
    return score, first, last


@njit(cache=True)
def align(
    query: IntArray, weights: FloatArray, symbols: IntArray, distances: FloatArray, scale: float
) -> tuple[float, int, int]:
    """Best local alignment of a query with one capture: score, first and last symbol + 1.

    Shapes: `query`, `weights` (l,); `symbols` (n,); `distances` (symbols, symbols).
    """
    pairs = np.empty((len(query), len(symbols)))
    for i in range(len(query)):
        for j in range(len(symbols)):
            pairs[i, j] = (1.0 - distances[query[i], symbols[j]] / scale) * weights[i]
    return _smith_waterman(pairs, weights * GAP)


@njit(cache=True)
def _smith_waterman(pairs: FloatArray, gaps: FloatArray) -> tuple[float, int, int]:
    """Best local alignment by scores of pairs (query, capture) and costs of gaps (query,)."""
    n_query, n_symbols = pairs.shape
    mean_gap = gaps.mean()
    score = np.zeros((n_query + 1, n_symbols + 1))
    origin = np.zeros((n_query + 1, n_symbols + 1), np.int64)
    for j in range(n_symbols + 1):
        origin[0, j] = j
    top, first, last = 0.0, 0, 0
    for i in range(1, n_query + 1):
        for j in range(1, n_symbols + 1):
            best, start = 0.0, j
            diagonal = score[i - 1, j - 1] + pairs[i - 1, j - 1]
            if diagonal > best:
                best = diagonal
                start = origin[i - 1, j - 1] if score[i - 1, j - 1] > 0.0 else j - 1
            up = score[i - 1, j] - gaps[i - 1]
            if up > best:
                best, start = up, origin[i - 1, j]
            left = score[i, j - 1] - mean_gap
            if left > best:
                best, start = left, origin[i, j - 1]
            score[i, j], origin[i, j] = best, start
            if best > top:
                top, first, last = best, start, j
    return top, first, last


FAR = 1e30  # Cost of paths that are not possible; finite in single precision


def best_part(
    query: Float32Array,
    columns: Float32Array,
    low: int = 0,
    high: int | None = None,
    farthest: float = inf,
) -> tuple[float, int, int]:
    """Distance and interval of the part of a capture nearest to the query, within [low, high).

    Shapes: `query` (frames, D); `columns` (D, frames): the capture by dimension.

    `farthest`: The distance is infinite where it is larger; that is seen before the end.
    """
    high = columns.shape[1] if high is None else high
    if len(query) == 0 or high <= low:
        return inf, 0, 0
    query, columns = (np.ascontiguousarray(each, dtype=np.float32) for each in (query, columns))
    distance, start, end = _subsequence(query, columns, low, high, farthest)
    if end == 0 or distance > farthest:
        return inf, 0, 0
    return float(distance), low + start, low + end


@njit(cache=True)
def _subsequence(  # noqa: C901  one compiled dynamic program over three rows
    query: Float32Array, columns: Float32Array, low: int, high: int, farthest: float
) -> tuple[float, int, int]:
    """Least mean cost of a path, its first frame, and one past its last (0: there is none).

    The capture is given by dimension (D, frames), so that distances are computed for many frames at
    once without fast math, whose sums depend on the processor. Costs never fall along a path, so it
    is given up where two rows hold none that can end within the farthest distance.

    Rows i, i - 1 and i - 2 suffice: row i of cost and start is kept at i % 3, of local at i % 2.
    """
    n, m = len(query), high - low
    most, least = farthest * n * (1.0 + 1e-3), np.float32(0.0)  # single precision rounds the sums
    local = np.empty((2, m), np.float32)
    cost = np.full((3, m), np.float32(FAR))
    start = np.zeros((3, m), np.int64)
    for i in range(n):
        here, before, above = i % 3, (i - 1) % 3, (i - 2) % 3
        squares = np.zeros(m, np.float32)
        for d in range(query.shape[1]):
            column = columns[d, low:high]
            for j in range(m):
                difference = query[i, d] - column[j]
                squares[j] += difference * difference
        for j in range(m):
            local[i % 2, j] = np.sqrt(squares[j] / query.shape[1])
        if i == 0:
            cost[0] = local[0]
            start[0] = np.arange(m)
            continue
        cost[here, 0] = FAR
        for j in range(1, m):
            best, origin = cost[before, j - 1] + local[i % 2, j], start[before, j - 1]
            if j > 1:
                c = cost[before, j - 2] + local[i % 2, j]
                if c < best:
                    best, origin = c, start[before, j - 2]
            if i > 1:
                c = cost[above, j - 1] + local[(i - 1) % 2, j] + local[i % 2, j]
                if c < best:
                    best, origin = c, start[above, j - 1]
            cost[here, j], start[here, j] = best, origin
        before_least, least = least, cost[here].min()
        if min(before_least, least) > most:
            return np.inf, 0, 0
    last = (n - 1) % 3
    nearest, end = np.float32(FAR), -1
    for j in range(m):
        if cost[last, j] < nearest:
            nearest, end = cost[last, j], j
    return float(nearest / n), start[last, end], end + 1
