"""What recognition compares: a frame of motion without performer size, place and heading.

For every frame, in the frame of the body's heading (x left, y up, z ahead, origin on the ground
under the pelvis), metres on the standard body:

========================  ==================  ======
part                      values              weight
========================  ==================  ======
joint positions           21 x 3              1
joint velocities          21 x 3 (per 1/3 s)  0.6
pelvis velocity, turning  3 + 1 (per 1/3 s)   2
========================  ==================  ======

The weights are the ones measured to serve word search best (positions without velocities and
without the pelvis's own motion lose 0.06 of mean average precision).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motiondb.pose import body, retarget, rotation
from motiondb.records import MOTION_FPS, Float32Array, FloatArray, Motion

POSITION_WEIGHT = 1.0
VELOCITY_WEIGHT = 0.6
ROOT_WEIGHT = 2.0
VELOCITY_SECONDS = 1.0 / 3.0
"""Velocities are expressed as metres (or radians) per this time, to stand beside positions."""
FEATURE_STEP = 2
"""Frames of the motion per feature frame: features run at 15 frames a second."""
FEATURE_FPS = MOTION_FPS / FEATURE_STEP
N_FEATURES = 6 * len(body.JOINTS) + 4

LEVEL = 0.25
"""Share of a body axis's length that must lie in the ground plane to tell the heading."""
TIPPED = 0.5
"""Height of the body's upward axis (1: upright) below which it may have tipped over."""

_I = body.INDEX
TRUNK = (_I["pelvis"], _I["chest"])
"""Joints that tell the heading."""


def headings(rotations: FloatArray) -> FloatArray:
    """Heading (frames,), radians about y, 0 = facing +z, from world rotations (frames, 21, 4).

    Only those of :data:`TRUNK` are looked at. The facing direction is at right angles to the mean
    left axis of pelvis and chest, which stays level in bows and somersaults. Where the body tips
    over sideways (a cartwheel) that axis turns upside down, but the one that points ahead stays
    level and is taken. Where neither is level the heading is interpolated between sure frames.
    Unwrapped in time.
    """
    left, up, ahead = (_mean_axis(rotations, n) for n in range(3))
    facing = np.stack([-left[:, 2], left[:, 0]], axis=1)  # (x, z), at right angles to the left axis
    level = np.linalg.norm(facing, axis=1)
    forward = ahead[:, [0, 2]]
    forward_level = np.linalg.norm(forward, axis=1)
    for start, end in runs(up[:, 1] < TIPPED):
        if level[start:end].min() < LEVEL < forward_level[start:end].min():
            share = np.clip(up[start:end, 1] / TIPPED, 0.0, 1.0)[:, None]
            facing[start:end] = share * facing[start:end] + (1.0 - share) * forward[start:end]
    level = np.linalg.norm(facing, axis=1)
    sure = np.flatnonzero(level > LEVEL)
    if len(sure) == 0:
        sure = np.array([int(np.argmax(level))])
    angle = np.unwrap(np.arctan2(facing[sure, 0], facing[sure, 1]))
    return np.interp(np.arange(len(rotations)), sure, angle)


def _mean_axis(rotations: FloatArray, number: int) -> FloatArray:
    """An axis of pelvis and chest in the world, averaged: array (frames, 3), length at most 1."""
    axis = np.broadcast_to(np.eye(3)[number], (len(rotations), 3))
    pelvis = rotation.rotate(rotations[:, _I["pelvis"]], axis)
    return (pelvis + rotation.rotate(rotations[:, _I["chest"]], axis)) / 2.0


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Half-open intervals in which the mask holds.

    >>> runs(np.array([True, True, False, True]))
    [(0, 2), (3, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def velocity(values: FloatArray, fps: float) -> FloatArray:
    """Central differences in time (frames, ...), per second; one-sided at the ends."""
    if len(values) < 2:
        return np.zeros_like(values)
    return np.asarray(np.gradient(values, 1.0 / fps, axis=0))


def recognition_features(motion: Motion) -> Float32Array:
    """Features of every second frame: array (ceil(frames / 2), 130), float32; see the module."""
    positions, rotations = retarget.motion_positions(motion)
    heading = headings(rotations)
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), -heading)
    ground = positions[:, 0] * np.array([1.0, 0.0, 1.0])
    local = rotation.rotate(facing[:, None], positions - ground[:, None])
    per_time = VELOCITY_SECONDS
    moving = velocity(local, MOTION_FPS) * per_time
    root = rotation.rotate(facing, velocity(positions[:, 0], MOTION_FPS)) * per_time
    turning = velocity(heading, MOTION_FPS)[:, None] * per_time
    features = np.concatenate(
        [
            POSITION_WEIGHT * local.reshape(len(local), -1),
            VELOCITY_WEIGHT * moving.reshape(len(local), -1),
            ROOT_WEIGHT * root,
            ROOT_WEIGHT * turning,
        ],
        axis=1,
    )
    return features[::FEATURE_STEP].astype(np.float32)
