"""The extent of an activity: the interval of a take in which the activity of an example lasts.

Time warping finds where a take repeats an example frame by frame. If one performer repeats a
movement four times and another ten times, the answer should be the whole repetition. The context of
a frame is the mean and the standard deviation of the features over 2.6 s, on whitened principal
axes of all captures' contexts. With d_t the mean distance of a take's frame to the five nearest
contexts of the example, the interval [a, b) maximises

    sum_{t in [a, b)} (theta - d_t),    theta = near + SHARE (median of d - near),

with near the least mean of d over two seconds. It is found exactly in one pass over prefix sums. A
take that shows the activity throughout has no background to compare with; it is returned as a whole
only if this maximises the sum.

Window and threshold were chosen among 27 settings with the four long CMU takes in view, on which
``docs/measured/quality.md`` measures ("Interval in a long take"): no other takes with true parts
are available.

An occurrence of an event (:mod:`motiondb.meaning.occurrences`) is *whole* with what leads to it and
what follows it, such as the crouch before a flight and after the landing: from a frame of rest to
the next one (:func:`whole_occurrences`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np

from motiondb.body.contacts import MAX_HEIGHT
from motiondb.meaning.occurrences import FLIGHTS, LASTING, OVER, find_occurrences
from motiondb.meaning.postures import INVERTED, LEANS, LOW
from motiondb.meaning.score_vectors import running_median
from motiondb.records import MOTION_FPS, Axes, Float32Array, FloatArray, IntArray

WINDOW = 39  # Feature frames (2.6 s) of a context
SPREAD_WEIGHT = 1.5  # Weight of the standard deviations relative to the means
N_AXES = 24  # Principal axes that are kept
THINNED = 5  # Every fifth frame is used to compute the axes, since neighbours hardly differ
SHARE = 0.35  # Place of the threshold between ``near`` and the median of d
NEAREST = 5  # Number of nearest contexts of the example
SHORTEST = 22  # Least length of an activity, feature frames (1.5 s)
NEAR_FRAMES = 30  # Feature frames (2 s) over which ``near`` is averaged
LEAST_EXAMPLE = 30  # Least length of an example with contexts of its own, feature frames (2 s)
LONG = 1.5
"""Least length of a take that is searched for whole activities, relative to that of the example."""
UPRIGHT = 0.9  # Quantile of the heights of the pelvis that is taken for standing
REST_WITHIN = 45  # Frames (1.5 s) before and after an occurrence in which the body comes to rest
LEAD = 3  # Frames (0.1 s) of the rest that belong to a whole occurrence
SINKING, SAGGED, RETURNED = 0.15, 0.05, 0.25
"""Speed of the pelvis up or down, m/s, height that it lost, m, and share of an excursion, up to
which a body is at rest."""
AROUND = 24  # Frames (0.8 s) before and after a punch: arms are at rest where feet may not be


@dataclass(frozen=True, eq=False)
class ContextSpace:
    """A whitening projection of contexts."""

    features: Annotated[FloatArray, Axes("features")]  # Mean of the features
    mean: Annotated[FloatArray, Axes("contexts")]  # Mean of their contexts; 2 a feature
    # Principal axes as columns, each divided by the standard deviation along it
    projection: Annotated[FloatArray, Axes("contexts", None)]

    def view(self, features: FloatArray | Float32Array) -> FloatArray:
        """Contexts (frames, axes) of features (frames, n), 15 a second."""
        return (_contexts(features - self.features) - self.mean) @ self.projection


def fit_context_space(captures: Iterable[FloatArray | Float32Array]) -> ContextSpace:
    """Whitened principal axes of the contexts of all captures; `captures` each (frames, n).

    They are gone through more than once.
    """
    total, centre = 0, np.zeros(())
    for c in captures:
        total, centre = total + len(c), centre + c.sum(axis=0, dtype=np.float64)
    centre = centre / max(total, 1)
    n_rows, sums, products = 0, np.zeros(()), np.zeros(())
    for c in captures:
        rows = _contexts(c - centre)[::THINNED]
        n_rows, sums = n_rows + len(rows), sums + rows.sum(axis=0)
        products = products + rows.T @ rows
    mean = sums / n_rows
    values, axes = np.linalg.eigh(products / n_rows - np.outer(mean, mean))
    kept = np.argsort(-values)[:N_AXES]
    spread = np.sqrt(np.maximum(values[kept], 1e-6 * values.max() + 1e-12))
    return ContextSpace(np.asarray(centre), mean, axes[:, kept] / spread)


def extent(example: FloatArray, take: FloatArray) -> tuple[float, int, int]:
    """Interval of a take in which the activity of an example lasts.

    Shapes: `example`, `take` (frames, axes).
    """
    margin = min(WINDOW // 4, (len(example) - 1) // 2)
    inner = example[margin : len(example) - margin]
    squares = np.sum(take**2, axis=1)[:, None] + np.sum(inner**2, axis=1) - 2.0 * (take @ inner.T)
    nearest = min(NEAREST, len(inner))
    closest = np.partition(np.maximum(squares, 0.0), nearest - 1, axis=1)[:, :nearest]
    distance = np.sqrt(closest).mean(axis=1)
    start, end = 0, len(take)
    if len(take) > SHORTEST:
        ((start, end),) = best_spans((_threshold(distance) - distance)[None], SHORTEST)
    return float(distance[start:end].mean()), start, end


def best_spans(values: FloatArray, shortest: int) -> list[tuple[int, int]]:
    """One interval for each row, each behind the one before, of the largest sum of values.

    Each has ``shortest`` frames at least, for which there must be room. Of equal ones, the first.

    Shapes: `values` (actions, frames).

    >>> best_spans(np.array([[-1.0, 2.0, -0.5, 2.0, -3.0, 3.0]]), 2)
    [(1, 4)]
    """
    n_actions, n = values.shape
    best = np.zeros(n + 1)  # of the actions so far, within the first frames
    starts, ends = [], []
    for k in range(n_actions):
        sums = np.concatenate([[0.0], np.cumsum(values[k])])
        gain, start = _running_best(best - sums)
        total = np.full(n + 1, -np.inf)
        total[shortest:] = gain[:-shortest] + sums[shortest:]
        best, end = _running_best(total)
        starts.append(start)
        ends.append(end)
    spans, limit = [], n
    for start, end in zip(reversed(starts), reversed(ends)):
        stop = int(end[limit])
        limit = int(start[stop - shortest])
        spans.append((limit, stop))
    return spans[::-1]


def _running_best(values: FloatArray) -> tuple[FloatArray, IntArray]:
    """The largest value so far, and the first place that has it."""
    best = np.maximum.accumulate(values)
    is_new = np.append(True, values[1:] > best[:-1])
    return best, np.maximum.accumulate(np.where(is_new, np.arange(len(values)), 0))


def _threshold(distance: FloatArray) -> float:
    length = min(NEAR_FRAMES, len(distance))
    near = np.convolve(distance, np.full(length, 1.0 / length), "valid").min()
    return float(near + SHARE * (np.median(distance) - near))


def _contexts(features: FloatArray | Float32Array) -> FloatArray:
    from motiondb.symbols.segmentation import context  # compiled code

    values = context(np.asarray(features, dtype=np.float64), WINDOW)
    values[:, features.shape[1] :] *= SPREAD_WEIGHT
    return values


def whole_occurrences(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """First frame and last frame + 1 of each occurrence with what leads to it and follows it.

    Each begins and ends at rest, or where the body is calmest within ``REST_WITHIN`` frames; those
    that follow one another closely meet in between.

    >>> track = np.zeros((90, 6)); track[:, 0] = 0.9
    >>> track[30:40, 0], track[40:50, 0:6] = 0.7, 1.1  # a crouch, then a flight
    >>> whole_occurrences(track, "jump")
    [(25, 55)]
    """
    found = find_occurrences(track, word)
    if not found:
        return []
    meeting = [(one[1] + after[0]) // 2 for one, after in pairwise(found)]
    unrest = np.zeros(0) if word == "punch" else _unrest(track, word)
    whole = []
    for n, (start, end) in enumerate(found):
        low = max(start - REST_WITHIN, meeting[n - 1] if n else 0)
        high = min(end + REST_WITHIN, meeting[n] if n < len(meeting) else len(track))
        if word == "punch":
            whole.append((max(start - AROUND, low), min(end + AROUND, high)))
        else:
            first = start - _until_rest(unrest[low:start][::-1])
            whole.append((max(first, low), min(end + _until_rest(unrest[end:high]), high)))
    return whole


def _until_rest(unrest: FloatArray) -> int:
    """Frames until the body is at rest, with ``LEAD`` frames of it; until it is calmest, if never.

    >>> _until_rest(np.array([3.0, 2.0, 0.5, 0.0, 0.0])), _until_rest(np.array([3.0, 2.0, 4.0]))
    (6, 2)
    """
    if not len(unrest):
        return 0
    calm = np.flatnonzero(unrest <= 1.0)
    return int(calm[0]) + 1 + LEAD if len(calm) else int(np.argmin(unrest)) + 1


def _unrest(track: FloatArray, word: str) -> FloatArray:
    """How far from rest a body is: array (frames,), up to 1 at rest."""
    heights = track[:, 0]
    feet = track[:, 4:6].max(axis=1) if word == "kick" else track[:, 4:6].min(axis=1)
    parts = [np.abs(np.gradient(heights)) * MOTION_FPS / SINKING, feet / MAX_HEIGHT]
    if word in (*OVER, *LEANS):
        parts.append(track[:, 14] / (RETURNED * LEANS.get(word, INVERTED)))
    elif word in LOW:
        parts.append((np.quantile(heights, UPRIGHT) - heights) / (RETURNED * LOW[word]))
    elif word in FLIGHTS:
        sagged = running_median(heights, 2 * LASTING - 1) - heights
        parts.append(sagged / SAGGED)
    return np.asarray(np.max(parts, axis=0))
