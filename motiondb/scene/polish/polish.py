"""Polishing: what sampling leaves over is taken out by editing time, ways and bodies.

In this order: clips and pauses are scheduled and spliced; time is bent so that synchronisations
meet, ways so that rules of place hold and nobody overlaps (which changes how long balls fly, so
both are done again, and all of it in less of a hurry where rules stay broken); who waits turns to
the ball; seams are blended and feet held, or take small steps; hands are brought to the ball, and
heads may follow it.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), end of section 3.2, after M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized
Multi-Character Motion Editing", ACM Transactions on Graphics 28 (2009).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene.ball.ball_acts import ball_acts
from motiondb.scene.ball.ball_flight import Ball, fly
from motiondb.scene.ball.gaze import look
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy import rule_table as kinds
from motiondb.scene.energy.collisions import RADIUS
from motiondb.scene.energy.rule_table import RuleTable
from motiondb.scene.energy.scene_state import SceneState
from motiondb.scene.polish.facing import turn_who_waits
from motiondb.scene.polish.joint_edits import joint_edits
from motiondb.scene.polish.path_editing import Edited, Facing, edit_paths
from motiondb.scene.polish.separation import COMFORT, overlaps
from motiondb.scene.polish.splicing import Shelf, Spliced, show, splice, standing
from motiondb.scene.timing.playing import Part, Playing
from motiondb.scene.timing.scene_schedule import Scheduled, after_clips, scene_bound, schedule_scene
from motiondb.scene.timing.time_editing import Meeting, TimeMap, edit_times
from motiondb.scene.timing.timeline import Timeline, excess, lag_of, own_places, sampled_timeline
from motiondb.scene.timing.waiting import ON_GUARD, lead_in, lead_out

_LEAST, _PATIENCE, _MOST = 2, 3, 8
"""How often time and ways are edited in turn, as balls fly as far as the ways say: at least, before
giving up where it does not get better, and at most."""
_MIDDLE = 0.3
_WAYS = (
    *((hurry, radius, True) for radius, hurry in product((COMFORT, _MIDDLE), (1.0, 0.5))),
    *product((1.0,), (COMFORT, _MIDDLE), (False,)),
    *product((0.2,), (COMFORT, RADIUS), (True, False)),
    *product((0.0,), (RADIUS,), (True, False)),
)
"""What a frame of the scene costs, how far people stay apart, and whether who catches or guards
turns to the ball or the opponent: tried one after another, until every rule holds."""
_FAR, _NEARLY = 1.0, 2e-3
"""For who is in haste: faults that no room or facing mends, so that hurry is eased at once, and
those that are nothing to look for another way for (weights of rules)."""
_FASTEST = 7.0
"""Metres a second that nobody should be edited into."""
CATCH_FACING = np.radians(75.0)
"""Radians from the ball that whoever catches it may face."""
GUARD_FACING = np.radians(45.0)
"""Radians from the opponent that whoever guards may face."""
_EVERY = 4
"""Frames between those at which guards are looked at."""
_Plan = tuple[tuple[tuple[Part, ...], ...], tuple[float, ...]]
"""What everybody plays, and when they begin: equal where two schedules are."""


@dataclass(frozen=True, eq=False)
class Placed:
    """One player of the polished scene, and where each frame comes from.

    Attributes
    ----------
    player : name.
    captures, licences : what frames come from.
    source_numbers : array (frames,), into ``captures``; source_frames : the capture's frame, may
        lie between two.
    warps : array (frames,), frames of the source per frame; 0 where a pose is held, below 0 where
        who waits is shown backwards.
    edits : per frame what was done to it.
    clips : array (frames,), which of the player's actions it belongs to; waiting to the first or
        the last.
    """

    player: str
    motion: Motion
    captures: tuple[str, ...]
    licences: tuple[str, ...]
    source_numbers: IntArray
    source_frames: FloatArray
    warps: FloatArray
    edits: tuple[str, ...]
    clips: IntArray


@dataclass(frozen=True, eq=False)
class PolishedScene:
    """All players, the ball (None where nobody has one), and the timeline that came out.

    ``settled`` says whether every rule of place could be made true; the report says which not.
    """

    players: tuple[Placed, ...]
    ball: Ball | None
    timeline: Timeline
    settled: bool


def polish(
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    table: RuleTable,
    gaze: bool = True,
    haste: bool = False,
) -> PolishedScene:
    """Make a sampled scene fit.

    Parameters
    ----------
    motions : capture name -> motion of the whole capture, of all entries that the state has.
    table : the rules of the state's trees.
    gaze : whether heads follow the ball.
    haste : leave out ways that seldom help, as is enough for a scene that was polished before and
        changed little.

    Raises
    ------
    SceneError : a capture is not among the motions.
    """
    best = _best(state, library, motions, table, haste)
    timeline = best.edited.timeline
    acts = ball_acts(state, library, table, timeline)
    clock = _clock(timeline)
    rows = [
        own.rows(times.source_at(clock)) for own, times in zip(best.spliced, best.maps, strict=True)
    ]
    waits = np.stack([standing(own, at) for own, at in zip(best.spliced, rows, strict=True)])
    turned = turn_who_waits(table, timeline, waits, acts)
    timeline = replace(timeline, places=turned)
    shown = [
        show(own, at, places) for own, at, places in zip(best.spliced, rows, turned, strict=True)
    ]
    ball, held = fly(acts, shown) if acts else (None, shown)
    if acts and ball is not None and gaze:
        held = look(acts, ball.positions, held)
    players = tuple(
        _placed(table.players[n], (one, held[n]), best.spliced[n], best.maps[n], table.actions[n])
        for n, one in enumerate(shown)
    )
    return PolishedScene(players, ball, timeline, best.edited.settled)


@dataclass(frozen=True, eq=False)
class _Tried:
    """A scene in edited time on edited ways; ``fault``: how far rules fail, 0 if all is well."""

    spliced: list[Spliced]
    maps: tuple[TimeMap, ...]
    edited: Edited
    fault: float


def _best(
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    table: RuleTable,
    haste: bool = False,
) -> _Tried:
    """The first of :data:`_WAYS` in which every rule holds, else that in which they fail least.

    What ways have in common is done once: schedules of the same hurry, what they splice, and
    everything where two hurries lead to the same schedule. In haste a plan that fails by far is
    given up, and one that nearly holds is taken.
    """
    schedules: dict[float, Scheduled] = {}
    spliced: dict[_Plan, list[Spliced]] = {}
    shelf: Shelf = {}
    found: dict[tuple[_Plan, float, bool], _Tried] = {}
    given_up: set[_Plan] = set()
    for hurry, radius, facing in _WAYS:
        if hurry not in schedules:
            schedules[hurry] = schedule_scene(state, library, table, hurry)
        scheduled = schedules[hurry]
        plan = tuple(own.parts for own in scheduled.playing), scheduled.delays
        if (plan, radius, facing) in found or plan in given_up:
            continue
        if plan not in spliced:
            spliced[plan] = _spliced(state, library, motions, scheduled, shelf)
        maps, edited = _edit(state, library, table, (scheduled, spliced[plan]), (radius, facing))
        tried = _Tried(spliced[plan], maps, edited, _fault(table, edited))
        if tried.fault <= (_NEARLY if haste else 0.0):
            return tried
        if haste and tried.fault > _FAR:
            given_up.add(plan)
        found[plan, radius, facing] = tried
    return min(found.values(), key=lambda tried: tried.fault)


def _fault(table: RuleTable, edited: Edited) -> float:
    """How far rules fail; more where somebody overlaps, or goes faster than people do."""
    places = edited.timeline.places[:, :, :2]
    pace = np.linalg.norm(np.diff(places, axis=1), axis=2).max() * MOTION_FPS
    depth = sum(overlap.depth for overlap in overlaps(table, edited.timeline))
    return excess(table, edited.timeline) + depth + max(float(pace) - _FASTEST, 0.0)


def _clock(timeline: Timeline) -> FloatArray:
    return np.arange(timeline.n_frames, dtype=float)


def _edit(
    state: SceneState,
    library: ClipLibrary,
    table: RuleTable,
    played: tuple[Scheduled, list[Spliced]],
    how: tuple[float, bool],
) -> tuple[tuple[TimeMap, ...], Edited]:
    """Time and ways, edited in turn."""
    scheduled, spliced = played
    playing, partners = scheduled.playing, scheduled.partners
    knots = [own.knots.astype(float) for own in playing]
    wished = [
        own_places(player, library)[own.rows]
        for player, own in zip(state.players, playing, strict=True)
    ]
    now, best_excess = sampled_timeline(state, library), np.inf
    for done in range(_MOST):
        meetings = _meetings(table, now, playing, partners)
        maps = edit_times(knots, scheduled.delays, meetings)
        n_frames = _length(state, library, table, maps, playing)
        begins, ends, instants = (
            tuple(_rounded(m.frame_of(own)) for m, own in zip(maps, asked, strict=True))
            for asked in zip(
                *((own.begins, own.ends, own.instants) for own in playing), strict=True
            )
        )
        clock = np.arange(n_frames, dtype=float)
        shown = [m.source_at(clock) for m in maps]
        ways = np.stack(
            [_read(own.places, own.rows(at)) for own, at in zip(spliced, shown, strict=True)]
        )
        best = np.stack([_read(own, at) for own, at in zip(wished, shown, strict=True)])
        before = ways if done == 0 else _lasting(now.places, n_frames)
        times = Timeline(ways, begins, instants, ends)
        facings = _facings(table, partners, times) if how[1] else ()
        measured = replace(times, places=before)
        edited = edit_paths(table, times, best, facings, measured, how[0])
        now = edited.timeline
        amiss = excess(table, now)
        better = amiss < 0.9 * best_excess
        if amiss <= best_excess:
            best_excess, kept = amiss, (maps, edited)
        if done + 1 >= _LEAST and (best_excess == 0.0 or (done >= _PATIENCE and not better)):
            break
    return kept


def _spliced(
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    scheduled: Scheduled,
    shelf: Shelf,
) -> list[Spliced]:
    """Everybody's clips, with what they do while they wait."""
    longest, found = scene_bound(scheduled), []
    for player, playing in zip(state.players, scheduled.playing, strict=True):
        entries = np.asarray(player.entries)
        parts = (
            *lead_in(library, entries, longest),
            *playing.parts,
            *lead_out(library, entries, longest),
        )
        found.append(splice(parts, motions, np.array(player.origin, dtype=float), shelf))
    return found


def _read(places: FloatArray, at: FloatArray) -> FloatArray:
    """Places (rows, 3) between rows; the ends are held."""
    rows = np.arange(len(places))
    return np.column_stack([np.interp(at, rows, column) for column in places.T])


def _lasting(places: FloatArray, n_frames: int) -> FloatArray:
    """Ways (players, any, 3) cut, or their ends held, to last ``n_frames``."""
    return places[:, np.minimum(np.arange(n_frames), places.shape[1] - 1)]


def _rounded(frames: FloatArray) -> IntArray:
    return np.rint(frames).astype(np.int64)


def _length(
    state: SceneState,
    library: ClipLibrary,
    table: RuleTable,
    maps: tuple[TimeMap, ...],
    playing: tuple[Playing, ...],
) -> int:
    """Frames of the scene: until the last player stands, and until a shot ball has come down."""
    length = 0.0
    for p, (times, own) in enumerate(zip(maps, playing, strict=True)):
        ends = times.frame_of(own.ends) + after_clips(library, state, table, p)
        length = max(length, float(ends.max()))
    return int(np.ceil(length - 1e-6))


def _meetings(
    table: RuleTable, now: Timeline, playing: tuple[Playing, ...], partners: tuple[int, ...]
) -> list[Meeting]:
    """What is to happen together, with how long balls fly as everybody stands now."""
    found = []
    for number, row in enumerate(table.rows):
        if row["kind"] != kinds.SYNCHRONISATION:
            continue
        own, partner = int(row["player"]), int(row["partner"])
        lag = lag_of(row, now, partners[number]) * MOTION_FPS
        thrown, caught = playing[own].instants[row["first"]], playing[partner].instants
        meets = float(thrown), float(caught[partners[number]])
        found.append(Meeting(own, meets[0], partner, meets[1], lag))
    return found


def _facings(
    table: RuleTable,
    partners: tuple[int, ...],
    times: Timeline,
) -> tuple[Facing, ...]:
    """Who catches faces where the ball comes from, and who guards the opponent, more or less."""
    found: list[Facing] = []
    guards: dict[tuple[int, int], list[IntArray]] = {}
    for number, row in enumerate(table.rows):
        player, clip = int(row["player"]), int(row["first"])
        if row["kind"] == kinds.SYNCHRONISATION and np.isnan(row["lag"]):
            partner = int(row["partner"])
            thrown = times.instants[player][clip : clip + 1]
            caught = times.instants[partner][partners[number], None]
            found.append(Facing(partner, caught, player, thrown, CATCH_FACING))
        elif (
            row["kind"] == kinds.DISTANCE
            and row["target"] >= 0
            and table.actions[player][clip] == ON_GUARD
        ):
            since, end = int(times.begins[player][clip]), times.end_of(player, clip)
            frames = np.arange(since, max(end, since + 1), _EVERY)
            guards.setdefault((player, int(row["target"])), []).append(frames)
    for (player, target), parts in guards.items():
        frames = np.unique(np.concatenate(parts))  # all at once, so that nobody spins between two
        found.append(Facing(player, frames, target, frames, GUARD_FACING))
    return tuple(found)


def _placed(
    name: str,
    bodies: tuple[Motion, Motion],
    spliced: Spliced,
    times: TimeMap,
    actions: tuple[str, ...],
) -> Placed:
    """A player with where each frame comes from; motions before and after arms and head moved."""
    motion, moved = bodies[1], joint_edits(*bodies)
    clock = np.arange(motion.n_frames, dtype=float)
    source = times.source_at(clock)
    at = spliced.rows(source)
    held = at != source + spliced.lead
    frames, rate = spliced.shown_frames(at)
    nearest = np.rint(at).astype(np.int64)
    numbers, shares = spliced.part[nearest].tolist(), spliced.shares[nearest].tolist()
    sources = [part.source for part in spliced.parts]
    captures = tuple(dict.fromkeys(sources[number].capture for number in numbers))
    licence = {source.capture: source.licence for source in sources}
    edits = []
    for frame, (number, share) in enumerate(zip(numbers, shares, strict=True)):
        part = spliced.parts[number]
        said = [part.source.edit, f"blend {share:.2f}" if share < 1.0 else ""]
        said += ["waits" if part.waits else "", "way edited, feet held"]
        said += [edit for edit, frames in moved.items() if frames[frame]]
        edits.append(", ".join(word for word in said if word))
    return Placed(
        name,
        motion,
        captures,
        tuple(licence[capture] for capture in captures),
        np.array([captures.index(sources[number].capture) for number in numbers]),
        frames,
        np.where(held, 0.0, rate * times.slope_at(clock)),
        tuple(edits),
        np.clip([spliced.parts[number].clip for number in numbers], 0, len(actions) - 1),
    )
