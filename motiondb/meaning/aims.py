"""Where a kick, a punch or a leaning trunk goes: to a side, forward, back, up or down.

It is the direction of the body, not of the room: of a foot from the pelvis where it is highest, of
a hand from its shoulder where it is farthest, and of the trunk from upright in the mean of a place.
A direction counts if no other one is clearly larger (``SHARE``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.body import body, rotation
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.records import FloatArray

FIRST_COLUMN = 29
"""Of :func:`reaches` in ``measured_track``, whose columns 18 and 19 are the ankles ahead, and 22
and 23 the wrists above the shoulders."""
SHARE = 0.7  # Of the largest other direction: 35 degrees from it
LEANT = 0.15  # Sine of the angle by which a trunk leans at least
_LEANS = frozenset(("lean", "bend", "tilt"))
_OF = {"kick": "kick", "punch": "punch", **dict.fromkeys(_LEANS, "lean")}
_AIMS = {"back": "backward", "side": "sideways", "straight": "forward"} | {
    aim: aim for aim in ("left", "right", "sideways", "forward", "backward", "up", "down")
}
_MEASURED = {
    "kick": frozenset(("left", "right", "sideways", "forward", "backward")),
    "punch": frozenset(_AIMS.values()),
    "lean": frozenset(("left", "right", "sideways", "forward", "backward")),
}
_I = body.INDEX
_SHOULDERS, _WRISTS, _ANKLES = (
    [_I[f"{side}_{joint}"] for side in "lr"] for joint in ("shoulder", "wrist", "ankle")
)


def aims_of(action: Sequence[str]) -> tuple[str, ...]:
    """The words of an action that say where its kick, punch or trunk goes.

    >>> aims_of(("kick", "left")), aims_of(("side", "kick", "right", "leg"))
    (('left',), ('side',))
    >>> aims_of(("punch", "up", "left", "hand")), aims_of(("kick", "left", "foot"))
    (('up',), ())
    >>> aims_of(("lean", "left", "forward")), aims_of(("walk", "left"))
    (('left', 'forward'), ())
    """
    of = next((_OF[word] for word in action if word in _OF), "")
    found = list[str]()
    for n, word in enumerate(action):
        is_limb = word in SIDES and n + 1 < len(action) and action[n + 1] in LIMBS
        if of and not is_limb and _AIMS.get(word) in _MEASURED[of]:
            found.append(word)
    return tuple(found)


def reaches(positions: FloatArray, facing: FloatArray) -> FloatArray:
    """Where trunk, feet and hands go from the body: array (frames, 8).

    To the left and ahead: the trunk from upright, sines; the left and the right ankle from the
    pelvis, of which only the left; the left and the right wrist from the shoulder, m. `positions`
    (frames, 21, 3), metres; `facing` (frames,): angle of the body about the vertical, rad.
    """
    sine, cosine = np.sin(facing)[:, None], np.cos(facing)[:, None]

    def turned(ways: FloatArray) -> FloatArray:
        left = ways[..., 0] * cosine - ways[..., 2] * sine
        ahead = ways[..., 0] * sine + ways[..., 2] * cosine
        return np.stack([left, ahead], axis=-1)

    trunk = rotation.normalize(positions[:, _I["neck"]] - positions[:, 0])[:, None]
    ankles = turned(positions[:, _ANKLES] - positions[:, :1])[..., 0]
    wrists = turned(positions[:, _WRISTS] - positions[:, _SHOULDERS])
    return np.column_stack([turned(trunk)[:, 0], ankles, wrists[:, 0], wrists[:, 1]])


def goes_there(track: FloatArray, action: Sequence[str], first: int, behind: int) -> bool:
    """Whether the kick, punch or trunk in frames [first, behind) goes where an action says.

    `track` (frames, columns): those of ``measured_track``.

    >>> track = np.zeros((10, 37)); track[:, 4], track[:, 31], track[:, 18] = 0.8, 0.6, 0.2
    >>> [goes_there(track, ("kick", aim), 0, 10) for aim in ("left", "right", "side", "forward")]
    [True, False, True, False]
    """
    of = next(_OF[word] for word in action if word in _OF)
    left, ahead, up = _way(track[first:behind], of)
    amounts = {"left": left, "right": -left, "sideways": abs(left), "forward": ahead}
    amounts |= {"backward": -ahead, "up": up, "down": -up}
    largest = max(abs(left), abs(ahead), abs(up))
    asked = [amounts[_AIMS[word]] for word in aims_of(action)]
    least = SHARE * largest if len(asked) < 2 else 0.3 * largest  # "left and forward"
    return all(amount > max(least, 0.0) for amount in asked)


def _way(inside: FloatArray, of: str) -> tuple[float, float, float]:
    """How far something goes to the left, ahead and up in some frames (frames, columns)."""
    more = inside[:, FIRST_COLUMN:]
    if of == "lean":
        left, ahead = more[:, :2].mean(axis=0)
        return (
            (float(left), float(ahead), 0.0) if np.hypot(left, ahead) > LEANT else (0.0, 0.0, 0.0)
        )
    if of == "kick":
        frame, foot = np.unravel_index(np.argmax(inside[:, 4:6]), (len(inside), 2))
        return float(more[frame, 2 + foot]), float(inside[frame, 18 + foot]), 0.0
    hands = np.stack([more[:, 4:6], more[:, 6:8]], axis=1)
    lengths = np.hypot(np.linalg.norm(hands, axis=2), inside[:, 22:24])
    frame, hand = np.unravel_index(np.argmax(lengths), lengths.shape)
    left, ahead = hands[frame, hand]
    return float(left), float(ahead), float(inside[frame, 22 + hand])
