"""How well one clip follows another: the cost of every seam.

Notation: clip a ends in the frame after its last one, with joints x and velocities v as seen from
its place on the ground; clip b begins with x', v'. The cost is 0 where b is what truly follows a in
its capture, else

    g(a, b) = mean_j |x_j - x'_j| / POSE_SCALE  +  mean_j |v_j - v'_j| / VELOCITY_SCALE

over the 21 joints: 1 for joints 10 cm off, or 1 m/s too fast, in the mean. The form is that of
J. Lee, J. Chai, P. Reitsma, J. Hodgins and N. Pollard, "Interactive control of avatars animated
with human motion data" (SIGGRAPH 2002); paper C names pose and velocity and gives no weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import Float32Array, FloatArray, IntArray

POSE_SCALE = 0.10
"""Metres."""
VELOCITY_SCALE = 1.0
"""Metres a second."""
_BLOCK = 128


@dataclass(frozen=True, eq=False)
class SeamEnds:
    """Where clips begin and end.

    Attributes
    ----------
    captures : array (clips,), a number per capture, another one for its mirror image.
    starts, ends : arrays (clips,), frames of the capture, half-open.
    entries, exits : arrays (clips, 2, joints, 3), joints (metres) and velocities (metres a second)
        at the first frame and at the frame after the last.
    """

    captures: IntArray
    starts: IntArray
    ends: IntArray
    entries: FloatArray
    exits: FloatArray


def seam_costs(clips: SeamEnds) -> Float32Array:
    """g(a, b) of every clip a and b: array (clips, clips), float32; see the module."""
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
    """What it costs to begin every clip from standing in its first pose, and to stop after it.

    array (clips, 2), float32: the cost of a seam between equal poses, one without velocity.
    """
    ends = np.stack([clips.entries[:, 1], clips.exits[:, 1]], axis=1)
    speeds = np.linalg.norm(ends, axis=-1).mean(axis=-1)
    return np.asarray(speeds / VELOCITY_SCALE, dtype=np.float32)
