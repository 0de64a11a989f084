"""The figure that the browser draws: 26 points, and a capsule from each to its parent.

The points are the 21 joints of the canonical body and the ends of head, hands and feet. Positions
determine the capsules completely, so the browser computes no rotations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget, rotation
from motiondb.generate.contact import find_contacts
from motiondb.records import FloatArray, IntArray, Motion

POINTS: tuple[str, ...] = (
    *body.JOINTS,
    *(f"{body.JOINTS[joint].replace('wrist', 'hand')}_end" for joint, _ in body.END_SITES),
)  # Names of the points, in their order in arrays
PARENTS: tuple[int, ...] = (*body.PARENTS.tolist(), *(joint for joint, _ in body.END_SITES))
"""Index of each point's parent, -1 for the pelvis."""
_RADII = {
    "pelvis": 0.0,
    "hip": 0.10,
    "knee": 0.075,
    "ankle": 0.052,
    "toe": 0.042,
    "toe_end": 0.032,
    "spine": 0.115,
    "chest": 0.125,
    "neck": 0.06,
    "head": 0.055,
    "head_end": 0.095,
    "collar": 0.06,
    "shoulder": 0.062,
    "elbow": 0.047,
    "wrist": 0.037,
    "hand_end": 0.035,
}
"""Radius of the capsule that ends at each point, metres. Chosen by hand, to look like an adult."""


def _radius(point: str) -> float:
    return _RADII[point[2:] if point[1] == "_" else point]


RADII: tuple[float, ...] = tuple(_radius(point) for point in POINTS)
"""Radius of the capsule from each point to its parent, metres; 0 for the pelvis."""
BALL_RADIUS = 0.12  # Radius of a basketball, metres


@dataclass(frozen=True, eq=False)
class Figure:
    """A motion as points."""

    # (frames, 26, 3): metres on the standard body, right-handed world frame, y up, ground at y = 0
    points: FloatArray
    # (frames, 2): whether the left and the right foot are on the ground
    contacts: NDArray[np.bool_]
    leg_length: float  # The performer's leg length, metres


def figure_of(motion: Motion) -> Figure:
    """Return the points and the contacts of a motion."""
    positions, rotations = retarget.motion_positions(motion)
    ends = [
        positions[:, joint] + rotation.rotate(rotations[:, joint], np.array(offset))
        for joint, offset in body.END_SITES
    ]
    points = np.concatenate([positions, np.stack(ends, axis=1)], axis=1)
    return Figure(points, find_contacts(positions), float(motion.leg_length))


def facing_forward(points: FloatArray) -> FloatArray:
    """Return points moved and turned so that the first frame is at the origin and faces +z.

    Shapes: `points` (frames, 26, 3).
    """
    left, right = POINTS.index("l_hip"), POINTS.index("r_hip")
    across = points[0, left] - points[0, right]
    heading = np.arctan2(
        -across[2], across[0]
    )  # angle of the axis to the left, which is +x when facing +z
    c, s = np.cos(-heading), np.sin(-heading)
    moved = points - points[0, 0] * np.array([1.0, 0.0, 1.0])
    x, z = moved[..., 0], moved[..., 2]
    return np.stack([c * x + s * z, moved[..., 1], c * z - s * x], axis=-1)


def thinned(n_frames: int, fps: float, wanted: float) -> IntArray:
    """Return the indices of the frames to keep at a lower rate: array (frames,).

    >>> thinned(5, 30.0, 15.0).tolist()
    [0, 2, 4]
    """
    if wanted >= fps:
        return np.arange(n_frames)
    count = int(np.ceil(n_frames * wanted / fps))
    return np.minimum(np.round(np.arange(count) * fps / wanted).astype(np.int64), n_frames - 1)


def no_points() -> FloatArray:
    """Return the points of a figure without frames."""
    return np.zeros((0, len(POINTS), 3))
