"""Windows of captures compared with an example, without the vector of any window.

Notation: z_s the standardised row of segment s (:mod:`motiondb.meaning.score_vectors`), z'_s its
columns that are neither posture nor travel, f_s the frames of the segment inside a window, q the
vector of the example, W the weights and c the offsets of the words
(:mod:`motiondb.meaning.resemblance`). The vector of the window is v = sum_s f_s z_s, scaled to
length 1. Therefore

    cosine    v . q / |v| = sum_s f_s (z_s . q) / |v|,    |v|^2 = sum_s sum_t f_s f_t (z_s . z_t),
    evidence  W' v / |v| + c = sum_s f_s (W' z_s) / |v| + c,

and the cosine of v' and q' in the same way. The products z_s . z_t of neighbours and the W' z_s are
the same for every example, and computed once. An example then needs one pass over the rows.

The rows are in single precision, which halves what the pass reads, most of its time. Cosines then
differ from those in double precision by some 1e-7.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit

from motiondb.meaning.alignment import Aligned
from motiondb.meaning.resemblance import MeaningSpace
from motiondb.meaning.score_vectors import Rows, in_memory, unit
from motiondb.records import Float32Array, FloatArray, IntArray

_SHORTEST = 64  # Feature frames (4 s) of the shortest windows that products are computed for


@dataclass(frozen=True, eq=False)
class ComparedSegments:
    """The segments of all captures, capture after capture, as examples are compared with them."""

    frames: IntArray  # (segments, 2): first feature frame of each, and one past its last
    symbols: IntArray  # (segments,): their symbols
    rows: Float32Array  # (segments, columns): standardised scores and movement, z
    n_moving: int  # Number of the first columns that are neither posture nor travel
    # (segments, words): evidence for words without offsets, W' z; no columns without words
    evidence: Float32Array
    _kept: dict[int, tuple[IntArray, FloatArray]] = field(default_factory=dict)

    def neighbours(self, length: int) -> tuple[IntArray, FloatArray]:
        """Products of the segments that a window of some length can hold together.

        Those of segments s and s + k, z . z and z' . z', are row offsets[s] + k of (pairs, 2).
        """
        longest = _SHORTEST
        while longest < length:
            longest *= 2
        if longest not in self._kept:
            self._kept[longest] = _neighbours(self.frames, self.rows, self.n_moving, longest)
        return self._kept[longest]

    def vectors(self, places: IntArray) -> Float32Array:
        """Vectors of length 1 of some windows (windows, columns); `places` (windows, 4)."""
        return unit(_sums(places, self.frames, self.rows))


def compared_segments(
    frames: IntArray, symbols: IntArray, rows: Rows, space: MeaningSpace | None
) -> ComparedSegments:
    """Prepare segments for examples.

    Shapes: `frames` (segments, 2); `symbols` (segments,); `rows` (segments, columns).

    `space`: What the words are compared by; None if there are none.
    """
    single = in_memory(rows, np.float32)
    if space is None:
        none = np.zeros((len(single), 0), dtype=np.float32)
        return ComparedSegments(frames, symbols, single, rows.shape[1], none)
    evidence = single @ space.weights.astype(np.float32, copy=False)
    return ComparedSegments(frames, symbols, single, space.n_moving, evidence)


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of captures with their scores, and the best one of each capture."""

    edges: IntArray  # (captures + 1,): first window of each capture, and their number
    # (windows, 4): first feature frame and one past the last, first segment and one past the last
    places: IntArray
    rough: FloatArray  # (windows,): (cosine + alignment times the share that it covers) / 2
    best: IntArray  # (captures,): number of the window of largest ``rough``
    cosine: FloatArray  # (captures,): of its vector with the example's
    moving: FloatArray  # (captures,): the same without posture and travel
    evidence: Float32Array  # (captures, words): its evidence, without offsets


def score_windows(
    segments: ComparedSegments, bounds: IntArray, vector: FloatArray, aligned: Aligned, length: int
) -> Windows:
    """Score the windows of some captures by their vectors and by the alignment of symbols.

    Shapes: `bounds` (captures, 2): first segment of each, and one past its last; `vector`
    (columns,): the example's.

    `aligned`: The captures, with the example. `length`: That of the windows, feature frames.
    """
    frames, n = segments.frames, segments.n_moving
    asked = vector.astype(np.float32)
    offsets, pairs = segments.neighbours(length)
    moving = segments.rows[:, :n] @ asked[:n]
    both = moving + segments.rows[:, n:] @ asked[n:]
    edges, places = _all_places(bounds, frames, length)
    products, lengths = _products_and_lengths(places, frames, both, offsets, pairs[:, 0])
    cosine = products / lengths
    rough = 0.5 * cosine + 0.5 * _shares_aligned(aligned, bounds, frames, edges, places)
    best = _first_of_largest(edges, rough)
    of_best = places[best]
    products, of_moving = _products_and_lengths(of_best, frames, moving, offsets, pairs[:, 1])
    whole = float(np.linalg.norm(asked[:n]))
    evidence = _sums(of_best, frames, segments.evidence)
    evidence /= lengths[best, np.newaxis]
    products /= of_moving * (whole if whole > 0.0 else 1.0)
    return Windows(edges, places, rough, best, cosine[best], products, evidence)


def _shares_aligned(
    aligned: Aligned, bounds: IntArray, frames: IntArray, edges: IntArray, places: IntArray
) -> FloatArray:
    """Alignment of the capture times the share of it that a window covers: array (windows,)."""
    owner = np.repeat(np.arange(len(bounds)), np.diff(edges))
    start = frames[bounds[:, 0] + aligned.first, 0][owner]
    end = frames[bounds[:, 0] + np.maximum(aligned.last, 1) - 1, 1][owner]
    low, high = places[:, 0], places[:, 1]
    shared = np.maximum(np.minimum(high, end) - np.maximum(low, start), 0)
    return aligned.score[owner] * shared / np.maximum(np.minimum(high - low, end - start), 1)


def window_places(starts: IntArray, ends: IntArray, length: int) -> tuple[IntArray, IntArray]:
    """First frame, and one past the last, of windows that begin or end with segments.

    Shapes: `starts`, `ends` (segments,).

    >>> [place.tolist() for place in window_places(np.array([0, 10]), np.array([10, 30]), 12)]
    [[0, 10, 18], [12, 22, 30]]
    """
    frames = np.stack([starts, ends], axis=1).astype(np.int64)
    _, places = _all_places(np.array([[0, len(frames)]]), frames, length)
    return places[:, 0], places[:, 1]


@njit(cache=True)
def _all_places(bounds: IntArray, frames: IntArray, length: int) -> tuple[IntArray, IntArray]:
    """First window of every capture (captures + 1,), and the windows (windows, 4)."""
    edges = np.zeros(len(bounds) + 1, np.int64)
    places = np.empty((2 * (bounds[:, 1] - bounds[:, 0]).sum(), 4), np.int64)
    n = 0
    for capture in range(len(bounds)):
        first, last = bounds[capture]
        total = frames[last - 1, 1]
        begin, end = first, first  # segments of a window
        starting, ending = first, first  # segments with which the next window may start or end
        low = -1
        while low < max(total - length, 0) and ending < last:
            before = low
            at_end = max(frames[ending, 1] - length, 0)
            if starting < last and frames[starting, 0] <= at_end:
                low = frames[starting, 0]
                starting += 1
            else:
                low = at_end
                ending += 1
            low = min(low, max(total - length, 0))
            if low == before:
                continue
            high = min(low + length, total)
            while frames[begin, 1] <= low:
                begin += 1
            while end < last and frames[end, 0] < high:
                end += 1
            places[n] = low, high, begin, end
            n += 1
        edges[capture + 1] = n
    return edges, places[:n].copy()


@njit(cache=True)
def _products_and_lengths(
    places: IntArray, frames: IntArray, products: Float32Array, offsets: IntArray, pairs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Products v . q of windows, and lengths of v, 1 in place of 0; see the module.

    Shapes: `places` (windows, 4); `frames` (segments, 2); `products` (segments,): z . q; `offsets`
    (segments,) and `pairs` (pairs,): products of neighbours.
    """
    sums, lengths = np.zeros(len(places)), np.ones(len(places))
    inside = np.empty((places[:, 3] - places[:, 2]).max() if len(places) else 0)
    for w in range(len(places)):
        low, high, a, b = places[w]
        square = 0.0
        for s in range(a, b):
            inside[s - a] = min(frames[s, 1], high) - max(frames[s, 0], low)
            sums[w] += inside[s - a] * products[s]
        for s in range(a, b):
            square += inside[s - a] * inside[s - a] * pairs[offsets[s]]
            for t in range(s + 1, b):
                square += 2.0 * inside[s - a] * inside[t - a] * pairs[offsets[s] + t - s]
        if square > 0.0:
            lengths[w] = np.sqrt(square)
    return sums, lengths


@njit(cache=True)
def _sums(places: IntArray, frames: IntArray, rows: Float32Array) -> Float32Array:
    """Sums over segments of their frames inside windows times their rows: (windows, columns)."""
    sums = np.zeros((len(places), rows.shape[1]), np.float32)
    for w in range(len(places)):
        low, high, a, b = places[w]
        for s in range(a, b):
            inside = np.float32(min(frames[s, 1], high) - max(frames[s, 0], low))
            sums[w] += inside * rows[s]
    return sums


@njit(cache=True)
def _first_of_largest(edges: IntArray, values: FloatArray) -> IntArray:
    """Number of the first of the largest values of every capture: array (captures,)."""
    best = edges[:-1].copy()
    for capture in range(len(best)):
        for w in range(edges[capture], edges[capture + 1]):
            if values[w] > values[best[capture]]:
                best[capture] = w
    return best


@njit(cache=True)
def _neighbours(
    frames: IntArray, rows: Float32Array, n_moving: int, length: int
) -> tuple[IntArray, FloatArray]:
    """As :meth:`ComparedSegments.neighbours`, for windows of this length or shorter."""
    n = len(frames)
    offsets = np.zeros(n + 1, np.int64)
    for s in range(n):
        t = s + 1
        while t < n and frames[s, 0] < frames[t, 0] < frames[s, 1] + length:
            t += 1  # in the same capture, since the next one begins at frame 0
        offsets[s + 1] = offsets[s] + t - s
    pairs = np.empty((offsets[n], 2))
    for s in range(n):
        for k in range(offsets[s + 1] - offsets[s]):
            one, other = rows[s], rows[s + k]
            moving = _dot(one[:n_moving], other[:n_moving])
            pairs[offsets[s] + k] = moving + _dot(one[n_moving:], other[n_moving:]), moving
    return offsets, pairs


@njit(cache=True)
def _dot(one: Float32Array, other: Float32Array) -> float:
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
