"""Where short actions occur in a motion, and how often: flights, kicks, bows, seats, turns.

Postures that last are those of :mod:`motiondb.meaning.postures`.

==================  =============================================================================
words               one occurrence
==================  =============================================================================
jump, leap, jete    a time of at least 0.1 s in which the pelvis is aloft, and both feet are off the
                    ground once; no stride of a run
hop                 such a time in which both feet are off the ground, and that ends on a foot on
                    which it began; a flight from one foot to the other is a leap. "Hop left", "hop
                    one": with the other foot above it before and after
kick                a time in which a foot is at least 0.35 m higher than in standing, that began
                    quickly, and in which the leg is stretched once and the trunk is upright; not
                    behind the pelvis; the middle of the shank is at 0.29 m on this body
punch               a time in which a hand is far from its shoulder, not lower than the chest, and
                    that began quickly
cartwheel, flip,    a time in which the trunk is head downwards, with what leads there and back, and
                    a foot is above the pelvis (but in rolls); a
somersault, roll,   handstand lasts a second, and in a roll the trunk need only be level
handstand
bend, bow           a time of at least 0.3 s in which the trunk leans and the pelvis is not low
squat, crouch,      a time in which the pelvis is lower than in standing, and the feet are below it;
duck                who ducks may lean instead
sit                 a time of at least 1 s in which both thighs are level and the trunk upright
seat                the beginning of such a time: "sit down"
rise                the end of a time in which somebody sits or is low: "stand up", "get up"
turn, spin          a time in which the body turns quickly, and far enough
stop                the end of a time of at least 0.5 s in which somebody travels, and rests within
                    1 s after it
land                the end of a flight: "land left" is on the left foot alone for 0.2 s
takeoff             the beginning of a flight, likewise
==================  =============================================================================

So raised knees, arabesques, climbing, and legs in the air of somebody who is upside down are no
kicks, and a kick is no jump. Feet that are up at the same time kick once. Hands that go out
together punch once; a hand that stays out does not hide the punch of the other. The limits were set
on kicks and punches of six captures of CMU; those of speed, stretching and leaning of kicks on
four: all 17 kicks of karate and of exercises are counted, and nothing else in these captures.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget, rotation
from motiondb.body.contacts import FEET, MAX_HEIGHT, foot_heights
from motiondb.body.features import headings, runs, velocity
from motiondb.body.pose_vectors import path_of
from motiondb.language.vocabulary import IN_PLACE, MODIFIERS
from motiondb.meaning.aims import reaches
from motiondb.meaning.limb_sides import outward_speeds, places_of_hands
from motiondb.meaning.postures import (
    INVERTED,
    LEANS,
    LEANT,
    LEVEL,
    LOW,
    MOST_LEAN,
    PAUSE,
    POSED,
    RESTS,
    SHORTEST_LEAN,
    SHORTEST_SEAT,
    STANDING,
    closed_runs,
    find_postures,
    moving,
    posture_of,
    sitting,
)
from motiondb.meaning.score_vectors import averaged_rows, running_median
from motiondb.meaning.travelled import RUNS, SPINS, SPUN, TURNS
from motiondb.records import MOTION_FPS, FloatArray, Motion

FLIGHTS = ("jump", "hop", "leap", "jete")
RISE = 0.06
"""Height of the pelvis above its lasting height, m, from which on it is aloft: running lifts it by
about 4 cm."""
FEET_AHEAD = 0.2
"""Metres by which the ankles of who sits are ahead of the pelvis: in the squats of CMU and of the
sample data they are up to 0.12, on its seats 0.26 or more."""
STRIDE = 0.014
"""Metres for each (m/s)^2 below which a flight is the stride of a run: those of CMU and
Bandai-Namco rise up to 0.013, jumps and leaps of dancers at least 0.016."""
LASTING = 31
"""Frames (1 s) over which the median of the height is taken, so that a jump does not count as
moving up."""
SHORTEST_FLIGHT = 3  # Frames (0.1 s)
NEAR_GROUND = 6
"""Frames (0.2 s) before and after a flight in which its feet are looked for on the ground."""
KICKED = 0.35  # Height of a kicking foot above its height in standing, m
KICK_SPEED, STRETCHED = 3.0, 0.7
"""Speed of the ankle relative to the pelvis, m/s, and distance of the ankle from the hip as a share
of the leg's length, of a kick."""
BEHIND = 0.2
"""Metres by which a kicking ankle may be behind the pelvis when it is highest: kicks of karate to
the side are up to 0.1, arabesques at least 0.3."""
LONGEST_KICK = 90  # Frames (3 s): who sits on a climbing frame has a foot up for longer
SHORTEST_KICK = 6  # Frames (0.2 s): the heels of runners are up for less
EXTENDED, LOWEST_HAND, PUNCH_SPEED = 0.8, -0.25, 2.0
"""Share of the arm's length between shoulder and wrist, height of the wrist relative to the
shoulder, m, and speed of the wrist relative to the pelvis, m/s, of a punch."""
BEGINNING = 8
"""Frames before the arm is extended or the foot is up in which a punch or kick may be quickest."""
LONGEST_FLIP = 18  # Frames
ALOFT = tuple(word for word in FLIGHTS if word != "hop")
OVER = frozenset(("cartwheel", "flip", "backflip", "somersault", "roll", "handstand"))
TURN_SPEED, SPIN_SPEED, TURNED = 0.8, 2.0, 0.7  # rad/s, rad/s, rad
COUNTED = (*FLIGHTS, "kick", "punch", *sorted(OVER), *LEANS, *LOW)
"""Words whose occurrences are counted in a motion that is made or judged."""
LIFTED, ON_ONE, BESIDE = 0.08, 0.6, 6
"""Height of a foot over the other one, m, and share of some frames, of who is on one foot; frames
before and after a flight, in which this holds of a hop."""
STOPPED, STEP = 0.3, 15  # m/s; frames (0.5 s) over which speeds are averaged
_RISES = frozenset(("stand", "get", "rise"))
_CLEAR = "kick squat crouch sit seat rise turn spin stop cartwheel flip backflip handstand"
CLEAR = frozenset((*_CLEAR.split(), "somersault", *FLIGHTS))
"""Events that tell an action where no caption says it. Hands that go out fast need not punch, and a
trunk that leans or is level need not bow or roll."""
SURE = CLEAR - {"hop", "kick", "turn", "spin", "stop"}
"""Events that a take without them surely lacks: low kicks and slow turns are not all seen."""
_NAMES = {"rise": _RISES, "turn": TURNS, "spin": SPINS, "run": RUNS}
_NAMES |= {"seat": frozenset(("sit",)), "handstand": frozenset(("hand", "stand", "handstand"))}
FASTEST_WALK, SLOWEST_WALK, SHORTEST_WAY = 2.0, 0.4, 15
"""Steady speeds, m/s, from which somebody runs and walks; frames (0.5 s) for which they last. Those
who run in Bandai-Namco go at 2.3 or more, those who walk at 1.7 or less; of 61 runs of CMU, 56 are
seen, and of the other captures two."""
_I = body.INDEX
_HIPS = (_I["l_hip"], _I["r_hip"])
_KNEES = (_I["l_knee"], _I["r_knee"])
_ARMS = tuple(_I[f"{side}_{joint}"] for side in "lr" for joint in ("shoulder", "elbow", "wrist"))


def measured_track(motion: Motion) -> FloatArray:
    """What measured words look at: array (frames, 37).

    Height of the pelvis (m), speed to the left and ahead (m/s), turning (rad/s); heights of the
    left and the right foot above standing (m); for the left and the right hand, whether it is
    extended (1 or 0), and its speed relative to the pelvis (m/s); the same speed of the left and
    the right ankle; the speed of the left and the right hand away from the shoulder; the angle of
    the trunk from upright (rad); height of the head (m); distance of the left and the right ankle
    from the hip, and how far ahead of the pelvis they are (m); the angle of the left and the right
    thigh from hanging down (rad); heights of the left and the right wrist above their shoulders,
    and above the head, and of the knees (m); the places of the hands (``places_of_hands``);
    where the trunk, the feet and the hands go (``reaches``).
    """
    joints = (0, *FEET, *_HIPS, *_KNEES, *_ARMS, _I["chest"], _I["neck"], _I["head"])
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
    held = places_of_hands(positions, heading)
    return np.column_stack([*tracked, thighs, *heights, held, reaches(positions, heading)])


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
    posture = posture_of(words)
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


def seen_event(action: Sequence[str], known: Container[str]) -> str:
    """The posture of an action; or its event, if that is clear and no known word names it; or "".

    `known`: The words that captions say.

    >>> seen_event(("jump", "left"), ()), seen_event(("jump", "left"), {"jump"})
    ('jump', '')
    >>> seen_event(("kneel",), {"kneel"}), seen_event(("punch",), ()), seen_event(("jog",), ())
    ('kneel', '', 'run')
    """
    return posture_of(action) or _clear_event(action, known)


def _clear_event(action: Sequence[str], known: Container[str]) -> str:
    """The clear event of an action of which no known word names it; "" for others."""
    if any(word in known and word not in MODIFIERS for word in action):
        return ""
    event = event_of(action)
    if not event and IN_PLACE not in action:
        event = next((e for e in ("run", "walk") if not _names(e).isdisjoint(action)), "")
    return event if event in (*CLEAR, "run", "walk") else ""


def _names(event: str) -> frozenset[str]:
    """The words that name an event."""
    return _NAMES.get(event, frozenset((event,)))


def beside_event(action: Sequence[str]) -> tuple[str, ...]:
    """What an action says beside its event, and of no direction, limb or degree.

    >>> beside_event(("jump", "over", "puddle")), beside_event(("stand", "up", "quick"))
    (('puddle',), ())
    >>> beside_event(("jump", "kick"))
    ('jump',)
    """
    own = _names(_clear_event(action, ()))
    return tuple(word for word in action if word not in own and word not in MODIFIERS)


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
        kicks = closed_runs(_kicking(track, 0) | _kicking(track, 1))
        return [(a, b) for a, b in kicks if b - a <= LONGEST_KICK]
    if word == "punch":
        hands = (closed_runs(_begun(track[:, hand] > 0, track[:, hand + 1])) for hand in (6, 8))
        return _one_by_one(sorted(time for times in hands for time in times))
    if word in _TIMES:
        return _TIMES[word](track, word)
    what, _, side = word.partition(" ")
    if what in ("land", "takeoff"):
        return _ends_of_flights(track, what, side)
    if what in ("stand", "sit", *POSED):
        return find_postures(track, word)
    if word in ("turn", "spin"):
        return _turns(
            track[:, 3], *((SPIN_SPEED, SPUN) if word == "spin" else (TURN_SPEED, TURNED))
        )
    flights = [(a, b) for a, b in closed_runs(aloft(track)) if b - a >= SHORTEST_FLIGHT]
    flights = [flight for flight in flights if not _is_stride(track, *flight)]
    if what != "hop":
        return flights
    feet = track[:, 4:6]
    hops = [flight for flight in flights if _is_hop(feet, flight)]
    return [hop for hop in hops if not side or is_on_foot(_beside(feet, hop), side)]


def _travels(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """The times in which somebody who is upright walks or runs."""
    speed = averaged_rows(np.hypot(track[:, 1], track[:, 2]), STEP // 2)
    is_fast = speed > FASTEST_WALK
    going = is_fast if word == "run" else (speed > SLOWEST_WALK) & ~is_fast
    upright = np.asarray(going & (track[:, 14] < MOST_LEAN))
    return [(a, b) for a, b in closed_runs(upright) if b - a >= SHORTEST_WAY]


def _is_stride(track: FloatArray, start: int, end: int) -> bool:
    """Whether a flight [start, end) is the stride of a run, which rises little for its speed."""
    around = track[max(start - NEAR_GROUND, 0) : end + NEAR_GROUND]
    speed = float(np.hypot(around[:, 1], around[:, 2]).mean())
    return bool(track[start:end, 0].max() - track[max(start - 1, 0), 0] < STRIDE * speed**2)


def _lasting(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """The times in which somebody moves, bends or bows, or is as low as who squats or ducks."""
    if word == "move":
        lasting = moving(track)
    elif word in LEANS:
        leans = (track[:, 14] > LEANS[word]) & (track[:, 14] < INVERTED)
        lasting = np.asarray(leans & (track[:, 0] > 0.6))
    else:
        low = track[:, 0] < STANDING - LOW[word]
        lasting = np.asarray(low | ((word == "duck") & (track[:, 14] > LEANS["bend"])))
    found = [(a, b) for a, b in closed_runs(lasting) if b - a >= SHORTEST_LEAN]
    if word in ("squat", "crouch"):
        return [time for time in found if not _is_seat(track, *time)]
    return found


def _is_seat(track: FloatArray, start: int, end: int) -> bool:
    """Whether something bears the body where it is lowest: both feet are ahead of the pelvis."""
    lowest = start + int(np.argmin(track[start:end, 0]))
    return bool((track[lowest, 18:20] > FEET_AHEAD).all())


def _ends(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """The times around the beginnings of seats, and around the ends of low postures and travels."""
    if word == "seat":
        starts = [start for start, _ in find_postures(track, "sit") if start > PAUSE]
        return [(max(start - 20, 0), start + 20) for start in starts]
    if word == "stop":
        return _stops(track)
    low = sitting(track) | (track[:, 0] < STANDING - LOW["squat"])
    ends = [b for a, b in closed_runs(low, SHORTEST_SEAT) if b - a >= SHORTEST_LEAN]
    around = [(max(e - 10, 0), min(e + 20, len(track))) for e in ends]
    return [time for time, e in zip(around, ends) if e < len(track) - PAUSE]


def _stops(track: FloatArray) -> list[tuple[int, int]]:
    """The times around the ends of travelling that a rest follows."""
    speed = averaged_rows(np.hypot(track[:, 1], track[:, 2]), STEP // 2)
    travels = [(a, b) for a, b in closed_runs(np.asarray(speed > RESTS)) if b - a >= STEP]
    rests = [b for _, b in travels if speed[b : b + 2 * STEP].min(initial=np.inf) < STOPPED]
    return [(max(b - 20, 0), min(b + STEP, len(track))) for b in rests]


def _ends_of_flights(track: FloatArray, what: str, side: str) -> list[tuple[int, int]]:
    """The landings of a side, or the times in which it takes off: landings, backwards in time."""
    if what == "land":
        return _landings(track, side)
    return [(len(track) - b, len(track) - a) for a, b in reversed(_landings(track[::-1], side))]


def _landings(track: FloatArray, side: str) -> list[tuple[int, int]]:
    """The times in which a flight ends, on the foot of a side alone, on one, both or any."""
    down, found = track[:, 4:6] <= MAX_HEIGHT, list[tuple[int, int]]()
    for start, end in find_occurrences(track, "jump"):
        flying = np.flatnonzero(~down[start : end + NEAR_GROUND].any(axis=1))
        first = start + int(flying[-1]) + 1 if len(flying) else end
        after = down[first : first + NEAR_GROUND]
        left, right = after.mean(axis=0) > 0.5 if len(after) else (False, False)
        of_side = {"left": left > right, "right": right > left, "one": left != right}
        if of_side.get(side, left and right if side == "both" else left or right):
            found.append((max(first - PAUSE, 0), min(first + NEAR_GROUND, len(track))))
    return found


def _over(track: FloatArray, word: str) -> list[tuple[int, int]]:
    """The times in which the trunk is upside down, and in which it leans before and after."""
    leans, found = track[:, 14], list[tuple[int, int]]()
    rolls, flips = word in ("roll", "somersault"), word in ("flip", "backflip")
    flies = aloft(track) if flips else np.zeros(len(track), dtype=bool)
    for start, end in closed_runs(np.asarray(leans > (LEVEL if rolls else LEANT))):
        n_over = int((leans[start:end] > (LEVEL if rolls else INVERTED)).sum())
        if flips and (n_over > LONGEST_FLIP or not flies[start:end].any()):
            continue
        if n_over < (SHORTEST_SEAT if word == "handstand" else PAUSE):
            continue
        legs_over = (track[start:end, 4:6].max(axis=1) > track[start:end, 0]).any()
        if rolls or legs_over:  # who bends down, head downwards, stays on the feet
            found.append((start, end))
    return found


_TIMES: dict[str, Callable[[FloatArray, str], list[tuple[int, int]]]] = {
    **dict.fromkeys((*LEANS, *LOW, "move"), _lasting),
    **dict.fromkeys(OVER, _over),
    **dict.fromkeys(("seat", "rise", "stop"), _ends),
    **dict.fromkeys(("walk", "run"), _travels),
}


def _turns(speeds: FloatArray, least_speed: float, least: float) -> list[tuple[int, int]]:
    """The times in which the body turns quickly to one side, and far enough.

    `speeds` (frames,): rad/s.

    >>> speeds = np.zeros(90); speeds[20:50] = 2.0; speeds[60:63] = 2.0
    >>> _turns(speeds, 0.8, 0.7)
    [(20, 50)]
    """
    times = [run for sign in (1.0, -1.0) for run in closed_runs(sign * speeds > least_speed)]
    return sorted((a, b) for a, b in times if abs(speeds[a:b].sum()) >= least * MOTION_FPS)


def aloft(track: FloatArray) -> NDArray[np.bool_]:
    """Frames of the times in which the pelvis is aloft, and once both feet are: array (frames,)."""
    rise = track[:, 0] - running_median(track[:, 0], LASTING)
    off = np.asarray((track[:, 4:6] > MAX_HEIGHT).all(axis=1))
    kept = np.zeros(len(track), dtype=bool)
    for start, end in runs(np.asarray(rise > RISE)):
        kept[start:end] = off[start:end].any()
    return kept


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
    for start, end in closed_runs(extended):
        kept[start:end] = speeds[max(start - BEGINNING, 0) : start + 1].max() >= PUNCH_SPEED
    return kept


def _kicking(track: FloatArray, foot: int) -> NDArray[np.bool_]:
    """Frames of the times in which the left (0) or right (1) foot kicks."""
    heights, speeds, reach = track[:, 4 + foot], track[:, 10 + foot], track[:, 16 + foot]
    kept = np.zeros(len(track), dtype=bool)
    for start, end in closed_runs(heights > KICKED):
        highest = start + int(np.argmax(heights[start:end]))
        is_quick = speeds[max(start - BEGINNING, 0) : highest + 1].max() >= KICK_SPEED
        is_stretched = reach[start:end].max() >= STRETCHED * body.LEG_LENGTH
        is_upright = track[start:end, 14].max() <= MOST_LEAN
        is_long = end - start >= SHORTEST_KICK and track[highest, 18 + foot] >= -BEHIND
        kept[start:end] = is_quick and is_stretched and is_upright and is_long
    return kept


def flown(track: FloatArray, flight: tuple[int, int]) -> tuple[float, float]:
    """How far a flight goes to the left and ahead, m, as seen from where it takes off.

    >>> track = np.zeros((30, 6)); track[:15, 2] = track[15:, 1] = 1.0; track[15, 3] = -15.0 * np.pi
    >>> [round(way, 2) + 0.0 for way in flown(track, (0, 30))]
    [0.0, 1.0]
    """
    left, ahead, turned = track[slice(*flight), 1:4].T / MOTION_FPS
    heading = np.cumsum(turned)
    aside = left * np.cos(heading) + ahead * np.sin(heading)
    before = ahead * np.cos(heading) - left * np.sin(heading)
    return float(aside.sum()), float(before.sum())


def _beside(feet: FloatArray, flight: tuple[int, int]) -> FloatArray:
    """The `feet` (frames, 2) just before and after a flight."""
    start, end = flight
    return np.concatenate([feet[max(start - BESIDE, 0) : start], feet[end : end + BESIDE]])


def is_on_foot(feet: FloatArray, side: str) -> bool:
    """Whether the foot of a side, or one, is below the other for most of some frames.

    `feet` (frames, 2): heights, m.

    >>> feet = np.tile([0.0, 0.2], (10, 1))
    >>> [is_on_foot(feet, side) for side in ("left", "right", "one")]
    [True, False, True]
    """
    over = feet[:, 1] - feet[:, 0]  # of the right foot over the left one
    alone = {"left": over, "right": -over}.get(side, np.abs(over)) > LIFTED
    return bool(len(feet)) and float(alone.mean()) >= ON_ONE


def _is_hop(feet: FloatArray, flight: tuple[int, int]) -> bool:
    """Whether both `feet` (frames, 2) leave the ground, and one that it began on lands first."""
    down = feet <= MAX_HEIGHT
    first, last = max(flight[0] - NEAR_GROUND, 0), flight[1] + NEAR_GROUND
    up = list(runs(np.asarray(~down[first:last].any(axis=1))))
    start, end = max(up, key=lambda run: run[1] - run[0], default=(0, 0))
    if start == 0 or first + end >= len(down):
        return False
    return bool((down[first + start - 1] & down[first + end]).any())
