"""How fast, how high or how far: what "the fastest run" or "a long jump" asks for is measured.

=======  =============================================  ===================================
measure  of                                             words
=======  =============================================  ===================================
hand     punches: the speed of a hand relative to    fast, quick, rapid, brisk; slow
         the pelvis, m/s
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
=======  =============================================  ===================================

These words have no bounds: they order the motions that show the action. The speeds of hands and
feet and of turning are means over the fastest half second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.language.question import amounts
from motiondb.language.vocabulary import MODIFIERS, TRAVELS
from motiondb.meaning.limb_sides import PUNCHES
from motiondb.meaning.occurrences import (
    BEGINNING,
    FLIGHTS,
    LEANS,
    LOW,
    STANDING,
    event_of,
    find_occurrences,
)
from motiondb.meaning.travelled import STEADY, TURNS, means_of
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
    (frozenset(LOW), {word: ("depth", sign) for word, sign in _DEPTHS.items()}),
    (frozenset(LEANS), {word: ("leaning", sign) for word, sign in _DEPTHS.items()}),
)
"""Words of actions that neither travel nor fly, and those of their degrees."""
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
            steps = count_steps(track[first:behind])
            way = np.hypot(*track[first:behind, 1:3].T).sum() / MOTION_FPS
            return float(way / steps) if steps > 1 else float("nan")
        if self.measure == "limbs":
            return float(inside[:, [7, 9, 10, 11]].mean())
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

        >>> Degree("speed", 1.0, frozenset()).say(4.316)
        '4.3 m/s'
        """
        digits = {"speed": 1, "time": 1, "turning": 0, "leaning": 0}.get(self.measure, 2)
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


def degree_of(words: Sequence[str]) -> Degree | None:
    """The degree that an action names; None if it names none, or several.

    >>> degree_of(("run", "fast")).sign, degree_of(("jump", "far")).measure
    (1.0, 'way')
    >>> degree_of(("punch", "slow")).measure, degree_of(("kick", "high")).event
    ('hand', 'kick')
    >>> degree_of(("wave", "slow")).measure, degree_of(("turn", "deep"))
    ('limbs', None)
    >>> degree_of(("run", "long")).measure, degree_of(("walk", "long", "stride")).measure
    ('time', 'step')
    """
    jumps, steps = not _JUMPS.isdisjoint(words), not _STEPS.isdisjoint(words)
    by_speed = not {*_FAST, *_SLOW}.isdisjoint(words)  # by which "a fast walk with long steps" goes
    travel = _OF_TRAVEL | _OF_STEPS if steps and not by_speed else _OF_TRAVEL
    others = [table for actions, table in _OF_OTHERS if not actions.isdisjoint(words)]
    travels = not _TRAVELS.isdisjoint(words)
    acts = not {*words} - MODIFIERS - {*_FAST, *_SLOW} <= {"step", "stride"}
    others = others or [_speeds_as("limbs") if acts else {}]
    table = travel if travels else others[0]
    table = _OF_JUMPS if jumps else table
    named = {word for word in words if word in table}
    if not jumps and ((steps and by_speed) or not {*words} - named <= TRAVELS):
        named -= _LASTING  # a long walk, but no long wave
    found = {table[word] for word in named}
    if len(found) != 1:
        return None
    ((measure, sign),) = found
    if measure == "step" and not TRAVELS.isdisjoint({*words} - _STEPS):
        named |= _STEPS.intersection(words)  # "walk with long steps" is looked for as a walk
    event = {"hand": "punch"}.get(measure) or event_of([w for w in words if w not in named])
    return Degree(measure, sign, frozenset(named), "jump" if jumps else event)
