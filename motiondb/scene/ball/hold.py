"""Where a held or dribbled ball is, and which hands are on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.body import body, features, pose_vectors, rotation
from motiondb.records import FloatArray
from motiondb.scene.ball.ball_acts import Possession
from motiondb.scene.ball.hands import palms

HALF_WIDTH = 0.11
"""Distance from the centre of the ball to a palm at its side, m: a little less than its radius."""
UNDER = 0.11
"""Distance from a palm to the centre of the ball that it dribbles, m: a little less than its
radius."""
CARRIED = np.array([0.0, -0.06, 0.34])
"""Where a ball is carried relative to the chest, m, in the frame of the heading: left, up,
ahead."""
CLOSE, FAR = 0.34, 0.55
"""Distances between palms, m: up to the first both are on the ball, from the second on they are
not."""
LEAST_AHEAD = 0.24  # Least distance of a ball below the neck in front of the chest, m
BALL = 0.12  # Radius of the ball, m: size 7
_TURN = 8  # Frames in which a ball passes from both hands to one
_OUT = 2.0  # Standard deviation of the smoothing of :func:`clearance`, frames
_LIMBS = (
    ("pelvis", "neck", 0.1),
    ("neck", "head", 0.08),
    ("l_hip", "l_knee", 0.06),
    ("r_hip", "r_knee", 0.06),
    ("l_knee", "l_ankle", 0.05),
    ("r_knee", "r_ankle", 0.05),
)
"""Capsules of the body: from joint to joint, with their radius in m. Chosen by hand: slimmer than
limbs, so that a held ball may touch clothes."""
_I = body.INDEX


@dataclass(frozen=True, eq=False)
class HeldBall:
    """Per frame, whether held or not: where the ball would be."""

    ball: FloatArray  # (frames, 3), m: its centre
    # (frames, 2): weight with which the left and the right palm are to be at ``palms``
    hands: FloatArray
    palms: FloatArray  # (frames, 2, 3), m: targets of the palms


def held_ball(possession: Possession, joints: FloatArray, rotations: FloatArray) -> HeldBall:
    """Return where the ball is while a player has it.

    If it would be inside the player's body, it is moved out, and the hands with it.

    Shapes: `joints` (frames, 21, 3), m; `rotations` (frames, 21, 4).
    """
    from scipy.ndimage import gaussian_filter1d

    n_frames = len(joints)
    heading = pose_vectors.yaw(features.headings(rotations))
    left = rotation.rotate(heading, np.broadcast_to(np.array([1.0, 0.0, 0.0]), (n_frames, 3)))
    both = palms(joints)
    two = _between(both, joints, heading)
    hand = possession.hand_at(n_frames)
    one = both[np.arange(n_frames), hand]
    single = _smooth(possession.one_handed(n_frames, _gap(both)))
    dribbled = _smooth(possession.dribbled(n_frames))
    under = one - np.array([0.0, UNDER, 0.0]) * dribbled[:, None]
    ball = (1.0 - single)[:, None] * two + single[:, None] * under
    out = gaussian_filter1d(clearance(ball, joints), _OUT, axis=0, mode="nearest")
    ball = ball + out
    aside = np.stack([left, -left], axis=1) * HALF_WIDTH
    led = _smooth(np.stack([hand == 0, hand == 1], axis=1).astype(float))
    beside = both + led[:, :, None] * out[:, None]
    share = single[:, None, None]
    wanted = (1.0 - share) * (ball[:, None] + aside) + share * beside
    other = (1.0 - single)[:, None]
    return HeldBall(ball, np.maximum(led * np.sign(single)[:, None], other), wanted)


def _smooth(values: FloatArray) -> FloatArray:
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(values, _TURN / 3.0, axis=0, mode="nearest"))


def clearance(ball: FloatArray, joints: FloatArray) -> FloatArray:
    """Return the least horizontal displacement (frames, 3) of balls (frames, 3) out of a body.

    It is 0 outside. Trunk, head, thighs and shins are capsules; joints (frames, 21, 3), m.
    """
    out = np.zeros_like(ball)
    for first, second, radius in _LIMBS:
        a, b = joints[:, _I[first]], joints[:, _I[second]]
        along = b - a
        share = np.sum((ball + out - a) * along, axis=1) / np.sum(along * along, axis=1)
        away = ball + out - (a + np.clip(share, 0.0, 1.0)[:, None] * along)
        level = away * np.array([1.0, 0.0, 1.0])
        flat = np.linalg.norm(level, axis=1)
        wide = np.sqrt(np.maximum((radius + BALL) ** 2 - away[:, 1] ** 2, 0.0))
        out += level * (np.maximum(wide - flat, 0.0) / np.maximum(flat, 1e-6))[:, None]
    return out


def _gap(both: FloatArray) -> FloatArray:
    return np.linalg.norm(both[:, 0] - both[:, 1], axis=1)


def _between(both: FloatArray, joints: FloatArray, heading: FloatArray) -> FloatArray:
    """Return the ball in both hands: between the palms, or in front of the chest if far apart."""
    chest = joints[:, _I["chest"]]
    middle = rotation.rotate(rotation.conjugate(heading), both.mean(axis=1) - chest)
    share = np.clip((_gap(both) - CLOSE) / (FAR - CLOSE), 0.0, 1.0)[:, None]
    share = share * share * (3.0 - 2.0 * share)
    middle = (1.0 - share) * middle + share * CARRIED
    below = np.clip(1.0 - (middle[:, 1] - 0.2) / 0.2, 0.0, 1.0)
    middle[:, 2] += below * np.maximum(LEAST_AHEAD - middle[:, 2], 0.0)
    return chest + rotation.rotate(heading, middle)
