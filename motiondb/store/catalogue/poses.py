"""Convert a motion to the rows of the table ``motion_frame`` and back."""

from __future__ import annotations

import numpy as np

from motiondb.body import body
from motiondb.records import Float32Array, Motion

POSE_SIZE = 3 + 4 * len(body.JOINTS)
"""Numbers in each frame: 3 for the root position and 4 for the quaternion of each joint."""


def flatten_motion(motion: Motion) -> Float32Array:
    """Put the root position and the joints' quaternions of each frame into one row.

    Shapes: result (frames, 87), float32.
    """
    rotations = motion.local_rotations.reshape(motion.n_frames, 4 * len(body.JOINTS))
    return np.concatenate([motion.root_positions, rotations], axis=1, dtype=np.float32)


def unflatten_motion(
    poses: Float32Array, leg_length: float = 0.8, notes: tuple[str, ...] = ()
) -> Motion:
    """Make a motion from rows of poses; the inverse of :func:`flatten_motion`.

    Shapes: `poses` (frames, 87), float32.

    >>> motion = unflatten_motion(np.zeros((5, POSE_SIZE), dtype=np.float32))
    >>> motion.local_rotations.shape, motion.root_positions.shape
    ((5, 21, 4), (5, 3))
    """
    rotations = poses[:, 3:].reshape(len(poses), len(body.JOINTS), 4)
    return Motion(rotations, poses[:, :3], leg_length, notes)
