"""Hands: where they are, and how arms move them somewhere else.

A palm is a little beyond its wrist, along the forearm. Arms are chains of two bones. The hand moves
to its target as far as the arm reaches, with the elbow bent in its plane.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motiondb.body import body, kinematics, retarget, rotation
from motiondb.records import FloatArray, Motion

PALM = 0.09  # Distance from wrist to palm, m: half the length of a hand
_I = body.INDEX


def palms(positions: FloatArray) -> FloatArray:
    """Return both palms: array (frames, 2, 3), left and right, from joints (frames, 21, 3), m."""
    wrists_and_palms = []
    for side in "lr":
        elbow, wrist = positions[:, _I[f"{side}_elbow"]], positions[:, _I[f"{side}_wrist"]]
        wrists_and_palms.append(wrist + PALM * rotation.normalize(wrist - elbow))
    return np.stack(wrists_and_palms, axis=1)


def reach(motion: Motion, targets: FloatArray, weights: FloatArray) -> Motion:
    """Return the motion with its palms moved towards targets.

    Shapes: `targets` (frames, 2, 3), m; `weights` (frames, 2).
    """
    if not np.any(weights > 0.0):
        return motion
    positions, world = retarget.motion_positions(motion)
    local = motion.local_rotations.astype(np.float64)
    down = np.broadcast_to(np.array([0.0, -1.0, 0.0]), (len(positions), 3))
    for hand, side in enumerate("lr"):
        if not np.any(weights[:, hand] > 0.0):
            continue
        collar, shoulder, elbow = (_I[f"{side}_{j}"] for j in ("collar", "shoulder", "elbow"))
        palm = palms(positions)[:, hand]
        wanted = palm + weights[:, hand, None] * (targets[:, hand] - palm)
        # the palm is a straight continuation of the forearm, so the chain may end there
        upper, lower = kinematics.two_bone(
            positions[:, shoulder], positions[:, elbow], palm, wanted, down
        )
        new_shoulder = rotation.multiply(upper, world[:, shoulder])
        new_elbow = rotation.multiply(lower, world[:, elbow])
        moved = weights[:, hand, None] > 0.0
        local[:, shoulder] = np.where(
            moved, rotation.relative(world[:, collar], new_shoulder), local[:, shoulder]
        )
        local[:, elbow] = np.where(
            moved, rotation.relative(new_shoulder, new_elbow), local[:, elbow]
        )
    return replace(motion, local_rotations=rotation.unroll(local).astype(np.float32))
