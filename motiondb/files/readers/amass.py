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
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, kinematics, rotation, world
from motiondb.body.joint_names import joint_map
from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.array_files import RATES, Arrays, frames_left_out, load_npz
from motiondb.files.readers.smpl_rotations import joint_numbers, to_rotations
from motiondb.files.text import quoted
from motiondb.records import BoolArray, Clip, Skeleton

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
_POSES = ("poses", "smpl_poses", "pose", "fullpose")
_PARTS = (("root_orient", "global_orient"), ("pose_body", "body_pose"))
_TRANS = ("trans", "transl", "smpl_trans")
_SCALE = "smpl_scaling"


def is_amass(names: Sequence[str]) -> bool:
    """Whether arrays of these names are poses of SMPL.

    >>> is_amass(["poses", "trans"]), is_amass(["joint_pos", "fps"])
    (True, False)
    """
    return any(name in names for name in (*_POSES, *itertools.chain(*_PARTS)))


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
    trans_name = next((name for name in _TRANS if name in arrays), _TRANS[0])
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
            values = _array(arrays, name, names, path)
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
