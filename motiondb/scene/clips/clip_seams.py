"""The cost of a seam: how badly one clip follows another.

Notation: clip a ends in the frame after its last one, with joints x and velocities v seen from its
place on the ground. Clip b begins with x' and v'. The cost is 0 if b truly follows a in its
capture; otherwise

    g(a, b) = mean_j |x_j - x'_j| / POSE_SCALE  +  mean_j |v_j - v'_j| / VELOCITY_SCALE

over the 21 joints: 1 for joints that are 10 cm apart, or differ by 1 m/s, on average. The form is
that of
J. Lee, J. Chai, P. Reitsma, J. Hodgins and N. Pollard, "Interactive control of avatars animated
with human motion data" (SIGGRAPH 2002). The paper on motion grammars names pose and velocity and
gives no weights; ours were chosen by hand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray

POSE_SCALE = 0.10  # Distance of joints, m, that costs 1. Chosen by hand: a viewer sees the blend
VELOCITY_SCALE = 1.0  # Difference of velocities, m/s, that costs 1
_BLOCK = 128  # Clips compared at once. It bounds the memory; the result does not depend on it


@dataclass(frozen=True, eq=False)
class SeamEnds:
    """The beginnings and ends of clips."""

    captures: IntArray  # (clips,), int: a number per capture, and another one for its mirror image
    starts: IntArray  # (clips,), int: first frame in the capture
    ends: IntArray  # (clips,), int: frame after the last one
    # (clips, 2, joints, 3), m and m/s: joints and velocities at the first frame
    entries: FloatArray
    # (clips, 2, joints, 3), m and m/s: joints and velocities at the frame after the last
    exits: FloatArray


def seam_costs(clips: SeamEnds) -> Float32Array:
    """Return g(a, b) of every clip a and b: array (clips, clips), float32; see the module."""
    scales = np.array([POSE_SCALE, VELOCITY_SCALE])[:, None, None]
    exits = (clips.exits / scales).astype(np.float32)
    entries = (clips.entries / scales).astype(np.float32)
    n_clips, n_joints = len(exits), exits.shape[2]
    costs = np.zeros((n_clips, n_clips), dtype=np.float32)
    for low in range(0, n_clips, _BLOCK):
        for what in range(2):
            for joint in range(n_joints):
                a, b = exits[low : low + _BLOCK, what, joint], entries[:, what, joint]
                square = np.square(a[:, None, 0] - b[None, :, 0])
                square += np.square(a[:, None, 1] - b[None, :, 1])
                square += np.square(a[:, None, 2] - b[None, :, 2])
                costs[low : low + _BLOCK] += np.sqrt(square)
    costs /= n_joints
    same = clips.captures[:, None] == clips.captures[None, :]
    costs[same & (clips.ends[:, None] == clips.starts[None, :])] = 0.0
    return costs


def rest_costs(clips: SeamEnds) -> Float32Array:
    """Return the costs of starting every clip from standing, and of stopping after it.

    It is the cost of a seam between equal poses, one of them without velocity.

    Shapes: result (clips, 2), float32.
    """
    ends = np.stack([clips.entries[:, 1], clips.exits[:, 1]], axis=1)
    speeds = np.linalg.norm(ends, axis=-1).mean(axis=-1)
    return np.asarray(speeds / VELOCITY_SCALE, dtype=np.float32)
