"""A scene frame by frame on one clock, and the values of its semantic rules there.

Sampling works on clips and their places. Polishing bends time and paths, after which a scene is no
longer a string of clips. To measure both in the same way, either becomes a timeline: the place of
every player at every frame of the scene, and the frames at which clips begin and have their events.
Before their string players hold its first pose, after it the last.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 3.1.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.scene.clips.clip_cutting import compose
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy import binding as kinds
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.rule_kernels import values_at
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.expressions import expressions
from motiondb.scene.language.semantic_rules import PASS_SPEED, DistanceRule, bearing

SYNCHRONOUS = 2.0
"""Accepted error of a synchronisation, frames. Chosen by hand: 67 ms, hardly visible."""


@dataclass(frozen=True, eq=False)
class Timeline:
    """The places of all players over time."""

    places: FloatArray  # (players, frames, 3), m and rad: x, z and heading
    # each (clips + 1,), int: for every player the frames at which their clips begin, and after the
    # last the end
    begins: tuple[IntArray, ...]
    # each (clips,), int: for every player the frames of their clips' events
    instants: tuple[IntArray, ...]
    # each (clips,), int: for every player the frames after their clips' last; () if each begins
    # where the one before it ends
    ends: tuple[IntArray, ...] = ()

    @property
    def n_frames(self) -> int:
        """Frames of the scene."""
        return self.places.shape[1]

    def end_of(self, player: int, clip: int) -> int:
        """Return the frame after a clip's last, without the pause after it."""
        ends = self.ends[player] if self.ends else self.begins[player][1:]
        return int(ends[clip])


@dataclass(frozen=True)
class Measured:
    """The value of a rule."""

    value: float
    frame: int  # The frame that counts; of several the worst
    partner_clip: int = -1  # The partner's clip, or -1


def own_places(player: PlayerState, library: ClipLibrary) -> FloatArray:
    """Return the places of a player's frames, clip after clip: array (frames, 3)."""
    at, parts = np.array(player.origin, dtype=float), []
    for entry in np.asarray(player.entries).tolist():
        parts.append(compose(at, library.path_of(entry)))
        at = compose(at, library.step[entry])
    return np.concatenate(parts)


def clip_frames(player: PlayerState, library: ClipLibrary) -> tuple[IntArray, IntArray]:
    """Return where a player's clips begin (clips + 1,) and have their events (clips,).

    Frames count from the first.

    >>> from types import SimpleNamespace as Bare
    >>> library = Bare(n_frames=np.array([4, 9]), event_frame=np.array([-1, 5]))
    >>> [frames.tolist() for frames in clip_frames(Bare(entries=np.array([0, 1])), library)]
    [[0, 4, 13], [1, 9]]
    """
    entries = np.asarray(player.entries)
    lengths = np.asarray(library.n_frames)[entries].astype(np.int64)
    begins = np.concatenate([[0], np.cumsum(lengths)])
    events = np.asarray(library.event_frame)[entries].astype(np.int64)
    return begins, begins[:-1] + np.where(events >= 0, events, (lengths - 1) // 2)


def sampled_timeline(state: SceneState, library: ClipLibrary) -> Timeline:
    """Return the timeline of a scene as it was sampled."""
    frames = [clip_frames(player, library) for player in state.players]
    delays = [player.delay for player in state.players]
    ends = [int(begins[-1]) for begins, _ in frames]
    n_frames = max(delay + end for delay, end in zip(delays, ends, strict=True))
    places = np.empty((len(delays), n_frames, 3))
    for number, player in enumerate(state.players):
        path = own_places(player, library)
        places[number] = path[np.clip(np.arange(n_frames) - player.delay, 0, len(path) - 1)]
    return Timeline(
        places,
        tuple(delay + begins for delay, (begins, _) in zip(delays, frames, strict=True)),
        tuple(delay + instants for delay, (_, instants) in zip(delays, frames, strict=True)),
    )


def moment_frames(row: np.void, timeline: Timeline) -> IntArray:
    """Return the frames at which a rule looks: one, or an interval for throughout."""
    player, first, last = int(row["player"]), int(row["first"]), int(row["last"])
    since = int(timeline.begins[player][first])
    end = max(timeline.end_of(player, last - 1) - 1, since)
    if row["moment"] == kinds.THROUGHOUT:
        return np.arange(since, end + 1)
    if row["moment"] == kinds.AT_START:
        return np.array([since])
    if row["moment"] == kinds.AT_END:
        return np.array([end])
    if row["moment"] == kinds.ON_THE_WAY:
        places = timeline.places[row["player"], since : end + 1, :2]
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
        return np.array([since + int(np.searchsorted(way, row["fraction"] * way[-1] - 1e-9))])
    return np.array([int(timeline.instants[row["player"]][first])])


def target_places(row: np.void, timeline: Timeline, frames: IntArray, name: str) -> FloatArray:
    """Return the places (frames, 2) of the ``target`` or the ``other`` of a rule, m."""
    prefix = "" if name == "target" else "other_"
    if row[name] >= 0:
        return timeline.places[row[name], frames, :2]
    return np.broadcast_to([row[f"{prefix}x"], row[f"{prefix}z"]], (len(frames), 2)).astype(float)


def wanted_headings(row: np.void, timeline: Timeline, frames: IntArray) -> FloatArray:
    """Return the headings (frames,) that a direction rule asks for, rad."""
    if row["target"] == kinds.HEADING:
        return np.full(len(frames), float(row["x"]))
    places = timeline.places[row["player"], frames, :2]
    return bearing(places, target_places(row, timeline, frames, "target")) + row["near"]


def frame_values(row: np.void, timeline: Timeline, frames: IntArray) -> FloatArray:
    """Return f of a rule that is no synchronisation at each of the frames: array (frames,)."""
    if row["kind"] == kinds.UNMET:
        return np.ones(len(frames))
    targets, others = (target_places(row, timeline, frames, name) for name in ("target", "other"))
    places, heading = timeline.places[row["player"], frames], row["target"] == kinds.HEADING
    bounds, values = (float(row["near"]), float(row["far"])), np.empty(len(frames))
    values_at(int(row["kind"]), places, targets, others, bool(heading), bounds, values)
    return values


def lag_of(row: np.void, timeline: Timeline, partner_clip: int) -> float:
    """Return the lag of a synchronisation, s: as stated, or the time that the ball flies."""
    if not math.isnan(row["lag"]):
        return float(row["lag"])
    start = timeline.instants[row["player"]][row["first"]]
    end = timeline.instants[row["partner"]][partner_clip]
    thrown, caught = timeline.places[row["player"], start], timeline.places[row["partner"], end]
    return math.dist(thrown[:2], caught[:2]) / PASS_SPEED


def measure(table: RuleTable, number: int, timeline: Timeline) -> Measured:
    """Return f of rule ``number`` of a table (:class:`RuleTable`): the mean over its frames."""
    row = table.rows[number]
    frames = moment_frames(row, timeline)
    if row["kind"] != kinds.SYNCHRONISATION:
        values = frame_values(row, timeline, frames)
        return Measured(float(values.mean()), int(frames[int(np.argmax(values))]))
    best = Measured(math.inf, int(frames[0]))
    for clip in table.partners[row["partner_first"] : row["partner_last"]].tolist():
        later = float(timeline.instants[row["partner"]][clip] - frames[0]) / MOTION_FPS
        error = abs(later - lag_of(row, timeline, clip))
        if error < best.value:
            best = Measured(error, int(frames[0]), clip)
    return best


def tolerance(row: np.void) -> float:
    """Return the largest accepted f of a rule in a polished scene.

    It is the weight, the deviation that costs 1. A distance must be kept exactly, and a
    synchronisation within :data:`SYNCHRONOUS`.
    """
    if row["kind"] == kinds.DISTANCE:
        return 0.0
    if row["kind"] == kinds.SYNCHRONISATION:
        return SYNCHRONOUS / MOTION_FPS
    return float(row["weight"])


def excess(table: RuleTable, timeline: Timeline) -> float:
    """Return by how much rules fail: the sum of f beyond the tolerances, divided by the weights."""
    total = 0.0
    for number, row in enumerate(table.rows):
        if row["kind"] != kinds.UNMET:
            beyond = measure(table, number, timeline).value - tolerance(row)
            total += max(beyond, 0.0) / float(row["weight"]) if beyond > 1e-9 else 0.0
    return total


def contact_frames(table: RuleTable, timeline: Timeline, around: int) -> NDArray[np.bool_]:
    """Return when two players may touch: array of bool (players, players, frames)."""
    n_players, n_frames, _ = timeline.places.shape
    may = np.zeros((n_players, n_players, n_frames), dtype=bool)
    for one, k, other, m in table.contacts.tolist():
        for instant in (timeline.instants[one][k], timeline.instants[other][m]):
            reach = slice(max(int(instant) - around, 0), int(instant) + around + 1)
            may[one, other, reach] = may[other, one, reach] = True
    return may


# Declared guards: whom they guard, and at what distance.


def guard_bounds(table: RuleTable) -> tuple[float, float] | None:
    """Return the bounds of the grammar's distance for guarding; None if it has none."""
    for said in table.annotations:
        if table.activity.follows(said.symbol) and isinstance(said.rule, DistanceRule):
            return said.rule.near, said.rule.far
    return None


def guarded(table: RuleTable, player: int, before: int | None = None) -> int:
    """Return whom a declared guard guards at last, or before an action; -1 if nobody is.

    It is the opponent of the last element drawn for them about one, else who was declared.
    """
    one = table.diagram.player[table.players[player]]
    if not one.guards or table.activity.leader_of(one.team):
        return -1
    drawn = [target for first, target in attends(table, player) if before is None or first < before]
    return drawn[-1] if drawn else table.players.index(one.guards)


def attends(table: RuleTable, player: int) -> Iterator[tuple[int, int]]:
    """Yield the first action of every element of a player about an opponent, and the opponent."""
    diagram, name = table.diagram, table.players[player]
    items = [item for item in expressions(diagram)[name] if item.element >= 0]
    rows = [first for _, who, first, _ in table.steps if who == player]
    for item, first in zip(items, rows, strict=True):
        own = diagram.elements[item.element].player == name
        if own and item.other and diagram.player[item.other].team != diagram.player[name].team:
            yield first, table.players.index(item.other)
