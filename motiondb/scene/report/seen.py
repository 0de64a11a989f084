"""What a viewer sees at once, measured in the written frames: nothing here looks at the sampling.

Declared guards over the whole scene; what the diagram asks players to keep up, from one step to
another; people who stand; poses that are held without moving; things that miss their target or pass
through somebody.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body
from motiondb.body.features import runs
from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.scene.energy.binding import ORDER, RuleTable
from motiondb.scene.language.semantic_rules import bounds_text
from motiondb.scene.language.tactics import Stretch
from motiondb.scene.report.report_records import GuardReport, RuleReport, SeenFault
from motiondb.scene.report.visible_motion import segment_distances, travel_speeds
from motiondb.scene.thing.thing_flight import Ball
from motiondb.scene.timing.timeline import (
    Timeline,
    attends,
    guard_bounds,
    guarded,
    moment_frames,
)

TOO_FAR = 1.0 / 3.0
"""Share of the scene in which a declared guard may be out of the bounds of the grammar before it is
a fault. Chosen by hand."""
STANDS = 0.15  # Mean speed of the pelvis over half a second, m/s, below which somebody stands
SITS = 0.7  # Height of the pelvis, m, below which somebody sits or lies: nobody misses their steps
LONG, MOSTLY = 4.0, 0.5
"""Seconds of standing, and its share of the scene, from which on it is a fault."""
HELD, HELD_FOR = 0.02, 1.0
"""Speed of the fastest joint, m/s, below which a pose is held, and seconds from which it counts."""
UNREACHED = 0.5  # Metres from hands and feet from which on nobody takes or strikes an object
BESIDE = 0.5  # Metres from the edge of a chair from which on somebody has left it
LATE = 3  # Frames by which a step may come after a later one of somebody else: nobody sees them
MOVING_GAP = 1.0  # Seconds that somebody who keeps moving may stand
_THICK = 0.05  # Radius of limbs that things must not pass through, m
_TRUNK = np.array([
    [body.INDEX[a], body.INDEX[b]]
    for a, b in (("neck", "pelvis"), ("l_hip", "l_knee"), ("r_hip", "r_knee"))
])  # fmt: skip
_FINE = 4  # Times within a frame at which things that fly are looked at


def guard_reports(table: RuleTable, timeline: Timeline) -> list[GuardReport]:
    """Return how far declared guards are from whom they guard, over all frames of the scene.

    The bounds are those of the grammar's distance for guarding, if it has one. Who is drawn to
    guard or run at another leaves whom they were declared to guard.
    """
    reports = []
    near, far = guard_bounds(table) or (0.0, np.inf)
    for one, name in enumerate(table.players):
        if guarded(table, one) < 0:
            continue
        targets = _guarded(table, timeline, one)
        other = int(np.bincount(targets).argmax())
        places = timeline.places[:, :, :2]
        now = places[targets, np.arange(timeline.n_frames)]
        apart = np.linalg.norm(places[one] - now, axis=1)
        frame = int(np.argmax(apart))
        looked = [
            timeline.end_of(one, clip) - int(timeline.begins[one][clip])
            for clip, action in enumerate(table.actions[one])
            if table.activity.follows(action)
        ]
        reports.append(
            GuardReport(
                name,
                table.players[other],
                near,
                far if np.isfinite(far) else None,
                sum(looked),
                float(((apart < near) | (apart > far)).mean()),
                float(apart[frame]),
                frame,
            )
        )
    return reports


def _guarded(table: RuleTable, timeline: Timeline, player: int) -> IntArray:
    """Return whom a guard guards in every frame: who was declared, until another is drawn."""
    targets = np.full(timeline.n_frames, guarded(table, player, 1))
    for first, target in attends(table, player):
        if first > 0:
            targets[int(timeline.begins[player][first]) :] = target
    return targets


def kept_reports(
    table: RuleTable, timeline: Timeline, joints: Sequence[FloatArray]
) -> Iterator[RuleReport]:
    """Yield what the diagram asks players to keep up, measured in all frames between its steps."""
    for kept in table.diagram.stretches:
        start, end = _frames_of(kept, table, timeline)
        player = table.players.index(kept.player)
        if kept.other:
            places = timeline.places[:, start:end, :2]
            apart = np.hypot(*(places[player] - places[table.players.index(kept.other)]).T)
            beyond = np.maximum(np.maximum(kept.near - apart, apart - kept.far), 0.0)
            worst = int(np.argmax(beyond))
            value, frame, limit = float(beyond[worst]), start + worst, 0.0
            about = f"{kept.other}, {bounds_text(kept.near, kept.far)}"
            unit = "m"
        else:
            stands = (travel_speeds(joints[player]) < STANDS) & ~_acting(table, timeline, player)
            stands = stands[start:end]
            longest = max(runs(stands), key=lambda run: run[1] - run[0], default=(0, 0))
            value, frame = (longest[1] - longest[0]) / MOTION_FPS, start + longest[0]
            about, unit, limit = "moving", "s", MOVING_GAP
        yield RuleReport(
            kept.player, "", 0, 0, "keeps", about, unit, limit, frame, start, end, value, value,
            value <= limit + 1e-6,
        )  # fmt: skip


def _frames_of(kept: Stretch, table: RuleTable, timeline: Timeline) -> tuple[int, int]:
    """Return the frames [start, end) from the first to the last step of a stretch."""
    start, end = 0, timeline.n_frames
    if not kept.last and not kept.other:  # nobody runs on while a ball rolls away
        end = max(timeline.end_of(p, len(row) - 1) for p, row in enumerate(table.actions))
    of = [row for row in table.steps if kept.first <= row[0] <= (kept.last or row[0])]
    if kept.last and of:
        start = min(int(timeline.begins[player][first]) for _, player, first, _ in of)
        end = max(timeline.end_of(player, last - 1) for _, player, _, last in of)
    return start, max(end, start + 1)


def seen_faults(
    table: RuleTable,
    timeline: Timeline,
    joints: Sequence[FloatArray],
    guards: Sequence[GuardReport],
    ball: Ball | None,
) -> Iterator[SeenFault]:
    """Yield what a viewer sees at once although no rule is about it."""
    n_frames = len(joints[0])
    yield from _out_of_order(table, timeline)
    for guard in guards:
        if guard.outside > TOO_FAR:
            share = guard.outside
            yield SeenFault("guard", (guard.player, guard.target), 0, n_frames, share, "of frames")
    for player, (name, positions) in enumerate(zip(table.players, joints, strict=True)):
        yield from _standing(name, positions, _acting(table, timeline, player))
        yield from _through_places(table, timeline, player, positions)
    if ball is not None:
        yield from _misses(table, ball)
        yield from _passes_through(table, joints, ball)


def _acting(table: RuleTable, timeline: Timeline, player: int) -> NDArray[np.bool_]:
    """Return when a player does what is drawn, but for resting: array (frames,)."""
    rests = {rest.action for rest in table.activity.rests}
    acts = np.zeros(timeline.n_frames, dtype=bool)
    for _, who, first, last in table.steps:
        if who == player and not rests.issuperset(table.actions[who][first:last]):
            acts[int(timeline.begins[who][first]) : timeline.end_of(who, last - 1)] = True
    return acts


def _out_of_order(table: RuleTable, timeline: Timeline) -> Iterator[SeenFault]:
    """Yield who does a step only after somebody has done a later one (ORDER)."""
    steps = {(player, last - 1): step for step, player, _, last in table.steps}
    for row in table.wishes[table.wishes["kind"] == ORDER]:
        target, clip = int(row["target"]), int(row["partner_first"])
        own = int(moment_frames(row, timeline)[0])
        done = timeline.end_of(target, clip) if row["fraction"] else timeline.instants[target][clip]
        if own > done + LATE:
            who = table.players[row["player"]], table.players[target]
            yield SeenFault("order", who, int(done), own, float(steps[target, clip]), "step")


def _through_places(
    table: RuleTable, timeline: Timeline, player: int, joints: FloatArray
) -> Iterator[SeenFault]:
    """Yield the places that stand on the ground, such as tables, with somebody in the middle.

    Who sits down on one is there rightly, until they are away from it.
    """
    trunk = joints[:, _TRUNK]
    for place in table.places.values():
        if place.at is None or not place.is_in_the_way:
            continue
        above, below = trunk[:, :, 0], trunk[:, :, 1]
        rise = above[..., 1] - below[..., 1]
        share = (place.height - below[..., 1]) / np.where(np.abs(rise) < 1e-6, 1e-6, rise)
        at = below + share[..., None] * (above - below)
        apart = np.hypot(at[..., 0] - place.at.x, at[..., 2] - place.at.z)
        inside = (share >= 0.0) & (share <= 1.0) & (apart < place.width / 2.0 - _THICK)
        through = np.asarray(inside.any(axis=1))
        away = np.hypot(joints[:, 0, 0] - place.at.x, joints[:, 0, 2] - place.at.z)
        for row in table.rows[place.leading_into(table.rows) & (table.rows["player"] == player)]:
            since = int(timeline.begins[player][row["first"]])
            gone = np.flatnonzero(away[since:] > place.width / 2.0 + BESIDE)
            through[since : since + int(gone[0]) if len(gone) else None] = False
        for start, end in runs(through):
            players = table.players[player], place.name
            yield SeenFault("place", players, start, end, place.height, "m")


def _standing(name: str, joints: FloatArray, acts: NDArray[np.bool_]) -> Iterator[SeenFault]:
    """Yield the longest time in which somebody stands, and every pose that is held.

    Whoever does in place what is drawn (``acts``, by frame), such as clapping, does not stand.
    """
    n_frames = len(joints)
    stands = (travel_speeds(joints) < STANDS) & (joints[:, 0, 1] > SITS) & ~acts
    start, end = max(runs(stands), key=lambda run: run[1] - run[0], default=(0, 0))
    if end - start > max(LONG * MOTION_FPS, MOSTLY * n_frames):
        yield SeenFault("stands", (name,), start, end, (end - start) / MOTION_FPS, "s")
    speeds = np.linalg.norm(np.diff(joints, axis=0), axis=2).max(axis=1) * MOTION_FPS
    for start, end in runs(speeds < HELD):
        if end - start > HELD_FOR * MOTION_FPS:
            yield SeenFault("held pose", (name,), start, end, (end - start) / MOTION_FPS, "s")


def _misses(table: RuleTable, ball: Ball) -> Iterator[SeenFault]:
    """Yield what was sent and does not come within its target, and what nobody reaches."""
    for sent in ball.sent:
        way = ball.positions[sent.frame :]
        steps = np.linspace(0.0, 1.0, 8, endpoint=False)[:, None, None]
        fine = (way[:-1] + steps * np.diff(way, axis=0)).reshape(-1, 3)
        apart = float(np.linalg.norm(fine - np.array(sent.at), axis=1).min())
        if apart > sent.width / 2.0 + 0.05:
            who = table.players[sent.player]
            yield SeenFault(
                "misses", (who, sent.target), sent.frame, len(ball.positions), apart, "m"
            )
    for player, frame, apart in ball.met:
        if apart > UNREACHED:
            yield SeenFault("reach", (table.players[player],), frame, frame + 1, apart, "m")


def _passes_through(
    table: RuleTable, joints: Sequence[FloatArray], ball: Ball
) -> Iterator[SeenFault]:
    """Yield the players through whom the object passes, but for those who hold it then."""
    for player, name in enumerate(table.players):
        near = _bone_distance(_finely(ball.positions), _finely(joints[player]))
        near = near.reshape(-1, _FINE).min(axis=1)
        inside = near < ball.size / 2.0 - _THICK
        struck = [sent.frame for sent in ball.sent if sent.player == player]
        struck += [frame for who, frame, _ in ball.met if who == player]
        for who, since, until in ball.helpers:
            struck += range(since, until + 1) if who == player else ()
        # hands come to it before, and leave it afterwards
        for frame in (*np.flatnonzero(ball.holder == player), *struck):
            inside[max(frame - 12, 0) : frame + 13] = False
        for start, end in runs(inside):
            depth = float(ball.size / 2.0 - near[start:end].min())
            yield SeenFault("object", (name,), start, end, depth, "m")


def _finely(values: FloatArray) -> FloatArray:
    """Return values (frames, ...) with the values between frames, for what flies fast."""
    after = np.concatenate([values[1:], values[-1:]])
    shares = np.arange(_FINE).reshape(-1, *[1] * (values.ndim - 1)) / _FINE
    fine = values[:, None] + shares * (after - values)[:, None]
    return np.asarray(fine.reshape(-1, *values.shape[1:]))


def _bone_distance(points: FloatArray, joints: FloatArray) -> FloatArray:
    """Return distances, m, of points (frames, 3) to the nearest bone of joints (frames, 21, 3)."""
    above, at = joints[:, body.PARENTS[1:]], points[:, None]
    return np.asarray(segment_distances(at, at, above, joints[:, 1:]).min(axis=1))
