"""Vectors that generation models: one for each frame, from which a motion can be computed back.

Notation, per frame: h pelvis height (metres); v planar velocity of the pelvis to the next frame, in
axes that follow the heading (x left, z ahead; metres per second); w turning to the next frame
(radians per second); r_j = log(mean_j^-1 q_j) the rotation vector of joint j about its mean local
rotation (the pelvis relative to the heading). The vector is [h, v_x, v_z, w, r_0, r_1, ...] over
the joints that turn. :func:`from_vectors` integrates w and v, so it gives the motion back
exactly, up to the position and the heading of the first frame.
"""

from __future__ import annotations

import numpy as np

from motiondb.body import body, features, retarget, rotation
from motiondb.records import MOTION_FPS, FloatArray, Motion

FIXED = ("head", "l_wrist", "r_wrist", "l_toe", "r_toe")
"""Joints that keep their rest rotation on the canonical body."""
TURNING = np.array([n for n, joint in enumerate(body.JOINTS) if joint not in FIXED])
"""Numbers of all other joints."""
N_VALUES = 4 + 3 * len(TURNING)  # Values in a vector
_UP = np.array([0.0, 1.0, 0.0])  # The vertical axis y


def yaw(angle: FloatArray) -> FloatArray:
    """Return rotations (..., 4) about the vertical by angles (...), radians."""
    return rotation.from_axis_angle(_UP, angle)


def mean_rotations(rotations: FloatArray) -> FloatArray:
    """Compute the mean rotation of every joint over the frames.

    It is the eigenvector of the largest eigenvalue of the sum of q q^T (Markley et al., "Averaging
    quaternions", Journal of Guidance, Control, and Dynamics 30(4), 2007).

    Shapes: `rotations` (frames, joints, 4); result (joints, 4).
    """
    moments = np.einsum("tja,tjb->jab", rotations, rotations)
    vectors = np.linalg.eigh(moments)[1][..., -1]
    return vectors * np.where(vectors[:, :1] < 0, -1.0, 1.0)


def heading_rotations(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Split the rotations of a motion into its heading and the rest; result (frames, 21, 4)."""
    _, world = retarget.motion_positions(motion, features.TRUNK)
    heading = features.headings(world)
    local = motion.local_rotations.astype(np.float64)
    local[:, 0] = rotation.multiply(yaw(-heading), local[:, 0])
    return local, heading


def to_path(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Split a motion into its path over the ground and its rotations; result (frames, 4)."""
    local, heading = heading_rotations(motion)
    return path_of(motion.root_positions.astype(np.float64), heading, MOTION_FPS), local


def path_of(root: FloatArray, heading: FloatArray, fps: float) -> FloatArray:
    """The path (frames, 4) of root positions (frames, 3) and headings (frames,)."""
    step = np.diff(root, axis=0, append=root[-1:]) * fps
    turning = np.diff(heading, append=heading[-1:]) * fps
    if len(root) > 1:
        step[-1], turning[-1] = step[-2], turning[-2]
    planar = rotation.rotate(yaw(-heading), step)
    return np.stack([root[:, 1], planar[:, 0], planar[:, 2], turning], axis=1)


def headings_of(path: FloatArray, heading: float, fps: float) -> FloatArray:
    """The headings (frames,) of a path (frames, 4) from that of its first frame on."""
    return heading + np.concatenate([[0.0], np.cumsum(path[:-1, 3]) / fps])


def steps_of(path: FloatArray, headings: FloatArray, fps: float) -> FloatArray:
    """The way over the ground to the next frame, in the world: array (frames, 3)."""
    planar = np.zeros((len(path), 3))
    planar[:, [0, 2]] = path[:, 1:3]
    return rotation.rotate(yaw(headings), planar) / fps


def along_path(path: FloatArray, start: FloatArray, heading: float, fps: float) -> FloatArray:
    """The root positions (frames, 3) of a path; `start` (3,): of the first frame."""
    steps = steps_of(path, headings_of(path, heading, fps), fps)
    root = start + np.concatenate([np.zeros((1, 3)), np.cumsum(steps[:-1], axis=0)])
    root[:, 1] = path[:, 0]
    return root


def from_path(
    path: FloatArray,
    local: FloatArray,
    start: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    leg_length: float = body.LEG_LENGTH,
) -> Motion:
    """The motion of a path (frames, 4) and of rotations relative to the heading."""
    turns = headings_of(path, heading, MOTION_FPS)
    root = along_path(path, np.array([start[0], 0.0, start[1]]), heading, MOTION_FPS)
    world = local.copy()
    world[:, 0] = rotation.multiply(yaw(turns), local[:, 0])
    return Motion(
        local_rotations=rotation.unroll(world).astype(np.float32),
        root_positions=root.astype(np.float32),
        leg_length=leg_length,
    )


def from_vectors(
    vectors: FloatArray,
    means: FloatArray,
    start: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    leg_length: float = body.LEG_LENGTH,
) -> Motion:
    """The motion of vectors (frames, 52) about mean rotations (21, 4)."""
    local = np.tile(rotation.IDENTITY, (len(vectors), len(body.JOINTS), 1))
    turned = rotation.exp(vectors[:, 4:].reshape(len(vectors), -1, 3))
    local[:, TURNING] = rotation.multiply(means[TURNING], turned)
    return from_path(vectors[:, :4], local, start, heading, leg_length)
