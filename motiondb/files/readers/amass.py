"""Reader of AMASS and other SMPL-style npz files.

Arrays: ``poses`` (or ``smpl_poses``, ``pose``, ``fullpose``), or ``root_orient`` and ``pose_body``
(or ``global_orient`` and ``body_pose``); ``trans`` (or ``transl``, ``smpl_trans``), metres, divided
by ``smpl_scaling`` where there is one; a frame rate. ``smpl_rotations`` tells rotation vectors,
quaternions, matrices and 6D apart. Only the 22 joints of the body are read: fingers, jaw and eyes,
``betas`` and ``gender`` are skipped, and every performer gets the mean body below. The world of
AMASS has z up, which a posture cannot contradict; another axis is up where the motion shows it over
the whole take, and told where the body stands along it. The world is turned so that y is up; where
the user names the axis, it stays.

Source: Loper et al., "SMPL", ACM Transactions on Graphics 34(6), 2015 (the joints and their order);
Mahmood et al., "AMASS", ICCV 2019 (the arrays). The rest positions are rounded to a centimetre and
made symmetric: proportions of an average adult, not data of the model.

Rotations of SMPL's joints in the forms in which programs write them.

A joint has 3 numbers (rotation vector), 4 (quaternion), 6 (two axes of its matrix) or 9 (matrix).
SMPL has 22 to 24 joints, 52 or 53 with hands, 55 with the face, so the number of columns alone
tells the form; the numbers must agree with it. What they do not tell is found in the body: most
joints turn little, so the largest part of a quaternion is w; and knees and elbows bend one way, so
two axes are either the columns of the matrices or their rows.

Source: Zhou et al., "On the Continuity of Rotation Representations in Neural Networks", CVPR 2019.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, kinematics, rotation, world
from motiondb.body.joint_names import joint_map
from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.array_files import (
    RATES,
    Arrays,
    as_numbers,
    frames_left_out,
    load_npz,
)
from motiondb.files.text import quoted
from motiondb.records import BoolArray, Clip, FloatArray, Skeleton

_TABLE = (
    # joint, parent, rest position (metres; y up, facing +z, left +x, origin as in SMPL)
    ("Pelvis", -1, (0.00, -0.22, 0.03)),
    ("L_Hip", 0, (0.07, -0.31, 0.02)),
    ("R_Hip", 0, (-0.07, -0.31, 0.02)),
    ("Spine1", 0, (0.00, -0.11, 0.00)),
    ("L_Knee", 1, (0.10, -0.69, 0.02)),
    ("R_Knee", 2, (-0.10, -0.69, 0.02)),
    ("Spine2", 3, (0.00, 0.02, 0.00)),
    ("L_Ankle", 4, (0.09, -1.09, -0.03)),
    ("R_Ankle", 5, (-0.09, -1.09, -0.03)),
    ("Spine3", 6, (0.00, 0.07, 0.03)),
    ("L_Foot", 7, (0.12, -1.14, 0.09)),
    ("R_Foot", 8, (-0.12, -1.14, 0.09)),
    ("Neck", 9, (0.00, 0.29, -0.01)),
    ("L_Collar", 9, (0.08, 0.19, -0.01)),
    ("R_Collar", 9, (-0.08, 0.19, -0.01)),
    ("Head", 12, (0.00, 0.35, 0.04)),
    ("L_Shoulder", 13, (0.17, 0.23, -0.02)),
    ("R_Shoulder", 14, (-0.17, 0.23, -0.02)),
    ("L_Elbow", 16, (0.43, 0.21, -0.04)),
    ("R_Elbow", 17, (-0.43, 0.21, -0.04)),
    ("L_Wrist", 18, (0.68, 0.22, -0.04)),
    ("R_Wrist", 19, (-0.68, 0.22, -0.04)),
)
_ENDS = (
    ("Head", (0.0, 0.18, 0.0)),
    ("L_Foot", (0.0, -0.02, 0.07)),
    ("R_Foot", (0.0, -0.02, 0.07)),
    ("L_Wrist", (0.17, -0.01, -0.02)),
    ("R_Wrist", (-0.17, -0.01, -0.02)),
)
N_JOINTS = len(_TABLE)
_POSES = ("poses", "smpl_poses", "pose_world", "pose", "fullpose", "pose_aa")
_PARTS = (("root_orient", "global_orient"), ("pose_body", "body_pose"))
_TRANS = ("trans_world", "trans_orig", "trans", "transl", "smpl_trans", "root_trans_offset")
_SCALE = "smpl_scaling"


def is_amass(names: Sequence[str]) -> bool:
    """Whether arrays of these names are poses of SMPL.

    >>> is_amass(["poses", "trans"]), is_amass(["joint_pos", "fps"])
    (True, False)
    """
    is_robot = "dof" in names or "dof_pos" in names  # whose pkl has pose_aa, too
    return not is_robot and any(name in names for name in (*_POSES, *itertools.chain(*_PARTS)))


def skeleton(unit: float = 1.0) -> Skeleton:
    """Return the mean body, scaled by metres per unit."""
    names = tuple(row[0] for row in _TABLE)
    parents = np.array([row[1] for row in _TABLE])
    rest = np.array([row[2] for row in _TABLE]) * unit
    offsets = rest - np.where(parents[:, None] >= 0, rest[parents], rest)
    return Skeleton(
        names=names,
        parents=parents,
        offsets=offsets,
        end_sites=tuple(
            (names.index(name), (x * unit, y * unit, z * unit)) for name, (x, y, z) in _ENDS
        ),
    )


KEYS = (*_POSES, *itertools.chain(*_PARTS), *_TRANS, _SCALE, *RATES)


def read_amass(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of an npz file."""
    arrays, names = load_npz(data, path, KEYS)
    return read_poses(arrays, names, path, options, len(data))


def read_poses(
    arrays: Arrays, names: tuple[str, ...], path: object, options: ReadOptions, n_bytes: int
) -> Clip:
    """Return the clip of poses by the names of arrays; `names`: of all in the file."""
    found = [name for name in _POSES if name in arrays][:1]
    found = found or [next((n for n in part if n in arrays), part[0]) for part in _PARTS]
    if len(found) == 2 and not set(found) <= set(arrays):
        found = [_POSES[0]]
    poses = [_array(arrays, name, names, path) for name in found]
    trans_name = next((name for name in _TRANS if name in arrays), "trans")
    trans = _array(arrays, trans_name, names, path)
    trans = trans.reshape([size for size in trans.shape[:-1] if size != 1] + [trans.shape[-1]])
    joints = [joint_numbers(array, name, path) for array, name in zip(poses, found)]
    n_frames = len(joints[0])
    if trans.ndim == 1:
        trans = trans[None]
    if trans.shape != (n_frames, 3) or len(joints[-1]) != n_frames:
        raise CaptureError(
            path,
            f"expected {trans_name} of shape ({n_frames}, 3) as {found[0]} has {n_frames} frames, "
            f"found {trans.shape}. Export the file again.",
        )
    check_clip_size(n_frames, N_JOINTS, n_bytes, path, options.limits)
    fps, rate_notes = (options.fps, ()) if options.fps else _frame_rate(arrays, names, path)
    scale = float(np.ravel(_array(arrays, _SCALE, names, path))[0]) if _SCALE in arrays else 1.0
    arrays.clear()  # they hold more than the joints of the body, and are large
    good, notes = _good_frames([*joints, trans], path, options.skip_bad_frames)
    rotations, rotation_notes = to_rotations([part[good] for part in joints], N_JOINTS, path)
    unit = 1.0 if options.unit is None else options.unit
    clip = Clip(
        skeleton=skeleton(unit),
        fps=fps,
        local_rotations=rotation.normalize(rotations),
        root_positions=(trans[good].astype(float) / scale + np.array(_TABLE[0][2])) * unit,
        format="amass",
        unit=unit,
        notes=rate_notes + notes + rotation_notes,
    )
    return replace(clip, up=options.up) if options.up else _with_y_up(clip)


_DOUBTFUL = (
    "z is taken for up, as in AMASS: the motion does not show for certain which axis is up. Give "
    "the axis (--up) if this is wrong."
)


def _with_y_up(clip: Clip) -> Clip:
    """Turn the world of the data, in which z is up unless the motion shows otherwise."""
    positions, _ = kinematics.clip_positions(clip)
    points = np.full((clip.n_frames, len(body.JOINTS), 3), np.nan)
    for role, joint in joint_map(clip.skeleton).items():
        if joint >= 0:
            points[:, body.INDEX[role]] = positions[:, joint]
    found = world.find_up(points, clip.fps, usual="z")
    up, notes = (found.up, found.notes) if found.is_sure else ("z", (_DOUBTFUL,))
    turn = np.broadcast_to(world.to_y_up(up), (clip.n_frames, 4))
    rotations = clip.local_rotations.copy()
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    return replace(
        clip,
        local_rotations=rotations,
        root_positions=rotation.rotate(turn, clip.root_positions),
        notes=clip.notes + notes,
        up="y",
    )


def _array(
    arrays: dict[str, NDArray[np.generic]], name: str, names: tuple[str, ...], path: object
) -> NDArray[np.generic]:
    """Return an array of real numbers by its name; `names`: of all arrays, for the message."""
    if name not in arrays:
        present = ", ".join(quoted(other) for other in sorted(names)[:20]) or "none"
        raise CaptureError(
            path, f"expected an array {name!r}, found {present}. Is this a motion of AMASS?"
        )
    if arrays[name].dtype.kind not in "iuf":
        raise CaptureError(path, f"expected numbers in {name!r}, found other values.")
    return np.atleast_1d(arrays[name])


def _good_frames(
    parts: list[NDArray[np.generic]], path: object, skip_bad: bool
) -> tuple[BoolArray, tuple[str, ...]]:
    """Say which frames are finite in all parts, and note it where some are left out."""
    n_frames = len(parts[0])
    if n_frames == 0:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    good = np.all([np.isfinite(part.reshape(n_frames, -1)).all(axis=1) for part in parts], axis=0)
    notes = frames_left_out(good, path, skip_bad, "finite numbers", "NaN or infinity")
    return good, notes


def _frame_rate(
    arrays: dict[str, NDArray[np.generic]], names: tuple[str, ...], path: object
) -> tuple[float, tuple[str, ...]]:
    """Return the frame rate under the first of its usual names that there is, and notes."""
    rates: dict[str, float] = {}
    for name in RATES:
        if name in arrays:
            values = _array({name: as_numbers(arrays[name])}, name, names, path)
            if np.unique(values).size != 1:
                raise CaptureError(
                    path,
                    f"expected one number in {name}, found {values.size}. "
                    "Give the right frame rate with --fps.",
                )
            rates[name] = float(values.reshape(-1).astype(float)[0])
    if not rates and _SCALE in names:
        told = "The file has no frame rate; 60 a second are taken, as in AIST++. Give another one "
        return 60.0, (told + "(--fps) if this is wrong.",)
    if not rates:
        raise CaptureError(
            path, "expected a frame rate (mocap_framerate or fps), found none. Give it with --fps."
        )
    first, *others = rates
    fps = check_rate(rates[first], path, first)
    if all(math.isclose(rates[name], fps, rel_tol=1e-3) for name in others):
        return fps, ()
    said = " and ".join(f"{name} {rate:g}" for name, rate in rates.items())
    return fps, (
        f"The file has {said}; {fps:g} is taken. Give the right one (--fps) if this is wrong.",
    )


_FORMS: Mapping[int, str] = MappingProxyType(
    {3: "rotation vectors", 4: "quaternions", 6: "6D rotations", 9: "matrices"}
)  # By numbers a joint
_WHOLE, _ROOT, _BODY = (22, 23, 24, 52, 53, 55), (1,), (21, 22, 23, 51, 52, 54)
"""Numbers of joints of arrays of all, of the root alone, and of the others."""
_NEAR = 0.01  # How far lengths and products may be from 1 and 0; half precision is within 0.001
_DEGREES = 10.0
"""Length of the longest rotation vector below the root, in the median over frames, that only
degrees have: a joint that turns by 573 degrees does not exist, and arms hang 60 degrees from a
T-pose."""
_ROOT_DEGREES = 30.0
"""The same of the root, which may turn on: five turns. Where z is up, 90 degrees are usual."""
_W_LEADS = 0.1  # By how much w must be larger than the last part in the mean
_BENDS_SURELY = 0.3  # Radians: the usual order of matrices is left only for clear bends
_BENDS = 0.02  # Radians by which knees and elbows must bend in the mean to tell rows from columns
_KNEES, _ELBOWS = (4, 5), (18, 19)  # Left and right


def joint_numbers(array: NDArray[np.generic], name: str, path: object) -> NDArray[np.generic]:
    """Return an array of any shape as (frames, joints, numbers a joint)."""
    counts = _ROOT if "orient" in name else _BODY if "body" in name else _WHOLE
    for tried in (array, array[0]) if array.ndim > 2 and len(array) == 1 else (array,):
        rest = tried.shape[1:]
        for size in _FORMS:
            count = math.prod(rest) // size if rest else 0
            shapes = [(count * size,), (count, size), (count, 3, 3), (3, 3)][
                : 4 if size == 9 else 2
            ]
            if count in counts and rest in shapes and math.prod(rest) == count * size:
                return tried.reshape(len(tried), count, size)
    if array.ndim > 2 and math.prod(array.shape[2:]) // 3 in counts:
        raise CaptureError(
            path,
            f"expected poses of one body, found {len(array)} in {name} of shape {array.shape}. "
            "Save each in a file of its own.",
        )
    raise CaptureError(
        path,
        f"expected {name} with 3, 4, 6 or 9 numbers for each of {', '.join(map(str, counts))} "
        f"joints, found shape {array.shape}. Export the poses of the SMPL body as axis-angle.",
    )


def to_rotations(
    parts: Sequence[NDArray[np.generic]], n_joints: int, path: object
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return quaternions (frames, joints, 4) of the first joints of parts, and notes."""
    if len({part.shape[2] for part in parts}) == 1:
        parts = [np.concatenate(parts, axis=1)]
    found, notes, first = [], [], 0
    for part in parts:
        numbers = part[:, : n_joints - first].astype(float)
        how = {3: _of_vectors, 4: _of_quaternions, 6: _of_axes, 9: _of_matrices}[part.shape[2]]
        rotations, note = how(numbers, first, path)
        found.append(rotations)
        notes += [note] if note else []
        first += numbers.shape[1]
    return np.concatenate(found, axis=1), tuple(notes)


def _of_vectors(numbers: FloatArray, first: int, _path: object) -> tuple[FloatArray, str]:
    """Take rotation vectors in radians, or in degrees if they are too long."""
    lengths = np.linalg.norm(numbers, axis=-1)
    roots, joints = np.split(lengths, [1 - min(first, 1)], axis=1)
    longest = (float(np.median(part.max(axis=1, initial=0.0))) for part in (roots, joints))
    if all(length <= most for length, most in zip(longest, (_ROOT_DEGREES, _DEGREES))):
        return rotation.exp(numbers), ""
    return rotation.exp(np.radians(numbers)), "The angles are too large for radians: degrees."


def _of_quaternions(numbers: FloatArray, _first: int, path: object) -> tuple[FloatArray, str]:
    """Take quaternions with w at the beginning or at the end, where the larger part is."""
    lengths = np.linalg.norm(numbers, axis=-1)
    if np.abs(lengths - 1.0).max() > _NEAR:
        raise _refused(path, 4, f"lengths from {lengths.min():.3g} to {lengths.max():.3g}")
    begin, end = (float(np.abs(numbers[..., place]).mean()) for place in (0, 3))
    if abs(begin - end) < _W_LEADS:
        raise _refused(path, 4, "no part that is the largest")
    return (numbers if begin > end else np.roll(numbers, 1, axis=-1)), ""


def _of_axes(numbers: FloatArray, first: int, path: object) -> tuple[FloatArray, str]:
    """Take two columns of matrices, one after the other or number by number, or two rows."""
    in_turn = numbers.reshape(*numbers.shape[:2], 3, 2)
    one_by_one = np.swapaxes(numbers.reshape(*numbers.shape[:2], 2, 3), -1, -2)
    layouts = [layout for layout in (one_by_one, in_turn) if _are_orthonormal(layout)]
    if not layouts:
        raise _refused(path, 6, "axes that are not orthonormal")
    columns = layouts[0]
    third = np.cross(columns[..., 0], columns[..., 1])
    rotations = rotation.from_matrix(np.concatenate([columns, third[..., None]], axis=-1))
    if columns is in_turn:
        return rotations, ""
    bends = _bends(rotations, first)
    if abs(bends) < _BENDS:
        raise _refused(path, 6, "no bent knees or elbows to tell whether they are columns or rows")
    return (rotations if bends > 0 else rotation.conjugate(rotations)), ""


def _of_matrices(numbers: FloatArray, first: int, path: object) -> tuple[FloatArray, str]:
    """Take matrices row by row, or column by column if knees and elbows bend the other way."""
    matrices = numbers.reshape(*numbers.shape[:2], 3, 3)
    if not _are_orthonormal(matrices) or np.linalg.det(matrices).min() < 0:
        raise _refused(path, 9, "ones that are no rotations")
    rotations = rotation.from_matrix(matrices)
    if _bends(rotations, first) > -_BENDS_SURELY:
        return rotations, ""
    return rotation.conjugate(rotations), "Knees and elbows show matrices column by column."


def _are_orthonormal(axes: FloatArray) -> bool:
    """Say whether the columns (..., 3, n) have length 1 and are orthogonal to one another."""
    products = np.einsum("...ki,...kj->...ij", axes, axes)
    return bool(np.abs(products - np.eye(axes.shape[-1])).max() < _NEAR)


def _bends(rotations: FloatArray, first: int) -> float:
    """Return by how much knees and elbows bend as they can, radians; negative the other way."""
    vectors = rotation.log(rotations)
    total = 0.0
    for (left, right), axis, signs in ((_KNEES, 0, (1, 1)), (_ELBOWS, 1, (-1, 1))):
        for joint, sign in zip((left - first, right - first), signs):
            if 0 <= joint < vectors.shape[1]:
                total += sign * float(vectors[:, joint, axis].mean()) / 2.0
    return total


def _refused(path: object, size: int, found: str) -> CaptureError:
    """Return the error that poses look like a form, but cannot be read in it."""
    return CaptureError(
        path,
        f"expected {_FORMS[size]}, as {size} numbers a joint look like, found {found}. "
        "Export the poses of the SMPL body as axis-angle.",
    )
