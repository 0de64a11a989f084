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
:mod:`.time_editing`.

Source: M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized Multi-Character Motion Editing", ACM
Transactions on Graphics 28 (2009), which bends time only; cuts, pauses and the program are ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray
from motiondb.scene.timing.time_editing import SLOWEST, Meeting

SHORTEST_PAUSE = 12  # Shortest pause, frames: the transitions into it and out of it take ten
_PACE, _MEET, _PAUSE, _CUT = 4.0, 50.0, 0.05, 0.02
"""Costs per frame of a change of pace, a missed synchronisation, a pause, and a cut of standing.
Only their order matters: synchronisations before pace, pace before pauses and cuts."""
_BESIDE, _DELAY = 0.3, 0.02
"""Costs per frame of the fifth term and of a changed delay. Chosen by hand, below those of pace."""


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

    `beside`: Frames of two strings that show the same moment as sampled; their lags are 0.

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
        self._off({now: 1.0}, float(string.delay), (_DELAY, _DELAY))
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
        late = 0.0 if meeting.theirs < 0.0 else cost
        early = 0.0 if meeting.theirs > last else cost
        self._off(terms, meeting.lag, (late, early))

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
