"""Search by words: intervals of captures that show the actions of a query.

The word map gives the log-odds of each word in a window around each segment of a capture. An
*action* is one or more words about the same interval ("turn left"); its value in a window is the
mean of its words' log-odds. Actions of a query must occur in its order: a dynamic program selects
one segment for every action, each after the one before, with the largest total. The interval of an
action is this segment, the peak, with its neighbours for as long as their value is at least half
way between the capture's lower quartile and the peak.

The log-odds of an action in a capture are the mean of those of its interval and of the whole
capture, because captions describe whole captures. Words in captions of the capture are evidence in
addition to the motion. A capture's score is the probability that it shows all actions, the product
of the actions' probabilities, so that a clear action does not compensate for a missing one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.meaning.score_vectors import interval_vectors
from motiondb.meaning.word_map import WordMap
from motiondb.records import FloatArray, IntArray

WRITTEN = 4.0  # Log-odds added by a word written about the interval: captions are rarely wrong
UNWRITTEN = -1.0  # Log-odds added by a word missing from a caption: captions are rarely complete
WINDOW_MARGIN = 22  # Frames (0.75 s) by which a window extends beyond its segment on both sides


@dataclass(frozen=True, eq=False)
class TakeScores:
    """Log-odds of the vocabulary in one capture."""

    starts: IntArray  # (segments,): first frame of each segment
    ends: IntArray  # (segments,): one past the last frame of each segment
    windows: FloatArray  # (segments, words): log-odds in the window around each segment
    whole: FloatArray  # (words,): log-odds of the whole capture


def motion_log_odds(
    fit: WordMap, standardised: FloatArray, starts: IntArray, ends: IntArray, margin: int
) -> FloatArray:
    """Log-odds of words in one capture, from its motion: array (segments + 1, words).

    The last row is that of the whole capture.

    Shapes: `standardised` (segments, columns); `starts`, `ends` (segments,).
    """
    low = np.concatenate([starts - margin, [0]])
    high = np.concatenate([ends + margin, ends[-1:]])
    return fit.log_odds(interval_vectors(standardised, starts, ends, low, high))


def written_evidence(
    n_segments: int,
    spans: Sequence[tuple[int, int, FloatArray]],
    starts: IntArray,
    ends: IntArray,
    n_words: int,
) -> FloatArray:
    """Log-odds added by captions: array (segments, words).

    Shapes: `spans` each (words,); `starts`, `ends` (segments,).
    """
    evidence = np.zeros((n_segments, n_words))
    if not spans:
        return evidence
    covered = np.zeros(n_segments, dtype=bool)
    said = np.zeros((n_segments, n_words), dtype=bool)
    for low, high, words in spans:
        inside = (starts < high) & (ends > low)
        covered |= inside
        said[inside] |= words.astype(bool)
    evidence[covered] = UNWRITTEN
    evidence[said] = WRITTEN
    return evidence


def all_hold(log_odds: Sequence[FloatArray]) -> FloatArray:
    """Log-odds that independent statements all hold, element by element.

    `log_odds`: Log-odds of each statement, of one shape; at least one. A single one is returned as
    it is.
    """
    if len(log_odds) == 1:
        return log_odds[0]
    log_p = -np.logaddexp(0.0, -np.stack(log_odds)).sum(axis=0)
    log_p = np.minimum(log_p, -1e-300)  # certain, up to floating point
    joint: FloatArray = log_p - np.log(-np.expm1(log_p))
    return joint


def joint_log_odds(log_odds: Sequence[float]) -> float:
    """Log-odds that several independent statements all hold.

    >>> joint_log_odds([0.25])
    0.25
    >>> round(joint_log_odds([0.0, 0.0]), 6)  # 1/2 * 1/2 = 1/4, whose log-odds are -ln 3
    -1.098612
    """
    if len(log_odds) == 1:
        return float(log_odds[0])
    log_p = -float(np.logaddexp(0.0, -np.asarray(log_odds)).sum())
    return log_p - math.log(-math.expm1(log_p))


def split_segments(take: TakeScores, n_least: int) -> TakeScores:
    """Divide segments so that there are at least ``n_least``, or as many as there are frames.

    Segments are divided into equal parts with the same log-odds.
    """
    n_parts = -(-n_least // max(len(take.starts), 1))
    if n_parts < 2:
        return take
    bounds = np.linspace(take.starts, take.ends, n_parts + 1, axis=1).round().astype(np.int64)
    starts, ends = bounds[:, :-1].ravel(), bounds[:, 1:].ravel()
    kept = ends > starts
    windows = np.repeat(take.windows, n_parts, axis=0)[kept]
    return TakeScores(starts[kept], ends[kept], windows, take.whole)


def ordered_peaks(values: FloatArray) -> list[int] | None:
    """One segment for each action, each after the one before, of largest total value.

    Shapes: `values` (actions, segments).

    >>> ordered_peaks(np.array([[0., 5, 1], [9, 1, 2]]))
    [1, 2]
    """
    n_actions, n_segments = values.shape
    if n_segments < n_actions:
        return None
    best = np.full((n_actions, n_segments), -np.inf)
    back = np.zeros((n_actions, n_segments), dtype=np.int64)
    best[0] = values[0]
    for k in range(1, n_actions):
        top, arg = -np.inf, 0
        for i in range(1, n_segments):
            if best[k - 1, i - 1] > top:
                top, arg = best[k - 1, i - 1], i - 1
            best[k, i], back[k, i] = top + values[k, i], arg
    path = [int(np.argmax(best[-1]))]
    for k in range(n_actions - 1, 0, -1):
        path.append(int(back[k, path[-1]]))
    return path[::-1]


def grow(values: FloatArray, peak: int, low: int, high: int) -> tuple[int, int]:
    """Segments [a, b) around a peak, within [low, high), of at least half its height.

    Height is measured from the capture's lower quartile. If the peak is less than one nat above it,
    the values are nearly constant, and the interval is [low, high).

    Shapes: `values` (segments,).
    """
    floor = lower_quartile(values)
    if values[peak] - floor < 1.0:
        return low, high
    threshold = floor + 0.5 * (values[peak] - floor)
    a = b = peak
    while a > low and values[a - 1] >= threshold:
        a -= 1
    while b + 1 < high and values[b + 1] >= threshold:
        b += 1
    return a, b + 1


def lower_quartile(values: FloatArray) -> float:
    """Lower quartile as ``np.quantile`` computes it, faster for short arrays.

    Shapes: `values` (n,).

    >>> lower_quartile(np.array([4.0, 1, 3, 2]))
    1.75
    """
    ordered = np.sort(values)
    place = 0.25 * (len(ordered) - 1)
    low = int(place)
    high = min(low + 1, len(ordered) - 1)
    return float(ordered[low] + (place - low) * (ordered[high] - ordered[low]))


def place_parts(
    values: FloatArray, runs: Sequence[tuple[int, int]], worded: Sequence[bool]
) -> list[tuple[int, int]]:
    """Segments [a, b) of every part: those with words grow, empty ones fill the gaps.

    Shapes: `values` (parts, segments).

    `runs`: Segments [a, b) that every part covers at least, each behind the one before.
    """
    n_actions, n_segments = values.shape
    parts = [(0, 0)] * n_actions
    asked = [k for k in range(n_actions) if worded[k]]
    end, last = 0, -1
    for place, k in enumerate(asked):
        following = asked[place + 1] if place + 1 < len(asked) else n_actions
        limit = runs[following][0] if following < n_actions else n_segments
        low, high = end + (k - last - 1), limit - (following - k - 1)
        first, behind = runs[k]
        peak = first + int(np.argmax(values[k][first:behind]))
        start, stop = grow(values[k], peak, low, high)
        parts[k] = (min(start, first), max(stop, behind))
        _fill(parts, last + 1, k, end, parts[k][0])
        end, last = parts[k][1], k
    _fill(parts, last + 1, n_actions, end, n_segments)
    return parts


def _fill(parts: list[tuple[int, int]], first: int, last: int, low: int, high: int) -> None:
    """Assign segments [low, high) to actions [first, last): one each, the rest to the last."""
    for k in range(first, last):
        parts[k] = (low, high if k == last - 1 else low + 1)
        low += 1
