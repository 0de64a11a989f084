"""Runs of segments for parts in order: one segment each, or as many as a part must last."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.evidence.by_words import lower_quartile, ordered_peaks
from motiondb.records import MOTION_FPS, FloatArray, IntArray


def ordered_runs(
    values: FloatArray,
    starts: IntArray,
    ends: IntArray,
    seconds: FloatArray,
    apart: Sequence[bool],
) -> list[tuple[int, int]] | None:
    """One run of segments per part, each after the one before, of largest total value.

    Shapes: `values` (parts, segments); `starts`, `ends` (segments,); `seconds` (parts,).

    `apart`: Per part, whether it repeats the part before it: then a segment must lie between the
    two that is less than half as strong as the strongest of the capture (``gaps``).

    >>> starts = np.array([0, 30, 60])
    >>> ordered_runs(np.array([[0., 5, 1], [9, 1, 2]]), starts, starts + 30,
    ...              np.array([2.0, 0.0]), [False, False])
    [(0, 2), (2, 3)]
    >>> ordered_runs(np.array([[4., 0, 3]] * 2), starts, starts + 30, np.zeros(2), [False, True])
    [(0, 1), (2, 3)]
    """
    n_parts, n_segments = values.shape
    if not seconds.any() and not any(apart):
        peaks = ordered_peaks(values)
        return None if peaks is None else [(peak, peak + 1) for peak in peaks]
    best = np.full((n_parts + 1, n_segments + 1), -np.inf)
    best[0] = 0.0
    back = np.full(
        (n_parts + 1, n_segments + 1, 3), -1
    )  # run [a, b), and the end of the run before it
    for k in range(n_parts):
        behind, means = _runs(values[k], starts, ends, float(seconds[k]))
        latest = _latest_ends(gaps(values[k])) if apart[k] else np.arange(n_segments)
        for i in range(n_segments):  # the shortest run from i that is long enough
            b, before = int(behind[i]), int(latest[i])
            if b > n_segments or before < 0:
                continue
            if best[k, before] + means[i] > best[k + 1, b]:
                best[k + 1, b], back[k + 1, b] = best[k, before] + means[i], (i, b, before)
        for b in range(1, n_segments + 1):
            if best[k + 1, b - 1] >= best[k + 1, b]:
                best[k + 1, b], back[k + 1, b] = best[k + 1, b - 1], back[k + 1, b - 1]
    if np.isneginf(best[-1, -1]):
        return None
    runs, place = [], n_segments
    for k in range(n_parts, 0, -1):
        first, last, place = (int(n) for n in back[k, place])
        runs.append((first, last))
    return runs[::-1]


def gaps(values: FloatArray) -> NDArray[np.bool_]:
    """Segments (segments,) that are less than half as strong as the strongest of a capture.

    Strength is measured from the lower quartile; if the strongest is less than one nat above it,
    the evidence is the same throughout and there are no gaps (as in ``by_words.grow``).

    >>> gaps(np.array([4.0, 0.0, 3.0])).tolist()
    [False, True, False]
    """
    floor = lower_quartile(values)
    top = float(values.max())
    if top - floor < 1.0:
        return np.zeros(len(values), dtype=bool)
    weak: NDArray[np.bool_] = values < floor + 0.5 * (top - floor)
    return weak


def _latest_ends(weak: NDArray[np.bool_]) -> IntArray:
    """Per segment i the last end b of a run, such that a gap lies in [b, i); -1: there is none."""
    latest = np.full(len(weak), -1, dtype=np.int64)
    for i in range(1, len(weak)):
        latest[i] = i - 1 if weak[i - 1] else latest[i - 1]
    return latest


def _runs(
    values: FloatArray, starts: IntArray, ends: IntArray, seconds: float
) -> tuple[IntArray, FloatArray]:
    """Per segment, the end of the shortest run from it that lasts ``seconds``, and its mean value.

    If the capture is too short for a run, its end is the number of segments + 1.
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
