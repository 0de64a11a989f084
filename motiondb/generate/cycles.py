"""Cycles of a movement: its period, the best place to repeat it, and the pieces of a repetition.

Notation: x_t the pose at frame t (any vector whose squared length compares poses), T a number of
frames. A movement is *periodic* if some lag T has a small self-difference

    D(T) = mean_t |x_{t+T} - x_t|^2 / (2 sum_d var(x_d)),

which is about 1 for unrelated poses and 0 for an exact repetition. The period is the shortest lag
at a local minimum of D below ``PERIODIC``. A *loop* [a, b) is a part of the movement that can be
played again and again, because the poses and velocities at a and b are nearly the same.

A cycle of a clip can be played for ever: its first frame follows its last. It is the part whose two
ends agree best in pose and velocity, and of a periodic movement at least about a period long. Its
seam is blended as those of generated motion are (:mod:`motiondb.generate.stitching`): the cycle is
joined to itself before and behind, and the middle one is taken. A turn of the whole cycle below
``STRAIGHT`` is taken out evenly, and so is a way below ``STANDING``; the travel of a walk stays, so
that the next cycle begins where this ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from motiondb.body import body, changes, kinematics, pose_vectors, retarget, rotation
from motiondb.body.features import runs
from motiondb.body.pose_vectors import yaw
from motiondb.errors import QueryError
from motiondb.generate import stitching
from motiondb.records import MOTION_FPS, Clip, FloatArray

PERIODIC = 0.35
"""Largest self-difference of a periodic movement. Walks of real captures have .05 to .2, single
jumps more than .6."""
SHORTEST_PERIOD, LONGEST_PERIOD = 12, 90
"""Shortest and longest period, frames (0.4 s and 3 s at 30 a second): faster cycles are
trembling."""
LEAST_OVERLAP = 0.3
"""Smallest overlap of a movement with itself, shifted by the lag, as a share of its length."""
LENGTH_WEIGHT = 0.15
"""Cost by which a loop of one second is worse than one of two, in the units of the poses' squared
distance. Longer loops are less monotonous."""


@dataclass(frozen=True)
class Loop:
    """A part [first, behind) that can be repeated."""

    first: int
    behind: int  # Last frame + 1
    cost: float  # Squared distance between the poses and velocities at both ends

    @property
    def length(self) -> int:
        """Number of frames."""
        return self.behind - self.first


def self_difference(poses: FloatArray, longest: int) -> FloatArray:
    """D(T) for the lags T = 0, 1, ..., longest: array (longest + 1,); `poses` (frames, values).

    >>> wave = np.sin(2 * np.pi * np.arange(40) / 10)[:, None]
    >>> self_difference(wave, 10).round(2)[[0, 5, 10]]
    array([0., 2., 0.])
    """
    spread = 2.0 * float(poses.var(axis=0).sum()) + 1e-12
    differences = np.zeros(longest + 1)
    for lag in range(1, longest + 1):
        differences[lag] = np.mean(np.sum((poses[lag:] - poses[:-lag]) ** 2, axis=1)) / spread
    return differences


def find_period(poses: FloatArray, periodic: float = PERIODIC) -> int | None:
    """The period of a movement in frames, None without one; `poses` (frames, values).

    >>> wave = np.sin(2 * np.pi * np.arange(80) / 20)[:, None]
    >>> find_period(wave), find_period(np.linspace(0, 1, 80)[:, None])
    (20, None)
    """
    longest = min(LONGEST_PERIOD, int(len(poses) * (1.0 - LEAST_OVERLAP)))
    if longest <= SHORTEST_PERIOD:
        return None
    difference = self_difference(poses, longest)
    inner = difference[SHORTEST_PERIOD:longest]
    lowest = (inner <= difference[SHORTEST_PERIOD - 1 : longest - 1]) & (
        inner <= difference[SHORTEST_PERIOD + 1 : longest + 1]
    )
    lags = SHORTEST_PERIOD + np.flatnonzero(lowest & (inner < periodic))
    return int(lags[0]) if len(lags) else None


def best_loop(
    edges: FloatArray, shortest: int, missing: tuple[float, float] | None = None
) -> Loop | None:
    """The loop of least cost, None if there is none; `edges` (frames + 1, values).

    >>> loop = best_loop(np.sin(2 * np.pi * np.arange(31) / 10)[:, None], 8)
    >>> loop.length, round(loop.cost, 6)
    (30, 0.0)
    """
    n = len(edges)
    if n - 1 < shortest or shortest < 1:
        return None
    square = np.sum(edges**2, axis=1)
    distance = np.maximum(square[:, None] + square[None] - 2.0 * (edges @ edges.T), 0.0)
    frames = np.arange(n)
    length = frames[None] - frames[:, None]
    cost = distance + LENGTH_WEIGHT * 30.0 / np.maximum(length, 1)
    cost[length < shortest] = np.inf
    if missing is not None:
        low, high = missing
        fills = np.floor(high / np.maximum(length, 1)) * length >= low
        cost[~fills] = np.inf
    first, behind = np.unravel_index(int(np.argmin(cost)), cost.shape)
    if not np.isfinite(cost[first, behind]):
        return None
    return Loop(int(first), int(behind), float(distance[first, behind]))


def repeat(first: int, behind: int, loop: Loop, times: int) -> list[tuple[int, int]]:
    """Return the pieces of a movement [first, behind) whose loop is played additional times.

    >>> repeat(0, 50, Loop(10, 30, 0.0), 2)
    [(0, 30), (10, 30), (10, 50)]
    >>> repeat(0, 50, Loop(10, 30, 0.0), 0)
    [(0, 50)]
    """
    if times < 1:
        return [(first, behind)]
    inner = [(loop.first, loop.behind)] * (times - 1)
    return [(first, loop.behind), *inner, (loop.first, behind)]


def calmest_phase(poses: FloatArray, period: int) -> int:
    """The frame of the first period at which the movement is slowest, averaged over periods.

    `poses` (frames, values).

    >>> calmest_phase(np.cos(2 * np.pi * (np.arange(60) - 4) / 20)[:, None], 20) in (4, 14)
    True
    """
    speed = np.linalg.norm(np.gradient(poses, axis=0), axis=1)
    whole = len(speed) // period * period
    return int(np.argmin(speed[:whole].reshape(-1, period).mean(axis=0)))


STRAIGHT = 0.35  # Radians (20 degrees) by which a cycle that is meant to go straight may turn
STANDING = 0.12  # Metres that a cycle on the spot may travel
_VELOCITY = 0.2  # Seconds: a difference of velocities counts as one of places after this time
_SHORTEST = 12  # Fewest frames of a cycle, at 30 a second
_MOST = 2700
"""Frames at 30 a second (90 s) among which a cycle is looked for: all pairs are compared."""
_BUSY = 0.7  # Share of the usual speed of a cycle that its parts have
_AVERAGED = 20  # Frames over which speeds are averaged: more than a step lasts
_I = body.INDEX


@dataclass(frozen=True, eq=False)
class Cycle:
    """A cycle, and what was changed to close it."""

    clip: Clip
    start: float  # Seconds of the clip that was given
    end: float
    gap: float  # Largest distance of a joint between both ends, before the seam was blended, m
    step: float  # Largest step of a joint from the last frame to the first of the next cycle, m
    usual_step: float  # The same, of all other frames
    travel: float  # Way over the ground of a cycle, m
    turn: float  # Turn that was taken out, radians
    turning: float  # Turn of a cycle that stays, radians


def looped(
    clip: Clip, user_map: Mapping[str, str] | None = None, is_straight: bool = False
) -> Cycle:
    """Find the cycle of a clip with y up, and close it (QueryError if the clip is too short).

    `is_straight`: whether any turn of the cycle is taken out, as it is played in place.
    """
    hips = changes.from_hips(clip, user_map)
    loop = _looped(hips.clip, user_map, is_straight)
    return replace(loop, clip=hips.restored(loop.clip))


def _looped(clip: Clip, user_map: Mapping[str, str] | None, is_straight: bool) -> Cycle:
    """Find the cycle of a clip whose root are the hips, and close it."""
    points = retarget.clip_keypoints(clip, user_map)
    coarse = retarget.resample(points, clip.fps)
    if len(coarse) < _SHORTEST + 2:
        raise QueryError(
            f"loop: expected at least {(_SHORTEST + 2) / MOTION_FPS:.2g} s of motion, found "
            f"{clip.duration:.2f} s. Choose a longer part."
        )
    if len(coarse) > _MOST:
        raise QueryError(
            f"loop: expected at most {_MOST / MOTION_FPS:g} s in which to look for a cycle, found "
            f"{clip.duration:.1f} s. Choose a part with --from and --to."
        )
    first, behind = _find(coarse, clip)
    path, local = _to_path(clip, points)
    piece = stitching.Piece(0, first, behind)
    thrice = stitching.stitch([piece] * 3, {0: (path, local)}, clip.fps)
    middle = slice(behind - first, 2 * (behind - first))
    path, turn = _straight(thrice.path[middle].copy(), clip.fps, is_straight)
    made = _from_path(clip, path, thrice.rotations[middle], (first, behind), points)
    facts = _measure(made, path, user_map)
    ends = _relative(points)[[first, min(behind, len(points) - 1)]]
    gap = float(np.linalg.norm(ends[1] - ends[0], axis=-1).max())
    turning = float(path[:, 3].sum()) / clip.fps
    return Cycle(made, first / clip.fps, behind / clip.fps, gap, *facts, turn, turning)


def _find(coarse: FloatArray, clip: Clip) -> tuple[int, int]:
    """Return the first frame of the cycle and the one behind its last, at the rate of the clip."""
    relative = _relative(coarse).reshape(len(coarse), -1)
    velocity = np.asarray(np.gradient(relative, axis=0)) * (MOTION_FPS * _VELOCITY)
    way = np.asarray(np.gradient(coarse[:, 0, [0, 2]], axis=0)) * (MOTION_FPS * _VELOCITY)
    speed = np.linalg.norm(way, axis=1, keepdims=True) * 3.0  # as much as three joints
    edges = np.concatenate([relative, velocity, speed], axis=1)
    # neither the standing before a walk nor the way to it is part of the cycle
    first, behind = _busiest(np.linalg.norm(velocity, axis=1) + speed[:, 0])
    period = find_period(relative[first:behind])
    if period is None:
        first, behind, shortest = 0, len(coarse), len(coarse) // 2
    else:
        shortest = round(0.8 * period)
    found = best_loop(edges[first:behind], max(shortest, _SHORTEST))
    if found is None:
        return 0, clip.n_frames
    rate = clip.fps / MOTION_FPS
    start, end = round((first + found.first) * rate), round((first + found.behind) * rate)
    return start, min(end, clip.n_frames)


def _busiest(speeds: FloatArray) -> tuple[int, int]:
    """Return the longest part that moves about as fast as the movement does; speeds (frames,)."""
    averaged = uniform_filter1d(speeds, _AVERAGED, mode="nearest")
    parts = runs(averaged > _BUSY * np.quantile(averaged, 0.75))
    return max(parts, key=lambda part: part[1] - part[0], default=(0, len(speeds)))


def _headings(points: FloatArray) -> FloatArray:
    """Return the direction that the body faces, radians about the vertical, unwrapped (frames,)."""
    left = points[:, _I["l_hip"]] - points[:, _I["r_hip"]]
    left = left + points[:, _I["l_shoulder"]] - points[:, _I["r_shoulder"]]
    return np.asarray(np.unwrap(np.arctan2(-left[:, 2], left[:, 0])))


def _relative(points: FloatArray) -> FloatArray:
    """Return places (frames, 21, 3) relative to the ground below the pelvis, along the heading."""
    back = yaw(-_headings(points))[:, None]
    moved = points - points[:, :1] * np.array([1.0, 0.0, 1.0])
    return rotation.rotate(np.broadcast_to(back, (*moved.shape[:2], 4)), moved)


def _to_path(clip: Clip, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The path (frames, 4) of a clip's root, and its rotations relative to the heading."""
    heading = _headings(points)
    local = rotation.normalize(clip.local_rotations)
    local[:, 0] = rotation.multiply(yaw(-heading), local[:, 0])
    return pose_vectors.path_of(clip.root_positions, heading, clip.fps), local


def _straight(path: FloatArray, fps: float, whole: bool) -> tuple[FloatArray, float]:
    """Take a small turn, and a small way, of a cycle out of its path (frames, 4).

    `whole`: whether a large turn is taken out, too.
    """
    turn = float(path[:, 3].sum()) / fps
    if whole or abs(turn) < STRAIGHT:
        path[:, 3] -= turn * fps / len(path)
    else:
        turn = 0.0
    headings = pose_vectors.headings_of(path, 0.0, fps)
    steps = pose_vectors.steps_of(path, headings, fps)
    if np.linalg.norm(steps.sum(axis=0)) < STANDING:
        steps -= steps.mean(axis=0)
        path[:, 1:3] = rotation.rotate(yaw(-headings), steps * fps)[:, [0, 2]]
    return path, turn


def _from_path(
    clip: Clip, path: FloatArray, local: FloatArray, part: tuple[int, int], points: FloatArray
) -> Clip:
    """Return the clip of a path and of rotations relative to the heading, from its own place."""
    heading = float(_headings(points)[part[0]])
    turns = pose_vectors.headings_of(path, heading, clip.fps)
    root = pose_vectors.along_path(path, clip.root_positions[part[0]], heading, clip.fps)
    world = local.copy()
    world[:, 0] = rotation.multiply(yaw(turns), local[:, 0])
    moved = clip.joint_positions
    if moved is not None:
        moved = _closed(moved, *part)
    made = replace(
        clip, local_rotations=rotation.unroll(world), root_positions=root, joint_positions=moved
    )
    return changes.moved_root(made, root)


def _closed(places: FloatArray, first: int, behind: int) -> FloatArray:
    """Return places (frames, joints, 3) with the difference of both ends spread evenly."""
    part = places[first:behind].copy()
    over = places[min(behind, len(places) - 1)] - places[first]
    share = np.arange(len(part)) / len(part)
    return np.asarray(part - share[:, None, None] * over)


def _measure(
    clip: Clip, path: FloatArray, user_map: Mapping[str, str] | None
) -> tuple[float, float, float]:
    """Return the step of joints over the seam, the largest other one, and the travel, metres."""
    headings = pose_vectors.headings_of(path, 0.0, clip.fps)
    way = pose_vectors.steps_of(path, headings, clip.fps).sum(axis=0)
    places = kinematics.clip_positions(clip)[0]
    begin = _headings(retarget.clip_keypoints(clip, user_map))[0]
    turned = yaw(np.array(path[:, 3].sum() / clip.fps))
    next_first = places[0] - places[0, 0]
    next_first = rotation.rotate(np.broadcast_to(turned, (len(next_first), 4)), next_first)
    start = places[0, 0] + rotation.rotate(yaw(np.array(begin)), way)
    seam = np.linalg.norm(next_first + start - places[-1], axis=-1).max()
    steps = np.linalg.norm(np.diff(places, axis=0), axis=-1).max()
    return float(seam), float(steps), float(np.linalg.norm(way))
