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
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from motiondb.meaning import extents
from motiondb.meaning.alignment import align_captures, best_part
from motiondb.meaning.resemblance import (
    FEEDBACK,
    MOVING_LENGTH,
    MeaningSpace,
    pooled_statistics,
    right_answers,
    statistics_of_intervals,
)
from motiondb.meaning.windows import ComparedSegments, Windows, row_products, score_windows
from motiondb.records import Float32Array, FloatArray, IntArray

WARP_WEIGHT = 0.5  # Weight of the warping distance
MOST_CELLS = 50_000_000
"""Largest number of pairs of frames in the third comparison, over all candidates: bounds time."""
FramesOf = Callable[[Sequence[tuple[int, int, int]]], Sequence[Float32Array]]
"""Whitened features (frames, D) of each of some intervals: capture, first frame, end."""
_TOGETHER = 64  # Captures whose second opinion is computed together
PER_CAPTURE = 6  # Most candidates of one capture
N_CANDIDATES = 120  # Most candidates of all captures
NEAR = 0.2  # Whitened feature distance below which two intervals count as equal up to noise
SAME = 0.02  # The same, for which an answer is called the same motion as the example


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
    bounds: IntArray  # (captures, 2): first segment of each, and one past its last
    segments: ComparedSegments  # Those of all captures


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
    n_candidates: int = N_CANDIDATES,
    frames_of: FramesOf | None = None,
) -> list[Candidate]:
    """Intervals of largest ``rough`` score, best first (ties: lowest capture number).

    Shapes: `distances` (symbols, symbols).

    `frames_of`: Whitened features of the captures. Without them, the second opinion on the words of
    the query is not used.
    """
    segments, length = takes.segments, len(query.features)
    aligned = align_captures(
        query.symbols, query.weights, segments.symbols, takes.bounds, distances
    )
    windows = score_windows(segments, takes.bounds, query.vector, aligned, length)
    tops = _scores_of_best(query, takes, windows, frames_of, n_candidates)
    candidates: list[Candidate] = []
    weakest: list[float] = []  # a heap of the largest scores so far
    for n in np.argsort(-tops, kind="stable").tolist():
        if len(weakest) == n_candidates and tops[n] < weakest[0]:
            break  # no window of this capture or a later one is among the best
        own = slice(windows.edges[n], windows.edges[n + 1])
        places = windows.places[own]
        scores = windows.rough[own] + (tops[n] - windows.rough[windows.best[n]])
        for w in _separate_peaks(scores, places):
            capture, score = int(takes.captures[n]), float(scores[w])
            candidates.append(Candidate(capture, int(places[w, 0]), int(places[w, 1]), score))
            heapq.heappush(weakest, score)
            if len(weakest) > n_candidates:
                heapq.heappop(weakest)
    return sorted(candidates, key=lambda c: (-c.rough, c.capture, c.start))[:n_candidates]


def _scores_of_best(
    query: Query, takes: Takes, windows: Windows, frames_of: FramesOf | None, n: int
) -> FloatArray:
    """Scores of the best window of every capture, its cosine replaced by the resemblance.

    Array (captures,); -inf where it is not among the n largest.
    """
    rough, space = windows.rough[windows.best], query.meaning
    if space is None or not len(rough):
        return rough
    if frames_of is None:
        space = replace(space, pooled=None)
    example = space.rows(query.vector, pooled_statistics(query.features))
    rows = _BestRows(takes, windows, space, frames_of if space.pooled is not None else None)
    moving = windows.moving * MOVING_LENGTH**2
    alike = _largest(
        space.most_alike(rows.said, moving, example, example),
        FEEDBACK,
        lambda some: row_products(rows.of(some), example),
    )
    best, weights = right_answers(alike)
    asked = 0.5 * (example + weights @ rows.of(best)) if len(best) else example
    plain = rough - 0.5 * windows.cosine
    return _largest(
        plain + 0.5 * space.most_alike(rows.said, moving, example, asked),
        n,
        lambda some: plain[some] + 0.5 * row_products(rows.of(some), asked),
    )


class _BestRows:
    """Rows (:mod:`motiondb.meaning.resemblance`) of the best windows of captures.

    Movement and second opinion are the slowest parts of a row, and change a resemblance by a
    bounded amount. They are computed only for captures that they may bring among the best: a tenth
    of 2,700 captures, a thirtieth of 10,800.
    """

    def __init__(
        self, takes: Takes, windows: Windows, space: MeaningSpace, frames_of: FramesOf | None
    ) -> None:
        self._takes, self._windows, self._space, self._frames_of = takes, windows, space, frames_of
        self.said = space.said_rows(windows.evidence)  # (captures, words)
        self._at = np.full(len(self.said), -1)  # (captures,): places in ``_known``
        self._known: FloatArray | Float32Array | None = None  # whole rows

    def of(self, some: IntArray) -> FloatArray | Float32Array:
        """The rows of some captures: array (captures, columns of a row)."""
        new = some[self._at[some] < 0]
        if len(new):
            places, statistics = self._windows.places[self._windows.best[new]], None
            if self._frames_of is not None:
                columns = self._takes.captures[new], places[:, 0], places[:, 1]
                intervals = list(zip(*(column.tolist() for column in columns), strict=True))
                statistics = statistics_of_intervals(self._frames_of(intervals))
            vectors = self._takes.segments.vectors(places)
            rows = np.concatenate(
                [self.said[new], self._space.rest_rows(vectors, statistics)], axis=1
            )
            known = rows[:0] if self._known is None else self._known
            self._at[new] = np.arange(len(known), len(known) + len(new))
            self._known = np.concatenate([known, rows])
        assert self._known is not None
        return self._known[self._at[some]]


def _largest(
    bounds: FloatArray, n: int, values_of: Callable[[IntArray], FloatArray | Float32Array]
) -> FloatArray:
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
    query: Query, candidates: Sequence[Candidate], frames_of: Callable[[int], Float32Array]
) -> list[Candidate]:
    """Exact intervals and scores of candidates by subsequence time warping, best first.

    With them come intervals of the same captures that nearly agree with the query. The weaker of
    two that overlap is left out.

    `candidates`: Intervals, best first. For a very long query only the first ones are compared, so
    that the time is bounded (``MOST_CELLS``). `frames_of`: Whitened features (frames, D) of a
    capture.
    """
    candidates = candidates[: max(8, MOST_CELLS // (3 * len(query.features) ** 2 + 1))]
    columns = {  # by dimension, as time warping takes them
        capture: np.ascontiguousarray(frames_of(capture).T, dtype=np.float32)
        for capture in {c.capture for c in candidates}
    }
    refined: list[Candidate] = []
    margin = len(query.features) + 8
    for candidate in candidates:
        low = max(0, candidate.start - margin)
        whole = columns[candidate.capture]
        high = min(whole.shape[1], candidate.end + margin)
        distance, start, end = best_part(query.features, whole, low, high)
        if not np.isfinite(distance):
            distance, start, end = _whole(query.features, whole[:, low:high].T), low, high
        refined.append(_scored(candidate, start, end, distance))
    refined += _near_copies(query, candidates, columns)
    return _without_overlaps(sorted(refined, key=lambda c: (-c.score, c.capture, c.start)))


def _scored(candidate: Candidate, start: int, end: int, warp: float) -> Candidate:
    """The candidate with its exact interval and its final score (see the module)."""
    rough = 1.0 - (1.0 - candidate.rough) * min(1.0, warp / NEAR)
    score = rough - WARP_WEIGHT * warp
    return Candidate(candidate.capture, start, end, candidate.rough, score, warp)


def _near_copies(
    query: Query, candidates: Sequence[Candidate], columns: Mapping[int, Float32Array]
) -> list[Candidate]:
    """Intervals of the candidates' captures that nearly agree with the query, wherever they start.

    Windows begin at segments, so that a short query cut from a long capture can lie between them.
    """
    weakest = {candidate.capture: candidate for candidate in candidates}
    copies = []
    for capture, candidate in weakest.items():
        distance, start, end = best_part(query.features, columns[capture], farthest=NEAR)
        if distance < NEAR:
            copies.append(_scored(candidate, start, end, distance))
    return copies


def to_activities(
    example: FloatArray,
    answers: Sequence[Candidate],
    takes: Mapping[int, FloatArray | None],
    most: int | None = None,
) -> list[Candidate]:
    """Extend answers to the interval in which the activity of the example lasts.

    Shapes: `example`, `takes` (frames, axes).

    `answers`: Answers, best first. The order is kept, and so is the interval of an answer that
    nearly agrees with the query frame by frame. `takes`: None: not known. `most`: No more answers
    are looked at than are needed for so many.
    """
    wholes = dict[int, tuple[int, int]]()

    def placed(c: Candidate) -> Candidate:
        if c.warp < NEAR or c.capture not in takes:
            return c
        if c.capture not in wholes:
            take = takes[c.capture]
            wholes[c.capture] = (0, 0) if take is None else extents.extent(example, take)[1:]
        start, end = wholes[c.capture]
        shared = min(end, c.end) - max(start, c.start)
        is_same = shared > 0.5 * min(end - start, c.end - c.start)
        return replace(c, start=start, end=end) if is_same and end else c

    return _without_overlaps(map(placed, answers), most)


def same_motion(chance: float, warp: float) -> float:
    """Raise a probability where frames nearly agree, since equal motions show the same action.

    >>> same_motion(0.5, 0.0), same_motion(0.5, 0.1), same_motion(0.5, 0.8)
    (1.0, 0.75, 0.5)
    """
    return 1.0 - (1.0 - chance) * min(1.0, warp / NEAR)


@njit(cache=True)
def _separate_peaks(rough: FloatArray, places: IntArray) -> IntArray:
    """Numbers of the best windows that overlap one another by less than half.

    Shapes: `rough` (windows,); `places` (windows, 4).
    """
    chosen, n = np.empty(PER_CAPTURE, np.int64), 0
    for w in np.argsort(-rough, kind="mergesort"):
        low, high = places[w, 0], places[w, 1]
        apart = True
        for c in chosen[:n]:
            shared = min(high, places[c, 1]) - max(low, places[c, 0])
            apart = apart and shared < 0.5 * (high - low)
        if apart:
            chosen[n] = w
            n += 1
        if n == PER_CAPTURE:
            break
    return chosen[:n]


def _without_overlaps(candidates: Iterable[Candidate], most: int | None = None) -> list[Candidate]:
    """Leave out intervals that share more than half of their frames with a better one."""
    kept: list[Candidate] = []
    for c in candidates:
        if len(kept) == most:
            break
        shared = [min(c.end, k.end) - max(c.start, k.start) for k in kept if k.capture == c.capture]
        if all(s <= 0.5 * (c.end - c.start) for s in shared):
            kept.append(c)
    return kept


def _whole(query: Float32Array, part: Float32Array) -> float:
    """Distance to a part too short for warping, stretched linearly to the query's length."""
    positions = np.linspace(0, len(part) - 1, len(query)).round().astype(np.int64)
    gap = np.linalg.norm(query - part[positions], axis=1) / np.sqrt(query.shape[1])
    return float(gap.mean())
