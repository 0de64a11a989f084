"""Where short actions occur in a motion, and how often: flights, kicks, bows, seats, turns.

==================  =============================================================================
words               one occurrence
==================  =============================================================================
jump, leap, jete    a time of at least 0.1 s in which the pelvis is aloft, and both feet are off the
                    ground once
hop                 such a time in which both feet are off the ground, and that ends on a foot on
                    which it began; a flight from one foot to the other is a leap
kick                a time in which a foot is at least 0.35 m higher than in standing, that began
                    quickly, and in which the leg is stretched once and the trunk is upright; not
                    behind the pelvis; the middle of the shank is at 0.29 m on this body
punch               a time in which a hand is far from its shoulder, not lower than the chest, and
                    that began quickly
cartwheel, flip,    a time in which the trunk is head downwards, with what leads there and back; a
somersault, roll,   handstand lasts a second, and in a roll the trunk need only be level
handstand
bend, bow           a time of at least 0.3 s in which the trunk leans and the pelvis is not low
squat, crouch,      a time in which the pelvis is lower than in standing; who ducks may lean instead
duck
sit                 a time of at least 1 s in which both thighs are level and the trunk upright
seat                the beginning of such a time: "sit down"
rise                the end of a time in which somebody sits or is low: "stand up", "get up"
turn, spin          a time in which the body turns quickly, and far enough
stop                the end of a time of at least 0.5 s in which somebody travels, and rests within
                    1 s after it
raise               a time of at least 0.3 s in which a hand is as high as its shoulder, and the
                    trunk upright; "raise left": the left one, "raise both": both at once
overhead            the same for a hand above the head
lower               the end of a time in which a hand is raised, until it hangs down, within 1.5 s
lie                 a time of at least 1 s in which trunk and thighs are level
kneel               a time of at least 0.5 s in which a knee is on the ground, and the trunk upright
stand still         a time of at least 0.5 s of standing in which neither pelvis nor limbs move
on one leg          a time of at least 1 s of standing in which a foot is 0.15 m above the other;
                    "on left leg": the right one is above
==================  =============================================================================

An occurrence is *whole* with what leads to it and what follows it, such as the crouch before a
flight and after the landing: from a frame of rest to the next one (:func:`whole_occurrences`).

So raised knees, arabesques, climbing, and legs in the air of somebody who is upside down are no
kicks, and a kick is no jump. Feet that are up at the same time kick once. Hands that go out
together punch once; a hand that stays out does not hide the punch of the other. The limits were set
on kicks and punches of six captures of CMU; those of speed, stretching and leaning of kicks on
four: all 17 kicks of karate and of exercises are counted, and nothing else in these captures. Of
Bandai-Namco's 280 captures, hands are raised on the named side in 160 of 168 that say so, on
another side in none, and in one of 112 that walk and run.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget, rotation
from motiondb.body.contacts import FEET, MAX_HEIGHT, foot_heights
from motiondb.body.features import headings, runs, velocity
from motiondb.body.pose_vectors import path_of
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import SINGLE, as_said
from motiondb.meaning.limb_sides import (
    LEGS,
    LOWERS,
    PLAIN,
    arm_lowered,
    arm_raised,
    limb_held,
    outward_speeds,
)
from motiondb.meaning.score_vectors import averaged_rows, running_median
from motiondb.meaning.travelled import SPINS, SPUN, TURNS
from motiondb.records import MOTION_FPS, FloatArray, Motion

FLIGHTS = ("jump", "hop", "leap", "jete")
RISE = 0.06
"""Height of the pelvis above its lasting height, m, from which on it is aloft: running lifts it by
about 4 cm."""
LASTING = 31
"""Frames (1 s) over which the median of the height is taken, so that a jump does not count as
moving up."""
SHORTEST_FLIGHT = 3  # Frames (0.1 s)
NEAR_GROUND = 6
"""Frames (0.2 s) before and after a flight in which its feet are looked for on the ground."""
KICKED = 0.35  # Height of a kicking foot above its height in standing, m
KICK_SPEED, STRETCHED, MOST_LEAN = 3.0, 0.7, 1.0
"""Speed of the ankle relative to the pelvis, m/s, distance of the ankle from the hip as a share of
the leg's length, and angle of the trunk from upright, radians, of a kick."""
BEHIND = 0.2
"""Metres by which a kicking ankle may be behind the pelvis when it is highest: kicks of karate to
the side are up to 0.1, arabesques at least 0.3."""
SHORTEST_KICK = 6  # Frames (0.2 s): the heels of runners are up for less
EXTENDED, LOWEST_HAND, PUNCH_SPEED = 0.8, -0.25, 2.0
"""Share of the arm's length between shoulder and wrist, height of the wrist relative to the
shoulder, m, and speed of the wrist relative to the pelvis, m/s, of a punch."""
BEGINNING = 8
"""Frames before the arm is extended or the foot is up in which a punch or kick may be quickest."""
ALOFT = tuple(word for word in FLIGHTS if word != "hop")
OVER = frozenset(("cartwheel", "flip", "backflip", "somersault", "roll", "handstand"))
LEANS = {"bend": 0.7, "bow": 0.5}  # Angle of the trunk from upright, rad
LOW = {"squat": 0.3, "crouch": 0.2, "duck": 0.2}  # How much the pelvis is lower than standing, m
INVERTED, LEVEL, LEANT = 2.0, 1.3, 0.7
"""Angle of the trunk from upright, rad, of somebody upside down, level, and on the way there."""
SEATED = 0.95  # Angle of the thighs from hanging down, rad, of somebody who sits
SHORTEST_SEAT, SHORTEST_LEAN, LONGEST_FLIP = 30, 9, 18  # Frames
GOING, MOVING = 0.2, 0.4
"""Speed of the pelvis over the ground, and of a hand or foot relative to the pelvis, m/s, above
which somebody moves: who stands sways more slowly."""
TURN_SPEED, SPIN_SPEED, TURNED = 0.8, 2.0, 0.7  # rad/s, rad/s, rad
COUNTED = (*FLIGHTS, "kick", "punch", *sorted(OVER), *LEANS, *LOW)
"""Words whose occurrences are counted in a motion that is made or judged."""
POSED = frozenset(("raise", "overhead", "lower", "lie", "kneel", "on", "still"))
"""First words of postures, and of a change between them, that are measured where captions do not
say them."""
_HANDS = ("", " left", " right", " both")
EVERY_POSTURE = (
    *(f"{what}{side}" for what in ("raise", "overhead", "lower") for side in _HANDS),
    *(f"on {side} leg" for side in ("left", "right", "one")),
    *("lie", "kneel", "still", "stand", "sit"),
)
"""The postures of ``POSED`` with their sides, and those in which something else is done."""
HELD = frozenset(("handstand", "sit", *POSED)) - {"lower"}
"""Events that last for as long as a posture is held, or their first words."""
RAISED, ABOVE_HEAD = -0.05, 0.1
"""Height of a wrist above its shoulder, and above the joint of the head, m, of a raised hand."""
HANGS, LOWERED_WITHIN, BEFORE_LOWERING = -0.25, 45, 15
"""Height of a wrist below its shoulder, m, of a hand that hangs down; frames in which it comes
there, and frames (0.5 s) before."""
STOPPED, STEP = 0.3, 15  # m/s; frames (0.5 s) over which speeds are averaged
LYING, KNEE_DOWN, FOOT_UP, RESTS = 1.2, 0.15, 0.15, 0.6
"""Angle of the trunk from upright of somebody who lies, rad; height of a knee that is on the
ground, and of a foot above the one that is, m; speed over the ground of these postures, m/s."""
SHORTEST_KNEELING = 15  # Frames (0.5 s), also of standing still
_RISES = frozenset(("stand", "get", "rise"))
OF_POSTURES = frozenset(("raise", "lift", "lie", "kneel", "stand", "balance", "still"))
"""Words of postures that captions say."""
_WITH_HANDS = frozenset(("raise", "lift", "up", "overhead", "high", *SIDES, *LIMBS, *PLAIN))
_WITH_LEGS = frozenset(("stand", "balance", SINGLE, *SIDES, *LEGS))
_WITH_POSTURE = {
    **dict.fromkeys(("raise", "overhead"), _WITH_HANDS),
    "lower": frozenset((*LOWERS, *SIDES, *LIMBS)),
    "on": _WITH_LEGS,
    "still": frozenset(("stand", "still")),
    "kneel": frozenset(("kneel", "down", "knee", "floor", "ground", SINGLE)),
    "lie": frozenset(("lie", "down", "still", "floor", "ground")),
}
"""Words beside which a posture is asked for, and nothing else."""
STANDING = body.LEG_LENGTH + body.ANKLE_HEIGHT  # Height of the pelvis in standing, m
PAUSE = 3  # Frames (0.1 s) up to which a break does not end an occurrence
UPRIGHT = 0.9  # Quantile of the heights of the pelvis that is taken for standing
REST_WITHIN = 45  # Frames (1.5 s) before and after an occurrence in which the body comes to rest
LEAD = 3  # Frames (0.1 s) of the rest that belong to a whole occurrence
SINKING, SAGGED, RETURNED = 0.15, 0.05, 0.25
"""Speed of the pelvis up or down, m/s, height that it lost, m, and share of an excursion, up to
which a body is at rest."""
AROUND = 24  # Frames (0.8 s) before and after a punch: arms are at rest where feet may not be
_I = body.INDEX
_HIPS = (_I["l_hip"], _I["r_hip"])
_KNEES = (_I["l_knee"], _I["r_knee"])
_ARMS = tuple(_I[f"{side}_{joint}"] for side in "lr" for joint in ("shoulder", "elbow", "wrist"))


def measured_track(motion: Motion) -> FloatArray:
    """What measured words look at: array (frames, 28).

    Height of the pelvis (m), speed to the left and ahead (m/s), turning (rad/s); heights of the
    left and the right foot above standing (m); for the left and the right hand, whether it is
    extended (1 or 0), and its speed relative to the pelvis (m/s); the same speed of the left and
    the right ankle; the speed of the left and the right hand away from the shoulder; the angle of
    the trunk from upright (rad); height of the head (m); distance of the left and the right ankle
    from the hip, and how far ahead of the pelvis they are (m); the angle of the left and the right
    thigh from hanging down (rad); heights of the left and the right wrist above their shoulders,
    and above the head, and of the knees (m).
    """
    joints = (0, *FEET, *_HIPS, *_KNEES, *_ARMS, _I["neck"], _I["head"])
    positions, world = retarget.motion_positions(motion, joints)
    positions = positions.astype(np.float64)
    arms = []
    for side in "lr":
        shoulder, elbow, wrist = (
            positions[:, _I[f"{side}_{j}"]] for j in ("shoulder", "elbow", "wrist")
        )
        length = np.linalg.norm(elbow - shoulder, axis=1) + np.linalg.norm(wrist - elbow, axis=1)
        far = np.linalg.norm(wrist - shoulder, axis=1) > EXTENDED * length
        high = (wrist - shoulder)[:, 1] > LOWEST_HAND
        arms += [(far & high).astype(float), _speeds(wrist - positions[:, 0])]
    ankles = [_speeds(positions[:, ankle] - positions[:, 0]) for ankle in FEET[::2]]
    outward = outward_speeds(positions, velocity(positions, MOTION_FPS))
    trunk = rotation.normalize(positions[:, _I["neck"]] - positions[:, 0])[:, 1]
    leaning = np.arccos(np.clip(trunk, -1.0, 1.0))
    head = positions[:, _I["head"], 1]
    legs = np.linalg.norm(positions[:, FEET[::2]] - positions[:, _HIPS], axis=2)
    heading = headings(world)
    path = path_of(motion.root_positions.astype(np.float64), heading, MOTION_FPS)
    away, facing = positions[:, FEET[::2]] - positions[:, :1], heading[:, None]
    ahead = away[..., 0] * np.sin(facing) + away[..., 2] * np.cos(facing)
    tracked = [path, foot_heights(positions), *arms, *ankles, outward, leaning, head, legs, ahead]
    down = -rotation.normalize(positions[:, _KNEES] - positions[:, _HIPS])[..., 1]
    thighs = np.arccos(np.clip(down, -1.0, 1.0))
    wrists, shoulders = (
        positions[:, [_I[f"{side}_{joint}"] for side in "lr"], 1] for joint in ("wrist", "shoulder")
    )
    heights = [wrists - shoulders, wrists - head[:, None], positions[:, _KNEES, 1]]
    return np.column_stack([*tracked, thighs, *heights])


def event_of(words: Sequence[str]) -> str:
    """The word for what occurs in an action, as ``find_occurrences`` takes it; "" for others.

    >>> event_of(("kick", "left", "leg")), event_of(("stand", "up")), event_of(("hand", "stand"))
    ('kick', 'rise', 'handstand')
    >>> event_of(("sit", "stool")), event_of(("stand", "still")), event_of(("veer", "left"))
    ('sit', 'still', 'turn')
    >>> event_of(("raise", "left", "arm")), event_of(("hand", "overhead")), event_of(("raise",))
    ('raise left', 'overhead', '')
    >>> event_of(("stand", "theone", "leg")), event_of(("lie", "floor"))
    ('on one leg', 'lie')
    """
    if {"hand", "stand"} <= {*words}:
        return "handstand"
    posture = _posture(words)
    if posture:
        return posture
    if "up" in words and not _RISES.isdisjoint(words):
        return "rise"
    if "sit" in words:
        return "seat" if "down" in words else "sit"
    if not SPINS.isdisjoint(words):
        return "spin"
    found = [word for word in words if word in COUNTED]
    if not found and "stop" in words:
        return "stop"
    return found[-1] if found else "turn" if not TURNS.isdisjoint(words) else ""


def _posture(words: Sequence[str]) -> str:
    """The posture that an action takes, with its side; "" for others."""
    raised, lowered = arm_raised(words), arm_lowered(words)
    if raised is not None:
        return f"{'overhead' if 'overhead' in words else 'raise'} {raised}".strip()
    if lowered is not None:
        return f"lower {lowered}".strip()
    if "stand" in words or "balance" in words:
        held = limb_held(words)
        return f"on {as_said(held[0])} leg" if held else "still" if "still" in words else ""
    return next((word for word in words if word in ("lie", "kneel")), "")


def say_posture(posture: str) -> str:
    """A posture of :func:`event_of` in words that follow "does not".

    >>> [say_posture(one) for one in ("lie", "on left leg", "raise", "lower both")]
    ['lie', 'stand on the left leg alone', 'raise a hand', 'lower both hands']
    """
    what, _, side = posture.partition(" ")
    hands = {"": "a hand", "both": "both hands"}.get(side, f"the {side} hand")
    said = {
        "on": f"stand on {'one leg' if side == 'one leg' else f'the {side}'} alone",
        "raise": f"raise {hands}",
        "overhead": f"hold {hands} overhead",
        "lower": f"lower {hands}",
        "still": "stand still",
    }
    return said.get(what, what)


def is_held(event: str) -> bool:
    """Whether an event lasts for as long as a posture is held.

    >>> is_held("raise left"), is_held("sit"), is_held("jump"), is_held("")
    (True, True, False, False)
    """
    return event.split(" ")[0] in HELD


def posture_of(action: Sequence[str]) -> str:
    """The posture of ``POSED`` that an action takes, with its side; "" for others."""
    event = event_of(action)
    return event if event.split(" ")[0] in POSED else ""


def is_posture_alone(action: Sequence[str]) -> bool:
    """Whether an action takes a posture of ``POSED``, and says no more than that.

    >>> is_posture_alone(("kneel", "floor")), is_posture_alone(("kneel", "backward"))
    (True, False)
    """
    posture = posture_of(action)
    return bool(posture) and _WITH_POSTURE[posture.split()[0]].issuperset(action)


def _speeds(places: FloatArray) -> FloatArray:
    """Speeds (frames,), m/s, of `places` (frames, 3)."""
    steps = np.diff(places, axis=0, prepend=places[:1]) * MOTION_FPS
    return np.asarray(np.linalg.norm(steps, axis=1))


def find_occurrences(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """First frame and last frame + 1 of each occurrence, in the order of time.

    >>> track = np.zeros((90, 6)); track[20:30] = track[60:70] = 0.2
    >>> find_occurrences(track, "jump")
    [(20, 30), (60, 70)]
    """
    if word == "kick":
        return _runs(_kicking(track, 0) | _kicking(track, 1))
    if word == "punch":
        hands = (_runs(_begun(track[:, hand] > 0, track[:, hand + 1])) for hand in (6, 8))
        return _one_by_one(sorted(time for times in hands for time in times))
    if word in OVER:
        return _over(track, word)
    if word in LEANS:
        bent = (track[:, 14] > LEANS[word]) & (track[:, 14] < INVERTED) & (track[:, 0] > 0.6)
        return [(a, b) for a, b in _runs(np.asarray(bent)) if b - a >= SHORTEST_LEAN]
    if word in LOW:
        low = track[:, 0] < STANDING - LOW[word]
        low |= (word == "duck") & (track[:, 14] > LEANS["bend"])
        return [(a, b) for a, b in _runs(np.asarray(low)) if b - a >= SHORTEST_LEAN]
    if word in ("seat", "rise", "stop"):
        return _ends(track, word)
    if word == "move":
        return [(a, b) for a, b in _runs(_moving(track)) if b - a >= SHORTEST_LEAN]
    if word.split()[0] in ("stand", "sit", *POSED):
        return _postures(track, word)
    if word in ("turn", "spin"):
        return _turns(
            track[:, 3], *((SPIN_SPEED, SPUN) if word == "spin" else (TURN_SPEED, TURNED))
        )
    flights = [(a, b) for a, b in _runs(aloft(track)) if b - a >= SHORTEST_FLIGHT]
    return [flight for flight in flights if word != "hop" or _is_hop(track[:, 4:6], flight)]


def _ends(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """The times around the beginnings of seats, and around the ends of low postures and travels."""
    if word == "seat":
        starts = [start for start, _ in _postures(track, "sit") if start > PAUSE]
        return [(max(start - 20, 0), start + 20) for start in starts]
    if word == "stop":
        return _stops(track)
    low = sitting(track) | (track[:, 0] < STANDING - LOW["squat"])
    ends = [b for a, b in _runs(low, SHORTEST_SEAT) if b - a >= SHORTEST_LEAN]
    around = [(max(e - 10, 0), min(e + 20, len(track))) for e in ends]
    return [time for time, e in zip(around, ends) if e < len(track) - PAUSE]


def _stops(track: FloatArray) -> list[tuple[int, int]]:
    """The times around the ends of travelling that a rest follows."""
    speed = averaged_rows(np.hypot(track[:, 1], track[:, 2]), STEP // 2)
    travels = [(a, b) for a, b in _runs(np.asarray(speed > RESTS)) if b - a >= STEP]
    rests = [b for _, b in travels if speed[b : b + 2 * STEP].min(initial=np.inf) < STOPPED]
    return [(max(b - 20, 0), min(b + STEP, len(track))) for b in rests]


def _postures(track: FloatArray, posture: str) -> list[tuple[int, int]]:
    """The times in which somebody sits, or holds a posture of ``POSED`` with its side."""
    what, _, side = posture.partition(" ")
    if what == "lower":
        return _lowered(track, side)
    shortest = SHORTEST_LEAN
    if what in ("raise", "overhead"):
        up = track[:, 22:24] > RAISED if what == "raise" else track[:, 24:26] > ABOVE_HEAD
        of_side = {"left": up[:, 0], "right": up[:, 1], "both": up.all(axis=1)}
        held = of_side.get(side, up.any(axis=1)) & (track[:, 14] < MOST_LEAN)
    elif what == "kneel":
        down, shortest = (track[:, 26:28] < KNEE_DOWN).any(axis=1), SHORTEST_KNEELING
        held = down & (track[:, 14] < MOST_LEAN) & (track[:, 0] > LOW["squat"])
    elif what == "still":
        held, shortest = standing(track) & ~_moving(track), SHORTEST_KNEELING
    elif what in ("stand", "sit"):
        rests = np.hypot(track[:, 1], track[:, 2]) < RESTS
        held = sitting(track) if what == "sit" else standing(track) & rests
        shortest = SHORTEST_SEAT
    else:
        rests, shortest = np.hypot(track[:, 1], track[:, 2]) < RESTS, SHORTEST_SEAT
        level = (track[:, 14] > LYING) & (track[:, 14] < np.pi - LYING)
        held = level & (track[:, 20:22] > LEANT).all(axis=1) & rests
        if what == "on":
            over = track[:, 5] - track[:, 4]  # of the right foot over the left one
            over = {"left leg": over, "right leg": -over}.get(side, np.abs(over))
            held = (over > FOOT_UP) & standing(track) & rests
    return [(a, b) for a, b in _runs(np.asarray(held)) if b - a >= shortest]


def _lowered(track: FloatArray, side: str) -> list[tuple[int, int]]:
    """The times in which a raised hand, or both, comes to hang down."""
    hands = {"left": [22], "right": [23], "both": [22, 23]}
    if side not in hands:
        times = _lowered(track, "left") + _lowered(track, "right")
        inside = ~frames_without(times, len(track))
        return [(int(a), int(b)) for a, b in runs(inside)]
    hangs = np.asarray((track[:, hands[side]] < HANGS).all(axis=1))
    found = []
    for start, end in _postures(track, f"raise {side}"):
        down = np.flatnonzero(hangs[end : end + LOWERED_WITHIN])
        if len(down):
            found.append((max(end - BEFORE_LOWERING, start), int(end + down[0] + 1)))
    return found


def _moving(track: FloatArray) -> NDArray[np.bool_]:
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


def _over(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """The times in which the trunk is upside down, and in which it leans before and after."""
    leans, found = track[:, 14], list[tuple[int, int]]()
    rolls, flips = word in ("roll", "somersault"), word in ("flip", "backflip")
    flies = aloft(track) if flips else np.zeros(len(track), dtype=bool)
    for start, end in _runs(np.asarray(leans > (LEVEL if rolls else LEANT))):
        n_over = int((leans[start:end] > (LEVEL if rolls else INVERTED)).sum())
        if flips and (n_over > LONGEST_FLIP or not flies[start:end].any()):
            continue
        if n_over >= (SHORTEST_SEAT if word == "handstand" else PAUSE):
            found.append((start, end))
    return found


def _turns(speeds: FloatArray, least_speed: float, least: float) -> list[tuple[int, int]]:
    """The times in which the body turns quickly to one side, and far enough.

    `speeds` (frames,): rad/s.

    >>> speeds = np.zeros(90); speeds[20:50] = 2.0; speeds[60:63] = 2.0
    >>> _turns(speeds, 0.8, 0.7)
    [(20, 50)]
    """
    times = [run for sign in (1.0, -1.0) for run in _runs(sign * speeds > least_speed)]
    return sorted((a, b) for a, b in times if abs(speeds[a:b].sum()) >= least * MOTION_FPS)


def whole_occurrences(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """First frame and last frame + 1 of each occurrence with what leads to it and follows it.

    Each begins and ends at rest, or where the body is calmest within ``REST_WITHIN`` frames; those
    that follow one another closely meet in between.

    >>> track = np.zeros((90, 6)); track[:, 0] = 0.9
    >>> track[30:40, 0], track[40:50, 0:6] = 0.7, 1.1  # a crouch, then a flight
    >>> whole_occurrences(track, "jump")
    [(25, 55)]
    """
    found = find_occurrences(track, word)
    if not found:
        return []
    meeting = [(one[1] + after[0]) // 2 for one, after in pairwise(found)]
    unrest = np.zeros(0) if word == "punch" else _unrest(track, word)
    whole = []
    for n, (start, end) in enumerate(found):
        low = max(start - REST_WITHIN, meeting[n - 1] if n else 0)
        high = min(end + REST_WITHIN, meeting[n] if n < len(meeting) else len(track))
        if word == "punch":
            whole.append((max(start - AROUND, low), min(end + AROUND, high)))
        else:
            first = start - _until_rest(unrest[low:start][::-1])
            whole.append((max(first, low), min(end + _until_rest(unrest[end:high]), high)))
    return whole


def _until_rest(unrest: FloatArray) -> int:
    """Frames until the body is at rest, with ``LEAD`` frames of it; until it is calmest, if never.

    >>> _until_rest(np.array([3.0, 2.0, 0.5, 0.0, 0.0])), _until_rest(np.array([3.0, 2.0, 4.0]))
    (6, 2)
    """
    if not len(unrest):
        return 0
    calm = np.flatnonzero(unrest <= 1.0)
    return int(calm[0]) + 1 + LEAD if len(calm) else int(np.argmin(unrest)) + 1


def _unrest(track: FloatArray, word: str) -> FloatArray:
    """How far from rest a body is: array (frames,), up to 1 at rest."""
    heights = track[:, 0]
    feet = track[:, 4:6].max(axis=1) if word == "kick" else track[:, 4:6].min(axis=1)
    parts = [np.abs(np.gradient(heights)) * MOTION_FPS / SINKING, feet / MAX_HEIGHT]
    if word in (*OVER, *LEANS):
        parts.append(track[:, 14] / (RETURNED * LEANS.get(word, INVERTED)))
    elif word in LOW:
        parts.append((np.quantile(heights, UPRIGHT) - heights) / (RETURNED * LOW[word]))
    elif word in FLIGHTS:
        sagged = running_median(heights, 2 * LASTING - 1) - heights
        parts.append(sagged / SAGGED)
    return np.asarray(np.max(parts, axis=0))


def aloft(track: FloatArray) -> NDArray[np.bool_]:
    """Frames of the times in which the pelvis is aloft, and once both feet are: array (frames,)."""
    rise = track[:, 0] - running_median(track[:, 0], LASTING)
    off = np.asarray((track[:, 4:6] > MAX_HEIGHT).all(axis=1))
    kept = np.zeros(len(track), dtype=bool)
    for start, end in runs(np.asarray(rise > RISE)):
        kept[start:end] = off[start:end].any()
    return kept


def _runs(inside: NDArray[np.bool_], pause: int = PAUSE) -> list[tuple[int, int]]:
    """Runs of frames; breaks of up to `pause` frames are filled."""
    filled = inside.copy()
    for start, end in runs(~inside):
        if start > 0 and end < len(inside) and end - start <= pause:
            filled[start:end] = True
    return [(int(start), int(end)) for start, end in runs(filled)]


def _one_by_one(times: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Times in order of which each ends where the next begins; those that begin together are one.

    >>> _one_by_one([(0, 60), (40, 50), (42, 70)])
    [(0, 40), (40, 70)]
    """
    apart: list[tuple[int, int]] = []
    for start, end in times:
        if apart and start - apart[-1][0] <= PAUSE:
            apart[-1] = (apart[-1][0], max(apart[-1][1], end))
        else:
            apart.append((start, end))
    nexts = [start for start, _ in apart[1:]] + [apart[-1][1]] if apart else []
    return [(start, min(end, after)) for (start, end), after in zip(apart, nexts)]


def _begun(extended: NDArray[np.bool_], speeds: FloatArray) -> NDArray[np.bool_]:
    """Frames of the times in which an arm is extended that began quickly."""
    kept = np.zeros(len(extended), dtype=bool)
    for start, end in _runs(extended):
        kept[start:end] = speeds[max(start - BEGINNING, 0) : start + 1].max() >= PUNCH_SPEED
    return kept


def _kicking(track: FloatArray, foot: int) -> NDArray[np.bool_]:
    """Frames of the times in which the left (0) or right (1) foot kicks."""
    heights, speeds, reach = track[:, 4 + foot], track[:, 10 + foot], track[:, 16 + foot]
    kept = np.zeros(len(track), dtype=bool)
    for start, end in _runs(heights > KICKED):
        highest = start + int(np.argmax(heights[start:end]))
        is_quick = speeds[max(start - BEGINNING, 0) : highest + 1].max() >= KICK_SPEED
        is_stretched = reach[start:end].max() >= STRETCHED * body.LEG_LENGTH
        is_upright = track[start:end, 14].max() <= MOST_LEAN
        is_long = end - start >= SHORTEST_KICK and track[highest, 18 + foot] >= -BEHIND
        kept[start:end] = is_quick and is_stretched and is_upright and is_long
    return kept


def _is_hop(feet: FloatArray, flight: tuple[int, int]) -> bool:
    """Whether both `feet` (frames, 2) leave the ground, and one that it began on lands first."""
    down = feet <= MAX_HEIGHT
    first, last = max(flight[0] - NEAR_GROUND, 0), flight[1] + NEAR_GROUND
    up = list(runs(np.asarray(~down[first:last].any(axis=1))))
    if not up:
        return False
    start, end = max(up, key=lambda run: run[1] - run[0])
    if start == 0 or first + end >= len(down):
        return False
    return bool((down[first + start - 1] & down[first + end]).any())
