"""Rotations of SMPL's joints in the forms in which programs write them.

A joint has 3 numbers (rotation vector), 4 (quaternion), 6 (two axes of its matrix) or 9 (matrix).
SMPL has 22 to 24 joints, 52 or 53 with hands, 55 with the face, so the number of columns alone
tells the form; the numbers must agree with it. What they do not tell is found in the body: most
joints turn little, so the largest part of a quaternion is w; and knees and elbows bend one way, so
two axes are either the columns of the matrices or their rows.

Source: Zhou et al., "On the Continuity of Rotation Representations in Neural Networks", CVPR 2019.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from motiondb.body import rotation
from motiondb.errors import CaptureError
from motiondb.records import FloatArray

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
