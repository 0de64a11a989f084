"""Runs of segments for parts in order: one segment each, or as many as a part must last."""

from __future__ import annotations

import numpy as np

from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.search.by_words import ordered_peaks


def ordered_runs(
    values: FloatArray, starts: IntArray, ends: IntArray, seconds: FloatArray
) -> list[tuple[int, int]] | None:
    """One run of segments per part, each after the one before, of largest total value.

    Parameters
    ----------
    values : array (parts, segments)
    starts, ends : array (segments,)
        Frames.
    seconds : array (parts,)
        Least length of every part; the value of a run is the mean of its segments' weighted by
        frames, and a part without a least length is one segment.

    Returns
    -------
    runs : list of (int, int) or None
        Segments [a, b); None where the capture is too short.

    >>> ordered_runs(np.array([[0., 5, 1], [9, 1, 2]]), np.array([0, 30, 60]),
    ...              np.array([30, 60, 90]), np.array([2.0, 0.0]))
    [(0, 2), (2, 3)]
    """
    n_parts, n_segments = values.shape
    if not seconds.any():
        peaks = ordered_peaks(values)
        return None if peaks is None else [(peak, peak + 1) for peak in peaks]
    best = np.full((n_parts + 1, n_segments + 1), -np.inf)
    best[0] = 0.0
    back = np.full((n_parts + 1, n_segments + 1, 2), -1)
    for k in range(n_parts):
        behind, means = _runs(values[k], starts, ends, float(seconds[k]))
        for i in range(n_segments):  # the shortest run from i that lasts
            if behind[i] <= n_segments and best[k, i] + means[i] > best[k + 1, behind[i]]:
                best[k + 1, behind[i]] = best[k, i] + means[i]
                back[k + 1, behind[i]] = (i, behind[i])
        for b in range(1, n_segments + 1):
            if best[k + 1, b - 1] >= best[k + 1, b]:
                best[k + 1, b], back[k + 1, b] = best[k + 1, b - 1], back[k + 1, b - 1]
    if np.isneginf(best[-1, -1]):
        return None
    runs, place = [], n_segments
    for k in range(n_parts, 0, -1):
        first, last = (int(n) for n in back[k, place])
        runs.append((first, last))
        place = first
    return runs[::-1]


def _runs(
    values: FloatArray, starts: IntArray, ends: IntArray, seconds: float
) -> tuple[IntArray, FloatArray]:
    """Per segment, where the shortest run from it that lasts ends, and the run's mean value.

    A run that the capture is too short for ends behind the last segment + 1.
    """
    frames = (ends - starts).astype(np.float64)
    before = np.concatenate([[0.0], np.cumsum(frames)])
    weighted = np.concatenate([[0.0], np.cumsum(frames * values)])
    n = len(values)
    needed = np.maximum(before[:-1] + seconds * MOTION_FPS - 1e-6, before[1:] - 0.5)
    behind = np.searchsorted(before, needed, side="left")
    last = np.minimum(behind, n)
    means = (weighted[last] - weighted[:-1]) / np.maximum(before[last] - before[:-1], 1.0)
    return behind.astype(np.int64), means
