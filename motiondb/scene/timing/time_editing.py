"""Editing of time so that synchronisations hold.

Every player's time is a piecewise linear function from source frames s (0 at the first frame of the
first clip) to frames T(s) of the scene. Its knots are where clips begin, at instants of
synchronisations, and at the end. Over all players together, with intervals ds and dT between
neighbouring knots,

    minimise     sum (dT - ds)^2 / ds  +  w sum (T(0) - delay)^2
    subject to   T_partner - T_own = lag of every synchronisation,   dT / ds in [0.8, 1.25],   T >=
    0.

Slopes are bounds, and synchronisations are equations of great weight. If both cannot hold, the
bounds do, and the error is shared among the equations and shown in the report. Time for which
everybody waits at first is left out: one player begins at 0.

Source: M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized Multi-Character Motion Editing", ACM
Transactions on Graphics 28 (2009): interactions in time are kept by bending time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray

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
