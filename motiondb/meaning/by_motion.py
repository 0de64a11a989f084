"""Search by example: intervals of captures that move like a query.

Three comparisons, each more exact than the one before and applied to fewer intervals:

1. symbols: the query's symbol sequence is aligned locally with every capture's, with the symbols'
   distances as substitution costs (:mod:`motiondb.meaning.by_motion`);
2. scores: the cosine between the query's score vector and that of windows of the query's length;
3. poses: subsequence time warping on the whitened features of the best intervals, which also
   determines their start and end (:mod:`motiondb.meaning.by_motion`).

The first two select candidates by ``rough`` = (cosine + alignment) / 2, where the alignment is
multiplied by the share of the aligned segments that the window covers. Where words were learned,
these recognise the same action in another style: in the best window of a capture the cosine is
replaced by the resemblance with feedback (:mod:`motiondb.meaning.resemblance`), and the
difference is added to all windows of the capture. The pooled statistics of the window are a second
opinion on its words, if they were learned. Words therefore choose between captures, and motion
alone within a capture. The final score is

    score = rough - WARP_WEIGHT * warp,    warp the mean feature distance of the third comparison.

Where the frames nearly agree (warp < ``NEAR``), rough is replaced by
1 - (1 - rough) * warp / NEAR. So a stored interval finds itself with warp 0 and score 1, the
largest, although a new segmentation of it differs from the stored one.

**The part of a capture nearest to a query: by its symbols, and by the frames of its features.**

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

import heapq
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from motiondb.meaning import extents
from motiondb.meaning.resemblance import (
    MeaningSpace,
    statistics_of_intervals,
    with_feedback,
)
from motiondb.records import Float32Array, FloatArray, IntArray

WARP_WEIGHT = 0.5  # Weight of the warping distance
MOST_CELLS = 50_000_000
"""Largest number of pairs of frames in the third comparison, over all candidates: bounds time."""
FramesOf = Callable[[Sequence[tuple[int, int, int]]], Sequence[Float32Array]]
"""Whitened features (frames, D) of each of some intervals: capture, first frame, end."""
NEAR = 0.2  # Whitened feature distance below which two intervals count as equal up to noise


@dataclass(frozen=True, eq=False)
class Query:
    """An example."""

    features: Float32Array  # (frames, D): whitened features, 15 a second
    symbols: IntArray  # (l,): symbols of its segments
    weights: FloatArray  # (l,): share of each segment in the duration; the sum is 1
    vector: FloatArray  # (columns,): its vector, of length 1
    # What the words of the vectors and of the frames are compared by. None: words are not used in
    # the comparison
    meaning: MeaningSpace | None = None


@dataclass(frozen=True, eq=False)
class Take:
    """A stored capture."""

    starts: IntArray  # (segments,): first feature frame of each segment
    ends: IntArray  # (segments,): one past the last feature frame of each segment
    symbols: IntArray  # (segments,): symbols of the segments
    standardised: FloatArray  # (segments, columns): standardised scores and movement


@dataclass(frozen=True)
class Candidate:
    """An interval of a capture, before or after time warping."""

    capture: int  # Number of the capture
    start: int
    end: int  # One past the last feature frame
    rough: float  # Score of symbols and vectors
    score: float = 0.0  # Final score; 0 before warping
    warp: float = float("inf")  # Warping distance; infinite before warping


def find_candidates(
    query: Query,
    takes: Mapping[int, Take],
    distances: FloatArray,
    n_candidates: int = 120,
    per_capture: int = 6,
    frames_of: FramesOf | None = None,
) -> list[Candidate]:
    """Intervals of largest ``rough`` score, best first (ties: lowest capture number).

    Shapes: `distances` (symbols, symbols).

    `frames_of`: Whitened features of the captures. Without them, the second opinion on the words of
    the query is not used.
    """
    scale = distance_scale(distances)
    scored = {c: _score_windows(query, take, distances, scale) for c, take in takes.items()}
    gains = dict(zip(scored, _meaning_gains(query, scored, frames_of).tolist()))
    tops = {c: float(w.rough[w.best] + 0.5 * gains[c]) for c, w in scored.items()}
    candidates: list[Candidate] = []
    weakest: list[float] = []  # a heap of the largest scores so far
    for capture in sorted(tops, key=lambda c: -tops[c]):
        if len(weakest) == n_candidates and tops[capture] < weakest[0]:
            break  # no window of this capture or a later one is among the best
        windows = scored[capture]
        for w in _separate_peaks(windows.rough, windows.low, windows.high, per_capture):
            rough = float(windows.rough[w] + 0.5 * gains[capture])
            candidates.append(Candidate(capture, int(windows.low[w]), int(windows.high[w]), rough))
            heapq.heappush(weakest, rough)
            if len(weakest) > n_candidates:
                heapq.heappop(weakest)
    candidates.sort(key=lambda c: (-c.rough, c.capture, c.start))
    return candidates[:n_candidates]


@dataclass(frozen=True, eq=False)
class _Windows:
    """Windows [low, high) of a capture with their scores; number, vector, cosine of the best one.

    ``low``, ``high`` and ``rough`` are arrays (windows,), ``vector`` is an array (columns,).
    """

    low: IntArray
    high: IntArray
    rough: FloatArray
    best: int
    vector: FloatArray
    cosine: float


def _score_windows(query: Query, take: Take, distances: FloatArray, scale: float) -> _Windows:
    aligned = align(query.symbols, query.weights, take.symbols, distances, scale)
    low, high = window_places(take.starts, take.ends, len(query.features))
    places = take.starts, take.ends, low, high
    return _Windows(low, high, *_rough_scores(places, take.standardised, query.vector, aligned))


@njit(cache=True)
def _rough_scores(
    places: tuple[IntArray, IntArray, IntArray, IntArray],
    standardised: FloatArray,
    asked: FloatArray,
    aligned: tuple[float, int, int],
) -> tuple[FloatArray, int, FloatArray, float]:
    """Scores of windows (windows,); number, vector (columns,) and cosine of the best one.

    `places`: First frame of the segments, one past their last, and the same of the windows.
    `standardised` (segments, columns); `asked` (columns,): the query's vector. `aligned`: The score
    of the alignment, and its first and last segment + 1.
    """
    starts, ends, low, high = places
    score, first, last = aligned
    n_windows, n_columns = len(low), standardised.shape[1]
    rough, vector, best_vector = np.empty(n_windows), np.empty(n_columns), np.empty(n_columns)
    best, best_cosine, begin = 0, 0.0, 0
    for w in range(n_windows):
        vector[:] = 0.0
        while begin < len(ends) - 1 and ends[begin] <= low[w]:
            begin += 1
        for s in range(begin, len(starts)):
            if starts[s] >= high[w]:
                break
            inside = min(ends[s], high[w]) - max(starts[s], low[w])
            if inside > 0:
                for c in range(n_columns):
                    vector[c] += inside * standardised[s, c]
        square, product = 0.0, 0.0
        for c in range(n_columns):
            square += vector[c] * vector[c]
            product += vector[c] * asked[c]
        length = np.sqrt(square) if square > 0.0 else 1.0
        cosine, overlap = product / length, 0.0
        if last > first:
            a, b = starts[first], ends[last - 1]
            shared = max(min(high[w], b) - max(low[w], a), 0)
            overlap = shared / max(min(high[w] - low[w], b - a), 1)
        rough[w] = 0.5 * cosine + 0.5 * score * overlap
        if w == 0 or rough[w] > rough[best]:
            best, best_cosine = w, cosine
            best_vector[:] = vector / length
    return rough, best, best_vector, best_cosine


def _meaning_gains(
    query: Query, scored: Mapping[int, _Windows], frames_of: FramesOf | None
) -> FloatArray:
    """Resemblance, with feedback, less cosine of the best window of every capture: (captures,)."""
    if query.meaning is None or not scored:
        return np.zeros(len(scored))
    vectors = np.stack([query.vector, *(windows.vector for windows in scored.values())])
    rows = query.meaning.rows(vectors, _pooled_statistics(query, scored, frames_of))
    alike = with_feedback(rows[1:] @ rows[0], rows[1:])
    return alike - np.array([windows.cosine for windows in scored.values()])


def _pooled_statistics(
    query: Query, scored: Mapping[int, _Windows], frames_of: FramesOf | None
) -> FloatArray | None:
    """Pooled statistics of the query and of the best windows, if used: (1 + captures, 5 D)."""
    if query.meaning is None or query.meaning.pooled is None or frames_of is None:
        return None
    best = [(c, int(w.low[w.best]), int(w.high[w.best])) for c, w in scored.items()]
    return statistics_of_intervals([query.features, *frames_of(best)])


def refine(
    query: Query, candidates: Sequence[Candidate], features: Mapping[int, Float32Array]
) -> list[Candidate]:
    """Exact intervals and scores by subsequence time warping, best first.

    Shapes: `features` (frames, D).

    `candidates`: Intervals, best first. For a very long query only the first ones are compared, so
    that the time is bounded (``MOST_CELLS``).
    """
    candidates = candidates[: max(8, MOST_CELLS // (3 * len(query.features) ** 2 + 1))]
    refined: list[Candidate] = []
    margin = len(query.features) + 8
    for candidate in candidates:
        low = max(0, candidate.start - margin)
        high = min(len(features[candidate.capture]), candidate.end + margin)
        part = features[candidate.capture][low:high]
        distance, start, end = best_part(query.features, part)
        if not np.isfinite(distance):
            distance, start, end = _whole(query.features, part)
        refined.append(_scored(candidate, low + start, low + end, distance))
    refined += _near_copies(query, candidates, features)
    refined.sort(key=lambda c: (-c.score, c.capture, c.start))
    return _without_overlaps(refined)


def _scored(candidate: Candidate, start: int, end: int, warp: float) -> Candidate:
    """The candidate with its exact interval and its final score (see the module)."""
    rough = 1.0 - (1.0 - candidate.rough) * min(1.0, warp / NEAR)
    score = rough - WARP_WEIGHT * warp
    return Candidate(candidate.capture, start, end, candidate.rough, score, warp)


def _near_copies(
    query: Query, candidates: Sequence[Candidate], features: Mapping[int, Float32Array]
) -> list[Candidate]:
    """Intervals of the candidates' captures that nearly agree with the query, wherever they start.

    Windows begin at segments, so that a short query cut from a long capture can lie between them.
    """
    weakest = {candidate.capture: candidate for candidate in candidates}
    copies = []
    for capture, candidate in weakest.items():
        distance, start, end = best_part(query.features, features[capture])
        if distance < NEAR:
            copies.append(_scored(candidate, start, end, distance))
    return copies


def to_activities(
    example: FloatArray, answers: Sequence[Candidate], takes: Mapping[int, FloatArray]
) -> list[Candidate]:
    """Extend answers to the interval in which the activity of the example lasts.

    Shapes: `example`, `takes` (frames, axes).

    `answers`: Answers, best first. The order is kept, and so is the interval of an answer that
    nearly agrees with the query frame by frame.
    """
    wholes = {capture: extents.extent(example, take) for capture, take in takes.items()}
    placed = []
    for c in answers:
        if c.capture in wholes and c.warp >= NEAR:
            _, start, end = wholes[c.capture]
            shared = min(end, c.end) - max(start, c.start)
            if shared > 0.5 * min(end - start, c.end - c.start):
                c = replace(c, start=start, end=end)
        placed.append(c)
    return _without_overlaps(placed)


def window_places(starts: IntArray, ends: IntArray, length: int) -> tuple[IntArray, IntArray]:
    """First frame, and one past the last, of windows that begin or end with segments.

    Shapes: `starts`, `ends` (segments,).

    >>> [place.tolist() for place in window_places(np.array([0, 10]), np.array([10, 30]), 12)]
    [[0, 10, 18], [12, 22, 30]]
    """
    return _window_places(starts, ends, length)


@njit(cache=True)
def _window_places(starts: IntArray, ends: IntArray, length: int) -> tuple[IntArray, IntArray]:
    """As :func:`window_places`."""
    total, n = ends[-1], len(starts)
    last = max(total - length, 0)
    places = np.empty(2 * n, np.int64)
    for i in range(n):
        places[i] = min(max(starts[i], 0), last)
        places[n + i] = min(max(ends[i] - length, 0), last)
    places.sort()
    low = np.empty(2 * n, np.int64)
    n_low = 0
    for place in places:
        if n_low == 0 or low[n_low - 1] != place:
            low[n_low] = place
            n_low += 1
    low = low[:n_low].copy()
    return low, np.minimum(low + length, total)


def same_motion(chance: float, warp: float) -> float:
    """Raise a probability where frames nearly agree, since equal motions show the same action.

    >>> same_motion(0.5, 0.0), same_motion(0.5, 0.1), same_motion(0.5, 0.8)
    (1.0, 0.75, 0.5)
    """
    return 1.0 - (1.0 - chance) * min(1.0, warp / NEAR)


def _separate_peaks(rough: FloatArray, low: IntArray, high: IntArray, n_peaks: int) -> list[int]:
    """Numbers of the best windows that overlap one another by less than half."""
    chosen: list[int] = []
    for w in np.argsort(-rough, kind="stable"):
        shared = [min(high[w], high[c]) - max(low[w], low[c]) for c in chosen]
        if all(s < 0.5 * (high[w] - low[w]) for s in shared):
            chosen.append(int(w))
        if len(chosen) == n_peaks:
            break
    return chosen


def _without_overlaps(candidates: list[Candidate]) -> list[Candidate]:
    """Leave out intervals that share more than half of their frames with a better one."""
    kept: list[Candidate] = []
    for c in candidates:
        shared = [min(c.end, k.end) - max(c.start, k.start) for k in kept if k.capture == c.capture]
        if all(s <= 0.5 * (c.end - c.start) for s in shared):
            kept.append(c)
    return kept


def _whole(query: Float32Array, part: Float32Array) -> tuple[float, int, int]:
    """Distance to a part too short for warping, stretched linearly to the query's length."""
    positions = np.linspace(0, len(part) - 1, len(query)).round().astype(np.int64)
    gap = np.linalg.norm(query - part[positions], axis=1) / np.sqrt(query.shape[1])
    return float(gap.mean()), 0, len(part)


GAP = 0.5  # Cost of a gap, where a match scores 1


def distance_scale(distances: FloatArray) -> float:
    """Distance above which two symbols count as unrelated: the median over pairs.

    Shapes: `distances` (symbols, symbols).
    """
    pairs = distances[np.triu_indices(len(distances), 1)]
    return max(float(np.median(pairs)), 1e-9) if len(pairs) else 1.0


def align(
    query: IntArray, weights: FloatArray, symbols: IntArray, distances: FloatArray, scale: float
) -> tuple[float, int, int]:
    """Best local alignment of a query with one capture.

    Shapes: `query`, `weights` (l,); `symbols` (n,); `distances` (symbols, symbols).
    """
    return _align(query, weights, symbols, distances, scale, GAP)


@njit(cache=True)
def _align(
    query: IntArray,
    weights: FloatArray,
    symbols: IntArray,
    distances: FloatArray,
    scale: float,
    gap: float,
) -> tuple[float, int, int]:
    """As :func:`align`, with the cost of a gap."""
    pairs = np.empty((len(query), len(symbols)))
    for i in range(len(query)):
        for j in range(len(symbols)):
            pairs[i, j] = (1.0 - distances[query[i], symbols[j]] / scale) * weights[i]
    return _smith_waterman(pairs, weights * gap)


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


def best_part(query: Float32Array, capture: Float32Array) -> tuple[float, int, int]:
    """Distance and interval of the part of a capture nearest to the query.

    Shapes: `query`, `capture` (frames, D).
    """
    if len(query) == 0 or len(capture) == 0:
        return float("inf"), 0, 0
    distance, start, end = _subsequence(
        np.ascontiguousarray(query, dtype=np.float32),
        np.ascontiguousarray(capture.T, dtype=np.float32),
    )
    if end == 0:
        return float("inf"), 0, 0
    return float(distance), start, end


@njit(cache=True)
def _subsequence(  # noqa: C901  one compiled dynamic program over three rows
    query: Float32Array, columns: Float32Array
) -> tuple[float, int, int]:
    """Least mean cost of a path, its first frame, and one past its last (0: there is none).

    The capture is given by dimension (D, frames), so that distances are computed for many frames at
    once without fast math, whose sums depend on the processor.

    Rows i, i - 1 and i - 2 suffice: row i of cost and start is kept at i % 3, of local at i % 2.
    """
    n, m = len(query), columns.shape[1]
    local = np.empty((2, m), np.float32)
    cost = np.full((3, m), np.float32(FAR))
    start = np.zeros((3, m), np.int64)
    for i in range(n):
        here, before, above = i % 3, (i - 1) % 3, (i - 2) % 3
        squares = np.zeros(m, np.float32)
        for d in range(query.shape[1]):
            for j in range(m):
                difference = query[i, d] - columns[d, j]
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
    last = (n - 1) % 3
    low, end = np.float32(FAR), -1
    for j in range(m):
        if cost[last, j] < low:
            low, end = cost[last, j], j
    return float(low / n), start[last, end], end + 1
