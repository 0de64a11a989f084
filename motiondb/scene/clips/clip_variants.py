"""Clips bent, stretched and mirrored: what a clip's path on the ground becomes.

A capture walks straight on and as far as it did; a scene wants other ways. A variant of a clip has

    heading'(t) = heading(t) + bend * t / n                     bend in radians, n frames
    step'(t)    = stretch * R(bend * (t + 1/2) / n) step(t)     the steps between frames

so that poses, seen from the place where they stand, are those of the clip. Feet then slide by what
the path was edited; polishing holds them again.

Travelling clips are bent and stretched; those that begin or end at rest may turn farther, as who
starts to run turns with the first step. Clips in place are turned a little.
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

    Attributes
    ----------
    bends, stretches : of clips that travel; radians, and factors of the steps.
    rest_bends : bends of first and last steps, radians.
    turns : bends of clips that stay in place, radians.
    mirror : whether mirror images are made.
    most : pieces of one terminal before variants, about, of those that travel and of those that
        stay; beyond, captures are left out evenly.
    """

    bends: tuple[float, ...] = _radians(-40, -20, -10, 0, 10, 20, 40)
    stretches: tuple[float, ...] = (0.7, 0.85, 1.0, 1.15, 1.3)
    rest_bends: tuple[float, ...] = _radians(-90, -60, -40, -20, 0, 20, 40, 60, 90)
    turns: tuple[float, ...] = _radians(-30, -15, 0, 15, 30)
    mirror: bool = True
    most: int = 96


TRAVELS = 0.3
"""Metres between the ends of a piece that travels."""
STEPS = 0.1
"""Metres between the ends of a first or last step."""
MOST_TURNING = math.radians(240.0)
"""Radians a second of the fastest bend; people who run turn no faster."""


def edits_of(path: FloatArray, kind: str, settings: VariantSettings) -> FloatArray:
    """The variants of a piece: array (variants, 2), bend in radians and stretch.

    Parameters
    ----------
    path : array (n + 1, 3), places of the piece's frames and of the frame after it.
    kind : of the piece, see :mod:`motiondb.scene.clips.clip_cutting`.
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
    """The path of every variant: array (variants, n + 1, 3), from path (n + 1, 3); see the module.

    >>> straight = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    >>> edited_paths(straight, np.array([[np.pi, 0.5]])).round(6).tolist()
    [[[0.0, 0.0, 0.0], [0.5, 0.0, 3.141593]]]
    """
    return _edited(path, np.linspace(0.0, 1.0, len(path)), edits)


def edited_stretch(path: FloatArray, shares: FloatArray, bend: float, stretch: float) -> FloatArray:
    """One variant's path (frames, 3) where frame t has turned by ``shares[t] * bend``."""
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
