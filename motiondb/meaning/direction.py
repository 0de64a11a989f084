"""What is measured in a motion: directions, sides of limbs, turns, starts, stops and jumps.

Directions of travel and of turns ("backward", "turn left", "in place") are measured as in a search
(:mod:`motiondb.meaning.travelled`), and so is the limb that moves ("left hand",
:mod:`motiondb.meaning.limb_sides`). Their full amount is a clear one there, half of it the least
amount. Besides:

===============  ============================================  =====================
words            measured                                      full amount
===============  ============================================  =====================
up, down         lasting change of the height of the pelvis    0.15 m
turn, veer       turning to either side that lasts             0.7 rad (40 degrees)
spin, pirouette  turning to either side                        4.7 rad (270 degrees)
stop             loss of speed along the ground, up to MOVING  0.5 m/s
start            gain of speed along the ground, up to MOVING  0.5 m/s
jump             time aloft                                    0.2 s
leap, jete       the same                                      0.2 s
hop, kick,       occurrences                                   1
punch            (:mod:`motiondb.meaning.occurrences`)
bend, bow        angle of the trunk from upright               0.7, 0.5 rad
cartwheel, flip  the same: head downwards                      2.0 rad
squat, crouch    height that the pelvis loses or gains         0.3, 0.2 m
duck             height that the head loses or gains           0.3 m
climb            lasting rise over the ground of the lower     0.4 m
                 foot, or of the pelvis from where it is in
                 standing if that is less; not "climb down"
kneel, raise     time for which a posture is held              0.5 s
both, ...        (:mod:`motiondb.meaning.occurrences`)
===============  ============================================  =====================

A loss of speed from 3 to 2 m/s is no stop, because speeds above ``MOVING`` count as that. The
amounts are well above the sway of a standing person, and a running person's pelvis is not aloft.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.body import body
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import IN_PLACE, TRAVELS, as_said
from motiondb.meaning.limb_sides import (
    LEGS,
    PUNCHES,
    hop_on,
    is_at_rest,
    limbs_to_measure,
    say_other_limb,
    side_amount,
)
from motiondb.meaning.occurrences import ALOFT, FLIGHTS, LASTING, aloft, find_occurrences
from motiondb.meaning.postures import (
    EVERY_POSTURE,
    INVERTED,
    LEANS,
    LOW,
    frames_without,
    is_posture_alone,
    posture_of,
    say_posture,
)
from motiondb.meaning.score_vectors import running_median
from motiondb.meaning.travelled import (
    CLEARLY,
    directions_to_measure,
    furthest,
    largest_part,
    lasting_turns,
    means_around,
    say_not_gone,
    share_of_full,
    turning,
    ways,
)
from motiondb.records import MOTION_FPS, FloatArray

HOPS_ON = ("hop left", "hop right", "hop one")  # On the leg of a side, or on one
_OVER = ("cartwheel", "flip", "backflip", "somersault")
FULL = {
    "up": 0.15,
    "down": 0.15,
    "turn": 0.7,
    "veer": 0.7,
    "spin": 4.7,
    "pirouette": 4.7,
    "stop": 0.5,
    "start": 0.5,
    "jump": 0.2,
    "leap": 0.2,
    "jete": 0.2,
    **dict.fromkeys(("hop", *HOPS_ON), 1.0),
    "kick": 1.0,
    "punch": 1.0,
    **LEANS,
    **dict.fromkeys(_OVER, INVERTED),
    **LOW,
    "duck": 0.3,  # of the head
    "climb": 0.4,
    **dict.fromkeys(EVERY_POSTURE, 0.5),
    **{one: 0.13 for one in EVERY_POSTURE if one.endswith((" floor", " foot"))},
    **{one: 0.25 for one in EVERY_POSTURE if one.startswith(("land", "takeoff"))},
}
"""Word -> full amount, in the units of the table."""
VERTICAL = ("up", "down")
TURNS = ("turn", "veer", "spin", "pirouette")
PLAIN_TURNS = ("turn", "spin", "veer", "swerve")  # Of which nothing but the turning has to be seen
OCCURRING = ("hop", "kick", "punch")
OUT = " out"  # After the limb of a punch, of which only the way from the shoulder counts
LEANING = (*LEANS, *_OVER)
LOWERING = {"squat": 0, "crouch": 0, "duck": 15}  # Word -> column of the track
POSTURES = (*LEANING, *LOWERING)
_SAID_BY = {"down": (*LEANS, *LOWERING), "up": FLIGHTS}
"""Direction -> actions that are measured to go there, and of which nothing lasts: "jump up"."""
OF_TRAVEL = (*TURNS, "stop", "start")  # Measured only where the action has no direction
ACTIONS = (*OF_TRAVEL, *ALOFT, *OCCURRING, *POSTURES, "climb")
"""Words that name actions; the others are directions of actions."""
ONCE = (*ACTIONS, *VERTICAL, "left", "right", "turn left", "turn right", "turn around")
"""What is over when it is done, so that a part that shows it is not repeated to make it longer."""
EITHER = TURNS  # Words that are measured to either side
REACHED = 0.5  # Share of the full amount from which on a motion may do what is measured
FULLY = 1.0 - 1e-9  # Full amount of a measured word; sums of shares lack the last digits of 1
MOVING = 0.6  # Speed along the ground, m/s, from which on a person counts as moving
STEADY = 15  # Frames (0.5 s, about one step) over which the speed along the ground is averaged
NEARLY = 0.9  # Share of the largest distance that counts as nearly as far


def directions_of(words: Sequence[str]) -> tuple[str, ...]:
    """What of an action is measured: words, or a word with its turn or limb ("left hand").

    A word that names a turn, a stop or a start is measured where the action has no direction; the
    others are measured beside one too. A kick with the left leg is not cut to the
    kicks, because these are of either leg.

    >>> directions_of(("sit", "down")), directions_of(("wave", "left", "hand"))
    (('down',), ('left hand',))
    >>> directions_of(("turn",)), directions_of(("turn", "left")), directions_of(("step", "left"))
    (('turn',), ('turn left',), ('left',))
    >>> directions_of(("turn", "around")), directions_of(("look", "around"))
    (('turn around',), ())
    >>> directions_of(("jump", "left")), directions_of(("start", "walk", "forward"))
    (('left', 'jump'), ('forward',))
    >>> directions_of(("spin", "left")), directions_of(("punch", "left", "hand"))
    (('spin left',), ('left hand out',))
    >>> directions_of(("bend", "down")), directions_of(("jump", "down"))
    (('bend',), ('down', 'jump'))
    >>> directions_of(("raise", "both", "arm")), directions_of(("hop", "left", "leg", "backward"))
    (('raise both',), ('hop left', 'backward'))
    """
    if is_posture_alone(words):
        return (posture_of(words),)
    out = "" if PUNCHES.isdisjoint(words) else OUT
    limbs = [
        f"{side} {limb}{'' if limb in LEGS else out}" for side, limb in limbs_to_measure(words)
    ]
    if hop_on(words):
        return (hop_on(words), *_travelled(words))
    is_sided = bool(SIDES.intersection(words) and LIMBS.intersection(words))
    vertical = [w for w in words if w in VERTICAL and {*_SAID_BY[w]}.isdisjoint(words)]
    named = [word for word in words if word in ACTIONS and not (word in OCCURRING and is_sided)]
    directed = [*limbs, *_travelled(words), *vertical]
    if directed:
        named = [word for word in named if word not in OF_TRAVEL]
    if "down" in words:
        named = [word for word in named if word != "climb"]
    return tuple(dict.fromkeys([*directed, *named]))


def vertical_ways(words: Sequence[str]) -> tuple[str, ...]:
    """Whether an action that travels or climbs goes "up" or "down", which is measured.

    >>> vertical_ways(("walk", "up", "step")), vertical_ways(("stand", "up"))
    (('up',), ())
    """
    if {"climb", *TRAVELS}.isdisjoint(words) or not {*FLIGHTS}.isdisjoint(words):
        return ()
    return tuple(word for word in words if word in VERTICAL)


def gone_anywhere(track: FloatArray, way: str) -> float:
    """How much some part of a motion does of what is measured, in full amounts."""
    return _most_gained(progress(track, way))


def trodden_anywhere(track: FloatArray, way: str) -> float:
    """How far up or down the lower foot gets in some part of a motion, in full amounts.

    Hips that rise from a crouch do not walk up.
    """
    feet = np.minimum(*(running_median(track[:, k], LASTING) for k in (4, 5)))
    return _most_gained(feet / FULL[way] * (-1.0 if way == "down" else 1.0))


def _most_gained(amount: FloatArray) -> float:
    """By how much an amount (frames,) exceeds one of an earlier frame at most."""
    return float((amount - np.minimum.accumulate(amount)).max())


def _travelled(words: Sequence[str]) -> tuple[str, ...]:
    """The directions of an action that are measured as in a search, turns with their verb.

    >>> _travelled(("turn", "left")), _travelled(("walk", "backward")), _travelled(("sit", "down"))
    (('turn left',), ('backward',), ())
    """
    turn = turning(words)
    return tuple(
        f"{turn} {word}" if turn and word != IN_PLACE else word
        for word in directions_to_measure(words)
    )


def is_as_in_search(measured: str) -> bool:
    """Whether a measured word is a direction or the side of a limb, which search measures too."""
    return measured not in FULL


def is_of_limb(measured: str) -> bool:
    """Whether a measured word is the side of a limb."""
    return measured not in EVERY_POSTURE and not LIMBS.isdisjoint(measured.split())


def words_of_measured(measured: Sequence[str]) -> set[str]:
    """The words of what is measured, and where it goes.

    >>> sorted(words_of_measured(["turn left", "backward"])), sorted(words_of_measured(["bend"]))
    (['backward', 'left', 'turn'], ['bend', 'down'])
    """
    words = {word for one in measured for word in one.split()}
    if not words.isdisjoint(VERTICAL):  # "jump down" goes down
        return words
    return words | {d for d, actions in _SAID_BY.items() if not words.isdisjoint(actions)}


def say_measured(measured: str) -> str:
    """What is measured, in plain words.

    >>> say_measured("stationary"), say_measured("left hand"), say_measured("both hand")
    ('in place', 'left hand', 'both hands')
    """
    if measured in EVERY_POSTURE:
        return say_posture(measured)
    if measured in HOPS_ON:
        return f"hop on {'' if measured == 'hop one' else 'the '}{measured[4:]} leg"
    if measured.startswith("both "):
        return {"both foot": "both feet"}.get(measured, f"{measured}s")
    return measured if measured in FULL else " ".join(map(as_said, measured.split()))


def say_not_done(measured: str, amount: float) -> str:
    """What a motion lacks that does not do what is measured, of which it has an amount.

    >>> [say_not_done(measured, 0.1) for measured in ("up", "stop", "turn left")]
    ['it does not go up', 'it does not stop', 'it does not turn left']
    >>> say_not_done("left hand", 0.1), say_not_done("left hand", 0.0)
    ('it moves the right hand, not the left', 'it does not move the left hand')
    """
    if measured in FULL and measured not in VERTICAL:
        return f"it does not {say_measured(measured)}"
    first, _, second = measured.removesuffix(OUT).partition(" ")
    if second in LIMBS and amount <= 0.0:
        which = measured if first == "both" else f"the {measured}"
        return f"it does not move {say_measured(which)}"
    if second in LIMBS:
        return f"it {say_other_limb(first, second)}"
    return f"it {say_not_gone(*_of_travel(measured))}"


def _of_travel(measured: str) -> tuple[str, str]:
    """A direction as search measures it, and how the action turns: "spin left" is left, spin."""
    turn, _, direction = measured.rpartition(" ")
    return direction, turn


def say_hardly_done(measured: str) -> str:
    """What a motion does that does not clearly do what is measured.

    >>> say_hardly_done("backward"), say_hardly_done("left hand")
    ('backward only a little, as measured', 'left hand hardly more than the other, as measured')
    """
    if is_of_limb(measured) and not measured.startswith("both"):
        return f"{measured} hardly more than the other, as measured"
    return f"{say_measured(measured)} only a little, as measured"


def progress(track: FloatArray, measured: str) -> FloatArray:
    """Distance moved up to each frame, in full amounts: array (frames,); not for "in place".

    `track` (frames, columns): those of ``measured_track``.

    >>> track = np.zeros((31, 4)); track[:, 2] = 0.5
    >>> [float(progress(track, word)[-1].round(3)) for word in ("forward", "backward")]
    [1.0, -1.667]
    """
    if is_of_limb(measured):
        left, right = _limbs(track, measured).T
        of = {"left": left - right, "right": right - left, "both": np.minimum(left, right)}
        return np.asarray(np.cumsum(of[measured.split()[0]]) / MOTION_FPS)
    if measured not in FULL:
        every = ways(track[:-1, 1:4], *_of_travel(measured), fps=MOTION_FPS)
        way = max(every, key=largest_part)
        return np.concatenate([[0.0], np.cumsum(way)]) / CLEARLY
    sign = -1.0 if measured in ("down", "stop") else 1.0
    return sign * _way(track, measured) / FULL[measured]


def _way(track: FloatArray, measured: str) -> FloatArray:
    """What a word of ``FULL`` measures up to each frame, in its units: array (frames,)."""
    if measured in VERTICAL:
        height = running_median(track[:, 0], LASTING)
        return height - height[0]
    if measured == "climb":
        above_standing = running_median(track[:, 0], LASTING) - body.LEG_LENGTH - body.ANKLE_HEIGHT
        feet = np.minimum(*(running_median(track[:, k], LASTING) for k in (4, 5)))
        return np.maximum(np.minimum(above_standing, feet), 0.0)
    if measured in ("stop", "start"):
        speed = means_around(np.hypot(track[:, 1], track[:, 2]), STEADY)
        return np.minimum(speed, MOVING)
    if measured in ALOFT:
        return np.cumsum(aloft(track)) / MOTION_FPS
    if measured in LEANING:
        return track[:, 14]
    if measured in LOWERING:
        return -track[:, LOWERING[measured]]
    if measured in EVERY_POSTURE:
        held = ~frames_without(find_occurrences(track, measured), len(track))
        return np.asarray(np.cumsum(held) / MOTION_FPS)
    if measured in (*OCCURRING, *HOPS_ON):
        share = np.zeros(len(track))
        for start, end in find_occurrences(track, measured):
            share[start:end] = 1.0 / (end - start)
        return np.cumsum(share)
    return np.concatenate([[0.0], np.cumsum(lasting_turns(track[:-1, 1:4], MOTION_FPS))])


def gone(track: FloatArray, measured: str) -> float:
    """How much a motion does of what is measured, in full amounts; 1 or more is clear.

    What stops is at rest in the end, and what starts is at rest in the beginning; so these compare
    the last or first frame with the frame of most speed. Limbs that rest move neither side.
    """
    if not len(track):
        return 0.0
    if is_of_limb(measured):
        speeds = _limbs(track, measured)
        side = measured.split()[0]
        return 0.0 if is_at_rest(speeds) else side_amount(speeds, side) / CLEARLY
    if measured not in FULL:
        direction, turn = _of_travel(measured)
        amount = furthest(track[:, 1:4], direction, turn, fps=MOTION_FPS)[0]
        return share_of_full(amount, direction, turn)
    way = progress(track, measured)
    if measured == "stop":
        return float(way[-1] - way.min())
    if measured == "start":
        return float(way.max() - way[0])
    if measured in LEANING:
        return float(way.max())
    if measured == "climb":
        return gone_anywhere(track, measured)
    if measured in (*TURNS, *LOWERING):
        return float(way.max() - way.min())
    return float(way[-1])


def lacking(amount: float, measured: str) -> float:
    """What an amount lacks, 0 to 2: half of the full amount does, but not of directions and sides.

    Directions and sides that are not reached lack twice as much, because no looks outweigh them.

    >>> lacking(0.6, "stop"), lacking(0.75, "backward"), lacking(0.4, "backward")
    (0.0, 0.25, 2.0)
    """
    if not is_as_in_search(measured):
        return float(amount < REACHED)
    return 2.0 if amount < REACHED else max(1.0 - amount, 0.0)


def _limbs(track: FloatArray, measured: str) -> FloatArray:
    """Squared speeds of the left and the right wrist or ankle, (m/s)^2: array (frames, 2)."""
    columns = [10, 11] if LEGS.intersection(measured.split()) else [7, 9]
    return np.asarray(track[:, [12, 13] if measured.endswith(OUT) else columns] ** 2)


def furthest_part(track: FloatArray, measured: str, longest: int) -> tuple[int, int]:
    """The shortest part, [first, behind), that travels nearly as far as any of ``longest`` frames.

    >>> track = np.zeros((120, 4)); track[:, 0] = [1.0] * 40 + [0.5] * 40 + [1.0] * 40
    >>> furthest_part(track, "up", 120)
    (79, 81)
    """
    way = progress(track, measured)
    spans = []
    for first in range(len(way)):
        gain = way[first : first + longest] - way[first]
        gain = np.abs(gain) if measured in EITHER else gain
        far = float(gain.max())
        spans.append((far, first, first + int(np.argmax(gain >= NEARLY * far)) + 1))
    best = max(far for far, _, _ in spans)
    good = [(behind - first, first) for far, first, behind in spans if far >= NEARLY * best]
    length, first = min(good)
    return first, first + length
