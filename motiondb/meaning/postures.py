"""Postures that a motion takes: raised hands, a hand at the hip, kneeling, lying, one leg, low.

==================  =============================================================================
words               a time in which it is held
==================  =============================================================================
sit                 a time of at least 1 s in which both thighs are level and the trunk upright
raise               a time of at least 0.3 s in which a hand is as high as its shoulder, and the
                    trunk upright; "raise left": the left one, "raise both": both at once
overhead            the same for a hand above the head
lower               the end of a time in which a hand is raised, until it hangs down, within 1.5 s
lie                 a time of at least 1 s in which trunk and thighs are level
kneel               a time of at least 0.5 s in which a knee is on the ground, and the trunk upright
stand still         a time of at least 0.5 s of standing in which neither pelvis nor limbs move
hand at             a time of at least 0.3 s in which a hand, or both, is at a part of the body, at
                    the floor or at the other hand, or the arm out to the side or in front: "at
                    left hip" is the left hand at a hip
lift                a time of at least 0.3 s in which a thigh is level and its foot 0.1 m above the
                    other, or 0.3 m, the trunk upright and the other thigh not level: "raise the
                    knee"
stay low            a time of at least 0.3 s on the feet in which the pelvis is 0.15 m lower than in
                    standing
stoop               a time of at least 0.3 s of standing or travelling in which the trunk leans 0.5
                    rad
lunge               a time of at least 0.3 s on both feet in which one is 0.65 m ahead of the other,
                    the pelvis 0.12 m lower than in standing and the trunk upright
on all fours        a time of at least 0.3 s in which a knee and a hand are on the floor, and the
                    trunk leans: "crawl"
on one leg          a time of at least 1 s of standing in which a foot is 0.15 m above the other;
                    "on left leg": the right one is above
==================  =============================================================================

Of Bandai-Namco's 280 captures, hands are raised on the named side in 160 of 168 that say so, on
another side in none, and in one of 112 that walk and run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body
from motiondb.body.features import runs
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import MODIFIERS, SINGLE, as_said
from motiondb.meaning.limb_sides import (
    LEGS,
    LOWERS,
    PLACES_ASKED,
    PLAIN,
    arm_lowered,
    arm_raised,
    hand_at,
    hands_are_at,
    leg_raised,
    limb_held,
)
from motiondb.records import FloatArray

MOST_LEAN = 1.0  # Angle of the trunk from upright, rad, of a posture that is upright
LEANS = {"bend": 0.7, "bow": 0.5}  # Angle of the trunk from upright, rad
LOW = {"squat": 0.3, "crouch": 0.2, "duck": 0.2}  # How much the pelvis is lower than standing, m
INVERTED, LEVEL, LEANT = 2.0, 1.3, 0.7
"""Angle of the trunk from upright, rad, of somebody upside down, level, and on the way there."""
SEATED = 0.95  # Angle of the thighs from hanging down, rad, of somebody who sits
SHORTEST_SEAT, SHORTEST_LEAN = 30, 9  # Frames
GOING, MOVING = 0.2, 0.4
"""Speed of the pelvis over the ground, and of a hand or foot relative to the pelvis, m/s, above
which somebody moves: who stands sways more slowly."""
_POSED_TEXT = (
    "raise overhead lower lie kneel on still at land takeoff lift low stoop lunge allfours"
)
POSED = frozenset(_POSED_TEXT.split())
"""First words of postures, and of a change between them, that are measured where captions do not
say them."""
_HANDS = ("", " left", " right", " both")
EVERY_POSTURE = (
    *(f"{what}{side}" for what in ("raise", "overhead", "lower") for side in _HANDS),
    *(f"on {side} leg" for side in ("left", "right", "one")),
    *(f"{what}{side}" for what in ("land", "takeoff") for side in (*_HANDS, " one")),
    *(f"lift{side}" for side in _HANDS[:3]),
    *(f"at {side} {place}" for side in ("any", "left", "right", "both") for place in PLACES_ASKED),
    *("lie", "kneel", "still", "stand", "sit", "low", "stoop", "lunge", "allfours", "walk", "run"),
)
"""The postures of ``POSED`` with their sides, and those in which something else is done."""
HELD = frozenset(("handstand", "sit", *POSED)) - {"lower", "land", "takeoff"}
"""Events that last for as long as a posture is held, or their first words."""
RAISED, ABOVE_HEAD = -0.05, 0.1
"""Height of a wrist above its shoulder, and above the joint of the head, m, of a raised hand."""
HANGS, LOWERED_WITHIN, BEFORE_LOWERING = -0.25, 45, 15
"""Height of a wrist below its shoulder, m, of a hand that hangs down; frames in which it comes
there, and frames (0.5 s) before."""
SHORTEST_TOUCH = 4  # Frames (0.13 s) for which a hand is at least at the floor or a foot
STAYS_LOW = 0.15  # Metres by which the pelvis is lower than in standing, of who stays low
LIFTED = 0.3  # Height of a foot above the other one, m, of a raised leg
OFF_GROUND = 0.1  # The same of a level thigh: the knee of a low stance is not raised
LYING, KNEE_DOWN, FOOT_UP, RESTS = 1.2, 0.15, 0.15, 0.6
"""Angle of the trunk from upright of somebody who lies, rad; height of a knee that is on the
ground, and of a foot above the one that is, m; speed over the ground of these postures, m/s."""
LUNGED, LUNGE_LOW = 0.65, 0.12
"""Metres between the ankles along the facing, and by which the pelvis is lower, of a lunge."""
LOWEST_HIPS, ON_FLOOR = 0.75, 0.2  # Heights of pelvis and knee of somebody on all fours, m
SHORTEST_KNEELING = 15  # Frames (0.5 s), also of standing still
_OF_POSTURES_TEXT = "raise lift lie kneel stand balance still lunge crawl allfours"
OF_POSTURES = frozenset(_OF_POSTURES_TEXT.split())
"""Words of postures that captions say."""
_WITH_LIFTED = frozenset(("raise", "lift", "up", "overhead", "high", *SIDES, *LIMBS, *PLAIN))
_WITH_HANDS = _WITH_LIFTED - LEGS  # "raise the arm and the knee" takes two postures
_WITH_LEGS = frozenset(("stand", "balance", SINGLE, *SIDES, *LEGS))
_WITH_POSTURE = {
    **dict.fromkeys(("raise", "overhead"), _WITH_HANDS),
    "lower": frozenset((*LOWERS, *SIDES, *LIMBS)) - LEGS,
    "on": _WITH_LEGS,
    "still": frozenset(("stand", "still")),
    "kneel": frozenset(("kneel", "down", "knee", "floor", "ground", SINGLE)),
    "lift": _WITH_LIFTED,
    "low": frozenset(("stay", "low", "down")),
    "stoop": frozenset(("stoop", "over", "forward", "down")),
    "land": _WITH_LEGS | {"land", "down", "floor", "ground"},
    "takeoff": _WITH_LEGS | {"takeoff"},
    "lie": frozenset(("lie", "down", "still", "floor", "ground")),
    "lunge": frozenset(("lunge", "forward")),
    "allfours": frozenset(
        ("crawl", "go", "move", "walk", "allfours", "floor", "ground", "hand", "knee")
    ),
}
"""Words beside which a posture is asked for, and nothing else."""
_OF_SIZE = MODIFIERS | {"deep", "shallow", "long", "short"}
_PLAIN_POSTURES = {"crawl": "allfours"} | {
    word: word for word in ("lie", "kneel", "stoop", "lunge", "allfours")
}
"""Words that name a posture by themselves -> the posture."""
STANDING = body.LEG_LENGTH + body.ANKLE_HEIGHT  # Height of the pelvis in standing, m
PAUSE = 3  # Frames (0.1 s) up to which a break does not end an occurrence


def posture_of(action: Sequence[str]) -> str:
    """The posture of ``POSED`` that an action takes, with its side; "" for others.

    >>> posture_of(("raise", "left", "arm")), posture_of(("stand", "theone", "leg"))
    ('raise left', 'on one leg')
    >>> posture_of(("both", "hand", "hip")), posture_of(("stand", "up"))
    ('at both hip', '')
    """
    return _posture_of(tuple(action))


@lru_cache(1024)  # each capture is asked for the same few
def _posture_of(action: tuple[str, ...]) -> str:
    """The posture of an action, as :func:`posture_of`."""
    words = {*action}
    if {"hand", "stand"} <= words:
        return ""
    held_at = hand_at(action)
    if held_at is not None:
        return f"at {held_at[0]} {held_at[1]}"
    raised, lowered, leg = arm_raised(action), arm_lowered(action), leg_raised(action)
    if leg is not None:
        return f"lift {leg}".strip().replace(" both", "")
    if raised is not None:
        return f"{'overhead' if 'overhead' in words else 'raise'} {raised}".strip()
    if lowered is not None:
        return f"lower {lowered}".strip()
    held = limb_held(action)
    flown = words.intersection(("land", "takeoff"))
    if flown:
        both = "both" if "both" in words else ""
        return f"{min(flown)} {as_said(held[0]) if held else both}".strip()
    if "stand" in words or "balance" in words:
        return f"on {as_said(held[0])} leg" if held else "still" if "still" in words else ""
    if {"stay", "low"} <= words:
        return "low"
    return next((_PLAIN_POSTURES[word] for word in action if word in _PLAIN_POSTURES), "")


def say_posture(posture: str) -> str:
    """A posture of :func:`event_of` in words that follow "does not".

    >>> [say_posture(one) for one in ("lie", "on left leg", "at any hip", "lower both")]
    ['lie', 'stand on the left leg alone', 'hold a hand at the hip', 'lower both hands']
    """
    what, _, side = posture.partition(" ")
    side, _, place = side.partition(" ") if what == "at" else (side, "", "")
    foot = "one foot" if side == "one" else f"the {side} foot"
    hands = {"": "a hand", "any": "a hand", "both": "both hands"}.get(side, f"the {side} hand")
    said = {
        "at": {
            "other hand": "hold the hands together",
            "other elbow": "cross the arms",
            "back": f"hold {hands} behind the back",
            "side": f"hold {hands} out to the side",
            "front": f"hold {hands} out in front",
            "floor": f"touch the floor with {hands}",
        }.get(place, f"hold {hands} at the {place}"),
        "land": "land on both feet" if side == "both" else f"land on {foot} alone",
        "takeoff": f"take off from {'both feet' if side == 'both' else f'{foot} alone'}",
        "on": f"stand on {'one leg' if side == 'one leg' else f'the {side}'} alone",
        "raise": f"raise {hands}",
        "lift": f"raise {f'the {side}' if side else 'a'} knee",
        "overhead": f"hold {hands} overhead",
        "lower": f"lower {hands}",
        "still": "stand still",
        "low": "stay low",
        "allfours": "go on all fours",
    }
    plain = {"land": "land", "takeoff": "take off", "seat": "sit down", "rise": "stand up"}
    return plain.get(posture) or said.get(what, what)


def is_held(event: str) -> bool:
    """Whether an event lasts for as long as a posture is held.

    >>> is_held("raise left"), is_held("sit"), is_held("jump"), is_held("")
    (True, True, False, False)
    """
    return event.split(" ")[0] in HELD


def is_posture_alone(action: Sequence[str]) -> bool:
    """Whether an action takes a posture of ``POSED``, and says no more than that.

    >>> is_posture_alone(("kneel", "floor")), is_posture_alone(("kneel", "backward"))
    (True, False)
    >>> is_posture_alone(("raise", "arm")), is_posture_alone(("raise", "arm", "knee"))
    (True, False)
    """
    what = posture_of(action).split(" ")[0]
    return what == "at" or (bool(what) and _WITH_POSTURE[what].issuperset(action))


def beside_posture(action: Sequence[str]) -> tuple[str, ...]:
    """What an action says of its posture that is not measured: ways, limbs and sizes.

    >>> beside_posture(("lunge", "left")), beside_posture(("kneel", "left", "knee"))
    (('left',), ('left',))
    >>> beside_posture(("lunge", "wave")), beside_posture(("walk", "left"))
    ((), ())
    """
    what = posture_of(action).split(" ")[0]
    if not what or what == "at":
        return ()
    beside = tuple(word for word in action if word not in _WITH_POSTURE[what])
    return beside if _OF_SIZE.issuperset(beside) else ()


def find_postures(track: FloatArray, posture: str) -> list[tuple[int, int]]:
    """The times in which somebody sits, or holds a posture of ``POSED`` with its side."""
    what, _, side = posture.partition(" ")
    if what == "lower":
        return _lowered(track, side)
    held, shortest = np.asarray(_FRAMES[what](track, side)), _SHORTEST.get(what, SHORTEST_LEAN)
    if what == "at" and side.endswith((" floor", " foot")):
        shortest = SHORTEST_TOUCH
    return [(a, b) for a, b in closed_runs(held) if b - a >= shortest]


def _of_side(each: NDArray[np.bool_], side: str) -> NDArray[np.bool_]:
    """Frames in which the limb of a side, both or any does something; `each` (frames, 2)."""
    if side in ("left", "right"):
        return each[:, int(side == "right")]
    return np.asarray(each.all(axis=1) if side == "both" else each.any(axis=1))


def _leg_raised(track: FloatArray, side: str) -> NDArray[np.bool_]:
    """Frames in which the leg of a side, or any, is raised, and the other one is not."""
    over = track[:, 4:6] - track[:, 5:3:-1]  # of a foot over the other one
    up = ((track[:, 20:22] > SEATED) & (over > OFF_GROUND)) | (over > LIFTED)
    return _of_side(up & (track[:, 21:19:-1] < SEATED), side)


def _on_one_leg(track: FloatArray, side: str) -> NDArray[np.bool_]:
    """Frames in which somebody stands on the leg of a side, or on one."""
    over = track[:, 5] - track[:, 4]  # of the right foot over the left one
    over = {"left leg": over, "right leg": -over}.get(side, np.abs(over))
    return np.asarray((over > FOOT_UP) & standing(track) & _resting(track))


def _lying(track: FloatArray, _: str) -> NDArray[np.bool_]:
    """Frames in which trunk and thighs are level."""
    level = (track[:, 14] > LYING) & (track[:, 14] < np.pi - LYING)
    return np.asarray(level & (track[:, 20:22] > LEANT).all(axis=1) & _resting(track))


def _kneeling(track: FloatArray, _: str) -> NDArray[np.bool_]:
    """Frames in which a knee is on the ground, and the trunk upright."""
    down = (track[:, 26:28] < KNEE_DOWN).any(axis=1)
    return np.asarray(down & (track[:, 14] < MOST_LEAN) & (track[:, 0] > LOW["squat"]))


def _low(track: FloatArray, _: str) -> NDArray[np.bool_]:
    """Frames in which somebody is low, on the feet."""
    on_feet = (track[:, 14] < LEVEL) & (track[:, 4:6] < LIFTED).any(axis=1) & ~sitting(track)
    return np.asarray((track[:, 0] < STANDING - STAYS_LOW) & on_feet)


def _stooping(track: FloatArray, _: str) -> NDArray[np.bool_]:
    """Frames in which the trunk leans, of somebody who does not sit."""
    leans = (track[:, 14] > LEANS["bow"]) & (track[:, 14] < LEVEL)
    return np.asarray(leans & ~sitting(track))


def _lunging(track: FloatArray, _: str) -> NDArray[np.bool_]:
    """Frames of a lunge, on both feet."""
    wide = np.abs(track[:, 18] - track[:, 19]) > LUNGED
    low = (track[:, 0] < STANDING - LUNGE_LOW) & (track[:, 14] < LEANS["bend"])
    return np.asarray(wide & low & (track[:, 4:6] < FOOT_UP).all(axis=1) & _resting(track))


def _on_all_fours(track: FloatArray, _: str) -> NDArray[np.bool_]:
    """Frames in which a hand and a knee are on the floor, and the trunk leans."""
    down = hands_are_at(track[:, 28], "any", "floor") & (track[:, 26:28] < ON_FLOOR).any(axis=1)
    leans = (track[:, 14] > LEANT) & (track[:, 14] < INVERTED)
    return np.asarray(down & leans & (track[:, 0] < LOWEST_HIPS))


def _resting(track: FloatArray) -> NDArray[np.bool_]:
    """Frames in which nobody travels."""
    return np.asarray(np.hypot(track[:, 1], track[:, 2]) < RESTS)


_FRAMES: dict[str, Callable[[FloatArray, str], NDArray[np.bool_]]] = {
    "raise": lambda track, side: (
        _of_side(track[:, 22:24] > RAISED, side) & (track[:, 14] < MOST_LEAN)
    ),
    "overhead": lambda track, side: (
        _of_side(track[:, 24:26] > ABOVE_HEAD, side) & (track[:, 14] < MOST_LEAN)
    ),
    "lift": lambda track, side: _leg_raised(track, side) & (track[:, 14] < MOST_LEAN),
    "at": lambda track, side: hands_are_at(track[:, 28], *side.split(" ", 1)),
    "still": lambda track, _: standing(track) & ~moving(track),
    "stand": lambda track, _: standing(track) & _resting(track),
    "sit": lambda track, _: sitting(track),
    "on": _on_one_leg,
    "lie": _lying,
    "kneel": _kneeling,
    "low": _low,
    "stoop": _stooping,
    "lunge": _lunging,
    "allfours": _on_all_fours,
}
"""Frames in which a posture is held, by its first word and its side."""
_SHORTEST = {
    **dict.fromkeys(("kneel", "still"), SHORTEST_KNEELING),
    **dict.fromkeys(("stand", "sit", "on", "lie"), SHORTEST_SEAT),
}
"""Least frames of postures; ``SHORTEST_LEAN`` of others."""


def _lowered(track: FloatArray, side: str) -> list[tuple[int, int]]:
    """The times in which a raised hand, or both, comes to hang down."""
    hands = {"left": [22], "right": [23], "both": [22, 23]}
    if side not in hands:
        times = _lowered(track, "left") + _lowered(track, "right")
        inside = ~frames_without(times, len(track))
        return [(int(a), int(b)) for a, b in runs(inside)]
    hangs = np.asarray((track[:, hands[side]] < HANGS).all(axis=1))
    found = []
    for start, end in find_postures(track, f"raise {side}"):
        down = np.flatnonzero(hangs[end : end + LOWERED_WITHIN])
        if len(down):
            found.append((max(end - BEFORE_LOWERING, start), int(end + down[0] + 1)))
    return found


def moving(track: FloatArray) -> NDArray[np.bool_]:
    """Frames in which the pelvis or a limb moves: (frames,)."""
    limbs = track[:, [7, 9, 10, 11]].max(axis=1) > MOVING
    return np.asarray(limbs | (np.hypot(track[:, 1], track[:, 2]) > GOING))


def sitting(track: FloatArray) -> NDArray[np.bool_]:
    """Frames in which somebody sits: both thighs are level and the trunk upright: (frames,)."""
    return np.asarray((track[:, 20:22] > SEATED).all(axis=1) & (track[:, 14] < MOST_LEAN))


def frames_without(times: Sequence[tuple[int, int]], n: int) -> NDArray[np.bool_]:
    """Which of n frames are in none of some times: array (n,)."""
    free = np.ones(n, dtype=bool)
    for start, end in times:
        free[start:end] = False
    return free


def standing(track: FloatArray) -> NDArray[np.bool_]:
    """Frames in which somebody is upright on the feet, at rest or not: (frames,)."""
    upright = (track[:, 14] < MOST_LEAN) & (track[:, 0] > STANDING - LOW["crouch"])
    return np.asarray(~sitting(track) & upright)


def closed_runs(inside: NDArray[np.bool_], pause: int = PAUSE) -> list[tuple[int, int]]:
    """Runs of frames; breaks of up to `pause` frames are filled."""
    filled = inside.copy()
    for start, end in runs(~inside):
        if start > 0 and end < len(inside) and end - start <= pause:
            filled[start:end] = True
    return [(int(start), int(end)) for start, end in runs(filled)]
