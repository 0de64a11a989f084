"""How smooth a motion is, beside the captures at the frames that it comes from.

Slip is measured as :mod:`motiondb.body.contacts` sees contacts in the motion itself; whether a
foot should stand, and so does not float, the captures say.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body import retarget
from motiondb.body.contacts import (
    FEET,
    MAX_HEIGHT,
    TOE_HEIGHT,
    contact_speeds,
    find_contacts,
    foot_heights,
)
from motiondb.generate.material import SequenceMotion
from motiondb.records import MOTION_FPS, FloatArray, Motion


@dataclass(frozen=True)
class Smoothness:
    """Slip and jumps in m/s, heights in m; None where no capture is the source, or no foot stands.

    A jump is the change of the pelvis's speed over the ground from one frame to the next.
    """

    foot_slip: float | None  # Mean ground speed of feet in contact, of the slower of ankle and toe
    foot_slip_of_sources: float | None
    toe_slip: float | None  # Mean ground speed of the toes of feet in contact that are low
    toe_slip_of_sources: float | None
    speed_jump: float  # Largest jump
    speed_jump_of_sources: float | None
    floating: float | None  # Mean height of the lower foot where one stands in the sources
    floating_of_sources: float | None


@dataclass(frozen=True, eq=False)
class _Frames:
    """What is measured at every frame of a motion."""

    slip: FloatArray  # (frames, 2), m/s; NaN without contact
    toes: FloatArray  # (frames, 2), m/s; NaN without contact, and where the toe is not low
    jumps: FloatArray  # (frames,), m/s
    lower: FloatArray  # (frames,): height of the lower foot, m
    stands: NDArray[np.bool_]  # (frames,): whether a foot is in contact

    def at(self, frames: NDArray[np.int64]) -> _Frames:
        """The same at some of the frames."""
        return _Frames(*(column[frames] for column in vars(self).values()))


def measure_smoothness(made: SequenceMotion, motion: Callable[[int], Motion]) -> Smoothness:
    """Measure a motion and its sources; `motion` gives a capture by its number."""
    own = _measure(made.motion)
    used = sorted(set(made.captures.tolist()))
    if -1 in used:
        slip, toes, jump, low = _summary(own, own.stands)
        return Smoothness(slip, None, toes, None, jump, None, low, None)
    source = np.rint(made.frames).astype(np.int64)
    parts, order = [], []
    for capture in used:
        here = np.flatnonzero(made.captures == capture)
        measured = _measure(motion(capture))
        parts.append(measured.at(np.minimum(source[here], len(measured.jumps) - 1)))
        order.append(here)
    back = np.argsort(np.concatenate(order))
    columns = zip(*(vars(part).values() for part in parts))
    theirs = _Frames(*(np.concatenate(column)[back] for column in columns))
    slip, toes, jump, low = _summary(own, theirs.stands)
    slips, toe_slips, jumps, lows = _summary(theirs, theirs.stands)
    return Smoothness(slip, slips, toes, toe_slips, jump, jumps, low, lows)


def _measure(motion: Motion) -> _Frames:
    positions, _ = retarget.motion_positions(motion, (0, *FEET))
    positions = positions.astype(np.float64)
    contacts = find_contacts(positions)
    toes = positions[:, FEET[1::2]]
    speeds = np.linalg.norm(np.gradient(toes[..., [0, 2]], axis=0), axis=-1) * MOTION_FPS
    is_low = contacts & (toes[..., 1] - TOE_HEIGHT < MAX_HEIGHT / 2.0)
    steps = np.linalg.norm(np.diff(positions[:, 0][:, [0, 2]], axis=0), axis=1) * MOTION_FPS
    jumps = np.zeros(motion.n_frames)
    jumps[1:-1] = np.abs(np.diff(steps))
    return _Frames(
        contact_speeds(motion),
        np.where(is_low, speeds, np.nan),
        jumps,
        np.maximum(foot_heights(positions).min(axis=1), 0.0),
        np.asarray(contacts.any(axis=1)),
    )


def _summary(
    frames: _Frames, stands: NDArray[np.bool_]
) -> tuple[float | None, float | None, float, float | None]:
    """Foot slip, toe slip and largest jump, and the mean height of the lower foot at `stands`."""
    return (
        _mean(frames.slip),
        _mean(frames.toes),
        float(frames.jumps.max(initial=0.0)),
        _mean(frames.lower[stands]),
    )


def _mean(values: FloatArray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else None
