"""Visible faults of a scene that no rule covers: feet, steps, speed, limbs, guards.

The allowed range of an action is measured on the captures of the database that show it
(:func:`natural_ranges`): how long both feet are in the air, how far apart they are, how fast the
body travels. Editing changes all of this a little, so the limits are somewhat wider. Motion beyond
them is impossible: people do not walk with both feet in the air.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget
from motiondb.body.contacts import MAX_HEIGHT, find_contacts, foot_heights
from motiondb.body.features import runs
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.polish.placed import FOLLOWS, Placed
from motiondb.scene.polish.splicing import ANKLES, LIFTED, TOES
from motiondb.scene.report.report_records import (
    ImpossibleMotion,
    JumpReport,
    LimbReport,
)
from motiondb.scene.timing.scheduling import SLOWEST

# The distance between the limbs of two bodies: the nearest bones, as segments between joints.


REACH = 2.4
"""Distance of two pelvises, m, from which on no limbs can be near: twice an arm and the trunk."""
_CHILDREN = np.arange(1, len(body.JOINTS))
_TINY = 1e-12  # Squared length, m^2, below which a segment counts as a point


def limb_distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the distance between the nearest bones of two bodies: array (frames,), m.

    It is infinite if the bodies are out of each other's reach.

    Shapes: `first`, `second` (frames, 21, 3), m.

    For segments a + s (b - a) and c + t (d - c) with s, t in [0, 1] the squared distance is a
    convex quadratic in s and t. Its minimum is that of the two lines if both s and t are inside;
    otherwise it is at an end of one of the segments.

    Source: C. Ericson, "Real-Time Collision Detection" (2005), section 5.1.9.
    """
    nearest = np.full(len(first), np.inf)
    near = np.flatnonzero(np.linalg.norm(first[:, 0] - second[:, 0], axis=1) < REACH)
    parents = body.PARENTS[_CHILDREN]
    for bone, parent in zip(_CHILDREN.tolist(), parents.tolist(), strict=True):
        apart = segment_distances(
            first[near, None, parent],
            first[near, None, bone],
            second[near][:, parents],
            second[near][:, _CHILDREN],
        )
        nearest[near] = np.minimum(nearest[near], apart.min(axis=1))
    return nearest


def segment_distances(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Return the distances (...) of segments from a to b and from c to d, arrays (..., 3).

    >>> a, b = np.array([0.0, 0.0, 0.0]), np.array([2.0, 0.0, 0.0])
    >>> c, d = np.array([1.0, 1.0, 3.0]), np.array([1.0, 1.0, -3.0])
    >>> float(segment_distances(a, b, c, d))
    1.0
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = _dot(u, u), _dot(v, v), _dot(u, v)
    uw, vw = _dot(u, w), _dot(v, w)
    across = uu * vv - uv * uv
    s = np.clip(
        np.where(across > _TINY, (uv * vw - vv * uw) / np.maximum(across, _TINY), 0.0), 0, 1
    )
    t = np.clip((uv * s + vw) / np.maximum(vv, _TINY), 0.0, 1.0)
    s = np.clip((uv * t - uw) / np.maximum(uu, _TINY), 0.0, 1.0)  # the nearest to that end
    between = w + s[..., None] * u - t[..., None] * v
    return np.asarray(np.sqrt(_dot(between, between)))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.sum(a * b, axis=-1))


# How people stand, step and travel: feet in the air, steps, speed, jumps of planted feet. All
# functions take joints of one body: array (frames, 21, 3), m, on the canonical body with the ground
# at y = 0.

SPEED_FRAMES = 15
"""Frames over which speed is averaged: half a second, so that one step does not count as fast."""
JUMP_FRAMES = (2, 9)
"""Shortest and longest time, frames, in which a planted foot's displacement counts as a jump.

Slower displacements are slides, which are measured by the mean speed of feet on the ground."""


@dataclass(frozen=True)
class GaitRange:
    """The most that captures of an action show, measured by the functions that measure scenes."""

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
    stance, the limit up to which :mod:`motiondb.body.contacts` looks for contacts.
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


WAITING = "waiting"  # Name of the time between the actions of a player
STANDING = GaitRange(airborne=0, step=0.8, speed=0.8)
"""The allowed range of standing, which includes small steps."""
AIR_SLACK = 3
"""Frames in the air beyond those of the captures (as long as time may stretch them). Less than 4
frames are not visible, and blends lift feet for as long."""
SPEED_FACTOR, SPEED_SLACK = 1.5, 0.25
"""An action may be this many times as fast as in its captures, plus so many m/s. A clip may be
stretched by 1.3, and time by 1.25; both together look wrong."""
STEP_FACTOR, STEP_SLACK = 1.3, 0.1
"""An action's steps may be this many times as long as in its captures, plus so many m: the stretch
of a clip."""
JUMP_LIMIT = 0.15
"""Displacement of a planted foot within 0.3 s, m, that is clearly visible. Chosen by
hand; smaller ones are reported but not refused."""
NEAR_LIMBS = 0.05
"""Distance between the axes of bones, m, below which limbs count as near: half a limb's width."""
CROSSING = 0.01  # Distance between the axes of bones, m, below which limbs pass through each other
_BLEND = 5  # Frames around a seam in which either neighbour's limits hold: half a blend


def natural_ranges(
    library: ClipLibrary, motions: Mapping[str, Motion], actions: set[str]
) -> dict[str, GaitRange]:
    """Return the gait of each of some actions in all captures that the library has of it."""
    ranges = {WAITING: STANDING}
    joints: dict[str, FloatArray] = {}
    for action in sorted(actions):
        intervals: dict[str, set[tuple[int, int]]] = {}
        for entry in library.of(action):
            source = library.source[entry]
            intervals.setdefault(source.capture, set()).add((source.start, source.end))
        gait = GaitRange()
        for capture, shown in intervals.items():
            if capture not in joints:
                joints[capture] = retarget.motion_positions(motions[capture])[0]
            gait = gait.including(gait_range(joints[capture], sorted(shown)))
        ranges[action] = gait
    return ranges


def shown_actions(placed: Placed, actions: Sequence[str]) -> list[str]:
    """Return the action of a player at every frame, or :data:`WAITING`."""
    shown = []
    for edit, clip in zip(placed.edits, np.asarray(placed.clips).tolist(), strict=True):
        said = edit.split(", ")
        follows = [one.removeprefix(FOLLOWS) for one in said if one.startswith(FOLLOWS)]
        shown.append(WAITING if "waits" in said else (*follows, actions[clip])[0])
    return shown


def impossible_gait(
    player: str, joints: FloatArray, labels: Sequence[str], ranges: Mapping[str, GaitRange]
) -> list[ImpossibleMotion]:
    """Return the frames in which a player's gait is impossible for their action.

    Shapes: `joints` (frames, 21, 3), m.
    """
    natural = [ranges[label] for label in labels]
    airborne_limits = _widest([n.airborne for n in natural], _BLEND)
    faults = []
    for start, end in runs(airborne(joints)):
        limit = math.ceil(SLOWEST * float(airborne_limits[start:end].max())) + AIR_SLACK
        if end - start > limit:
            middle = (start + end) // 2
            faults.append(
                ImpossibleMotion(
                    "airborne",
                    (player,),
                    labels[middle],
                    start,
                    end,
                    middle,
                    float(end - start),
                    float(limit),
                    "frames",
                )
            )
    speed_limits = _widest([n.speed for n in natural], _BLEND + SPEED_FRAMES // 2)
    step_limits = _widest([n.step for n in natural], _BLEND)
    for kind, unit, values, limits in (
        ("speed", "m/s", travel_speeds(joints), SPEED_FACTOR * speed_limits + SPEED_SLACK),
        ("step", "m", step_lengths(joints), STEP_FACTOR * step_limits + STEP_SLACK),
    ):
        for start, end in runs(values > limits):
            worst = start + int(np.argmax((values - limits)[start:end]))
            value, limit_there = float(values[worst]), float(limits[worst])
            faults.append(
                ImpossibleMotion(
                    kind, (player,), labels[worst], start, end, worst, value, limit_there, unit
                )
            )
    return faults


def _widest(values: Sequence[float], reach: int) -> FloatArray:
    """Return the largest value within ``reach`` frames on both sides of each."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(np.asarray(values, dtype=float), 2 * reach + 1))


def planted_feet(
    placed: Placed, joints: FloatArray, motions: Mapping[str, Motion]
) -> NDArray[np.bool_]:
    """Return which feet are planted: array (frames, 2), left and right.

    A foot is planted if it is in contact in the scene, or in the capture that the frame shows and
    not lifted in the scene, or between two such times in a blend without being lifted. While a
    player waits, feet step on their own, and only contacts in the scene count.
    """
    planted, low = find_contacts(joints), foot_heights(joints) <= LIFTED
    known: dict[str, NDArray[np.bool_]] = {}
    words = [edit.split(", ") for edit in placed.edits]
    for frame, edits in enumerate(words):
        if "waits" in edits:
            continue
        capture = placed.captures[int(placed.source_numbers[frame])]
        if capture not in known:
            known[capture] = find_contacts(retarget.motion_positions(motions[capture])[0])
        there = int(np.clip(np.rint(placed.source_frames[frame]), 0, len(known[capture]) - 1))
        contacts = known[capture][there]
        planted[frame] |= low[frame] & (contacts[::-1] if "mirror" in edits else contacts)
    blended = [any(edit.startswith(("blend", "waits")) for edit in edits) for edits in words]
    return on_the_ground(joints, planted, np.array(blended, dtype=bool))


def foot_jumps(placed: Placed, joints: FloatArray, motions: Mapping[str, Motion]) -> JumpReport:
    """Return the largest displacement of a planted foot of a player, beside their captures'."""
    jump = foot_jump(joints, planted_feet(placed, joints, motions))
    source = 0.0
    for capture in placed.captures:
        there = retarget.motion_positions(motions[capture])[0]
        source = max(source, foot_jump(there, find_contacts(there)).metres)
    foot = ("left", "right", "")[jump.foot]
    return JumpReport(placed.player, foot, jump.metres, jump.start, jump.end, source)


def impossible_jump(jump: JumpReport, labels: Sequence[str]) -> list[ImpossibleMotion]:
    """Return a jump of a planted foot as impossible motion if it is beyond the limit.

    The limit is :data:`JUMP_LIMIT`, or that of the stretched steps of the captures, if larger.
    """
    limit = max(JUMP_LIMIT, STEP_FACTOR * jump.source_metres)
    if jump.metres <= limit:
        return []
    return [
        ImpossibleMotion(
            "foot jump",
            (jump.player,),
            labels[jump.end],
            jump.start,
            jump.end + 1,
            jump.end,
            jump.metres,
            limit,
            "m",
        )
    ]


def near_limbs(names: Sequence[str], joints: Sequence[FloatArray]) -> Iterator[LimbReport]:
    """Yield every pair of players whose limbs are less than 5 cm apart at some time."""
    for one, other in combinations(range(len(names)), 2):
        apart = limb_distances(joints[one], joints[other])
        frame = int(np.argmin(apart))
        near = int((apart < NEAR_LIMBS).sum())
        if near:
            yield LimbReport((names[one], names[other]), float(apart[frame]), frame, near)


def crossing_limbs(limbs: Sequence[LimbReport]) -> list[ImpossibleMotion]:
    """Return the pairs of players whose limbs pass through each other."""
    return [
        ImpossibleMotion(
            "limbs",
            pair.players,
            "",
            pair.frame,
            pair.frame + 1,
            pair.frame,
            pair.metres,
            CROSSING,
            "m",
        )
        for pair in limbs
        if pair.metres < CROSSING
    ]
