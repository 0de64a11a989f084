"""Polishing: the remaining errors of a sampled scene are removed by editing time, paths and bodies.

The steps are these. Clips and pauses are scheduled and spliced. Time is bent so that
synchronisations hold, and paths so that rules of place hold and no players overlap. The paths
change how long balls fly, so both are repeated. If rules stay broken, everything is repeated with a
longer scene. Waiting players turn to the object. Seams are blended, and feet are held or take small
steps. Hands are moved to the ball, and heads may follow it.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), end of section 3.2, after M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized
Multi-Character Motion Editing", ACM Transactions on Graphics 28 (2009).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene.clips.clip_cutting import compose, inverse
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy import binding as kinds
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.energy import CONTACT_RADIUS, RADIUS
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.activity import Activity
from motiondb.scene.polish.facing import look, turn_who_waits
from motiondb.scene.polish.following import chase
from motiondb.scene.polish.path_editing import COMFORT, Edited, Facing, edit_paths, overlaps
from motiondb.scene.polish.placed import Placed, place_player
from motiondb.scene.polish.splicing import Shelf, Spliced, show, splice, standing
from motiondb.scene.thing.thing_acts import thing_acts
from motiondb.scene.thing.thing_flight import Ball, fly
from motiondb.scene.timing.playing import Part, Playing, lead_in, lead_out
from motiondb.scene.timing.scene_schedule import Scheduled, after_clips, scene_bound, schedule_scene
from motiondb.scene.timing.scheduling import Meeting, TimeMap, edit_times
from motiondb.scene.timing.timeline import Timeline, excess, lag_of, own_places, sampled_timeline

_LEAST, _PATIENCE, _MOST = 2, 3, 8
"""Rounds of editing time and paths in turn: at least, before giving up without progress, at most.
They depend on each other through the flight of balls."""
_MIDDLE = 0.3  # Radius of the discs, m, between :data:`COMFORT` and :data:`RADIUS`
_WAYS = (
    *((frame_cost, radius, True) for radius, frame_cost in product((COMFORT, _MIDDLE), (1.0, 0.5))),
    *product((1.0,), (COMFORT, _MIDDLE), (False,)),
    *product((0.2,), (COMFORT, RADIUS), (True, False)),
    *product((0.0,), (RADIUS,), (True, False)),
)
"""Ways to polish, tried in this order until every rule holds: the cost of a frame of the scene, the
radius of the discs that players keep apart, and whether catchers turn to the ball and guards to the
opponent. Chosen by hand, from the best looking to the most permissive."""
_FAR, _NEARLY = 1.0, 2e-3
"""Limits of the fault of a way (see :func:`_fault`) if polishing is approximate. Above the first,
other radii and facings will not help, and the next schedule is tried at once. Up to the second, the
way is accepted although a rule fails slightly."""
_FASTEST = 7.0
"""Speed of the pelvis, m/s, above which a way counts as faulty: a fast run of untrained people."""
CATCH_FACING = np.radians(75.0)
"""Largest angle between the ball and the heading of its catcher, rad."""
GUARD_FACING = np.radians(45.0)
"""Largest angle between the opponent and the heading of a guard, rad."""
_EVERY = 4  # Frames between those at which guards are checked
_Plan = tuple[tuple[tuple[Part, ...], ...], tuple[float, ...]]
"""The clips and the begin of every player; equal for equal schedules."""


@dataclass(frozen=True, eq=False)
class PolishedScene:
    """A polished scene."""

    players: tuple[Placed, ...]
    ball: Ball | None  # The ball, or None if nobody has one
    timeline: Timeline  # The timeline after editing
    settled: bool  # Whether every rule of place could be satisfied; the report lists the others


def polish(
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    table: RuleTable,
    gaze: bool = True,
    approximate: bool = False,
    follows: bool = True,
    contact: float = CONTACT_RADIUS,
) -> PolishedScene:
    """Return a sampled scene as motions in which its rules hold as far as possible.

    `approximate`: Leave out attempts that seldom help, for a scene that was polished before and
    changed little. `follows`: Whether guards follow when their acts are over. `contact`: Radius of
    the discs of players who are to touch, m.
    """
    best = _best(state, library, motions, table, approximate, contact)
    if follows:
        best = _followed(best, state, library, motions, table)
    timeline = best.edited.timeline
    acts = thing_acts(state, library, table, timeline)
    clock = np.arange(timeline.n_frames, dtype=float)
    rows = [
        clips.rows(times.source_at(clock))
        for clips, times in zip(best.spliced, best.maps, strict=True)
    ]
    waits = np.stack([standing(clips, at) for clips, at in zip(best.spliced, rows, strict=True)])
    turned = turn_who_waits(table, timeline, waits, acts)
    timeline = replace(timeline, places=turned)
    shown = [
        show(clips, at, places)
        for clips, at, places in zip(best.spliced, rows, turned, strict=True)
    ]
    ball, held = fly(acts, shown) if acts else (None, shown)
    if acts and ball is not None and gaze:
        held = look(acts, ball.positions, held)
    players = tuple(
        place_player(
            table.players[n], (one, held[n]), best.spliced[n], best.maps[n], table.actions[n]
        )
        for n, one in enumerate(shown)
    )
    return PolishedScene(players, ball, timeline, best.edited.settled)


@dataclass(frozen=True, eq=False)
class _Tried:
    """A scene with edited time and paths; ``fault`` is how far rules fail, 0 if all hold."""

    spliced: list[Spliced]
    maps: tuple[TimeMap, ...]
    edited: Edited
    fault: float


def _best(
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    table: RuleTable,
    approximate: bool = False,
    contact: float = CONTACT_RADIUS,
) -> _Tried:
    """Return the first of :data:`_WAYS` in which every rule holds, else that of least fault.

    Work shared by several ways is done once: schedules of the same frame cost, their splices, and
    everything if two frame costs lead to the same schedule. With ``approximate`` a schedule that
    fails by far is abandoned, and one that nearly holds is accepted.
    """
    schedules: dict[float, Scheduled] = {}
    spliced: dict[_Plan, list[Spliced]] = {}
    shelf: Shelf = {}
    results: dict[tuple[_Plan, float, bool], _Tried] = {}
    given_up: set[_Plan] = set()
    for frame_cost, radius, facing in _WAYS:
        if frame_cost not in schedules:
            schedules[frame_cost] = schedule_scene(state, library, table, frame_cost)
        scheduled = schedules[frame_cost]
        plan = tuple(played.parts for played in scheduled.playing), scheduled.delays
        if (plan, radius, facing) in results or plan in given_up:
            continue
        if plan not in spliced:
            spliced[plan] = _spliced(state, library, motions, scheduled, shelf, table.activity)
        how = radius, facing, contact
        maps, edited = _edit(state, library, table, (scheduled, spliced[plan]), how)
        tried = _Tried(spliced[plan], maps, edited, _fault(table, edited))
        if tried.fault <= (_NEARLY if approximate else 0.0):
            return tried
        if approximate and tried.fault > _FAR:
            given_up.add(plan)
        results[plan, radius, facing] = tried
    return min(results.values(), key=lambda tried: tried.fault)


def _followed(
    tried: _Tried,
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    table: RuleTable,
) -> _Tried:
    """Return the scene with guards who follow when their acts are over, if no rule suffers."""
    for player, one in enumerate(state.players):
        entries, times = np.asarray(one.entries), tried.edited.timeline
        since = times.end_of(player, len(entries) - 1)
        found = chase(library, table, player, entries, times.places, since)
        if not found:
            continue
        old, clock = tried.spliced[player], np.arange(times.n_frames, dtype=float)
        parts = [part for part in old.parts if part.clip < len(entries)]
        behind = np.concatenate([entries, found])
        for entry in found:
            action = library.terminals[int(library.terminal[entry])]
            lasts = int(library.n_frames[entry])
            parts.append(Part(library.source[entry], lasts, len(entries), action=action))
        out = lead_out(library, behind, times.n_frames, table.activity)
        parts += [one if one.waits else replace(one, action=action) for one in out]
        clips = splice(parts, motions, np.array(one.origin, dtype=float))
        ways = _read(clips.places, clips.rows(tried.maps[player].source_at(clock)))
        places = times.places.copy()
        moved = compose(inverse(ways[since]), ways[since:])
        path = compose(places[player, since], moved)
        places[player, since:] = path + _drift(path, found, library)
        timeline = replace(times, places=places)
        worse = excess(table, timeline) > excess(table, times) + 1e-9
        if worse or len(overlaps(table, timeline)) > len(overlaps(table, times)):
            continue
        spliced = [*tried.spliced[:player], clips, *tried.spliced[player + 1 :]]
        tried = replace(tried, spliced=spliced, edited=replace(tried.edited, timeline=timeline))
    return tried


def _drift(path: FloatArray, entries: Sequence[int], library: ClipLibrary) -> FloatArray:
    """Return by how much a spliced path (frames, 3) is off from its clips, even between middles.

    Blends change steps and turns, which adds up to decimetres over ten clips.
    """
    here, since, knots = path[0], 0, [(0.0, np.zeros(3))]
    for entry in entries:
        middle = int(library.n_frames[entry]) // 2
        if since + middle < len(path):
            off = compose(here, library.path_of(entry)[middle]) - path[since + middle]
            off[2] = (off[2] + np.pi) % (2.0 * np.pi) - np.pi
            knots.append((float(since + middle), off))
        here, since = compose(here, library.step[entry]), since + int(library.n_frames[entry])
    frames, offs = zip(*knots, strict=True)
    clock = np.arange(len(path))
    return np.stack([np.interp(clock, frames, values) for values in np.array(offs).T], axis=1)


def _fault(table: RuleTable, edited: Edited) -> float:
    """Return how far rules fail, plus overlaps, m, and speed above :data:`_FASTEST`, m/s."""
    places = edited.timeline.places[:, :, :2]
    pace = np.linalg.norm(np.diff(places, axis=1), axis=2).max() * MOTION_FPS
    depth = sum(overlap.depth for overlap in overlaps(table, edited.timeline))
    return excess(table, edited.timeline) + depth + max(float(pace) - _FASTEST, 0.0)


def _edit(
    state: SceneState,
    library: ClipLibrary,
    table: RuleTable,
    played: tuple[Scheduled, list[Spliced]],
    how: tuple[float, bool, float],
) -> tuple[tuple[TimeMap, ...], Edited]:
    """Edit time and paths in turn."""
    scheduled, spliced = played
    playing, partners = scheduled.playing, scheduled.partners
    knots = [each.knots.astype(float) for each in playing]
    wished = [
        own_places(player, library)[each.rows]
        for player, each in zip(state.players, playing, strict=True)
    ]
    now, best_excess = sampled_timeline(state, library), np.inf
    for done in range(_MOST):
        meetings = _meetings(table, now, playing, partners)
        maps = edit_times(knots, scheduled.delays, meetings)
        n_frames = _length(state, library, table, maps, playing)
        begins, ends, instants = (
            tuple(
                np.rint(m.frame_of(each)).astype(np.int64)
                for m, each in zip(maps, asked, strict=True)
            )
            for asked in zip(
                *((each.begins, each.ends, each.instants) for each in playing), strict=True
            )
        )
        clock = np.arange(n_frames, dtype=float)
        shown = [m.source_at(clock) for m in maps]
        ways = np.stack(
            [_read(each.places, each.rows(at)) for each, at in zip(spliced, shown, strict=True)]
        )
        best = np.stack([_read(each, at) for each, at in zip(wished, shown, strict=True)])
        before = ways if done == 0 else _lasting(now.places, n_frames)
        times = Timeline(ways, begins, instants, ends)
        facings = _facings(table, partners, times) if how[1] else ()
        measured = replace(times, places=before)
        edited = edit_paths(table, times, best, facings, measured, how[0], how[2])
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
    activity: Activity,
) -> list[Spliced]:
    """Return every player's clips, including those while they wait."""
    longest, spliced = scene_bound(scheduled), []
    for player, playing in zip(state.players, scheduled.playing, strict=True):
        entries = np.asarray(player.entries)
        parts = (
            *lead_in(library, entries, longest, activity),
            *playing.parts,
            *lead_out(library, entries, longest, activity),
        )
        spliced.append(splice(parts, motions, np.array(player.origin, dtype=float), shelf))
    return spliced


def _read(places: FloatArray, at: FloatArray) -> FloatArray:
    """Return places (rows, 3) between rows; the ends are held."""
    rows = np.arange(len(places))
    return np.column_stack([np.interp(at, rows, column) for column in places.T])


def _lasting(places: FloatArray, n_frames: int) -> FloatArray:
    """Return paths (players, any, 3) cut, or with their ends held, to ``n_frames``."""
    return places[:, np.minimum(np.arange(n_frames), places.shape[1] - 1)]


def _length(
    state: SceneState,
    library: ClipLibrary,
    table: RuleTable,
    maps: tuple[TimeMap, ...],
    playing: tuple[Playing, ...],
) -> int:
    """Return the number of frames: until the last player stands and a shot ball is down."""
    length = 0.0
    for p, (times, played) in enumerate(zip(maps, playing, strict=True)):
        ends = times.frame_of(played.ends) + after_clips(library, state, table, p)
        length = max(length, float(ends.max()))
    return int(np.ceil(length - 1e-6))


def _meetings(
    table: RuleTable, now: Timeline, playing: tuple[Playing, ...], partners: tuple[int, ...]
) -> list[Meeting]:
    """Return the synchronisations, with the time that balls fly between the present places."""
    meetings = []
    for number, row in enumerate(table.rows):
        if row["kind"] != kinds.SYNCHRONISATION:
            continue
        player, partner = int(row["player"]), int(row["partner"])
        lag = lag_of(row, now, partners[number]) * MOTION_FPS
        thrown, caught = playing[player].instants[row["first"]], playing[partner].instants
        meets = float(thrown), float(caught[partners[number]])
        meetings.append(Meeting(player, meets[0], partner, meets[1], lag))
    return meetings


def _facings(table: RuleTable, partners: tuple[int, ...], times: Timeline) -> tuple[Facing, ...]:
    """Return the facings of receivers to the passer, and of guards to their opponent."""
    facings: list[Facing] = []
    guards: dict[tuple[int, int], list[IntArray]] = {}
    for number, row in enumerate(table.rows):
        player, clip = int(row["player"]), int(row["first"])
        if row["kind"] == kinds.SYNCHRONISATION and np.isnan(row["lag"]):
            partner = int(row["partner"])
            thrown = times.instants[player][clip : clip + 1]
            caught = times.instants[partner][partners[number], None]
            facings.append(Facing(partner, caught, player, thrown, CATCH_FACING))
        elif (
            row["kind"] == kinds.DISTANCE
            and row["target"] >= 0
            and table.activity.follows(table.actions[player][clip])
        ):
            since, end = int(times.begins[player][clip]), times.end_of(player, clip)
            frames = np.arange(since, max(end, since + 1), _EVERY)
            guards.setdefault((player, int(row["target"])), []).append(frames)
    for (player, target), parts in guards.items():
        frames = np.unique(np.concatenate(parts))  # all at once, so that the turn is continuous
        facings.append(Facing(player, frames, target, frames, GUARD_FACING))
    return tuple(facings)
