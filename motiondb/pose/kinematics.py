"""Forward kinematics and two-bone inverse kinematics on any skeleton."""

from __future__ import annotations

import numpy as np

from motiondb.pose import rotation
from motiondb.records import Clip, FloatArray, IntArray


def forward(
    parents: IntArray,
    offsets: FloatArray,
    local_rotations: FloatArray,
    root_positions: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Where every joint is and how it is turned.

    Parameters
    ----------
    parents : array (joints,), -1 for the root, parents first.
    offsets : array (joints, 3) or (frames, joints, 3), metres, in the parent's frame.
    local_rotations : array (frames, joints, 4), relative to the parent.
    root_positions : array (frames, 3), metres, world frame.

    Returns
    -------
    positions : array (frames, joints, 3), metres, world frame.
    rotations : array (frames, joints, 4), world frame.
    """
    positions = np.empty((*local_rotations.shape[:2], 3), dtype=local_rotations.dtype)
    rotations = np.empty_like(local_rotations)
    for joint, parent in enumerate(parents):
        if parent < 0:
            positions[:, joint] = root_positions
            rotations[:, joint] = local_rotations[:, joint]
        else:
            offset = offsets[..., joint, :]
            positions[:, joint] = positions[:, parent] + rotation.rotate(
                rotations[:, parent], np.broadcast_to(offset, positions[:, joint].shape)
            )
            rotations[:, joint] = rotation.multiply(rotations[:, parent], local_rotations[:, joint])
    return positions, rotations


def clip_positions(clip: Clip) -> tuple[FloatArray, FloatArray]:
    """World positions (frames, joints, 3), metres, and rotations (frames, joints, 4) of a clip."""
    offsets = clip.skeleton.offsets if clip.joint_positions is None else clip.joint_positions
    return forward(clip.skeleton.parents, offsets, clip.local_rotations, clip.root_positions)
