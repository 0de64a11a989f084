"""Tempo: how fast a motion moves, and the same motion played faster or slower.

Notation: r the rate; frame t of the result is frame r t of the source, so that r > 1 is faster.
Path values that are speeds are multiplied by r. The *speed* of a motion is the mean speed of its
joints in the world, metres a second on the standard body.

A rate is *natural* if the resulting speed lies within the speeds of recorded motions of the same
action.
"""

from __future__ import annotations

import numpy as np

from motiondb.body import retarget, rotation
from motiondb.records import MOTION_FPS, FloatArray, Motion

SLOW_SHARE, FAST_SHARE = 0.15, 0.85
"""Quantiles of the recorded speeds that "slowly" and "fast" ask for."""
MOST_CHANGE = 1.4
"""Largest factor by which a recorded motion is played faster or slower. Beyond it jumps look as if
gravity had changed."""


def joint_speeds(motion: Motion) -> FloatArray:
    """Compute the mean speed of the joints at every frame: array (frames,), metres a second."""
    positions, _ = retarget.motion_positions(motion)
    if len(positions) < 2:
        return np.zeros(len(positions))
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=-1).mean(axis=1) * MOTION_FPS
    return np.append(steps, steps[-1])


def wanted_speed(speeds: FloatArray, fast: bool) -> float:
    """Speed that "fast" or "slowly" asks for, among recorded speeds of the action.

    Shapes: `speeds` (motions,).

    >>> wanted_speed(np.array([1.0, 2.0, 3.0]), True)
    2.7
    """
    return round(float(np.quantile(speeds, FAST_SHARE if fast else SLOW_SHARE)), 9)


def natural_rate(speed: float, wanted: float, speeds: FloatArray, fast: bool) -> float:
    """Playback rate at which a motion has a requested speed, within the range of recorded speeds.

    Shapes: `speeds` (motions,).

    `fast`: Whether the motion is to be faster; a motion that is fast enough is not slowed down.

    >>> natural_rate(1.0, 1.3, np.array([0.8, 1.2]), True)
    1.2
    >>> natural_rate(1.5, 1.3, np.array([0.8, 1.5]), True)
    1.0
    """
    wanted = float(np.clip(wanted, speeds.min(), speeds.max()))
    rate = wanted / max(speed, 1e-6)
    rate = max(rate, 1.0) if fast else min(rate, 1.0)
    return float(np.clip(rate, 1.0 / MOST_CHANGE, MOST_CHANGE))


def resample(path: FloatArray, rotations: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Play a path and its rotations at another rate.

    Shapes: `path` (frames, 4); `rotations` (frames, joints, 4); result each (frames', 4), array
    (frames', joints, 4).
    """
    times = np.arange(0.0, len(path) - 1 + 1e-9, rate)
    low = np.minimum(times.astype(np.int64), max(len(path) - 2, 0))
    share = times - low
    high = np.minimum(low + 1, len(path) - 1)
    values = path[low] * (1.0 - share[:, None]) + path[high] * share[:, None]
    values[:, 1:] *= rate
    weights = np.repeat(share[:, None], rotations.shape[1], axis=1)
    return values, rotation.slerp(rotations[low], rotations[high], weights)
