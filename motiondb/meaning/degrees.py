"""How fast, how high or how far: what "the fastest run" or "a long jump" asks for is measured.

=======  =============================================  ===================================
measure  of                                             words
=======  =============================================  ===================================
speed    travelling (``TRAVELS``), not of jumps: the    fast, quick, rapid, brisk; slow
         mean over its fastest second, m/s
height   jumps: the rise of the pelvis in a flight, m   high; low
way      jumps: the way over the ground in a flight, m  far, long, broad; short
time     travelling: how long the interval lasts, s     long; short
step     "steps", "strides": the way over the ground    long; short, tiny
         from one step to the next, in the mean, m
=======  =============================================  ===================================

These words have no bounds: they order the motions that show the action.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.language.question.amounts import SPEEDS
from motiondb.language.vocabulary import TRAVELS
from motiondb.meaning.occurrences import FLIGHTS, find_occurrences
from motiondb.meaning.travelled import STEADY, means_of
from motiondb.records import MOTION_FPS, FloatArray

_SLOW, _FAST = SPEEDS
_JUMPS = frozenset(FLIGHTS)
_OF_TRAVEL = dict.fromkeys(_FAST, ("speed", 1.0)) | dict.fromkeys(_SLOW, ("speed", -1.0))
_OF_TRAVEL |= {"long": ("time", 1.0), "short": ("time", -1.0)}
_OF_JUMPS = {
    "high": ("height", 1.0),
    "low": ("height", -1.0),
    "far": ("way", 1.0),
    "long": ("way", 1.0),
    "broad": ("way", 1.0),
    "short": ("way", -1.0),
}
_OF_STEPS = {"long": ("step", 1.0), "short": ("step", -1.0), "tiny": ("step", -1.0)}
_STEPS = frozenset(("step", "stride"))
_LASTING = frozenset(("long", "short"))
_UNITS = {
    **{"time": "s", "speed": "m/s", "height": "m up"},
    **{"way": "m along the ground", "step": "m a step"},
}
PASSED = 0.08  # Metres by which one foot must be ahead of the other before it is passed again


@dataclass(frozen=True)
class Degree:
    """What of a motion a word of degree names, and whether more or less of it."""

    measure: str  # "speed", "time", "height", "way" or "step"
    sign: float  # 1: the more the better; -1: the less
    words: frozenset[str]  # The words that name it

    def amount(self, track: FloatArray, first: int, behind: int) -> float:
        """How much a part [first, behind) of a motion has of it; NaN if nothing can be measured.

        `track` (frames, columns): those of ``measured_track``.

        >>> track = np.zeros((90, 6)); track[:, 2] = 2.0
        >>> Degree("speed", 1.0, frozenset()).amount(track, 0, 90)
        2.0
        """
        if self.measure == "time":
            return (behind - first) / MOTION_FPS
        if self.measure == "speed":
            inside = np.hypot(*track[first:behind, 1:3].T)
            if not len(inside):
                return float("nan")
            size = min(round(STEADY * MOTION_FPS), len(inside))
            return float(means_of(inside, size).max())
        if self.measure == "step":
            steps = count_steps(track[first:behind])
            way = np.hypot(*track[first:behind, 1:3].T).sum() / MOTION_FPS
            return float(way / steps) if steps > 1 else float("nan")
        flights = [f for f in find_occurrences(track, "jump") if f[0] < behind and f[1] > first]
        if self.measure == "height":
            found = [track[a:b, 0].max() - track[max(a - 1, 0), 0] for a, b in flights]
        else:
            found = [np.hypot(*track[a:b, 1:3].T).sum() / MOTION_FPS for a, b in flights]
        return float(max(found, default=float("nan")))

    def say(self, amount: float) -> str:
        """What was measured, in plain words.

        >>> Degree("speed", 1.0, frozenset()).say(4.316)
        '4.3 m/s'
        """
        digits = 1 if self.measure in ("speed", "time") else 2
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
    >>> degree_of(("wave", "slow")), degree_of(("kick", "high"))
    (None, None)
    >>> degree_of(("run", "long")).measure, degree_of(("walk", "long", "stride")).measure
    ('time', 'step')
    """
    jumps, steps = not _JUMPS.isdisjoint(words), not _STEPS.isdisjoint(words)
    by_speed = not {*_FAST, *_SLOW}.isdisjoint(words)  # by which "a fast walk with long steps" goes
    travel = _OF_TRAVEL | _OF_STEPS if steps and not by_speed else _OF_TRAVEL
    table = _OF_JUMPS if jumps else {} if TRAVELS.isdisjoint(words) else travel
    named = {word for word in words if word in table}
    if not jumps and ((steps and by_speed) or not {*words} - named <= TRAVELS):
        named -= _LASTING  # a long walk, but no long wave
    found = {table[word] for word in named}
    if len(found) != 1:
        return None
    ((measure, sign),) = found
    if measure == "step" and not TRAVELS.isdisjoint({*words} - _STEPS):
        named |= _STEPS.intersection(words)  # "walk with long steps" is looked for as a walk
    return Degree(measure, sign, frozenset(named))
