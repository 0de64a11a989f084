"""Whether a capture travels or turns in the direction that a question names.

Captions rarely say "forward", and never that a person does not walk backward. So the direction of
an action that travels ("walk backward", "jump to the left") or turns ("turn right") is measured in
the frame of the heading, which the recognition features hold:

===============  =============================================  ==========================
word             measured                                       at least
===============  =============================================  ==========================
forward          way ahead                                      0.25 m
backward, back   way back                                       0.15 m
sideways         way to either side                             0.2 m
left, right      turning to that side, or, if the action does   0.35 rad (20 degrees)
                 not name a turn, way to that side              0.2 m
around           turning to either side                         2.1 rad (120 degrees)
===============  =============================================  ==========================

Way along an axis counts in frames in which the person moves faster along it than across it, so that
the sway of a person who walks ahead is no way to a side. The amounts are those that some part of
the frames covers; except for "around", they are half of what :mod:`motiondb.generate.direction`
asks for, because a question is answered "not" where the motion clearly goes elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.body.features import FEATURE_FPS, ROOT_WEIGHT, VELOCITY_SECONDS
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.records import Float32Array, FloatArray

LEAST = {
    "forward": 0.25,
    "backward": 0.15,
    "back": 0.15,
    "sideways": 0.2,
    "left": 0.35,
    "right": 0.35,
    "around": 2.1,
}
"""Direction -> least amount, in the units of the table."""
TURNS = frozenset(
    ("turn", "spin", "rotate", "pivot", "pirouette", "twirl", "whirl")
)  # Words for turning
_TRAVELS_TEXT = """
walk run jog sprint dash step stride stroll march sneak tiptoe limp stagger stumble shuffle wander
pace trot gallop skip hop jump leap crawl creep move go travel slide dribble sidestep amble saunter
mosey hike stalk
"""
TRAVELS = frozenset(_TRAVELS_TEXT.split())
"""Words for travelling over the ground. Other actions have directions that are not travelled: a
person can lean back, reach forward and look left in place."""
STEADY = 15  # Feature frames (1 s) over which speeds are averaged before they are compared


def directions_to_measure(words: Sequence[str]) -> tuple[str, ...]:
    """The measured directions of an action, without sides that belong to a limb.

    >>> directions_to_measure(("walk", "backward")), directions_to_measure(("lean", "back"))
    (('backward',), ())
    >>> directions_to_measure(("step", "left", "foot")), directions_to_measure(("walk", "around"))
    ((), ())
    """
    turns, travels = not TURNS.isdisjoint(words), not TRAVELS.isdisjoint(words)
    return tuple(
        dict.fromkeys(
            word
            for word, following in zip(words, [*words[1:], ""])
            if word in LEAST
            and (turns if word == "around" else travels or (turns and word in SIDES))
            and not (word in SIDES and following in LIMBS)
        )
    )


def speeds_of(features: Float32Array) -> FloatArray:
    """Speed to the left and ahead (m/s) and turning to the left (rad/s): array (frames, 3).

    `features` (frames, 130): recognition features, 15 frames a second.
    """
    root = features[:, -4:].astype(np.float64) / (ROOT_WEIGHT * VELOCITY_SECONDS)
    return np.asarray(root[:, [0, 2, 3]])


def furthest(speeds: FloatArray, direction: str, turns: bool = False) -> tuple[float, int, int]:
    """How far some frames go in a direction, in least amounts, and the part [a, b) that does.

    `speeds` (frames, 3): those of ``speeds_of``. `turns`: Whether the action names a turn.

    >>> speeds = np.zeros((60, 3)); speeds[:30, 1], speeds[30:, 1] = 1.0, -0.45  # ahead, then back
    >>> furthest(speeds, "left")
    (0.0, 0, 0)
    >>> [round(number) for number in furthest(speeds, "backward")]
    [6, 30, 60]
    """
    aside, ahead = _along(speeds, 0), _along(speeds, 1)
    if direction in ("forward", "backward", "back"):
        return _largest(ahead / LEAST[direction], 1 if direction == "forward" else -1)
    if direction == "sideways":
        return _largest(aside / LEAST[direction], 1, -1)
    turning = speeds[:, 2] / LEAST[direction]
    if direction == "around":
        return _largest(turning, 1, -1)
    sign = 1 if direction == "left" else -1
    turned = _largest(turning, sign)
    return turned if turns else max(turned, _largest(aside / LEAST["sideways"], sign))


def _along(speeds: FloatArray, axis: int) -> FloatArray:
    """Speed along an axis (0: left, 1: ahead), 0 where it is slower than across: (frames,)."""
    from scipy.ndimage import uniform_filter1d  # a quarter of a second; other questions do without

    steady = np.abs(uniform_filter1d(speeds[:, :2], STEADY, axis=0, mode="nearest"))
    return np.where(steady[:, axis] > steady[:, 1 - axis], speeds[:, axis], 0.0)


def _largest(rates: FloatArray, *signs: int) -> tuple[float, int, int]:
    """The largest sum over a part of rates a second, of some signs, and the part [a, b)."""
    return max(_largest_part(sign * rates / FEATURE_FPS) for sign in signs)


def _largest_part(steps: FloatArray) -> tuple[float, int, int]:
    """The largest sum over a part of steps, and the part [a, b); zeros if no step is positive."""
    way = np.concatenate([[0.0], np.cumsum(steps)])
    gain = way - np.minimum.accumulate(way)
    behind = int(np.argmax(gain))
    # the last of equal minima, so that standing before the way does not belong to it
    first = behind - int(np.argmin(way[behind::-1]))
    return float(gain[behind]), first, behind
