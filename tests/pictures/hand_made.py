"""Motions made by hand for the tests of pictures."""

from __future__ import annotations

import numpy as np

from motiondb.body import body, rotation
from motiondb.records import Motion


def rest(n_frames: int, heading: float = 0.0) -> Motion:
    """A body in T-pose, pelvis at hip height, that faces a heading (degrees from +z towards +x)."""
    rotations = np.tile(rotation.IDENTITY, (n_frames, len(body.JOINTS), 1))
    if n_frames:
        rotations[:, 0] = rotation.from_euler([heading], "Y")
    height = body.LEG_LENGTH + body.ANKLE_HEIGHT
    root = np.tile([0.0, height, 0.0], (n_frames, 1))
    return Motion(rotations.astype(np.float32), root.astype(np.float32))


def swing(n_frames: int) -> Motion:
    """Arms down, swinging twice a second by 40 degrees, while the body walks along +z at 1 m/s."""
    still = rest(n_frames)
    rotations = still.local_rotations.astype(float)
    root = still.root_positions.astype(float)
    seconds = np.arange(n_frames) / 30.0
    angle = 40.0 * np.sin(4.0 * np.pi * seconds)
    for side, sign in (("l", -1.0), ("r", 1.0)):
        euler = np.stack([sign * angle, np.full(n_frames, sign * 80.0)], axis=-1)
        rotations[:, body.INDEX[f"{side}_shoulder"]] = rotation.from_euler(euler, "XZ")
    root[:, 2] = seconds
    return Motion(rotations.astype(np.float32), root.astype(np.float32))
