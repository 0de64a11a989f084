"""What is wrong with a scene, and what was before it was polished: rule by rule, player by player.

Everything is measured on the motions that came out, not on what polishing meant to do: places and
headings of the pelvis, discs, feet, bones, palms. A rule's value is in a unit that can be read:

    position, line    metres                      threshold: the rule's weight
    direction         degrees                     threshold: the rule's weight
    distance          metres beyond its bounds    threshold: 0
    synchronisation   frames                      threshold: 2

A rule looks at one frame, or, where it holds throughout, at every frame of its own actions; what is
before and behind them no rule looks at. It is judged by its mean over these frames, a distance by
its worst frame. The frame is where it fails most.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from motiondb.generate.contact import contact_speeds
from motiondb.pose import body, features, retarget
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy import rule_table as kinds
from motiondb.scene.energy.rule_table import RuleTable
from motiondb.scene.energy.scene_state import SceneState
from motiondb.scene.language.semantic_rules import RULE_NAMES
from motiondb.scene.polish.polish import Placed, PolishedScene
from motiondb.scene.polish.separation import Overlap, overlaps
from motiondb.scene.timing.timeline import (
    Timeline,
    measure,
    moment_frames,
    sampled_timeline,
    target_places,
    tolerance,
)

_UNITS = {kinds.DIRECTION: "deg", kinds.SYNCHRONISATION: "frames", kinds.UNMET: ""}
_SCALES = {kinds.DIRECTION: 180.0 / math.pi, kinds.SYNCHRONISATION: MOTION_FPS}


@dataclass(frozen=True)
class RuleReport:
    """One rule: whose, of which action, about what, and by how much it fails.

    ``token`` : number of the action in the player's string; ``last`` the one behind the stretch.
    ``frame`` : of the polished scene; ``start``, ``end`` : the frames [start, end) of it that the
    rule looked at. ``before``, ``after`` polishing, and ``threshold``, in ``unit``; ``kept`` :
    whether ``after`` is no more than it. A rule whose role nobody fills is ``unmet`` and never
    kept.
    """

    player: str
    action: str
    token: int
    last: int
    kind: str
    about: str
    unit: str
    threshold: float
    frame: int
    start: int
    end: int
    before: float
    after: float
    kept: bool
    unmet: bool = False


@dataclass(frozen=True)
class FeetReport:
    """Mean speed of feet on the ground, metres a second: in the scene, and in its captures."""

    player: str
    slip: float
    source_slip: float


@dataclass(frozen=True)
class PaceReport:
    """Fastest that a player's pelvis goes on the ground, metres a second, before and after."""

    player: str
    before: float
    after: float


@dataclass(frozen=True)
class SourceRun:
    """Frames [start, end) of a player, the capture's frames that they show, edit and licence."""

    player: str
    start: int
    end: int
    capture: str
    source_start: float
    source_end: float
    edit: str
    licence: str


@dataclass(frozen=True)
class Collision:
    """Two players overlap in frames [start, end), by ``depth`` metres at most."""

    players: tuple[str, str]
    start: int
    end: int
    depth: float


@dataclass(frozen=True, eq=False)
class SceneReport:
    """A scene's report.

    ``n_instances`` clips were put together. ``collisions_before`` polishing and ``collisions``
    after it. ``paces`` : rules that were made true by inhuman speed show there. ``bone_error`` :
    metres by which any bone is ever longer or shorter than the body's. ``ball_gap`` : metres from
    the ball's middle to the nearest palm while it is held, at most; NaN without a ball.
    """

    n_characters: int
    n_instances: int
    n_frames: int
    rules: tuple[RuleReport, ...]
    collisions_before: tuple[Collision, ...]
    collisions: tuple[Collision, ...]
    feet: tuple[FeetReport, ...]
    paces: tuple[PaceReport, ...]
    bone_error: float
    ball_gap: float
    sources: tuple[SourceRun, ...]

    @property
    def broken(self) -> tuple[RuleReport, ...]:
        """The rules that do not hold."""
        return tuple(rule for rule in self.rules if not rule.kept)

    @property
    def clean(self) -> bool:
        """Whether every rule holds and nobody overlaps."""
        return not self.broken and not self.collisions


def report_scene(
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    table: RuleTable,
    polished: PolishedScene,
) -> SceneReport:
    """Measure a polished scene; ``motions`` are those of the captures, by name."""
    before, after = sampled_timeline(state, library), shown_timeline(polished)
    joints = [retarget.motion_positions(placed.motion)[0] for placed in polished.players]
    gap = np.nan
    if polished.ball is not None and np.isfinite(polished.ball.gap).any():
        gap = float(np.nanmax(polished.ball.gap))
    return SceneReport(
        len(polished.players),
        sum(len(player.entries) for player in state.players),
        after.n_frames,
        tuple(_rule(table, number, before, after) for number in range(len(table.rows))),
        _collisions(table, overlaps(table, before)),
        _collisions(table, overlaps(table, after)),
        _feet(polished.players, motions),
        _paces(table, before, after),
        max(_bone_error(positions) for positions in joints),
        gap,
        tuple(run for placed in polished.players for run in _runs(placed)),
    )


def shown_timeline(polished: PolishedScene) -> Timeline:
    """The timeline of a polished scene with the places that its motions show."""
    shown = []
    for placed in polished.players:
        positions, world = retarget.motion_positions(placed.motion)
        shown.append(np.column_stack([positions[:, 0, [0, 2]], features.headings(world)]))
    return replace(polished.timeline, places=np.stack(shown).astype(float))


def _rule(table: RuleTable, number: int, before: Timeline, after: Timeline) -> RuleReport:
    row, rule = table.rows[number], table.rules[number]
    kind = int(row["kind"])
    unmet = kind == kinds.UNMET
    was, now = (_value(table, number, timeline) for timeline in (before, after))
    scale = _SCALES.get(kind, 1.0)
    threshold = 0.0 if unmet else tolerance(row) * scale
    frames = moment_frames(row, after)[: 1 if kind == kinds.SYNCHRONISATION else None]
    actions = table.actions[row["player"]]
    return RuleReport(
        table.players[row["player"]],
        actions[row["first"]],
        int(row["first"]),
        int(row["last"]),
        RULE_NAMES[type(rule)],
        _about(table, row),
        _UNITS.get(kind, "m"),
        threshold,
        now[1],
        int(frames[0]),
        int(frames[-1]) + 1,
        was[0] * scale,
        now[0] * scale,
        not unmet and now[0] * scale <= threshold + 1e-6,
        unmet,
    )


def _value(table: RuleTable, number: int, timeline: Timeline) -> tuple[float, int]:
    """A rule's value and the frame that counts; of a distance the metres beyond its bounds."""
    row = table.rows[number]
    if row["kind"] != kinds.DISTANCE:
        measured = measure(table, number, timeline)
        return measured.value, measured.frame
    frames = moment_frames(row, timeline)
    own = timeline.places[row["player"], frames, :2]
    apart = np.linalg.norm(own - target_places(row, timeline, frames, "target"), axis=1)
    beyond = np.maximum(np.maximum(row["near"] - apart, apart - row["far"]), 0.0)
    worst = int(np.argmax(beyond))
    return float(beyond[worst]), int(frames[worst])


def _about(table: RuleTable, row: np.void) -> str:
    """Whom or what a rule is about, in words."""
    if row["kind"] == kinds.UNMET:
        return "nobody"
    if row["kind"] == kinds.SYNCHRONISATION:
        meant = table.partners[row["partner_first"] : row["partner_last"]].tolist()
        actions = table.actions[row["partner"]]
        names = dict.fromkeys(actions[clip] for clip in meant)
        return f"{table.players[row['partner']]} {'|'.join(names)}"
    if row["target"] == kinds.HEADING:
        return f"{math.degrees(row['x']):.0f} deg"
    first = _end(table, row, "target")
    if row["kind"] == kinds.LINE:
        return f"{first} - {_end(table, row, 'other')}"
    if row["kind"] == kinds.DISTANCE:
        return f"{first}, {row['near']:g} to {row['far']:g} m"
    return first


def _end(table: RuleTable, row: np.void, name: str) -> str:
    if row[name] >= 0:
        return table.players[row[name]]
    prefix = "" if name == "target" else "other_"
    return f"({row[f'{prefix}x']:g}, {row[f'{prefix}z']:g})"


def _collisions(table: RuleTable, found: tuple[Overlap, ...]) -> tuple[Collision, ...]:
    names = table.players
    return tuple(
        Collision((names[o.first], names[o.second]), o.start, o.end, o.depth) for o in found
    )


def _feet(players: tuple[Placed, ...], motions: Mapping[str, Motion]) -> tuple[FeetReport, ...]:
    speeds: dict[str, FloatArray] = {}
    found = []
    for placed in players:
        there = []
        for number, capture in enumerate(placed.captures):
            if capture not in speeds:
                speeds[capture] = contact_speeds(motions[capture])
            own = placed.source_frames[placed.source_numbers == number]
            rows = np.unique(np.clip(np.rint(own), 0, len(speeds[capture]) - 1).astype(int))
            there.append(speeds[capture][rows].ravel())
        slips = _mean(contact_speeds(placed.motion).ravel()), _mean(np.concatenate(there))
        found.append(FeetReport(placed.player, *slips))
    return tuple(found)


def _paces(table: RuleTable, before: Timeline, after: Timeline) -> tuple[PaceReport, ...]:
    peaks = [
        np.linalg.norm(np.diff(timeline.places[:, :, :2], axis=1), axis=2).max(axis=1) * MOTION_FPS
        for timeline in (before, after)
    ]
    return tuple(
        PaceReport(name, float(was), float(now))
        for name, was, now in zip(table.players, *peaks, strict=True)
    )


def _mean(speeds: FloatArray) -> float:
    known = speeds[np.isfinite(speeds)]
    return float(known.mean()) if len(known) else 0.0


def _bone_error(joints: FloatArray) -> float:
    """Metres by which bones differ from the body's, at most: joints (frames, 21, 3)."""
    child = np.arange(1, len(body.JOINTS))
    lengths = np.linalg.norm(joints[:, child] - joints[:, body.PARENTS[child]], axis=2)
    return float(np.abs(lengths - np.linalg.norm(body.OFFSETS[child], axis=1)).max())


def _runs(placed: Placed) -> list[SourceRun]:
    """Stretches of one clip with the same edit, blends aside."""
    edits = [_unblended(edit) for edit in placed.edits]
    clips, numbers = placed.clips.tolist(), placed.source_numbers.tolist()
    keys = list(zip(clips, numbers, edits, strict=True))
    changes = [frame for frame in range(1, len(keys)) if keys[frame] != keys[frame - 1]]
    return [
        SourceRun(
            placed.player,
            start,
            end,
            placed.captures[numbers[start]],
            float(placed.source_frames[start]),
            float(placed.source_frames[end - 1]),
            edits[start],
            placed.licences[numbers[start]],
        )
        for start, end in zip([0, *changes], [*changes, len(keys)], strict=True)
    ]


def _unblended(edit: str) -> str:
    return ", ".join(part for part in edit.split(", ") if not part.startswith("blend "))
