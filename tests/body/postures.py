"""Motions of the canonical body in many postures, the floor at 0, and worlds for them."""

from __future__ import annotations

import numpy as np

from motiondb.body import body, kinematics, rotation

_I = body.INDEX
_ARMS = {"l_shoulder": (0, 0, -75), "r_shoulder": (0, 0, 75)}
_SIT = {"l_hip": (-90, 0, 0), "r_hip": (-90, 0, 0)}
_CHAIR = {**_SIT, "l_knee": (90, 0, 0), "r_knee": (90, 0, 0)}
_KNEEL = {"l_knee": (90, 0, 0), "r_knee": (90, 0, 0)}
_BEND = {"l_hip": (-85, 0, 0), "r_hip": (-85, 0, 0)}
_SQUAT = {
    "l_hip": (-110, 0, 0),
    "r_hip": (-110, 0, 0),
    "l_knee": (120, 0, 0),
    "r_knee": (120, 0, 0),
}
POSTURES = {  # name -> degrees of joints, of the root, and how much all joints sway
    "stand": (_ARMS, (0, 0, 0), 3.0),
    "back": (_ARMS, (-90, 0, 0), 5.0),
    "face down": (_ARMS, (90, 0, 0), 5.0),
    "side": (_ARMS, (0, 0, 90), 5.0),
    "chair": ({**_ARMS, **_CHAIR}, (0, 0, 0), 2.0),
    "floor": ({**_ARMS, **_SIT}, (0, 0, 0), 2.0),
    "kneel": ({**_ARMS, **_KNEEL}, (0, 0, 0), 3.0),
    "bend": ({**_ARMS, **_BEND}, (85, 0, 0), 3.0),
    "squat": ({**_ARMS, **_SQUAT}, (0, 0, 0), 2.0),
    "push-up": ({"l_shoulder": (0, 90, 0), "r_shoulder": (0, -90, 0)}, (80, 0, 0), 1.0),
    "handstand": ({"l_shoulder": (0, 0, 85), "r_shoulder": (0, 0, -85)}, (180, 0, 0), 2.0),
}
FPS = 30.0


def rotations(name: str, n_frames: int = 45) -> np.ndarray:
    """Local rotations (frames, 21, 4) of a posture; every joint sways."""
    degrees, root, sway = POSTURES[name]
    rng, times = np.random.default_rng(0), np.arange(n_frames)[:, None] / FPS
    turns = np.tile(rotation.IDENTITY, (n_frames, 21, 1))
    for joint in body.JOINTS:
        rates, phases = rng.uniform(0.1, 0.4, 3), rng.uniform(0.0, 6.0, 3)
        angles = sway * np.sin(2 * np.pi * times * rates + phases)
        angles = angles * (0.1 if joint == "pelvis" else 1.0) + degrees.get(joint, (0, 0, 0))
        turns[:, _I[joint]] = rotation.from_euler(
            angles + (joint == "pelvis") * np.array(root), "XYZ"
        )
    return turns


def positions(name: str, heading: float = 0.0, at: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Joints (frames, 21, 3) of a posture, y up, on the floor; heading in degrees."""
    turns = rotations(name)
    points, _ = kinematics.forward(body.PARENTS, body.OFFSETS, turns, np.zeros((len(turns), 3)))
    points[..., 1] -= points[..., 1].min(axis=1)[:, None] - 0.03
    turn = rotation.from_euler([heading], "Y")
    return rotation.rotate(turn, points + np.array([at[0], 0.0, at[1]]))


def walk(n_frames: int = 60, speed: float = 1.2) -> np.ndarray:
    """Joints (frames, 21, 3) of a walk along z whose standing foot stays where it is."""
    points = np.repeat(positions("stand")[:1], n_frames, axis=0)
    times, half = np.arange(n_frames) / FPS, 0.3  # each foot stands 0.5 s for a step of 0.6 m
    phase = times * speed / (4.0 * half)
    points[..., 2] += (speed * times)[:, None]
    for side, shift in (("l", 0.0), ("r", 0.5)):
        share = (phase + shift) % 1.0
        stands = share < 0.5
        ahead = np.where(stands, half - 4 * half * share, -half + 4 * half * (share - 0.5))
        lift = np.where(stands, 0.0, 0.1 * np.sin(np.pi * (share - 0.5) * 2))
        foot = [_I[f"{side}_ankle"], _I[f"{side}_toe"]]
        points[:, foot, 2] += ahead[:, None]
        points[:, foot, 1] += lift[:, None]
        points[:, _I[f"{side}_knee"], 2] += ahead / 2.0 + 0.06
    return points


def in_world(points: np.ndarray, up: str) -> np.ndarray:
    """The same in a world in which another axis is up, by hand."""
    x, y, z = np.moveaxis(points, -1, 0)
    axes = {
        "y": (x, y, z), "z": (x, -z, y), "x": (y, -x, z),
        "-y": (x, -y, -z), "-z": (x, z, -y), "-x": (-y, x, z),
    }[up]  # fmt: skip
    return np.stack(axes, axis=-1)
