"""The path of the ball: in hands, from hand to floor and back, from player to player, to the ring.

Captures have no ball. The actions determine the holder: at first the first player who passes or
shoots, from a catch on the receiver of the pass, and no player after a shot. It moves

* in the hands: between the palms; if these are far apart, in front of the chest, and the hands are
  moved to it;
* dribbled: under the palm of the clip's hand, and between its release and its catch down to the
  floor and up again, each way a fall under gravity in the given time;
* passed: at constant horizontal speed, with gravity, in the time from release to catch;
* shot: so that it enters the ring from above at 45 degrees; then it falls and bounces.

Hands are moved to the ball where the capture's hands are not: during a few frames before the catch,
and while the ball is held in both hands.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 6: trajectories of the ball are added when a scene is done.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body import retarget
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene.ball.ball_acts import BallActs, Possession
from motiondb.scene.ball.hands import palms, reach
from motiondb.scene.ball.hold import BALL, HeldBall, clearance, held_ball

RADIUS, RIM, GRAVITY = BALL, 3.05, 9.81
"""Radius of the ball, m; height of the ring, m; gravity, m/s^2."""
ENTRY = math.radians(45.0)
"""Angle at which a shot comes down into the ring, rad; 43 to 47 degrees are usual."""
BOUNCE = 0.7
"""Fraction of the speed after the floor. Chosen by hand: the rules of basketball ask for 0.82 to
0.87 for a new ball dropped from 1.8 m; the net takes more."""
REACHING = 8  # Frames over which hands move to the ball and away from it


@dataclass(frozen=True, eq=False)
class Ball:
    """The path of the ball."""

    positions: FloatArray  # (frames, 3), m: its centre
    # (frames,), int: the player who has it in the hands or dribbles it; -1 in flight
    holder: IntArray
    # (frames,), m: distance from the centre to the nearest palm of the holder; NaN in flight and
    # while it bounces
    gap: FloatArray


def fly(acts: BallActs, motions: Sequence[Motion]) -> tuple[Ball, list[Motion]]:
    """Return the path of the ball, and the motions with hands moved to it."""
    n_frames = motions[0].n_frames
    positions, holder = np.zeros((n_frames, 3)), np.full(n_frames, -1)
    moved = list(motions)
    joints = [retarget.motion_positions(motion) for motion in motions]
    free = np.zeros(n_frames, dtype=bool)
    for number, possession in enumerate(acts.possessions):
        held = held_ball(possession, *joints[possession.player])
        frames = np.arange(possession.since, possession.until + 1)
        positions[frames], holder[frames] = held.ball[frames], possession.player
        for bounce in possession.bounces:
            inner = np.arange(bounce.release, bounce.catch + 1)
            ends = held.ball[bounce.release], held.ball[bounce.catch]
            way = bounced(*ends, len(inner))
            positions[inner] = way + _around(way, joints[possession.player][0][inner])
            free[inner[1:-1]] = True
        if number > 0:
            _pass(positions, acts.possessions[number - 1].until, possession.since)
        moved[possession.player] = _brought(moved[possession.player], possession, held)
    if acts.shot:
        _shoot(positions, acts.possessions[-1].until, acts.rim)
        holder[acts.possessions[-1].until + 1 :] = -1
    return Ball(positions, holder, _gaps(positions, holder, free, moved)), moved


def bounced(start: FloatArray, end: FloatArray, n_frames: int) -> FloatArray:
    """Return the path from a hand to the floor and up to a hand: array (n_frames, 3).

    The ends are included. The floor is touched in the middle frame or the one before; at least 3
    frames.

    >>> bounced(np.array([0.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0]), 3)[1].round(3).tolist()
    [0.5, 0.12, 0.0]
    """
    share = np.linspace(0.0, 1.0, n_frames)[:, None]
    way = start + share * (end - start)
    seconds = (n_frames - 1) / MOTION_FPS
    half = (n_frames - 1) // 2 / MOTION_FPS
    time = share[:, 0] * seconds
    down, up = (
        thrown(start[1], RADIUS, half, time),
        thrown(RADIUS, end[1], seconds - half, time - half),
    )
    way[:, 1] = np.maximum(np.where(time <= half + 1e-9, down, up), RADIUS)
    return np.asarray(way)


def thrown(start: float, end: float, seconds: float, time: FloatArray) -> FloatArray:
    """Return heights, m, at times of a ball that goes from ``start`` to ``end`` in ``seconds``."""
    speed = (end - start) / seconds + GRAVITY * seconds / 2.0
    return np.asarray(start + speed * time - GRAVITY * time * time / 2.0)


def shot_seconds(distance: float, height: float) -> float:
    """Return how long a shot flies that comes down at :data:`ENTRY`, from distance and rise, m.

    >>> round(shot_seconds(4.5, 0.85), 2)
    1.04
    """
    return math.sqrt(max(2.0 * (height + distance * math.tan(ENTRY)) / GRAVITY, 0.04))


def _pass(positions: FloatArray, release: int, catch: int) -> None:
    """Fill the frames between release and catch."""
    share = np.linspace(0.0, 1.0, catch - release + 1)
    start, end = positions[release].copy(), positions[catch].copy()
    seconds = (catch - release) / MOTION_FPS
    positions[release : catch + 1] = start + share[:, None] * (end - start)
    positions[release : catch + 1, 1] = thrown(start[1], end[1], seconds, share * seconds)


def _shoot(positions: FloatArray, release: int, rim: tuple[float, float]) -> None:
    """Fill the frames after a shot: to the ring, down, and bouncing."""
    start, end = positions[release].copy(), np.array([rim[0], RIM, rim[1]])
    distance = float(np.hypot(end[0] - start[0], end[2] - start[2]))
    seconds = shot_seconds(distance, RIM - float(start[1]))
    time = np.arange(len(positions) - release) / MOTION_FPS
    share = np.clip(time / seconds, 0.0, 1.0)
    way = start + share[:, None] * (end - start)
    way[:, 1] = thrown(start[1], RIM, seconds, time)
    after = time > seconds
    way[after, 1] = _falling(time[after] - seconds)
    positions[release:] = way


def _falling(time: FloatArray) -> FloatArray:
    """Return heights of a ball that the net has stopped: down to the floor and up again."""
    heights, speed = np.full(len(time), RADIUS), 0.0
    start, begin = RIM, 0.0
    for _ in range(12):
        lasts = (speed + math.sqrt(speed * speed + 2.0 * GRAVITY * (start - RADIUS))) / GRAVITY
        inside = (time >= begin) & (time <= begin + lasts)
        fall_time = time[inside] - begin
        heights[inside] = start + speed * fall_time - GRAVITY * fall_time * fall_time / 2.0
        begin, speed = begin + lasts, BOUNCE * (GRAVITY * lasts - speed)
        start = RADIUS
    return np.maximum(heights, RADIUS)


def _around(way: FloatArray, joints: FloatArray) -> FloatArray:
    """Return how far a bounce has to avoid the legs: array (frames, 3), 0 at its ends."""
    from scipy.ndimage import gaussian_filter1d

    out = gaussian_filter1d(clearance(way, joints), 2.0, axis=0, mode="constant")
    return np.asarray(out * np.minimum(1.0, 3.0 * np.sin(np.linspace(0, np.pi, len(way))))[:, None])


def _brought(motion: Motion, possession: Possession, held: HeldBall) -> Motion:
    """Return a motion with its palms at the ball while it is held, and moving to it before."""
    n_frames = motion.n_frames
    frames = np.arange(n_frames)
    inside = np.clip(frames, possession.since, possession.until)
    near = 1.0 - np.maximum(possession.since - frames, frames - possession.until) / REACHING
    ramp = np.clip(near, 0.0, 1.0)
    if possession.since == 0:
        ramp[: possession.since + 1] = 1.0
    weights = held.hands[inside] * (ramp * ramp * (3.0 - 2.0 * ramp))[:, None]
    return reach(motion, held.palms[inside], weights)


def _gaps(
    positions: FloatArray, holder: IntArray, free: NDArray[np.bool_], motions: Sequence[Motion]
) -> FloatArray:
    gaps = np.full(len(positions), np.nan)
    for player in set(holder[holder >= 0].tolist()):
        joints, _ = retarget.motion_positions(motions[player])
        apart = np.linalg.norm(palms(joints) - positions[:, None], axis=2).min(axis=1)
        here = (holder == player) & ~free
        gaps[here] = apart[here]
    return gaps
