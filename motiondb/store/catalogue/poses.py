"""Convert a motion to the rows of the table ``motion_frame`` and back."""

from __future__ import annotations

import numpy as np

from motiondb.body import body
from motiondb.records import Float32Array, Motion

POSE_SIZE = 3 + 4 * len(body.JOINTS)
"""Numbers in each frame: 3 for the root position and 4 for the quaternion of each joint."""


def flatten_motion(motion: Motion) -> Float32Array:
    """Put the root position and the joints' quaternions of each frame into one row.

    Parameters
    ----------
    motion : Motion
        The canonical motion.

    Returns
    -------
    array (frames, 87), float32
        World position of the root (x, y, z, metres on the standard body), then the quaternion
        (w, x, y, z) of each joint relative to its parent, in the order of ``body.JOINTS``.
    """
    rotations = motion.local_rotations.reshape(motion.n_frames, 4 * len(body.JOINTS))
    return np.concatenate([motion.root_positions, rotations], axis=1, dtype=np.float32)


def unflatten_motion(
    poses: Float32Array, leg_length: float = 0.8, notes: tuple[str, ...] = ()
) -> Motion:
    """Make a motion from rows of poses; the inverse of :func:`flatten_motion`.

    Parameters
    ----------
    poses : array (frames, 87), float32
        Rows as :func:`flatten_motion` returns them.
    leg_length : float
        The performer's leg length, hip to ankle, metres.
    notes : tuple of str
        Notes of the motion.

    Returns
    -------
    Motion
        The motion. Its arrays are views into ``poses``.

    Examples
    --------
    >>> motion = unflatten_motion(np.zeros((5, POSE_SIZE), dtype=np.float32))
    >>> motion.local_rotations.shape, motion.root_positions.shape
    ((5, 21, 4), (5, 3))
    """
    rotations = poses[:, 3:].reshape(len(poses), len(body.JOINTS), 4)
    return Motion(rotations, poses[:, :3], leg_length, notes)
