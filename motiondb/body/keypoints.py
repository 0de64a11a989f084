"""Positions of the canonical joints of a capture, measured or estimated.

The joints of a skeleton are found by :mod:`motiondb.body.joint_names`; missing ones (spine, head,
collars, hands, toes) are placed as on the standard body.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motiondb.body import body, kinematics, rotation
from motiondb.body.joint_names import joint_map
from motiondb.records import Clip, FloatArray, Skeleton

_I = body.INDEX
_FOLDED = 0.5
"""Cosine of 60 degrees: an end site that turns away from its bone by more is not believed. A fist
or a bowed head stays within it. Chosen by hand on converted CMU files; not tuned."""
_Z_UP = 3.0
"""How many times longer the trunk must be along z than along y for z to point up: the body is then
within 18 degrees of z for most of the time, which no motion in a world with y up does."""
_SPINE_SHARE, _HEAD_SHARE = 0.24, 0.4
"""Places of a missing spine joint (from pelvis to neck) and head (beyond the neck along the trunk):
close to the canonical body."""
_COLLAR_SHARE, _FOREARM_SHARE = 0.2, 0.9
"""Places of the collar (from neck to shoulder) and of a missing wrist (forearm by upper arm):
close to the canonical body."""
_FOOT_AHEAD, _FOOT_DOWN = 0.33, 0.14
"""Place of a missing toe from the ankle, by the length of the shin: 0.14 m and 0.06 m of 0.42 m on
the canonical body."""
_FOOT_LENGTHS = (0.15, 0.8)
"""Lengths from ankle to toe, by the length of the shin, outside which a file's toe is not
believed."""


def clip_keypoints(clip: Clip, user_map: Mapping[str, str] | None = None) -> FloatArray:
    """Compute the positions of the canonical joints of a clip; joints that it lacks are estimated.

    Shapes: result (frames, 21, 3).
    """
    skeleton = clip.skeleton
    roles = joint_map(skeleton, user_map)
    needed = {j if j >= 0 else skeleton.end_sites[-1 - j][0] for j in roles.values()}
    positions, rotations = kinematics.clip_positions(clip, sorted(needed))
    points = np.full((clip.n_frames, len(body.JOINTS), 3), np.nan)
    for role, joint in roles.items():
        if joint >= 0:
            points[:, _I[role]] = positions[:, joint]
        else:
            parent = skeleton.end_sites[-1 - joint][0]
            offset = _end_offset(skeleton, -1 - joint)
            turned = rotation.rotate(
                rotations[:, parent], np.broadcast_to(offset, (clip.n_frames, 3))
            )
            points[:, _I[role]] = positions[:, parent] + turned
    if _is_z_up(points):
        points = points[..., [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
        rotations = rotation.multiply(rotation.from_euler([-90.0], "X"), rotations)
    return _fill_missing(points, roles, rotations)


def _end_offset(skeleton: Skeleton, end: int) -> FloatArray:
    """Return the offset of an end site; one that turns away from its bone is laid along the bone.

    Some converted files turn joint offsets but not end sites, so that hands and heads would point
    in any direction. Feet are naturally at an angle; :func:`_toe` checks them.
    """
    joint, site = skeleton.end_sites[end]
    offset = np.array(site)
    straight = skeleton.offsets[joint]
    size = np.linalg.norm(offset) * np.linalg.norm(straight)
    foot = "foot" in skeleton.names[joint].lower() or "ankle" in skeleton.names[joint].lower()
    if foot or size < 1e-9 or offset @ straight > _FOLDED * size:
        return offset
    return straight * (np.linalg.norm(offset) / np.linalg.norm(straight))


def _is_z_up(points: FloatArray) -> bool:
    """Say whether z points up in the file's world: the way from feet to neck, in the median."""
    trunk = points[:, _I["neck"]] - points[:, [_I["l_ankle"], _I["r_ankle"]]].mean(axis=1)
    trunk = trunk[np.isfinite(trunk).all(axis=1)]
    if len(trunk) == 0:
        return False
    return bool(np.median(trunk[:, 2]) > _Z_UP * np.abs(np.median(trunk[:, 1])))


def _fill_missing(
    points: FloatArray, roles: Mapping[str, int], rotations: FloatArray
) -> FloatArray:
    """Place the joints that a skeleton lacks where the standard body has them."""
    points[:, 0] = (points[:, _I["l_hip"]] + points[:, _I["r_hip"]]) / 2.0
    neck, pelvis = points[:, _I["neck"]], points[:, 0]
    if "spine" not in roles:
        points[:, _I["spine"]] = pelvis + _SPINE_SHARE * (neck - pelvis)
    if "chest" not in roles:
        points[:, _I["chest"]] = (points[:, _I["spine"]] + neck) / 2.0
    trunk = neck - points[:, _I["chest"]]
    if "head" not in roles:
        points[:, _I["head"]] = neck + _HEAD_SHARE * trunk
    for side in "lr":
        elbow, shoulder = points[:, _I[f"{side}_elbow"]], points[:, _I[f"{side}_shoulder"]]
        points[:, _I[f"{side}_collar"]] = neck + _COLLAR_SHARE * (shoulder - neck)
        if f"{side}_wrist" not in roles:
            points[:, _I[f"{side}_wrist"]] = elbow + _FOREARM_SHARE * (elbow - shoulder)
        points[:, _I[f"{side}_toe"]] = _toe(points, roles, rotations, side)
    return points


def _toe(
    points: FloatArray, roles: Mapping[str, int], rotations: FloatArray, side: str
) -> FloatArray:
    """Return the toe positions (frames, 3) of a side: the file's, or estimated ones.

    A rigid foot keeps its toe at one place in the ankle's frame. Where the file has no toe, or one
    that is not in front of the shin, that place is estimated: the toe of the standard foot,
    orthogonal to the shin and in the direction that the body faces, averaged over the frames in the
    ankle's frame.
    """
    ankle, knee = points[:, _I[f"{side}_ankle"]], points[:, _I[f"{side}_knee"]]
    left = rotation.normalize(points[:, _I["l_hip"]] - points[:, _I["r_hip"]])
    shin = rotation.normalize(ankle - knee)
    ahead = rotation.normalize(np.cross(left, -shin))
    known = np.isfinite(ahead).all(axis=1)
    if not known.any():
        return np.full_like(ankle, np.nan)
    size = np.median(np.linalg.norm(ankle - knee, axis=-1)[known])
    toe = points[:, _I[f"{side}_toe"]]
    if f"{side}_toe" in roles:
        foot = (toe - ankle)[known]
        length = float(np.median(np.linalg.norm(foot, axis=-1)))
        shortest, longest = _FOOT_LENGTHS
        forward = float(np.median(np.sum(rotation.normalize(foot) * ahead[known], axis=-1)))
        is_end = roles[f"{side}_toe"] < 0
        if shortest * size < length < longest * size and (forward > _FOLDED or not is_end):
            return toe
    guess = size * (_FOOT_AHEAD * ahead + _FOOT_DOWN * shin)
    turn = rotations[:, roles[f"{side}_ankle"]]
    place = rotation.rotate(rotation.conjugate(turn), guess)[known].mean(axis=0)
    return ankle + rotation.rotate(turn, np.broadcast_to(place, guess.shape))
