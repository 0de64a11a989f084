"""A capture on its own skeleton, turned into a motion on the canonical body, and back.

The positions of the canonical joints are measured, or estimated as on the standard body where the
skeleton has none (spine, head, collars, hands, toes). The canonical rotations follow from joint
positions alone, so that neither rest pose nor joint axes of the source matter: pelvis and chest get
full frames (line of hips or shoulders, and up), every other bone the smallest rotation in its
parent's frame that points it where the source points it (swing without twist). Bone
lengths are the standard body's; the root is scaled by leg length. What is lost: the rotation of
head, hands and feet about their own bone, and shrugs along the bone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from motiondb.body import body, cleaning, kinematics, rotation, world
from motiondb.body.joint_names import crossed_names, joint_map, same_names
from motiondb.errors import ImplausibleError, SkeletonError
from motiondb.records import (
    MOTION_FPS,
    POSE_STEP,
    Clip,
    Float32Array,
    FloatArray,
    IntArray,
    Motion,
    Skeleton,
)

_I = body.INDEX
_COLLAR_FROM_NECK = body.OFFSETS[_I["l_collar"]] - body.OFFSETS[_I["neck"]]
_TRUNK_NAMES = (
    *("pelvis", "spine", "chest", "neck"),
    *("l_hip", "r_hip", "l_shoulder", "r_shoulder"),
)
_TRUNK = np.array([_I[name] for name in _TRUNK_NAMES])
_LIMBS = ("hip", "knee", "ankle", "toe"), ("collar", "shoulder", "elbow", "wrist")
_BONES = [("neck", "head", 0)] + [
    (f"{side}_{joint}", f"{side}_{end}", sign if joint == "collar" else 0)
    for side, sign in (("l", 1), ("r", -1))
    for limb in _LIMBS
    for joint, end in pairwise(limb)
]
_SWINGS = np.array([(_I[joint], body.PARENTS[_I[joint]], _I[end], s) for joint, end, s in _BONES])
"""(bones, 4), as :func:`.kernels.solve` takes them."""
_TOE_HEIGHT = 0.02  # Height of the toe joint above the ground in a flat stance, metres
_GROUND_PERCENTILE = 5
"""The ground is at this percentile of the lower foot's height over the frames: low enough for
walks, in which one foot is always on the ground, and not at the single lowest frame, which depends
on noise."""
_FOLDED = 0.5
"""Cosine of 60 degrees: an end site that turns away from its bone by more is not believed. A fist
or a bowed head stays within it."""
_NECK_SHARE = 0.14  # Place of a missing neck beyond the middle of the shoulders, from the hips
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


def to_motion(
    clip: Clip, user_map: Mapping[str, str] | None = None, keep_implausible: bool = True
) -> Motion:
    """Turn a clip into a motion on the canonical body at 30 frames a second."""
    return solved(clip, user_map, keep_implausible)[0]


def solved(
    clip: Clip, user_map: Mapping[str, str] | None = None, keep_implausible: bool = True
) -> tuple[Motion, world.Found]:
    """Turn a clip into a motion as :func:`to_motion`, and say which axis was taken for up."""
    roles = joint_map(clip.skeleton, user_map)
    keypoints, found = keypoints_of(clip, roles)
    leg_length = legs_of(keypoints)
    if not keep_implausible:
        reason = cleaning.implausible(keypoints, clip.fps, leg_length)
        if reason:
            raise ImplausibleError(
                f"motion: expected the motion of a person, found {reason}. Check the frame rate "
                "(--fps) and the unit (--unit), or pass --keep-implausible."
            )
    notes = crossed_names(clip.skeleton, roles) + same_names(clip.skeleton, roles) + found.notes
    notes += world.side_notes(keypoints, {"l_toe", "r_toe"} <= roles.keys())
    notes += world.travel_notes(keypoints, clip.fps, leg_length) + world.angle_notes(clip)
    motion = motion_from_positions(keypoints, clip.fps)
    return replace(motion, notes=notes + motion.notes), found


def motion_from_positions(keypoints: FloatArray, fps: float) -> Motion:
    """Solve the canonical body for joint positions; `keypoints` (frames, 21, 3)."""
    leg_length = legs_of(keypoints)
    points, notes = cleaning.clean(keypoints, fps, leg_length)
    points = resample(points, fps) * (body.LEG_LENGTH / leg_length)
    rotations = solve_rotations(points)
    root = points[:, _I["pelvis"]]
    root = root - np.array([root[0, 0], 0.0, root[0, 2]])
    positions, _ = _compiled_forward(body.PARENTS, body.OFFSETS, rotations, root)
    root[:, 1] -= ground_height(positions)
    return Motion(
        local_rotations=_to_steps(rotation.unroll(rotations)),
        root_positions=_to_steps(root),
        leg_length=leg_length,
        notes=notes + cleaning.fastest_note(positions),
    )


def _to_steps(values: FloatArray) -> Float32Array:
    """Values rounded to multiples of ``POSE_STEP``."""
    steps = np.rint(values / POSE_STEP) + 0.0  # without -0.0
    return (steps * POSE_STEP).astype(np.float32)


def motion_positions(
    motion: Motion, joints: Sequence[int] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Compute world positions and rotations of a motion; result (frames, 21, 3)."""
    return kinematics.forward(
        body.PARENTS,
        body.OFFSETS,
        motion.local_rotations.astype(np.float64),
        motion.root_positions.astype(np.float64),
        joints,
    )


def to_clip(motion: Motion | Clip) -> Clip:
    """Turn a motion into a clip on the canonical skeleton, in the performer's size; keep a clip."""
    if isinstance(motion, Clip):
        return motion
    if not isinstance(motion, Motion):
        found = type(motion).__name__
        raise TypeError(f"expected a motiondb.Clip or a motiondb.Motion, found {found}.")
    return Clip(
        skeleton=body.standard_skeleton(motion.leg_length),
        fps=MOTION_FPS,
        local_rotations=rotation.normalize(motion.local_rotations.astype(np.float64)),
        root_positions=motion.root_positions.astype(np.float64)
        * (motion.leg_length / body.LEG_LENGTH),
        unit=0.01,
    )


def mirror(motion: Motion) -> Motion:
    """Return the mirror image in the plane x = 0, left and right exchanged."""
    flip = np.array([1.0, 1.0, -1.0, -1.0], dtype=np.float32)
    return Motion(
        local_rotations=motion.local_rotations[:, body.MIRROR] * flip,
        root_positions=motion.root_positions * np.array([-1.0, 1.0, 1.0], dtype=np.float32),
        leg_length=motion.leg_length,
        notes=motion.notes,
    )


def resample(points: FloatArray, fps: float) -> FloatArray:
    """Interpolate positions (frames, joints, 3) linearly to 30 frames a second."""
    n_frames = max(1, round(len(points) / fps * MOTION_FPS))
    times = np.arange(n_frames) * (fps / MOTION_FPS)
    below = np.minimum(times.astype(np.int64), len(points) - 1)
    above = np.minimum(below + 1, len(points) - 1)
    share = (times - below).clip(0.0, 1.0)[:, None, None]
    return points[below] * (1.0 - share) + points[above] * share


def solve_rotations(points: FloatArray) -> FloatArray:
    """Rotations (frames, 21, 4) that point the canonical bones like points (frames, 21, 3)."""
    from motiondb.body.kernels import solve  # compiled code

    points = np.ascontiguousarray(points, dtype=np.float64)
    return solve(points, _TRUNK, _SWINGS, body.OFFSETS, _COLLAR_FROM_NECK)


def neck_over(shoulders: Sequence[FloatArray], hips: Sequence[FloatArray]) -> FloatArray:
    """Place a neck (frames, 3) over the middle of both shoulders, as the canonical body has it."""
    middle, low = (shoulders[0] + shoulders[1]) / 2.0, (hips[0] + hips[1]) / 2.0
    return middle + _NECK_SHARE * (middle - low)


def solved_body(points: FloatArray) -> tuple[Skeleton, FloatArray]:
    """Canonical skeleton with the bones of a body, and its rotations; points (frames, 21, 3).

    A bone is where its end is, in the median over the frames, as the joint above sees it.
    """
    rotations = solve_rotations(points)
    world = _compiled_forward(body.PARENTS, body.OFFSETS, rotations, points[:, 0])[1]
    points, parents = points.copy(), body.PARENTS.clip(0)
    for side, sign in (("l", 1.0), ("r", -1.0)):  # collars are where :func:`.kernels.solve` begins
        start = rotation.rotate(world[:, _I["chest"]], _COLLAR_FROM_NECK * [sign, 1.0, 1.0])
        points[:, _I[f"{side}_collar"]] = points[:, _I["neck"]] + start
    ways = rotation.rotate(rotation.conjugate(world[:, parents]), points - points[:, parents])
    return replace(body.standard_skeleton(), offsets=np.median(ways, axis=0)), rotations


def ground_height(positions: FloatArray) -> float:
    """Estimate the height of the ground from the feet of positions (frames, 21, 3)."""
    toes = positions[:, [_I["l_toe"], _I["r_toe"]], 1] - _TOE_HEIGHT
    ankles = positions[:, [_I["l_ankle"], _I["r_ankle"]], 1] - body.ANKLE_HEIGHT
    return float(np.percentile(np.minimum(toes, ankles).min(axis=1), _GROUND_PERCENTILE))


def frame_of(left: FloatArray, up: FloatArray) -> FloatArray:
    """Return rotations with x axis ``left``, and y axis ``up`` made orthogonal to it."""
    x = rotation.normalize(left)
    z = rotation.normalize(np.cross(x, up))
    y = np.cross(z, x)
    return rotation.from_matrix(np.stack([x, y, z], axis=-1))


def legs_of(points: FloatArray) -> float:
    """Return the median length of hip-knee-ankle over the frames that hold numbers, metres."""
    known = points[np.isfinite(points).all(axis=(1, 2))]
    if len(known) == 0:
        raise SkeletonError(
            "positions: expected numbers, found none in any frame. Export the capture again."
        )
    bones = [
        (f"{s}_{a}", f"{s}_{b}") for s in "lr" for a, b in (("hip", "knee"), ("knee", "ankle"))
    ]
    lengths = [np.linalg.norm(known[:, _I[a]] - known[:, _I[b]], axis=-1) for a, b in bones]
    length = float(np.median(np.sum(lengths, axis=0)) / 2.0)
    if not 1e-3 < length < 1e3:
        raise SkeletonError(
            f"skeleton: expected a leg between 1 mm and 1 km long, found {length:.3g} m. "
            "Give the length unit of the file (--unit)."
        )
    return length


def clip_keypoints(clip: Clip, user_map: Mapping[str, str] | None = None) -> FloatArray:
    """Places (frames, 21, 3) of the canonical joints, y up; those a clip lacks are estimated."""
    return keypoints_of(clip, joint_map(clip.skeleton, user_map))[0]


def keypoints_of(clip: Clip, roles: Mapping[str, int]) -> tuple[FloatArray, world.Found]:
    """Positions (frames, 21, 3) of the canonical joints of a clip whose roles are found, y up."""
    points, rotations = _measured(clip, roles)
    found = _find_up(clip, roles, points)
    if found.up != "y":
        turn = world.to_y_up(found.up)
        points = rotation.rotate(turn, points)
        rotations = rotation.multiply(turn, rotations)
    return _fill_missing(points, roles, rotations), found


def up_axis(clip: Clip, user_map: Mapping[str, str] | None = None) -> str:
    """Return the axis that is up in the world of a clip."""
    roles = joint_map(clip.skeleton, user_map)
    return clip.up or _find_up(clip, roles, _measured(clip, roles)[0]).up


_TURNS = frozenset({"c3d", "trc", "markers", "movement", "positions", "robot", "amass"})
"""Formats whose readers turn their axes: these are others than those that a person knows."""
_TURNED = (
    "The body moves as if another axis were up than the file, its format or --up says. Give the "
    "right one (--up) if it does not lie."
)


def _find_up(clip: Clip, roles: Mapping[str, int], points: FloatArray) -> world.Found:
    """Find the axis that is up from joints (frames, 21, 3) and the rest pose, or as stated."""
    if clip.up:
        found = world.find_up(points, clip.fps, stated=clip.up)
        return replace(found, notes=(_TURNED,)) if found.notes and clip.format in _TURNS else found
    n_joints = len(clip.skeleton.names)
    rest = replace(
        clip,
        local_rotations=np.tile(rotation.IDENTITY, (1, n_joints, 1)),
        root_positions=np.zeros((1, 3)),
        joint_positions=None,
    )
    stands = world.rest_up(_measured(rest, roles)[0][0])
    return world.find_up(points, clip.fps, rest=stands)


def _measured(clip: Clip, roles: Mapping[str, int]) -> tuple[FloatArray, FloatArray]:
    """Return places (frames, 21, 3) of the roles, NaN for others, and rotations of all joints."""
    skeleton = clip.skeleton
    if clip.joint_positions is None:
        positions, rotations = _compiled_forward(
            skeleton.parents, skeleton.offsets, clip.local_rotations, clip.root_positions
        )
    else:
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
    return points, rotations


def _compiled_forward(
    parents: IntArray, offsets: FloatArray, local: FloatArray, roots: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """As :func:`.kinematics.forward` of one skeleton for all frames, a tenth of the time."""
    from motiondb.body import kernels  # compiled code

    doubles = (np.ascontiguousarray(each, np.float64) for each in (offsets, local, roots))
    return kernels.forward(np.ascontiguousarray(parents, np.int64), *doubles)


def _end_offset(skeleton: Skeleton, end: int) -> FloatArray:
    """Offset of an end site; one that turns away from its bone (in converted files) follows it."""
    joint, site = skeleton.end_sites[end]
    offset = np.array(site)
    straight = skeleton.offsets[joint]
    size = np.linalg.norm(offset) * np.linalg.norm(straight)
    foot = "foot" in skeleton.names[joint].lower() or "ankle" in skeleton.names[joint].lower()
    if foot or size < 1e-9 or offset @ straight > _FOLDED * size:
        return offset
    return straight * (np.linalg.norm(offset) / np.linalg.norm(straight))


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
