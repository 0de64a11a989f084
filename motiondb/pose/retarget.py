"""From a capture on its own skeleton to the canonical body, and back to any leg length.

The canonical rotations follow from joint positions alone, so that neither rest pose nor joint axes
of the source matter: pelvis and chest get full frames (line of hips or shoulders, and up), every
other bone the smallest rotation in its parent's frame that points it where the source points it
(swing without twist). Bone lengths are the standard body's; the root is scaled by leg length.
What is lost: rolling of head, hands and feet about their own bone, shoulder shrugs along the bone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motiondb.errors import SkeletonError
from motiondb.pose import body, cleaning, kinematics, rotation
from motiondb.pose.joint_names import joint_map
from motiondb.records import MOTION_FPS, Clip, FloatArray, Motion, Skeleton

_I = body.INDEX
_COLLAR_FROM_NECK = body.OFFSETS[_I["l_collar"]] - body.OFFSETS[_I["neck"]]


def to_motion(clip: Clip, user_map: Mapping[str, str] | None = None) -> Motion:
    """The motion of a clip on the canonical body at 30 frames a second.

    Parameters
    ----------
    clip : any skeleton that a convention of :mod:`motiondb.pose.joint_names` fits.
    user_map : role -> joint name, for other skeletons.

    Raises
    ------
    SkeletonError
        when the joints cannot be matched, or the body has no size.
    """
    keypoints = clip_keypoints(clip, user_map)
    return motion_from_positions(keypoints, clip.fps)


def clip_keypoints(clip: Clip, user_map: Mapping[str, str] | None = None) -> FloatArray:
    """Canonical joints of a clip: array (frames, 21), world frame, metres, y up; gaps filled."""
    roles = joint_map(clip.skeleton, user_map)
    positions, rotations = kinematics.clip_positions(clip)
    points = np.full((clip.n_frames, len(body.JOINTS), 3), np.nan)
    for role, joint in roles.items():
        if joint >= 0:
            points[:, _I[role]] = positions[:, joint]
        else:
            parent = clip.skeleton.end_sites[-1 - joint][0]
            offset = _end_offset(clip.skeleton, -1 - joint)
            turned = rotation.rotate(
                rotations[:, parent], np.broadcast_to(offset, (clip.n_frames, 3))
            )
            points[:, _I[role]] = positions[:, parent] + turned
    if _is_z_up(points):
        points = points[..., [0, 2, 1]] * np.array([1.0, 1.0, -1.0])
        rotations = rotation.multiply(rotation.from_euler([-90.0], "X"), rotations)
    return _fill_missing(points, roles, rotations)


def _end_offset(skeleton: Skeleton, end: int) -> FloatArray:
    """An end site's offset, or, where it folds back by more than a right angle's two thirds, the
    same length straight on.

    Some converted files turn joint offsets but not end sites, so that hands and heads would point
    anywhere. Feet stand at an angle by nature and are looked at in :func:`_toe`.
    """
    joint, site = skeleton.end_sites[end]
    offset = np.array(site)
    straight = skeleton.offsets[joint]
    size = np.linalg.norm(offset) * np.linalg.norm(straight)
    foot = "foot" in skeleton.names[joint].lower() or "ankle" in skeleton.names[joint].lower()
    if foot or size < 1e-9 or offset @ straight > 0.5 * size:
        return offset
    return straight * (np.linalg.norm(offset) / np.linalg.norm(straight))


def motion_from_positions(keypoints: FloatArray, fps: float) -> Motion:
    """Solve the canonical body for joint positions (frames, 21, 3), metres, y up, at ``fps``."""
    leg_length = _leg_length(keypoints)
    points, notes = cleaning.clean(keypoints, fps, leg_length)
    points = resample(points, fps) * (body.LEG_LENGTH / leg_length)
    rotations = solve_rotations(points)
    root = points[:, _I["pelvis"]]
    root = root - np.array([root[0, 0], 0.0, root[0, 2]])
    positions, _ = kinematics.forward(body.PARENTS, body.OFFSETS, rotations, root)
    root[:, 1] -= ground_height(positions)
    return Motion(
        local_rotations=rotation.unroll(rotations).astype(np.float32),
        root_positions=root.astype(np.float32),
        leg_length=leg_length,
        notes=notes,
    )


def motion_positions(
    motion: Motion, joints: Sequence[int] | None = None
) -> tuple[FloatArray, FloatArray]:
    """World positions (frames, 21, 3), metres on the standard body, and rotations of a motion.

    joints : numbers of those that are asked for; others may be NaN. Default all.
    """
    return kinematics.forward(
        body.PARENTS,
        body.OFFSETS,
        motion.local_rotations.astype(np.float64),
        motion.root_positions.astype(np.float64),
        joints,
    )


def to_clip(motion: Motion, leg_length: float | None = None) -> Clip:
    """A motion as a clip on the canonical skeleton, scaled to a leg length (default: its own)."""
    length = motion.leg_length if leg_length is None else leg_length
    skeleton = body.standard_skeleton(length)
    return Clip(
        skeleton=skeleton,
        fps=MOTION_FPS,
        local_rotations=rotation.normalize(motion.local_rotations.astype(np.float64)),
        root_positions=motion.root_positions.astype(np.float64) * (length / body.LEG_LENGTH),
        unit=0.01,
    )


def mirror(motion: Motion) -> Motion:
    """The mirror image in the plane x = 0, left and right exchanged."""
    flip = np.array([1.0, 1.0, -1.0, -1.0], dtype=np.float32)
    return Motion(
        local_rotations=motion.local_rotations[:, body.MIRROR] * flip,
        root_positions=motion.root_positions * np.array([-1.0, 1.0, 1.0], dtype=np.float32),
        leg_length=motion.leg_length,
        notes=motion.notes,
    )


def resample(points: FloatArray, fps: float) -> FloatArray:
    """Linear interpolation in time to 30 frames a second, over the same duration."""
    n_frames = max(1, round(len(points) / fps * MOTION_FPS))
    times = np.arange(n_frames) * (fps / MOTION_FPS)
    below = np.minimum(times.astype(np.int64), len(points) - 1)
    above = np.minimum(below + 1, len(points) - 1)
    share = (times - below).clip(0.0, 1.0)[:, None, None]
    return points[below] * (1.0 - share) + points[above] * share


def solve_rotations(points: FloatArray) -> FloatArray:
    """Local rotations (frames, 21, 4) of the canonical body that point its bones like ``points``.

    points : array (frames, 21, 3), metres, world frame, y up, scaled to the standard leg length
        (the collar's place below the neck is the standard body's).
    """
    n_frames = len(points)
    local = np.tile(rotation.IDENTITY, (n_frames, len(body.JOINTS), 1))
    world = np.empty_like(local)

    def at(name: str) -> FloatArray:
        return points[:, _I[name]]

    world[:, 0] = _frame(at("l_hip") - at("r_hip"), at("spine") - at("pelvis"))
    chest = _frame(at("l_shoulder") - at("r_shoulder"), at("neck") - at("chest"))
    left = rotation.rotate(world[:, 0], _axis(0, n_frames)) + rotation.rotate(
        chest, _axis(0, n_frames)
    )
    world[:, _I["spine"]] = _frame(left, at("chest") - at("spine"))
    world[:, _I["chest"]] = chest
    local[:, 0] = world[:, 0]
    _set_local(local, world, "spine")
    _set_local(local, world, "chest")
    _swing(local, world, "neck", at("head") - at("neck"), body.OFFSETS[_I["head"]])
    _swing(local, world, "head", None, None)
    for side in "lr":
        _solve_arm(local, world, points, side)
        for joint, child in (("hip", "knee"), ("knee", "ankle"), ("ankle", "toe")):
            bone = at(f"{side}_{child}") - at(f"{side}_{joint}")
            _swing(local, world, f"{side}_{joint}", bone, body.OFFSETS[_I[f"{side}_{child}"]])
        _swing(local, world, f"{side}_toe", None, None)
    return local


def ground_height(positions: FloatArray) -> float:
    """Height of the ground under a motion: the 5th percentile of the lower toe or ankle, metres."""
    toes = positions[:, [_I["l_toe"], _I["r_toe"]], 1] - 0.02
    ankles = positions[:, [_I["l_ankle"], _I["r_ankle"]], 1] - body.ANKLE_HEIGHT
    return float(np.percentile(np.minimum(toes, ankles).min(axis=1), 5))


def _solve_arm(local: FloatArray, world: FloatArray, points: FloatArray, side: str) -> None:
    """Collar, shoulder, elbow, wrist; the collar starts at its canonical place below the neck."""
    chest, neck = world[:, _I["chest"]], points[:, _I["neck"]]
    shoulder = points[:, _I[f"{side}_shoulder"]]
    offset = _COLLAR_FROM_NECK * np.array([1.0 if side == "l" else -1.0, 1.0, 1.0])
    collar = neck + rotation.rotate(chest, np.broadcast_to(offset, neck.shape))
    rest = body.OFFSETS
    _swing(local, world, f"{side}_collar", shoulder - collar, rest[_I[f"{side}_shoulder"]])
    upper = points[:, _I[f"{side}_elbow"]] - shoulder
    _swing(local, world, f"{side}_shoulder", upper, rest[_I[f"{side}_elbow"]])
    fore = points[:, _I[f"{side}_wrist"]] - points[:, _I[f"{side}_elbow"]]
    _swing(local, world, f"{side}_elbow", fore, rest[_I[f"{side}_wrist"]])
    _swing(local, world, f"{side}_wrist", None, None)


def _swing(
    local: FloatArray,
    world: FloatArray,
    joint: str,
    bone: FloatArray | None,
    rest: FloatArray | None,
) -> None:
    """Turn a joint as little as possible so that its bone (world frame) leaves ``rest``."""
    number, parent = _I[joint], world[:, body.PARENTS[_I[joint]]]
    if bone is not None and rest is not None:
        direction = rotation.rotate(rotation.conjugate(parent), bone)
        local[:, number] = rotation.between(np.broadcast_to(rest, direction.shape), direction)
    world[:, number] = rotation.multiply(parent, local[:, number])


def _set_local(local: FloatArray, world: FloatArray, joint: str) -> None:
    parent = world[:, body.PARENTS[_I[joint]]]
    local[:, _I[joint]] = rotation.relative(parent, world[:, _I[joint]])


def _axis(number: int, n_frames: int) -> FloatArray:
    return np.broadcast_to(np.eye(3)[number], (n_frames, 3))


def _frame(left: FloatArray, up: FloatArray) -> FloatArray:
    """Rotation whose x axis is ``left`` and whose y axis is ``up`` made orthogonal to it."""
    x = rotation.normalize(left)
    z = rotation.normalize(np.cross(x, up))
    y = np.cross(z, x)
    return rotation.from_matrix(np.stack([x, y, z], axis=-1))


def _leg_length(points: FloatArray) -> float:
    """Median hip-knee-ankle length of both legs over the frames that hold numbers, metres."""
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


def _is_z_up(points: FloatArray) -> bool:
    """Whether z points up in the file's world: feet to neck, most of the time."""
    trunk = points[:, _I["neck"]] - points[:, [_I["l_ankle"], _I["r_ankle"]]].mean(axis=1)
    trunk = trunk[np.isfinite(trunk).all(axis=1)]
    if len(trunk) == 0:
        return False
    return bool(np.median(trunk[:, 2]) > 3.0 * np.abs(np.median(trunk[:, 1])))


def _fill_missing(
    points: FloatArray, roles: Mapping[str, int], rotations: FloatArray
) -> FloatArray:
    """Place the joints that a skeleton lacks where the standard body would have them."""
    points[:, 0] = (points[:, _I["l_hip"]] + points[:, _I["r_hip"]]) / 2.0
    neck, pelvis = points[:, _I["neck"]], points[:, 0]
    if "spine" not in roles:
        points[:, _I["spine"]] = pelvis + 0.24 * (neck - pelvis)
    if "chest" not in roles:
        points[:, _I["chest"]] = (points[:, _I["spine"]] + neck) / 2.0
    trunk = neck - points[:, _I["chest"]]
    if "head" not in roles:
        points[:, _I["head"]] = neck + 0.4 * trunk
    for side in "lr":
        elbow, shoulder = points[:, _I[f"{side}_elbow"]], points[:, _I[f"{side}_shoulder"]]
        points[:, _I[f"{side}_collar"]] = neck + 0.2 * (shoulder - neck)
        if f"{side}_wrist" not in roles:
            points[:, _I[f"{side}_wrist"]] = elbow + 0.9 * (elbow - shoulder)
        points[:, _I[f"{side}_toe"]] = _toe(points, roles, rotations, side)
    return points


def _toe(
    points: FloatArray, roles: Mapping[str, int], rotations: FloatArray, side: str
) -> FloatArray:
    """The toe as the file has it, or, where it has none or one that points anywhere, ahead.

    A rigid foot keeps its toe at one place in the ankle's frame. Where the file's toe is not in
    front of the shin, that place is estimated: the toe of the standard foot, set on the ground
    plane at right angles to the shin and along the body's facing, averaged over the frames in the
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
        forward = float(np.median(np.sum(rotation.normalize(foot) * ahead[known], axis=-1)))
        is_end = roles[f"{side}_toe"] < 0
        if 0.15 * size < length < 0.8 * size and (forward > 0.5 or not is_end):
            return toe
    guess = size * (0.33 * ahead + 0.14 * shin)
    turn = rotations[:, roles[f"{side}_ankle"]]
    place = rotation.rotate(rotation.conjugate(turn), guess)[known].mean(axis=0)
    return ankle + rotation.rotate(turn, np.broadcast_to(place, guess.shape))
