"""Rotations of the canonical body by compiled code, frame by frame.

Quaternions are tuples (w, x, y, z) here, vectors (x, y, z); :mod:`.rotation` has the same formulas.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from motiondb.records import FloatArray, IntArray

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
