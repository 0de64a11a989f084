"""Time edited so that what belongs together happens together.

Every player's time is bent piecewise linearly: source frames s (0 at the first clip's first) to
frames T(s) of the scene, with knots where clips begin, at instants that synchronisations are about,
and at the end. Over all players together, with intervals ds, dT of neighbouring knots,

    minimise   sum (dT - ds)^2 / ds  +  w sum (T(0) - delay)^2
    so that    T_partner - T_own = lag of every synchronisation,   dT / ds in [0.8, 1.25],   T >= 0.

Slopes are bounds, synchronisations equations of great weight: where both cannot hold, the bounds
do, and the rest is shared among the equations, to be seen in the report. What everybody waits
for at first is left out: somebody begins at 0.

Source: M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized Multi-Character Motion Editing", ACM
Transactions on Graphics 28 (2009): interactions in time are kept by bending time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray

SLOWEST = 1.25
"""Frames of the scene per frame of a clip, at most; its inverse is the least."""
_DELAY_WEIGHT = 0.05
_MEET_WEIGHT = 100.0


@dataclass(frozen=True)
class Meeting:
    """``partner``'s source frame ``theirs`` is to be ``lag`` frames after ``own`` of ``player``."""

    player: int
    own: float
    partner: int
    theirs: float
    lag: float


@dataclass(frozen=True, eq=False)
class TimeMap:
    """Source frames and the frames of the scene at which they are shown, both ascending."""

    source: FloatArray
    shown: FloatArray

    def frame_of(self, source: FloatArray | IntArray) -> FloatArray:
        """When source frames are shown, in frames of the scene."""
        return np.interp(source, self.source, self.shown)

    def source_at(self, frames: FloatArray) -> FloatArray:
        """What is shown at frames of the scene; before and behind, time goes on as it does."""
        inside = np.interp(frames, self.shown, self.source)
        early, late = np.minimum(frames - self.shown[0], 0.0), frames - self.shown[-1]
        return inside + early + np.maximum(late, 0.0)

    def slope_at(self, frames: FloatArray) -> FloatArray:
        """Source frames per frame of the scene: array (frames,), 1 before and behind."""
        slopes = np.diff(self.source) / np.diff(self.shown)
        where = np.searchsorted(self.shown, frames, side="right") - 1
        inside = (where >= 0) & (where < len(slopes))
        return np.where(inside, slopes[np.clip(where, 0, len(slopes) - 1)], 1.0)


def edit_times(
    knots: Sequence[FloatArray], delays: Sequence[float], meetings: Sequence[Meeting]
) -> tuple[TimeMap, ...]:
    """The time maps of all players that let meetings happen; see the module.

    Parameters
    ----------
    knots : for every player source frames, ascending from 0 to their last; those of meetings are
        added.
    delays : frames at which the players begin as sampled.

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
        own = np.arange(first + 1, first + len(source))
        rows[first, first], wanted[first] = _DELAY_WEIGHT, _DELAY_WEIGHT * delays[p]
        rows[own, own], wanted[own] = 1.0 / np.sqrt(length), np.sqrt(length)
        low[own], high[own] = length / SLOWEST, length * SLOWEST
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
    found = lsq_linear(rows, wanted, (low, high), method="bvls", max_iter=10 * n_values).x
    found[starts[:-1]] -= found[starts[:-1]].min()
    return tuple(
        TimeMap(sources[p], np.cumsum(found[starts[p] : starts[p + 1]])) for p in range(n_players)
    )


def _with_meetings(knots: FloatArray, player: int, meetings: Sequence[Meeting]) -> FloatArray:
    frames = [m.own for m in meetings if m.player == player]
    frames += [m.theirs for m in meetings if m.partner == player]
    return np.unique(np.concatenate([np.asarray(knots, dtype=float), frames]))
