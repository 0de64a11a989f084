"""Words of direction as travel: whether a motion moves in the direction of a word.

In the frame of the heading (x left, y up, z ahead):

==============  ==============================================  ==================
words           measured                                        full amount
==============  ==============================================  ==================
up, down        lasting change of the height of the pelvis      0.15 m
left, right     turning to the left or right                    0.7 rad (40 degrees)
forward         distance ahead                                  0.5 m
backward, back  distance back                                   0.3 m
sideways        distance to either side                         0.4 m
==============  ==============================================  ==================

The amounts were chosen by hand; they are well above the sway of a standing person.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter

from motiondb.records import MOTION_FPS, FloatArray
from motiondb.words.question.tree import LIMBS, SIDES

FULL = {
    "up": 0.15, "down": 0.15, "left": 0.7, "right": 0.7, "forward": 0.5, "backward": 0.3,
    "back": 0.3, "sideways": 0.4,
}  # fmt: skip
"""Word -> full amount, in the units of the table."""
VERTICAL = ("up", "down")
NEARLY = 0.9
"""Share of the largest distance that counts as nearly as far. Chosen by hand."""
LASTING = 31
"""Frames (1 s) over which the median of the height is taken, so that a jump does not count as
moving up. Chosen by hand."""


def directions_of(words: Sequence[str]) -> tuple[str, ...]:
    """The words of direction of an action, without sides that belong to a limb.

    >>> directions_of(("sit", "down")), directions_of(("wave", "left", "hand"))
    (('down',), ())
    """
    directions = [
        word
        for word, following in zip(words, [*words[1:], ""])
        if word in FULL and not (word in SIDES and following in LIMBS)
    ]
    return tuple(dict.fromkeys(directions))


def progress(path: FloatArray, direction: str) -> FloatArray:
    """Distance moved in a direction up to each frame, in full amounts: array (frames,).

    Parameters
    ----------
    path : array (frames, 4)
        Height (m), speed to the left and ahead (m/s), turning (rad/s), as in
        ``pose.pose_vectors``.
    direction : str
        One of :data:`FULL`.

    >>> path = np.zeros((31, 4)); path[:, 2] = 0.5
    >>> [float(progress(path, word)[-1].round(3)) for word in ("forward", "backward")]
    [1.0, -1.667]
    """
    if direction in VERTICAL:
        height = median_filter(path[:, 0], size=LASTING, mode="nearest")
        way = height - height[0]
    else:
        column = {"left": 3, "right": 3, "sideways": 1}.get(direction, 2)
        steps = path[:-1, column] / MOTION_FPS
        way = np.concatenate([[0.0], np.cumsum(steps)])
    if direction == "sideways":
        way = np.abs(way)
    sign = -1.0 if direction in ("down", "right", "backward", "back") else 1.0
    return np.asarray(sign * way / FULL[direction])


def gone(path: FloatArray, direction: str) -> float:
    """Distance that a motion moves in a direction, in full amounts; 1 or more is clear.

    Parameters
    ----------
    path : array (frames, 4)
        As for :func:`progress`.
    direction : str
        One of :data:`FULL`.
    """
    return float(progress(path, direction)[-1]) if len(path) else 0.0


def furthest_part(path: FloatArray, direction: str, longest: int) -> tuple[int, int]:
    """Return the shortest part that travels nearly as far as any part of ``longest`` frames.

    Its first frame and last frame + 1.

    Parameters
    ----------
    path : array (frames, 4)
        As for :func:`progress`.
    direction : str
        One of :data:`FULL`.
    longest : int
        Most frames, at least 1.

    >>> path = np.zeros((120, 4)); path[:, 0] = [1.0] * 40 + [0.5] * 40 + [1.0] * 40
    >>> furthest_part(path, "up", 120)
    (79, 81)
    """
    way = progress(path, direction)
    spans = []
    for first in range(len(way)):
        gain = way[first : first + longest] - way[first]
        gain = np.abs(gain) if direction == "sideways" else gain
        far = float(gain.max())
        spans.append((far, first, first + int(np.argmax(gain >= NEARLY * far)) + 1))
    best = max(far for far, _, _ in spans)
    good = [(behind - first, first) for far, first, behind in spans if far >= NEARLY * best]
    length, first = min(good)
    return first, first + length
