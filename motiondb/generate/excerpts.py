"""Excerpts of captures that show an action: where to cut, how often to repeat, how fast to play.

An excerpt grows from the segment of largest value (:mod:`motiondb.generate.action_sources`)
to its neighbours for as long as their value is within ``DROP`` of it. From one capture up to
``MOST_OF_A_CAPTURE`` excerpts are taken.

Repetitions repeat whole cycles. Where occurrences of the action are measured in the motion
(:mod:`motiondb.meaning.occurrences`), these are counted. Otherwise one time is one cycle if the
movement has a period, or the whole excerpt, cut where its end and its beginning are alike. A longer
duration is reached by further cycles.

Where an action has a measured word that its captures can show ("stand up", "stop"), every excerpt
is cut to the part of its stretch that goes furthest that way, and what is missing of the full
amount is a cost. An excerpt that would begin or end in an unusual pose, such as upside down, is
extended to a more usual one near by.

A *place* is an excerpt with all those that share more than half of the shorter one with it. It is
comparable with the best place if the value of its best excerpt is lower by at most ``COMPARABLE``,
or at least ``CLEAR``, and if it does all that is measured, where the best one does. Where an action
or a lasting change of height is measured, excerpts that fully do it are comparable down to
``COMPARABLE_DONE``. The captures take turns: first the best place of each capture, then the second
one of each, and so on. Seed s takes place s modulo their number.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motiondb.generate.action_sources import Source
from motiondb.generate.cycles import Loop, best_loop, calmest_phase, find_period, repeat
from motiondb.generate.sentence_plan import PlannedAction
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import IN_PLACE
from motiondb.meaning.direction import (
    ACTIONS,
    OCCURRING,
    REACHED,
    VERTICAL,
    furthest_part,
    gone,
    lacking,
)
from motiondb.meaning.extents import whole_occurrences
from motiondb.meaning.limb_sides import hop_on
from motiondb.meaning.occurrences import COUNTED, FLIGHTS, find_occurrences
from motiondb.meaning.travelled import directions_to_measure
from motiondb.records import MOTION_FPS, FloatArray, IntArray

DROP = 1.0
"""Nats by which a segment of an excerpt may be worse than the best. Of .7, 1 and 1.5, 1 gave the
most excerpts whose action the judge finds first (.40, .42, .40 of 36 actions of CMU)."""
SHORTEST, LONGEST = 75, 150
"""Frames (2.5 s and 5 s) of an excerpt, unless the sentence says how long or how often, or the
capture is shorter: two to three seconds were the best context for recognition."""
UNPLACED = 105
"""Shortest excerpt, frames (3.5 s), if the motion does not determine where the action is."""
MOST_OF_A_CAPTURE = 3  # Excerpts of one capture
FAR_BELOW = 2.0
"""Nats by which a further excerpt of a capture may be worse than its best: worse ones are approach
and waiting."""
LEAST_CYCLIC = 90  # Shortest periodic movement, frames (3 s)
SLACK = 20  # Frames by which a cut may move to where the end and the beginning are alike
SHORTEST_LOOP = 45  # Fewest frames (1.5 s) of a loop of a movement without a period
TOLERANCE = 0.05  # Share by which a duration may be missed so that a loop fits
UNREST_WEIGHT = 10.0  # Cost of a cut at the largest speed, as a squared distance of poses
LEAST_LOOP = 0.6  # Smallest share of an excerpt without a period that a loop repeats
DIRECTION_WEIGHT = 3.0  # Cost of an excerpt that does not go in the direction at all, nats
NOT_DONE = 6.0
"""Further cost of an excerpt that does not reach ``REACHED``, nats: it would be told as not
shown. A direction or a side that is reached, but is not clear, costs a part of it."""
UNSEEN_WEIGHT = 6.0  # Cost of an excerpt in which the action is nowhere to be seen, nats
_AHEAD = {"stop": 1.0, "start": 0.0}
"""Share of the time that a short part is extended by which lies before it. A stop is not followed
by what comes after it, nor a start preceded by what came before."""
MARGIN = 12  # Frames (0.4 s) before and after the part that goes in the direction
CHANGE = 60
"""Frames (2 s) around a stretch in which a lasting change of height is looked for: who sits has sat
down before."""
FURTHER = 36  # Frames (1.2 s) by which an excerpt may be extended to a usual pose
UNUSUAL = 2.0
"""Mean squared distance from the mean pose, in variances, above which a pose is unusual."""
COMPARABLE = 2.0
"""Nats. On the best 24 excerpts of 36 actions of CMU, the judge's probability of excerpts within 2
nats of the best one is lower than that one's by .01 to .04, that of excerpts 2.5 to 3 nats below it
by .13; it finds shown .06 fewer at most within 2 nats, and .14 to .22 fewer at 2 to 3."""
COMPARABLE_DONE = 6.0
"""Nats, by hand. A kick that is measured is a kick, even if other captures look more like one."""
CLEAR = 3.0
"""Nats. On the same excerpts the judge's mean probability from 3 nats on is .97 or more even where
the best one is better by more than 2 nats, and it finds them all shown; below 2 nats it is .83 or
less."""


@dataclass(frozen=True)
class Excerpt:
    """A part of a capture that shows an action."""

    capture: int  # Number of the capture
    start: int  # First frame, at 30 frames a second
    end: int  # Last frame + 1
    score: float  # Mean value of its segments less the cost of the capture, nats
    # First frame and last frame + 1 of the stretch of good segments that it is cut from
    stretch: tuple[int, int]
    # What cuts must leave whole: the measured occurrences with what leads to them and follows them
    core: tuple[int, int] | None = None

    def keeps_core(self, start: int, end: int) -> bool:
        """Whether other cuts leave its core whole."""
        return self.core is None or (start <= self.core[0] and self.core[1] <= end)


def find_excerpts(sources: Sequence[Source], longest: int) -> list[Excerpt]:
    """Find the excerpts of all sources, best first."""
    excerpts = []
    for source in sources:
        free = np.ones(len(source.values), dtype=bool)
        for _ in range(MOST_OF_A_CAPTURE):
            if not free.any():
                break
            peak = int(np.argmax(np.where(free, source.values, -np.inf)))
            if source.values[peak] < source.values.max() - FAR_BELOW:
                break
            first, behind = _grow(source.values, free, peak)
            free[first:behind] = False
            excerpts += _cut(source, first, behind, longest)
    return sorted(excerpts, key=lambda excerpt: -excerpt.score)


def _grow(values: FloatArray, free: NDArray[np.bool_], peak: int) -> tuple[int, int]:
    """Segments [first, behind) around a peak whose values are within DROP of it."""
    first, behind = peak, peak + 1
    while first > 0 and free[first - 1] and values[first - 1] >= values[peak] - DROP:
        first -= 1
    while behind < len(values) and free[behind] and values[behind] >= values[peak] - DROP:
        behind += 1
    return first, behind


def _cut(source: Source, first: int, behind: int, longest: int) -> list[Excerpt]:
    """Excerpts of some segments: all of them, or windows where they are longer than allowed."""
    start, end = int(source.starts[first]), int(source.ends[behind - 1])
    least = min(SHORTEST if source.is_placed else UNPLACED, longest)
    if end - start < least:
        start, end = _extend(source, start, end, least)
    spans = [(start, end)]
    if end - start > longest:
        ahead = {start, end - longest, *source.starts[first:behind].tolist()}
        lows = sorted(low for low in ahead if low <= end - longest)
        spans = [(int(low), int(low) + longest) for low in lows]
    return [
        Excerpt(source.capture, a, b, _mean_value(source, a, b) - source.cost, (start, end))
        for a, b in spans
    ]


def _extend(source: Source, start: int, end: int, least: int) -> tuple[int, int]:
    """An interval around [start, end) of a number of frames, where the values are largest.

    All of the capture if it is shorter. Of intervals of equal value the most central one.
    """
    first, behind = int(source.starts[0]), int(source.ends[-1])
    lows = np.arange(max(end - least, first), min(start, behind - least) + 1)
    if len(lows) == 0:
        return first, behind
    middle = np.abs(lows + least / 2.0 - (start + end) / 2.0)
    order = np.argsort(middle, kind="stable")
    values = [_mean_value(source, int(low), int(low) + least) for low in lows[order]]
    low = int(lows[order[int(np.argmax(np.round(values, 6)))]])
    return low, low + least


def _mean_value(source: Source, start: int, end: int) -> float:
    """Mean value of the segments of an interval, weighted by their frames in it."""
    frames = np.minimum(source.ends, end) - np.maximum(source.starts, start)
    return float(np.average(source.values, weights=np.maximum(frames, 0)))


def direct(
    excerpts: Sequence[Excerpt],
    tracks: Mapping[int, FloatArray],
    directions: Sequence[str],
    longest: int = LONGEST,
) -> tuple[list[Excerpt], tuple[str, ...]]:
    """Cut excerpts to go in the directions of an action, and say which directions are honoured."""
    honoured: list[str] = []
    directed = list(excerpts)
    for direction in directions:
        cut = [_cut_to_direction(e, tracks[e.capture], direction, longest) for e in directed]
        amounts = np.array([gone(tracks[e.capture][e.start : e.end], direction) for e in cut])
        if amounts.max(initial=0.0) < REACHED:
            continue
        costs = DIRECTION_WEIGHT * np.clip(1.0 - amounts, 0.0, 2.0)
        costs += NOT_DONE * np.array([lacking(amount, direction) for amount in amounts])
        directed = [replace(e, score=e.score - c) for e, c in zip(cut, costs)]
        honoured.append(direction)
    unique = {(e.capture, e.start, e.end): e for e in sorted(directed, key=lambda e: e.score)}
    return sorted(unique.values(), key=lambda e: -e.score), tuple(honoured)


def _cut_to_direction(excerpt: Excerpt, path: FloatArray, direction: str, longest: int) -> Excerpt:
    """The part of the excerpt's stretch that goes furthest in a direction."""
    if direction == IN_PLACE:
        return excerpt
    low, high = excerpt.stretch
    if direction in VERTICAL:
        low, high = max(low - CHANGE, 0), min(high + CHANGE, len(path))
    first, behind = furthest_part(path[low:high], direction, longest)
    first, behind, core = low + first, low + behind, None
    for begin, over in whole_occurrences(path, direction) if direction in COUNTED else ():
        if begin < behind and first < over:
            core = min(first, begin), max(behind, over)
            first, behind = core
    margin = 0 if core else MARGIN
    start, end = max(first - margin, 0), min(behind + margin, len(path))
    missing = max(SHORTEST - (end - start), 0)
    start = max(start - round(missing * _AHEAD.get(direction, 0.5)), 0)
    if direction != "stop":
        end = max(end, start + SHORTEST)
    return replace(excerpt, start=start, end=min(end, len(path)), core=core)


def with_unseen(excerpts: Sequence[Excerpt], unseen: Mapping[int, FloatArray]) -> list[Excerpt]:
    """Excerpts with the cost of frames that do not show the action, beyond the least of them.

    `unseen`: capture -> 1 at such frames (frames,), else 0; empty where this is not known.

    >>> excerpts = [Excerpt(7, 0, 4, 0.0, (0, 4)), Excerpt(7, 4, 8, 0.0, (4, 8))]
    >>> [e.score for e in with_unseen(excerpts, {7: np.array([0, 0, 0, 1, 1, 1, 1, 0])})]
    [0.0, -3.0]
    """
    if not unseen:
        return list(excerpts)
    shares = np.array([unseen[e.capture][e.start : e.end].mean() for e in excerpts])
    costs = UNSEEN_WEIGHT * (shares - shares.min())
    return [replace(e, score=e.score - float(cost)) for e, cost in zip(excerpts, costs)]


def complete(excerpt: Excerpt, unusual: FloatArray) -> Excerpt:
    """Extend an excerpt that begins or ends in an unusual pose; `unusual` (frames,)."""
    start, end = excerpt.start, min(excerpt.end, len(unusual))
    if unusual[end - 1] > UNUSUAL:
        end += int(np.argmin(unusual[end - 1 : end + FURTHER]))
    if unusual[start] > UNUSUAL:
        before = unusual[max(start - FURTHER, 0) : start + 1]
        start -= len(before) - 1 - int(np.argmin(before))
    return replace(excerpt, start=start, end=end)


def number_places(
    excerpts: Sequence[Excerpt],
    values: FloatArray,
    does: NDArray[np.bool_],
    words: Sequence[str] = (),
) -> IntArray:
    """Number the comparable places: array (excerpts,), from 0; -1 for excerpts of no such place.

    `values` (excerpts,); `does` (excerpts,): whether each does all that is measured; `words`: what
    is measured.

    >>> where = [(7, 0, 90), (7, 20, 110), (7, 100, 190), (8, 0, 90), (9, 0, 90)]
    >>> excerpts = [Excerpt(c, a, b, 0.0, (a, b)) for c, a, b in where]
    >>> number_places(excerpts, np.array([5.0, 4.9, 4.5, 3.0, 2.9]), np.ones(5, dtype=bool))
    array([ 0,  0,  2,  1, -1])
    >>> number_places(excerpts, np.array([2.0, 0, -1, -3, -5]), np.ones(5, dtype=bool), ["kick"])
    array([ 0,  0,  2,  1, -1])
    >>> number_places(excerpts, np.array([2.0, 0, -1, -3, -5]), np.ones(5, dtype=bool))
    array([ 0,  0, -1, -1, -1])
    """
    numbers = np.full(len(excerpts), -1)
    order = np.argsort(-values, kind="stable").tolist()
    is_measured = not {*words}.isdisjoint((*ACTIONS, *VERTICAL)) and bool(order) and does[order[0]]
    apart = COMPARABLE_DONE if is_measured else COMPARABLE
    least = min(values[order[0]] - apart, CLEAR) if order else 0.0
    firsts: list[int] = []
    of_capture: Counter[int] = Counter()
    turns: list[tuple[int, int]] = []
    for n in order:
        mates = [k for k, first in enumerate(firsts) if _is_same(excerpts[n], excerpts[first])]
        comparable = values[n] >= least
        if mates:
            numbers[n] = mates[0]
        elif comparable and (does[n] or not does[order[0]]):
            numbers[n] = len(firsts)
            firsts.append(n)
            turns.append((of_capture[excerpts[n].capture], len(turns)))
            of_capture[excerpts[n].capture] += 1
    in_turn = np.array([place for _, place in sorted(turns)])
    return np.where(numbers >= 0, np.argsort(in_turn)[numbers], -1)


def _is_same(one: Excerpt, other: Excerpt) -> bool:
    """Whether two excerpts share more than half of the shorter one."""
    shared = min(one.end, other.end) - max(one.start, other.start)
    shorter = min(one.end - one.start, other.end - other.start)
    return one.capture == other.capture and 2 * shared > shorter


@dataclass(frozen=True)
class Layout:
    """Parts of a capture that are played one after the other."""

    parts: tuple[tuple[int, int], ...]  # First frame and last frame + 1 of every part
    said: str = ""  # How the excerpt is repeated; "" where it is played once
    # Number of performances of the action; None if no number was requested
    times: int | None = None
    is_measured: bool = False  # Whether these are measured occurrences
    each: int = 1  # Measured occurrences in each performance: a jumping jack has two flights

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return sum(end - start for start, end in self.parts)


@dataclass(frozen=True, eq=False)
class Movement:
    """What the layout of an excerpt looks at."""

    poses: FloatArray  # (frames, values): poses of the whole capture, for its period
    # (frames + 1, values): poses and velocities of the whole capture, as compared at seams
    edges: FloatArray
    # Whether the movement is over when it is done, so that it is lengthened only where the action
    # asks for a duration
    is_once: bool = False
    # First frame and last frame + 1 of every occurrence in the excerpt that was measured
    occurrences: tuple[tuple[int, int], ...] = ()
    # Whether no action follows, so that its end may be cut anywhere
    is_last: bool = True
    restless: FloatArray | None = None  # (frames,): speed of the limbs, m/s


def counted_word(action: PlannedAction) -> str | None:
    """The word of an action whose occurrences are counted.

    None for kicks and punches with a limb of one side, since those of either one are found.

    >>> counted_word(PlannedAction((("jump", "left"),)))
    'jump'
    >>> counted_word(PlannedAction((("hop", "left", "leg"),)))
    'hop left'
    >>> counted_word(PlannedAction((("kick", "left", "leg"),))) is None
    True
    """
    for group in action.groups:
        is_sided = bool(SIDES.intersection(group) and LIMBS.intersection(group))
        if hop_on(group):
            return hop_on(group)
        for word in group:
            if word in COUNTED and not (is_sided and word in OCCURRING):
                return word
    return None


def occurrences_in(
    excerpt: Excerpt, action: PlannedAction, track: FloatArray, rate: float
) -> tuple[tuple[int, int], ...]:
    """The occurrences in an excerpt that a number asks for, in frames of the capture at a tempo."""
    word = counted_word(action)
    if action.times is None or word is None:
        return ()
    return tuple(
        (round((excerpt.start + a) / rate), round((excerpt.start + b) / rate))
        for a, b in whole_occurrences(track[excerpt.start : excerpt.end], word)
    )


def occurrences_each(
    action: PlannedAction, poses: FloatArray, occurrences: Sequence[tuple[int, int]]
) -> int:
    """Measured occurrences in one performance of an action: 1, or those in a period of it.

    Only actions whose name says more than what is counted have several: a jumping jack, whose arms
    and legs come back at the second flight. `poses` (frames, values), from the first frame on to
    which the occurrences refer.

    >>> poses = np.sin(2 * np.pi * np.arange(90) / 30)[:, None]
    >>> flights = [(n, n + 5) for n in range(0, 90, 15)]
    >>> occurrences_each(PlannedAction((("jump", "jack"),)), poses, flights)
    2
    >>> occurrences_each(PlannedAction((("jump", "left"),)), poses, flights)
    1
    """
    word = counted_word(action)
    if word not in FLIGHTS or len(occurrences) < 2:
        return 1
    plain = {word, *SIDES, *LIMBS, *VERTICAL, IN_PLACE, *directions_to_measure(action.words)}
    if plain.issuperset(action.words):
        return 1
    first, last = occurrences[0][0], occurrences[-1][0]
    apart = (last - first) / (len(occurrences) - 1)
    period = find_period(poses[max(first, 0) : last + round(apart)])
    return max(round(period / apart), 1) if period else 1


def recount(action: PlannedAction, layout: Layout, track: FloatArray) -> Layout:
    """A layout that does not say the number measured in its capture if the motion has another."""
    word = counted_word(action)
    if not layout.is_measured or word is None:
        return layout
    is_right = len(find_occurrences(track, word)) == (layout.times or 0) * layout.each
    return layout if is_right else replace(layout, said="", is_measured=False)


def lay_out(action: PlannedAction, span: tuple[int, int], movement: Movement) -> Layout:
    """Repeat an excerpt as often and as long as an action asks for."""
    poses, edges = movement.poses, movement.edges
    start, end = span
    period = find_period(poses[start:end])
    if action.times is not None:
        times = max(round(action.times.wanted), 1)
        if movement.occurrences:
            each = occurrences_each(action, poses, movement.occurrences)
            return _times_measured(times, span, movement, each)
        return _times(times, span, period, movement)
    least = action.seconds.wanted * MOTION_FPS if action.seconds is not None else 0.0
    lengthened = period and not least and not movement.is_once
    wanted = round(max(least, LEAST_CYCLIC if lengthened else 0.0))
    if wanted <= end - start:
        return Layout(((start, start + wanted if least else end),))
    missing = wanted - (end - start)
    inside = edges[start : end + 1]
    is_least = action.seconds is not None and action.seconds.most is None
    short = 0.0 if is_least else TOLERANCE * wanted
    loop = _fitting_loop(inside, period, missing, short, bool(least) and not movement.is_last)
    if loop is None:
        return Layout((span,))
    more = -(-missing // loop.length)
    if period is None and not is_least:  # nothing is cut off
        more = max(round(missing / loop.length), 0)
    parts = [(start + a, start + b) for a, b in repeat(0, end - start, loop, more)]
    excess = sum(b - a for a, b in parts) - wanted
    if period is not None and excess > 0 and (movement.is_last or excess > TOLERANCE * least > 0):
        parts[-1] = (parts[-1][0], max(parts[-1][1] - excess, parts[-1][0] + 1))
    often = "once" if more == 1 else f"{more} times"
    said = f"{loop.length / MOTION_FPS:.1f} s of it repeated {often}" if more else ""
    return Layout(tuple(parts), said)


def _fitting_loop(
    edges: FloatArray, period: int | None, missing: int, short: float, timed: bool
) -> Loop | None:
    """The loop that lengthens an excerpt: whole cycles, or a part that fills what is missing.

    It may be shorter than that by ``short`` frames.
    """
    more = TOLERANCE * (len(edges) - 1 + missing)
    if period is not None:
        fitting = best_loop(edges, period, (missing - short, missing + more)) if timed else None
        return fitting or best_loop(edges, period)
    return best_loop(edges, SHORTEST_LOOP, (missing - short, missing + more)) or best_loop(
        edges, max(round(LEAST_LOOP * (len(edges) - 1)), 1)
    )


def _times(
    times: int,
    span: tuple[int, int],
    period: int | None,
    movement: Movement,
) -> Layout:
    """A number of cycles, or of whole performances where the movement has no period."""
    start, end = span
    if period is None:
        unit = _alike_ends(span, movement)
        length = (unit[1] - unit[0]) / MOTION_FPS
        said = f"the whole excerpt of {length:.1f} s, {times} times" if times > 1 else ""
        return Layout((unit,) * times, said, times)
    first = start + calmest_phase(movement.poses[start:end], period)
    n_cycles = max((end - first) // period, 1)
    parts = [(first, first + n_cycles * period)] * (times // n_cycles)
    if times % n_cycles:
        parts.append((first, first + times % n_cycles * period))
    said = f"{times} cycles of {period / MOTION_FPS:.1f} s"
    return Layout(tuple(parts), said, times)


def _times_measured(times: int, span: tuple[int, int], movement: Movement, each: int) -> Layout:
    """A number of measured occurrences: some of those of the excerpt, or all of them repeatedly.

    The excerpt is cut in the middle between two occurrences, or where its end and its beginning are
    alike. `each`: occurrences in a performance.
    """
    flights = movement.occurrences
    lasts = range(each - 1, len(flights), each)
    inside = [(flights[last - each + 1][0], flights[last][1]) for last in lasts]
    if len(flights) % each:  # the rest of a performance
        span = span[0], (inside[-1][1] + flights[len(inside) * each][0]) // 2
    middles = [(one[1] + after[0]) // 2 for one, after in pairwise(inside)]
    n = len(inside)
    if times < n:
        parts = [(span[0], middles[times - 1])]
    else:
        first, behind = _alike_ends(span, movement)
        whole = min(first, inside[0][0]), max(behind, inside[-1][1])
        whole = span if times == n else whole
        parts = [whole] * (times // n)
        parts += [(whole[0], middles[times % n - 1])] if times % n else []
    said = f"{'once' if times == 1 else f'{times} times'}, measured in the motion"
    if times > n:
        said += f": {n} in an excerpt of {(whole[1] - whole[0]) / MOTION_FPS:.1f} s, repeated"
    if each > 1:
        said += f", {each} flights each"
    return Layout(tuple(parts), said, times, is_measured=True, each=each)


def _alike_ends(span: tuple[int, int], movement: Movement) -> tuple[int, int]:
    """The span with both cuts moved by at most SLACK frames to where the poses are most alike.

    And to where they move little.
    """
    start, end = span
    edges = movement.edges
    n = len(edges) - 1
    slack = min(SLACK, (end - start) // 6)
    firsts = np.arange(max(start - slack, 0), start + slack + 1)
    behinds = np.arange(end - slack, min(end + slack, n) + 1)
    distance = np.sum((edges[firsts][:, None] - edges[behinds][None]) ** 2, axis=-1)
    if movement.restless is not None:
        speeds = movement.restless / (movement.restless[start:end].max() + 1e-6)
        distance += UNREST_WEIGHT * (speeds[firsts][:, None] + speeds[behinds - 1][None])
    a, b = np.unravel_index(int(np.argmin(distance)), distance.shape)
    return int(firsts[a]), int(behinds[b])
