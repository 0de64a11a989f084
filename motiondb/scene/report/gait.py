"""How people stand, step and travel: feet in the air, steps, speed, jumps of planted feet.

All functions take joints of one body: array (frames, 21, 3), m, on the canonical body with the
ground at y = 0. The natural range of an action is measured on the captures that show it, with the
same functions (:class:`GaitRange`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import runs
from motiondb.generate.contact import MAX_HEIGHT, foot_heights
from motiondb.records import MOTION_FPS, FloatArray
from motiondb.scene.polish.seam_steps import ANKLES, LIFTED, TOES

SPEED_FRAMES = 15
"""Frames over which speed is averaged: half a second, so that one step does not count as fast."""
JUMP_FRAMES = (2, 9)
"""Shortest and longest time, frames, in which a planted foot's displacement counts as a jump.

Slower displacements are slides, which are measured by the mean speed of feet on the ground."""


@dataclass(frozen=True)
class GaitRange:
    """The most that captures of an action show."""

    airborne: int = 0  # Longest time with both feet in the air
    step: float = 0.0  # Largest horizontal distance between the ankles
    speed: float = 0.0  # Largest mean speed of the pelvis over half a second

    def including(self, other: GaitRange) -> GaitRange:
        """Return the range that includes both.

        >>> GaitRange(3, 0.5, 2.0).including(GaitRange(0, 0.8, 1.0))
        GaitRange(airborne=3, step=0.8, speed=2.0)
        """
        return GaitRange(
            max(self.airborne, other.airborne),
            max(self.step, other.step),
            max(self.speed, other.speed),
        )


def airborne(joints: FloatArray) -> NDArray[np.bool_]:
    """Return where both feet are in the air: array (frames,).

    A foot is in the air if its ankle and its toe are more than 5 cm above their height in a flat
    stance, the limit up to which :mod:`motiondb.generate.contact` looks for contacts.
    """
    return np.asarray(foot_heights(joints).min(axis=1) > MAX_HEIGHT)


def on_the_ground(
    joints: FloatArray, contacts: NDArray[np.bool_], edited: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return where feet are planted: contacts, and short times between them without a lift.

    A foot that leaves one place for another within 9 frames and is never lifted by more than
    2.5 cm looks like a planted foot that jumps. People may step so; so this counts only where the
    motion is not that of a capture.

    Shapes: `joints` (frames, 21, 3), m; `contacts`, result (frames, 2), bool; `edited` (frames,),
    bool.
    """
    planted, heights = contacts.copy(), foot_heights(joints)
    for foot in range(2):
        for start, end in runs(~contacts[:, foot]):
            inside = start > 0 and end < len(planted) and end - start < JUMP_FRAMES[1]
            if inside and edited[start:end].any() and heights[start:end, foot].max() <= LIFTED:
                planted[start:end, foot] = True
    return planted


def step_lengths(joints: FloatArray) -> FloatArray:
    """Return the horizontal distance between the ankles: array (frames,), m."""
    apart = joints[:, ANKLES[0]] - joints[:, ANKLES[1]]
    return np.asarray(np.hypot(apart[:, 0], apart[:, 2]))


def travel_speeds(joints: FloatArray) -> FloatArray:
    """Return the mean horizontal speed of the pelvis over half a second: array (frames,), m/s.

    The mean is over the distance between the ends of a window around each frame; near the ends of
    the motion the window is shorter.
    """
    n_frames = len(joints)
    frames = np.arange(n_frames)
    first = np.maximum(frames - SPEED_FRAMES // 2, 0)
    last = np.minimum(frames + SPEED_FRAMES // 2, n_frames - 1)
    away = joints[last, 0] - joints[first, 0]
    seconds = np.maximum(last - first, 1) / MOTION_FPS
    return np.asarray(np.hypot(away[:, 0], away[:, 2]) / seconds)


def gait_range(joints: FloatArray, intervals: Iterable[tuple[int, int]]) -> GaitRange:
    """Return the gait within frames [start, end) of a capture; overlapping intervals are joined.

    A time in the air counts as a whole where it begins within an interval.
    """
    inside = np.zeros(len(joints), dtype=bool)
    for start, end in intervals:
        inside[max(start, 0) : end] = True
    if not inside.any():
        return GaitRange()
    flights = [end - start for start, end in runs(airborne(joints)) if inside[start:end].any()]
    return GaitRange(
        max(flights, default=0),
        float(step_lengths(joints)[inside].max()),
        float(travel_speeds(joints)[inside].max()),
    )


@dataclass(frozen=True)
class FootJump:
    """The largest displacement of a planted foot within a short time."""

    metres: float = 0.0
    foot: int = -1  # 0 for the left foot, 1 for the right; -1 if no foot was ever planted
    start: int = 0  # First frame of the displacement
    end: int = 0


def foot_jump(joints: FloatArray, planted: NDArray[np.bool_]) -> FootJump:
    """Return the largest displacement of a foot while it is planted, within 2 to 9 frames.

    A foot may roll over its toe or its heel. So the displacement is that of the ankle or of the
    toe, whichever is smaller.

    Shapes: `joints` (frames, 21, 3), m; `planted` (frames, 2), bool.
    """
    worst = FootJump()
    for foot in range(2):
        ankle, toe = joints[:, ANKLES[foot]], joints[:, TOES[foot]]
        for start, end in runs(planted[:, foot]):
            for later in range(JUMP_FRAMES[0], min(JUMP_FRAMES[1], end - start - 1) + 1):
                moved = np.minimum(_moved(ankle[start:end], later), _moved(toe[start:end], later))
                at = int(np.argmax(moved))
                if moved[at] > worst.metres + 1e-9:
                    worst = FootJump(float(moved[at]), foot, start + at, start + at + later)
    return worst


def _moved(places: FloatArray, later: int) -> FloatArray:
    """Return the horizontal displacement (frames - later,) within ``later`` frames, m."""
    away = places[later:] - places[:-later]
    return np.asarray(np.hypot(away[:, 0], away[:, 2]))
