"""Waiting players turn to the object, or to the opponent whom they guard; heads follow the object.

While a player waits, no rule asks for a heading, and the clip of standing that is played has the
heading with which the string begins or ended. With o the angle from there to the focus, the body
turns by

    o - sign(o) 25 degrees      if |o| > 25 degrees, else not at all

(the head does the rest), smoothed. The turn is 0 if the string begins or has just ended, and
increases and decreases at about 100 degrees a second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget, rotation
from motiondb.body.features import runs
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.energy.binding import DISTANCE, RuleTable
from motiondb.scene.language.activity import GIVE
from motiondb.scene.thing.thing_acts import ThingActs
from motiondb.scene.timing.timeline import Timeline

ASIDE = np.radians(25.0)  # How far from the focus a body may face, rad; the head turns the rest
TURNING = np.radians(100.0)  # Speed of a body that turns in place, rad/s
_SMOOTH = 10.0  # Standard deviation of the smoothing, frames
_BRIEF = 50  # Frames of a pause that is too short to turn away and back
MOST_YAW, MOST_PITCH = math.radians(60.0), math.radians(30.0)
"""Largest turns of neck and head together, rad: within what people turn without effort."""
AIMING = 20  # Frames before a release in which the player looks at the target of the ball
_SMOOTH_HEAD = 5.0  # Standard deviation of the smoothing of heads, frames
_LEAST_RAMP, _MOST_RAMP = 15, 80  # Limits of the frames that a turn takes to begin and to end


def turn_who_waits(
    table: RuleTable, timeline: Timeline, waits: NDArray[np.bool_], acts: ThingActs | None
) -> FloatArray:
    """Return the places of a timeline with waiting players turned: array (players, frames, 3).

    A guard faces half way between the opponent and the ball. The player with the ball is not
    turned.

    Shapes: `waits` (players, frames), bool.
    """
    places = timeline.places.copy()
    for player, path in enumerate(timeline.places):
        focus = np.full((timeline.n_frames, 2), np.nan)
        if acts is not None:
            focus = ball_on_ground(acts, timeline.places)
            for held in acts.possessions:
                if held.player == player:
                    focus[held.since : held.until + 1] = np.nan
        guarded = _guarded(table, player)
        if guarded >= 0:
            opponent = timeline.places[guarded, :, :2]
            focus = opponent if acts is None else between(path[:, :2], opponent, focus)
        places[player, :, 2] += turns_to(path, waits[player], focus)
    return places


def _guarded(table: RuleTable, player: int) -> int:
    """Return the player whom a player guards last; -1 for nobody."""
    targets = [
        int(row["target"])
        for row in table.rows
        if row["player"] == player
        and row["kind"] == DISTANCE
        and row["target"] >= 0
        and table.activity.follows(table.actions[player][row["first"]])
    ]
    return targets[-1] if targets else -1


def ball_on_ground(acts: ThingActs, places: FloatArray) -> FloatArray:
    """Return about where the object is, array (frames, 2), m: at its holder's, or on the way.

    Shapes: `places` (players, frames, 3), m and rad.
    """
    n_frames = places.shape[1]
    known, at = [], []
    for possession in acts.possessions:
        frames = np.arange(max(possession.since, 0), min(possession.until, n_frames - 1) + 1)
        known.append(frames)
        at.append(places[possession.player, frames, :2])
    last = acts.possessions[-1] if acts.possessions else None
    if last is None or (last.left and last.aim is not None):
        aim = acts.lies if last is None else last.aim
        until = -2 * _LEAST_RAMP if last is None else last.until
        known.append(np.arange(min(until + 2 * _LEAST_RAMP, n_frames), n_frames + 1))
        spot = (0.0, 0.0) if aim is None else aim.on_the_ground
        if aim is not None and aim.player >= 0:
            spot = tuple(places[aim.player, -1, :2].tolist())
        at.append(np.tile(np.asarray(spot, dtype=float), (len(known[-1]), 1)))
    frames, spots = np.concatenate(known), np.concatenate(at)
    return np.column_stack([np.interp(np.arange(n_frames), frames, s) for s in spots.T])


def between(position: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return a point half way between the directions of two points: arrays (frames, 2), m.

    >>> between(np.zeros((1, 2)), np.array([[5.0, 0.0]]), np.array([[0.0, 2.0]])).tolist()
    [[1.0, 1.0]]
    """
    away = [point - position for point in (first, second)]
    near = [np.linalg.norm(a, axis=1, keepdims=True) for a in away]
    return position + away[0] / np.maximum(near[0], 1e-6) + away[1] / np.maximum(near[1], 1e-6)


def turns_to(places: FloatArray, waits: NDArray[np.bool_], focus: FloatArray) -> FloatArray:
    """Return the turn of a player who waits: array (frames,), rad; 0 elsewhere.

    Shapes: `places` (frames, 3), m and rad; `waits` (frames,), bool; `focus` (frames, 2), m.
    """
    turned = np.zeros(len(places))
    for start, end in runs(waits):
        inner = start > 0, end < len(places)
        if all(inner) and end - start < _BRIEF:
            continue
        turned[start:end] = _turned(places[start:end], focus[start:end], inner)
    return turned


def _turned(places: FloatArray, focus: FloatArray, inner: tuple[bool, bool]) -> FloatArray:
    """Return the turn of one wait; ``inner``: whether clips come before it and after it."""
    from scipy.ndimage import gaussian_filter1d

    away = focus - places[:, :2]
    known = np.isfinite(away[:, 0]) & (np.hypot(away[:, 0], away[:, 1]) > 0.3)
    if not known.any():
        return np.zeros(len(places))
    off = np.zeros(len(places))
    angle = np.arctan2(away[known, 0], away[known, 1]) - places[known, 2]
    off[known] = _unwrapped(angle, backward=inner[1] and not inner[0])
    frames = np.flatnonzero(known)
    off = np.interp(np.arange(len(places)), frames, off[known])
    wanted = np.sign(off) * np.maximum(np.abs(off) - ASIDE, 0.0)
    wanted = gaussian_filter1d(wanted, _SMOOTH, mode="nearest")
    share = np.ones(len(places))
    frames = np.arange(len(places))
    for side, distance in ((0, frames), (1, len(places) - 1 - frames)):
        if inner[side]:
            ramp = np.abs(wanted).max() / TURNING * MOTION_FPS * 1.5
            near = np.clip(distance / np.clip(ramp, _LEAST_RAMP, _MOST_RAMP), 0.0, 1.0)
            share *= near * near * (3.0 - 2.0 * near)
    return np.asarray(wanted * share)


def _unwrapped(angle: FloatArray, backward: bool) -> FloatArray:
    """Return angles without jumps of a full turn, from the principal value of the first or last."""
    first = -1 if backward else 0
    whole = np.unwrap(angle)
    principal = np.mod(whole[first] + np.pi, 2.0 * np.pi) - np.pi
    return np.asarray(whole - whole[first] + principal)


def look(acts: ThingActs, ball: FloatArray, motions: Sequence[Motion]) -> list[Motion]:
    """Return every player's motion with the head turned to what they look at.

    Shapes: `ball` (frames, 3), m.

    Before a release the player looks at the receiver or the target. Neck and
    head share the turn: yaw and pitch from the forward direction of the chest to the ball, clamped
    and smoothed over a third of a second. Captures on the canonical body hold the head still, so
    nothing is lost.

    Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
    Forum 35 (2016), section 6: gaze is added when a scene is done.
    """
    heads = [retarget.motion_positions(motion)[0][:, body.INDEX["head"]] for motion in motions]
    seen = [ball.copy() for _ in motions]
    for number, possession in enumerate(acts.possessions):
        if not possession.left:
            continue
        aim, thrown_at = ball, possession.aim
        if possession.left == GIVE and number + 1 < len(acts.possessions):
            aim = heads[acts.possessions[number + 1].player]
        elif thrown_at is not None and thrown_at.player >= 0:
            aim = heads[thrown_at.player]
        elif thrown_at is not None:
            aim = np.tile(np.array(thrown_at.at), (len(ball), 1))
        frames = np.arange(max(possession.until - AIMING, possession.since), possession.until + 1)
        seen[possession.player][frames] = aim[frames]
    return [follow(motion, spot) for motion, spot in zip(motions, seen, strict=True)]


def follow(motion: Motion, ball: FloatArray) -> Motion:
    """Return the motion with its head turned to a point: array (frames, 3), m."""
    from scipy.ndimage import gaussian_filter1d

    positions, world = retarget.motion_positions(motion)
    chest = rotation.conjugate(world[:, body.INDEX["chest"]])
    away = rotation.rotate(chest, ball - positions[:, body.INDEX["head"]])
    flat = np.hypot(away[:, 0], away[:, 2])
    ahead = np.clip(flat / 0.3, 0.0, 1.0)  # a ball overhead has no direction
    yaw = np.clip(np.arctan2(away[:, 0], away[:, 2]), -MOST_YAW, MOST_YAW) * ahead
    behind = np.clip((np.abs(np.arctan2(away[:, 0], away[:, 2])) - 2.4) / 0.7, 0.0, 1.0)
    yaw = yaw * (1.0 - behind)  # people do not turn the head to something straight behind them
    pitch = np.clip(-np.arctan2(away[:, 1], np.maximum(flat, 0.3)), -MOST_PITCH, MOST_PITCH)
    turns = (
        gaussian_filter1d(np.stack([pitch, yaw], axis=1), _SMOOTH_HEAD, axis=0, mode="nearest")
        / 2.0
    )
    half = rotation.multiply(
        rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), turns[:, 1]),
        rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), turns[:, 0]),
    )
    local = motion.local_rotations.astype(np.float64)
    for joint in ("neck", "head"):
        local[:, body.INDEX[joint]] = rotation.multiply(half, local[:, body.INDEX[joint]])
    return replace(motion, local_rotations=rotation.unroll(local).astype(np.float32))
