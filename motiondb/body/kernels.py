"""Compiled code of the body: parts of the features, and the rotations of the canonical body.

The features are the same to the last bit as in numpy: their kernels follow :mod:`.kinematics` and
:mod:`.rotation` operation by operation. Rotations are solved frame by frame; quaternions are tuples
(w, x, y, z) there, vectors (x, y, z), and :mod:`.rotation` has the same formulas.
"""

from __future__ import annotations

import math

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


Triple = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
_TINY = 1e-12  # As in ``rotation``
_OPPOSITE = 1e-8  # As in ``rotation``


@njit(cache=True, nogil=True)
def solve(
    points: FloatArray,
    trunk: IntArray,
    swings: IntArray,
    rest: FloatArray,
    collar_from_neck: FloatArray,
) -> FloatArray:
    """Rotations (frames, joints, 4) that point the canonical bones like points (frames, joints, 3).

    Shapes: `trunk` (8,): pelvis, spine, chest, neck, left and right hip, left and right shoulder;
    `swings` (bones, 4): joint, its parent, the joint at the bone's end, and the side (1, -1) of a
    collar, which begins where the canonical body has it, else 0; `rest` (joints, 3): offsets;
    `collar_from_neck` (3,): of the left.
    """
    n_frames, n_joints = points.shape[:2]
    local, world = np.zeros((n_frames, n_joints, 4)), np.zeros((n_joints, 4))
    local[:, :, 0] = 1.0
    pelvis, spine, chest, neck, l_hip, r_hip, l_shoulder, r_shoulder = trunk
    for n in range(n_frames):
        p = points[n]
        low = _frame_of(_way(p, r_hip, l_hip), _way(p, pelvis, spine))
        high = _frame_of(_way(p, r_shoulder, l_shoulder), _way(p, chest, neck))
        a, b = _rotate(low, (1.0, 0.0, 0.0)), _rotate(high, (1.0, 0.0, 0.0))
        left = a[0] + b[0], a[1] + b[1], a[2] + b[2]
        middle = _frame_of(left, _way(p, spine, chest))
        _set(local, n, pelvis, low)
        _set(local, n, spine, _multiply(_conjugate(low), middle))
        _set(local, n, chest, _multiply(_conjugate(middle), high))
        world[chest] = high
        world[pelvis] = low
        for joint, parent, end, side in swings:
            before = _quaternion(world[parent])
            bone = _way(p, joint, end)
            if side:
                x, y, z = collar_from_neck
                off = _rotate(high, (side * x, y, z))
                bone = (
                    p[end, 0] - (p[neck, 0] + off[0]),
                    p[end, 1] - (p[neck, 1] + off[1]),
                    p[end, 2] - (p[neck, 2] + off[2]),
                )
            direction = _rotate(_conjugate(before), bone)
            turn = _between((rest[end, 0], rest[end, 1], rest[end, 2]), direction)
            _set(local, n, joint, turn)
            world[joint] = _multiply(before, turn)
    return local


@njit(cache=True, nogil=True)
def _set(local: FloatArray, n: int, joint: int, q: Quaternion) -> None:
    for k in range(4):
        local[n, joint, k] = q[k]


@njit(cache=True, nogil=True)
def _quaternion(q: FloatArray) -> Quaternion:
    return q[0], q[1], q[2], q[3]


@njit(cache=True, nogil=True)
def _way(p: FloatArray, start: int, end: int) -> Triple:
    """From one joint of a frame (joints, 3) to another."""
    return p[end, 0] - p[start, 0], p[end, 1] - p[start, 1], p[end, 2] - p[start, 2]


@njit(cache=True, nogil=True)
def _conjugate(q: Quaternion) -> Quaternion:
    return q[0], -q[1], -q[2], -q[3]


@njit(cache=True, nogil=True)
def _multiply(p: Quaternion, q: Quaternion) -> Quaternion:
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@njit(cache=True, nogil=True)
def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, nogil=True)
def _rotate(q: Quaternion, v: Triple) -> Triple:
    axis = q[1], q[2], q[3]
    a, b, c = _cross(axis, v)
    t = 2.0 * a, 2.0 * b, 2.0 * c
    u = _cross(axis, t)
    return (
        v[0] + q[0] * t[0] + u[0],
        v[1] + q[0] * t[1] + u[1],
        v[2] + q[0] * t[2] + u[2],
    )


@njit(cache=True, nogil=True)
def _unit(v: Triple) -> Triple:
    size = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    size = size if size > _TINY else 1.0
    return v[0] / size, v[1] / size, v[2] / size


@njit(cache=True, nogil=True)
def _unit_quaternion(w: float, x: float, y: float, z: float) -> Quaternion:
    size = math.sqrt(w * w + x * x + y * y + z * z)
    size = size if size > _TINY else 1.0
    return w / size, x / size, y / size, z / size


@njit(cache=True, nogil=True)
def _frame_of(left: Triple, up: Triple) -> Quaternion:
    """The rotation with x axis ``left``, and y axis ``up`` made orthogonal to it."""
    x = _unit(left)
    z = _unit(_cross(x, up))
    y = _cross(z, x)
    trace = x[0] + y[1] + z[2]
    sums = (1 + trace, 1 + 2 * x[0] - trace, 1 + 2 * y[1] - trace, 1 + 2 * z[2] - trace)
    a, b, c = y[2] - z[1], z[0] - x[2], x[1] - y[0]
    xy, xz, yz = y[0] + x[1], z[0] + x[2], z[1] + y[2]
    if sums[0] >= sums[1] and sums[0] >= sums[2] and sums[0] >= sums[3]:
        return _unit_quaternion(sums[0], a, b, c)
    if sums[1] >= sums[2] and sums[1] >= sums[3]:
        return _unit_quaternion(a, sums[1], xy, xz)
    if sums[2] >= sums[3]:
        return _unit_quaternion(b, xy, sums[2], yz)
    return _unit_quaternion(c, xz, yz, sums[3])


@njit(cache=True, nogil=True)
def _between(u: Triple, v: Triple) -> Quaternion:
    """The smallest rotation from u to v; half a turn where they are opposite."""
    u, v = _unit(u), _unit(v)
    w = 1.0 + (u[0] * v[0] + u[1] * v[1] + u[2] * v[2])
    if w > _OPPOSITE:
        x, y, z = _cross(u, v)
        return _unit_quaternion(w, x, y, z)
    a, b, c = abs(u[0]), abs(u[1]), abs(u[2])
    least = (1.0, 0.0, 0.0)
    if b < a and b <= c:
        least = (0.0, 1.0, 0.0)
    elif c < a and c < b:
        least = (0.0, 0.0, 1.0)
    x, y, z = _cross(u, least)
    return _unit_quaternion(0.0, x, y, z)
