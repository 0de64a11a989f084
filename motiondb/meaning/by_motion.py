"""Search by example: intervals of captures that move like a query.

Three comparisons, each more exact than the one before and applied to fewer intervals:

1. symbols: the query's symbol sequence is aligned locally with every capture's, with the symbols'
   distances as substitution costs (:mod:`motiondb.meaning.alignment`);
2. scores: the cosine between the query's score vector and that of windows of the query's length;
3. poses: subsequence time warping on the whitened features of the best intervals, which also
   determines their start and end (:mod:`motiondb.meaning.alignment`).

The first two select candidates by ``rough`` = (cosine + alignment) / 2, where the alignment is
multiplied by the share of the aligned segments that the window covers. Where words were learned, in
the best window of a capture the cosine is replaced by the resemblance with feedback
(:mod:`motiondb.meaning.resemblance`), and the difference is added to all windows of the capture:
words choose between captures, and motion alone within a capture. The final score is

    score = rough - WARP_WEIGHT * warp,    warp the mean feature distance of the third comparison.

Where the frames nearly agree (warp < ``NEAR``), rough is replaced by
1 - (1 - rough) * warp / NEAR. So a stored interval finds itself with warp 0 and score 1, the
largest, although a new segmentation of it differs from the stored one.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from motiondb.meaning import extents
from motiondb.meaning.alignment import align, best_part, distance_scale
from motiondb.meaning.resemblance import (
    SECOND_LENGTH,
    MeaningSpace,
    n_right,
    pooled_statistics,
    right_answers,
    statistics_of_intervals,
    with_feedback,
)
from motiondb.records import Float32Array, FloatArray, IntArray

WARP_WEIGHT = 0.5  # Weight of the warping distance
MOST_CELLS = 50_000_000
"""Largest number of pairs of frames in the third comparison, over all candidates: bounds time."""
FramesOf = Callable[[Sequence[tuple[int, int, int]]], Sequence[Float32Array]]
"""Whitened features (frames, D) of each of some intervals: capture, first frame, end."""
_TOGETHER = 64  # Captures whose second opinion is computed together
PER_CAPTURE = 6  # Most candidates of one capture
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
class Takes:
    """Stored captures: each one some successive rows of a table of segments."""

    captures: IntArray  # (captures,): their numbers
    first: IntArray  # (captures,): first row of each
    last: IntArray  # (captures,): one past the last row of each
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
    takes: Takes,
    distances: FloatArray,
    n_candidates: int = 120,
    frames_of: FramesOf | None = None,
) -> list[Candidate]:
    """Intervals of largest ``rough`` score, best first (ties: lowest capture number).

    Shapes: `distances` (symbols, symbols).

    `frames_of`: Whitened features of the captures. Without them, the second opinion on the words of
    the query is not used.
    """
    windows = _score_windows(query, takes, distances)
    tops = _scores_of_best(query, windows, frames_of, n_candidates)
    candidates: list[Candidate] = []
    weakest: list[float] = []  # a heap of the largest scores so far
    for n in np.argsort(-tops, kind="stable").tolist():
        if len(weakest) == n_candidates and tops[n] < weakest[0]:
            break  # no window of this capture or a later one is among the best
        own = slice(windows.edges[n], windows.edges[n + 1])
        low, high = windows.low[own], windows.high[own]
        scores = windows.rough[own] + (tops[n] - windows.rough[windows.best[n]])
        for w in _separate_peaks(scores, low, high):
            capture, score = int(windows.captures[n]), float(scores[w])
            candidates.append(Candidate(capture, int(low[w]), int(high[w]), score))
            heapq.heappush(weakest, score)
            if len(weakest) > n_candidates:
                heapq.heappop(weakest)
    candidates.sort(key=lambda c: (-c.rough, c.capture, c.start))
    return candidates[:n_candidates]


@dataclass(frozen=True, eq=False)
class _Windows:
    """Windows [low, high) of captures with their scores, and the best one of each capture.

    ``low``, ``high`` and ``rough`` are arrays (windows,), the others (captures,) if not said.
    """

    captures: IntArray
    edges: IntArray  # (captures + 1,): first window of each capture, and their number
    low: IntArray
    high: IntArray
    rough: FloatArray
    best: IntArray  # Number of the best window
    cosine: FloatArray  # Of its vector with that of the query
    vector: FloatArray  # (captures, columns): its vector, of length 1

    def places_of_best(self, some: IntArray) -> list[tuple[int, int, int]]:
        """Capture, first frame and end of the best windows of some captures."""
        best = self.best[some]
        columns = self.captures[some], self.low[best], self.high[best]
        return list(zip(*(column.tolist() for column in columns), strict=True))


def _score_windows(query: Query, takes: Takes, distances: FloatArray) -> _Windows:
    """Score the windows of all captures by symbols and vectors."""
    table = takes.starts, takes.ends, takes.symbols
    aligning = query.symbols, query.weights, distances, distance_scale(distances)
    scored = _score_rows(
        (takes.first, takes.last), table, takes.standardised, query.vector, aligning,
        len(query.features),
    )  # fmt: skip
    return _Windows(takes.captures, *scored)


@njit(cache=True)
def _score_rows(
    rows: tuple[IntArray, IntArray],
    table: tuple[IntArray, IntArray, IntArray],
    standardised: FloatArray,
    asked: FloatArray,
    aligning: tuple[IntArray, FloatArray, FloatArray, float],
    length: int,
) -> tuple[IntArray, IntArray, IntArray, FloatArray, IntArray, FloatArray, FloatArray]:
    """The fields of :class:`_Windows`, all but the first.

    `rows`: First row of every capture, and one past its last. `table`: Starts, ends and symbols of
    segments. `asked` (columns,): the query's vector. `aligning`: The query's symbols and weights,
    the distances of symbols and their scale. `length`: That of the windows, frames.
    """
    (first, last), (starts, ends, symbols) = rows, table
    most, n_captures = 2 * int((last - first).sum()), len(first)
    edges = np.zeros(n_captures + 1, np.int64)
    low, high = np.empty(most, np.int64), np.empty(most, np.int64)
    rough, cosines = np.empty(most), np.empty(n_captures)
    best = np.empty(n_captures, np.int64)
    vectors = np.zeros((n_captures, standardised.shape[1]))
    for n in range(n_captures):
        a, b, at = first[n], last[n], edges[n]
        query, weights, distances, scale = aligning
        aligned = align(query, weights, symbols[a:b], distances, scale)
        some_low, some_high = _window_places(starts[a:b], ends[a:b], length)
        to = at + len(some_low)
        edges[n + 1], low[at:to], high[at:to] = to, some_low, some_high
        places = starts[a:b], ends[a:b], some_low, some_high
        chosen, cosines[n] = _rough_scores(
            places, standardised[a:b], asked, aligned, rough[at:to], vectors[n]
        )
        best[n] = at + chosen
    total = edges[n_captures]
    return edges, low[:total], high[:total], rough[:total], best, cosines, vectors


@njit(cache=True)
def _rough_scores(
    places: tuple[IntArray, IntArray, IntArray, IntArray],
    standardised: FloatArray,
    asked: FloatArray,
    aligned: tuple[float, int, int],
    rough: FloatArray,
    vector: FloatArray,
) -> tuple[int, float]:
    """Number and cosine of the best window; writes ``rough`` (windows,) and its ``vector``.

    A window's vector is the sum of rows, each times its frames inside. Its length and its product
    with the query follow from the products of rows, which are computed once for all windows.

    `places`: First frame of the segments, one past their last, and the same of the windows.
    `standardised` (segments, columns); `asked` (columns,): the query's vector. `aligned`: The score
    of the alignment, and its first and last segment + 1. `vector` (columns,): zeros.
    """
    starts, ends, low, high = places
    score, first, last = aligned
    begin, end, width = _rows_inside(starts, ends, low, high)
    products, together = _products(standardised, asked, width)
    best, best_cosine = 0, 0.0
    inside = np.empty(width)
    for w in range(len(low)):
        a, n = begin[w], end[w] - begin[w]
        product, square = 0.0, 0.0
        for s in range(n):
            inside[s] = max(min(ends[a + s], high[w]) - max(starts[a + s], low[w]), 0)
            product += inside[s] * products[a + s]
        for s in range(n):
            square += inside[s] * inside[s] * together[a + s, 0]
            for t in range(s + 1, n):
                square += 2.0 * inside[s] * inside[t] * together[a + s, t - s]
        cosine = product / np.sqrt(square) if square > 0.0 else product
        overlap = 0.0
        if last > first:
            from_, to = starts[first], ends[last - 1]
            shared = max(min(high[w], to) - max(low[w], from_), 0)
            overlap = shared / max(min(high[w] - low[w], to - from_), 1)
        rough[w] = 0.5 * cosine + 0.5 * score * overlap
        if w == 0 or rough[w] > rough[best]:
            best, best_cosine = w, cosine
    for s in range(begin[best], end[best]):
        frames = max(min(ends[s], high[best]) - max(starts[s], low[best]), 0)
        vector += frames * standardised[s]
    square = _dot(vector, vector)
    if square > 0.0:
        vector /= np.sqrt(square)
    return best, best_cosine


@njit(cache=True)
def _rows_inside(
    starts: IntArray, ends: IntArray, low: IntArray, high: IntArray
) -> tuple[IntArray, IntArray, int]:
    """First row of every window, one past its last (windows,), and the largest number of rows."""
    begin, end = np.empty(len(low), np.int64), np.empty(len(low), np.int64)
    a, width = 0, 1
    for w in range(len(low)):
        while a < len(ends) - 1 and ends[a] <= low[w]:
            a += 1
        b = a
        while b < len(starts) and starts[b] < high[w]:
            b += 1
        begin[w], end[w] = a, b
        width = max(width, b - a)
    return begin, end, width


@njit(cache=True)
def _products(
    standardised: FloatArray, asked: FloatArray, width: int
) -> tuple[FloatArray, FloatArray]:
    """Products of the rows with the query (segments,), and with the next rows (segments, width)."""
    n = len(standardised)
    products, together = np.empty(n), np.zeros((n, width))
    for s in range(n):
        products[s] = _dot(standardised[s], asked)
        for t in range(min(width, n - s)):
            together[s, t] = _dot(standardised[s], standardised[s + t])
    return products, together


@njit(cache=True)
def _dot(one: FloatArray, other: FloatArray) -> float:
    """Dot product in eight sums: the same on every processor, in a quarter of the time of one."""
    a = b = c = d = e = f = g = h = 0.0
    n = len(one)
    last = n - n % 8
    for i in range(0, last, 8):
        a += one[i] * other[i]
        b += one[i + 1] * other[i + 1]
        c += one[i + 2] * other[i + 2]
        d += one[i + 3] * other[i + 3]
        e += one[i + 4] * other[i + 4]
        f += one[i + 5] * other[i + 5]
        g += one[i + 6] * other[i + 6]
        h += one[i + 7] * other[i + 7]
    for i in range(last, n):
        a += one[i] * other[i]
    return ((a + b) + (c + d)) + ((e + f) + (g + h))


def _scores_of_best(
    query: Query, windows: _Windows, frames_of: FramesOf | None, n: int
) -> FloatArray:
    """Scores of the best window of every capture, its cosine replaced by the resemblance.

    Array (captures,); -inf where it is not among the n largest. A second opinion is computed only
    for captures that it may bring among these, since it is the slowest part and changes a
    resemblance by a bounded amount: a tenth of 2,700 captures.
    """
    rough = windows.rough[windows.best]
    meaning = query.meaning
    if meaning is None or not len(rough):
        return rough
    vectors = np.concatenate([query.vector[np.newaxis], windows.vector])
    if meaning.pooled is None or frames_of is None:
        rows = meaning.rows(vectors)
        alike = with_feedback(rows[1:] @ rows[0], rows[1:])
        return rough + 0.5 * (alike - windows.cosine)
    first = meaning.first_rows(vectors)
    example, first = first[0], first[1:]
    opinion = meaning.second_rows(pooled_statistics(query.features)[np.newaxis])[0]
    second = np.zeros((len(rough), len(opinion)), opinion.dtype)
    known = np.zeros(len(rough), bool)

    def opinions(some: IntArray) -> FloatArray | Float32Array:
        new = some[~known[some]]
        if len(new):
            frames = frames_of(windows.places_of_best(new))
            second[new], known[new] = meaning.second_rows(statistics_of_intervals(frames)), True
        return second[some]

    likely = first @ example
    alike = _largest(
        likely + _reach(opinion), n_right(len(rough)), lambda c: likely[c] + opinions(c) @ opinion
    )
    best, weights = right_answers(alike)
    if len(best):
        example = 0.5 * (example + weights @ first[best])
        opinion = 0.5 * (opinion + weights @ second[best])
    scores = rough + 0.5 * (first @ example - windows.cosine)
    return _largest(
        scores + 0.5 * _reach(opinion), n, lambda c: scores[c] + 0.5 * (opinions(c) @ opinion)
    )


def _reach(opinion: FloatArray | Float32Array) -> float:
    """Largest product of a second opinion with a row, and what rounding may add."""
    return SECOND_LENGTH * float(np.linalg.norm(opinion)) + 1e-5


def _largest(bounds: FloatArray, n: int, values_of: Callable[[IntArray], FloatArray]) -> FloatArray:
    """Values, none above its bound, computed in order of the bounds until the n largest are known.

    The others are -inf.
    """
    values, at = np.full(len(bounds), -np.inf), 0
    order = np.argsort(-bounds, kind="stable")
    while at < len(order):
        if at >= n and bounds[order[at]] < np.partition(values, -n)[-n]:
            break
        some = order[at : at + max(n, _TOGETHER)]
        values[some] = values_of(some)
        at += len(some)
    return values


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


def _separate_peaks(rough: FloatArray, low: IntArray, high: IntArray) -> list[int]:
    """Numbers of the best windows that overlap one another by less than half."""
    chosen: list[int] = []
    for w in np.argsort(-rough, kind="stable"):
        shared = [min(high[w], high[c]) - max(low[w], low[c]) for c in chosen]
        if all(s < 0.5 * (high[w] - low[w]) for s in shared):
            chosen.append(int(w))
        if len(chosen) == PER_CAPTURE:
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
