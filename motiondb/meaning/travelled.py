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
in a circle      turning to either side                         4.5 rad (260 degrees)
spin left, ...   turning to that side, or to either one         2.35 rad (135 degrees)
in place         frames in a square of 0.45 m (half of a leg)   0.8 of them
===============  =============================================  ==========================

Way along an axis counts in frames in which the person moves faster along it than across it, so that
the sway of a person who walks ahead is no way to a side. A turn on the spot that is taken back
within two seconds, as in a twist of the trunk, is no turn. The amounts are those that some part of
the frames covers. A motion that does less than the least amount clearly goes elsewhere; from
``CLEARLY`` on it clearly does what the word says. Search and the judge of generated motion both
measure in this way.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_FPS, ROOT_WEIGHT, VELOCITY_SECONDS, runs
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import IN_A_CIRCLE, IN_PLACE, TRAVELS, as_said
from motiondb.meaning.score_vectors import running_median
from motiondb.records import Float32Array, FloatArray

LEAST = {
    "forward": 0.25,
    "backward": 0.15,
    "back": 0.15,
    "sideways": 0.2,
    "left": 0.35,
    "right": 0.35,
    "around": 2.1,
    IN_A_CIRCLE: 4.5,
    IN_PLACE: 0.8,
}
"""Direction -> least amount, in the units of the table."""
SQUARE = 0.45  # Side of the square on the ground that a motion in place does not leave, m
CLEARLY = 2.0  # Least amounts of a direction from which a motion clearly goes there
# 143 and 315 degrees, and all frames
_CLEARLY = {"around": 2.5 / 2.1, IN_A_CIRCLE: 5.5 / 4.5, IN_PLACE: 1.0 / 0.8}
SHORTEST_STAY = 1.0  # Seconds for which a motion must stay in place, unless it is shorter
SPINS = frozenset(
    ("spin", "pirouette", "twirl", "whirl")
)  # Words for turning most of the way round
TURNS = SPINS | {"turn", "rotate", "rotation", "pivot", "veer", "swerve"}  # Words for turning
SPUN = 2.35  # Least turning of a spin, rad
GOES = TRAVELS - {"dribble", "jump", "hop", "leap", "slide", "march", "hobble"}
"""Words for travelling that nobody does on the spot."""
RUNS = frozenset(("run", "jog", "sprint", "dash"))
REST = frozenset(("stand", "still", "rest", "wait", "freeze"))  # Words for staying where one is
RUNNING, GOING, RESTING = 1.5, 0.3, 0.15
"""Averaged speed over the ground, m/s, above which a person runs, or goes at all, and below which
one rests."""
STEADY = 1.0  # Seconds over which speeds are averaged before they are compared
LASTING = 2.0
"""Seconds from which on a turn on the spot lasts; twists are taken back after 1 to 2."""
_OF_TURNS = SIDES | {IN_A_CIRCLE}  # Directions of turns; "around" has none but these
ON_THE_SPOT = 0.4  # Averaged speed over the ground, m/s, below which a person is on the spot


def directions_to_measure(words: Sequence[str]) -> tuple[str, ...]:
    """The measured directions of an action, without sides that belong to a limb.

    >>> directions_to_measure(("walk", "backward")), directions_to_measure(("lean", "back"))
    (('backward',), ())
    >>> directions_to_measure(("step", "left", "foot")), directions_to_measure(("walk", "around"))
    ((), ())
    >>> directions_to_measure(("wave", IN_PLACE)), directions_to_measure(("run", IN_A_CIRCLE))
    (('stationary',), ('circular',))
    >>> directions_to_measure(("move", "arm", IN_A_CIRCLE))
    ()
    """
    turns, travels = not TURNS.isdisjoint(words), not TRAVELS.isdisjoint(words)
    return tuple(
        dict.fromkeys(
            word
            for word, following in zip(words, [*words[1:], ""])
            if word in LEAST
            and (
                word == IN_PLACE
                or (turns if word == "around" else travels or (turns and word in _OF_TURNS))
            )
            and not (word in SIDES and following in LIMBS)
            and not (word == IN_A_CIRCLE and not LIMBS.isdisjoint(words))
        )
    )


def steady_speed(speeds: FloatArray, fps: float = FEATURE_FPS) -> FloatArray:
    """Speed over the ground, m/s, averaged over ``STEADY`` seconds: array (frames,).

    `speeds` (frames, 3): those of ``speeds_of``.
    """
    size = round(STEADY * fps)
    around = (size // 2, size - 1 - size // 2), (0, 0)
    return np.asarray(np.hypot(*means_of(np.pad(speeds[:, :2], around, mode="edge"), size).T))


def means_of(values: FloatArray, size: int) -> FloatArray:
    """Means over successive values: array (frames - size + 1, ...); `values` (frames, ...).

    SciPy has them, too, but to import it takes longer than most questions.

    >>> means_of(np.array([1.0, 3.0, 5.0]), 2).tolist()
    [2.0, 4.0]
    """
    sums = np.cumsum(np.concatenate([np.zeros_like(values[:1]), values]), axis=0)
    return (sums[size:] - sums[:-size]) / size


def means_around(values: FloatArray, size: int) -> FloatArray:
    """Means over `size` values around each, the first and last repeated: array (frames, ...).

    As ``scipy.ndimage.uniform_filter1d`` with ``mode="nearest"``.

    >>> means_around(np.array([0.0, 3.0, 6.0]), 3).tolist()
    [1.0, 3.0, 5.0]
    """
    before = size // 2
    first, last = values[:1], values[-1:]
    ends = np.repeat(first, before, axis=0), np.repeat(last, size - 1 - before, axis=0)
    return means_of(np.concatenate([ends[0], values, ends[1]]), size)


def longest_going(
    speed: FloatArray,
    words: Sequence[str],
    shown: NDArray[np.bool_] | None = None,
    at_any_speed: bool = False,
    fps: float = FEATURE_FPS,
) -> tuple[float, int, int]:
    """The longest time for which a motion travels, or rests, in seconds, and its part [a, b).

    `speed` (frames,): that of ``steady_speed``. `words`: those of the action, which tell how fast
    it goes at least. `shown` (frames,): frames that count; without it, all.

    >>> speeds = np.zeros((90, 3)); speeds[:60, 1] = 2.0  # 4 s ahead, then 2 s at rest
    >>> speed = steady_speed(speeds)
    >>> round(longest_going(speed, ("run",))[0]), longest_going(speed[60:], ("jog",))[0]
    (4, 0.0)
    """
    goes = (
        np.ones(len(speed), dtype=bool)
        if at_any_speed
        else speed > (RUNNING if RUNS.intersection(words) else GOING)
    )
    if TRAVELS.isdisjoint(words) and not REST.isdisjoint(words):
        goes = goes if at_any_speed else speed < RESTING
    found = [(0, 0), *runs(goes if shown is None else goes & shown)]
    first, behind = max(found, key=lambda run: run[1] - run[0])
    return float((behind - first) / fps), int(first), int(behind)


def turning(words: Sequence[str]) -> str:
    """How an action turns: "spin", "turn", or "" if it names no turn.

    >>> turning(("twirl", "left")), turning(("turn", "left")), turning(("walk", "left"))
    ('spin', 'turn', '')
    """
    return "spin" if SPINS.intersection(words) else "turn" if TURNS.intersection(words) else ""


def say_not_gone(direction: str, turn: str = "") -> str:
    """What a motion lacks that does not go in a direction.

    >>> say_not_gone("left", "turn"), say_not_gone(IN_PLACE), say_not_gone(IN_A_CIRCLE)
    ('does not turn left', 'does not stay in place', 'does not go in a circle')
    """
    verb = "stay" if direction == IN_PLACE else turn or "go"
    return f"does not {verb} {as_said(direction)}"


def speeds_of(features: Float32Array) -> FloatArray:
    """Speed to the left and ahead (m/s) and turning to the left (rad/s): array (frames, 3).

    `features` (frames, 130): recognition features, 15 frames a second.
    """
    root = features[:, -4:].astype(np.float64) / (ROOT_WEIGHT * VELOCITY_SECONDS)
    return np.asarray(root[:, [0, 2, 3]])


def furthest(
    speeds: FloatArray,
    direction: str,
    turn: str = "",
    shown: NDArray[np.bool_] | None = None,
    fps: float = FEATURE_FPS,
    least: float = 0.0,
) -> tuple[float, int, int]:
    """How far some frames go in a direction, in least amounts, and the part [a, b) that does.

    `speeds` (frames, 3): those of ``speeds_of``, or of another rate `fps`. `turn`: How the action
    turns (``turning``). `shown` (frames,): frames that count; without it, all. `least`: Least
    amounts below which a stay in place is not looked for, which takes most of the time.

    >>> speeds = np.zeros((60, 3)); speeds[:30, 1], speeds[30:, 1] = 1.0, -0.45  # ahead, then back
    >>> furthest(speeds, "left")
    (0.0, 0, 0)
    >>> [round(number) for number in furthest(speeds, "backward")]
    [6, 30, 60]
    >>> furthest(np.zeros((60, 3)), IN_PLACE)
    (1.25, 0, 60)
    """
    if direction == IN_PLACE:
        counted = np.ones(len(speeds), bool) if shown is None else shown
        return _longest_stay(speeds, counted, fps, least)
    every = ways(speeds, direction, turn, fps)
    return max(largest_part(way if shown is None else way_while(way, shown)) for way in every)


def ways(
    speeds: FloatArray, direction: str, turn: str = "", fps: float = FEATURE_FPS
) -> list[FloatArray]:
    """The way of every frame in a direction, in least amounts, for each meaning: arrays (frames,).

    Parameters are those of ``furthest``. A direction has several where either side counts, or
    turning and travelling do. What stays in place has no way.
    """
    if direction in ("forward", "backward", "back"):
        sign = 1.0 if direction == "forward" else -1.0
        return [sign * _along(speeds, 1, fps) / fps / LEAST[direction]]
    if direction == "sideways":
        aside = _along(speeds, 0, fps) / fps
        return [sign * aside / LEAST[direction] for sign in (1.0, -1.0)]
    turned = lasting_turns(speeds, fps)
    least = SPUN if turn == "spin" else LEAST[direction]
    if direction in ("around", IN_A_CIRCLE):
        return [sign * turned / least for sign in (1.0, -1.0)]
    sign = 1.0 if direction == "left" else -1.0
    if turn:
        return [sign * turned / least]
    return [sign * turned / least, sign * _along(speeds, 0, fps) / fps / LEAST["sideways"]]


def way_while(way: FloatArray, shown: NDArray[np.bool_]) -> FloatArray:
    """The way of every frame where only some count: what is gone back in others still counts.

    >>> way_while(np.array([1.0, -0.5, 1.0]), np.array([True, False, False])).tolist()
    [1.0, -0.5, 0.0]
    """
    return np.where(shown, way, np.minimum(way, 0.0))


def lasting_turns(speeds: FloatArray, fps: float) -> FloatArray:
    """Turning to the left of every frame, rad, without turns on the spot that are taken back.

    `speeds` (frames, 3): those of ``furthest``.

    >>> back = np.zeros((90, 3)); back[30:38, 2], back[45:53, 2] = 1, -1
    >>> float(np.abs(lasting_turns(back, 15.0)).max())
    0.0
    """
    heading = np.concatenate([[0.0], np.cumsum(speeds[:, 2])]) / fps
    median = running_median(heading, 2 * round(LASTING * fps) + 1)
    moves = steady_speed(speeds, fps) > ON_THE_SPOT
    return np.asarray(np.where(moves, speeds[:, 2] / fps, np.diff(median)))


def share_of_full(amount: float, direction: str, turn: str = "") -> float:
    """Least amounts as a share of what is clear: 0.5 for the least amount, 1 for a clear one.

    >>> share_of_full(0.5, "left"), share_of_full(2.0, "left"), share_of_full(2.5 / 2.1, "around")
    (0.25, 1.0, 1.0)
    """
    if amount < 1.0:
        return amount / 2.0
    clearly = CLEARLY if turn == "spin" else _CLEARLY.get(direction, CLEARLY)
    return 0.5 + 0.5 * (amount - 1.0) / (clearly - 1.0)


def _longest_stay(
    speeds: FloatArray, shown: NDArray[np.bool_], fps: float, least: float
) -> tuple[float, int, int]:
    """The part of some run of frames that stays in a square, with its share of the run.

    Of runs of equal share the longest counts; short ones do not.
    """
    heading = np.cumsum(speeds[:, 2]) / fps
    steps = speeds[:, :2] @ np.array([1.0, 1j]) * np.exp(-1j * heading) / fps
    places = np.cumsum(steps)
    ground = np.column_stack([places.real, places.imag])
    found = [(0.0, 0, 0)]
    for start, end in runs(shown):
        if end - start < min(SHORTEST_STAY * fps, len(speeds)):
            continue
        shortest = max(int(least * (end - start) * LEAST[IN_PLACE]), 1)
        first, behind = _within_square(ground[start:end], shortest)
        amount = (behind - first) / ((end - start) * LEAST[IN_PLACE])
        found.append((amount, int(start) + first, int(start) + behind))
    return max(found, key=lambda one: (round(one[0], 3), one[2] - one[1]))


def _within_square(ground: FloatArray, shortest: int) -> tuple[int, int]:
    """The longest part [a, b) of a way on the ground, (frames, 2) in m, that stays in a square.

    It is empty if none of some length does.
    """
    first, low, high = _first_stay(ground, shortest), shortest, len(ground)
    if first is None:
        return 0, 0
    while low < high:  # a part of a part that stays stays too
        middle = (low + high + 1) // 2
        start = _first_stay(ground, middle)
        if start is None:
            high = middle - 1
        else:
            low, first = middle, start
    return first, first + low


def _first_stay(ground: FloatArray, n: int) -> int | None:
    """The first of n frames of a way on the ground that stay in a square; None: there are none."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    # window [i - n // 2, i - n // 2 + n)
    size = maximum_filter1d(ground, n, axis=0) - minimum_filter1d(ground, n, axis=0)
    starts = np.flatnonzero((size <= SQUARE).all(axis=1)) - n // 2
    starts = starts[(starts >= 0) & (starts + n <= len(ground))]
    return int(starts[0]) if len(starts) else None


def _along(speeds: FloatArray, axis: int, fps: float) -> FloatArray:
    """Speed along an axis (0: left, 1: ahead), 0 where it is slower than across: (frames,)."""
    steady = np.abs(means_around(speeds[:, :2], round(STEADY * fps)))
    return np.where(steady[:, axis] > steady[:, 1 - axis], speeds[:, axis], 0.0)


def largest_part(steps: FloatArray) -> tuple[float, int, int]:
    """The largest sum over a part of steps, and the part [a, b); zeros if no step is positive."""
    way = np.concatenate([[0.0], np.cumsum(steps)])
    gain = way - np.minimum.accumulate(way)
    behind = int(np.argmax(gain))
    # the last of equal minima, so that standing before the way does not belong to it
    first = behind - int(np.argmin(way[behind::-1]))
    return float(gain[behind]), first, behind
