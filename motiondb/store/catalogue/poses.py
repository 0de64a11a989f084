"""A motion as the rows of ``motion_frame``: 3 + 4 x joints floats a frame, and back."""

from __future__ import annotations

import numpy as np

from motiondb.pose import body
from motiondb.records import Float32Array, Motion

POSE_SIZE = 3 + 4 * len(body.JOINTS)


def flatten_motion(motion: Motion) -> Float32Array:
    """Root position, then the joints' quaternions: array (frames, 87), float32."""
    rotations = motion.local_rotations.reshape(motion.n_frames, 4 * len(body.JOINTS))
    return np.concatenate([motion.root_positions, rotations], axis=1, dtype=np.float32)


def unflatten_motion(
    poses: Float32Array, leg_length: float = 0.8, notes: tuple[str, ...] = ()
) -> Motion:
    """The inverse of :func:`flatten_motion`; the arrays are views into ``poses``.

    >>> motion = unflatten_motion(np.zeros((5, POSE_SIZE), dtype=np.float32))
    >>> motion.local_rotations.shape, motion.root_positions.shape
    ((5, 21, 4), (5, 3))
    """
    rotations = poses[:, 3:].reshape(len(poses), len(body.JOINTS), 4)
    return Motion(rotations, poses[:, :3], leg_length, notes)
