"""Forward kinematics and two-bone inverse kinematics on any skeleton.

Going down a skeleton is many small steps over all frames, so there a row of its own holds each
component (w, x, y, z), not a column: half the time, and the same numbers to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.pose import rotation
from motiondb.records import Clip, FloatArray, IntArray


def forward(
    parents: IntArray,
    offsets: FloatArray,
    local_rotations: FloatArray,
    root_positions: FloatArray,
    joints: Sequence[int] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Where every joint is and how it is turned.

    Parameters
    ----------
    parents : array (joints,), -1 for the root, parents first.
    offsets : array (joints, 3) or (frames, joints, 3), metres, in the parent's frame.
    local_rotations : array (frames, joints, 4), relative to the parent.
    root_positions : array (frames, 3), metres, world frame.
    joints : numbers of those that are asked for; default all. What lies on no way to one of them
        is left out, and NaN in what is returned.

    Returns
    -------
    positions : array (frames, joints, 3), metres, world frame.
    rotations : array (frames, joints, 4), world frame.
    """
    n_joints, dtype = local_rotations.shape[1], local_rotations.dtype
    chosen = list(range(n_joints)) if joints is None else _with_ancestors(parents, joints)
    row = {joint: number for number, joint in enumerate(chosen)}
    local = local_rotations if joints is None else local_rotations[:, chosen]
    local = np.ascontiguousarray(local.transpose(1, 2, 0))
    places = np.empty((len(chosen), 3, len(local_rotations)), dtype=dtype)
    turns = np.empty_like(local)
    for joint, own in row.items():
        parent = int(parents[joint])
        if parent < 0:
            places[own], turns[own] = root_positions.T, local[own]
        else:
            before = turns[row[parent]]
            _move(before, offsets[..., joint, :].T, places[row[parent]], places[own])
            _product(before, local[own], turns[own])
    if joints is None:
        return _frames_first(places), _frames_first(turns)
    return _among(places, chosen, n_joints), _among(turns, chosen, n_joints)


def _frames_first(rows: FloatArray) -> FloatArray:
    """Arrays (joints, values, frames) as (frames, joints, values)."""
    return np.ascontiguousarray(rows.transpose(2, 0, 1))


def _among(rows: FloatArray, chosen: list[int], n_joints: int) -> FloatArray:
    """Arrays (chosen, values, frames) as (frames, joints, values), NaN for all others."""
    found = np.full((rows.shape[2], n_joints, rows.shape[1]), np.nan, dtype=rows.dtype)
    found[:, chosen] = rows.transpose(2, 0, 1)
    return found


def _with_ancestors(parents: IntArray, joints: Sequence[int]) -> list[int]:
    """The joints and all that lie between them and the root, ascending."""
    found: set[int] = set()
    for joint in joints:
        while joint >= 0 and joint not in found:
            found.add(int(joint))
            joint = int(parents[joint])
    return sorted(found)


def _product(p: FloatArray, q: FloatArray, into: FloatArray) -> None:
    """As :func:`.rotation.multiply`, of arrays (4, frames)."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    into[0] = pw * qw - px * qx - py * qy - pz * qz
    into[1] = pw * qx + px * qw + py * qz - pz * qy
    into[2] = pw * qy - px * qz + py * qw + pz * qx
    into[3] = pw * qz + px * qy - py * qx + pz * qw


def _move(q: FloatArray, v: FloatArray, since: FloatArray, into: FloatArray) -> None:
    """``since`` (3, frames) and v, (3,) or (3, frames), turned as by :func:`.rotation.rotate`."""
    w, x, y, z = q
    a, b, c = v
    s, t, u = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    into[0] = since[0] + (a + w * s + (y * u - z * t))
    into[1] = since[1] + (b + w * t + (z * s - x * u))
    into[2] = since[2] + (c + w * u + (x * t - y * s))


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
