"""The interval of a capture that best shows a question, with its log-odds.

A *reading* of the question (:mod:`motiondb.language.question.readings`) is an order of parts, each
of one or more actions at once, and exclusions that hold from one part to another. With v_a(i) the
mean log-odds of the words of action a in the window around segment i, the value of part k there is

    v_k(i) = sum of v_a(i) over its actions - sum of v_e(i) over the exclusions that hold in it.

A dynamic program picks one run of segments for every part, each after the one before, with the
largest total: one segment, or, for a part of a least length, as many as reach it, with their mean
weighted by frames. Two repeats of the same part have a gap between them, a segment that is less
than half as strong as the strongest. Around its run a part grows for as long as its value is at
least half way between the capture's lower quartile and the peak.

Statements of an answer, each with its log-odds:

    asked       of the words of the action, each with 1/2 of its log-odds at the strongest segment
                of the part + 1/2 of those of the whole capture
    repeats     as asked, at the weakest of the repeats
    excluded    as asked, at the segment within the parts where v_e is largest; where all its words
                are asked for elsewhere in the question, of this segment alone

The odds against an action are the sum of those against its words: who surely walks and hardly goes
backward does not walk backward. The log-odds of all statements together are those that all hold,
assumed independent. A side of a limb is no evidence where the motion tells it
(:func:`motiondb.meaning.limb_sides.without_sides`).
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motiondb.language.question.readings import Exclusion, Part, Reading
from motiondb.meaning.limb_sides import without_sides
from motiondb.meaning.word_evidence import (
    SLACK,
    TakeScores,
    action_log_odds,
    all_hold,
    joint_log_odds,
)
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
    if not any(apart) and not any(seconds.tolist()):
        peaks = ordered_peaks(values)
        return None if peaks is None else [(peak, peak + 1) for peak in peaks]
    # per end b the largest total of the parts so far, and its last run [a, b) with the end before
    best = [0.0] * (n_segments + 1)
    backs: list[list[tuple[int, int, int]]] = []
    for k in range(n_parts):
        behind, means = (
            each.tolist() for each in _runs(values[k], starts, ends, float(seconds[k]))
        )
        latest = _latest_ends(gaps(values[k]).tolist()) if apart[k] else range(n_segments)
        new, back = [-math.inf] * (n_segments + 1), [(-1, -1, -1)] * (n_segments + 1)
        for i, before in enumerate(latest):  # the shortest run from i that is long enough
            b = behind[i]
            if b <= n_segments and before >= 0 and best[before] + means[i] > new[b]:
                new[b], back[b] = best[before] + means[i], (i, b, before)
        for b in range(1, n_segments + 1):
            if new[b - 1] >= new[b]:
                new[b], back[b] = new[b - 1], back[b - 1]
        best = new
        backs.append(back)
    if math.isinf(best[-1]):
        return None
    runs, place = [], n_segments
    for back in reversed(backs):
        first, last, place = back[place]
        runs.append((first, last))
    return runs[::-1]


def gaps(values: FloatArray) -> NDArray[np.bool_]:
    """Segments (segments,) that are less than half as strong as the strongest of a capture.

    Strength is measured from the lower quartile, as in :func:`grow`.

    >>> gaps(np.array([4.0, 0.0, 3.0])).tolist()
    [False, True, False]
    """
    floor, top = lower_quartile(values.tolist()), float(values.max())
    if top - floor < 1.0:
        return np.zeros(len(values), dtype=bool)
    weak: NDArray[np.bool_] = values < floor + 0.5 * (top - floor)
    return weak


def _latest_ends(weak: Sequence[bool]) -> list[int]:
    """Per segment i the last end b of a run, such that a gap lies in [b, i); -1: there is none."""
    latest = [-1] * len(weak)
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
    first, *others = values.tolist()  # lists, since most captures have few segments
    best, backs = first, []
    for row in others:
        top, arg = -math.inf, 0
        new, back = [-math.inf], [0]
        for i in range(1, n_segments):
            if best[i - 1] > top:
                top, arg = best[i - 1], i - 1
            new.append(top + row[i])
            back.append(arg)
        best = new
        backs.append(back)
    path = [best.index(max(best))]
    for back in reversed(backs):
        path.append(back[path[-1]])
    return path[::-1]


def grow(values: Sequence[float], peak: int, low: int, high: int) -> tuple[int, int]:
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


def lower_quartile(values: Sequence[float]) -> float:
    """Lower quartile as ``np.quantile`` computes it, faster for short lists; `values` (n,).

    >>> lower_quartile([4.0, 1, 3, 2])
    1.75
    """
    ordered = sorted(values)
    place = 0.25 * (len(ordered) - 1)
    low = int(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def place_parts(
    values: FloatArray, runs: Sequence[tuple[int, int]], worded: Sequence[bool]
) -> list[tuple[int, int]]:
    """Segments [a, b) of every part: those with words grow, empty ones fill the gaps.

    Shapes: `values` (parts, segments).

    `runs`: Segments [a, b) that every part covers at least, each behind the one before.
    """
    n_actions, n_segments = values.shape
    rows = values.tolist()
    parts = [(0, 0)] * n_actions
    asked = [k for k in range(n_actions) if worded[k]]
    end, last = 0, -1
    for place, k in enumerate(asked):
        following = asked[place + 1] if place + 1 < len(asked) else n_actions
        limit = runs[following][0] if following < n_actions else n_segments
        low, high = end + (k - last - 1), limit - (following - k - 1)
        first, behind = runs[k]
        peak = _place_of_largest(rows[k], first, behind)
        start, stop = grow(rows[k], peak, low, high)
        parts[k] = (min(start, first), max(stop, behind))
        _fill(parts, last + 1, k, end, parts[k][0])
        end, last = parts[k][1], k
    _fill(parts, last + 1, n_actions, end, n_segments)
    return parts


def _place_of_largest(values: Sequence[float], low: int, high: int) -> int:
    """The first place in [low, high) of the largest value there."""
    return low if high - low == 1 else max(range(low, high), key=values.__getitem__)


def _fill(parts: list[tuple[int, int]], first: int, last: int, low: int, high: int) -> None:
    """Assign segments [low, high) to actions [first, last): one each, the rest to the last."""
    for k in range(first, last):
        parts[k] = (low, high if k == last - 1 else low + 1)
        low += 1


@dataclass(frozen=True)
class Statement:
    """One requested or excluded action, and the segments of a capture at which it is evaluated."""

    words: tuple[int, ...]  # Numbers of its words
    part: int  # Number of the part that requests it; of the first one for an exclusion
    exclusion: int  # Number of the exclusion that it belongs to, -1 if it is requested
    # First frames of the segments at which it is evaluated, and their weights, which sum to 1
    places: tuple[tuple[int, float], ...]
    near: float  # Share of these segments in the log-odds; the rest is of the whole capture
    odds: tuple[float, ...]  # Log-odds of every word alone

    @cached_property
    def log_odds(self) -> float:
        """Log-odds that the capture shows the action there."""
        return self.odds[0] if len(self.odds) == 1 else float(action_log_odds(self.odds))


@dataclass(frozen=True)
class QuestionHit:
    """The best interval of one capture for one reading of a question."""

    start: int
    end: int  # Last frame + 1
    log_odds: float  # Log-odds of the answer, by which answers are ranked
    parts: tuple[tuple[int, int], ...]  # Frames of every part, in order; they do not overlap
    statements: tuple[Statement, ...]  # Requested and excluded actions
    reading: int = 0  # Number of the reading


def search_take(
    take: TakeScores,
    readings: Sequence[Reading],
    number: Mapping[str, int],
) -> QuestionHit | None:
    """The best interval of a capture over all readings of a question."""
    seen: dict[int, _Seen] = {}
    hits = [_search_reading(seen, take, readings, n, number) for n in range(len(readings))]
    fitting = [hit for hit in hits if hit is not None]
    return max(fitting, key=lambda hit: hit.log_odds, default=None)


def likeliest_takes(
    captures: IntArray,
    bounds: FloatArray,
    search: Callable[[int], QuestionHit | None],
    limit: int,
) -> list[tuple[int, QuestionHit]]:
    """The captures with the largest log-odds, best first; of equal ones, the lowest numbers.

    Shapes: `captures`, `bounds` (captures,): numbers, and what their log-odds are at most.
    """
    best: list[tuple[float, int, QuestionHit]] = []  # a heap, the worst first
    for place in np.argsort(-bounds, kind="stable"):
        if len(best) >= limit and (not best or bounds[place] + SLACK < best[0][0]):
            break
        capture = int(captures[place])
        hit = search(capture)
        if hit is None:
            continue
        heapq.heappush(best, (hit.log_odds, -capture, hit))
        if len(best) > limit:
            heapq.heappop(best)
    return [(-number, hit) for _, number, hit in sorted(best, key=lambda b: (-b[0], -b[1]))]


def search_order(take: TakeScores, actions: Sequence[Sequence[int]]) -> QuestionHit | None:
    """The best interval of a capture for actions in order.

    >>> take = TakeScores(np.array([0, 10]), np.array([10, 20]), np.diag([4.0, 2.0]), np.ones(2))
    >>> search_order(take, [[0], [1]]).parts
    ((0, 10), (10, 20))
    """
    number = {str(word): word for action in actions for word in action}
    parts = tuple(
        Part((tuple(map(str, action)),) if action else (), repeat_of=k)
        for k, action in enumerate(actions)
    )
    return search_take(take, [Reading(parts)], number)


@dataclass(frozen=True, eq=False)
class PlacedReading:
    """Where a capture shows the parts of one reading."""

    # (segments,): first frames of the segments; divided if the capture has fewer than there are
    # parts
    starts: IntArray
    ends: IntArray  # (segments,): last frames + 1
    # (parts, segments): mean value of the actions of every part; 0 for a part without any
    values: FloatArray
    # Segments [a, b) of every part, in order; they do not overlap
    spans: tuple[tuple[int, int], ...]


def place_reading(
    take: TakeScores, reading: Reading, number: Mapping[str, int]
) -> PlacedReading | None:
    """Where a capture shows the parts of a reading, as :func:`search_take` places them."""
    seen = _Seen(split_segments(take, len(reading.parts)), number)
    laid = None if _is_too_short(take, reading) else _lay(seen, reading)
    if laid is None:
        return None
    none = np.zeros(len(seen.take.starts))
    values = [
        sum(map(seen.action, part.actions), none) / max(len(part.actions), 1)
        for part in reading.parts
    ]
    return PlacedReading(seen.take.starts, seen.take.ends, np.array(values), tuple(laid[2]))


def joint_statements(asked: Sequence[float], excluded: Sequence[float]) -> float:
    """Log-odds that all requested actions are shown and no excluded one.

    >>> joint_statements([1.5], [])
    1.5
    >>> round(joint_statements([0.0], [0.0]), 6)  # 1/2 * (1 - 1/2) = 1/4
    -1.098612
    """
    return joint_log_odds([*asked, *(-log_odds for log_odds in excluded)])


def _search_reading(
    known: dict[int, _Seen],
    take: TakeScores,
    readings: Sequence[Reading],
    n: int,
    number: Mapping[str, int],
) -> QuestionHit | None:
    """The best interval for reading n; ``known`` caches the result for each number of parts."""
    reading = readings[n]
    n_parts = len(reading.parts)
    seen = known.get(n_parts)
    if seen is None:
        seen = known[n_parts] = _Seen(split_segments(take, n_parts), number)
    laid = None if _is_too_short(take, reading) else _lay(seen, reading)
    if laid is None:
        return None
    values, runs, parts = laid
    take = seen.take
    statements = [*seen.asked(reading.parts, values, runs, parts), *seen.excluded(reading, parts)]
    frames = tuple((int(take.starts[a]), int(take.ends[b - 1])) for a, b in parts)
    log_odds = joint_statements(*split_statements(statements))
    return QuestionHit(frames[0][0], frames[-1][1], log_odds, frames, tuple(statements), n)


def _is_too_short(take: TakeScores, reading: Reading) -> bool:
    """Whether a capture is shorter than the parts, or its segments are fewer than repeats."""
    asked = _asked_of(reading)
    if asked.n_frames > take.ends[-1] - take.starts[0]:
        return True
    return asked.repeats and len(take.starts) < len(reading.parts)


class _Asked(NamedTuple):
    """What a reading asks of the places of its parts, in any capture."""

    n_frames: float  # Least length of the capture
    repeats: bool  # Whether parts are repeated
    seconds: FloatArray  # (parts,): least length of each
    apart: tuple[bool, ...]  # Whether a part repeats the one before it
    worded: tuple[bool, ...]  # Whether a part asks for something


@lru_cache(256)
def _asked_of(reading: Reading) -> _Asked:
    parts, first = reading.parts, [part.repeat_of for part in reading.parts]
    return _Asked(
        sum(part.seconds for part in parts) * MOTION_FPS - 1e-6 * len(parts),
        first != list(range(len(parts))),
        np.array([part.seconds for part in parts]),
        tuple(k > 0 and first[k] == first[k - 1] for k in range(len(parts))),
        tuple(
            bool(part.actions)
            or part.seconds > 0.0
            or any(e.first <= k < e.last for e in reading.exclusions)
            for k, part in enumerate(parts)
        ),
    )


def _lay(
    seen: _Seen, reading: Reading
) -> tuple[FloatArray, list[tuple[int, int]], list[tuple[int, int]]] | None:
    """Values (parts, segments), runs and segments [a, b) of every part; None: too short."""
    take, asked = seen.take, _asked_of(reading)
    values = np.array([seen.part(reading, k) for k in range(len(reading.parts))])
    runs = ordered_runs(values, take.starts, take.ends, asked.seconds, asked.apart)
    return None if runs is None else (values, runs, place_parts(values, runs, asked.worded))


def split_statements(statements: Sequence[Statement]) -> tuple[list[float], list[float]]:
    """Log-odds of the requested actions, and for every exclusion that all its actions are shown."""
    asked = [s.log_odds for s in statements if s.exclusion < 0]
    numbers = sorted({s.exclusion for s in statements if s.exclusion >= 0})
    excluded = [
        joint_log_odds([s.log_odds for s in statements if s.exclusion == n]) for n in numbers
    ]
    return asked, excluded


class _Seen:
    """The evidence of a capture for actions, at its segments and of the whole, computed once."""

    def __init__(self, take: TakeScores, number: Mapping[str, int]) -> None:
        self.take = take
        self.number = number
        self.values: dict[tuple[str, ...], FloatArray] = {}

    def columns(self, action: tuple[str, ...]) -> list[int]:
        return [self.number[word] for word in without_sides(action)]

    def action(self, action: tuple[str, ...]) -> FloatArray:
        """Values of an action: array (segments,)."""
        if action not in self.values:
            self.values[action] = _mean_of(self.take.windows, self.columns(action))
        return self.values[action]

    def part(self, reading: Reading, k: int) -> FloatArray:
        """Values of a part of a reading: array (segments,)."""
        asked = [self.action(action) for action in reading.parts[k].actions]
        values = np.asarray(sum(asked)) if asked else np.zeros(len(self.take.starts))
        for exclusion in reading.exclusions:
            if exclusion.first <= k < exclusion.last:
                values = values - self.together(exclusion)
        return values

    def together(self, exclusion: Exclusion) -> FloatArray:
        """Log-odds that all actions of an exclusion are seen: array (segments,)."""
        return all_hold([self.action(action) for action in exclusion.actions])

    def asked(
        self,
        parts: Sequence[Part],
        values: FloatArray,
        runs: Sequence[tuple[int, int]],
        spans: Sequence[tuple[int, int]],
    ) -> list[Statement]:
        """Requested actions; repeats are evaluated at the weakest repeat."""
        rows = values.tolist()
        looks = [self._look(rows[k], parts[k], runs[k], spans[k]) for k in range(len(parts))]
        strength = [sum(weight * rows[k][i] for i, weight in look) for k, look in enumerate(looks)]
        statements = []
        for first in sorted({part.repeat_of for part in parts}):
            same = [k for k, part in enumerate(parts) if part.repeat_of == first]
            k = min(same, key=lambda k: strength[k])
            statements += [
                self._statement(action, k, -1, looks[k], 0.5) for action in parts[k].actions
            ]
        return statements

    def excluded(self, reading: Reading, spans: Sequence[tuple[int, int]]) -> list[Statement]:
        """Excluded actions, each at its largest value within its parts."""
        elsewhere = {word for part in reading.parts for action in part.actions for word in action}
        statements = []
        for n, exclusion in enumerate(reading.exclusions):
            low, high = spans[exclusion.first][0], spans[exclusion.last - 1][1]
            for action in exclusion.actions:
                loudest = low + int(np.argmax(self.action(action)[low:high]))
                near = 1.0 if elsewhere.issuperset(action) else 0.5
                statements.append(
                    self._statement(action, exclusion.first, n, [(loudest, 1.0)], near)
                )
        return statements

    def _look(
        self, values: Sequence[float], part: Part, run: tuple[int, int], span: tuple[int, int]
    ) -> list[tuple[int, float]]:
        """Segments at which a part is evaluated, with weights: the strongest, or all of its run."""
        if part.seconds <= 0.0:
            return [(_place_of_largest(values, *span), 1.0)]
        frames = (self.take.ends - self.take.starts)[run[0] : run[1]]
        return [(run[0] + i, float(f / frames.sum())) for i, f in enumerate(frames)]

    def _statement(
        self,
        action: tuple[str, ...],
        part: int,
        exclusion: int,
        look: Sequence[tuple[int, float]],
        near: float,
    ) -> Statement:
        columns = self.columns(action)
        places = tuple((int(self.take.starts[i]), weight) for i, weight in look)
        odds = []
        for column in columns:
            inside = sum([weight * float(self.take.windows[i, column]) for i, weight in look])
            odds.append(near * inside + (1.0 - near) * float(self.take.whole[column]))
        return Statement(tuple(columns), part, exclusion, places, near, tuple(odds))


def _mean_of(values: FloatArray, columns: Sequence[int]) -> FloatArray:
    """Mean over some columns: array (segments,); `values` (segments, words)."""
    total = sum([values[:, column] for column in columns[1:]], values[:, columns[0]])
    return total / len(columns) if len(columns) > 1 else total
