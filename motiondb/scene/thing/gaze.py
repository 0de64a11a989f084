"""Heads that follow the object, as far as necks turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motiondb.body import body, retarget, rotation
from motiondb.records import FloatArray, Motion
from motiondb.scene.language.activity import GIVE
from motiondb.scene.thing.thing_acts import ThingActs

_I = body.INDEX
MOST_YAW, MOST_PITCH = math.radians(60.0), math.radians(30.0)
"""Largest turns of neck and head together, rad: within what people turn without effort."""
AIMING = 20  # Frames before a release in which the player looks at the target of the ball
_SMOOTH = 5.0  # Standard deviation of the smoothing, frames


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
    heads = [retarget.motion_positions(motion)[0][:, _I["head"]] for motion in motions]
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
    chest = rotation.conjugate(world[:, _I["chest"]])
    away = rotation.rotate(chest, ball - positions[:, _I["head"]])
    flat = np.hypot(away[:, 0], away[:, 2])
    ahead = np.clip(flat / 0.3, 0.0, 1.0)  # a ball overhead has no direction
    yaw = np.clip(np.arctan2(away[:, 0], away[:, 2]), -MOST_YAW, MOST_YAW) * ahead
    behind = np.clip((np.abs(np.arctan2(away[:, 0], away[:, 2])) - 2.4) / 0.7, 0.0, 1.0)
    yaw = yaw * (1.0 - behind)  # people do not turn the head to something straight behind them
    pitch = np.clip(-np.arctan2(away[:, 1], np.maximum(flat, 0.3)), -MOST_PITCH, MOST_PITCH)
    turns = gaussian_filter1d(np.stack([pitch, yaw], axis=1), _SMOOTH, axis=0, mode="nearest") / 2.0
    half = rotation.multiply(
        rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), turns[:, 1]),
        rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), turns[:, 0]),
    )
    local = motion.local_rotations.astype(np.float64)
    for joint in ("neck", "head"):
        local[:, _I[joint]] = rotation.multiply(half, local[:, _I[joint]])
    return replace(motion, local_rotations=rotation.unroll(local).astype(np.float32))
