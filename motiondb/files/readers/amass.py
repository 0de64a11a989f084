"""Reader of AMASS and other SMPL-style npz files: axis-angle poses of the SMPL body.

Arrays: ``poses`` (frames, 66 or more), three numbers a joint, radians; or ``root_orient``
(frames, 3) and ``pose_body`` (frames, 63); ``trans`` (frames, 3), metres; a frame rate. Only the 22
joints of the body are read: fingers, jaw and eyes, ``betas`` and ``gender`` are skipped, and
every performer gets the mean body below. The world of AMASS has z up; it is turned so that y is
up. A file whose bodies are already upright along y is not changed.

Sizes and types of the arrays are checked before any array is unpacked, because a few kilobytes of
compressed zeros can unpack to gigabytes.

Source: Loper et al., "SMPL", ACM Transactions on Graphics 34(6), 2015 (the joints and their order);
Mahmood et al., "AMASS", ICCV 2019 (the arrays). The rest positions are rounded to a centimetre and
made symmetric: proportions of an average adult, not data of the model.
"""

from __future__ import annotations

import io
import math
import warnings
import zipfile

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from motiondb.body import rotation
from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, ReadOptions, check_clip_size, check_rate
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
_UNPACKED, _RATIO = 256_000_000, 20
"""Bytes to which the arrays of a file may unpack, or this multiple of the file's size if that is
more. An hour of poses at 60 frames a second takes 270 MB, and compressed motion has at least a
third of its size; compressed zeros have a thousandth."""
_UPRIGHT = 0.7
"""Median cosine between the body's axis and the world's y above which the world has y up: the body
stands within 45 degrees of y for most of the time."""
_Y_UP = rotation.from_axis_angle((1.0, 0.0, 0.0), -np.pi / 2)
"""Turns a world with z up into one with y up."""


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


def read_amass(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of an npz file."""
    arrays = _load(data, path)
    poses, trans = _poses(arrays, path), _array(arrays, "trans", path)
    if trans.shape != (len(poses), 3):
        raise CaptureError(
            path,
            f"expected trans of shape ({poses.shape[0]}, 3) as poses has {poses.shape[0]} frames, "
            f"found {trans.shape}. Export the file again.",
        )
    check_clip_size(len(poses), N_JOINTS, len(data), path, options.limits)
    fps = options.fps or _frame_rate(arrays, path)
    arrays.clear()  # they hold more than the joints of the body, and are large
    poses, trans, notes = _good_frames(
        poses.astype(float), trans.astype(float), path, options.skip_bad_frames
    )
    unit = 1.0 if options.unit is None else options.unit
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
        fps=fps,
        local_rotations=rotation.normalize(rotations),
        root_positions=roots,
        format="amass",
        unit=unit,
        notes=notes,
    )


def _load(data: bytes, path: object) -> dict[str, NDArray[np.generic]]:
    """Return the arrays that can be read without running code from the file."""
    wanted = {f"{name}.npy": name for name in ("poses", "trans", "root_orient", "pose_body")}
    wanted |= {f"{name}.npy": name for name in _RATES}
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as file:
            members = [info for info in file.infolist() if info.filename in wanted]
            unpacked = sum(info.file_size for info in members)
            if unpacked > max(_UNPACKED, _RATIO * len(data)):
                raise CaptureError(
                    path,
                    f"expected arrays of at most {max(_UNPACKED, _RATIO * len(data)) / 1e6:.4g} "
                    f"MB, found {unpacked / 1e6:.4g} MB packed into {len(data) / 1e6:.4g} MB. "
                    "Save the motion again, without other data.",
                )
            return {wanted[info.filename]: _read_array(file, info) for info in members}
    except CaptureError:
        raise
    except Exception as error:  # zipfile and NumPy raise some sixteen kinds for other files
        raise CaptureError(
            path, "expected an npz file of plain arrays, found something else. Save it again."
        ) from error


def _read_array(file: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[np.generic]:
    """The array of a member that its header fits, unpacked piece by piece."""
    with file.open(info) as member:
        version = npy.read_magic(member)
        read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        with warnings.catch_warnings():  # odd headers make Python's parser warn beside its errors
            warnings.simplefilter("ignore", SyntaxWarning)
            shape, _, dtype = read_header(member)
    if dtype.hasobject or any(length < 0 for length in shape):
        raise ValueError("objects, or a negative length")
    size = info.file_size
    if math.prod(shape) * dtype.itemsize > size or math.prod(shape) > size:
        raise ValueError("less data than the header says")
    with file.open(info) as member, warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)
        return np.asarray(npy.read_array(member, allow_pickle=False))


def _array(arrays: dict[str, NDArray[np.generic]], name: str, path: object) -> NDArray[np.generic]:
    """Return an array of real numbers by its name."""
    if name not in arrays:
        present = ", ".join(sorted(arrays)) or "none of the known"
        raise CaptureError(
            path, f"expected an array {name!r}, found {present}. Is this a motion of AMASS?"
        )
    if arrays[name].dtype.kind not in "iuf":
        raise CaptureError(path, f"expected numbers in {name!r}, found other values.")
    return arrays[name]


def _poses(arrays: dict[str, NDArray[np.generic]], path: object) -> NDArray[np.generic]:
    """Return the axis-angle poses (frames, 66) of the body, radians, in the file's type."""
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
    """Return poses and translations of the finite frames, and a note where some are left out."""
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


def _frame_rate(arrays: dict[str, NDArray[np.generic]], path: object) -> float:
    """Return the frame rate under any of its usual names."""
    for name in _RATES:
        if name in arrays:
            values = _array(arrays, name, path)
            if values.size != 1:
                raise CaptureError(
                    path,
                    f"expected one number in {name}, found {values.size}. "
                    "Give the right frame rate with --fps.",
                )
            return check_rate(float(values.reshape(-1).astype(float)[0]), path, name)
    raise CaptureError(
        path, "expected a frame rate (mocap_framerate or fps), found none. Give it with --fps."
    )


def _is_z_up(root_rotations: FloatArray) -> bool:
    """Return whether the bodies' up axis is closer to the world's z axis than to y."""
    up = rotation.rotate(
        root_rotations, np.broadcast_to([0.0, 1.0, 0.0], root_rotations[:, 1:].shape)
    )
    y, z = np.median(up[:, 1]), np.median(up[:, 2])
    return not (y > _UPRIGHT and y > z)
