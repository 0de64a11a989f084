"""The report of a scene, before and after polishing: rule by rule, player by player.

Everything is measured on the finished motions, not on what polishing intended: places and headings
of the pelvis, discs, feet, bones, palms. The values of rules have readable units:

    position, line    metres                      threshold: the rule's weight
    direction         degrees                     threshold: the rule's weight
    distance          metres beyond its bounds    threshold: 0
    synchronisation   frames                      threshold: 2

A rule is evaluated at one frame, or, if it holds throughout, at every frame of its own actions; no
rule covers the frames before and after them. It is judged by its mean over these frames, a distance
by its worst frame. ``frame`` is where it fails most.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from motiondb.body import body, features, retarget
from motiondb.body.contacts import contact_speeds
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy import binding as kinds
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.semantic_rules import (
    RULE_NAMES,
    SemanticRule,
    SynchronisationRule,
    bounds_text,
)
from motiondb.scene.polish.path_editing import Overlap, overlaps
from motiondb.scene.polish.placed import Placed
from motiondb.scene.polish.polish import PolishedScene
from motiondb.scene.report.report_records import (
    Collision,
    FeetReport,
    LimbReport,
    PaceReport,
    RuleReport,
    SceneReport,
    SeenFault,
    SourceRun,
)
from motiondb.scene.report.seen import guard_reports, kept_reports, seen_faults
from motiondb.scene.report.visible_motion import (
    CROSSING,
    WAITING,
    crossing_limbs,
    foot_jumps,
    impossible_gait,
    impossible_jump,
    natural_ranges,
    near_limbs,
    shown_actions,
)
from motiondb.scene.timing.timeline import (
    Timeline,
    measure,
    moment_frames,
    sampled_timeline,
    target_places,
    tolerance,
)

LEAP = 3.0  # Cost of a seam from which on its blend shows: joints 30 cm apart. Chosen by hand
_UNITS = {kinds.DIRECTION: "deg", kinds.SYNCHRONISATION: "frames", kinds.UNMET: ""}
_SCALES = {kinds.DIRECTION: 180.0 / math.pi, kinds.SYNCHRONISATION: MOTION_FPS}
"""Factors from the units of the energy to degrees and frames."""


def report_scene(
    state: SceneState,
    library: ClipLibrary,
    motions: Mapping[str, Motion],
    table: RuleTable,
    polished: PolishedScene,
) -> SceneReport:
    """Measure a polished scene; ``motions`` are those of whole captures, by name."""
    before, after = sampled_timeline(state, library), shown_timeline(polished)
    joints = [retarget.motion_positions(placed.motion)[0] for placed in polished.players]
    names = [placed.player for placed in polished.players]
    shown = [shown_actions(*one) for one in zip(polished.players, table.actions, strict=True)]
    actions = {one for row in (*table.actions, *shown) for one in row} - {WAITING}
    ranges = natural_ranges(library, motions, actions)
    jumps, impossible = [], []
    for placed, labels, joint_positions in zip(polished.players, shown, joints, strict=True):
        jumps.append(foot_jumps(placed, joint_positions, motions))
        impossible += impossible_gait(placed.player, joint_positions, labels, ranges)
        impossible += impossible_jump(jumps[-1], labels)
    limbs = tuple(near_limbs(names, joints))
    guards = guard_reports(table, after)
    rules = [_rule(table, number, before, after) for number in range(len(table.rows))]
    gap = np.nan
    if polished.ball is not None and np.isfinite(polished.ball.gap).any():
        gap = float(np.nanmax(polished.ball.gap))
    return SceneReport(
        len(polished.players),
        sum(len(player.entries) for player in state.players),
        after.n_frames,
        (*rules, *kept_reports(table, after, joints)),
        _collisions(table, overlaps(table, before)),
        _collisions(table, overlaps(table, after)),
        _feet(polished.players, motions),
        _paces(table, before, after),
        max(_bone_error(positions) for positions in joints),
        gap,
        tuple(run for placed in polished.players for run in _runs(placed)),
        (*impossible, *crossing_limbs(limbs)),
        tuple(jumps),
        limbs,
        tuple(guards),
        (
            *seen_faults(table, after, joints, guards, polished.ball),
            *_touching(table, limbs),
            *_leaps(state, library, table, after),
        ),
    )


def _touching(table: RuleTable, limbs: Sequence[LimbReport]) -> Iterator[SeenFault]:
    """Yield the pairs whose limbs come near, but for those who are to touch or pass through."""
    meet = [{table.players[one], table.players[other]} for one, _, other, _ in table.contacts]
    for pair in limbs:
        if pair.metres >= CROSSING and set(pair.players) not in meet:
            yield SeenFault("limbs", pair.players, pair.frame, pair.frame + 1, pair.metres, "m")


def _leaps(
    state: SceneState, library: ClipLibrary, table: RuleTable, timeline: Timeline
) -> Iterator[SeenFault]:
    """Yield the seams of clips that no blend makes natural, as from sitting to waving."""
    for n, player in enumerate(state.players):
        of = library.seam_class[np.asarray(player.entries)]
        for k in (1 + np.flatnonzero(library.seam[of[:-1], of[1:]] > LEAP)).tolist():
            who = table.players[n], table.actions[n][k - 1], table.actions[n][k]
            begin = int(timeline.begins[n][k])
            cost = float(library.seam[of[k - 1], of[k]])
            yield SeenFault("leap", who, max(begin - 5, 0), begin + 5, cost, "")


def shown_timeline(polished: PolishedScene) -> Timeline:
    """Return the timeline of a polished scene with the places that its motions show."""
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
        _about(table, row, rule),
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
    """Return a rule's value and the frame that counts; for a distance the metres beyond bounds."""
    row = table.rows[number]
    if row["kind"] != kinds.DISTANCE:
        measured = measure(table, number, timeline)
        return measured.value, measured.frame
    frames = moment_frames(row, timeline)
    places = timeline.places[row["player"], frames, :2]
    apart = np.linalg.norm(places - target_places(row, timeline, frames, "target"), axis=1)
    beyond = np.maximum(np.maximum(row["near"] - apart, apart - row["far"]), 0.0)
    worst = int(np.argmax(beyond))
    return float(beyond[worst]), int(frames[worst])


def _about(table: RuleTable, row: np.void, rule: SemanticRule) -> str:
    """Return the player or place that a rule refers to, in words."""
    if row["kind"] == kinds.UNMET:
        if not isinstance(rule, SynchronisationRule):
            return "nobody"
        return f"no {'|'.join(rule.actions)} of {rule.partner}"
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
        return f"{first}, {bounds_text(float(row['near']), float(row['far']))}"
    return first


def _end(table: RuleTable, row: np.void, name: str) -> str:
    if row[name] >= 0:
        return table.players[row[name]]
    prefix = "" if name == "target" else "other_"
    return f"({row[f'{prefix}x']:g}, {row[f'{prefix}z']:g})"


def _collisions(table: RuleTable, overlapping: tuple[Overlap, ...]) -> tuple[Collision, ...]:
    names = table.players
    return tuple(
        Collision((names[o.first], names[o.second]), o.start, o.end, o.depth) for o in overlapping
    )


def _feet(players: tuple[Placed, ...], motions: Mapping[str, Motion]) -> tuple[FeetReport, ...]:
    speeds: dict[str, FloatArray] = {}
    reports = []
    for placed in players:
        there = []
        for number, capture in enumerate(placed.captures):
            if capture not in speeds:
                speeds[capture] = contact_speeds(motions[capture])
            frames = placed.source_frames[placed.source_numbers == number]
            rows = np.unique(np.clip(np.rint(frames), 0, len(speeds[capture]) - 1).astype(int))
            there.append(speeds[capture][rows].ravel())
        slips = _mean(contact_speeds(placed.motion).ravel()), _mean(np.concatenate(there))
        reports.append(FeetReport(placed.player, *slips))
    return tuple(reports)


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
    """Return the largest difference of a bone from its length, m: joints (frames, 21, 3)."""
    child = np.arange(1, len(body.JOINTS))
    lengths = np.linalg.norm(joints[:, child] - joints[:, body.PARENTS[child]], axis=2)
    return float(np.abs(lengths - np.linalg.norm(body.OFFSETS[child], axis=1)).max())


def _runs(placed: Placed) -> list[SourceRun]:
    """Return consecutive frames of one clip with the same edit; blends do not count as edits."""
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
