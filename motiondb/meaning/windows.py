"""Windows of captures compared with an example, without the vector of any window.

Notation: z_s the standardised row of segment s (:mod:`motiondb.meaning.score_vectors`), z'_s its
columns that are neither posture nor travel, f_s the frames of the segment inside a window, q the
vector of the example, W the weights and c the offsets of the words
(:mod:`motiondb.meaning.resemblance`). The vector of the window is v = sum_s f_s z_s, scaled to
length 1. Therefore

    cosine    v . q / |v| = sum_s f_s (z_s . q) / |v|,    |v|^2 = sum_s sum_t f_s f_t (z_s . z_t),
    evidence  W' v / |v| + c = sum_s f_s (W' z_s) / |v| + c,

and the cosine of v' and q' in the same way. The products z_s . z_t of neighbours and the W' z_s are
the same for every example, and computed once. An example then needs one pass over the rows. Long
windows hold too many pairs: their v are differences of sums from the begin of the capture.

The rows and their products with q and W are in single precision, which halves what the pass reads,
most of its time. Let S = sum_s f_s |z_s|. Cosines then differ from those of rows in
double precision by some 1e-7 S / |v|, and so does the evidence. Where segments cancel, so that |v|
is far below S, the formulas lose digits, and v is computed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motiondb.meaning.alignment import Aligned
from motiondb.meaning.resemblance import MeaningSpace
from motiondb.meaning.score_vectors import VECTORS_AT_ONCE, Rows, in_memory, times, unit
from motiondb.records import Float32Array, FloatArray, IntArray

_SHORTEST = 64  # Feature frames (4 s) of the shortest windows that products are computed for
_LONGEST = 256  # Feature frames (17 s) of the longest: longer ones hold too many pairs of segments
_CANCELLED = 0.1  # |v| / S below which v is computed; by hand
_CANCELLED_SUMS = 1e-8  # The same for differences of sums from the begin of a capture, and its S


@dataclass(frozen=True, eq=False)
class ComparedSegments:
    """The segments of all captures, capture after capture, as examples are compared with them."""

    frames: IntArray  # (segments, 2): first feature frame of each, and one past its last
    symbols: IntArray  # (segments,): their symbols
    rows: Float32Array  # (segments, columns): standardised scores and movement, z
    n_moving: int  # Number of the first columns that are neither posture nor travel
    norms: FloatArray  # (segments,): |z|
    weights: Float32Array  # (columns, words): W; no columns without words
    evidence: Float32Array  # (segments, words): evidence for words without offsets, W' z
    # The products that were computed last. Two threads may compute the same ones.
    _kept: dict[int, tuple[IntArray, FloatArray]] = field(default_factory=dict)

    def neighbours(self, length: int) -> tuple[IntArray, FloatArray]:
        """Products of the segments that a window of some length can hold together.

        Those of segments s and s + k, z . z and z' . z', are row offsets[s] + k of (pairs, 2).
        """
        longest = _SHORTEST
        while longest < length:
            longest *= 2
        table = self._kept.get(longest)
        if table is None:
            table = _neighbours(self.frames, self.rows, self.n_moving, longest)
            self._kept.clear()
            self._kept[longest] = table
        return table

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
    norms = np.sqrt(np.einsum("ij,ij->i", single, single, dtype=np.float64))
    n_moving, weights = rows.shape[1], np.zeros((rows.shape[1], 0), dtype=np.float32)
    if space is not None:
        n_moving, weights = space.n_moving, space.weights.astype(np.float32, copy=False)
    evidence = times(single, weights, VECTORS_AT_ONCE)
    return ComparedSegments(frames, symbols, single, n_moving, norms, weights, evidence)


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
    whole, moving = vector.astype(np.float64), vector[: segments.n_moving].astype(np.float64)
    edges, places = _all_places(bounds, segments.frames, length)
    if length > _LONGEST:
        sums = _from_begin(edges, places, segments.frames, segments.rows, whole)
    else:
        asked, n = vector.astype(np.float32), segments.n_moving
        of_segments = row_products(segments.rows[:, :n], asked[:n])
        products = of_segments + row_products(segments.rows[:, n:], asked[n:])
        sums = _by_products(segments, places, products, length, whole)
    cosine = sums[:, 0] / sums[:, 1]
    rough = 0.5 * cosine + 0.5 * _shares_aligned(aligned, bounds, segments.frames, edges, places)
    best = _first_of_largest(edges, rough)
    of_best = places[best]
    evidence = _evidence(segments, of_best, sums[best, 1])
    if length > _LONGEST:
        sums = _directly(of_best, segments.frames, segments.rows, moving)
    else:
        sums = _by_products(segments, of_best, of_segments, length, moving)
    norm = float(np.linalg.norm(moving))
    of_moving = sums[:, 0] / (sums[:, 1] * (norm if norm > 0.0 else 1.0))
    return Windows(edges, places, rough, best, cosine[best], of_moving, evidence)


def row_products(rows: NDArray[Any], vector: NDArray[Any]) -> NDArray[Any]:
    """Products of rows with a vector: array (n,).

    Equal rows have equal products. Those of ``rows @ vector`` can differ in their last bits, so
    that a copy of a capture would come before it.

    Shapes: `rows` (n, columns); `vector` (columns,).
    """
    return np.asarray(np.einsum("ij,j->i", rows, vector))


def _by_products(
    segments: ComparedSegments,
    places: IntArray,
    products: Float32Array,
    length: int,
    vector: FloatArray,
) -> FloatArray:
    """As :func:`_directly`, by products (segments,) of z and q; windows of a length or shorter."""
    offsets, pairs = segments.neighbours(length)
    column = 0 if len(vector) == segments.rows.shape[1] else 1
    frames, rows, norms = segments.frames, segments.rows, segments.norms
    return _by_neighbours(places, frames, rows, norms, products, offsets, pairs[:, column], vector)


def _evidence(segments: ComparedSegments, places: IntArray, lengths: FloatArray) -> Float32Array:
    """Evidence for words in windows, without offsets: array (windows, words).

    Shapes: `places` (windows, 4); `lengths` (windows,): |v|.
    """
    evidence = _sums(places, segments.frames, segments.evidence)
    evidence /= lengths[:, np.newaxis]
    scales = _scales(places, segments.frames, segments.norms)
    cancelled = np.flatnonzero(lengths < _CANCELLED * scales)
    evidence[cancelled] = times(segments.vectors(places[cancelled]), segments.weights)
    return evidence


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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _by_neighbours(
    places: IntArray,
    frames: IntArray,
    rows: Float32Array,
    norms: FloatArray,
    products: Float32Array,
    offsets: IntArray,
    pairs: FloatArray,
    vector: FloatArray,
) -> FloatArray:
    """As :func:`_directly`, by products of neighbours where segments do not cancel.

    Shapes: `norms` (segments,): |z|; `products` (segments,): z . q; `offsets` (segments + 1,) and
    `pairs` (pairs,): products of neighbours.
    """
    sums = np.empty((len(places), 2))
    inside = np.empty((places[:, 3] - places[:, 2]).max() if len(places) else 0)
    for w in range(len(places)):
        low, high, a, b = places[w]
        product = square = scale = 0.0
        for s in range(a, b):
            inside[s - a] = min(frames[s, 1], high) - max(frames[s, 0], low)
            product += inside[s - a] * products[s]
            scale += inside[s - a] * norms[s]
        for s in range(a, b):
            square += inside[s - a] * inside[s - a] * pairs[offsets[s]]
            for t in range(s + 1, b):
                square += 2.0 * inside[s - a] * inside[t - a] * pairs[offsets[s] + t - s]
        if square > (_CANCELLED * scale) ** 2:
            sums[w] = product, np.sqrt(square)
        else:
            sums[w] = _directly(places[w : w + 1], frames, rows, vector)[0]
    return sums


@njit(cache=True, nogil=True)
def _from_begin(
    edges: IntArray, places: IntArray, frames: IntArray, rows: Float32Array, vector: FloatArray
) -> FloatArray:
    """As :func:`_directly`, by sums from the begin of each capture to each of its segments.

    Shapes: `edges` (captures + 1,): the first window of every capture. The time does not depend on
    the number of segments of a window.
    """
    sums = np.empty((len(places), 2))
    for capture in range(len(edges) - 1):
        windows = places[edges[capture] : edges[capture + 1]]
        first, last = windows[0, 2], windows[-1, 3]
        before, scale = np.zeros((last - first + 1, rows.shape[1])), 0.0
        for s in range(first, last):
            n_frames = float(frames[s, 1] - frames[s, 0])
            before[s - first + 1] = before[s - first] + n_frames * rows[s]
            scale += n_frames * np.sqrt(_dot(rows[s], rows[s]))
        for w in range(len(windows)):
            low, high, a, b = windows[w]
            v = before[b - first] - before[a - first]
            v -= float(max(low - frames[a, 0], 0)) * rows[a]
            v -= float(max(frames[b - 1, 1] - high, 0)) * rows[b - 1]
            length = np.sqrt(_dot(v, v))
            if length > _CANCELLED_SUMS * scale:
                sums[edges[capture] + w] = _dot(v, vector), length
            else:
                sums[edges[capture] + w] = _directly(windows[w : w + 1], frames, rows, vector)[0]
    return sums


@njit(cache=True, nogil=True)
def _directly(
    places: IntArray, frames: IntArray, rows: Float32Array, vector: FloatArray
) -> FloatArray:
    """Products v . q of windows, and lengths of v, 1 in place of 0: array (windows, 2).

    Shapes: `places` (windows, 4); `frames` (segments, 2); `rows` (segments, columns); `vector`
    (n,): q, or the first n numbers of it, with which those of v are compared.
    """
    sums, v = np.empty((len(places), 2)), np.empty(len(vector))
    for w in range(len(places)):
        _sum(places[w], frames, rows, v)
        length = np.sqrt(_dot(v, v))
        sums[w] = _dot(v, vector), length if length > 0.0 else 1.0
    return sums


@njit(cache=True, nogil=True)
def _sum(place: IntArray, frames: IntArray, rows: Float32Array, v: FloatArray) -> None:
    """Write the sum over segments of their frames inside a window times their rows to `v`."""
    low, high, a, b = place
    v[:] = 0.0
    for s in range(a, b):
        inside = float(min(frames[s, 1], high) - max(frames[s, 0], low))
        for i in range(len(v)):
            v[i] += inside * rows[s, i]


@njit(cache=True, nogil=True)
def _sums(places: IntArray, frames: IntArray, rows: Float32Array) -> Float32Array:
    """Sums over segments of their frames inside windows times their rows: (windows, columns)."""
    sums, v = np.empty((len(places), rows.shape[1]), np.float32), np.empty(rows.shape[1])
    for w in range(len(places)):
        _sum(places[w], frames, rows, v)
        sums[w] = v
    return sums


@njit(cache=True, nogil=True)
def _scales(places: IntArray, frames: IntArray, norms: FloatArray) -> FloatArray:
    """S of windows: array (windows,)."""
    scales = np.zeros(len(places))
    for w in range(len(places)):
        low, high, a, b = places[w]
        for s in range(a, b):
            scales[w] += norms[s] * (min(frames[s, 1], high) - max(frames[s, 0], low))
    return scales


@njit(cache=True, nogil=True)
def _first_of_largest(edges: IntArray, values: FloatArray) -> IntArray:
    """Number of the first of the largest values of every capture: array (captures,)."""
    best = edges[:-1].copy()
    for capture in range(len(best)):
        for w in range(edges[capture], edges[capture + 1]):
            if values[w] > values[best[capture]]:
                best[capture] = w
    return best


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _dot(one: Float32Array | FloatArray, other: Float32Array | FloatArray) -> float:
    """Dot product in eight sums of double precision: the same on every processor."""
    a = b = c = d = e = f = g = h = 0.0
    n = len(one)
    last = n - n % 8
    for i in range(0, last, 8):
        a += np.float64(one[i]) * np.float64(other[i])
        b += np.float64(one[i + 1]) * np.float64(other[i + 1])
        c += np.float64(one[i + 2]) * np.float64(other[i + 2])
        d += np.float64(one[i + 3]) * np.float64(other[i + 3])
        e += np.float64(one[i + 4]) * np.float64(other[i + 4])
        f += np.float64(one[i + 5]) * np.float64(other[i + 5])
        g += np.float64(one[i + 6]) * np.float64(other[i + 6])
        h += np.float64(one[i + 7]) * np.float64(other[i + 7])
    for i in range(last, n):
        a += np.float64(one[i]) * np.float64(other[i])
    return ((a + b) + (c + d)) + ((e + f) + (g + h))
