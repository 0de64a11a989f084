"""Words that are measured: whether a motion moves in a direction, turns, starts, stops or jumps.

In the frame of the heading (x left, y up, z ahead):

===============  ============================================  =====================
words            measured                                      full amount
===============  ============================================  =====================
up, down         lasting change of the height of the pelvis    0.15 m
left, right      turning to the left or right                  0.7 rad (40 degrees)
forward          way ahead                                     0.5 m
backward, back   way back                                      0.3 m
sideways         way to either side                            0.4 m
turn             turning to either side                        0.7 rad (40 degrees)
turn around      turning to either side                        2.5 rad (143 degrees)
spin, pirouette  turning to either side                        4.7 rad (270 degrees)
stop             loss of speed along the ground, up to MOVING  0.5 m/s
start            gain of speed along the ground, up to MOVING  0.5 m/s
jump             time during which the pelvis is aloft (RISE)  0.2 s
leap, jete       the same                                      0.2 s
hop, kick,       occurrences                                   1
punch            (:mod:`motiondb.generate.occurrences`)
===============  ============================================  =====================

A loss of speed from 3 to 2 m/s is no stop, because speeds above ``MOVING`` count as that. The
amounts are well above the sway of a standing person, and a running person's pelvis is not aloft.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from motiondb.generate.occurrences import LASTING, aloft, find_occurrences
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.records import MOTION_FPS, FloatArray

FULL = {
    "up": 0.15,
    "down": 0.15,
    "left": 0.7,
    "right": 0.7,
    "forward": 0.5,
    "backward": 0.3,
    "back": 0.3,
    "sideways": 0.4,
    "around": 2.5,
    "turn": 0.7,
    "spin": 4.7,
    "pirouette": 4.7,
    "stop": 0.5,
    "start": 0.5,
    "jump": 0.2,
    "leap": 0.2,
    "jete": 0.2,
    "hop": 1.0,
    "kick": 1.0,
    "punch": 1.0,
}
"""Word -> full amount, in the units of the table."""
VERTICAL = ("up", "down")
TURNS = ("turn", "spin", "pirouette")
ALOFT = ("jump", "leap", "jete")
OCCURRING = ("hop", "kick", "punch")
ACTIONS = (*TURNS, "stop", "start", *ALOFT, *OCCURRING)
"""Words that name actions; the others are directions of actions."""
ONCE = (*ACTIONS, *VERTICAL, "left", "right", "around")
"""Words whose movement is over when it is done, so that a part that shows it is not repeated to
make it longer."""
EITHER = ("sideways", "around", *TURNS)  # Words that are measured to either side
MOVING = 0.6  # Speed along the ground, m/s, from which on a person counts as moving
STEADY = 15  # Frames (0.5 s, about one step) over which the speed along the ground is averaged
NEARLY = 0.9  # Share of the largest distance that counts as nearly as far


def directions_of(words: Sequence[str]) -> tuple[str, ...]:
    """The measured words of an action, without sides that belong to a limb.

    A word that names an action is measured where the action has no direction; "around" is one of a
    turn alone. A kick with the left leg is not measured, because a kick is one of either leg.

    >>> directions_of(("sit", "down")), directions_of(("wave", "left", "hand"))
    (('down',), ())
    >>> directions_of(("turn",)), directions_of(("turn", "left"))
    (('turn',), ('left',))
    >>> directions_of(("turn", "around")), directions_of(("look", "around"))
    (('around',), ())
    """
    turns = any(word in TURNS for word in words)
    is_sided = bool(SIDES.intersection(words) and LIMBS.intersection(words))
    measured = [
        word
        for word, following in zip(words, [*words[1:], ""])
        if word in FULL
        and not (word in SIDES and following in LIMBS)
        and (turns or word != "around")
        and not (word in OCCURRING and is_sided)
    ]
    directions = [word for word in measured if word not in ACTIONS]
    return tuple(dict.fromkeys(directions or measured))


def say_not_gone(direction: str) -> str:
    """What a motion lacks that does not do what a measured word says.

    >>> say_not_gone("up"), say_not_gone("stop")
    ('it does not go up', 'it does not stop')
    """
    if direction in ACTIONS:
        return f"it does not {direction}"
    return f"it does not {'turn' if direction == 'around' else 'go'} {direction}"


def progress(path: FloatArray, direction: str) -> FloatArray:
    """Distance moved in a direction up to each frame, in full amounts: array (frames,).

    `path` (frames, 4 or more): the columns of ``measured_track``.

    >>> path = np.zeros((31, 4)); path[:, 2] = 0.5
    >>> [float(progress(path, word)[-1].round(3)) for word in ("forward", "backward")]
    [1.0, -1.667]
    """
    if direction in VERTICAL:
        height = median_filter(path[:, 0], size=LASTING, mode="nearest")
        way = height - height[0]
    elif direction in ("stop", "start"):
        speed = uniform_filter1d(np.hypot(path[:, 1], path[:, 2]), STEADY, mode="nearest")
        way = np.minimum(speed, MOVING)
    elif direction in ALOFT:
        way = np.cumsum(aloft(path[:, 0])) / MOTION_FPS
    elif direction in OCCURRING:
        share = np.zeros(len(path))
        for start, end in find_occurrences(path, direction):
            share[start:end] = 1.0 / (end - start)
        way = np.cumsum(share)
    else:
        column = {"left": 3, "right": 3, "sideways": 1}.get(direction, 2)
        column = 3 if direction in (*TURNS, "around") else column
        steps = path[:-1, column] / MOTION_FPS
        way = np.concatenate([[0.0], np.cumsum(steps)])
    if direction == "sideways":
        way = np.abs(way)
    sign = -1.0 if direction in ("down", "right", "backward", "back", "stop") else 1.0
    return np.asarray(sign * way / FULL[direction])


def gone(path: FloatArray, direction: str) -> float:
    """Distance that a motion moves in a direction, in full amounts; 1 or more is clear.

    What stops is at rest in the end, and what starts is at rest in the beginning; so these compare
    the last or first frame with the frame of most speed.
    """
    if not len(path):
        return 0.0
    way = progress(path, direction)
    if direction == "stop":
        return float(way[-1] - way.min())
    if direction == "start":
        return float(way.max() - way[0])
    if direction in (*TURNS, "around"):
        return float(way.max() - way.min())
    return float(way[-1])


def furthest_part(path: FloatArray, direction: str, longest: int) -> tuple[int, int]:
    """The shortest part, [first, behind), that travels nearly as far as any of ``longest`` frames.

    >>> path = np.zeros((120, 4)); path[:, 0] = [1.0] * 40 + [0.5] * 40 + [1.0] * 40
    >>> furthest_part(path, "up", 120)
    (79, 81)
    """
    way = progress(path, direction)
    spans = []
    for first in range(len(way)):
        gain = way[first : first + longest] - way[first]
        gain = np.abs(gain) if direction in EITHER else gain
        far = float(gain.max())
        spans.append((far, first, first + int(np.argmax(gain >= NEARLY * far)) + 1))
    best = max(far for far, _, _ in spans)
    good = [(behind - first, first) for far, first, behind in spans if far >= NEARLY * best]
    length, first = min(good)
    return first, first + length
