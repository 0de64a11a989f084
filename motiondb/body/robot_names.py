"""Which link of a robot stands at which joint of the body, by its name.

The names of links and hinges say the side and the part: ``left_hip_pitch_joint``, ``LHipYaw``,
``Shank_Left``, ``l_leg_kny``, ``arm_left_4_link``. Where a robot has several hinges for one joint,
the joint's centre is at the last one that does not turn about the limb (yaw) for hips and
shoulders, at the last one for ankles and wrists, and at the one nearest to the middle of the limb
for knees and elbows: an upper arm may turn about itself by a hinge that is called elbow, too.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from motiondb.body.kinematics import is_below
from motiondb.records import FloatArray, Skeleton

_PARTS = MappingProxyType(
    {
        "hip": ("hip", "hpx", "hpy", "hpz", "thigh", "upleg", "upperleg", "femur"),
        "knee": ("knee", "kny", "shank", "shin", "calf", "tibia", "lowerleg"),
        "ankle": ("ankle", "ank", "akx", "aky", "talus", "foot", "toe"),
        "toe": ("toe", "toes", "toebase"),
        "shoulder": ("shoulder", "sho", "shx", "shy", "shz", "upperarm", "humerus"),
        "elbow": ("elbow", "el", "elx", "ely", "elz", "forearm", "lowerarm", "ulna"),
        "wrist": ("wrist", "wrx", "wry", "wrz", "hand", "palm"),
    }
)  # Part -> words for it, the surest first
_NUMBERED = MappingProxyType(
    {"leg": ("hip", "hip", "hip", "knee", "ankle", "ankle")}
    | dict.fromkeys(("arm", "zarm"), (*("shoulder",) * 3, "elbow", *("wrist",) * 3))
)  # Limb -> the parts of its hinges, which have numbers
_ABOUT_LIMB = frozenset({"yaw", "hpz", "twist", "rz"})
_NOT = frozenset(
    [
        "thumb",
        "index",
        "middle",
        "ring",
        "pinky",
        "little",
        "finger",
        "gripper",
        "mimic",
        "imu",
        "camera",
    ]
)
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+")
_LOW, _HIGH = 0.75, 1.7
"""Where a link called neck or head may be, by the way from the hips to the shoulders. The frame of
the head of Unitree's G1 lies between its hips."""
_NECK_OVER = 0.07  # Height of the canonical neck over the shoulders, by the length of the legs


def words(name: str) -> list[str]:
    """Return the words of a name, in lower case.

    >>> words("left_hip_pitch_joint"), words("LHipYaw"), words("Shank_Left")
    (['left', 'hip', 'pitch', 'joint'], ['l', 'hip', 'yaw'], ['shank', 'left'])
    """
    found = []
    for word in _WORD.findall(name):
        if word.isupper() and len(word) > 1 and word[0] in "LR" and word[1:].lower() in _ALL:
            found += [word[0].lower(), word[1:].lower()]
        else:
            found.append(word.lower())
    return found


_ALL = frozenset(word for part in _PARTS.values() for word in part)
_PLAIN = _ALL | {"l", "r", "left", "right", "pitch", "roll", "yaw", "twist", "x", "y", "z"}
_PLAIN |= {"rx", "ry", "rz", "joint", "link", "skel", "leg", "arm", "body", "base", *"0123456789"}
"""Words of names that say no more: ``left_ankle_roll_sphere_3_link`` is a place on the foot."""


def part_of(name: str) -> tuple[str, str, int]:
    """Return the side ("l", "r" or ""), the part and the rank of its word; "" if there is none.

    >>> part_of("left_hip_pitch_joint"), part_of("leg_right_4_link"), part_of("imu_link")
    (('l', 'hip', 0), ('r', 'knee', 0), ('', '', 0))
    >>> part_of("zarm_l4_link"), part_of("l_sho_pitch"), part_of("r_el"), part_of("r_ank_roll")
    (('l', 'elbow', 0), ('l', 'shoulder', 1), ('r', 'elbow', 1), ('r', 'ankle', 1))
    """
    said = words(name)
    left, right = {"l", "left"} & {*said}, {"r", "right"} & {*said}
    side = "l" if left and not right else "r" if right and not left else ""
    if _NOT & {*said}:
        return side, "", 0
    for part, spelt in _PARTS.items():
        for rank, word in enumerate(spelt):
            if word in said:
                return side, part, rank
    for limb, parts in _NUMBERED.items():
        number = next((int(w) for w in said if w.isdigit() and len(w) < 3), 0)
        if limb in said and 0 < number <= len(parts):
            return side, parts[number - 1], 0
    return side, "", 0


def is_named(name: str) -> bool:
    """Say whether a name tells a side and a part of a limb."""
    side, part, _ = part_of(name)
    return bool(side and part)


def robot_roles(skeleton: Skeleton) -> dict[str, int]:
    """Find the joints of the roles of a robot by their names; those without one are missing."""
    roles: dict[str, int] = {}
    parts = [part_of(name) for name in skeleton.names]
    for side in "lr":
        limb: dict[str, list[int]] = {}
        for part in _PARTS:
            ranked = [(p[2], n) for n, p in enumerate(parts) if p[:2] == (side, part)]
            if part == "toe":
                named = [n for n, p in enumerate(parts) if p[0] == side]
                toes = [n for n in named if {*words(skeleton.names[n])} & {*_PARTS["toe"]}]
                ranked = [(0, n) for n in toes]
            plain = [(rank, n) for rank, n in ranked if {*words(skeleton.names[n])} <= _PLAIN]
            ranked = plain or ranked
            best = min(ranked)[0] if ranked else 0
            limb[part] = [n for rank, n in ranked if rank == best]
        roles |= {f"{side}_{part}": joint for part, joint in _limbs(skeleton, limb).items()}
    if all(f"{s}_{part}" in roles for s in "lr" for part in ("hip", "shoulder")):
        roles |= _neck(skeleton, roles)
    return roles


def _limbs(skeleton: Skeleton, limb: dict[str, list[int]]) -> dict[str, int]:
    """Choose one joint a part of one side, from the candidates of each."""
    chosen: dict[str, int] = {}
    at = _rest(skeleton)
    for first, middle, last in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")):
        straight = [n for n in limb[first] if not _ABOUT_LIMB & {*words(skeleton.names[n])}]
        start = (straight or limb[first] or [-1])[-1]
        if start < 0:
            continue
        chosen[first] = start
        bends = [n for n in limb[middle] if is_below(skeleton.parents, n, start) and n != start]
        above = bends[0] if bends else start
        ends = [n for n in limb[last] if is_below(skeleton.parents, n, above) and n != above]
        if bends:
            tip = at[ends[-1]] if ends else at[_tip(skeleton, bends[-1])]
            balance = [
                abs(np.linalg.norm(at[n] - at[start]) - np.linalg.norm(tip - at[n])) for n in bends
            ]
            chosen[middle] = bends[int(np.argmin(balance))]
        ends = [n for n in ends if n != chosen.get(middle)]
        if ends:
            chosen[last] = ends[-1]
    toes = [n for n in limb["toe"] if n != chosen.get("ankle")]
    toes = [n for n in toes if "ankle" in chosen and is_below(skeleton.parents, n, chosen["ankle"])]
    return chosen | ({"toe": toes[0]} if toes else {})


def _tip(skeleton: Skeleton, joint: int) -> int:
    """Return the last joint of the longest branch below a joint."""
    at = _rest(skeleton)
    below = [n for n in range(len(at)) if is_below(skeleton.parents, n, joint)]
    return max(below, key=lambda n: float(np.linalg.norm(at[n] - at[joint])))


def _rest(skeleton: Skeleton) -> FloatArray:
    """Return the places (joints, 3) where nothing is turned."""
    at = np.array(skeleton.offsets, dtype=float)
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            at[joint] += at[parent]
    return at


def _neck(skeleton: Skeleton, roles: dict[str, int]) -> dict[str, int]:
    """Return the joints of neck and head that are where these can be."""
    at = _rest(skeleton)
    hips, shoulders = (
        (at[roles[f"l_{part}"]] + at[roles[f"r_{part}"]]) / 2.0 for part in ("hip", "shoulder")
    )
    way = shoulders - hips
    size = max(float(way @ way), 1e-12)
    found: dict[str, list[int]] = {"neck": [], "head": []}
    for number, name in enumerate(skeleton.names):
        said = words(name)
        share = float((at[number] - hips) @ way) / size
        if _LOW < share < _HIGH and not _NOT & {*said}:
            for part in ("neck", "head"):
                if part in said:
                    found[part].append(number)
    necks = found["neck"] or found["head"][:1]
    heads = [n for n in found["head"] if n not in necks]
    chosen = {"neck": necks[0]} if necks else {}
    if necks and heads and is_below(skeleton.parents, heads[-1], necks[0]):
        chosen["head"] = heads[-1]
    return chosen


def missing_neck(skeleton: Skeleton) -> tuple[int, FloatArray] | None:
    """Return where a robot without a neck gets one: joint, and offset (3,); None if it needs none.

    It stands over the middle of the shoulders, as on the canonical body.
    """
    roles = robot_roles(skeleton)
    needed = [f"{s}_{part}" for s in "lr" for part in ("hip", "ankle", "shoulder")]
    if "neck" in roles or any(role not in roles for role in needed):
        return None
    at = _rest(skeleton)
    joint = _common(skeleton, [roles["l_shoulder"], roles["r_shoulder"]])
    shoulders = (at[roles["l_shoulder"]] + at[roles["r_shoulder"]]) / 2.0
    hips = (at[roles["l_hip"]] + at[roles["r_hip"]]) / 2.0
    way = (shoulders - hips) / max(float(np.linalg.norm(shoulders - hips)), 1e-9)
    leg = float(np.linalg.norm(at[roles["l_hip"]] - at[roles["l_ankle"]]))
    return joint, shoulders + _NECK_OVER * leg * way - at[joint]


def _common(skeleton: Skeleton, joints: Sequence[int]) -> int:
    """Return the lowest joint from which all given joints hang."""
    above = joints[0]
    while not all(is_below(skeleton.parents, joint, above) for joint in joints):
        above = int(skeleton.parents[above])
    return above
