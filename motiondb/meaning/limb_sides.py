"""Whether a capture moves the limb of the side that a question names ("wave with the left hand").

The share of a side is that of the squared speeds of its wrist (for words of the arm) or ankle (for
words of the leg), relative to the pelvis, in those of both sides. Of punches only the speed away
from the shoulder counts, since the other hand is often drawn back as quickly. A side below
``LEAST`` is not the one that moves; neither are both if one of them is. Who walks moves both alike,
so that this contradicts only what is clearly otherwise, and nothing where both limbs rest.

Which limbs an action raises or lowers, and at which place it holds a hand, is read here from its
words; whether a motion does so is told by its postures (:mod:`motiondb.meaning.postures`). A hand
is at a place whose distance from the palm is at most that of ``_NEAR`` ("hands on hips").
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import lru_cache
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, rotation
from motiondb.body.features import VELOCITY_SECONDS, VELOCITY_WEIGHT
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import OUT_AHEAD, OUT_ASIDE, SINGLE, as_said
from motiondb.records import Float32Array, FloatArray

LEAST = 1.0 / 3.0  # Smallest share of a limb that moves
LEAST_OF_BOTH = 0.15  # Smallest share of each of two limbs that move
RESTING = 0.1  # Root mean square of the speeds, m/s, below which a limb rests
LEGS = frozenset(("leg", "foot", "knee", "hip", "ankle", "toe", "heel", "thigh"))
PUNCHES = frozenset(("punch", "jab", "uppercut", "box", "hit", "thrust"))
_HOLDING_TEXT = "stand hop balance land lean rest support hang hold kneel"
HOLDING = frozenset(_HOLDING_TEXT.split())
"""Actions whose limb is the one that rests: who hops on the left leg may move the other."""
_ON_ONE_LEG = frozenset(
    ("hop", "stand", "balance", "spin", "rotate", "pirouette", "land", "takeoff")
)
_RAISES = frozenset(("raise", "lift", "up", "overhead"))
LOWERS = frozenset(("lower", "drop", "down", "put", "bring"))
PLAIN = frozenset(("hold", "put", "keep", "stretch", "throw", "stick"))
_PLACES_TEXT = {
    "head": "head face chin mouth cheek forehead ear nose eye hair lip brow",
    "chest": "chest heart",
    "back": "back",
    "floor": "floor ground",
    "other hand": "together clasp",
    "other elbow": "cross fold",
    "hip": "hip waist",
    "knee": "knee thigh lap",
    "foot": "foot toe ankle shin",
    "shoulder": "shoulder",
    "side": OUT_ASIDE,
    "front": OUT_AHEAD,
}
_PLACE_OF = {word: place for place, text in _PLACES_TEXT.items() for word in text.split()}
_OF_TWO = ("hip", "knee", "foot", "shoulder")  # Places of which there are a left and a right one
HAND_PLACES = (
    *(p for p in _PLACES_TEXT if p not in _OF_TWO),
    *map(" ".join, product(("left", "right"), _OF_TWO)),
)
"""Where a hand is measured to be: a bit of :func:`places_of_hands` each, twice."""
PLACES_ASKED = (*HAND_PLACES, *_OF_TWO)
_TOUCHES = frozenset(("touch", "scratch", "rub", "cover", "pat", "tap", "clutch", "feel"))
"""Verbs whose hand need not be said, but for those of ``_OF_FEET`` at the floor or a foot."""
_OF_FEET = frozenset(("tap", "pat", "cover"))  # "tap the foot", "cover the ground"
_PARTS = frozenset(("thumb", "finger", "shoulder"))  # Of arms, and raised without them
_HANDS = frozenset(("hand", "fist", "palm", "finger", "arm", "wrist"))
_BESIDE_TEXT = "rest place bring raise lift lean behind on up extend spread reach"
_BESIDE = frozenset(_BESIDE_TEXT.split())
PALM, FACE = 0.09, 0.06  # Metres from the wrist to the palm, and from the joint of the head up
BENT = 0.9  # Most share of an arm's length from shoulder to wrist, of a hand at the hip or the back
_NEAR = {
    "head": 0.24,
    "chest": 0.14,
    "back": 0.25,
    "floor": 0.12,
    "other hand": 0.13,
    "other elbow": 0.2,
    "hip": 0.14,
    "knee": 0.16,
    "foot": 0.17,
    "shoulder": 0.2,
}
"""Most metres from the palm to each place; from wrist to wrist of hands that are together."""
STRETCHED, LEVEL_ARM, OUT = 0.75, 0.5, 0.8
"""Share of an arm's length from shoulder to wrist, and of that distance upwards at most and to the
side or ahead at least, of an arm that is out to the side or in front."""


def limbs_to_measure(words: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """The sides of an action that belong to a limb, each with its limb.

    >>> limbs_to_measure(("wave", "left", "hand"))
    (('left', 'hand'),)
    >>> limbs_to_measure(("step", "left")), limbs_to_measure(("stand", "left", "leg"))
    ((), ())
    """
    if not HOLDING.isdisjoint(words):
        return ()
    pairs = pairwise(words)
    return tuple((side, limb) for side, limb in pairs if side in SIDES and limb in LIMBS)


def limb_held(words: Sequence[str]) -> tuple[str, ...]:
    """The side and the limb that bears an action: those of who hops on the left foot; () if none.

    >>> limb_held(("hop", "left", "foot")), limb_held(("kick", "left", "foot"))
    (('left', 'foot'), ())
    >>> limb_held(("stand", SINGLE, "leg"))
    ('theone', 'leg')
    """
    if _ON_ONE_LEG.isdisjoint(words):
        return ()
    found = [p for p in pairwise(words) if p[0] in ("left", "right", SINGLE) and p[1] in LEGS]
    return found[0] if found else ()


def hop_on(words: Sequence[str]) -> str:
    """The event of hops on the leg of a side, or on one, that an action names; "" if it names none.

    >>> hop_on(("hop", "left", "foot")), hop_on(("hop", SINGLE, "leg")), hop_on(("hop", "left"))
    ('hop left', 'hop one', '')
    """
    held = limb_held(words) if "hop" in words else ()
    return f"hop {as_said(held[0])}" if held else ""


def arm_raised(words: Sequence[str]) -> str | None:
    """The side, "left", "right", "both" or "" for any, of an action that raises an arm or a hand.

    >>> arm_raised(("raise", "left", "arm")), arm_raised(("hand", "overhead"))
    ('left', '')
    >>> arm_raised(("put", "both", "hand", "up")), arm_raised(("wave", "hand", "up"))
    ('both', None)
    """
    arms = _arms_of(words)
    rest = {*words} - _RAISES - PLAIN - SIDES - arms
    if _RAISES.isdisjoint(words) or not arms or (rest and "raise" not in words):
        return None
    return _side_of(words, arms)


def leg_raised(words: Sequence[str]) -> str | None:
    """The side, as of :func:`arm_raised`, of an action that raises a knee or a leg.

    >>> leg_raised(("raise", "left", "knee")), leg_raised(("high", "knee"))
    ('left', '')
    >>> leg_raised(("kick", "leg", "up")), leg_raised(("stand", "up", "leg"))
    (None, None)
    """
    legs = {"knee", "thigh", "leg"}.intersection(words)
    raised = not _RAISES.isdisjoint(words) or {"knee", "high"} <= {*words}
    if not raised or not legs or {*words} - _RAISES - PLAIN - SIDES - legs - {"high"}:
        return None
    return _side_of(words, legs)


def arm_lowered(words: Sequence[str]) -> str | None:
    """The side, as of :func:`arm_raised`, of an action that lowers an arm or a hand.

    >>> arm_lowered(("lower", "both", "arm")), arm_lowered(("put", "hand", "down"))
    ('both', '')
    >>> arm_lowered(("wave", "hand", "down")), arm_lowered(("left", "lower", "arm"))
    (None, None)
    """
    arms = _arms_of(words)
    lowers = not {"lower", "drop", "down"}.isdisjoint(words)
    lowers = lowers and ("lower", "arm") not in pairwise(words)  # which is the forearm
    if not arms or not lowers or {*words} - LOWERS - SIDES - arms:
        return None
    return _side_of(words, arms)


def hand_at(words: Sequence[str]) -> tuple[str, str] | None:
    """The side of the hand, or "any", and where it is, of an action that puts a hand somewhere.

    >>> hand_at(("both", "hand", "hip")), hand_at(("touch", "left", "knee", "right", "hand"))
    (('both', 'hip'), ('right', 'left knee'))
    >>> hand_at(("hand", "behind", "back")), hand_at(("arm", "cross")), hand_at(("touch", "toe"))
    (('any', 'back'), ('any', 'other elbow'), ('any', 'foot'))
    >>> hand_at(("hand", "fold")), hand_at(("wave", "hand", "head"))
    (('any', 'other hand'), None)
    >>> hand_at(("touch", "foot", "ground")), hand_at(("tap", "toe"))
    (None, None)
    >>> hand_at(("foot", "touch")), hand_at(("touch", "foot"))
    (None, ('any', 'foot'))
    >>> hand_at(("hand", "cross", "behind", "back")), hand_at(("arm", "fold", "across", "chest"))
    (('any', 'back'), ('any', 'other elbow'))
    """
    hands, named = _HANDS.intersection(words), [word for word in words if word in _PLACE_OF]
    joined = [word for word in named if _PLACE_OF[word].startswith("other")]
    if joined and {"behind", "back"} <= {*words}:  # "hands clasped behind the back"
        words = [word for word in words if word not in joined]
        named = ["back"]
    elif joined and {"chest", "across"} <= {*words}:  # "arms crossed across the chest"
        words, named = [word for word in words if word not in ("chest", "across")], joined
    if len(named) != 1 or not (hands or _TOUCHES.intersection(words)):
        return None
    place = _PLACE_OF[named[0]]
    if named[0] == "foot" and not hands and words[0] == "foot":  # "feet touch"
        return None
    if place in ("foot", "floor") and not (hands or (_TOUCHES - _OF_FEET).intersection(words)):
        return None
    if place == "other elbow" and "arm" not in hands:
        place = "other hand"  # "fold the hands"
    rest = {*words} - {*named} - SIDES - hands - _TOUCHES - PLAIN - _BESIDE
    is_meant = place.startswith("other") <= bool(hands) and (place == "back") <= ("behind" in words)
    if rest or not is_meant or (place in _OF_TWO and not _RAISES.isdisjoint(words)):
        return None  # "raise the arm and the knee"
    side = _side_of(words, named) if place in _OF_TWO else ""
    which = f"{side} {place}" if side in ("left", "right") else place
    return _side_of(words, hands) or "any", which


def places_of_hands(positions: FloatArray, facing: FloatArray) -> FloatArray:
    """Where the hands are: the bits of whole numbers, array (frames,).

    Of each hand, the left one first, a bit for each of :data:`HAND_PLACES`. `positions` (frames,
    21, 3), metres; `facing` (frames,): angle of the body about the vertical, rad.
    """
    at = {name: positions[:, n] for name, n in body.INDEX.items()}
    ahead = np.column_stack([np.sin(facing), np.zeros(len(facing)), np.cos(facing)])
    up = np.array([0.0, 1.0, 0.0])
    to_left = np.cross(up, ahead)
    places = {
        "head": at["head"] + FACE * rotation.normalize(at["head"] - at["neck"]),
        "chest": at["chest"] + 0.1 * ahead,
        "back": at["pelvis"] + 0.15 * up,
    }
    for of, name in (("l", "left"), ("r", "right")):
        places[f"{name} hip"] = at[f"{of}_hip"] + 0.08 * up
        places |= {f"{name} {joint}": at[f"{of}_{joint}"] for joint in ("knee", "shoulder")}
    bits = np.zeros(len(positions))
    for hand, (side, other) in enumerate((("l", "r"), ("r", "l"))):
        wrist, elbow, shoulder = (at[f"{side}_{joint}"] for joint in ("wrist", "elbow", "shoulder"))
        palm = wrist + PALM * rotation.normalize(wrist - elbow)
        near = {place: _length(palm - where) for place, where in places.items()}
        for of, name in (("l", "left"), ("r", "right")):
            ends = (_length(palm - at[f"{of}_{joint}"]) for joint in ("ankle", "toe"))
            near[f"{name} foot"] = np.minimum(*ends)
        near["floor"] = np.abs(palm[:, 1])
        near["other hand"] = _length(wrist - at[f"{other}_wrist"])
        near["other elbow"] = _length(palm - at[f"{other}_elbow"])
        long = _length(wrist - elbow) + _length(elbow - shoulder)
        reach = _length(wrist - shoulder)
        bent = reach < BENT * long
        out = rotation.normalize(wrist - shoulder)
        level = (reach > STRETCHED * long) & (np.abs(out[:, 1]) < LEVEL_ARM)
        ways = {"side": to_left if side == "l" else -to_left, "front": ahead}
        is_out = {name: level & ((out * way).sum(axis=1) > OUT) for name, way in ways.items()}
        behind = ((palm - at["pelvis"]) * ahead).sum(axis=1) < -0.05
        bent_at = {"left hip": bent, "right hip": bent, "back": bent & behind}
        for n, place in enumerate(HAND_PLACES):
            if place in is_out:
                is_at = is_out[place]
            else:
                is_at = near[place] < (_NEAR.get(place) or _NEAR[place.split()[1]])
            bits += (is_at & bent_at.get(place, True)) * 2.0 ** (n + hand * len(HAND_PLACES))
    return bits


def _length(vectors: FloatArray) -> FloatArray:
    """Lengths (n,) of vectors (n, 3)."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def hands_are_at(bits: FloatArray, side: str, place: str) -> NDArray[np.bool_]:
    """Frames in which the hand of a side, both or any, is at a place: array (frames,).

    `bits` (frames,): those of :func:`places_of_hands`. `side`, `place`: as of :func:`hand_at`.
    """
    asked = [n for n, one in enumerate(HAND_PLACES) if one == place or one.split()[-1] == place]
    numbers, n = bits.astype(np.int64), len(HAND_PLACES)
    left, right = (numbers & sum(1 << (k + hand * n) for k in asked) != 0 for hand in (0, 1))
    if side == "both" or place.startswith("other"):
        return np.asarray(left & right)
    return np.asarray({"left": left, "right": right}.get(side, left | right))


def _arms_of(words: Sequence[str]) -> set[str]:
    """The words of an action for an arm, or a part of one that goes up and down with it."""
    return {word for word in words if word in LIMBS and word not in LEGS | _PARTS}


def _side_of(words: Sequence[str], limbs: Collection[str]) -> str:
    """The first side that an action names of some limbs; "" if it names none."""
    return next((side for side, limb in pairwise(words) if side in SIDES and limb in limbs), "")


@lru_cache(256)
def without_sides(words: tuple[str, ...]) -> tuple[str, ...]:
    """The words of an action without the sides of limbs that are measured, and these limbs.

    >>> without_sides(("kick", "right", "leg")), without_sides(("right", "hand"))
    (('kick',), ('right', 'hand'))
    """
    if len(words) < 3:
        return words
    measured = set(limbs_to_measure(words))
    pairs = [tuple(pair) in measured for pair in pairwise(words)]
    of_side = [any(both) for both in zip([*pairs, False], [False, *pairs])]
    rest = tuple(word for word, is_of in zip(words, of_side) if not is_of)
    return rest or words


def speeds_of_limbs(features: Float32Array) -> FloatArray:
    """Squared speeds of ankles, of wrists, and of these outward, (m/s)^2: array (frames, 6).

    Of each the left one first. `features` (frames, 130): recognition features.
    """
    n = len(body.JOINTS)
    places, moving = (
        features[:, start * n : (start + 3) * n].astype(np.float64).reshape(len(features), n, 3)
        for start in (0, 3)
    )
    moving /= VELOCITY_WEIGHT * VELOCITY_SECONDS
    limbs = [body.INDEX[f"{side}_{joint}"] for joint in ("ankle", "wrist") for side in "lr"]
    relative = moving[:, limbs] - moving[:, :1]
    outward = outward_speeds(places, moving) ** 2
    return np.concatenate([(relative**2).sum(axis=2), outward], axis=1)


def limb_speeds(
    speeds: FloatArray | Float32Array, limb: str, action: Sequence[str] = ()
) -> FloatArray:
    """Squared speeds of the left and the right wrist or ankle, (m/s)^2: array (frames, 2).

    `speeds` (frames, 6): those of :func:`speeds_of_limbs`. `action`: the words that name the limb.
    """
    first = 0 if limb in LEGS else 2 if PUNCHES.isdisjoint(action) else 4
    return speeds[:, first : first + 2].astype(np.float64)


def outward_speeds(places: FloatArray, moving: FloatArray) -> FloatArray:
    """Speed of the wrists away from their shoulders, m/s, of places and velocities: (frames, 2)."""
    wrists, shoulders = (
        [body.INDEX[f"{side}_{joint}"] for side in "lr"] for joint in ("wrist", "shoulder")
    )
    along = rotation.normalize(places[:, wrists] - places[:, shoulders])
    apart = moving[:, wrists] - moving[:, shoulders]
    return np.asarray(np.maximum((apart * along).sum(axis=2), 0.0))


def is_at_rest(speeds: FloatArray) -> bool:
    """Whether the limbs of both sides rest; `speeds` (frames, 2): those of ``limb_speeds``."""
    return not len(speeds) or float(speeds.mean(axis=0).max()) < RESTING**2


def side_amount(speeds: FloatArray, side: str) -> float:
    """How clearly the limb of a side moves: 1 for the least share, 2 for twice as much.

    `speeds` (frames, 2): those of ``limb_speeds``. Where both limbs rest, nothing speaks against
    the side, and the amount is 1.

    >>> left = np.tile([1.0, 0.25], (30, 1))
    >>> [round(side_amount(left, side), 3) for side in ("left", "right", "both")]
    [2.4, 0.6, 1.333]
    >>> side_amount(np.full((30, 2), 1e-4), "left")
    1.0
    """
    if is_at_rest(speeds):
        return 1.0
    left, right = speeds.mean(axis=0)
    share = float(left / (left + right))
    if side == "both":
        return min(share, 1.0 - share) / LEAST_OF_BOTH
    return (share if side == "left" else 1.0 - share) / LEAST


def moves_otherwise(speeds: FloatArray, side: str) -> bool:
    """Whether the limb of another side moves, or one where both are asked for.

    `speeds` (frames, 2): those of ``limb_speeds``.

    >>> left = np.tile([1.0, 0.1], (30, 1))
    >>> [moves_otherwise(left, side) for side in ("left", "right", "both")]
    [False, True, True]
    """
    return side_amount(speeds, side) < 1.0


def say_other_limb(side: str, limb: str) -> str:
    """What a motion does instead that does not move the limb of a side.

    >>> say_other_limb("left", "hand"), say_other_limb("both", "arm")
    ('moves the right hand, not the left', 'moves one arm, not both')
    """
    if side == "both":
        return f"moves one {limb}, not both"
    return f"moves the {'right' if side == 'left' else 'left'} {limb}, not the {side}"
