"""Features of a motion that do not depend on the performer's size, position and heading.

For every frame of time, in the body's frame of reference (x left, y up, z ahead along the heading,
origin on the ground below the pelvis), metres on the standard body:

========================  ==================  ======
part                      values              weight
========================  ==================  ======
joint positions           21 x 3              1
joint velocities          21 x 3 (per 1/3 s)  0.6
pelvis velocity, turning  3 + 1 (per 1/3 s)   2
========================  ==================  ======

The weights gave the best search by words on real captures; without velocities and the pelvis's own
motion, mean average precision is lower by 0.06.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, rotation
from motiondb.records import MOTION_FPS, Float32Array, FloatArray, IntArray, Motion

POSITION_WEIGHT = 1.0
VELOCITY_WEIGHT = 0.6
ROOT_WEIGHT = 2.0
VELOCITY_SECONDS = 1.0 / 3.0
"""Velocities are expressed as metres (or radians) per this time, so that their size is comparable
with that of positions."""
FEATURE_STEP = 2
"""Frames of the motion for each frame of features: features have 15 frames a second, which suffice
for recognition (see ARCHITECTURE.md, "Feature weights")."""
FEATURE_FPS = MOTION_FPS / FEATURE_STEP  # Frames of features per second
BLOCK = 1024
"""Frames of short motions computed together. 600 motions of a second or two took 0.16 s with
1024, 0.27 s with 256, 0.21 s with 4096, and 0.62 s one at a time."""
N_FEATURES = 6 * len(body.JOINTS) + 4  # Values in a frame of features

LEVEL = 0.25
"""Length in the ground plane that a body axis (of length 1) needs to define the heading. Below it,
the axis is within 15 degrees of the vertical."""
TIPPED = 0.5
"""Height of the body's upward axis (1: upright) below which the body may have tipped over: 60
degrees from upright."""

_I = body.INDEX
TRUNK = (_I["pelvis"], _I["chest"])  # Joints whose rotations define the heading


def headings(rotations: FloatArray) -> FloatArray:
    """Compute the heading of a body over time.

    Only the joints of :data:`TRUNK` are used. The facing direction is orthogonal to the mean left
    axis of pelvis and chest, which stays level in bows and somersaults. Where the body tips over
    sideways (a cartwheel), that axis turns upside down, but the axis that points ahead stays level
    and is used instead. Where neither is level, the heading is interpolated between the frames in
    which it is known.

    Shapes: `rotations` (frames, 21, 4); result (frames,).
    """
    return _angle(*(_mean_axis(rotations, n) for n in range(3)))


def _angle(left: FloatArray, up: FloatArray, ahead: FloatArray) -> FloatArray:
    """Heading (frames,) of a body from its mean axes (frames, 3), see :func:`headings`."""
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
    return np.interp(np.arange(len(facing)), sure, angle)


def _mean_axis(rotations: FloatArray, number: int) -> FloatArray:
    """Return the mean of an axis of pelvis and chest (frames, 3), world, of length at most 1."""
    axis = np.broadcast_to(np.eye(3)[number], (len(rotations), 3))
    pelvis = rotation.rotate(rotations[:, _I["pelvis"]], axis)
    return (pelvis + rotation.rotate(rotations[:, _I["chest"]], axis)) / 2.0


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the half-open intervals in which a mask is true.

    >>> runs(np.array([True, True, False, True]))
    [(0, 2), (3, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def velocity(values: FloatArray, fps: float) -> FloatArray:
    """Central differences in time of values (frames, ...), one-sided at the ends."""
    if len(values) < 2:
        return np.zeros_like(values)
    return np.asarray(np.gradient(values, 1.0 / fps, axis=0))


def recognition_features(motion: Motion) -> Float32Array:
    """Compute the features of every second frame; result (ceil(frames / 2), 130), float32."""
    bounds = np.array([0, motion.n_frames])
    return _features(motion.local_rotations, motion.root_positions, bounds)


def features_of_motions(motions: Sequence[Motion]) -> list[Float32Array]:
    """Features of many motions, each as :func:`recognition_features`, by blocks."""
    if not motions:
        return []
    block_of = np.cumsum([0, *(motion.n_frames for motion in motions)])[:-1] // BLOCK
    features: list[Float32Array] = []
    for numbers in np.split(np.arange(len(motions)), np.flatnonzero(np.diff(block_of)) + 1):
        block = [motions[int(n)] for n in numbers]
        lengths = np.array([motion.n_frames for motion in block])
        joined = _features(
            np.concatenate([motion.local_rotations for motion in block]),
            np.concatenate([motion.root_positions for motion in block]),
            np.concatenate([[0], np.cumsum(lengths)]),
        )
        features += np.split(joined, np.cumsum(-(-lengths // FEATURE_STEP))[:-1])
    return features


def seen_from_pelvis(motion: Motion) -> FloatArray:
    """Joints relative to the pelvis, in the frame of the heading: array (frames, 21, 3), metres."""
    whole = np.array([0, motion.n_frames])
    local = _seen(motion.local_rotations, motion.root_positions, whole)[1]
    local[..., 1] -= local[:, :1, 1]
    return local


def _seen(
    local_rotations: Float32Array, root_positions: Float32Array, bounds: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Joints in the world and from above the pelvis, and headings, as angles and as rotations."""
    from motiondb.body import kernels  # compiled code, which a search does without

    positions, rotations = kernels.forward(
        body.PARENTS, body.OFFSETS, local_rotations, root_positions
    )
    axes = kernels.mean_axes(rotations, TRUNK)
    parts = itertools.pairwise(bounds)
    heading = np.concatenate([_angle(*(axis[a:b] for axis in axes)) for a, b in parts])
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), -heading)
    return positions, kernels.relative_to_heading(positions, facing), heading, facing


def _features(
    local_rotations: Float32Array, root_positions: Float32Array, bounds: IntArray
) -> Float32Array:
    """Features (sum of ceil(frames / 2), 130), float32, of motions that follow one another."""
    positions, local, heading, facing = _seen(local_rotations, root_positions, bounds)
    parts = itertools.pairwise(bounds)
    chosen = np.concatenate([np.arange(a, b, FEATURE_STEP) for a, b in parts])
    first, last = (
        np.repeat(edge, np.diff(bounds))[chosen] for edge in (bounds[:-1], bounds[1:] - 1)
    )
    around = np.maximum(chosen - 1, first), np.minimum(chosen + 1, last)

    def moving(values: FloatArray) -> FloatArray:  # as `velocity`, per VELOCITY_SECONDS
        seconds = np.maximum(around[1] - around[0], 1) * (1.0 / MOTION_FPS)
        change = values[around[1]] - values[around[0]]
        return change / seconds.reshape(-1, *[1] * (values.ndim - 1)) * VELOCITY_SECONDS

    features = np.concatenate(
        [
            POSITION_WEIGHT * local[chosen].reshape(len(chosen), -1),
            VELOCITY_WEIGHT * moving(local).reshape(len(chosen), -1),
            ROOT_WEIGHT * rotation.rotate(facing[chosen], moving(positions[:, 0])),
            ROOT_WEIGHT * moving(heading)[:, None],
        ],
        axis=1,
    )
    return features.astype(np.float32)
