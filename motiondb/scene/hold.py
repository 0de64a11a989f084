"""Where a ball is that somebody holds or dribbles, and which hands are on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.pose import body, features, pose_vectors, rotation
from motiondb.records import FloatArray
from motiondb.scene.ball_acts import Possession
from motiondb.scene.hands import palms

HALF_WIDTH = 0.11
"""Metres from the ball's middle to a palm at its side."""
UNDER = 0.11
"""Metres from a palm to the middle of the ball that it dribbles."""
CARRIED = np.array([0.0, -0.06, 0.34])
"""Where a ball is carried, from the chest, in the frame of the heading: left, up, ahead."""
CLOSE, FAR = 0.34, 0.55
"""Metres between palms that are both on the ball, and that are not."""
LEAST_AHEAD = 0.24
"""Metres before the chest of a ball below the neck."""
_TURN = 8
"""Frames in which a ball goes from both hands to one."""
_I = body.INDEX


@dataclass(frozen=True, eq=False)
class HeldBall:
    """Per frame, whether held or not: what it would be.

    ball : array (frames, 3), metres. hands : array (frames, 2), how far the left and the right
    palm are to be at the ball's sides. left : array (frames, 3), the body's left.
    """

    ball: FloatArray
    hands: FloatArray
    left: FloatArray


def held_ball(own: Possession, joints: FloatArray, rotations: FloatArray) -> HeldBall:
    """Where the ball is while a player has it, from their joints (frames, 21, 3) and rotations."""
    from scipy.ndimage import gaussian_filter1d

    heading = pose_vectors.yaw(features.headings(rotations))
    left = rotation.rotate(heading, np.broadcast_to(np.array([1.0, 0.0, 0.0]), (len(joints), 3)))
    both = palms(joints)
    two = _between(both, joints, heading)
    one = both[np.arange(len(joints)), own.hand_at(len(joints))]
    single = gaussian_filter1d(own.one_handed(len(joints), _gap(both)), _TURN / 3.0, mode="nearest")
    dribbled = gaussian_filter1d(own.dribbled(len(joints)), _TURN / 3.0, mode="nearest")
    under = one - np.array([0.0, UNDER, 0.0]) * dribbled[:, None]
    ball = (1.0 - single)[:, None] * two + single[:, None] * under
    return HeldBall(ball, np.repeat((1.0 - single)[:, None], 2, axis=1), left)


def _gap(both: FloatArray) -> FloatArray:
    return np.linalg.norm(both[:, 0] - both[:, 1], axis=1)


def _between(both: FloatArray, joints: FloatArray, heading: FloatArray) -> FloatArray:
    """The ball in both hands: between the palms, or before the chest where these are far apart."""
    chest = joints[:, _I["chest"]]
    middle = rotation.rotate(rotation.conjugate(heading), both.mean(axis=1) - chest)
    share = np.clip((_gap(both) - CLOSE) / (FAR - CLOSE), 0.0, 1.0)[:, None]
    share = share * share * (3.0 - 2.0 * share)
    middle = (1.0 - share) * middle + share * CARRIED
    below = np.clip(1.0 - (middle[:, 1] - 0.2) / 0.2, 0.0, 1.0)
    middle[:, 2] += below * np.maximum(LEAST_AHEAD - middle[:, 2], 0.0)
    return chest + rotation.rotate(heading, middle)
