"""The schedule of a sampled scene: which clips are cut, and where pauses are.

:mod:`.scheduling` works on numbers; this module takes them from a scene's clips and rules, and
turns its result into the sequence of every player.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import MOTION_FPS, IntArray
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy import binding as kinds
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.rule_kernels import EARLIER
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.activity import SEND, STRIKE, Activity
from motiondb.scene.timing.playing import (
    Pause,
    Playing,
    lead_out,
    least_lengths,
    may_pause,
    pause_entry,
    play,
)
from motiondb.scene.timing.scheduling import SLOWEST, Meeting, Schedule, Strings, schedule
from motiondb.scene.timing.timeline import (
    Timeline,
    clip_frames,
    guard_bounds,
    guarded,
    lag_of,
    measure,
    moment_frames,
    sampled_timeline,
)

AFTER_SENT = 66
"""Frames of a scene after something is sent, in which it flies, falls and bounces. Chosen by hand:
a shot from 7 m needs 40 to the ring."""
_GUARDS = 6.0
"""How much more than other rules of place a guard's keep two players together in a schedule: the
other runs away when the guard has ended, and not before, so that the scene is shorter."""
_ORDERS = 30.0
"""How much more than rules of place the order of steps counts in a schedule: more than a pause, a
change of pace, or frames of the scene. Chosen by hand."""
SETTLING = 8  # Frames of a scene after a last step to rest


@dataclass(frozen=True, eq=False)
class Scheduled:
    """The schedule of a scene."""

    playing: tuple[Playing, ...]  # What every player plays
    delays: tuple[float, ...]  # Frames for which every player waits before that
    # For every rule the partner's clip that a synchronisation refers to, or -1
    partners: tuple[int, ...]


def schedule_scene(
    state: SceneState, library: ClipLibrary, table: RuleTable, frame_cost: float
) -> Scheduled:
    """Return the schedule of a sampled scene; ``frame_cost`` is the cost of a frame of it."""
    now = sampled_timeline(state, library)
    partners = tuple(measure(table, n, now).partner_clip for n in range(len(table.rows)))
    strings = [_string(state, library, table, player) for player in range(len(state.players))]
    frames = [clip_frames(player, library) for player in state.players]
    meetings = []
    for number, row in enumerate(table.rows):
        if row["kind"] == kinds.SYNCHRONISATION:
            thrower, partner = int(row["player"]), int(row["partner"])
            lag = lag_of(row, now, partners[number]) * MOTION_FPS
            thrown = frames[thrower][1][row["first"]]
            caught = frames[partner][1][partners[number]]
            meetings.append(Meeting(thrower, float(thrown), partner, float(caught), lag))
    beside = [*_beside(state, table, now), *_orders(table, frames)]
    scheduled = schedule(strings, meetings, beside, frame_cost)
    playing = tuple(
        _played(state, library, (n, one), table.activity) for n, one in enumerate(scheduled)
    )
    return Scheduled(playing, tuple(one.delay for one in scheduled), partners)


def scene_bound(scheduled: Scheduled) -> int:
    """Return an upper bound of the frames of the scene."""
    longest = max(
        delay + playing.n_frames
        for delay, playing in zip(scheduled.delays, scheduled.playing, strict=True)
    )
    return int(SLOWEST * (longest + AFTER_SENT)) + 1


def after_clips(
    library: ClipLibrary, state: SceneState, table: RuleTable, player: int
) -> list[int]:
    """Return the frames that a scene lasts after the end of each of a player's clips."""
    entries = np.asarray(state.players[player].entries)
    after = [0] * len(entries)
    for clip, action in enumerate(table.actions[player]):
        if table.activity.deed(action) in (SEND, STRIKE):
            entry = int(entries[clip])
            left = int(library.n_frames[entry]) - int(library.event_frame[entry])
            after[clip] = max(AFTER_SENT - left, 0)
    steps = [
        part.n_frames for part in lead_out(library, entries, 1, table.activity) if not part.waits
    ]
    after[-1] = max(after[-1], *(lasts + SETTLING for lasts in steps), 0)
    return after


def _string(state: SceneState, library: ClipLibrary, table: RuleTable, player: int) -> Strings:
    sampled = state.players[player]
    entries = np.asarray(sampled.entries)
    return Strings(
        np.asarray(library.n_frames)[entries].astype(np.int64),
        least_lengths(library, entries, table.activity),
        may_pause(library, entries, table.activity),
        sampled.delay,
        np.array(after_clips(library, state, table, player)),
        _is_awaited(state, table, player),
    )


def _is_awaited(state: SceneState, table: RuleTable, player: int) -> bool:
    """Return whether a declared guard begins farther from whom they guard than the grammar asks."""
    bounds, other = guard_bounds(table), guarded(table, player, 1)
    if bounds is None or other < 0:
        return False
    return math.dist(*(state.players[n].origin[:2] for n in (player, other))) > bounds[1]


def _beside(state: SceneState, table: RuleTable, now: Timeline) -> list[Meeting]:
    """Return the frames at which a rule of place looks from one player's string at another's."""
    meetings = []
    for row in table.rows:
        if row["kind"] in (kinds.SYNCHRONISATION, kinds.UNMET) or row["target"] < 0:
            continue
        player, target = int(row["player"]), int(row["target"])
        delays = state.players[player].delay, state.players[target].delay
        frames = moment_frames(row, now)
        guards = table.activity.follows(table.actions[player][int(row["first"])])
        for frame in dict.fromkeys([int(frames[0]), int(frames[-1])]):
            time, theirs = float(frame - delays[0]), float(frame - delays[1])
            meetings.append(Meeting(player, time, target, theirs, 0.0, _GUARDS if guards else 1.0))
    return meetings


def _orders(table: RuleTable, frames: Sequence[tuple[IntArray, IntArray]]) -> Iterator[Meeting]:
    """Yield the frames of two strings of which one is drawn in a later step (ORDER)."""
    for row in table.wishes[table.wishes["kind"] == kinds.ORDER]:
        player, target, last = int(row["player"]), int(row["target"]), int(row["partner_first"])
        own = frames[player][int(row["moment"] == kinds.AT_EVENT)][row["first"]]
        theirs = frames[target][0][last + 1] if row["fraction"] else frames[target][1][last]
        yield Meeting(player, float(own), target, float(theirs), EARLIER, _ORDERS, at_least=True)


def _played(
    state: SceneState, library: ClipLibrary, of: tuple[int, Schedule], activity: Activity
) -> Playing:
    player, scheduled = of
    sampled = state.players[player]
    pauses = []
    for behind, lasts in enumerate(scheduled.pauses):
        if lasts > 0:
            entry = pause_entry(library, np.asarray(sampled.entries), behind, activity)
            if entry >= 0:
                pauses.append(Pause(behind, library.source[entry], lasts))
    return play(sampled, library, scheduled.lengths, pauses)
