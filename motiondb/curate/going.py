"""How a body goes: kinds of going, turns, starts, stops and changes, in metres of the performer.

Speeds are displacements of the pelvis over half a second, as it sways within a step. Directions are
relative to the heading, turns are changes of the heading over a second. A run passes through a walk
before it stops, and before it is a run: what a stop comes from, and what a start leads to, is the
fastest gait within 1.6 seconds. All bounds of speed are by hand, for adults; a slow run and a fast
walk of the same speed are not told apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.body import body, features, retarget
from motiondb.body.features import runs
from motiondb.records import MOTION_FPS, BoolArray, FloatArray, IntArray, Motion

STANDS = 0.2  # Speed below which a body stands, m/s
KINDS: tuple[tuple[str, float, float], ...] = (
    ("stand", 0.0, STANDS),
    ("walk slowly", STANDS, 0.9),
    ("walk", 0.9, 1.4),
    ("walk fast", 1.4, 1.9),
    ("jog", 1.9, 3.0),
    ("run", 3.0, np.inf),
    ("go left sideways", 0.4, np.inf),
    ("go right sideways", 0.4, np.inf),
    ("go backward", 0.4, np.inf),
)
"""Kinds of going with their speeds, m/s; sideways and backward from 0.4, where sway would reach."""
TURNS = ("sharp left", "left", "none", "right", "sharp right")
_TURN, _SHARP = np.radians(20.0), np.radians(60.0)  # Of a turn within a second
CHANGES = (
    "start to walk",
    "start to run",
    "walk to run",
    "run to walk",
    "stop from a walk",
    "stop from a run",
)
FEET = ("left foot", "right foot")
_RUN = 1.9  # Speed of a gait that counts as a run, m/s
_HOLD = tuple(round(s * MOTION_FPS) for s in (0.3, 0.4, 0.25))
"""Frames that standing, a walk and a run hold; standing at the ends of a capture holds any."""
_WALK = round(0.6 * MOTION_FPS)  # Frames of a walk that is no slow corner of a run
_BACK = round(1.6 * MOTION_FPS)  # Frames looked back and ahead
_APART = 0.2  # Metres between the ankles along the heading that say which is ahead
_UPRIGHT, _LOW = 0.7, 0.65  # Cosine of the trunk; height of the pelvis by the length of the legs
_GAITS = 1.4  # Kinds that differ by one of these in metres a second are as far as a right angle


@dataclass(frozen=True, eq=False)
class Going:
    """How a body goes, frame by frame, 30 a second."""

    speed: FloatArray  # (frames,): m/s over the ground
    aside: FloatArray  # (frames,): angle of travel from the heading, radians, positive to the left
    turn: FloatArray  # (frames,): of the heading within a second, radians, positive to the left
    upright: BoolArray  # (frames,)
    ahead: FloatArray  # (frames,): left ankle before the right one along the heading, metres

    @property
    def kinds(self) -> IntArray:
        """Number of the kind of every frame, -1 where the body is not upright."""
        found = np.searchsorted([low for _, low, _ in KINDS[1:6]], self.speed, side="right")
        side, back = np.abs(self.aside) > np.pi / 4, np.abs(self.aside) > 3 * np.pi / 4
        slow = self.speed < KINDS[6][1]
        found = np.where(side & slow, 0, found)
        other = np.where(back, 8, np.where(self.aside > 0, 6, 7))
        found = np.where(side & ~slow, other, found)
        return np.where(self.upright, found, -1)

    @property
    def turns(self) -> IntArray:
        """Number of the turn of every frame."""
        return np.searchsorted([-_SHARP, -_TURN, _TURN, _SHARP], -self.turn, side="right")


def going_of(motion: Motion) -> Going:
    """How a body goes, from its motion, in its own size."""
    positions, rotations = retarget.motion_positions(motion)
    positions = positions * (motion.leg_length / body.LEG_LENGTH)
    heading = features.headings(rotations)
    facing = np.stack([np.sin(heading), np.cos(heading)], axis=1)  # x, z
    pelvis = positions[:, 0][:, [0, 2]]
    way, seconds = _change(pelvis, 0.5)
    velocity = way / seconds[:, None]
    forward = np.einsum("fc,fc->f", velocity, facing)
    left = velocity[:, 0] * facing[:, 1] - velocity[:, 1] * facing[:, 0]
    turned, seconds_turned = _change(heading, 1.0)
    at = body.INDEX
    trunk = positions[:, at["neck"]] - positions[:, 0]
    cosine = trunk[:, 1] / np.maximum(np.linalg.norm(trunk, axis=1), 1e-6)
    feet = positions[:, [at["l_ankle"], at["r_ankle"]]]
    high = positions[:, 0, 1] - feet[..., 1].min(axis=1)
    between = np.einsum("fc,fc->f", (feet[:, 0] - feet[:, 1])[:, [0, 2]], facing)
    return Going(
        np.linalg.norm(velocity, axis=1),
        np.arctan2(left, forward),
        turned / seconds_turned,
        (cosine > _UPRIGHT) & (high > _LOW * motion.leg_length),
        between,
    )


def _change(values: FloatArray, seconds: float) -> tuple[FloatArray, FloatArray]:
    """Change of values (frames, ...) over some seconds around every frame, and these seconds."""
    n, half = len(values), round(seconds * MOTION_FPS / 2.0)
    low, high = np.maximum(np.arange(n) - half, 0), np.minimum(np.arange(n) + half, n - 1)
    return values[high] - values[low], np.maximum(high - low, 1) / MOTION_FPS


@dataclass(frozen=True)
class Change:
    """A start, a stop, or a change of gait."""

    frame: int
    kind: int  # Number among CHANGES
    foot: int  # Number among FEET


def changes_of(going: Going) -> list[Change]:
    """Starts, stops and changes of gait of one capture, in order."""
    gait = np.digitize(going.speed, [STANDS, _RUN])  # 0 stands, 1 walks, 2 runs
    gait = np.where(going.upright, gait, -1)
    held = _held(gait)
    out = []
    for (a0, a1, before), (b0, b1, after) in pairwise(held):
        if -1 in gait[a1 - 1 : b0 + 1]:
            continue  # down on the floor between
        if before == 0:
            ahead = max(g for s, _, g in held if b0 <= s < a1 + _BACK or s == b0)
            out.append(Change(a1, 0 if ahead == 1 else 1, _foot(going, a1, 1)))
        elif after == 0:
            back = max(g for _, e, g in held if b0 - _BACK < e <= a1 or e == a1)
            out.append(Change(b0, 4 if back == 1 else 5, _foot(going, b0, -1)))
        elif (a1 - a0 if before == 1 else b1 - b0) >= _WALK and not _near_stand(held, a1, b0):
            out.append(Change(b0, 2 if after == 2 else 3, _foot(going, b0, 1)))
    return out


def _held(gait: IntArray) -> list[tuple[int, int, int]]:
    """Runs of one gait that hold for a while: start, end, gait; neighbours differ."""
    found = sorted(
        (a, b, g)
        for g in (0, 1, 2)
        for a, b in runs(np.asarray(gait == g))
        if b - a >= _HOLD[g] or (g == 0 and (a == 0 or b == len(gait)))
    )
    out: list[tuple[int, int, int]] = []
    for a, b, g in found:
        if out and out[-1][2] == g and -1 not in gait[out[-1][1] : a]:
            out[-1] = (out[-1][0], b, g)
        else:
            out.append((a, b, g))
    return out


def _near_stand(held: list[tuple[int, int, int]], before: int, after: int) -> bool:
    """Whether the body stood within 1.6 s of a change: then it is a start or a stop."""
    return any(g == 0 and e > before - _BACK and s < after + _BACK for s, e, g in held)


def _foot(going: Going, frame: int, step: int) -> int:
    """The foot ahead where the feet are first apart, from a frame on or back."""
    part = going.ahead[frame::step] if step > 0 else going.ahead[frame::-1]
    part = part[: _BACK // 2]
    apart = np.flatnonzero(np.abs(part) > _APART)
    return int((part[apart[0]] if len(apart) else going.ahead[frame]) <= 0.0)


def moments(going: Going) -> FloatArray:
    """What a second is compared by: array (seconds, 4), by its middle frame.

    Speed in units of 1.4 m/s, sine and cosine of the direction (weak below 0.4 m/s), turn in
    right angles; rows of seconds that are not upright are NaN.
    """
    middle = np.arange(round(MOTION_FPS / 2), len(going.speed), round(MOTION_FPS))
    speed, aside = going.speed[middle], going.aside[middle]
    weight = np.minimum(1.0, speed / KINDS[6][1])
    found = np.stack(
        [
            speed / _GAITS,
            weight * np.sin(aside),
            weight * np.cos(aside),
            going.turn[middle] / (np.pi / 2),
        ],
        axis=1,
    )
    found[~going.upright[middle]] = np.nan
    return found


def wanted(kind: int, turn: int) -> FloatArray:
    """The moment in the middle of a cell, as :func:`moments` has them."""
    low, high = KINDS[kind][1:]
    speed = 1.0 if kind > 5 else (low + high) / 2.0 if np.isfinite(high) else low + 0.7
    angle = {6: np.pi / 2, 7: -np.pi / 2, 8: np.pi}.get(kind, 0.0)
    weight = min(1.0, speed / KINDS[6][1])
    degrees = (90.0, 40.0, 0.0, -40.0, -90.0)[turn]
    return np.array(
        [speed / _GAITS, weight * np.sin(angle), weight * np.cos(angle), degrees / 90.0]
    )


def phrase(kind: int, turn: int) -> str:
    """A cell in words.

    >>> phrase(5, 0), phrase(1, 2), phrase(0, 3)
    ('run with a sharp left turn', 'walk slowly straight on', 'stand with a right turn')
    """
    straight = "without a turn" if kind == 0 or kind > 5 else "straight on"
    return f"{KINDS[kind][0]} " + (straight if turn == 2 else f"with a {TURNS[turn]} turn")
