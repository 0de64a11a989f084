"""The schedule of a scene by a linear program: shorter if no player has to wait.

A sampled scene has every player's clips end to end, and a delay before each string. Players who
wait for another player then have to move more slowly, and a long delay of one player makes all
others stand. With T the frames of the scene at which clips begin and end and at which
synchronisations look, and with L the last of them, a linear program minimises

    c L  +  4 sum |dT - ds|  +  50 sum |T_partner - T_own - lag|  +  sum of pauses / 20
         +  0.3 sum |T_own(t) - T_other(t)|  +  0.02 sum |T(0) - delay|

where ds is the length of a clip. A pause may be inserted between two clips that are both at rest
where they meet. Clips of standing (holding, idling, guarding) may be cut short at almost no cost.
The fifth term keeps together the moments that a rule of place compares: a guard stays with the run
of the guarded player. The change of pace that the program leaves is then spread by
:func:`edit_times`.

Source: M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized Multi-Character Motion Editing", ACM
Transactions on Graphics 28 (2009), which bends time only; cuts, pauses and the program are ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray

# Editing of time so that synchronisations hold.


SLOWEST = 1.25
"""Most frames of the scene per frame of a clip; the inverse is the least. Chosen by hand: faster or
slower looks wrong."""
_DELAY_WEIGHT = 0.05  # Weight of the delays: small, because delays are hardly visible
_MEET_WEIGHT = 100.0  # Weight of the synchronisations: large enough to act as equations


@dataclass(frozen=True)
class Meeting:
    """A synchronisation of two players' source frames."""

    player: int
    own: float  # Source frame of the first player
    partner: int
    theirs: float  # Source frame of the second player
    lag: float  # Frames by which ``theirs`` must come after ``own``
    weight: float = 1.0  # Factor of its cost in a schedule
    at_least: bool = False  # Whether ``theirs`` may come later than that, in a schedule


@dataclass(frozen=True, eq=False)
class TimeMap:
    """Source frames and the frames of the scene at which they are shown, both ascending."""

    source: FloatArray
    shown: FloatArray

    def frame_of(self, source: FloatArray | IntArray) -> FloatArray:
        """Return the frames of the scene at which source frames are shown."""
        return np.interp(source, self.source, self.shown)

    def source_at(self, frames: FloatArray) -> FloatArray:
        """Return the source frames shown at frames; outside, time passes at its usual rate."""
        inside = np.interp(frames, self.shown, self.source)
        early, late = np.minimum(frames - self.shown[0], 0.0), frames - self.shown[-1]
        return inside + early + np.maximum(late, 0.0)

    def slope_at(self, frames: FloatArray) -> FloatArray:
        """Return source frames per frame: array (frames,); 1 before and after the string."""
        slopes = np.diff(self.source) / np.diff(self.shown)
        where = np.searchsorted(self.shown, frames, side="right") - 1
        inside = (where >= 0) & (where < len(slopes))
        return np.where(inside, slopes[np.clip(where, 0, len(slopes) - 1)], 1.0)


def edit_times(
    knots: Sequence[FloatArray], delays: Sequence[float], meetings: Sequence[Meeting]
) -> tuple[TimeMap, ...]:
    """Return the time maps of all players that let meetings happen; see the module.

    `knots`: For every player source frames, ascending from 0 to their last; those of meetings are
    added.

    >>> knots = [np.array([0.0, 10.0]), np.array([0.0, 10.0])]
    >>> maps = edit_times(knots, [0, 4], [Meeting(0, 10, 1, 10, 4.0)])
    >>> [round(float(m.frame_of(10.0)), 6) for m in maps]
    [10.0, 14.0]

    Every player's time is a piecewise linear function from source frames s (0 at the first frame of
    the first clip) to frames T(s) of the scene. Its knots are where clips begin, at instants of
    synchronisations, and at the end. Over all players together, with intervals ds and dT between
    neighbouring knots,

        minimise     sum (dT - ds)^2 / ds  +  w sum (T(0) - delay)^2
        subject to   T_partner - T_own = lag of every synchronisation,
                     dT / ds in [0.8, 1.25],   T >= 0.

    Slopes are bounds, and synchronisations are equations of great weight. If both cannot hold, the
    bounds do, and the error is shared among the equations and shown in the report. Time for which
    everybody waits at first is left out: one player begins at 0.

    Source: M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized Multi-Character Motion Editing", ACM
    Transactions on Graphics 28 (2009): interactions in time are kept by bending time.
    """
    from scipy.optimize import lsq_linear

    sources = [_with_meetings(knots[p], p, meetings) for p in range(len(knots))]
    starts = np.cumsum([0, *(len(source) for source in sources)])
    n_values, n_players = int(starts[-1]), len(sources)
    rows = np.zeros((n_values + len(meetings), n_values))
    wanted = np.zeros(len(rows))
    low, high = np.zeros(n_values), np.full(n_values, np.inf)
    for p, source in enumerate(sources):
        first, length = int(starts[p]), np.diff(source)
        columns = np.arange(first + 1, first + len(source))
        rows[first, first], wanted[first] = _DELAY_WEIGHT, _DELAY_WEIGHT * delays[p]
        rows[columns, columns], wanted[columns] = 1.0 / np.sqrt(length), np.sqrt(length)
        low[columns], high[columns] = length / SLOWEST, length * SLOWEST
    for number, meeting in enumerate(meetings):
        row = rows[n_values + number]
        for p, frame, sign in (
            (meeting.player, meeting.own, -1.0),
            (meeting.partner, meeting.theirs, 1.0),
        ):
            reached = int(np.searchsorted(sources[p], frame)) + 1
            row[starts[p] : starts[p] + reached] += sign
        row *= _MEET_WEIGHT
        wanted[n_values + number] = _MEET_WEIGHT * meeting.lag
    times = lsq_linear(rows, wanted, (low, high), method="bvls", max_iter=10 * n_values).x
    times[starts[:-1]] -= times[starts[:-1]].min()
    return tuple(
        TimeMap(sources[p], np.cumsum(times[starts[p] : starts[p + 1]])) for p in range(n_players)
    )


def _with_meetings(knots: FloatArray, player: int, meetings: Sequence[Meeting]) -> FloatArray:
    frames = [m.own for m in meetings if m.player == player]
    frames += [m.theirs for m in meetings if m.partner == player]
    return np.unique(np.concatenate([np.asarray(knots, dtype=float), frames]))


SHORTEST_PAUSE = 12  # Shortest pause, frames: the transitions into it and out of it take ten
_PACE, _MEET, _PAUSE, _CUT = 4.0, 50.0, 0.05, 0.02
"""Costs per frame of a change of pace, a missed synchronisation, a pause, and a cut of standing.
Only their order matters: synchronisations before pace, pace before pauses and cuts."""
_BESIDE, _DELAY = 0.3, 0.02
"""Costs per frame of the fifth term and of a changed delay. Chosen by hand, below those of pace."""
_HURRY = 0.1  # Cost per frame of the delay of who hurries: more than that of a pause


@dataclass(frozen=True, eq=False)
class Strings:
    """One player's string for a schedule."""

    lengths: IntArray  # (clips,), int: frames of the clips
    least: IntArray  # (clips,), int: frames to which they may be cut
    pauses: IntArray  # (clips,), int: 1 if a pause may follow; the last one never counts
    delay: int  # Frames before the first clip, as sampled
    # (clips,), int: frames that the scene lasts after the end of each clip, for a ball in the air;
    # mostly 0
    after: IntArray
    hurries: bool = False  # Whether to wait before the first clip is worse than behind it


@dataclass(frozen=True, eq=False)
class Schedule:
    """The schedule of one player."""

    lengths: tuple[int, ...]  # Frames of every clip
    pauses: tuple[int, ...]  # Frames of the pause after each, 0 for none
    delay: float  # Frames before the first clip


def schedule(
    strings: Sequence[Strings],
    meetings: Sequence[Meeting],
    beside: Sequence[Meeting] = (),
    frame_cost: float = 1.0,
) -> tuple[Schedule, ...]:
    """Return the schedules of all players; see the module.

    `beside`: Frames of two strings that show the same moment as sampled, or one of which is to come
    before the other; their cost is lower.

    >>> standing = Strings(np.array([100, 30]), np.array([15, 30]), np.array([1, 1]), 0,
    ...     np.array([0, 0]))
    >>> running = Strings(np.array([40]), np.array([40]), np.array([0]), 80, np.array([0]))
    >>> one, other = schedule([standing, running], [Meeting(0, 115.0, 1, 30.0, 0.0)])
    >>> one.lengths, one.pauses, one.delay, other.delay
    ((15, 30), (0, 0), 0.0, 0.0)
    """
    most = [np.where(one.pauses[:-1] > 0, np.inf, 0.0) for one in strings]
    least = [np.zeros(len(one.lengths) - 1) for one in strings]
    problem = _Problem(strings, meetings, beside, frame_cost)
    problem.solve(least, most)
    for player, high, low in zip(range(len(strings)), most, least, strict=True):
        pauses = problem.pauses(player)
        high[pauses < SHORTEST_PAUSE / 2.0] = 0.0
        low[pauses >= SHORTEST_PAUSE / 2.0] = SHORTEST_PAUSE
    problem.solve(least, most)
    return tuple(problem.schedule(player) for player in range(len(strings)))


class _Problem:
    """The linear program: costs, bounds, and equations a x = b."""

    def __init__(
        self,
        strings: Sequence[Strings],
        meetings: Sequence[Meeting],
        beside: Sequence[Meeting],
        frame_cost: float,
    ) -> None:
        self._strings = strings
        self._costs: list[float] = []
        self._bounds: list[tuple[float, float]] = []
        self._rows: list[dict[int, float]] = []
        self._equals: list[float] = []
        self._last = self._column(frame_cost)
        self._marks: list[list[tuple[float, int]]] = []
        self._begins: list[list[int]] = []
        self._ends: list[list[int]] = []
        self._pauses: list[list[int]] = []
        for player in range(len(strings)):
            self._string(player, meetings)
        for meeting in meetings:
            self._meet(meeting, _MEET)
        for meeting in beside:
            self._meet(meeting, _BESIDE)

    def _column(self, cost: float, low: float = 0.0, high: float = np.inf) -> int:
        self._costs.append(cost)
        self._bounds.append((low, high))
        return len(self._costs) - 1

    def _equation(self, terms: dict[int, float], value: float) -> None:
        self._rows.append(terms)
        self._equals.append(value)

    def _off(self, terms: dict[int, float], value: float, costs: tuple[float, float]) -> None:
        """Add the equation terms = value, with slack variables for more and less at their costs."""
        more, less = self._column(costs[0]), self._column(costs[1])
        self._equation({**terms, more: -1.0, less: 1.0}, value)

    def _string(self, player: int, meetings: Sequence[Meeting]) -> None:
        string = self._strings[player]
        met = {m.own for m in meetings if m.player == player}
        met |= {m.theirs for m in meetings if m.partner == player}
        firsts = np.cumsum([0, *string.lengths]).astype(float)
        now = self._column(0.0)
        early = (0.0, (_HURRY, 0.0)) if string.hurries else (float(string.delay), (_DELAY, _DELAY))
        self._off({now: 1.0}, *early)
        self._marks.append([(0.0, now)])
        self._begins.append([])
        self._ends.append([])
        self._pauses.append([])
        for clip in range(len(string.lengths)):
            start, end = firsts[clip], firsts[clip + 1]
            if clip > 0:
                pause, begin = self._column(_PAUSE), self._column(0.0)
                self._pauses[player].append(pause)
                self._equation({begin: 1.0, now: -1.0, pause: -1.0}, 0.0)
                now = begin
                self._marks[player].append((start, now))
            self._begins[player].append(now)
            inner = sorted(frame for frame in met if start < frame < end)
            least = float(string.least[clip]) if not inner else end - start
            for a, b in zip([start, *inner], [*inner, end], strict=True):
                now = self._stretch(now, b - a, least if not inner else b - a)
                self._marks[player].append((b, now))
            self._ends[player].append(now)
            spare = self._column(0.0)
            self._equation({self._last: 1.0, now: -1.0, spare: -1.0}, float(string.after[clip]))

    def _stretch(self, since: int, length: float, least: float) -> int:
        """Add a time ``length`` after another, faster, slower, or cut short to ``least``."""
        until = self._column(0.0)
        slower = self._column(_PACE, 0.0, (SLOWEST - 1.0) * length)
        faster = self._column(_PACE, 0.0, (1.0 - 1.0 / SLOWEST) * length)
        terms = {until: 1.0, since: -1.0, slower: -1.0, faster: 1.0}
        if least < length:
            terms[self._column(_CUT, 0.0, length - least)] = 1.0
        self._equation(terms, length)
        return until

    def _at(self, player: int, frame: float) -> dict[int, float]:
        """Return the time at which a frame of a string as sampled is shown, in columns."""
        marks = self._marks[player]
        frames = [mark for mark, _ in marks]
        k = int(np.clip(np.searchsorted(frames, frame, side="right"), 1, len(marks) - 1))
        (a, first), (b, second) = marks[k - 1], marks[k]
        share = float(np.clip((frame - a) / (b - a), 0.0, 1.0)) if b > a else 0.0
        return {first: 1.0 - share, second: share}

    def _meet(self, meeting: Meeting, cost: float) -> None:
        """Add a meeting; one who has not begun must not be late, one who has ended not early."""
        terms: dict[int, float] = {}
        for player, frame, sign in (
            (meeting.player, meeting.own, -1.0),
            (meeting.partner, meeting.theirs, 1.0),
        ):
            for column, share in self._at(player, frame).items():
                terms[column] = terms.get(column, 0.0) + sign * share
        last = float(np.sum(self._strings[meeting.partner].lengths))
        late = 0.0 if meeting.theirs < 0.0 or meeting.at_least else cost
        early = 0.0 if meeting.theirs > last else cost
        self._off(terms, meeting.lag, (late * meeting.weight, early * meeting.weight))

    def solve(self, least: Sequence[FloatArray], most: Sequence[FloatArray]) -> None:
        """Solve the program with these bounds of the pauses."""
        from scipy.optimize import linprog
        from scipy.sparse import csr_array

        bounds = list(self._bounds)
        for player, columns in enumerate(self._pauses):
            for column, low, high in zip(columns, least[player], most[player], strict=True):
                bounds[column] = (float(low), float(high))
        rows = [r for r, terms in enumerate(self._rows) for _ in terms]
        columns = [c for terms in self._rows for c in terms]
        values = [v for terms in self._rows for v in terms.values()]
        shape = (len(self._rows), len(self._costs))
        result = linprog(
            self._costs,
            A_eq=csr_array((values, (rows, columns)), shape=shape),
            b_eq=self._equals,
            bounds=bounds,
            method="highs-ds",
        )
        self._found: FloatArray = np.asarray(result.x)

    def pauses(self, player: int) -> FloatArray:
        """Return the frames of the pauses between a player's clips."""
        return self._found[self._pauses[player]]

    def schedule(self, player: int) -> Schedule:
        """Return one player's part of the solution, in whole frames."""
        string = self._strings[player]
        lasts = self._found[self._ends[player]] - self._found[self._begins[player]]
        lengths = np.where(string.least < string.lengths, np.rint(lasts), string.lengths).astype(
            int
        )
        lengths = np.clip(lengths, string.least, string.lengths)
        pauses = [int(np.rint(frames)) for frames in self.pauses(player)]
        start = float(self._found[self._begins[player][0]])
        return Schedule(tuple(lengths.tolist()), (*pauses, 0), max(start, 0.0) + 0.0)
