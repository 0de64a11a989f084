"""Distances: d(x_t, x_t') of two poses, as of two vectors, and D of two segments.

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

The poses of two segments are matched by uniform time warping. Frame m of the longer segment (l
frames) is matched with frame floor(m l' / l) of the shorter (l' frames), m = 0 .. l - 1, and

    D(s, s') = (1 / l) sum_m d(x_{s + m}, x_{s' + floor(m l' / l)}).

D is symmetric. It is 0 between a segment and itself, and between a segment and itself slowed down
by a whole number. The distances d are computed where they are needed; no table of all pairs of
frames is made.

Sources: J. Lee et al., "Interactive control of avatars animated with human motion data" (2002),
section 3.1; Park, Lee and Lee (2011), equation 1, and equation 4 for the largest distance d_max. In
print m counts from 1, which would skip the first frame and step over the last.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numba import njit

from motiondb.body import body, features, retarget, rotation
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.kernels import maker
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
features of word search have (``motiondb.body.features``)."""
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


_PARTS = 4  # Parts into which a table is divided for two threads, so that both have work to the end


@njit(cache=True, inline="always")
def _pose_distance(values: Float32Array, t: int, u: int) -> np.float32:
    """Return d of two frames."""
    square = np.float32(0.0)
    for d in range(values.shape[1]):
        gap = values[t, d] - values[u, d]
        square += gap * gap
    return np.sqrt(square)


@maker
def segment_distance(values: Float32Array, a: int, b: int, a2: int, b2: int) -> float:
    """Return D of the segments [a, b) and [a2, b2), in the unit of d.

    Parameters
    ----------
    values : array (frames, dimensions), float32
        Poses, :attr:`motiondb.grammar.terminals.distances.Poses.values`.
    a : int
        First frame of the first segment.
    b : int
        Frame after the last of the first segment.
    a2 : int
        First frame of the second segment.
    b2 : int
        Frame after the last of the second segment.
    """
    if b - a < b2 - a2:
        a, b, a2, b2 = a2, b2, a, b
    length, shorter = b - a, b2 - a2
    total = 0.0
    for m in range(length):
        total += float(_pose_distance(values, a + m, a2 + m * shorter // length))
    return total / length


def segment_distances(values: Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Return D between all segments: array (segments, segments), symmetric, 0 on the diagonal."""
    table = np.zeros((len(starts), len(starts)))

    def fill(part: int) -> None:
        _fill_rows(values, starts, ends, part, _PARTS, table)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(fill, range(_PARTS)))
    return table + table.T


@maker
def _fill_rows(
    values: Float32Array,
    starts: IntArray,
    ends: IntArray,
    part: int,
    n_parts: int,
    table: FloatArray,
) -> None:
    """Fill every n_parts-th row below the diagonal."""
    for i in range(part, len(starts), n_parts):
        for j in range(i):
            table[i, j] = segment_distance(values, starts[i], ends[i], starts[j], ends[j])


@maker
def distances_to(
    values: Float32Array, a: int, b: int, starts: IntArray, ends: IntArray
) -> FloatArray:
    """Return D of the segment [a, b) to every given segment: array (segments,)."""
    distances = np.empty(len(starts))
    for i in range(len(starts)):
        distances[i] = segment_distance(values, a, b, starts[i], ends[i])
    return distances
