"""Distance between two segments: poses matched by uniform time warping.

Frame m of the longer segment (l frames) is matched with frame floor(m l' / l) of the shorter (l'
frames), m = 0 .. l - 1, and

    D(s, s') = (1 / l) sum_m d(x_{s + m}, x_{s' + floor(m l' / l)}).

D is symmetric. It is 0 between a segment and itself, and between a segment and itself slowed down
by a whole number. The distances d are computed where they are needed; no table of all pairs of
frames is made.

Source: Park, Lee and Lee (2011), equation 1. In print m counts from 1, which would skip the first
frame and step over the last.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray

_PARTS = 4  # Parts into which a table is divided for two threads, so that both have work to the end


@njit(cache=True, fastmath=True, inline="always")
def _pose_distance(values: Float32Array, t: int, u: int) -> np.float32:
    """Return d of two frames."""
    square = np.float32(0.0)
    for d in range(values.shape[1]):
        gap = values[t, d] - values[u, d]
        square += gap * gap
    return np.sqrt(square)


@njit(cache=True, fastmath=True, nogil=True)
def segment_distance(values: Float32Array, a: int, b: int, a2: int, b2: int) -> float:
    """Return D of the segments [a, b) and [a2, b2), in the unit of d.

    Parameters
    ----------
    values : array (frames, dimensions), float32
        Poses, :attr:`motiondb.grammar.terminals.pose_distance.Poses.values`.
    a : int
        First frame of the first segment.
    b : int
        Frame after the last of the first segment.
    a2 : int
        First frame of the second segment.
    b2 : int
        Frame after the last of the second segment.
    """
    if b - a < b2 - a2:
        a, b, a2, b2 = a2, b2, a, b
    length, shorter = b - a, b2 - a2
    total = 0.0
    for m in range(length):
        total += float(_pose_distance(values, a + m, a2 + m * shorter // length))
    return total / length


def segment_distances(values: Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Return D between all segments: array (segments, segments), symmetric, 0 on the diagonal."""
    table = np.zeros((len(starts), len(starts)))

    def fill(part: int) -> None:
        _fill_rows(values, starts, ends, part, _PARTS, table)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(fill, range(_PARTS)))
    return table + table.T


@njit(cache=True, nogil=True)
def _fill_rows(
    values: Float32Array,
    starts: IntArray,
    ends: IntArray,
    part: int,
    n_parts: int,
    table: FloatArray,
) -> None:
    """Fill every n_parts-th row below the diagonal."""
    for i in range(part, len(starts), n_parts):
        for j in range(i):
            table[i, j] = segment_distance(values, starts[i], ends[i], starts[j], ends[j])


@njit(cache=True)
def distances_to(
    values: Float32Array, a: int, b: int, starts: IntArray, ends: IntArray
) -> FloatArray:
    """Return D of the segment [a, b) to every given segment: array (segments,)."""
    distances = np.empty(len(starts))
    for i in range(len(starts)):
        distances[i] = segment_distance(values, a, b, starts[i], ends[i])
    return distances
