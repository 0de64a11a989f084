"""Reader of positions alone: frames x joints x 3 in npy and npz, Kimodo's npz and HumanML3D.

The names of the joints stand in the file (``joint_names``), in a text file beside it, one a line,
or are those of a known order (:mod:`.point_orders`). The order is a guess, and told: it is the one
under which thighs, shins, upper arms and forearms keep their lengths over the take and are alike on
both sides.

Kimodo: ``posed_joints`` and ``global_rot_mats`` of SOMA (77 or 30 joints), SMPL-X (22) or the
skeleton of Unitree's G1 (34); y up, 30 frames a second. HumanML3D: 263 numbers a frame, of which
the way of the root and the places of the joints are read; 20 frames a second.

The body is solved as that of a C3D is; fingers and the turns of head, hands and feet are left out.

Source: https://research.nvidia.com/labs/sil/projects/kimodo/docs (output formats); Guo et al.,
"Generating Diverse and Natural 3D Human Motions From Text", CVPR 2022 (263 numbers); Loper et al.,
"SMPL", 2015; Harvey et al., "Robust Motion In-betweening", 2020 (LAFAN1).
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, hinges, retarget, rotation
from motiondb.body.joint_names import joint_map, mirror_joints
from motiondb.body.world import UNITS
from motiondb.errors import CaptureError, SkeletonError
from motiondb.files.limits import ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.array_files import RATES, Arrays, as_numbers, texts_of
from motiondb.files.readers.first_bytes import HUMANML3D_WIDTH, is_points_shape
from motiondb.files.readers.marker_gaps import LONGEST_GAP, gaps_of, longest_gap, seen, straight
from motiondb.files.readers.point_orders import ORDERS
from motiondb.files.text import decode, quoted
from motiondb.records import BoolArray, Clip, FloatArray, Skeleton

_POSITIONS = (
    *("posed_joints", "global_joint_positions", "joint_positions", "joints_3d", "joints3d"),
    *("keypoints", "keypoints_3d", "keypoints3d", "positions", "joints", "poses_3d", "xyz"),
    *("points", "arr_0", "keypoints3d_optim", "reconstruction"),
)  # Names of arrays of positions, in the order in which they are looked for
_NAMES = ("joint_names", "names", "joints", "bone_names", "keypoint_names", "marker_names")
_TURNS = "global_rot_mats"
KEYS = (*_POSITIONS, *_NAMES, _TURNS, "root_positions")
_BONES = (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
_ACROSS = ("hip", "shoulder")  # Joints of both sides that keep their distance
_KEEPS, _ALIKE, _BACKWARDS, _PROPORTIONS = 0.15, 0.03, 0.1, 0.3
"""Shares by which limbs change their length, and differ between the sides, in the mean: above the
first no order is believed; another order that is nearer than the second is told, too; the third is
added where knees bend backwards. The mean logarithm of the ratios of limbs to those of the
canonical body, above which they are no limbs: by hand."""
_TOE = re.compile("(?:foot[ _]?index|big[ _]?toe)$", re.IGNORECASE)
_AT_ORIGIN = 0.1  # Of the spread of a body's points: a point that near to the origin may be there
_OF_LENGTH_1 = 1e-3  # By which quaternions may differ from length 1 in the median
_USUAL_FPS, _FPS_ML3D, _JOINTS_ML3D = 30.0, 20.0, 22
_USUAL = MappingProxyType({"keypoints3d_optim": 60.0})  # Frames a second of AIST++'s keypoints
_BODIES = 8  # In one array at most
_FIRST = 1e-3  # Metres that HumanML3D's first root may be off the origin


def is_points(names: Sequence[str]) -> bool:
    """Whether arrays of these names are positions of joints."""
    return bool({*_POSITIONS} & {*names})


def read_points(
    arrays: Arrays, names_file: bytes | None, path: object, options: ReadOptions, n_bytes: int
) -> Clip:
    """Read the clip in arrays of positions (CaptureError); `names_file`: names, one a line."""
    points, fps, usual = _positions(arrays, path)
    names = _names(arrays, names_file, points.shape[1], path)
    check_clip_size(len(points), points.shape[1], n_bytes, path, options.limits)
    notes: tuple[str, ...] = ()
    if not names and usual == _FPS_ML3D:
        names = _order_of_humanml3d(points, path)
    elif not names:
        names, notes = _known_order(points, path)
    if options.fps:
        fps = options.fps
    elif fps is None:
        fps, why = (12.5, ", as in KIT-ML") if names == ORDERS["KIT-ML"] else (usual, "")
        if usual == _USUAL_FPS and names == ORDERS["SMPL"] and _begins_as_humanml3d(points):
            fps, why = _FPS_ML3D, ", as in HumanML3D, whose first frame it has"
        told = f"The file has no frame rate; {fps:g} frames a second are taken{why}. "
        notes += (told + "Give the right one (--fps) if this is wrong.",)
    if _TURNS in arrays and any(name.endswith("_skel") for name in names):
        return _of_robot(names, points, arrays[_TURNS], fps, path, options, notes)
    up = options.up or ("y" if "posed_joints" in arrays else "")
    return clip_of_points(names, points, fps, replace(options, up=up), path, "positions", notes)


def _positions(arrays: Arrays, path: object) -> tuple[FloatArray, float | None, float]:
    """Return positions (frames, joints, 3), the frame rate of the file, and the usual one."""
    name = next(
        (n for n in _POSITIONS if n in arrays and arrays[n].dtype.kind in "iuf"), _POSITIONS[0]
    )
    if name not in arrays or arrays[name].dtype.kind not in "iuf":
        found = ", ".join(quoted(n, 40) for n in sorted(arrays)[:20]) or "none"
        raise CaptureError(path, f"expected an array of positions, found {found}.")
    array = arrays[name].astype(np.float64)
    if array.ndim == 4 and 1 in array.shape[:2]:
        array = array[0] if len(array) == 1 else array[:, 0]
    if array.ndim == 3 and len(array) == 1 and array.shape[2] == HUMANML3D_WIDTH:
        array = array[0]
    rates = [as_numbers(arrays[n]) for n in RATES if n in arrays and arrays[n].size == 1]
    said = next((rate.reshape(-1)[0] for rate in rates if rate.dtype.kind in "iuf"), None)
    fps = None if said is None else check_rate(float(said), path)
    if array.ndim == 2 and array.shape[1] == HUMANML3D_WIDTH:
        return humanml3d_positions(array), fps, _FPS_ML3D
    if array.ndim == 3 and array.shape[2] == 4 and _has_confidence(array):
        array = np.where(array[..., 3:] > 0.0, array[..., :3], np.nan)  # x, y, z, confidence
    if array.ndim == 4 and array.shape[3] == 3 and min(array.shape[:2]) < _BODIES:
        found = min(array.shape[:2])
        raise CaptureError(
            path,
            f"expected positions of one body, found {found} in an array of shape {array.shape}. "
            "Save each in a file of its own.",
        )
    if array.shape[-1:] != (3,) or not is_points_shape(array.shape) or not len(array):
        raise CaptureError(
            path,
            f"expected positions of shape (frames, joints, 3), found {quoted(name, 30)} of shape "
            f"{array.shape}. Save the joints of one body in 3D, or the numbers of a robot as qpos "
            "(root x y z, quaternion w x y z, joints).",
        )
    return zeros_as_lost(array), fps, next((_USUAL[n] for n in _USUAL if n in arrays), _USUAL_FPS)


def _has_confidence(numbers: FloatArray) -> bool:
    """Whether the fourth number of points (frames, n, 4) is a confidence, not that of turns."""
    share, lengths = numbers[..., 3], np.linalg.norm(numbers, axis=2)
    is_turn = float(np.median(np.abs(lengths - 1.0))) < _OF_LENGTH_1
    return not is_turn and bool(((share >= 0.0) & (share <= 1.0)).all())


def zeros_as_lost(points: FloatArray) -> FloatArray:
    """Return points (frames, n, 3) with NaN where they are 0, as programs write what they lost.

    A first point that is always 0 is a root to which the others are relative, and a point that is
    near the origin before and behind may be there.
    """
    zero: BoolArray = np.asarray(~points.any(axis=2))
    zero[:, 0] &= not zero[:, 0].all()
    if not zero.any():
        return points
    known = np.where(zero[..., None], np.nan, points)
    with np.errstate(invalid="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of frames without points
        size = float(np.nanmedian(np.linalg.norm(np.nanstd(known, axis=1), axis=1)))
    for n in np.flatnonzero(zero.any(axis=0)):
        between = straight(known[:, n], math.inf)
        is_far = ~(np.linalg.norm(between, axis=1) < _AT_ORIGIN * size)
        known[:, n] = np.where((zero[:, n] & ~is_far)[:, None], 0.0, known[:, n])
    return known


def humanml3d_positions(numbers: FloatArray) -> FloatArray:
    """Return positions (frames, 22, 3) of HumanML3D's numbers (frames, 263), y up, metres.

    The first four are the turn about y and the way of the root to the next frame (x, z in its own
    frame), and its height; then the other 21 joints from the root's place on the ground, in its
    frame.
    """
    turning = np.zeros(len(numbers))
    turning[1:] = np.cumsum(numbers[:-1, 0])
    back = np.zeros((len(numbers), 4))
    back[:, 0], back[:, 2] = np.cos(turning), -np.sin(turning)  # half angles, as its authors have
    step = np.zeros((len(numbers), 3))
    step[1:, [0, 2]] = numbers[:-1, 1:3]
    root = np.cumsum(rotation.rotate(back, step), axis=0)
    others = numbers[:, 4 : 4 + 3 * (_JOINTS_ML3D - 1)].reshape(len(numbers), -1, 3)
    turned = rotation.rotate(np.broadcast_to(back[:, None], (*others.shape[:2], 4)), others)
    turned = turned + root[:, None] * [1.0, 0.0, 1.0]
    root[:, 1] = numbers[:, 3]
    return np.concatenate([root[:, None], turned], axis=1)


def _names(
    arrays: Arrays, names_file: bytes | None, n_joints: int, path: object
) -> tuple[str, ...]:
    """Return the names that the file has, or the file of names beside it; () for none."""
    found: tuple[str, ...] = ()
    for name in _NAMES:
        if name in arrays and arrays[name].dtype.kind in "US" and arrays[name].ndim == 1:
            found = texts_of(arrays[name])
            break
    if names_file is not None and not found:
        lines = [line.strip() for line in decode(names_file).splitlines()]
        found = tuple(line for line in lines if line and not line.startswith("#"))
    if found and len(found) != n_joints:
        raise CaptureError(
            path, f"expected names of {n_joints} joints, found {len(found)}. Correct the list."
        )
    return found


def _known_order(points: FloatArray, path: object) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the known order that fits best, and a note on what that rests on."""
    n_joints = points.shape[1]
    fits = {
        name: _misfit(points, order) for name, order in ORDERS.items() if len(order) == n_joints
    }
    ranked = sorted(fits, key=lambda name: fits[name])
    if not ranked or not fits[ranked[0]] < _KEEPS:
        sizes = ", ".join(map(str, sorted({len(order) for order in ORDERS.values()})))
        why = "whose limbs keep their lengths" if ranked else f"of {n_joints} (known: {sizes})"
        raise CaptureError(
            path,
            f"expected names of the joints, or a known order {why}, found none. Write the names, "
            f"one a line, into joint_names.txt beside the file.",
        )
    best = ranked[0]
    note = (
        f"The file names no joints; its {n_joints} are taken in the order of {best}, under which "
        f"limbs keep their lengths and are alike on both sides within {fits[best]:.1%}"
    )
    near = [name for name in ranked[1:] if fits[name] < fits[best] + _ALIKE]
    note += f" (as under {near[0]})" if near else ""
    return ORDERS[best], (note + ". Write them into joint_names.txt beside it if this is wrong.",)


def _begins_as_humanml3d(points: FloatArray) -> bool:
    """Whether a body (frames, 22, 3) begins over the origin and faces z, as HumanML3D has it."""
    left = points[0, 1] - points[0, 2] + points[0, 16] - points[0, 17]
    is_there = float(np.abs(points[0, 0, [0, 2]]).max()) < _FIRST
    return is_there and left[0] > 0.0 and abs(float(left[2])) < 0.05 * float(left[0])


def _order_of_humanml3d(points: FloatArray, path: object) -> tuple[str, ...]:
    """Return the names of HumanML3D's joints; CaptureError for numbers of no body."""
    names = ORDERS["SMPL"]
    if not _misfit(points, names) < _KEEPS:
        raise CaptureError(
            path,
            f"expected HumanML3D's {HUMANML3D_WIDTH} numbers in metres, found ones under which "
            "limbs do not keep their lengths. If they are normalised, multiply them by Std.npy and "
            "add Mean.npy.",
        )
    return names


def _misfit(points: FloatArray, names: Sequence[str]) -> float:
    """Return by how much limbs change their lengths, and differ between the sides, in shares.

    Infinite for limbs of no person's proportions; more where the knees bend backwards.
    """
    places = dict(zip(names, points.transpose(1, 0, 2)))
    spread, sizes = [], []
    for pair in _BONES:
        lengths = []
        for side in "lr":
            ends = [_place_of(places, side, part) for part in pair]
            if any(end is None for end in ends):
                return math.inf
            length = np.linalg.norm(np.asarray(ends[0]) - np.asarray(ends[1]), axis=-1)
            lengths.append(length[np.isfinite(length)])
        means = [float(length.mean()) if len(length) else 0.0 for length in lengths]
        if min(means) <= 0.0:
            return math.inf
        spread += [float(each.std()) / mean for each, mean in zip(lengths, means)]
        spread.append(abs(means[0] - means[1]) / sum(means))
        sizes.append(sum(means) / 2.0)
    for part in _ACROSS:
        left, right = (np.asarray(_place_of(places, side, part)) for side in "lr")
        apart = np.linalg.norm(left - right, axis=-1)
        apart = apart[np.isfinite(apart)]
        spread.append(float(apart.std()) / max(float(apart.mean()), 1e-9))
    usual = [np.linalg.norm(body.OFFSETS[body.INDEX[f"l_{end}"]]) for _, end in _BONES]
    ratios = np.log(np.array(sizes) / sum(sizes[:2]) * body.LEG_LENGTH / np.array(usual))
    if np.abs(ratios).mean() > _PROPORTIONS:
        return math.inf
    return float(np.mean(spread)) + _BACKWARDS * _bends_back(places)


def _bends_back(places: Mapping[str, FloatArray]) -> bool:
    """Whether knees bend backwards, as where the sides are exchanged."""
    at = {
        f"{side}_{part}": np.asarray(_place_of(places, side, part))
        for side in "lr"
        for part in ("hip", "knee", "ankle")
    }
    middle = {part: (at[f"l_{part}"] + at[f"r_{part}"]) / 2.0 for part in ("hip", "knee", "ankle")}
    ahead = np.cross(at["l_hip"] - at["r_hip"], middle["hip"] - middle["ankle"])
    bend = middle["knee"] - (middle["hip"] + middle["ankle"]) / 2.0
    return float(np.nanmedian(np.sum(bend * ahead, axis=-1))) < 0.0


def _place_of(places: Mapping[str, FloatArray], side: str, part: str) -> FloatArray | None:
    """Return the places of a joint of the body among joints of one of the known orders."""
    long = {"l": "Left", "r": "Right"}[side]
    words = {
        "hip": ("UpLeg", "Hip", "Leg"),
        "knee": ("Knee", "Shin", "Leg"),
        "ankle": ("Ankle", "Foot"),
        "shoulder": ("Arm", "Shoulder"),
        "elbow": ("ForeArm", "Elbow"),
        "wrist": ("Wrist", "Hand"),
    }[part]
    robot = {"hip": "hip_roll", "ankle": "ankle_pitch", "shoulder": "shoulder_roll"}
    spelt = [f"{long.lower()}_{robot.get(part, part)}_skel", f"{long.lower()}_wrist_yaw_skel"]
    for word in words:
        if word == "Leg" and part == "hip" and f"{long}Shin" not in places:
            continue
        spelt += [f"{long}{word}", f"{side.upper()}_{word}", f"{word}{long}"]
    spelt = spelt if part == "wrist" else [name for name in spelt if "wrist" not in name]
    return next((places[name] for name in spelt if name in places), None)


def _of_robot(
    names: tuple[str, ...],
    points: FloatArray,
    matrices: NDArray[np.generic],
    fps: float,
    path: object,
    options: ReadOptions,
    notes: tuple[str, ...],
) -> Clip:
    """Return the clip of a robot's joints with their turns (frames, joints, 3, 3), y up."""
    from motiondb.files.readers.robot_motion import rigid_tree

    if matrices.shape != (*points.shape, 3) or matrices.dtype.kind not in "iuf":
        raise CaptureError(
            path, f"expected {_TURNS} of shape {(*points.shape, 3)}, found {matrices.shape}."
        )
    turns = rotation.from_matrix(matrices.astype(np.float64))
    if not (np.isfinite(points).all() and np.isfinite(turns).all()):
        raise CaptureError(path, "expected finite numbers, found others. Export it again.")
    parents, order = rigid_tree(points, names)
    labels = tuple(names[n] for n in order)
    clip = hinges.of_frames(
        labels, parents, points[:, order], turns[:, order], fps, up=options.up or "y"
    )
    return replace(clip, notes=notes + clip.notes)


# Points of any origin


def clip_of_points(
    names: Sequence[str],
    points: FloatArray,
    fps: float,
    options: ReadOptions,
    path: object,
    kind: str,
    notes: tuple[str, ...] = (),
) -> Clip:
    """Return the clip of points (frames, n, 3), NaN where they are lost; y up (CaptureError)."""
    names, points, gap_notes = _tracks(names, points, fps, path, options.skip_bad_frames)
    if options.mirror_world:
        points = points * [-1.0, 1.0, 1.0]
    try:
        keypoints, found = _keypoints(names, points, fps, options)
    except SkeletonError as error:
        raise CaptureError(path, f"{error} Or rename the keypoints.") from None
    leg = retarget.legs_of(keypoints)
    usual, unit = body.LEG_LENGTH, options.unit
    if unit is None:
        unit = min(UNITS.values(), key=lambda metres: abs(math.log(leg * metres / usual)))
        found += (f"The file has no length unit; by the length of the legs it is {unit:.4g} m.",)
    skeleton, rotations = retarget.solved_body(keypoints * unit)
    return Clip(
        skeleton=skeleton,
        fps=fps,
        local_rotations=rotations,
        root_positions=keypoints[:, 0] * unit,
        format=kind,
        unit=unit,
        notes=notes + gap_notes + found,
        up="y",
    )


def _tracks(
    names: Sequence[str], points: FloatArray, rate: float, path: object, skip_bad: bool
) -> tuple[list[str], FloatArray, tuple[str, ...]]:
    """Return the keypoints that were seen, their places (frames, n, 3), and notes."""
    tracks = {n: points[:, at] for at, n in enumerate(names) if seen(points[:, at]).any()}
    tracks = {name: straight(track, LONGEST_GAP * rate) for name, track in tracks.items()}
    lost = {name: longest_gap(track) / rate for name, track in tracks.items()}
    lost = {name: seconds for name, seconds in lost.items() if seconds > 0.0}
    places = np.stack(list(tracks.values()), axis=1) if tracks else np.zeros((0, 0, 3))
    good = np.isfinite(places).all(axis=(1, 2))
    if not good.any() or (lost and not skip_bad):
        raise CaptureError(
            path,
            f"expected no gap above {LONGEST_GAP:g} s, found lost keypoints: "
            f"{gaps_of(list(lost), lost) or 'all'}. Fill the gaps, or "
            "pass --skip-bad-frames to leave those frames out.",
        )
    left_out = f"Left out {int((~good).sum())} frames with lost keypoints."
    return list(tracks), places[good], (left_out,) * bool(lost)


def _keypoints(
    names: list[str], points: FloatArray, rate: float, options: ReadOptions
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the places (frames, 21, 3) of the canonical joints, y up, in file units, and notes."""
    names = [_TOE.sub("toe", name) for name in names]
    alike = Skeleton(tuple(names), np.zeros(len(names), dtype=np.int64), np.zeros((len(names), 3)))
    if options.swap_sides:
        names = [names[other] for other in mirror_joints(alike)]
    at = {name.casefold(): points[:, n] for n, name in enumerate(names)}
    shoulders = [at[key] for key in at if "shoulder" in key and "mid" not in key]
    if not any("neck" in key for key in at) and len(shoulders) == 2:
        hips = [at[key] for key in at if "hip" in key and "mid" not in key]
        low = hips if len(hips) == 2 else shoulders
        neck = retarget.neck_over(shoulders, low)
        names = [*names, "neck"]
        points = np.concatenate([points, neck[:, None]], axis=1)
    root = points.mean(axis=1)
    places = np.concatenate([root[:, None], points - root[:, None]], axis=1)
    parents = np.zeros(len(names) + 1, dtype=np.int64)
    parents[0] = -1
    skeleton = Skeleton(("keypoints", *names), parents, np.median(places, axis=0))
    roles = joint_map(skeleton)
    turns = np.tile(rotation.IDENTITY, (*places.shape[:2], 1))
    for side in "lr":  # a foot without a toe keeps its place beside the shin
        across = points[:, roles["l_hip"] - 1] - points[:, roles["r_hip"] - 1]
        shin = points[:, roles[f"{side}_knee"] - 1] - points[:, roles[f"{side}_ankle"] - 1]
        turns[:, roles[f"{side}_ankle"]] = retarget.frame_of(across, shin)
    clip = Clip(skeleton, rate, turns, root, places, up=options.up)
    solved, found = retarget.keypoints_of(clip, roles)
    return solved, found.notes
