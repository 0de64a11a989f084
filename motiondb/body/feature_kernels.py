"""Compiled parts of the features of recognition, the same to the last bit as in numpy.

They follow :mod:`.kinematics` and :mod:`.rotation` operation by operation.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray


@njit(cache=True, nogil=True)
def forward(
    parents: IntArray,
    offsets: FloatArray,
    local_rotations: Float32Array | FloatArray,
    roots: Float32Array | FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """As ``kinematics.forward``: positions (frames, joints, 3), rotations (frames, joints, 4).

    Shapes: `parents` (joints,); `offsets` (joints, 3); `local_rotations` (frames, joints, 4);
    `roots` (frames, 3).
    """
    n_frames, n_joints = local_rotations.shape[:2]
    places, turns = np.empty((n_frames, n_joints, 3)), np.empty((n_frames, n_joints, 4))
    local = local_rotations.astype(np.float64)
    for n in range(n_frames):
        for j in range(n_joints):
            place, turn, q = places[n, j], turns[n, j], local[n, j]
            if parents[j] < 0:
                place[:] = roots[n]
                turn[:] = q
                continue
            since, before = places[n, parents[j]], turns[n, parents[j]]
            a, b, c = _rotated(before, offsets[j, 0], offsets[j, 1], offsets[j, 2])
            place[0], place[1], place[2] = since[0] + a, since[1] + b, since[2] + c
            w, x, y, z = before
            turn[0] = w * q[0] - x * q[1] - y * q[2] - z * q[3]
            turn[1] = w * q[1] + x * q[0] + y * q[3] - z * q[2]
            turn[2] = w * q[2] - x * q[3] + y * q[0] + z * q[1]
            turn[3] = w * q[3] + x * q[2] - y * q[1] + z * q[0]
    return places, turns


@njit(cache=True, nogil=True)
def _rotated(q: FloatArray, a: float, b: float, c: float) -> tuple[float, float, float]:
    """A vector (a, b, c), rotated by q (4,)."""
    w, x, y, z = q
    s, t, u = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return a + w * s + (y * u - z * t), b + w * t + (z * s - x * u), c + w * u + (x * t - y * s)


@njit(cache=True, nogil=True)
def mean_axes(rotations: FloatArray, joints: tuple[int, int]) -> FloatArray:
    """Means of the left, the upward and the forward axes of two joints: array (3, frames, 3).

    Shapes: `rotations` (frames, joints, 4).
    """
    axes, units = np.empty((3, len(rotations), 3)), np.eye(3)
    for n in range(len(rotations)):
        for k in range(3):
            a, b, c = units[k]
            x, y, z = _rotated(rotations[n, joints[0]], a, b, c)
            a, b, c = _rotated(rotations[n, joints[1]], a, b, c)
            axes[k, n, 0], axes[k, n, 1], axes[k, n, 2] = (x + a) / 2, (y + b) / 2, (z + c) / 2
    return axes


@njit(cache=True, nogil=True)
def relative_to_heading(positions: FloatArray, facing: FloatArray) -> FloatArray:
    """Positions seen from above the pelvis: array (frames, joints, 3).

    Shapes: `positions` (frames, joints, 3); `facing` (frames, 4): rotations about y.
    """
    local = np.empty_like(positions)
    for n in range(len(positions)):
        x, z = positions[n, 0, 0], positions[n, 0, 2]
        for j in range(positions.shape[1]):
            a, b, c = positions[n, j]
            local[n, j] = _rotated(facing[n], a - x, b, c - z)
    return local
