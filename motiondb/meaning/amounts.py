"""How far, fast, high or by which angle a motion goes, in numbers and in words of degree.

Numbers are those of "turn left by 90 degrees" and "walk 3 steps".

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

Words of degree order the motions that show an action: "the fastest run", "a long jump".

=======  =============================================  ===================================
measure  of                                             words
=======  =============================================  ===================================
hand     punches: the speed of a hand relative to the   fast, quick, rapid, brisk; slow
         pelvis, m/s
foot     kicks: the same of an ankle, m/s               fast, quick, rapid, brisk; slow
raised   kicks: the height of a foot over standing, m   high; low
turning  turns and spins: the turning of the body,      fast, quick, rapid, brisk; slow
         degrees/s
depth    squats, crouches, ducks: how much the pelvis   deep, low; shallow
         is lower than in standing, m
leaning  bows and bends: the angle of the trunk from    deep, low; shallow
         upright, degrees
speed    travelling (``TRAVELS``), not of jumps: the    fast, quick, rapid, brisk; slow
         mean over its fastest second, m/s
height   jumps: the rise of the pelvis in a flight, m   high; low
way      jumps: the way over the ground in a flight, m  far, long, broad; short
limbs    any other action: the speed of hands and feet  fast, quick, rapid, brisk; slow
         relative to the pelvis, the mean over all, m/s
time     travelling: how long the interval lasts, s     long; short
step     "steps", "strides": the way over the ground    long; short, tiny
         from one step to the next, in the mean, m
count    events: how often in the whole take            most often; least often
=======  =============================================  ===================================

These words have no bounds: they order the motions that show the action. The speeds of hands and
feet and of turning are means over the fastest half second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.body.features import runs
from motiondb.language.question import amounts
from motiondb.language.question.amounts import Measure
from motiondb.language.question.readings import say_count
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import LEAST_OFTEN, MODIFIERS, MOST_OFTEN, TRAVELS
from motiondb.meaning.limb_sides import PUNCHES
from motiondb.meaning.occurrences import BEGINNING, FLIGHTS, event_of, find_occurrences
from motiondb.meaning.postures import LEANS, LOW, STANDING
from motiondb.meaning.travelled import (
    GOING,
    STEADY,
    TURNS,
    lasting_turns,
    means_of,
    steady_speed,
    turning,
    ways,
)
from motiondb.records import MOTION_FPS, FloatArray

SPEEDS = ("speed", "hand", "foot", "turning", "limbs")  # Measures of how fast
_SLOW, _FAST = amounts.SPEEDS
_HALF_SECOND = round(0.5 * MOTION_FPS)


def _speeds_as(measure: str) -> dict[str, tuple[str, float]]:
    """The words of speed, with a measure that they name."""
    return dict.fromkeys(_FAST, (measure, 1.0)) | dict.fromkeys(_SLOW, (measure, -1.0))


_JUMPS = frozenset(FLIGHTS)
_OF_TRAVEL = _speeds_as("speed") | {"long": ("time", 1.0), "short": ("time", -1.0)}
_OF_JUMPS = {
    "high": ("height", 1.0),
    "low": ("height", -1.0),
    "far": ("way", 1.0),
    "long": ("way", 1.0),
    "broad": ("way", 1.0),
    "short": ("way", -1.0),
}
_OF_KICKS = _speeds_as("foot") | {"high": ("raised", 1.0), "low": ("raised", -1.0)}
_DEPTHS = {"deep": 1.0, "low": 1.0, "shallow": -1.0}
_OF_OTHERS: tuple[tuple[frozenset[str], dict[str, tuple[str, float]]], ...] = (
    (frozenset(["kick"]), _OF_KICKS),
    (PUNCHES, _speeds_as("hand")),
    (TURNS, _speeds_as("turning")),
    (frozenset(LOW), _speeds_as("limbs") | {w: ("depth", sign) for w, sign in _DEPTHS.items()}),
    (frozenset(LEANS), _speeds_as("limbs") | {w: ("leaning", sign) for w, sign in _DEPTHS.items()}),
)
"""Words of actions that neither travel nor fly, and those of their degrees."""
_OF_COUNTS = {MOST_OFTEN: ("count", 1.0), LEAST_OFTEN: ("count", -1.0)}
_OF_STEPS = {"long": ("step", 1.0), "short": ("step", -1.0), "tiny": ("step", -1.0)}
_STEPS = frozenset(("step", "stride"))
_TRAVELS = TRAVELS | {"gait", "locomotion"}
_LASTING = frozenset(("long", "short"))
_UNITS = {
    **{"time": "s", "speed": "m/s", "height": "m up"},
    **{"way": "m along the ground", "step": "m a step", "hand": "m/s of a hand"},
    "limbs": "m/s of hands and feet",
    **{"foot": "m/s of a foot", "raised": "m up of a foot", "turning": "degrees/s"},
    **{"depth": "m lower", "leaning": "degrees of leaning"},
}
_DIGITS = {"speed": 1, "time": 1, "turning": 0, "leaning": 0}
_COLUMNS = {"hand": [7, 9], "foot": [10, 11], "turning": [3]}
"""Columns of the track whose means over half a second are compared."""
PASSED = 0.08  # Metres by which one foot must be ahead of the other before it is passed again


@dataclass(frozen=True)
class Degree:
    """What of a motion a word of degree names, and whether more or less of it."""

    measure: str  # As in the module's table
    sign: float  # 1: the more the better; -1: the less
    words: frozenset[str]  # The words that name it
    event: str = "jump"  # What is looked at, as ``find_occurrences`` takes it, unless one travels

    def amount(self, track: FloatArray, first: int, behind: int) -> float:
        """How much a part [first, behind) of a motion has of it; NaN if nothing can be measured.

        `track` (frames, columns): those of ``measured_track``.

        >>> track = np.zeros((90, 6)); track[:, 2] = 2.0
        >>> Degree("speed", 1.0, frozenset()).amount(track, 0, 90)
        2.0
        """
        if self.measure == "time":
            return (behind - first) / MOTION_FPS
        if first == behind:
            return float("nan")
        inside = track[first:behind]
        if self.measure == "speed":
            speed = np.hypot(*inside[:, 1:3].T)
            return float(means_of(speed, min(round(STEADY * MOTION_FPS), len(speed))).max())
        if self.measure == "step":
            steps = count_steps(inside)
            way = np.hypot(*inside[:, 1:3].T).sum() / MOTION_FPS
            return float(way / steps) if steps > 1 else float("nan")
        if self.measure == "limbs":
            return float(inside[:, [7, 9, 10, 11]].mean())
        if self.measure == "count":
            return float(len(find_occurrences(track, self.event)) or "nan")
        times = [t for t in find_occurrences(track, self.event) if t[0] < behind and t[1] > first]
        return max((self._of_event(track, *time) for time in times), default=float("nan"))

    def _of_event(self, track: FloatArray, first: int, behind: int) -> float:
        """How much the event [first, behind) of a motion has of it."""
        inside = track[first:behind]
        if self.measure in _COLUMNS:  # a hand is quickest before it is out
            columns = track[max(first - BEGINNING, 0) : behind, _COLUMNS[self.measure]]
            size = min(_HALF_SECOND, len(columns))
            amount = max(float(np.abs(means_of(column, size)).max()) for column in columns.T)
            return math.degrees(amount) if self.measure == "turning" else amount
        if self.measure == "depth":
            return float(STANDING - inside[:, 0].min())
        if self.measure in ("raised", "leaning"):
            amount = float(inside[:, [4, 5] if self.measure == "raised" else [14]].max())
            return math.degrees(amount) if self.measure == "leaning" else amount
        if self.measure == "height":
            return float(inside[:, 0].max() - track[max(first - 1, 0), 0])
        return float(np.hypot(*inside[:, 1:3].T).sum() / MOTION_FPS)

    def say(self, amount: float) -> str:
        """What was measured, in plain words.

        >>> Degree("speed", 1.0, frozenset()).say(4.316), Degree("count", 1.0, frozenset()).say(1.0)
        ('4.3 m/s', 'once')
        """
        if self.measure == "count":
            return say_count(int(amount), int(amount))
        digits = _DIGITS.get(self.measure, 2)
        return f"{amount:.{digits}f} {_UNITS[self.measure]}"


def count_steps(track: FloatArray) -> int:
    """How often one foot passes the other; `track` (frames, columns).

    >>> track = np.zeros((8, 20)); track[:, 18] = [0.0, 0.3, 0.1, -0.3, -0.05, 0.02, -0.3, 0.3]
    >>> count_steps(track)
    3
    """
    ahead = track[:, 18] - track[:, 19]  # the left foot before the right one
    sides = np.sign(ahead[np.abs(ahead) > PASSED])
    return int(len(sides) > 0) + int((np.diff(sides) != 0).sum())


def is_of_degree(word: str) -> bool:
    """Whether a word says how fast, high, far or long something is."""
    ways = (_OF_TRAVEL, _OF_JUMPS, _OF_KICKS, _DEPTHS, _OF_STEPS, _OF_COUNTS)
    return any(word in way for way in ways)


def degree_of(words: Sequence[str]) -> Degree | None:
    """The degree that an action names; None if it names none, or several.

    >>> degree_of(("run", "fast")).sign, degree_of(("jump", "far")).measure
    (1.0, 'way')
    >>> degree_of(("punch", "slow")).measure, degree_of(("kick", "high")).event
    ('hand', 'kick')
    >>> degree_of(("wave", "slow")).measure, degree_of(("turn", "deep"))
    ('limbs', None)
    >>> degree_of(("fast", "spin", "kick")).event, degree_of(("squat", "slow")).measure
    ('kick', 'limbs')
    >>> degree_of(("run", "long")).measure, degree_of(("walk", "long", "stride")).measure
    ('time', 'step')
    >>> degree_of(("kick", MOST_OFTEN)).measure, degree_of(("wave", MOST_OFTEN))
    ('count', None)
    >>> degree_of(("kick", "left", "foot", MOST_OFTEN))
    """
    jumps, steps = not _JUMPS.isdisjoint(words), not _STEPS.isdisjoint(words)
    by_speed = not {*_FAST, *_SLOW}.isdisjoint(words)  # by which "a fast walk with long steps" goes
    travel = _OF_TRAVEL | _OF_STEPS if steps and not by_speed else _OF_TRAVEL
    others = [(actions, table) for actions, table in _OF_OTHERS if not actions.isdisjoint(words)]
    travels = not _TRAVELS.isdisjoint(words)
    acts = not {*words} - MODIFIERS - {*_FAST, *_SLOW} <= _STEPS
    of, table = others[0] if others else (frozenset(words), _speeds_as("limbs") if acts else {})
    table = travel if travels else table
    table = _OF_JUMPS if jumps else table
    is_sided = not (SIDES | LIMBS | _AHEAD).isdisjoint(words)  # of which no number was measured
    counted = "" if is_sided else event_of([word for word in words if word not in _OF_COUNTS])
    table = table | (_OF_COUNTS if counted else {})
    named = {word for word in words if word in table}
    if not jumps and ((steps and by_speed) or not {*words} - named <= TRAVELS):
        named -= _LASTING  # a long walk, but no long wave
    found = {table[word] for word in named}
    if len(found) != 1:
        return None
    ((measure, sign),) = found
    if measure == "step" and not TRAVELS.isdisjoint({*words} - _STEPS):
        named |= _STEPS.intersection(words)  # "walk with long steps" is looked for as a walk
    event = "punch" if measure == "hand" else event_of([word for word in words if word in of])
    event = counted if measure == "count" else "jump" if jumps else event
    return Degree(measure, sign, frozenset(named), event)


def usual_degree(action: Sequence[str]) -> Degree | None:
    """The degree by which a jump, kick, bow or squat is clear: its height or depth; None of others.

    >>> usual_degree(("jump", "left")).measure, usual_degree(("squat",)).measure
    ('height', 'depth')
    >>> usual_degree(("cartwheel",))
    """
    found = (degree_of((*action, word)) for word in ("high", "deep"))
    return next((replace(one, words=frozenset()) for one in found if one), None)


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
