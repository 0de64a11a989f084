"""Forward kinematics, two-bone inverse kinematics, and other worlds, on any skeleton.

Forward kinematics is many small steps over all frames. There each component (w, x, y, z) is one row
of memory, not one column: this takes half the time and gives the same numbers to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motiondb.body import rotation
from motiondb.records import Clip, FloatArray, IntArray

_FOLDED, _STRAIGHT = 1e-4, 1.0 - 1e-6
"""A chain is never folded closer than the first (metres) nor stretched beyond the second (share of
its length), where the direction of the bend is undefined."""
_BEND = 1e-3  # Metres by which a straight chain is taken to bend ahead: small against any real bend


def forward(
    parents: IntArray,
    offsets: FloatArray,
    local_rotations: FloatArray,
    root_positions: FloatArray,
    joints: Sequence[int] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Compute the position and the rotation of every joint in the world.

    Shapes: `parents` (joints,); `offsets` (joints, 3) or (frames, joints, 3); `local_rotations`
    (frames, joints, 4); `root_positions` (frames, 3); result (frames, joints, 3).

    `joints`: Numbers of the joints that are needed; None: all. Joints that are neither needed nor
    ancestors of one are not computed and are NaN in the result.
    """
    n_joints, dtype = local_rotations.shape[1], local_rotations.dtype
    chosen = list(range(n_joints)) if joints is None else _with_ancestors(parents, joints)
    row = {joint: place for place, joint in enumerate(chosen)}
    local = local_rotations if joints is None else local_rotations[:, chosen]
    local = np.ascontiguousarray(local.transpose(1, 2, 0))
    places = np.empty((len(chosen), 3, len(local_rotations)), dtype=dtype)
    turns = np.empty_like(local)
    for joint, number in row.items():
        parent = int(parents[joint])
        if parent < 0:
            places[number], turns[number] = root_positions.T, local[number]
        else:
            before = turns[row[parent]]
            _move(before, offsets[..., joint, :].T, places[row[parent]], places[number])
            _product(before, local[number], turns[number])
    if joints is None:
        return _frames_first(places), _frames_first(turns)
    return _among(places, chosen, n_joints), _among(turns, chosen, n_joints)


def forward_kinematics(
    parents: IntArray, offsets: FloatArray, local_rotations: FloatArray, root_positions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Compute where the joints of any skeleton are in the world, and how they are turned.

    Parameters
    ----------
    parents : array (joints,)
        Number of the parent of every joint, -1 for the root; parents come before children.
    offsets : array (joints, 3) or (frames, joints, 3), metres
        From the parent, in the parent's frame.
    local_rotations : array (frames, joints, 4)
        Unit quaternions w, x, y, z, relative to the parent.
    root_positions : array (frames, 3), metres
        In the world.

    Returns
    -------
    positions : array (frames, joints, 3), metres
        In the world.
    rotations : array (frames, joints, 4)
        Unit quaternions w, x, y, z, in the world.
    """
    return forward(parents, offsets, local_rotations, root_positions)


def _frames_first(rows: FloatArray) -> FloatArray:
    """Return an array (joints, values, frames) as (frames, joints, values)."""
    return np.ascontiguousarray(rows.transpose(2, 0, 1))


def _among(rows: FloatArray, chosen: list[int], n_joints: int) -> FloatArray:
    """Return an array (chosen, values, frames) as (frames, joints, values), NaN for all others."""
    spread = np.full((rows.shape[2], n_joints, rows.shape[1]), np.nan, dtype=rows.dtype)
    spread[:, chosen] = rows.transpose(2, 0, 1)
    return spread


def _with_ancestors(parents: IntArray, joints: Sequence[int]) -> list[int]:
    """Return the joints and all their ancestors, ascending."""
    needed: set[int] = set()
    for joint in joints:
        while joint >= 0 and joint not in needed:
            needed.add(int(joint))
            joint = int(parents[joint])
    return sorted(needed)


def is_below(parents: IntArray, joint: int, above: int) -> bool:
    """Say whether a joint hangs from another one."""
    while joint >= 0 and joint != above:
        joint = int(parents[joint])
    return joint == above


def to_local(
    parents: IntArray, places: FloatArray, turns: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return rotations (frames, joints, 4) and places (frames, joints, 3) in parents' frames."""
    local, offsets = turns.copy(), places.copy()
    for joint, parent in enumerate(parents):
        if parent >= 0:
            back = rotation.conjugate(turns[:, parent])
            local[:, joint] = rotation.multiply(back, turns[:, joint])
            offsets[:, joint] = rotation.rotate(back, places[:, joint] - places[:, parent])
    return local, offsets


def _product(p: FloatArray, q: FloatArray, into: FloatArray) -> None:
    """Multiply as :func:`.rotation.multiply`, arrays (4, frames), and write into the third."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    into[0] = pw * qw - px * qx - py * qy - pz * qz
    into[1] = pw * qx + px * qw + py * qz - pz * qy
    into[2] = pw * qy - px * qz + py * qw + pz * qx
    into[3] = pw * qz + px * qy - py * qx + pz * qw


def _move(q: FloatArray, v: FloatArray, since: FloatArray, into: FloatArray) -> None:
    """Rotate v, (3,) or (3, frames), as :func:`.rotation.rotate` does; add it to ``since``."""
    w, x, y, z = q
    a, b, c = v
    s, t, u = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    into[0] = since[0] + (a + w * s + (y * u - z * t))
    into[1] = since[1] + (b + w * t + (z * s - x * u))
    into[2] = since[2] + (c + w * u + (x * t - y * s))


def clip_positions(
    clip: Clip, joints: Sequence[int] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Compute world positions and rotations of a clip; result (frames, joints, 3)."""
    offsets = clip.skeleton.offsets if clip.joint_positions is None else clip.joint_positions
    return forward(
        clip.skeleton.parents, offsets, clip.local_rotations, clip.root_positions, joints
    )


def two_bone(
    hip: FloatArray, knee: FloatArray, ankle: FloatArray, target: FloatArray, ahead: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rotations (frames, 4) that bring the end of a two-bone chain to a target (frames, 3)."""
    upper_bone, lower_bone = knee - hip, ankle - knee
    a = np.linalg.norm(upper_bone, axis=-1)
    b = np.linalg.norm(lower_bone, axis=-1)
    reach = np.clip(
        np.linalg.norm(target - hip, axis=-1), np.abs(a - b) + _FOLDED, (a + b) * _STRAIGHT
    )
    direction = rotation.normalize(target - hip)
    chain = rotation.between(ankle - hip, direction)
    bend = rotation.rotate(chain, knee - (hip + ankle) / 2.0) + _BEND * ahead
    bend = rotation.normalize(bend - np.sum(bend * direction, axis=-1, keepdims=True) * direction)
    along = (a * a - b * b + reach * reach) / (2.0 * reach)
    aside = np.sqrt(np.maximum(a * a - along * along, 0.0))
    new_knee = hip + along[:, None] * direction + aside[:, None] * bend
    new_ankle = hip + reach[:, None] * direction
    upper = rotation.between(upper_bone, new_knee - hip)
    lower = rotation.between(lower_bone, new_ankle - new_knee)
    return upper, lower


def as_asked(
    clip: Clip, up: str, mirror_world: bool, swap_names: Sequence[int] | IntArray | None
) -> Clip:
    """Return a clip with an axis up, from a left-handed world, or with other joints' names."""
    skeleton = clip.skeleton
    if swap_names is not None:
        names = tuple(skeleton.names[other] for other in swap_names)
        skeleton = replace(skeleton, names=names)
    clip = replace(clip, skeleton=skeleton, up=up or clip.up)
    if not mirror_world:
        return clip
    axis = 2 if clip.up[-1:] == "x" else 0  # any axis along the ground
    flip = np.where(np.arange(3) == axis, -1.0, 1.0)
    moved = clip.joint_positions
    ends = tuple((j, tuple((flip * place).tolist())) for j, place in skeleton.end_sites)
    return replace(
        clip,
        skeleton=replace(skeleton, offsets=skeleton.offsets * flip, end_sites=ends),
        local_rotations=clip.local_rotations * np.array([1.0, *-flip]),
        root_positions=clip.root_positions * flip,
        joint_positions=None if moved is None else moved * flip,
    )
