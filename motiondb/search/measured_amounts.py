"""How far, how fast or by which angle, as "turn left by 90 degrees" and "walk three steps" ask.

=======  ======================  ================================================================
measure  of                      measured, for each time in which it goes on
=======  ======================  ================================================================
angle    turns                   the change of the heading, without turns that are taken back
way      flights of jumps        over the ground; up, if the action says "high" or "up"
way      travelling              the length of the path over the ground
speed    travelling              the mean over its fastest second
steps    travelling, steps       how often one foot passes the other
=======  ======================  ================================================================

A number without a limit is met within a fifth of it, or within ``WITHIN``; limits are met exactly.
Answers carry no probabilities, since none was calibrated for measures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motiondb.body.features import FEATURE_FPS, FEATURE_STEP, runs
from motiondb.language.question.amounts import Measure
from motiondb.language.question.readings import Part
from motiondb.language.vocabulary import TRAVELS
from motiondb.meaning.degrees import Degree
from motiondb.meaning.occurrences import FLIGHTS
from motiondb.meaning.travelled import GOING, lasting_turns, means_of, steady_speed, turning, ways
from motiondb.records import FloatArray
from motiondb.search.placing import PartPlace, unsure
from motiondb.search.seen_frames import SeenFrames

WITHIN = {"angle": 15.0, "way": 0.15, "speed": 0.2, "steps": 0.0}  # Degrees, m, m/s
SHARE = 0.2  # Of a number, within which it is met
SMOOTHED = 11  # Feature frames (0.7 s) over which turning is averaged: hips sway with every step
TURNS_FROM, LEAST_TURN = 0.25, 20.0  # rad/s and degrees of one turn
_AHEAD = frozenset(("forward", "backward", "back", "sideways"))  # Ways that do not turn
PASSED = 0.08  # Metres by which one foot must be ahead of the other before it is passed again
_VERBS = {"angle": "turns by", "way": "goes", "speed": "goes at", "steps": "takes"}


def is_gauged(part: Part, actions: Sequence[Sequence[str]]) -> bool:
    """Whether the measure that a part names is measured of its action.

    >>> turn = Part((("turn", "left"),), measure=Measure("angle", 90, 90))
    >>> is_gauged(turn, turn.actions), is_gauged(turn, [("wave",)])
    (True, False)
    """
    if part.measure is None or len(actions) != 1:
        return False
    (action,) = actions
    travels, jumps = not TRAVELS.isdisjoint(action), not set(FLIGHTS).isdisjoint(action)
    return {
        "angle": bool(turning(action)) or travels,
        "way": travels or jumps,
        "speed": travels and not jumps,
        "steps": travels and not jumps,
    }[part.measure.what]


def gauge(
    seen: SeenFrames, measure: Measure, action: Sequence[str], place: PartPlace, room: slice
) -> tuple[PartPlace, list[str], list[str]]:
    """Where a part is as far or fast as asked, what speaks against it, and what was measured.

    `room`: The feature frames in which the part may be.
    """
    if seen.is_away:
        return unsure(place), [], []
    inside = [one for one in _gauged(seen, measure, action) if _meets(one, room)]
    if not inside:
        return unsure(place), [f"no {'turn' if measure.what == 'angle' else 'way'} is seen"], []

    def off(one: tuple[float, int, int]) -> tuple[float, bool, float]:
        here = one[1] < place.end / FEATURE_STEP and one[2] > place.start / FEATURE_STEP
        return max(outside(measure, one[0]), 0.0), not here, abs(one[0] - measure.least)

    amount, first, behind = min(inside, key=off)
    told = f"{_verb(measure, action)} {_say(measure.what, amount)}"
    if outside(measure, amount) > 0.0:
        return unsure(place), [f"{told}, not {measure.say()}"], []
    first, behind = max(first, room.start), min(behind, room.stop)
    moved = replace(place, start=FEATURE_STEP * first, end=FEATURE_STEP * behind, unknown=False)
    return unsure(moved), [], [told]


def outside(measure: Measure, amount: float) -> float:
    """How far an amount is outside what is asked for; 0 or less if it meets that.

    >>> quarter = Measure("angle", 90, 90)
    >>> outside(quarter, 75.0) <= 0.0, outside(quarter, 180.0) > 0.0
    (True, True)
    >>> outside(Measure("steps", 3, None), 2.0)
    1.0
    """
    if measure.least == measure.most:
        slack = 0.0 if measure.what == "steps" and measure.least < 1 / SHARE else SHARE
        allowed = max(slack * measure.least, WITHIN[measure.what])
        return abs(amount - measure.least) - allowed
    most = amount if measure.most is None else measure.most
    return max(measure.least - amount, amount - most)


def _say(what: str, amount: float) -> str:
    """An amount that was measured, in the unit in which a question names it."""
    if what == "angle":
        return f"{amount:.0f} degrees"
    if what == "steps":
        return f"{amount:.0f} steps"
    return f"{amount:.2f} m" if what == "way" else f"{amount:.1f} m/s"


def _verb(measure: Measure, action: Sequence[str]) -> str:
    return "jumps" if _is_jump(measure, action) else _VERBS[measure.what]


def _is_jump(measure: Measure, action: Sequence[str]) -> bool:
    return measure.what == "way" and not set(FLIGHTS).isdisjoint(action)


def _meets(one: tuple[float, int, int], room: slice) -> bool:
    """Whether the middle of a part is in the room."""
    return room.start <= (one[1] + one[2]) / 2 <= room.stop


def _gauged(
    seen: SeenFrames, measure: Measure, action: Sequence[str]
) -> list[tuple[float, int, int]]:
    """The amounts of every time in which an action goes on, with its feature frames [a, b)."""
    if measure.what == "angle":
        return _turned(seen.speeds, action)
    if _is_jump(measure, action):
        kind = "height" if {"high", "up"}.intersection(action) else "way"
        degree = Degree(kind, 1.0, frozenset())
        return [
            (degree.amount(seen.track, a, b), a // FEATURE_STEP, -(-b // FEATURE_STEP))
            for a, b in seen.events("jump")
        ]
    speed = np.hypot(seen.speeds[:, 0], seen.speeds[:, 1])
    goes = steady_speed(seen.speeds) > GOING
    for direction in _AHEAD.intersection(action):
        ways_there = np.max(ways(seen.speeds, direction), axis=0)
        goes &= _smooth(ways_there) > 0.0
    found = []
    for a, b in runs(np.asarray(goes)):
        if measure.what == "steps":
            track = seen.track[FEATURE_STEP * a : FEATURE_STEP * b]
            amount = float(count_steps(track[:, 18] - track[:, 19]))
        elif measure.what == "way":
            amount = float(speed[a:b].sum() / FEATURE_FPS)
        else:
            amount = float(means_of(speed[a:b], min(round(FEATURE_FPS), int(b - a))).max())
        found.append((amount, int(a), int(b)))
    return found


def count_steps(ahead: FloatArray) -> int:
    """How often one foot passes the other; `ahead` (frames,): the left one before the right, m.

    >>> count_steps(np.array([0.0, 0.3, 0.1, -0.3, -0.05, 0.02, -0.3, 0.3]))
    3
    """
    sides = np.sign(ahead[np.abs(ahead) > PASSED])
    return int(len(sides) > 0) + int((np.diff(sides) != 0).sum())


def _turned(speeds: FloatArray, action: Sequence[str]) -> list[tuple[float, int, int]]:
    """The turns of a motion to the side of an action, or to either one, with their angles."""
    turned = lasting_turns(speeds, FEATURE_FPS)
    rate = _smooth(turned * FEATURE_FPS)
    asked = {"left": (1.0,), "right": (-1.0,)}
    signs = next((asked[word] for word in action if word in asked), (1.0, -1.0))
    found = [
        (float(np.degrees(sign * turned[a:b].sum())), int(a), int(b))
        for sign in signs
        for a, b in runs(np.asarray(sign * rate > TURNS_FROM))
    ]
    return [one for one in found if one[0] >= LEAST_TURN]


def _smooth(values: FloatArray) -> FloatArray:
    """Values averaged over ``SMOOTHED`` frames around each: array (frames,)."""
    return means_of(np.pad(values, SMOOTHED // 2, mode="edge"), SMOOTHED)
