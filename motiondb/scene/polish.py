"""Polishing: what sampling leaves over is taken out by editing time, ways and bodies.

In this order: time is bent so that synchronisations meet, ways so that rules of place hold and
nobody overlaps (which changes how long balls fly, so both are done again), clips are spliced on
the edited ways with seams blended and feet held, hands are brought to the ball, and heads may
follow it.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), end of section 3.2, after M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized
Multi-Character Motion Editing", ACM Transactions on Graphics 28 (2009).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene import rule_table as kinds
from motiondb.scene.ball import Ball, fly
from motiondb.scene.ball_acts import ball_acts
from motiondb.scene.clips import ClipLibrary
from motiondb.scene.gaze import follow
from motiondb.scene.path_editing import Edited, Facing, edit_paths
from motiondb.scene.rule_table import RuleTable
from motiondb.scene.scene_state import PlayerState, SceneState
from motiondb.scene.splicing import Spliced, show, splice
from motiondb.scene.tactics import SHOTS
from motiondb.scene.time_editing import SLOWEST, Meeting, TimeMap, edit_times
from motiondb.scene.timeline import (
    Timeline,
    clip_frames,
    excess,
    lag_of,
    measure,
    own_places,
    sampled_timeline,
)
from motiondb.scene.waiting import waits

AFTER_SHOT = 75
"""Frames of a scene after a shot: the ball flies, falls and bounces."""
_LEAST, _PATIENCE, _MOST = 2, 3, 8
"""How often time and ways are edited in turn, as balls fly as far as the ways say: at least, before
giving up where it does not get better, and at most."""
CATCH_FACING = np.radians(75.0)
"""Radians from the ball that whoever catches it may face."""


@dataclass(frozen=True, eq=False)
class Placed:
    """One player of the polished scene, and where each frame comes from.

    Attributes
    ----------
    player : name.
    captures, licences : what frames come from.
    source_numbers : array (frames,), into ``captures``; source_frames : the capture's frame, may
        lie between two.
    warps : array (frames,), frames of the source per frame; 0 where a pose is held.
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
) -> PolishedScene:
    """Make a sampled scene fit.

    Parameters
    ----------
    motions : capture name -> motion of the whole capture, of all entries that the state has.
    table : the rules of the state's trees.
    gaze : whether heads follow the ball.

    Raises
    ------
    SceneError : a capture is not among the motions.
    """
    spliced = [_spliced(player, library, motions, state) for player in state.players]
    maps, edited = _edit(state, library, table, spliced)
    shown = [
        show(own, own.rows(times.source_at(_clock(edited.timeline))), places)
        for own, times, places in zip(spliced, maps, edited.timeline.places, strict=True)
    ]
    acts = ball_acts(state, library, table, edited.timeline, maps)
    ball, held = fly(acts, shown) if acts else (None, shown)
    if ball is not None and gaze:
        held = [follow(motion, ball.positions) for motion in held]
    players = tuple(
        _placed(table.players[n], held[n], state, library, n, spliced[n], maps[n], edited.timeline)
        for n in range(len(shown))
    )
    return PolishedScene(players, ball, edited.timeline, edited.settled)


def _clock(timeline: Timeline) -> FloatArray:
    return np.arange(timeline.n_frames, dtype=float)


def _edit(
    state: SceneState, library: ClipLibrary, table: RuleTable, spliced: list[Spliced]
) -> tuple[tuple[TimeMap, ...], Edited]:
    """Time and ways, edited in turn."""
    frames = [clip_frames(player, library) for player in state.players]
    knots = [begins.astype(float) for begins, _ in frames]
    delays = [player.delay for player in state.players]
    wished = [own_places(player, library) for player in state.players]
    now = sampled_timeline(state, library)
    partners = [measure(table, n, now).partner_clip for n in range(len(table.rows))]
    best_excess = np.inf
    for done in range(_MOST):
        meetings = _meetings(table, now, frames, partners)
        maps = edit_times(knots, delays, meetings)
        n_frames = _length(table, maps, frames)
        begins = tuple(_rounded(m.frame_of(f[0])) for m, f in zip(maps, frames, strict=True))
        instants = tuple(_rounded(m.frame_of(f[1])) for m, f in zip(maps, frames, strict=True))
        facings = _facings(table, partners, instants)
        clock = np.arange(n_frames, dtype=float)
        shown = [m.source_at(clock) for m in maps]
        ways = np.stack(
            [_read(own.places, own.rows(at)) for own, at in zip(spliced, shown, strict=True)]
        )
        best = np.stack([_read(own, at) for own, at in zip(wished, shown, strict=True)])
        before = ways if done == 0 else _lasting(now.places, n_frames)
        edited = edit_paths(
            table,
            Timeline(ways, begins, instants),
            best,
            facings,
            Timeline(before, begins, instants),
        )
        now = edited.timeline
        amiss = excess(table, now)
        better = amiss < 0.9 * best_excess
        if amiss <= best_excess:
            best_excess, kept = amiss, (maps, edited)
        if done + 1 >= _LEAST and (best_excess == 0.0 or (done >= _PATIENCE and not better)):
            break
    return kept


def _spliced(
    player: PlayerState, library: ClipLibrary, motions: Mapping[str, Motion], state: SceneState
) -> Spliced:
    """One player's clips, with what they do while they wait."""
    entries = np.asarray(player.entries)
    lengths = [
        other.delay + int(library.n_frames[np.asarray(other.entries)].sum())
        for other in state.players
    ]
    own = int(library.n_frames[entries].sum())
    longest = int(SLOWEST * (max(lengths) + AFTER_SHOT)) + 1
    lead, tail = waits(library, entries, player.delay + longest, max(longest - own, 0) + longest)
    sources = [library.source[entry] for entry in entries.tolist()]
    return splice(sources, motions, np.array(player.origin, dtype=float), lead, tail)


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
    table: RuleTable, maps: tuple[TimeMap, ...], frames: list[tuple[IntArray, IntArray]]
) -> int:
    """Frames of the scene: until the last player's last, and until a shot ball has come down."""
    length = max(float(times.shown[-1]) for times in maps)
    for p, actions in enumerate(table.actions):
        for k, action in enumerate(actions):
            if action in SHOTS:
                release = float(maps[p].frame_of(frames[p][1][k]))
                length = max(length, release + AFTER_SHOT)
    return int(np.ceil(length - 1e-6))


def _meetings(
    table: RuleTable,
    now: Timeline,
    frames: list[tuple[IntArray, IntArray]],
    partners: list[int],
) -> list[Meeting]:
    """What is to happen together, with how long balls fly as everybody stands now."""
    found = []
    for number, row in enumerate(table.rows):
        if row["kind"] != kinds.SYNCHRONISATION:
            continue
        own, partner = int(row["player"]), int(row["partner"])
        lag = lag_of(row, now, partners[number]) * MOTION_FPS
        moments = float(frames[own][1][row["first"]]), float(frames[partner][1][partners[number]])
        found.append(Meeting(own, moments[0], partner, moments[1], lag))
    return found


def _facings(
    table: RuleTable, partners: list[int], instants: tuple[IntArray, ...]
) -> tuple[Facing, ...]:
    """Who catches faces where the ball comes from, more or less."""
    found = []
    for number, row in enumerate(table.rows):
        if row["kind"] == kinds.SYNCHRONISATION and np.isnan(row["lag"]):
            thrown = int(instants[row["player"]][row["first"]])
            caught = int(instants[row["partner"]][partners[number]])
            found.append(
                Facing(int(row["partner"]), caught, int(row["player"]), thrown, CATCH_FACING)
            )
    return tuple(found)


def _placed(
    name: str,
    motion: Motion,
    state: SceneState,
    library: ClipLibrary,
    number: int,
    spliced: Spliced,
    times: TimeMap,
    timeline: Timeline,
) -> Placed:
    """A player with where each frame comes from."""
    entries = np.asarray(state.players[number].entries)
    clock = _clock(timeline)
    source = times.source_at(clock)
    at = spliced.rows(source)
    held = at != source + spliced.lead
    nearest = np.rint(at).astype(np.int64)
    clips = spliced.clips[nearest]
    sources = {k: library.source[entry] for k, entry in enumerate(entries.tolist())}
    for wait, which in zip(spliced.waits, (-1, len(entries)), strict=True):
        if wait is not None:
            sources[which] = wait.source
    captures = tuple(dict.fromkeys(source.capture for source in sources.values()))
    licence = {source.capture: source.licence for source in sources.values()}
    edits = []
    for clip, share in zip(clips.tolist(), spliced.shares[nearest].tolist(), strict=True):
        said = [sources[clip].edit, f"blend {share:.2f}" if share < 1.0 else ""]
        said += ["" if 0 <= clip < len(entries) else "waits", "way edited, feet held"]
        edits.append(", ".join(part for part in said if part))
    return Placed(
        name,
        motion,
        captures,
        tuple(licence[capture] for capture in captures),
        np.array([captures.index(sources[clip].capture) for clip in clips.tolist()]),
        _read(spliced.source_frames[:, None].astype(float), at)[:, 0],
        np.where(held, 0.0, times.slope_at(clock)),
        tuple(edits),
        np.clip(clips, 0, len(entries) - 1),
    )
