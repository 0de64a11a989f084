"""Rotation algebra on the last axis; all leading axes are broadcast.

A rotation is a unit quaternion q = (w, x, y, z), array (..., 4); ``multiply(p, q)`` applies q
first, then p. Euler angles follow the BVH convention: order "ZXY" means R = Rz Rx Ry, the
channel that is written first is applied last.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from motiondb.records import FloatArray

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
_TINY = 1e-12
"""Lengths below this count as zero; far below the precision of float64 at a length of 1."""
_SMALL_SINE = 1e-9
"""Below this sine, the limit of a quotient is used instead of the quotient of small numbers."""
_LOCKED = 1.0 - 1e-10
"""Sine of the middle Euler angle beyond which the two others cannot be distinguished in float64."""
_OPPOSITE = 1e-8
"""1 + cosine below which two directions count as opposite, so that their cross product is noise."""


def multiply(p: FloatArray, q: FloatArray) -> FloatArray:
    """Return the Hamilton product p q (..., 4); q is applied first.

    >>> multiply(np.array([0., 1, 0, 0]), np.array([0., 0, 1, 0]))
    array([0., 0., 0., 1.])
    """
    pw, px, py, pz = p[..., 0], p[..., 1], p[..., 2], p[..., 3]
    qw, qx, qy, qz = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    return np.stack(
        [
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ],
        axis=-1,
    )


def conjugate(q: FloatArray) -> FloatArray:
    """Return the inverse of unit quaternions (..., 4)."""
    return q * np.array([1.0, -1.0, -1.0, -1.0], dtype=q.dtype)


def relative(parent: FloatArray, world: FloatArray) -> FloatArray:
    """The rotation that turns ``parent`` into ``world``, in the parent's frame.

    >>> relative(from_euler([30.0], "Y"), from_euler([50.0], "Y")).round(6).tolist()
    [0.984808, 0.0, 0.173648, 0.0]
    """
    return multiply(conjugate(parent), world)


def rotate(q: FloatArray, v: FloatArray) -> FloatArray:
    """Rotate the vectors v (..., 3) by q (..., 4).

    >>> rotate(from_euler([90.0], "Y"), np.array([0., 0, 1])).round(6) + 0.0
    array([1., 0., 0.])
    """
    t = 2.0 * _cross(q[..., 1:], v)
    return v + q[..., :1] * t + _cross(q[..., 1:], t)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross product of (..., 3); a third of the time of numpy.cross for few vectors."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def normalize(v: FloatArray) -> FloatArray:
    """Scale the last axis to length 1; a zero vector stays zero."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length > _TINY, length, 1.0)


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return the rotations by ``angle`` (...), radians, about unit vectors ``axis`` (..., 3)."""
    half = np.asarray(angle, dtype=float)[..., None] / 2.0
    vector = np.sin(half) * np.asarray(axis)
    return np.concatenate([np.broadcast_to(np.cos(half), (*vector.shape[:-1], 1)), vector], axis=-1)


def exp(r: FloatArray) -> FloatArray:
    """Return the quaternions (..., 4) of rotation vectors r (..., 3), radians.

    >>> exp(np.array([np.pi, 0, 0])).round(6) + 0.0
    array([0., 1., 0., 0.])
    """
    angle = np.linalg.norm(r, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * r], axis=-1)


def log(q: FloatArray) -> FloatArray:
    """Return rotation vectors (..., 3), radians, at most pi long; the inverse of :func:`exp`."""
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    return q[..., 1:] * np.where(
        sine > _SMALL_SINE, angle / np.where(sine > _SMALL_SINE, sine, 1.0), 2.0
    )


def from_euler(angles: ArrayLike, order: str) -> FloatArray:
    """Rotation (..., 4) of Euler angles (..., n), degrees: R_order[0] R_order[1] ..."""
    half = np.deg2rad(np.asarray(angles, dtype=float)) / 2.0
    cosine, sine = np.cos(half), np.sin(half)
    q = [np.full(half.shape[:-1], each) for each in IDENTITY]
    for n, axis in enumerate(order.upper()):
        c, s, i = cosine[..., n], sine[..., n], "XYZ".index(axis)
        # q (c + s i): each of two pairs of numbers turns by itself
        for k, m in ((0, 1 + i), (1 + (i + 2) % 3, 1 + (i + 1) % 3)):
            q[k], q[m] = q[k] * c - q[m] * s, q[k] * s + q[m] * c
    return np.stack(q, axis=-1)


def to_euler(q: FloatArray, order: str) -> FloatArray:
    """Euler angles (..., 3), degrees; in gimbal lock the last angle is 0."""
    i, j, k = ("XYZ".index(axis) for axis in order.upper())
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    m = to_matrix(q)
    s = np.clip(sign * m[..., i, k], -1.0, 1.0)
    middle = np.arcsin(s)
    locked = np.abs(s) > _LOCKED
    first = np.where(
        locked,
        np.arctan2(sign * m[..., k, j], m[..., j, j]),
        np.arctan2(-sign * m[..., j, k], m[..., k, k]),
    )
    last = np.where(locked, 0.0, np.arctan2(-sign * m[..., i, j], m[..., i, i]))
    return np.rad2deg(np.stack([first, middle, last], axis=-1))


def to_matrix(q: FloatArray) -> FloatArray:
    """Return rotation matrices (..., 3, 3); their columns are the rotated axes."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )


def from_matrix(m: FloatArray) -> FloatArray:
    """Quaternions (..., 4) of matrices (..., 3, 3), by the largest of four components."""
    d = np.einsum("...ii->...i", m)
    trace = d.sum(-1)
    sums = np.stack(
        [
            1 + trace,
            1 + 2 * d[..., 0] - trace,
            1 + 2 * d[..., 1] - trace,
            1 + 2 * d[..., 2] - trace,
        ],
        axis=-1,
    )
    a = m[..., 2, 1] - m[..., 1, 2]
    b = m[..., 0, 2] - m[..., 2, 0]
    c = m[..., 1, 0] - m[..., 0, 1]
    xy = m[..., 0, 1] + m[..., 1, 0]
    xz = m[..., 0, 2] + m[..., 2, 0]
    yz = m[..., 1, 2] + m[..., 2, 1]
    rows = np.stack(
        [
            np.stack([sums[..., 0], a, b, c], axis=-1),
            np.stack([a, sums[..., 1], xy, xz], axis=-1),
            np.stack([b, xy, sums[..., 2], yz], axis=-1),
            np.stack([c, xz, yz, sums[..., 3]], axis=-1),
        ],
        axis=-2,
    )
    best = np.argmax(sums, axis=-1)[..., None, None]
    return normalize(np.take_along_axis(rows, best, axis=-2)[..., 0, :])


def between(u: FloatArray, v: FloatArray) -> FloatArray:
    """The smallest rotation from u to v (..., 3); half a turn where they are opposite."""
    u, v = normalize(u), normalize(v)
    w = 1.0 + np.sum(u * v, axis=-1, keepdims=True)
    least = np.eye(3)[np.argmin(np.abs(u), axis=-1)]
    axis = np.where(w > _OPPOSITE, np.cross(u, v), np.cross(u, least))
    return normalize(np.concatenate([np.where(w > _OPPOSITE, w, 0.0), axis], axis=-1))


def slerp(p: FloatArray, q: FloatArray, t: ArrayLike) -> FloatArray:
    """Interpolate along the shortest arc from p (t = 0) to q (t = 1); t (...) has no last axis."""
    return multiply(p, exp(np.asarray(t)[..., None] * log(relative(p, q))))


def unroll(q: FloatArray) -> FloatArray:
    """Choose the signs of quaternions (frames, ..., 4) so that neighbours in time never flip."""
    dots = np.sum(q[1:] * q[:-1], axis=-1)
    signs = np.cumprod(np.where(dots < 0, -1.0, 1.0), axis=0)
    return np.concatenate([q[:1], q[1:] * signs[..., None]], axis=0).astype(q.dtype)
