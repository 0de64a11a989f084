"""Places on the ground with a heading, and their composition.

A place is (x, z, theta): metres and radians, theta from +z towards +x, so that ahead is (sin theta,
cos theta). As a transform it maps coordinates in its own frame (x to the left of a viewer who looks
along +z, z ahead) to the world::

    a b = (a.x + b.x cos a.th + b.z sin a.th,  a.z - b.x sin a.th + b.z cos a.th,  a.th + b.th)

This is the group SE(2) with the axes of the ground. A test compares it with a yaw rotation in
space.
"""

from __future__ import annotations

import numpy as np

from motiondb.records import FloatArray


def compose(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return ``second``, given in the frame of ``first``, in the frame in which ``first`` is given.

    Shapes: `first`, `second` (..., 3), m and rad.

    >>> compose(np.array([1.0, 0.0, np.pi / 2]), np.array([0.0, 2.0, 0.0])).round(6).tolist()
    [3.0, 0.0, 1.570796]
    """
    first, second = np.broadcast_arrays(np.asarray(first, float), np.asarray(second, float))
    c, s = np.cos(first[..., 2]), np.sin(first[..., 2])
    x, z = second[..., 0], second[..., 1]
    return np.stack(
        [
            first[..., 0] + x * c + z * s,
            first[..., 1] - x * s + z * c,
            first[..., 2] + second[..., 2],
        ],
        axis=-1,
    )


def inverse(place: FloatArray) -> FloatArray:
    """Return the transform that undoes ``place``: array (..., 3).

    >>> place = np.array([3.0, -1.0, 0.7])
    >>> abs(compose(place, inverse(place))).round(12).tolist()
    [0.0, 0.0, 0.0]
    """
    place = np.asarray(place, dtype=float)
    c, s = np.cos(place[..., 2]), np.sin(place[..., 2])
    x, z = -place[..., 0], -place[..., 1]
    return np.stack([x * c - z * s, x * s + z * c, -place[..., 2]], axis=-1)


def relative(places: FloatArray, to: FloatArray) -> FloatArray:
    """Return places (..., 3) as seen from the place ``to`` (3,) or (..., 3)."""
    return compose(inverse(to), places)
