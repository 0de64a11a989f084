"""The distance d(x_t, x_t') between two poses, as a Euclidean distance of two vectors.

A pose is described in the frame of its heading: origin on the ground under the pelvis, x to the
left, z ahead, on the canonical body. Position, facing and the performer's size therefore do not
matter. As in Lee et al. (2002), d compares where the joints are and how they move, and leaves out
joints that others determine (collars, hips) or that are noisy (toes):

    d(x, x')^2 = mean_j |p_j - p'_j|^2 + VELOCITY_WEIGHT^2 mean_j |v_j - v'_j|^2
                 + PELVIS_WEIGHT^2 (|u - u'|^2 + (r - r')^2)

with p_j the position of joint j (metres), v_j its velocity relative to the pelvis, u the velocity
of the pelvis and r its turning, all three per third of a second (metres, radians). Lee et al.
compare joint angles. Positions result from angles: they weight a bend of the hip by how far it
moves the hand, and they do not wrap around. The vectors are rotated to their principal axes, and
axes beyond the share ``KEPT`` of the variance are left out, which makes d cheap and changes it by
less than the noise of capture.

Source: J. Lee et al., "Interactive control of avatars animated with human motion data" (2002),
section 3.1; the largest distance d_max is used in Park, Lee and Lee (2011), equation 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body import body, features, retarget, rotation
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.records import MOTION_FPS, Float32Array, FloatArray, IntArray, Motion

COMPARED = (
    "pelvis",
    "chest",
    "head",
    "l_elbow",
    "l_wrist",
    "r_elbow",
    "r_wrist",
    "l_knee",
    "l_ankle",
    "r_knee",
    "r_ankle",
)
"""The joints that d compares, equally weighted."""
VELOCITY_WEIGHT = 0.6
"""Weight of velocities (metres per third of a second) relative to positions (metres). The value
that
features of word search have (``pose.features``)."""
PELVIS_WEIGHT = 0.5  # Weight of the pelvis's velocity and turning relative to the mean over joints
VELOCITY_SECONDS = 1.0 / 3.0  # Unit of time of velocities: about the length of a short movement
KEPT = 0.995  # Share of the variance that is kept on the principal axes

_NUMBERS = np.array([body.INDEX[name] for name in COMPARED])


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses of several takes, one after another."""

    # (frames of all takes, dimensions), float32: d is the Euclidean distance of rows
    values: Float32Array
    bounds: IntArray  # (takes + 1,): first row of each take, and the number of frames
    largest: float  # d_max, the largest distance of any two poses
    speeds: FloatArray  # (frames,): mean speed of the joints, metres a second

    @property
    def n_frames(self) -> int:
        """Number of frames of all takes, T."""
        return len(self.values)


def make_poses(takes: Sequence[Motion]) -> Poses:
    """Describe the poses of takes as vectors."""
    if not takes:
        raise GrammarError("terminals: expected at least one take, found none. Name a capture.")
    described = [_describe(take, number) for number, take in enumerate(takes)]
    raw = np.concatenate([values for values, _ in described])
    bounds = np.cumsum([0, *(len(values) for values, _ in described)])
    values = _on_principal_axes(raw)
    speeds = np.concatenate([speed for _, speed in described])
    return Poses(values, bounds, largest_distance(values), speeds)


def pose_vectors(motion: Motion) -> FloatArray:
    """Describe the poses of one motion, before principal axes; see the module.

    Shapes: result (frames, 70).
    """
    positions, rotations = retarget.motion_positions(motion)
    heading = features.headings(rotations)
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), -heading)
    ground = positions[:, :1] * np.array([1.0, 0.0, 1.0])
    local = rotation.rotate(facing[:, None], positions - ground)[:, _NUMBERS]
    moving = features.velocity(local, MOTION_FPS) * VELOCITY_SECONDS
    travel = features.velocity(positions[:, 0], MOTION_FPS) * VELOCITY_SECONDS
    turning = features.velocity(heading, MOTION_FPS)[:, None] * VELOCITY_SECONDS
    share = 1.0 / np.sqrt(len(COMPARED))
    parts = [
        share * local.reshape(len(local), -1),
        VELOCITY_WEIGHT * share * moving.reshape(len(local), -1),
        PELVIS_WEIGHT * rotation.rotate(facing, travel),
        PELVIS_WEIGHT * turning,
    ]
    return np.concatenate(parts, axis=1)


def _describe(motion: Motion, number: int) -> tuple[FloatArray, FloatArray]:
    if motion.n_frames == 0:
        raise GrammarError(f"take {number + 1}: expected frames, found none. Leave it out.")
    if not (np.isfinite(motion.root_positions).all() and np.isfinite(motion.local_rotations).all()):
        raise GrammarError(
            f"take {number + 1}: expected numbers, found NaN or infinity. Correct the capture, or "
            f"leave it out."
        )
    positions, _ = retarget.motion_positions(motion)
    steps = np.linalg.norm(features.velocity(positions[:, _NUMBERS], MOTION_FPS), axis=2)
    return pose_vectors(motion), steps.mean(axis=1)


def _on_principal_axes(raw: FloatArray) -> Float32Array:
    """Centre, rotate to the principal axes, and leave out the least axes."""
    centred = raw - raw.mean(axis=0)
    eigenvalues, axes = np.linalg.eigh(centred.T @ centred)
    order = np.argsort(-eigenvalues)
    shares = np.cumsum(np.maximum(eigenvalues[order], 0.0))
    if shares[-1] <= 0.0:
        return np.zeros((len(raw), 1), dtype=np.float32)
    n_axes = int(np.searchsorted(shares, KEPT * shares[-1])) + 1
    return np.ascontiguousarray(centred @ axes[:, order[:n_axes]], dtype=np.float32)


def largest_distance(values: FloatArray | Float32Array, block: int = 512) -> float:
    """Return the largest Euclidean distance of two rows, exactly, without a table of all distances.

    Rows are taken from far out inwards: two rows are never farther apart than the sum of their
    distances from the middle, so the search ends where that sum is below the largest distance so
    far.

    >>> largest_distance(np.array([[0.0, 0.0], [1.0, 0.0], [4.0, 3.0]]))
    5.0
    """
    rows = np.asarray(values, dtype=np.float64)
    rows = rows - (rows.min(axis=0) + rows.max(axis=0)) / 2.0
    radii = np.linalg.norm(rows, axis=1)
    order = np.argsort(-radii, kind="stable")
    rows, radii = rows[order], radii[order]
    largest = 0.0
    for start in range(0, len(rows), block):
        if 2.0 * radii[start] <= largest:
            break
        some = rows[start : start + block]
        reach = int(np.searchsorted(-radii, radii[start] - largest, side="right"))
        others = rows[start : max(reach, start + 1)]
        squares = (some**2).sum(axis=1)[:, None] + (others**2).sum(axis=1) - 2.0 * some @ others.T
        a, b = np.unravel_index(int(np.argmax(squares)), squares.shape)
        largest = max(largest, float(np.linalg.norm(some[a] - others[b])))
    return largest
