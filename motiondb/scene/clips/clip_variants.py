"""Variants of clips: the path of a clip on the ground, bent and stretched.

A capture follows its own path; a scene needs others. A variant of a clip has

    heading'(t) = heading(t) + bend * t / n                     bend in radians, n frames
    step'(t)    = stretch * R(bend * (t + 1/2) / n) step(t)     the steps between frames

so that its poses, relative to their places on the ground, are those of the clip. Feet slide by the
edit of the path; polishing removes this.

Travelling clips are bent and stretched. Those that begin or end at rest may turn farther, because
people turn with their first step. Clips in place are turned a little.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from motiondb.records import MOTION_FPS, FloatArray
from motiondb.scene.clips.clip_cutting import START, STOP


def _radians(*degrees: float) -> tuple[float, ...]:
    return tuple(math.radians(angle) for angle in degrees)


@dataclass(frozen=True)
class VariantSettings:
    """Which variants are made of every clip.

    The values were chosen by hand: bends and stretches beyond these look wrong in pictures.
    """

    bends: tuple[float, ...] = _radians(-40, -20, -10, 0, 10, 20, 40)  # Bends of clips that travel
    # Factors of the steps of clips that travel
    stretches: tuple[float, ...] = (0.7, 0.85, 1.0, 1.15, 1.3)
    # Bends of first and last steps
    rest_bends: tuple[float, ...] = _radians(-90, -60, -40, -20, 0, 20, 40, 60, 90)
    turns: tuple[float, ...] = _radians(-30, -15, 0, 15, 30)  # Bends of clips that stay in place
    mirror: bool = True  # Whether mirror images are made
    # Approximate largest number of pieces of one terminal before variants, separately for those
    # that travel and those that stay. Above it, captures are left out evenly
    most: int = 96


TRAVELS = 0.3  # Distance between the ends of a piece, m, from which on it counts as travelling
STEPS = 0.1  # The same for a first or last step, m
MOST_TURNING = math.radians(240.0)
"""Fastest bend, rad/s. Chosen by hand: people who run turn no faster."""


def edits_of(path: FloatArray, kind: str, settings: VariantSettings) -> FloatArray:
    """Return the variants of a piece.

    Shapes: `path` (n + 1, 3), m and rad; result (variants, 2), rad and factor.
    """
    way, seconds = float(np.hypot(path[-1, 0], path[-1, 1])), (len(path) - 1) / MOTION_FPS
    bends = settings.bends if way >= TRAVELS else settings.turns
    bends = settings.rest_bends if kind in (START, STOP) and way >= STEPS else bends
    stretches = settings.stretches if way >= TRAVELS else (1.0,)
    return np.array(
        [
            (bend, stretch)
            for bend in bends
            if abs(bend) <= MOST_TURNING * seconds + 1e-9
            for stretch in stretches
        ]
    ).reshape(-1, 2)


def edited_paths(path: FloatArray, edits: FloatArray) -> FloatArray:
    """Return the path of every variant: array (variants, n + 1, 3), from path (n + 1, 3).

    >>> straight = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    >>> edited_paths(straight, np.array([[np.pi, 0.5]])).round(6).tolist()
    [[[0.0, 0.0, 0.0], [0.5, 0.0, 3.141593]]]
    """
    return _edited(path, np.linspace(0.0, 1.0, len(path)), edits)


def edited_stretch(path: FloatArray, shares: FloatArray, bend: float, stretch: float) -> FloatArray:
    """Return one variant's path (frames, 3); frame t has turned by ``shares[t] * bend``."""
    return np.asarray(_edited(path, shares, np.array([[bend, stretch]]))[0])


def _edited(path: FloatArray, shares: FloatArray, edits: FloatArray) -> FloatArray:
    turn = edits[:, :1] * shares
    middle = (turn[:, 1:] + turn[:, :-1]) / 2.0
    step = np.diff(path[:, :2], axis=0)
    c, s = edits[:, 1:] * np.cos(middle), edits[:, 1:] * np.sin(middle)
    steps = np.stack([step[:, 0] * c + step[:, 1] * s, step[:, 1] * c - step[:, 0] * s], axis=-1)
    edited = np.empty((len(edits), len(path), 3))
    edited[:, 0, :2] = path[0, :2]
    edited[:, 1:, :2] = path[0, :2] + np.cumsum(steps, axis=1)
    edited[:, :, 2] = path[:, 2] + turn
    return edited
