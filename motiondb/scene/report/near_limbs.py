"""The distance between the limbs of two bodies: the nearest bones, as segments between joints.

For segments a + s (b - a) and c + t (d - c) with s, t in [0, 1] the squared distance is a convex
quadratic in s and t. Its minimum is that of the two lines if both s and t are inside; otherwise it
is at an end of one of the segments.

Source: C. Ericson, "Real-Time Collision Detection" (2005), section 5.1.9.
"""

from __future__ import annotations

import numpy as np

from motiondb.body import body
from motiondb.records import FloatArray

REACH = 2.4
"""Distance of two pelvises, m, from which on no limbs can be near: twice an arm and the trunk."""
_CHILDREN = np.arange(1, len(body.JOINTS))
_TINY = 1e-12  # Squared length, m^2, below which a segment counts as a point


def limb_distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the distance between the nearest bones of two bodies: array (frames,), m.

    It is infinite if the bodies are out of each other's reach.

    Shapes: `first`, `second` (frames, 21, 3), m.
    """
    nearest = np.full(len(first), np.inf)
    near = np.flatnonzero(np.linalg.norm(first[:, 0] - second[:, 0], axis=1) < REACH)
    parents = body.PARENTS[_CHILDREN]
    for bone, parent in zip(_CHILDREN.tolist(), parents.tolist(), strict=True):
        apart = segment_distances(
            first[near, None, parent],
            first[near, None, bone],
            second[near][:, parents],
            second[near][:, _CHILDREN],
        )
        nearest[near] = np.minimum(nearest[near], apart.min(axis=1))
    return nearest


def segment_distances(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Return the distances (...) of segments from a to b and from c to d, arrays (..., 3).

    >>> a, b = np.array([0.0, 0.0, 0.0]), np.array([2.0, 0.0, 0.0])
    >>> c, d = np.array([1.0, 1.0, 3.0]), np.array([1.0, 1.0, -3.0])
    >>> float(segment_distances(a, b, c, d))
    1.0
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = _dot(u, u), _dot(v, v), _dot(u, v)
    uw, vw = _dot(u, w), _dot(v, w)
    across = uu * vv - uv * uv
    s = np.clip(
        np.where(across > _TINY, (uv * vw - vv * uw) / np.maximum(across, _TINY), 0.0), 0, 1
    )
    t = np.clip((uv * s + vw) / np.maximum(vv, _TINY), 0.0, 1.0)
    s = np.clip((uv * t - uw) / np.maximum(uu, _TINY), 0.0, 1.0)  # the nearest to that end
    between = w + s[..., None] * u - t[..., None] * v
    return np.asarray(np.sqrt(_dot(between, between)))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.sum(a * b, axis=-1))
