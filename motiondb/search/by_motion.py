"""Which intervals move like an example.

Three looks, each finer and each at fewer places:

1. symbols: the query's symbol sequence is aligned locally with every capture's, the symbols'
   distances as substitution costs (:mod:`motiondb.search.alignment`);
2. scores: the cosine between the query's score vector and that of windows of the query's length;
3. poses: subsequence time warping on the whitened features of the best intervals, which also sets
   the exact start and end (:mod:`motiondb.search.warping`).

The first two choose candidates by ``rough`` = (cosine + alignment) / 2, where the alignment counts
as far as the window holds the aligned segments. Where words were learned, they tell which captures
show the same action in another style: the best window of a capture takes its :func:`resemblance`
in place of the cosine, and all windows of the capture are raised or lowered by as much. So words
choose between captures, and motion alone within one. The answer's ``score`` is exactly

    score = rough - WARP_WEIGHT * warp,    warp the mean feature distance of the third look;

only where the frames themselves all but agree (warp < ``NEAR``) do symbols and scores count less,
rough' = 1 - (1 - rough) * warp / NEAR in place of rough: a stored interval finds itself with warp
0 and the largest possible score, 1, though segments cut anew from it differ from those that it was
part of.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.search import alignment, extents, warping
from motiondb.search.score_vectors import interval_vectors, unit
from motiondb.words.word_map import WordMap

WARP_WEIGHT = 0.5
MOST_CELLS = 50_000_000
"""Pairs of frames that the third look may compare, all candidates together."""
MEANING_SHARE = 0.8
"""How much of a resemblance is what is said to words, where words were learned."""
NEAR = 0.2
"""Whitened feature distance below which two intervals are one but for noise."""


@dataclass(frozen=True, eq=False)
class Query:
    """An example: whitened features (frames, D) at 15 a second, its symbols, their shares of its
    length, its vector (columns,), the word map where words shall judge likeness too, and how many
    of the vector's last columns are posture and travel (``search.bearing``)."""

    features: Float32Array
    symbols: IntArray
    weights: FloatArray
    vector: FloatArray
    words: WordMap | None = None
    n_bearing: int = 0


@dataclass(frozen=True, eq=False)
class Take:
    """A stored capture: segments (feature frames), symbols and standardised scores."""

    starts: IntArray
    ends: IntArray
    symbols: IntArray
    standardised: FloatArray


@dataclass(frozen=True)
class Candidate:
    """An interval of a capture (feature frames) before and after the exact look."""

    capture: int
    start: int
    end: int
    rough: float
    score: float = 0.0
    warp: float = float("inf")


def find_candidates(
    query: Query,
    takes: Mapping[int, Take],
    distances: FloatArray,
    n_candidates: int = 120,
    per_capture: int = 6,
) -> list[Candidate]:
    """The most promising intervals of all captures, best first (ties: lowest capture number)."""
    scale = alignment.distance_scale(distances)
    looks = {c: _look(query, take, distances, scale) for c, take in takes.items()}
    gains = _meaning_gains(query, list(looks.values()))
    found: list[Candidate] = []
    for (capture, look), gain in zip(looks.items(), gains):
        for w in _separate_peaks(look.rough, look.low, look.high, per_capture):
            rough = float(look.rough[w] + 0.5 * gain)
            found.append(Candidate(capture, int(look.low[w]), int(look.high[w]), rough))
    found.sort(key=lambda c: (-c.rough, c.capture, c.start))
    return found[:n_candidates]


@dataclass(frozen=True, eq=False)
class _Look:
    """Windows [low, high) of a capture, how alike they move, and of the best one its vector and
    cosine: arrays (windows,), (columns,), a number."""

    low: IntArray
    high: IntArray
    rough: FloatArray
    vector: FloatArray
    cosine: float


def _look(query: Query, take: Take, distances: FloatArray, scale: float) -> _Look:
    aligned, first, last = alignment.align(
        query.symbols, query.weights, take.symbols, distances, scale
    )
    low, high = window_places(take.starts, take.ends, len(query.features))
    vectors = interval_vectors(take.standardised, take.starts, take.ends, low, high)
    cosine = resemblance(query.vector, vectors)
    overlap = np.zeros(len(low))
    if last > first:
        a, b = take.starts[first], take.ends[last - 1]
        shared = np.maximum(np.minimum(high, b) - np.maximum(low, a), 0)
        overlap = shared / np.maximum(np.minimum(high - low, b - a), 1)
    rough = 0.5 * cosine + 0.5 * aligned * overlap
    best = int(np.argmax(rough))
    return _Look(low, high, rough, vectors[best], float(cosine[best]))


def _meaning_gains(query: Query, looks: Sequence[_Look]) -> FloatArray:
    """What words add to the likeness of the best window of every capture: array (captures,)."""
    if query.words is None or not looks:
        return np.zeros(len(looks))
    vectors = np.stack([look.vector for look in looks])
    alike = resemblance(query.vector, vectors, query.words, n_bearing=query.n_bearing)
    return alike - np.array([look.cosine for look in looks])


def refine(
    query: Query, candidates: Sequence[Candidate], features: Mapping[int, Float32Array]
) -> list[Candidate]:
    """Exact intervals and scores by subsequence warping, best first.

    features : capture -> whitened features (frames, D). Of a very long query only the first
    candidates are looked at, so that the time stays bounded.
    """
    candidates = candidates[: max(8, MOST_CELLS // (3 * len(query.features) ** 2 + 1))]
    refined: list[Candidate] = []
    margin = len(query.features) + 8
    for candidate in candidates:
        low = max(0, candidate.start - margin)
        high = min(len(features[candidate.capture]), candidate.end + margin)
        part = features[candidate.capture][low:high]
        distance, start, end = warping.best_part(query.features, part)
        if not np.isfinite(distance):
            distance, start, end = _whole(query.features, part)
        refined.append(_scored(candidate, low + start, low + end, distance))
    refined += _near_copies(query, candidates, features)
    refined.sort(key=lambda c: (-c.score, c.capture, c.start))
    return _without_overlaps(refined)


def _scored(candidate: Candidate, start: int, end: int, warp: float) -> Candidate:
    """The candidate at its exact place, with its score (see the module)."""
    rough = 1.0 - (1.0 - candidate.rough) * min(1.0, warp / NEAR)
    score = rough - WARP_WEIGHT * warp
    return Candidate(candidate.capture, start, end, candidate.rough, score, warp)


def _near_copies(
    query: Query, candidates: Sequence[Candidate], features: Mapping[int, Float32Array]
) -> list[Candidate]:
    """Parts of the candidates' captures that all but agree with the query, wherever they are.

    Windows begin at segments, so a short query out of a long capture can fall between them.
    """
    weakest = {candidate.capture: candidate for candidate in candidates}
    found = []
    for capture, candidate in weakest.items():
        distance, start, end = warping.best_part(query.features, features[capture])
        if distance < NEAR:
            found.append(_scored(candidate, start, end, distance))
    return found


def to_activities(
    example: FloatArray, found: Sequence[Candidate], takes: Mapping[int, FloatArray]
) -> list[Candidate]:
    """Answers with the interval in which the example's activity goes on, where there is one.

    Parameters
    ----------
    example : array
        Contexts (frames, axes) of the query, see :mod:`motiondb.search.extents`.
    found : sequence of Candidate
        Best first; the order stays. What all but agrees frame by frame keeps its interval.
    takes : Mapping[int, FloatArray]
        Capture -> contexts, of the captures that are long enough to hold more than the answer.
    """
    wholes = {capture: extents.extent(example, take) for capture, take in takes.items()}
    placed = []
    for c in found:
        if c.capture in wholes and c.warp >= NEAR:
            _, start, end = wholes[c.capture]
            shared = min(end, c.end) - max(start, c.start)
            if shared > 0.5 * min(end - start, c.end - c.start):
                c = replace(c, start=start, end=end)
        placed.append(c)
    return _without_overlaps(placed)


def window_places(starts: IntArray, ends: IntArray, length: int) -> tuple[IntArray, IntArray]:
    """First and last + 1 frame of windows of a length that begin or end with segments.

    Parameters
    ----------
    starts : array (segments,)
        Frames of one capture, which they tile.
    ends : array (segments,)
        Frames of one capture, which they tile.

    >>> [place.tolist() for place in window_places(np.array([0, 10]), np.array([10, 30]), 12)]
    [[0, 10, 18], [12, 22, 30]]
    """
    total = int(ends[-1])
    low = np.unique(np.clip(np.concatenate([starts, ends - length]), 0, None))
    low = np.unique(np.minimum(low, max(total - length, 0)))
    return low, np.minimum(low + length, total)


def resemblance(
    vector: FloatArray, vectors: FloatArray, words: WordMap | None = None, *, n_bearing: int = 0
) -> FloatArray:
    """How alike intervals are to one: array (n,), 1 for the same.

    The cosine of their vectors. With a word map (4 m + cosine) / 5, m the cosine between what the
    two say to all words, and the other cosine without posture and travel: where a body is and how
    far it gets differ with the place and the performer, and what of it matters to an action the
    words have heard. Both cosines are sums over symbols and over columns of movement.

    Parameters
    ----------
    vector : array (columns,)
        Of length 1.
    vectors : array (n, columns)
        Rows of length 1.
    n_bearing : int, optional
        How many of the last columns are posture and travel.
    """
    if words is None:
        return np.asarray(vectors @ vector)
    rows = meaning_rows(words, vectors, n_bearing)
    return np.asarray(rows @ meaning_rows(words, vector, n_bearing))


def meaning_rows(words: WordMap, vectors: FloatArray, n_bearing: int = 0) -> FloatArray:
    """Rows whose products are the resemblances of :func:`resemblance`: (..., columns + words).

    For many questions to the same intervals: what they say to all words and how they move, each
    scaled to length 1, side by side.
    """
    said = unit(words.evidence(vectors))
    moving = unit(vectors[..., : vectors.shape[-1] - n_bearing])
    return np.concatenate(
        [np.sqrt(MEANING_SHARE) * said, np.sqrt(1.0 - MEANING_SHARE) * moving], axis=-1
    )


def same_motion(chance: float, warp: float) -> float:
    """A probability where frames all but agree: what is one motion shows one thing.

    >>> same_motion(0.5, 0.0), same_motion(0.5, 0.1), same_motion(0.5, 0.8)
    (1.0, 0.75, 0.5)
    """
    return 1.0 - (1.0 - chance) * min(1.0, warp / NEAR)


def _separate_peaks(rough: FloatArray, low: IntArray, high: IntArray, n_peaks: int) -> list[int]:
    """The best windows that overlap one another by less than half."""
    chosen: list[int] = []
    for w in np.argsort(-rough, kind="stable"):
        shared = [min(high[w], high[c]) - max(low[w], low[c]) for c in chosen]
        if all(s < 0.5 * (high[w] - low[w]) for s in shared):
            chosen.append(int(w))
        if len(chosen) == n_peaks:
            break
    return chosen


def _without_overlaps(candidates: list[Candidate]) -> list[Candidate]:
    """Drop an interval that shares more than half of itself with a better one."""
    kept: list[Candidate] = []
    for c in candidates:
        shared = [min(c.end, k.end) - max(c.start, k.start) for k in kept if k.capture == c.capture]
        if all(s <= 0.5 * (c.end - c.start) for s in shared):
            kept.append(c)
    return kept


def _whole(query: Float32Array, part: Float32Array) -> tuple[float, int, int]:
    """Distance to a part too short to warp: both stretched linearly to the query's length."""
    positions = np.linspace(0, len(part) - 1, len(query)).round().astype(np.int64)
    gap = np.linalg.norm(query - part[positions], axis=1) / np.sqrt(query.shape[1])
    return float(gap.mean()), 0, len(part)
