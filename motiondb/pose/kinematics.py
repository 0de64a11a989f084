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


def two_bone(
    hip: FloatArray, knee: FloatArray, ankle: FloatArray, target: FloatArray, ahead: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """World rotations that bring the end of a two-bone chain to a target, keeping its bend plane.

    Parameters
    ----------
    hip, knee, ankle : arrays (frames, 3), metres, the chain as it stands.
    target : array (frames, 3), where the ankle should be; out of reach, it is approached.
    ahead : array (frames, 3), where the knee points when the chain is straight.

    Returns
    -------
    upper, lower : arrays (frames, 4), rotations in the world frame to be applied to the upper and
        to the lower bone as they stand.
    """
    upper_bone, lower_bone = knee - hip, ankle - knee
    a = np.linalg.norm(upper_bone, axis=-1)
    b = np.linalg.norm(lower_bone, axis=-1)
    reach = np.clip(
        np.linalg.norm(target - hip, axis=-1), np.abs(a - b) + 1e-4, (a + b) * (1.0 - 1e-6)
    )
    direction = rotation.normalize(target - hip)
    chain = rotation.between(ankle - hip, direction)
    bend = rotation.rotate(chain, knee - (hip + ankle) / 2.0) + 1e-3 * ahead
    bend = rotation.normalize(bend - np.sum(bend * direction, axis=-1, keepdims=True) * direction)
    along = (a * a - b * b + reach * reach) / (2.0 * reach)
    aside = np.sqrt(np.maximum(a * a - along * along, 0.0))
    new_knee = hip + along[:, None] * direction + aside[:, None] * bend
    new_ankle = hip + reach[:, None] * direction
    upper = rotation.between(upper_bone, new_knee - hip)
    lower = rotation.between(lower_bone, new_ankle - new_knee)
    return upper, lower
