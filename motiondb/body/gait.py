"""Steps of a person: when feet strike and leave the ground, and what the gait measures.

A foot swings where its slower end, ankle or toe, moves faster than ``SWING`` of the highest speed
of its swing. The strike is the end of this. The foot leaves the ground when the toe begins to move,
which is the mean of two signs: the toe reaches ``LEAVES`` of the highest speed, and the ankle rises
fastest. All bounds are shares of the swing's own speed, metres or seconds, so they hold for walking
and running, children and any rate. A swing counts that carries the foot on, and that has one of the
other foot beside it: who shifts or lifts a foot while standing does not walk. On a treadmill the
ground moves: :func:`over_ground` says how fast.

Step length and width are those of Huxham, Gong, Baker, Morris, Iansek, "Defining spatial parameters
for non-linear walking", Gait & Posture 23, 2006: along and across the line from a strike to the
next one of the same foot. The ankle stands for the foot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.body import body, rotation
from motiondb.body.features import runs
from motiondb.records import FloatArray

STRIKE, OFF = "foot_strike", "foot_off"
SWING, LEAVES = 0.22, 0.25
"""Shares of the highest speed of a swing. In 84 marks by people of four walkers at 100 frames a
second, 81 events are within 2 frames; force plates say 20 N two frames after these strikes."""
_SMOOTH = 0.012  # Seconds, standard deviation: passes half of the power at 10 Hz
_FASTER = 0.8  # Metres a second that a swing exceeds
_MOVES = 0.4  # Metres a second of a foot that is not at rest
_CARRIES = 0.15  # Shares of the leg by which a swing carries the foot on
_STRAIGHT = 0.5  # Of the way of the foot in a swing, its two ends are so far apart
_NEIGHBOUR = 1.0  # Seconds between two swings of one walk
_STRIDE = 1.5  # Seconds on each side within which speeds of swings are alike
_PUSH = 0.1  # Seconds before and after the toe moves in which the ankle rises fastest
_TOGETHER = 0.08  # Seconds up to which both feet land at once
_STANDS = 0.5  # Of the leg that the pelvis is above the lower ankle: who sits does not step
_BELT, _STAYS = 0.3, 0.3
"""Metres a second of a treadmill, and of its speed that of the pelvis over the take."""
_EVEN = 0.15  # Of the speed, within which two cycles go alike
_LONGEST = 2.5  # Seconds of the longest cycle
_PHASES = 101  # Places of a cycle, 0 to 100 %
_I = body.INDEX


@dataclass(frozen=True, order=True)
class FootEvent:
    """A foot strikes the ground, or leaves it."""

    seconds: float
    """From the start of the motion."""
    side: str
    """"l" or "r"."""
    name: str
    """"foot_strike" or "foot_off"."""


@dataclass(frozen=True)
class GaitCycle:
    """From a foot's strike to its next one; lengths in metres, None where they are not known."""

    side: str
    start: float
    end: float
    foot_off: float | None  # Seconds from the start of the motion
    stance: float | None  # Share of the cycle in which the foot is on the ground
    stride_length: float
    step_length: float | None  # From the other foot, at the strike that ends the cycle
    step_width: float | None
    step_time: float | None  # Since the strike of the other foot, seconds
    speed: float  # Metres a second
    turn: float  # Degrees by which the pelvis turns, positive to the left


@dataclass(frozen=True)
class GaitMeasure:
    """A measure of the cycles of both sides; None where there are no cycles to measure."""

    measure: str
    unit: str
    left: float | None
    right: float | None
    both: float | None
    deviation: float | None  # Standard deviation over the cycles of both sides
    asymmetry: float | None  # Left less right, per cent of their mean (Robinson 1987)


@dataclass(frozen=True)
class FootPrint:
    """Where a foot stands when it strikes: metres over the ground, z ahead and x left as in y up.

    On a treadmill they lie as over ground at rest.
    """

    side: str
    seconds: float
    x: float
    z: float
    heading: float  # Degrees of the foot from +z towards +x


@dataclass(frozen=True)
class JointAngles:
    """Angles of a joint over the cycles of a side, degrees, at 0, 1, ... 100 % of the cycle."""

    side: str
    joint: str  # "hip", "knee" or "ankle"
    mean: tuple[float, ...]
    deviation: tuple[float, ...]  # Standard deviation over the cycles


def over_ground(points: FloatArray, fps: float) -> tuple[FloatArray, float]:
    """Return a motion as it goes over the ground, and the speed of a treadmill, 0 without one.

    A treadmill is where the lower foot moves backwards evenly while the pelvis stays. `points`:
    places (frames, 21, 3) of the canonical joints, metres of the performer, y up.
    """
    if len(points) < 3:
        return points, 0.0
    ankles = points[:, [_I["l_ankle"], _I["r_ankle"]]]
    lower = ankles[..., 1].argmin(axis=1)
    speeds = np.gradient(ankles, axis=0)[np.arange(len(points)), lower] * fps
    belt = np.median(speeds, axis=0) * [1.0, 0.0, 1.0]
    speed = float(np.linalg.norm(belt))
    travel = (points[-1, 0] - points[0, 0])[[0, 2]] * fps / len(points)
    if speed < _BELT or np.linalg.norm(travel) > _STAYS * speed:
        return points, 0.0
    times = np.arange(len(points)) / fps
    return points - times[:, None, None] * belt, speed


def foot_events(points: FloatArray, fps: float) -> list[FootEvent]:
    """Find when feet strike and leave the ground.

    Gives them in the order of time. `points`: as of :func:`over_ground`, over ground at rest.

    >>> foot_events(np.zeros((100, 21, 3)), 100.0)  # who stands makes no steps
    []
    """
    if len(points) < 3:
        return []
    points = np.where(np.isfinite(points), points, 0.0)
    swings = {side: _swings(points, fps, side) for side in "lr"}
    found = []
    for side, other in ("lr", "rl"):
        for swing in swings[side]:
            if any(
                swing.first < o.last + _NEIGHBOUR * fps and o.first < swing.last + _NEIGHBOUR * fps
                for o in swings[other]
            ):
                times = ((swing.off, OFF), (swing.strike, STRIKE))
                found += [FootEvent(t / fps, side, n) for t, n in times if np.isfinite(t)]
    return sorted(found)


def step_times(points: FloatArray, fps: float) -> FloatArray:
    """The times at which feet strike, seconds; both feet at once are one step.

    `points`: as of :func:`over_ground`.
    """
    times = sorted(e.seconds for e in foot_events(points, fps) if e.name == STRIKE)
    apart = np.diff(times, prepend=-np.inf)
    return np.array(times)[apart > _TOGETHER]


def gait_cycles(
    points: FloatArray, fps: float, events: Sequence[FootEvent]
) -> tuple[GaitCycle, ...]:
    """Measure the cycles between strikes of the same foot, in the order of time.

    `points`: as of :func:`over_ground`.
    """
    strikes = {side: _times(events, side, STRIKE) for side in "lr"}
    heading = _headings(points)
    cycles = []
    for side, other in ("lr", "rl"):
        offs = _times(events, side, OFF)
        for start, end in zip(strikes[side], strikes[side][1:]):
            between = strikes[other][(strikes[other] > start) & (strikes[other] < end)]
            off = offs[(offs > start) & (offs < end)]
            if end - start > _LONGEST or len(between) > 1 or len(off) != 1:
                continue  # the other foot hopped, or this one was lost
            ankle = f"{side}_ankle"
            stride = (_at(points, fps, ankle, end) - _at(points, fps, ankle, start))[[0, 2]]
            length = float(np.linalg.norm(stride))
            step: tuple[float | None, float | None, float | None] = (None, None, None)
            if len(between) and length > 0:
                way = _at(points, fps, ankle, end) - _at(points, fps, f"{other}_ankle", between[0])
                along = float(way[[0, 2]] @ stride) / length
                across = float(stride[0] * way[2] - stride[1] * way[0]) / length
                outward = across if side == "r" else -across  # negative where the feet cross
                step = (along, outward, float(end - between[0]))
            first, last = (min(round(t * fps), len(points) - 1) for t in (start, end))
            turn = float(np.degrees(heading[last] - heading[first]))
            cycles.append(
                GaitCycle(
                    side,
                    float(start),
                    float(end),
                    float(off[0]),
                    float((off[0] - start) / (end - start)),
                    length,
                    *step,
                    length / float(end - start),
                    turn,
                )
            )
    return tuple(sorted(cycles, key=lambda cycle: cycle.start))


_MEASURES = (
    ("stride time", "s", lambda c: c.end - c.start),
    ("step time", "s", lambda c: c.step_time),
    ("stance", "%", lambda c: None if c.stance is None else 100.0 * c.stance),
    ("stride length", "m", lambda c: c.stride_length),
    ("step length", "m", lambda c: c.step_length),
    ("step width", "m", lambda c: c.step_width),
    ("speed", "m/s", lambda c: c.speed),
    ("turn", "degrees", lambda c: c.turn),
)  # Name, unit, and how it is taken from a cycle
_SIGNED = ("step width", "turn")  # Which have no asymmetry: they may be 0


def steady(cycles: Sequence[GaitCycle]) -> tuple[GaitCycle, ...]:
    """The cycles that go about as fast as the one before or after them; all, if none does.

    The others start or stop: a last step that only closes the feet is no asymmetry.
    """
    even = [abs(a.speed - b.speed) < _EVEN * max(a.speed, b.speed) for a, b in pairwise(cycles)]
    kept = [c for c, *near in zip(cycles, [False, *even], [*even, False]) if any(near)]
    return tuple(kept or cycles)


def measures(cycles: Sequence[GaitCycle]) -> tuple[GaitMeasure, ...]:
    """Return the means of the cycles by side, with the cadence; () without cycles."""
    if not cycles:
        return ()
    found = []
    for name, unit, take in _MEASURES:
        values = {side: [take(c) for c in cycles if c.side == side] for side in "lr"}
        known = {side: [v for v in of if v is not None] for side, of in values.items()}
        left, right = (float(np.mean(known[s])) if known[s] else None for s in "lr")
        every = known["l"] + known["r"]
        both = float(np.mean(every)) if every else None
        deviation = float(np.std(every)) if len(every) > 1 else None
        uneven = None
        if left is not None and right is not None and name not in _SIGNED and left + right:
            uneven = 200.0 * (left - right) / (left + right)
        found.append(GaitMeasure(name, unit, left, right, both, deviation, uneven))
    step = next(each.both for each in found if each.measure == "step time")
    cadence = None if step is None else 60.0 / step
    return (GaitMeasure("cadence", "steps/min", None, None, cadence, None, None), *found)


def foot_prints(
    points: FloatArray, fps: float, events: Sequence[FootEvent]
) -> tuple[FootPrint, ...]:
    """Return where the feet stand when they strike; arguments as of :func:`gait_cycles`."""
    prints = []
    for event in events:
        if event.name == STRIKE:
            ankle, toe = (
                _at(points, fps, f"{event.side}_{end}", event.seconds) for end in ("ankle", "toe")
            )
            heading = float(np.degrees(np.arctan2(*(toe - ankle)[[0, 2]])))
            x, z = float(ankle[0]), float(ankle[2])
            prints.append(FootPrint(event.side, event.seconds, x, z, heading))
    return tuple(prints)


def cycle_angles(
    points: FloatArray, fps: float, cycles: Sequence[GaitCycle]
) -> tuple[JointAngles, ...]:
    """Mean angles of hip, knee and ankle over the cycles of each side; degrees."""
    found = []
    times = np.arange(len(points)) / fps
    for side in "lr":
        spans = [(cycle.start, cycle.end) for cycle in cycles if cycle.side == side]
        for joint, angles in leg_angles(points, side).items() if spans else ():
            over = np.array([np.interp(np.linspace(*s, _PHASES), times, angles) for s in spans])
            mean, deviation = over.mean(axis=0), over.std(axis=0)
            found.append(JointAngles(side, joint, tuple(mean.tolist()), tuple(deviation.tolist())))
    return tuple(found)


def leg_angles(points: FloatArray, side: str) -> dict[str, FloatArray]:
    """Return flexion of hip, knee and ankle of a side: joint -> (frames,), degrees.

    Hip: between thigh and trunk, as both are seen from the side; knee: between thigh and shank, 0
    where it is straight; ankle: between shank and foot, 0 where they are at a right angle as in
    standing, positive where the toe is up. `points`: (frames, 21, 3), y up.
    """
    hip, knee, ankle, toe = (
        points[:, _I[f"{side}_{name}"]] for name in ("hip", "knee", "ankle", "toe")
    )
    across = rotation.normalize(points[:, _I["l_hip"]] - points[:, _I["r_hip"]])
    trunk = points[:, _I["neck"]] - points[:, _I["pelvis"]]
    trunk = rotation.normalize(trunk - np.sum(trunk * across, axis=1, keepdims=True) * across)
    ahead = np.cross(across, trunk)
    thigh, shank, foot = knee - hip, ankle - knee, toe - ankle
    stands = np.arctan2(0.06, 0.14)  # The foot of the canonical body slopes so
    return {
        "hip": np.degrees(np.arctan2(_dot(thigh, ahead), -_dot(thigh, trunk))),
        "knee": np.degrees(_angle(thigh, shank)),
        "ankle": 90.0 - np.degrees(_angle(-shank, foot) - stands),
    }


@dataclass(frozen=True)
class _Swing:
    """A foot in the air, in frames; NaN where the motion does not hold it."""

    first: int
    last: int
    off: float
    strike: float


def _swings(points: FloatArray, fps: float, side: str) -> list[_Swing]:
    """Return the swings of a foot that carry it on."""
    from scipy.ndimage import gaussian_filter1d, maximum_filter1d  # most pictures do without

    ends = [points[:, _I[f"{side}_{name}"]] for name in ("ankle", "toe")]
    ankle, toe = (gaussian_filter1d(end, _SMOOTH * fps, axis=0, mode="nearest") for end in ends)
    chain = points[:, [_I[f"{side}_{name}"] for name in ("hip", "knee", "ankle")]]
    leg = float(np.median(np.linalg.norm(np.diff(chain, axis=1), axis=2), axis=0).sum())
    low = points[:, [_I["l_ankle"], _I["r_ankle"]], 1].min(axis=1)
    stands = points[:, _I["pelvis"], 1] - low > _STANDS * leg
    rise = np.gradient(ankle[:, 1]) * fps
    speeds = [np.linalg.norm(np.gradient(end, axis=0), axis=1) * fps for end in (ankle, toe)]
    slower = np.minimum(*speeds)
    around = maximum_filter1d(slower, 2 * round(_STRIDE * fps) + 1, mode="nearest")
    found = []
    for first, last in runs(slower > np.maximum(_MOVES, SWING / 2.0 * around)):
        starts, ends_within = first > 0, last < len(slower)
        is_whole = starts and ends_within
        top = first + int(slower[first:last].argmax())
        peak = slower[top] if is_whole else around[top]
        way = float(np.linalg.norm(np.diff(ankle[first:last], axis=0), axis=1).sum())
        carried = float(np.linalg.norm(ankle[last - 1] - ankle[first]))
        far = max(_CARRIES * leg * is_whole, _STRAIGHT * way)
        if slower[top] < _FASTER or carried < far or not stands[top]:
            continue
        off = _crossing(speeds[1], top, -1, LEAVES * peak) if starts else np.nan
        if np.isfinite(off):
            low, high = (max(0, round(off + t * fps)) for t in (-_PUSH, _PUSH))
            part = rise[low : high + 1]
            off = (off + low + int(part.argmax())) / 2.0
        strike = _crossing(slower, top, 1, SWING * peak) if ends_within else np.nan
        found.append(_Swing(first, last, off, strike))
    return found


def _crossing(values: FloatArray, start: int, step: int, level: float) -> float:
    """Return where values fall to a level from a place on, in one direction; NaN if nowhere."""
    part = values[start:] if step > 0 else values[start::-1]
    below = np.flatnonzero(part <= level)
    if len(below) == 0 or below[0] == 0:
        return float("nan")
    high, low = part[below[0] - 1], part[below[0]]
    return start + step * (int(below[0]) - float((level - low) / (high - low)))


def _times(events: Sequence[FootEvent], side: str, name: str) -> FloatArray:
    """Return the times of one kind of events, seconds."""
    return np.array([e.seconds for e in events if (e.side, e.name) == (side, name)])


def _at(points: FloatArray, fps: float, joint: str, seconds: float) -> FloatArray:
    """Return the place (3,) of a joint at a time."""
    times = np.arange(len(points)) / fps
    return np.array([np.interp(seconds, times, points[:, _I[joint], axis]) for axis in range(3)])


def _headings(points: FloatArray) -> FloatArray:
    """Return the direction of the pelvis over the ground, radians, without jumps."""
    left = points[:, _I["l_hip"]] - points[:, _I["r_hip"]]
    return np.asarray(np.unwrap(np.arctan2(-left[:, 2], left[:, 0])))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.sum(a * b, axis=1))


def _angle(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the angle between vectors (frames, 3), radians."""
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), _dot(a, b))
