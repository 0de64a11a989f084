"""What a file does not say, or says wrongly: the axis that is up, sides, units, frame rates.

A file's word holds, then the convention of its format. What neither says is found from the motion
over the whole take, and told in a note; whoever adds the file can overrule it.

**Up** is one of six axes. Each gets a score from what gravity does: the body's lowest points along
the axis stand still, at one height (``_STANDS``); that height is near 0, where the floor mostly
lies (``_FLOOR``); the body is upright along it for most of the take (``_POSTURE``), and in its rest
pose (``_REST``); it is the usual one of the format (``_USUAL``). A posture alone decides nothing: a
person may lie, sit or stand on the hands.

**Sides** are known without their names: toes point ahead, and knees bend ahead. Where both say that
left is right, the names of the sides are exchanged, or the file's axes are left-handed.

**Units** in use differ by a factor of 2.2 or more, so the size of the body tells them apart: legs
between 0.56 m and 1.23 m (1.15 m to 2.5 m of height) are read rightly. A small child in centimetres
may be mistaken for a person in inches, with a note from 0.85 m of height on. Where root and bones
have different units, the feet slide.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from motiondb.body import body, rotation
from motiondb.body.joint_names import joint_map
from motiondb.body.kinematics import is_below
from motiondb.errors import SkeletonError
from motiondb.records import Clip, FloatArray, Skeleton

_I = body.INDEX
UPS = ("y", "z", "x", "-y", "-z", "-x")
"""The axes that may point up."""
_TURNS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {"y": ("X", 0.0), "z": ("X", -90.0), "x": ("Z", 90.0)}
    | {"-y": ("X", 180.0), "-z": ("X", 90.0), "-x": ("Z", -90.0)}
)  # The axis and the degrees of the turn after which y is up
_STANDS, _FLOOR, _POSTURE = 2.0, 1.0, 1.0
"""Weights of what the motion shows."""
_MOSTLY, _REST, _USUAL = 0.6, 0.8, 0.5
"""Weights of what is mostly so: floors at 0, rest poses that stand up, the axis of the format. They
choose an axis, but make none certain."""
_SURE = 0.8
"""Difference to the next axis, in all and in what the motion shows, above which an axis is not
doubted: in 544 real captures the motion alone shows .83 to 3.9."""
_FLOOR_WITHIN = 0.06  # Metres from 0 of a floor at 0: real feet reach .07
_OFF_FLOOR, _FAR = 0.12, 0.35
"""Metres from 0 of a floor that is not at 0 (real ones are within .10, or where the hips start at
0 at -1); and of one that is certainly not, if the hips start elsewhere."""
_HELD_LESS = 0.2
"""By this share of the frames less a body must stand along other axes if its floor is not at 0, and
if it is to decide for other captures."""
_HELD = 0.5  # Share of the frames that a body stands on something, below which it flies
_STILL, _NEAR, _LEVEL = 0.3, 0.1, 0.15
"""A point that carries the body moves slower than this (m/s), is this near to the lowest point of
its frame, which is this near to the take's ground (metres)."""
_SAMPLES = 3000  # Frames that are looked at: more change no score
_UPRIGHT = 0.9  # Cosine with an axis above which a rest pose stands along it
_AHEAD, _BEND, _STRAIGHT = -0.3, -0.01, 0.01
"""Medians below which toes point backwards (cosine), and knees bend backwards or stay straight
(shares of the leg). Of 565 real captures one of the toes is at .65 or more, the knees of three that
stand at -.04 to -.01, of the others above 0."""
_BENT_BACK = 0.05
"""Share of the leg that both knees are behind it where they bend backwards: the straighter of both
is at -.0015 at least in 130 real captures, and one bends ahead by .027 at some time in all.
"""
_UNLIKE, _LONGER = 1.25, 1.5
"""Ratios of the lengths of a bone on both sides, and of a shin or forearm to the bone above: 1.19
and 1.24 at most in 565 real captures."""
_NO_LENGTH = 1e-6  # Metres of a bone below which its joints are at one place
_CROSSED = MappingProxyType(
    {"knee": -0.02, "ankle": -0.13, "shoulder": -0.02, "elbow": -0.02, "wrist": -0.05}
)
"""Metres by which a left joint is right of the other in the median where names are exchanged: in
540 real captures knees, shoulders, elbows and wrists are at least .06 m left, ankles reach -.12."""
_BONES = (
    *(("hip", "knee"), ("knee", "ankle"), ("ankle", "toe")),
    *(("shoulder", "elbow"), ("elbow", "wrist")),
)
_TOE_HEIGHT = 0.02  # Metres of the toe joint over the ground in a flat stance
_SECONDS = 0.5  # Of feet on the ground: less shows no steps
_STEP, _ALIKE, _SLIDES = 0.5, 0.9, (0.9, 4.0)
"""Metres a second that feet on the ground move past the hips while a body steps; correlation of
this with the travel; and ratios of both outside which their units differ. Of 540 real captures
those with such a correlation have ratios of 1.0 (walks) to 2.9 (runs and jumps)."""
_SINK, _SINKS = 0.05, (0.8, (0.5, 1.6))
"""Metres a second by which legs bend; correlation of this with the hips' way down, and ratios of
both. Of 540 real captures those with such a correlation have ratios of .63 to 1.29."""
_BOBS = 0.15  # Of the legs' rise and sink that of the hips: .32 or more in 540 real captures
_SWING, _RISE, _PINNED, _STANDS_UP = 0.2, 0.015, 0.25, 0.75
"""Metres that both feet move past the hips; metres that hips over them rise and sink less, and the
share of the feet's way that they move less, where the root is too small: of 358 real captures in
which both feet swing all rise more, and move .53 or more. Hips are over the feet by this share of
the legs: not those of a person who sits or lies."""
_NO_WAY = 0.005  # Of the way that feet carry the root, below which it does not travel
_GLIDES, _OUTRUNS = 1.5, 2.0
"""Metres a second of the hips, faster than a body glides ahead; and ratio to the faster foot past
them, in the medians: 1.29 at most in 540 real captures."""
_RADIANS, _NO_ANGLE, _TRAVELS, _MOVED = 3.2, 0.1, 0.3, 1e-3
"""Degrees that no joint exceeds where angles in radians are read as degrees (a half turn is 3.14);
degrees that are none but rounding; metres that the root travels, and a joint in a body that moves
without angles."""

INCH = 0.0254  # Metres
UNITS: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "cmu": INCH / 0.45, "inch": INCH, "cm": 0.01, "mm": 0.001}
)  # Metres per unit. "cmu" is the CMU database's own scale: inches divided by 0.45
TYPICAL_LEG = 0.83
"""Hip to ankle of an adult, metres: half of a height of 1.70 m, less the height of the ankle."""
TYPICAL_CHAIN = 1.15
"""Longest chain of bones from the root (to a hand or a foot) of an adult, metres."""
_USUAL_SIZES = (1 / 1.6, 1.25)
"""Ratios to the typical size outside which a body is noted. Legs of 0.52 m to 1.04 m pass: this
covers adults up to 2.1 m and children from about six years. A smaller child in centimetres would
be a giant in inches; 540 real captures are at .91 to 1.18."""
_DOUBTFUL_UNIT = 2.2
"""A body larger or smaller than typical by this ratio is not believed to be in the unit that its
file names: the units in use differ by more."""
_MEANT = (0.001, 0.01, INCH, 0.3048, 1.0)  # Metres of the units that a file may mean
_ABSURD = 1e3  # Ratio to the typical size of what is no body, not even of an animal
_SCALED = (1e-4, 1e-3, 1e-2, 0.1, 10.0, 100.0, 1e3, 1e4)
"""Factors by which lengths may be scaled once too often or too seldom."""


_UNITS_DIFFER = (
    "The root may have another unit than the bones. Export the capture again with one unit."
)
_ADVICE = "Give the axis (--up) if this is wrong."
AS_OTHERS = "{up} is taken for up, as in other captures of this skeleton. " + _ADVICE
"""The note where captures of one skeleton decided together."""


@dataclass(frozen=True)
class Found:
    """The axis that is up, and how it was found."""

    up: str  # One of ``UPS``
    is_sure: bool
    scores: tuple[float, ...]  # Of every axis of ``UPS``
    usual: str = "y"  # The axis of the format
    rest: str = ""  # The axis along which the rest pose stands
    notes: tuple[str, ...] = ()
    is_by_motion: bool = False
    """Sure, and the body stands still along no other axis: these captures of a skeleton decide."""


def to_y_up(up: str) -> FloatArray:
    """Return the rotation that turns a world in which an axis is up into one with y up.

    >>> rotation.rotate(to_y_up("z"), np.array([1.0, 2.0, 3.0])).round(9).tolist()
    [1.0, 3.0, -2.0]
    """
    axis, degrees = _TURNS[up]
    return rotation.from_euler([degrees], axis)


def find_up(
    points: FloatArray, fps: float, *, stated: str = "", usual: str = "y", rest: str = ""
) -> Found:
    """Find the axis that is up for joints (frames, 21, 3), metres, NaN where they are missing.

    `stated`: the axis that a file or a person names: it holds, and a contradiction is noted.
    `usual`: the axis that the format has where it says nothing. `rest`: the axis along which the
    rest pose stands, "" for none.
    """
    held, lows = _held(points, fps)
    stands = upright(points)
    hips = points[:, [_I["l_hip"], _I["r_hip"]]].mean(axis=1)
    is_at_origin = bool((np.linalg.norm(hips[:1], axis=1) < _FAR).any())
    # Where places are relative to the root nothing carries the body, and a head may be still
    is_relative = _is_relative(points, hips)
    shown, scores = dict[str, float](), dict[str, float]()
    for up in UPS:
        floor = math.exp(-0.5 * min(abs(lows[up]) / _FLOOR_WITHIN, 9.0) ** 2)
        floor, stood = (0.0, 0.0) if is_relative else (floor, held[up])
        shown[up] = _STANDS * stood + _FLOOR * floor + _POSTURE * max(stands[up], 0.0)
        usually = _REST * (rest == up) + _USUAL * ((stated or usual) == up)
        scores[up] = shown[up] + _MOSTLY * floor + usually
    best = max(UPS, key=lambda up: scores[up])
    is_sure = not is_relative and scores[best] - sorted(scores.values())[-2] >= _SURE
    is_on_floor = abs(lows[best]) < _OFF_FLOOR
    for up in UPS:
        is_off_floor = is_on_floor and abs(lows[up]) > _FAR and not is_at_origin
        if up != best and not is_off_floor:
            is_sure &= shown[best] - shown[up] >= _SURE
            is_sure &= is_on_floor or held[up] < held[best] - _HELD_LESS
    if held[best] < _HELD and stands[best] < _UPRIGHT:  # in the air, as in hops
        is_sure &= max(stands.values()) < _UPRIGHT
    is_moved = is_sure and all(held[up] < held[best] - _HELD_LESS for up in UPS if up != best)
    if stated:
        doubt = f"{stated} is up, as it was said; the body moves as if {best} were."
        notes = (doubt,) if is_sure and best != stated else ()
        return Found(stated, True, tuple(scores.values()), stated, rest, notes)
    found = Found(best, is_sure, tuple(scores.values()), usual, rest, is_by_motion=is_moved)
    return replace(found, notes=up_notes(found))


def _is_relative(points: FloatArray, hips: FloatArray) -> bool:
    """Whether the root stays near the origin while feet swing, as where places are relative."""
    ankles = points[:, [_I["l_ankle"], _I["r_ankle"]]].reshape(len(points), -1)
    known = np.isfinite(ankles).all(axis=1)
    if not known.any() or np.ptp(ankles[known], axis=0).max() < _SWING:
        return False
    roots = (points[known, _I["pelvis"]], hips[known])
    return any(
        np.isfinite(root).all()
        and np.linalg.norm(root[0]) < _FAR
        and np.ptp(root, axis=0).max() < _MOVED
        for root in roots
    )


def up_notes(found: Found) -> tuple[str, ...]:
    """Say which axis was taken for up where this was a guess."""
    if found.is_sure and found.up == found.usual:
        return ()
    if not found.is_sure:
        why = "the motion does not show for certain which axis is up"
    elif found.rest == found.up:
        why = "the skeleton's rest pose and the body stand along it"
    else:
        why = "what carries the body is lowest along it"
    return (f"{found.up} is taken for up: {why}. {_ADVICE}",)


def pooled(found: Sequence[Found]) -> tuple[str, bool]:
    """Return the axis that is up for captures of one skeleton, and whether this is sure.

    Those that are sure by their motion decide, else those that are sure; without any, what speaks
    for all together.
    """
    moved = [each for each in found if each.is_by_motion]
    sure = Counter(each.up for each in moved or found if each.is_sure)
    if sure:
        return sure.most_common(1)[0][0], True
    together = np.mean([each.scores for each in found], axis=0)
    second, best = np.sort(together)[-2:]
    return UPS[int(together.argmax())], bool(best - second >= _SURE)


def rest_up(points: FloatArray) -> str:
    """Return the axis along which a rest pose (21, 3) stands; "" for one that does not stand."""
    hips, ankles = (points[[_I[f"l_{j}"], _I[f"r_{j}"]]].mean(axis=0) for j in ("hip", "ankle"))
    legs, trunk = hips - ankles, points[_I["neck"]] - hips
    size = np.linalg.norm(legs) * np.linalg.norm(trunk)
    if not size > 0.0 or legs @ trunk < 0.5 * size:  # collapsed, or lying folded
        return ""
    values = _axis_values((legs + trunk) / np.linalg.norm(legs + trunk))
    best = max(values, key=lambda up: values[up])
    return best if values[best] > _UPRIGHT else ""


def _axis_values(way: FloatArray) -> dict[str, float]:
    """Return what a vector (3,) has along each axis of ``UPS``."""
    x, y, z = np.nan_to_num(way).tolist()
    return dict(zip(UPS, (y, z, x, -y, -z, -x)))


def upright(points: FloatArray) -> dict[str, float]:
    """Return the cosine with each axis of the way from feet to neck; joints (frames, 21, 3)."""
    way = points[:, _I["neck"]] - points[:, [_I["l_ankle"], _I["r_ankle"]]].mean(axis=1)
    known = np.isfinite(way).all(axis=1)
    way = rotation.normalize(way[known]) if known.any() else np.zeros((1, 3))
    return _axis_values(np.median(way, axis=0))


def _held(points: FloatArray, fps: float) -> tuple[dict[str, float], dict[str, float]]:
    """For each axis the share of frames in which still points carry the body, and its ground."""
    known = np.asarray(np.isfinite(points).all(axis=2))
    joints = known.mean(axis=0) > 0.5  # roles that the skeleton lacks are all NaN
    frames = known[:, joints].all(axis=1)
    points = points if frames.all() else points[frames]
    points = points if joints.all() else points[:, joints]
    if points.size == 0:
        return dict.fromkeys(UPS, 0.0), dict.fromkeys(UPS, 0.0)
    lag = min(max(1, round(fps / 15.0)), len(points) - 1)
    first = np.arange(0, len(points) - lag, max(1, lag, len(points) // _SAMPLES))
    if lag == 0:
        first = np.zeros(1, dtype=np.int64)
    speed = np.linalg.norm(points[first + lag] - points[first], axis=-1) * fps / max(lag, 1)
    places = (points[first] + points[first + lag]) / 2.0
    shares, lows = {}, {}
    for up in UPS:
        heights = places[..., "xyz".index(up[-1])] * (-1.0 if up[0] == "-" else 1.0)
        low = heights.min(axis=1)
        ground = float(np.percentile(low, 5))
        carries = (heights < low[:, None] + _NEAR) & (speed < _STILL)
        shares[up] = float(np.mean(carries.any(axis=1) & (low < ground + _LEVEL)))
        lows[up] = ground
    return shares, lows


def side_notes(points: FloatArray, has_toes: bool) -> tuple[str, ...]:
    """Note sides whose names contradict the body; joints (frames, 21, 3), y up."""
    left = points[:, _I["l_hip"]] - points[:, _I["r_hip"]]
    left = rotation.normalize(left)
    for part, least in _CROSSED.items():
        across = points[:, _I[f"l_{part}"]] - points[:, _I[f"r_{part}"]]
        if _median(across, left) < least:
            return (
                f"The left {part} is right of the right one for most of the take: the names of "
                f"the {part}s, or of the hips, look exchanged. Name them with --joint-map, or give "
                "--swap-sides.",
            )
    lost = [
        np.linalg.norm(points[:, _I[f"{a}_toe"]] - points[:, _I[f"{a}_ankle"]], axis=-1)
        - np.linalg.norm(points[:, _I[f"{a}_toe"]] - points[:, _I[f"{b}_ankle"]], axis=-1)
        for a, b in ("lr", "rl")
    ]
    if has_toes and min(float(np.nanmedian(further)) for further in lost) > 0.0:
        return (
            "Both toes are nearer to the other ankle for most of the take: the names of the toes "
            "look exchanged. Name them with --joint-map, or rename the markers.",
        )
    if unlike := _unlike_bones(points, has_toes):
        return (
            f"The way {unlike}: names of joints or markers look exchanged. Name them with "
            "--joint-map, or rename the markers, if this is wrong.",
        )
    toes, knees = [], []
    for side in "lr":
        hip, knee, ankle, toe = (
            points[:, _I[f"{side}_{part}"]] for part in ("hip", "knee", "ankle", "toe")
        )
        leg = hip - ankle
        size = np.linalg.norm(leg, axis=-1, keepdims=True)
        toes.append(_median(rotation.normalize(toe - ankle), _ahead(left, knee - ankle)))
        bend = np.sum((knee - (hip + ankle) / 2.0) / size * _ahead(left, leg), axis=-1)
        bend = bend[np.isfinite(bend)]
        knees.append(np.percentile(bend, [2, 50, 98]) if len(bend) else np.zeros(3))
    low, middle, high = np.max(knees, axis=0).tolist()
    if low < -_BENT_BACK and high < _BENT_BACK and has_toes and max(toes) > _AHEAD:
        return (
            "Both knees bend backwards though toes point ahead: their angles have the other sign, "
            "or belong to other axes or another model. Export the capture again.",
        )
    if middle > (_STRAIGHT if has_toes else _BEND) or (has_toes and max(toes) > _AHEAD):
        return ()
    return (
        "Knees bend and toes point backwards for the sides that the joints name. Either "
        "the axes are left-handed (--mirror-world), or the names of left and right are exchanged "
        "(--swap-sides): as all sides agree, the motion alone cannot show which.",
    )


def _unlike_bones(points: FloatArray, has_toes: bool) -> str:
    """Say which bone differs from that on the other side, or is too long for the one above it."""
    upper = math.inf
    for above, below in _BONES if has_toes else [bone for bone in _BONES if bone[1] != "toe"]:
        ways = (points[:, _I[f"{s}_{above}"]] - points[:, _I[f"{s}_{below}"]] for s in "lr")
        left, right = (float(np.nanmedian(np.linalg.norm(way, axis=1))) for way in ways)
        if max(left, right) > _UNLIKE * min(left, right):
            if min(left, right) < _NO_LENGTH:
                side = "left" if left < right else "right"
                return (
                    f"from {above} to {below} has no length on the {side} (a joint may be missing)"
                )
            return (
                f"from {above} to {below} is {left / right:.2g} times as long on the left as on "
                "the right"
            )
        if below in ("ankle", "wrist") and min(left, right) > _LONGER * upper:
            return f"from {above} to {below} is much longer than the bone above it on both sides"
        upper = max(left, right)
    return ""


def _ahead(left: FloatArray, up: FloatArray) -> FloatArray:
    """Return unit vectors (frames, 3) ahead of a body that has these on its left and above."""
    return rotation.normalize(np.cross(left, up))


def _median(values: FloatArray, along: FloatArray) -> float:
    """Return the median of vectors (frames, 3) along unit vectors; 0 where none is known."""
    products = np.sum(values * along, axis=-1)
    products = products[np.isfinite(products)]
    return float(np.median(products)) if len(products) else 0.0


def travel_notes(points: FloatArray, fps: float, leg_length: float) -> tuple[str, ...]:
    """Note feet that slide as if the root had another unit; joints (frames, 21, 3), y up, metres.

    While a foot stands, it moves past the hips as fast as these move ahead: compared second by
    second, since one foot or the other stands for most of a walk. Legs that bend let the hips sink.
    """
    lag = max(1, round(fps / 15.0))
    points = points[np.isfinite(points).all(axis=(1, 2))] * (body.LEG_LENGTH / leg_length)
    if len(points) <= lag:
        return ()
    hips = points[:, 0]
    feet = points[:, [_I["l_ankle"], _I["r_ankle"]]]
    toes = points[:, [_I["l_toe"], _I["r_toe"]], 1]
    heights = np.minimum(feet[..., 1] - body.ANKLE_HEIGHT, toes - _TOE_HEIGHT)
    below = heights - hips[:, 1:2]
    lower = np.maximum(below[lag:], below[:-lag]).argmin(axis=1)[:, None]

    def step(places: FloatArray) -> FloatArray:
        return (places[lag:] - places[:-lag]) * fps / lag

    def differs(
        travel: FloatArray, past: FloatArray, like: float, usual: tuple[float, float]
    ) -> str:
        own, both, steps = (
            np.sum(a * b) for a, b in ((travel, travel), (travel, past), (past, past))
        )
        is_alike = both > like * math.sqrt(own * steps) > 0.0
        return "" if not is_alike or usual[0] < both / steps < usual[1] else f"{both / steps:.2g}"

    swings = step(feet - hips[:, None])
    flat = step(hips)[:, [0, 2]]
    speed = float(np.median(np.linalg.norm(flat, axis=-1)))
    swing = float(np.median(np.linalg.norm(swings[..., [0, 2]], axis=-1).max(axis=1)))
    sinks = -np.take_along_axis(step(below), lower, axis=1)[:, 0]
    is_glide = speed < _GLIDES and float(np.linalg.norm(flat.mean(axis=0))) > speed / 2.0
    slides = speed > max(_TRAVELS, _OUTRUNS * swing) and swing > 0.0 and not is_glide
    ratio = f"{speed / swing:.2g}" if slides else ""
    rises = step(hips[:, 1])
    if not ratio and np.sqrt(np.mean(sinks**2)) > _SINK:
        ratio = differs(rises, sinks, *_SINKS)
    level = np.maximum(heights[lag:], heights[:-lag]).min(axis=1)
    stands = np.flatnonzero(level < np.percentile(heights.min(axis=1), 5) + _NEAR)
    if not ratio and len(stands) >= _SECONDS * fps:
        past = -np.take_along_axis(swings, lower[..., None], axis=1)[:, 0]
        both = np.stack([step(hips), past], axis=1)[..., [0, 2]]
        seconds = np.array_split(both[stands], max(1, round(len(stands) / fps)))
        pairs = np.array([second.mean(axis=0) for second in seconds])
        walks = np.linalg.norm(pairs[:, 1], axis=1) > _STEP
        if walks.mean() > 0.5:
            ratio = differs(pairs[walks, 0], pairs[walks, 1], _ALIKE, _SLIDES)
            is_fixed = speed < _BOBS * swing and np.std(rises) < _BOBS * np.std(sinks)
            if not ratio and is_fixed and np.std(sinks) > _SINK:
                ratio = f"{speed / swing:.1g}"
    if (ratio and float(ratio) < _NO_WAY) or (not ratio and _is_pinned(hips, feet - hips[:, None])):
        return (
            "The hips stay where they are while both feet swing below them: places may be relative "
            "to the root, or it has another unit than the bones. Export the way of the root, too.",
        )
    if not ratio:
        return ()
    return (
        f"The root travels {ratio} times as far as the feet carry it: they slide. {_UNITS_DIFFER}",
    )


def _is_pinned(hips: FloatArray, feet: FloatArray) -> bool:
    """Say whether hips rest over both feet, which swing; places of the feet from the hips."""

    def extent(places: FloatArray) -> FloatArray:
        low, high = np.percentile(places, [5, 95], axis=0)
        return np.asarray(high - low)

    swing = float(extent(feet).max(axis=1).min())
    across, rise, along = extent(hips)
    stands = -float(np.median(feet[..., 1].min(axis=1))) > _STANDS_UP * body.LEG_LENGTH
    return bool(stands and swing > _SWING and rise < _RISE and max(across, along) < _PINNED * swing)


def angle_notes(clip: Clip) -> tuple[str, ...]:
    """Note a clip of which no joint turns, but for less than angles in radians do."""
    cosines = np.abs(clip.local_rotations[..., 0]).min(initial=1.0)
    turned = math.degrees(2.0 * math.acos(min(float(cosines), 1.0)))
    travel = np.ptp(clip.root_positions, axis=0).max(initial=0.0)
    moved = clip.joint_positions
    turns = np.ptp(clip.local_rotations, axis=0).max(initial=0.0)
    places = 0.0 if moved is None else np.ptp(moved[:, 1:], axis=0).max(initial=0.0)
    if clip.n_frames > 1 and max(turns, travel, places) < _MOVED:
        return ("Nothing moves in the whole take. Export it again if it is more than a pose.",)
    if places > _MOVED:
        return ()  # a motion of positions alone
    if turned >= _RADIANS or (turned < _NO_ANGLE and travel < _TRAVELS):
        return ()
    return (
        f"No joint turns by more than {turned:.2g} degrees in the whole take, and the root travels "
        f"{travel:.2g} m: the angles may be in radians, or missing. Export them in degrees.",
    )


def find_unit(
    skeleton: Skeleton, joint_positions: FloatArray | None = None
) -> tuple[float, tuple[str, ...]]:
    """Estimate the length unit of a skeleton from the size of its body, with notes."""
    size, typical = body_size(skeleton, _bone_lengths(skeleton, joint_positions))
    if not 1e-9 < size < 1e9:
        return 1.0, ("The skeleton has no size; its unit is taken to be the metre.",)
    unit = min(UNITS.values(), key=lambda metres: abs(math.log(size * metres / typical)))
    ratio = size * unit / typical
    if not _USUAL_SIZES[0] < ratio < _USUAL_SIZES[1]:
        return unit, (
            f"The length unit is a guess ({unit:.4g} m): the body would be {ratio:.2g} times "
            "the usual size. Give the unit if it matters.",
        )
    return unit, ()


def checked_unit(unit: float, size: float, typical: float) -> tuple[float, tuple[str, ...]]:
    """Return the unit that a file names, or one that makes a body of this size a person's.

    `size`: of the body, in file units; `typical`: of an adult, metres.
    """
    ratio = size * unit / typical
    if not 0.0 < ratio < math.inf or fits(ratio):
        return unit, ()
    likely = (*_MEANT, *(unit * factor for factor in _SCALED))
    meant = min(likely, key=lambda metres: abs(math.log(size * metres / typical)))
    if not fits(size * meant / typical):
        is_absurd = not 1 / _ABSURD < ratio < _ABSURD
        return typical / size if is_absurd else unit, (
            f"In the file's unit ({unit:.4g} m) the body is {ratio:.2g} times the usual size, and "
            f"no other unit fits{'; the usual size is taken' * is_absurd}. Give the unit if it is "
            "wrong.",
        )
    return meant, (
        f"The file says that its unit is {unit:.4g} m; the body would be {ratio:.2g} times the "
        f"usual size, so {meant:.4g} m is taken. Give the unit if it is wrong.",
    )


def fits(ratio: float) -> bool:
    """Say whether a body that is larger than an adult by a ratio may have the unit it is in."""
    return 1 / _DOUBTFUL_UNIT < ratio < _DOUBTFUL_UNIT


def asked_unit_notes(clip: Clip) -> tuple[str, ...]:
    """Note a body, in a unit that was asked for, that is no person's."""
    lengths = _bone_lengths(clip.skeleton, clip.joint_positions)
    size, typical = body_size(clip.skeleton, lengths)
    if fits(size / typical):
        return ()
    return (
        f"In the unit that was asked for ({clip.unit:.4g} m) the body is {size / typical:.2g} "
        "times the usual size.",
    )


def _bone_lengths(skeleton: Skeleton, joint_positions: FloatArray | None) -> FloatArray:
    """Return the length of the bone of each joint, file units, in the median of some frames."""
    offsets = skeleton.offsets
    if joint_positions is not None:
        offsets = np.median(joint_positions[:: max(1, len(joint_positions) // 100)], axis=0)
    return np.asarray(np.linalg.norm(offsets, axis=-1))


def body_size(skeleton: Skeleton, lengths: FloatArray) -> tuple[float, float]:
    """Return the size of the body in file units, and the same size of an adult in metres."""
    try:
        roles = joint_map(skeleton)
    except SkeletonError:
        roles = {}
    chains = _chain_lengths(skeleton, lengths)
    ways = [(roles[f"{side}_ankle"], roles[f"{side}_hip"]) for side in ("lr" if roles else "")]
    legs = [chains[a] - chains[h] for a, h in ways if h >= 0 and is_below(skeleton.parents, a, h)]
    if any(leg > 0.0 for leg in legs):
        return float(np.mean([leg for leg in legs if leg > 0.0])), TYPICAL_LEG
    ends = [chains[joint] + math.hypot(*offset) for joint, offset in skeleton.end_sites]
    return max([*chains, *ends]), TYPICAL_CHAIN


def _chain_lengths(skeleton: Skeleton, lengths: FloatArray) -> list[float]:
    """Length of the bones from the root to every joint; parents come before children."""
    chains: list[float] = []
    for parent, length in zip(skeleton.parents.tolist(), lengths.tolist()):
        chains.append(chains[parent] + length if parent >= 0 else 0.0)
    return chains
