"""AMASS and other SMPL-style npz: axis-angle poses of the SMPL body.

Arrays: ``poses`` (frames, 66 or more), three numbers a joint, radians; or ``root_orient``
(frames, 3) and ``pose_body`` (frames, 63); ``trans`` (frames, 3), metres; a frame rate. Only the 22
joints of the body are read: fingers, jaw and eyes, ``betas`` and ``gender`` are passed over, and
every performer gets the mean body below. The world of AMASS has z up and is turned so that y is;
a file whose bodies stand along y already is left as it is.

Source: Loper et al., "SMPL", ACM Transactions on Graphics 34(6), 2015 (the joints and their order);
Mahmood et al., "AMASS", ICCV 2019 (the arrays). The rest positions are rounded to a centimetre and
made symmetric: proportions of an average adult, not data of the model.
"""

from __future__ import annotations

import io
import struct
import zipfile
import zlib

import numpy as np

from motiondb.errors import CaptureError
from motiondb.pose import rotation
from motiondb.records import Clip, FloatArray, Skeleton

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
_RATES = ("mocap_framerate", "mocap_frame_rate", "fps", "framerate", "frame_rate")
_UNREADABLE = (
    ValueError, OSError, EOFError, KeyError, AttributeError, RuntimeError, NotImplementedError,
    struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What NumPy and zipfile raise for files that are none."""
_Y_UP = rotation.from_axis_angle((1.0, 0.0, 0.0), -np.pi / 2)
"""Turns a world with z up into one with y up."""


def skeleton(unit: float = 1.0) -> Skeleton:
    """The mean body, scaled by metres per unit."""
    names = tuple(row[0] for row in _TABLE)
    parents = np.array([row[1] for row in _TABLE])
    rest = np.array([row[2] for row in _TABLE]) * unit
    offsets = rest - np.where(parents[:, None] >= 0, rest[parents], rest)
    turns = ("Zrotation", "Yrotation", "Xrotation")
    return Skeleton(
        names=names,
        parents=parents,
        offsets=offsets,
        end_sites=tuple(
            (names.index(name), (x * unit, y * unit, z * unit)) for name, (x, y, z) in _ENDS
        ),
        channels=(("Xposition", "Yposition", "Zposition", *turns), *[turns] * (N_JOINTS - 1)),
    )


def read_amass(
    data: bytes,
    path: object,
    *,
    fps: float | None = None,
    unit: float | None = None,
    skip_bad_frames: bool = False,
) -> Clip:
    """The clip in the bytes of an npz file.

    Parameters
    ----------
    data : the file's bytes.
    path : the file as messages shall name it.
    fps : frames per second, in place of what the file says.
    unit : metres per length unit of ``trans``; None: 1. The body is scaled alike.
    skip_bad_frames : leave out frames that are not finite instead of refusing the file.

    Raises
    ------
    CaptureError
        for files that are no npz, lack an array, or hold arrays of wrong shapes.
    """
    arrays = _load(data, path)
    poses, trans = _poses(arrays, path), _array(arrays, "trans", path)
    if poses.shape[0] != trans.shape[0] or trans.ndim != 2 or trans.shape[1] != 3:
        raise CaptureError(
            path,
            f"expected trans of shape ({poses.shape[0]}, 3) as poses has {poses.shape[0]} frames, "
            f"found {trans.shape}. Export the file again.",
        )
    poses, trans, notes = _good_frames(poses, trans, path, skip_bad_frames)
    unit = 1.0 if unit is None else unit
    rotations = rotation.exp(poses.reshape(len(poses), N_JOINTS, 3))
    roots = (trans + np.array(_TABLE[0][2])) * unit
    if _is_z_up(rotations[:, 0]):
        rotations[:, 0] = rotation.multiply(
            np.broadcast_to(_Y_UP, (len(poses), 4)), rotations[:, 0]
        )
        roots = rotation.rotate(np.broadcast_to(_Y_UP, (len(poses), 4)), roots)
    else:
        notes += ("The bodies stand along y: the world is taken to have y up.",)
    return Clip(
        skeleton=skeleton(unit),
        fps=_frame_rate(arrays, path) if fps is None else fps,
        local_rotations=rotation.normalize(rotations),
        root_positions=roots,
        format="amass",
        unit=unit,
        notes=notes,
    )


def _load(data: bytes, path: object) -> dict[str, np.ndarray]:
    """The arrays that can be read without running code from the file."""
    arrays = {}
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            for name in file.files:
                if name in ("poses", "trans", "root_orient", "pose_body", *_RATES):
                    arrays[name] = file[name]
    except _UNREADABLE as error:
        raise CaptureError(
            path, "expected an npz file of plain arrays, found something else. Save it again."
        ) from error
    return arrays


def _array(arrays: dict[str, np.ndarray], name: str, path: object) -> FloatArray:
    if name not in arrays:
        found = ", ".join(sorted(arrays)) or "none of the known"
        raise CaptureError(
            path, f"expected an array {name!r}, found {found}. Is this a motion of AMASS?"
        )
    try:
        return np.asarray(arrays[name], dtype=float)
    except (ValueError, TypeError) as error:
        raise CaptureError(path, f"expected numbers in {name!r}, found other values.") from error


def _poses(arrays: dict[str, np.ndarray], path: object) -> FloatArray:
    """Axis-angle (frames, 66) of the body."""
    if "poses" not in arrays and {"root_orient", "pose_body"} <= set(arrays):
        parts = [_array(arrays, name, path) for name in ("root_orient", "pose_body")]
        if all(part.ndim == 2 for part in parts) and len(parts[0]) == len(parts[1]):
            arrays["poses"] = np.concatenate(parts, axis=1)
    poses = _array(arrays, "poses", path)
    if poses.ndim == 3 and poses.shape[2] == 3:
        poses = poses.reshape(len(poses), -1)
    if poses.ndim != 2 or poses.shape[1] < 3 * N_JOINTS:
        raise CaptureError(
            path,
            f"expected poses of shape (frames, {3 * N_JOINTS} or more), found {poses.shape}. "
            "Export the poses of the SMPL body as axis-angle.",
        )
    return poses[:, : 3 * N_JOINTS]


def _good_frames(
    poses: FloatArray, trans: FloatArray, path: object, skip_bad: bool
) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Poses and translations of the finite frames, and a note where some are left out."""
    if len(poses) == 0:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    good = np.isfinite(poses).all(axis=1) & np.isfinite(trans).all(axis=1)
    if good.all():
        return poses, trans, ()
    count, first = int((~good).sum()), int(np.argmin(good))
    if not skip_bad or not good.any():
        raise CaptureError(
            path,
            f"expected finite numbers, found NaN or infinity in {count} frames, the first is "
            f"{first}. Export it again, or pass --skip-bad-frames to leave them out.",
        )
    return poses[good], trans[good], (f"Left out {count} bad frames; the first is {first}.",)


def _frame_rate(arrays: dict[str, np.ndarray], path: object) -> float:
    for name in _RATES:
        if name in arrays:
            rate = float(np.asarray(arrays[name]).reshape(-1)[0])
            if 1.0 <= rate <= 2000.0:
                return rate
            raise CaptureError(
                path,
                f"expected {name} from 1 to 2000, found {rate:g}. "
                "Give the right frame rate with --fps.",
            )
    raise CaptureError(
        path, "expected a frame rate (mocap_framerate or fps), found none. Give it with --fps."
    )


def _is_z_up(root_rotations: FloatArray) -> bool:
    """Whether the bodies' own up lies less along the world's y than along its z."""
    up = rotation.rotate(
        root_rotations, np.broadcast_to([0.0, 1.0, 0.0], root_rotations[:, 1:].shape)
    )
    y, z = np.median(up[:, 1]), np.median(up[:, 2])
    return not (y > 0.7 and y > z)
