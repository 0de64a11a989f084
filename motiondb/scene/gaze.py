"""Heads that follow the ball, as far as necks turn.

Neck and head share the turn: yaw and pitch from the chest's own forward to the ball, clamped and
smoothed over a third of a second. Captures on the canonical body hold the head still, so nothing is
lost.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 6: gaze is added when a scene is done.
"""

from __future__ import annotations

import math

import numpy as np

from motiondb.pose import body, retarget, rotation
from motiondb.records import FloatArray, Motion

MOST_YAW, MOST_PITCH = math.radians(60.0), math.radians(30.0)
_SMOOTH = 5.0
_I = body.INDEX


def follow(motion: Motion, ball: FloatArray) -> Motion:
    """The motion with its head turned to the ball, array (frames, 3), metres."""
    from scipy.ndimage import gaussian_filter1d

    positions, world = retarget.motion_positions(motion)
    chest = rotation.conjugate(world[:, _I["chest"]])
    away = rotation.rotate(chest, ball - positions[:, _I["head"]])
    flat = np.hypot(away[:, 0], away[:, 2])
    ahead = np.clip(flat / 0.3, 0.0, 1.0)  # a ball overhead has no bearing
    yaw = np.clip(np.arctan2(away[:, 0], away[:, 2]), -MOST_YAW, MOST_YAW) * ahead
    behind = np.clip((np.abs(np.arctan2(away[:, 0], away[:, 2])) - 2.4) / 0.7, 0.0, 1.0)
    yaw = yaw * (1.0 - behind)  # nobody turns the head for what is straight behind
    pitch = np.clip(-np.arctan2(away[:, 1], np.maximum(flat, 0.3)), -MOST_PITCH, MOST_PITCH)
    turns = gaussian_filter1d(np.stack([pitch, yaw], axis=1), _SMOOTH, axis=0, mode="nearest") / 2.0
    half = rotation.multiply(
        rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), turns[:, 1]),
        rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), turns[:, 0]),
    )
    local = motion.local_rotations.astype(np.float64)
    for joint in ("neck", "head"):
        local[:, _I[joint]] = rotation.multiply(half, local[:, _I[joint]])
    return Motion(
        rotation.unroll(local).astype(np.float32),
        motion.root_positions,
        motion.leg_length,
        motion.notes,
    )
