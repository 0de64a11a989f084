"""How far, how fast or by which angle a motion goes: "turn left by 90 degrees", "walk 3 steps".

=======  ======================  ================================================================
measure  of                      measured, for each time in which it goes on
=======  ======================  ================================================================
angle    turns, travelling       the change of the heading, without turns that are taken back
way      flights of jumps        over the ground; up, if the action says "high" or "up"
way      travelling              the length of the path over the ground
speed    travelling              the mean over its fastest second
steps    travelling, steps       how often one foot passes the other
=======  ======================  ================================================================

A number without a limit is met within a fifth of it, or within ``WITHIN``; limits are met exactly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.body.features import runs
from motiondb.language.question.amounts import Measure
from motiondb.language.question.tree import LIMBS
from motiondb.language.vocabulary import TRAVELS
from motiondb.meaning.degrees import Degree, count_steps
from motiondb.meaning.occurrences import FLIGHTS, find_occurrences
from motiondb.meaning.travelled import (
    GOING,
    lasting_turns,
    means_of,
    steady_speed,
    turning,
    ways,
)
from motiondb.records import MOTION_FPS, FloatArray

WITHIN = {"angle": 15.0, "way": 0.15, "speed": 0.2, "steps": 0.0}  # Degrees, m, m/s
HIGH_WITHIN = 0.03  # Metres, of the height of a jump
SHARE = 0.2  # Of a number, within which it is met
SHORTEST = 0.5  # Seconds for which somebody must go, unless the motion is shorter
SMOOTHED = 0.7  # Seconds over which turning is averaged: hips sway with every step
TURNS_FROM, LEAST_TURN = 0.25, 20.0  # rad/s and degrees of one turn
_AHEAD = frozenset(("forward", "backward", "back", "sideways"))  # Ways that do not turn
_VERBS = {"angle": "turns by", "way": "goes", "speed": "goes at", "steps": "takes"}


def is_gauged(measure: Measure, action: Sequence[str]) -> bool:
    """Whether a measure is measured of an action.

    >>> quarter = Measure("angle", 90, 90)
    >>> is_gauged(quarter, ("turn", "left")), is_gauged(quarter, ("wave",))
    (True, False)
    """
    travels, jumps = not TRAVELS.isdisjoint(action), not set(FLIGHTS).isdisjoint(action)
    if measure.what == "angle" and not (LIMBS | {"head"}).isdisjoint(action):
        return False  # which is turned, not the body
    return {
        "angle": bool(turning(action)) or travels,
        "way": travels or jumps,
        "speed": travels and not jumps,
        "steps": travels and not jumps,
    }.get(measure.what, False)


def outside(measure: Measure, action: Sequence[str], amount: float) -> float:
    """How far an amount of an action is outside what is asked for; 0 or less if it meets that.

    >>> quarter = Measure("angle", 90, 90)
    >>> outside(quarter, ("turn",), 75.0) <= 0.0, outside(quarter, ("turn",), 180.0) > 0.0
    (True, True)
    >>> outside(Measure("steps", 3, None), ("walk",), 2.0)
    1.0
    """
    if measure.least == measure.most:
        slack = 0.0 if measure.what == "steps" and measure.least < 1 / SHARE else SHARE
        within = HIGH_WITHIN if _is_height(measure, action) else WITHIN[measure.what]
        allowed = max(slack * measure.least, within)
        return abs(amount - measure.least) - allowed
    most = amount if measure.most is None else measure.most
    return max(measure.least - amount, amount - most)


def off(measure: Measure, action: Sequence[str], amount: float) -> tuple[float, float]:
    """How far an amount is outside, and from the number: of several, the least meets it best."""
    return max(outside(measure, action, amount), 0.0), abs(amount - measure.least)


def say_amount(measure: Measure, action: Sequence[str], amount: float) -> str:
    """What was measured of an action, in the unit in which a question names it.

    >>> say_amount(Measure("angle", 90, 90), ("turn",), 97.3)
    'turns by 97 degrees'
    """
    verb = "jumps" if _is_jump(measure, action) else _VERBS[measure.what]
    if measure.what == "angle":
        return f"{verb} {amount:.0f} degrees"
    if measure.what == "steps":
        return f"{verb} {amount:.0f} step{'' if round(amount) == 1 else 's'}"
    return f"{verb} {amount:.2f} m" if measure.what == "way" else f"{verb} {amount:.1f} m/s"


def amounts_of(
    measure: Measure,
    action: Sequence[str],
    track: FloatArray,
    speeds: FloatArray | None = None,
    fps: float = MOTION_FPS,
) -> list[tuple[float, int, int]]:
    """The amount of every time [a, b) in which an action goes on, in frames of `speeds`.

    Shapes: `track` (frames, columns), that of ``measured_track``; `speeds` (frames, 3), those of
    ``speeds_of`` at `fps` frames a second; without them, those of the track.
    """
    if speeds is None:
        speeds = track[:, 1:4]
    each = MOTION_FPS / fps  # Frames of the track for one of the speeds
    if measure.what == "angle":
        return _turned(speeds, action, fps)
    if _is_jump(measure, action):
        kind = "height" if _is_height(measure, action) else "way"
        degree = Degree(kind, 1.0, frozenset())
        return [
            (degree.amount(track, a, b), int(a // each), int(-(-b // each)))
            for a, b in find_occurrences(track, "jump")
        ]
    speed = np.hypot(speeds[:, 0], speeds[:, 1])
    goes = steady_speed(speeds, fps) > GOING
    for direction in _AHEAD.intersection(action):
        goes &= _smooth(np.max(ways(speeds, direction, "", fps), axis=0), fps) > 0.0
    found = []
    for a, b in runs(np.asarray(goes)):
        if b - a < SHORTEST * fps and b - a < len(speeds):
            continue
        if measure.what == "steps":
            amount = float(count_steps(track[round(each * a) : round(each * b)]))
        elif measure.what == "way":
            amount = float(speed[a:b].sum() / fps)
        else:
            amount = float(means_of(speed[a:b], min(round(fps), int(b - a))).max())
        found.append((amount, int(a), int(b)))
    return found


def _is_height(measure: Measure, action: Sequence[str]) -> bool:
    """Whether a measure is the height of a jump."""
    return _is_jump(measure, action) and not {"high", "up"}.isdisjoint(action)


def _is_jump(measure: Measure, action: Sequence[str]) -> bool:
    return measure.what == "way" and not set(FLIGHTS).isdisjoint(action)


def _turned(speeds: FloatArray, action: Sequence[str], fps: float) -> list[tuple[float, int, int]]:
    """The turns of a motion to the side of an action, or to either one, with their angles."""
    turned = lasting_turns(speeds, fps)
    rate = _smooth(turned * fps, fps)
    asked = {"left": (1.0,), "right": (-1.0,)}
    signs = next((asked[word] for word in action if word in asked), (1.0, -1.0))
    found = [
        (float(np.degrees(sign * turned[a:b].sum())), int(a), int(b))
        for sign in signs
        for a, b in runs(np.asarray(sign * rate > TURNS_FROM))
    ]
    return [one for one in found if one[0] >= LEAST_TURN]


def _smooth(values: FloatArray, fps: float) -> FloatArray:
    """Values averaged over ``SMOOTHED`` seconds around each: array (frames,)."""
    half = round(SMOOTHED * fps) // 2
    return means_of(np.pad(values, half, mode="edge"), 2 * half + 1)
