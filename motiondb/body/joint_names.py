"""Which joint of a capture's skeleton is which joint of the canonical body.

A *convention* names, for every role (a joint of :mod:`motiondb.body.body`), the joint that has
this role in the skeletons of some program; ``end:NAME`` means the end site of NAME. Names are
compared without namespace, prefix, case and separators, so that ``mixamorig:LeftUpLeg``,
``Neo_LeftUpLeg`` and ``LeftUpLeg`` are equal. Where this finds no body, what nearly all names begin
or end with (``J_Bip_``, ``robot``, ``Jnt``) and numbers of joints (``.001``) are left out, and a
side may be spelled in any way and place (``L_UpLeg``, ``UpLegLeft``); what many names begin with
(``J_Bip_``, beside ``J_Sec_`` of hair) is tried as well. The convention with the most
required roles is taken, then the one with the most roles, then the first; roles that it does not
find are taken from the others, where the joint hangs where it should. :func:`joint_map` refuses a
skeleton without hips, knees, ankles, shoulders, elbows and a neck, and lists its joints.

Where no convention names a body, the words of links and hinges of robots are looked at
(:mod:`motiondb.body.robot_names`).

Where the joints of the trunk have other names, those nearest to a third and to three fifths of the
way from the pelvis to the neck are taken. Skeletons of Vicon Shogun have the names of
MotionBuilder.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from motiondb.body import body
from motiondb.body.kinematics import is_below
from motiondb.body.robot_names import robot_roles
from motiondb.errors import SkeletonError, suggestion
from motiondb.records import IntArray, Skeleton

Roles = Mapping[str, str]  # Role -> normalised joint name

REQUIRED = (
    "l_hip",
    "l_knee",
    "l_ankle",
    "r_hip",
    "r_knee",
    "r_ankle",
    "neck",
    "l_shoulder",
    "l_elbow",
    "r_shoulder",
    "r_elbow",
)
"""Roles that a skeleton must have; all others can be estimated from these."""
LEG, ARM = ("hip", "knee", "ankle", "toe"), ("shoulder", "elbow", "wrist")  # From the trunk on
_PREFIX = re.compile(
    r"^(mixamorig\d*|character\d*_|neo_|cc_base_|bip\d+|joint_|m_avg_|f_avg_|def[-_]|org[-_])"
)
_SEPARATORS = re.compile(r"[\s_.\-]")
_SPACE = re.compile(r".*[:|]")  # Namespaces, and the joints above in a path
_NUMBERS = (re.compile(r"^[\s_.\-]*[0-9]+"), re.compile(r"[0-9]+[\s_.\-]*$"))
_BETWEEN = re.compile(r"[\s_.\-]+")
_NUMBER = re.compile(r"[0-9]+")
_MOST = 0.8  # Share of the joints that have in common what names none: a root may lack it
_MAX_LISTED = 40  # Joints that a message lists: those of a body without fingers


_CENTRE = ("spine", "chest", "neck", "head")
_TABLE = """
CMU ASF: l r
    upperback thorax lowerneck head *femur *tibia *foot *toes *humerus *radius *wrist
CMU BVH: left right
    chest chest2 lowerneck head *hip *knee *ankle *toe *shoulder *elbow *wrist
Xsens BVH: left right
    chest chest3 neck head *hip *knee *ankle *toe *shoulder *elbow *wrist
BVH hip-knee-ankle: left right
    chest chest2 neck head *hip *knee *ankle *toe *shoulder *elbow *wrist
Mixamo / MotionBuilder: left right
    spine1 spine2 neck head *upleg *leg *foot *toebase *arm *forearm *hand
MotionBuilder without toes and hands: left right
    spine1 spine2 neck end:neck *upleg *leg *foot end:*foot *arm *forearm end:*forearm
MotionBuilder with two spines: left right
    spine spine1 neck head *upleg *leg *foot *toebase *arm *forearm *hand
Poser: l r
    abdomen chest neck head *thigh *shin *foot end:*foot *shldr *forearm *hand
Character Creator: l r
    waist spine02 necktwist01 head *thigh *calf *foot *toebase *upperarm *forearm *hand
Bandai-Namco: l r
    spine chest neck head upperleg* lowerleg* foot* toes* upperarm* lowerarm* hand*
SMPL: l r
    spine1 spine3 neck head *hip *knee *ankle *foot *shoulder *elbow *wrist
DeepMimic: left right
    chest - neck end:neck *hip *knee *ankle end:*ankle *shoulder *elbow end:*elbow
3ds Max Biped: l r
    spine1 spine2 neck head *thigh *calf *foot *toe0 *upperarm *forearm *hand
Rigify: l r
    spine001 spine003 spine004 spine006 thigh* shin* foot* toe* upperarm* forearm* hand*
Blender: l r
    spine chest neck head thigh* shin* foot* toe* upperarm* forearm* hand*
Unreal: l r
    spine01 spine03 neck01 head thigh* calf* foot* ball* upperarm* lowerarm* hand*
Unity Humanoid: left right
    spine chest neck head *upperleg *lowerleg *foot *toes *upperarm *lowerarm *hand
Xsens: left right
    l5 t12 neck head *upperleg *lowerleg *foot *toe *upperarm *forearm *hand
Rokoko: left right
    spine1 spine3 neck head *thigh *shin *foot *toe *arm *forearm *hand
Visual3D: l r
    - torso neck head *thigh *shank *foot *toes *uarm *larm *hand
OptiTrack: l r
    ab chest neck head *thigh *shin *foot *toe *uarm *farm *hand
Daz Genesis 3 and 8: l r
    abdomenupper chestupper necklower head *thighbend *shin *foot *toe *shldrbend *forearmbend *hand
Daz Genesis 9: l r
    spine2 spine4 neck1 head *thigh *shin *foot *toes *upperarm *forearm *hand
MikuMikuDance: 左 右
    上半身 上半身2 首 頭 *足 *ひざ *足首 *つま先 *腕 *ひじ *手首
German: links rechts
    bauch brust hals kopf *oberschenkel *unterschenkel *fuss *zehen *oberarm *unterarm *hand
mocopi: l r
    torso3 torso6 neck1 head *upleg *lowleg *foot *toes *uparm *lowarm *hand
Cascadeur: l r
    stomach chest neck head thigh* calf* foot* toe* arm* forearm* hand*
VRChat: left right
    spine chest neck head *leg *knee *ankle *toe *arm *elbow *wrist
SOMA: left right
    spine1 chest neck1 head *leg *shin *foot *toebase *arm *forearm *hand
motiondb: l r
    spine chest neck head *hip *knee *ankle *toe *shoulder *elbow *wrist
"""
"""Two lines a convention: its name, and how it names left and right; then its joints of the centre,
leg and arm, `*` for the side, `-` for a joint that it lacks."""


def _read_conventions(table: str) -> dict[str, Roles]:
    conventions: dict[str, Roles] = {}
    lines = table.strip().splitlines()
    for head, row in zip(lines[::2], lines[1::2]):
        name, _, sides = head.partition(": ")
        joints = dict(zip((*_CENTRE, *LEG, *ARM), row.split()))
        roles = {role: joints[role] for role in _CENTRE if joints[role] != "-"}
        for side, spelt in zip("lr", sides.split()):
            roles |= {f"{side}_{r}": joints[r].replace("*", spelt) for r in (*LEG, *ARM)}
        conventions[name] = MappingProxyType(roles)
    return conventions


CONVENTIONS: Mapping[str, Roles] = MappingProxyType(_read_conventions(_TABLE))
"""Name of a convention -> role -> normalised joint name."""
_SPELT = MappingProxyType(
    {
        f"{end}{spelt}": f"{end}{side}{part}"
        for end in ("", "end:")
        for part in set(re.findall(r"[a-z0-9]+", _TABLE.replace("end:", "")))
        for side, words in (
            ("l", "l left lft links"),
            ("r", "r right rgt rechts"),
            ("", "c m center centre mid"),
        )
        for word in words.split()
        for spelt in (word + part, part + word)
    }
)  # A joint's name with its side spelled in any way -> with l, r or nothing before
_SIDES_FIRST: Mapping[str, Roles] = MappingProxyType(
    {
        name: {role: _SPELT.get(joint, joint) for role, joint in roles.items()}
        for name, roles in CONVENTIONS.items()
    }
)


@lru_cache(maxsize=4096)
def normalised(name: str) -> str:
    """Return a joint name without namespace, known prefix, case and separators.

    >>> normalised("mixamorig:LeftUpLeg"), normalised("CC_Base_L_Thigh"), normalised("DEF-thigh.L")
    ('leftupleg', 'lthigh', 'thighl')
    """
    return _SEPARATORS.sub("", _PREFIX.sub("", _SPACE.sub("", name).lower()))


_SIDES = re.compile(r"left|right|lft|rgt|(?<![a-z])[lr](?![a-z])", re.IGNORECASE)
_OTHER_SIDE = MappingProxyType(
    {"left": "right", "right": "left", "lft": "rgt", "rgt": "lft", "l": "r", "r": "l"}
)


def mirror_joints(skeleton: Skeleton) -> IntArray:
    """For every joint the number of its partner by name on the other side, else its own."""
    numbers: dict[str, int] = {}
    for number, name in enumerate(skeleton.names):
        numbers.setdefault(name, number)
    partners = []
    for number, name in enumerate(skeleton.names):
        found = [numbers[other] for other in _on_other_side(name) if other in numbers]
        partners.append(found[0] if found else number)
    each_other = [partners[partner] == number for number, partner in enumerate(partners)]
    return np.array([p if both else n for n, (p, both) in enumerate(zip(partners, each_other))])


def _on_other_side(name: str) -> list[str]:
    """Return what a joint's partner may be called.

    >>> _on_other_side("LeftArm"), _on_other_side("arm_l"), _on_other_side("lfemur")
    (['RightArm'], ['arm_r'], ['rfemur'])
    >>> _on_other_side("LowerArmL")
    ['LowerArmR', 'RowerArmL']
    """

    def exchanged(found: re.Match[str]) -> str:
        text = found[0]
        other = _OTHER_SIDE[text.lower()]
        return other.upper() if text.isupper() else other.title() if text[0].isupper() else other

    first = _SIDES.sub(exchanged, name)
    names = [first] if first != name else []
    space, mark, own = name.rpartition(":")
    if names:
        return names
    letter = {"l": "r", "r": "l", "L": "R", "R": "L"}
    if own[-1:] in ("L", "R"):  # UpperArmL
        names.append(f"{space}{mark}{own[:-1]}{letter[own[-1]]}")
    if own[:1] in letter:  # lfemur, LShldr, rThigh
        names.append(f"{space}{mark}{letter[own[0]]}{own[1:]}")
    return names


def joint_map(skeleton: Skeleton, user_map: Mapping[str, str] | None = None) -> dict[str, int]:
    """Find the joint of every role; `user_map` (role -> name or ``end:NAME``) goes before."""
    numbers = _numbers([normalised(name) for name in skeleton.names], skeleton)
    conventions = CONVENTIONS
    best, chosen = _best_convention(numbers, conventions)
    lacking = any(role not in chosen for role in REQUIRED)
    for read in _read_otherwise(skeleton.names) if lacking else ():
        if all(role in chosen for role in REQUIRED):
            break
        plain = _numbers([_SPELT.get(name, name) for name in read], skeleton)
        other, found = _best_convention(plain, _SIDES_FIRST)
        if _worth(found) > _worth(chosen):
            best, chosen, numbers, conventions = other, found, plain, _SIDES_FIRST
    roles = {role: _of_equals(role, joints, skeleton) for role, joints in chosen.items()}
    if any(role not in chosen for role in REQUIRED):
        robot = robot_roles(skeleton)
        if _worth(robot) > _worth(chosen):
            best, roles = "robots", robot
    roles |= _read_user_map(user_map or {}, skeleton)
    _fill(roles, numbers, conventions, skeleton)
    missing = [role for role in REQUIRED if role not in roles]
    if missing:
        names = ", ".join(name[:_MAX_LISTED] for name in skeleton.names[:_MAX_LISTED])
        names += ", ..." if len(skeleton.names) > _MAX_LISTED else ""
        raise SkeletonError(
            f"skeleton: expected joints for {', '.join(missing)}, found none among: {names} "
            f"(nearest convention: {best}). Name them in a joint map, lines of `role = joint`; "
            "motiondb joints proposes one."
        )
    return roles


def is_person(skeleton: Skeleton) -> bool:
    """Say whether the joints of a person are found by their names."""
    try:
        joint_map(skeleton)
    except SkeletonError:
        return False
    return True


Numbers = dict[str, list[int]]  # Normalised name -> the joints that have it (-1 - n: end site n)


def _numbers(names: Sequence[str], skeleton: Skeleton) -> Numbers:
    """Return the joints and end sites of every name."""
    numbers: Numbers = {}
    for number, name in enumerate(names):
        numbers.setdefault(name, []).append(number)
    for number, (joint, _) in enumerate(skeleton.end_sites):
        numbers.setdefault("end:" + names[joint], []).append(-1 - number)
    return numbers


def _best_convention(
    numbers: Numbers, conventions: Mapping[str, Roles]
) -> tuple[str, dict[str, list[int]]]:
    """Return the convention that fits best, and the joints of its roles; any names the neck."""
    maps = {
        name: {role: numbers[joint] for role, joint in roles.items() if joint in numbers}
        for name, roles in conventions.items()
    }
    best = max(maps, key=lambda name: _worth(maps[name]))
    found = maps[best]
    necks = (numbers.get(names["neck"]) for names in conventions.values())
    if "neck" not in found and (neck := next(filter(None, necks), None)):
        found["neck"] = neck
    return best, found


def _worth(found: Mapping[str, object]) -> tuple[int, int]:
    """Return by what conventions are compared: required roles, then all."""
    return sum(role in found for role in REQUIRED), len(found)


def _without_shared(names: Sequence[str]) -> list[str]:
    """Return normalised names without what most begin or end with, and without running numbers.

    >>> _without_shared(["J_Bip_C_HipsJnt", "J_Bip_L_LegJnt", "J_Bip_C_NeckJnt"])
    ['chips', 'lleg', 'cneck']
    >>> _without_shared(["00_Hips", "01_LeftLeg", "02_Neck"])
    ['hips', 'leftleg', 'neck']
    """
    left = [_SPACE.sub("", name).lower() for name in names]
    for _ in range(2):
        for number in _NUMBERS:
            if sum(bool(number.search(name)) for name in left) >= _MOST * len(left):
                left = [number.sub("", name) for name in left]
        first = _shared(left).rstrip("0123456789")
        left = [name.removeprefix(first) for name in left]
        last = _shared([name[::-1] for name in left])[::-1].lstrip("0123456789")
        left = [name.removesuffix(last) for name in left]
    return [normalised(name) for name in left]


def _read_otherwise(names: Sequence[str]) -> Iterator[list[str]]:
    """Yield normalised names without what most share, or many begin with, or without numbers.

    Of bones in several pieces, only the first is named in the last of these.

    >>> list(_read_otherwise(["UpperLeg01.L", "UpperLeg02.L", "Neck"]))[-1]
    ['upperlegl', '', 'neck']
    """
    yield _without_shared(names)
    begun = Counter(name[: end.end()] for name in names for end in _BETWEEN.finditer(name))
    for begin, count in begun.most_common():
        if count >= len(REQUIRED):
            yield _without_shared([name.removeprefix(begin) for name in names])
    plain = [_NUMBER.sub("", name) for name in _without_shared(names)]
    yield [name if name not in plain[:n] else "" for n, name in enumerate(plain)]


def _shared(names: Sequence[str]) -> str:
    """Return the longest text that most names begin with."""
    shared = ""
    while True:
        longer = Counter(n[: len(shared) + 1] for n in names if n.startswith(shared))
        text, count = longer.most_common(1)[0]
        if text == shared or count < _MOST * len(names):
            return shared
        shared = text


def _of_equals(role: str, joints: Sequence[int], skeleton: Skeleton) -> int:
    """Of joints with one name the nearest to the root, or the one below it near the trunk.

    A collar is called like the arm, a hip like the thigh; but a toe like the foot above it. Others
    are those of a second body.
    """

    def depth(joint: int) -> int:
        return 0 if joint < 0 else 1 + depth(int(skeleton.parents[joint]))

    first = min(joints, key=depth)
    if role.rpartition("_")[2] not in ("shoulder", "hip", "neck", "chest"):
        return first
    return next((joint for joint in joints[1:] if skeleton.parents[joint] == first), first)


def same_names(skeleton: Skeleton, roles: Mapping[str, int]) -> tuple[str, ...]:
    """Note joints of one name of which one has a role."""
    alike: dict[str, list[int]] = {}
    for number, name in enumerate(skeleton.names):
        alike.setdefault(normalised(name), []).append(number)
    notes = []
    for role, joint in roles.items():
        others = alike[normalised(skeleton.names[joint])] if joint >= 0 else []
        if len(others) > 1:
            names = " and ".join(dict.fromkeys(skeleton.names[other] for other in others))
            which = f"number {others.index(joint) + 1} in the file"
            notes.append(
                f"{len(others)} joints are called {names}; {which} is taken for {role}. Give them "
                "different names if this is wrong."
            )
    return tuple(notes)


_TRUNK = MappingProxyType({"spine": 1 / 3, "chest": 0.6})
"""Shares of the way from the hips to the neck: they give the joints that the names give in
skeletons of Mixamo, CMU, Poser, Bandai-Namco and SMPL."""
_ABOVE = MappingProxyType({"toe": "ankle", "wrist": "elbow", "head": "neck"})


def _fill(
    roles: dict[str, int],
    numbers: Numbers,
    conventions: Mapping[str, Roles],
    skeleton: Skeleton,
) -> None:
    """Add roles that the convention lacks: ends from other conventions, the trunk from its chain.

    Joints of the trunk are those nearest to ``_TRUNK``, whatever their names.
    """
    if any(role not in roles for role in REQUIRED):
        return
    for role in (*(f"{s}_{end}" for s in "lr" for end in ("toe", "wrist")), "head"):
        side, _, end = role.rpartition("_")
        above = roles[f"{side}_{_ABOVE[end]}" if side else _ABOVE[end]]
        for names in conventions.values():
            for joint in numbers.get(names.get(role, ""), []):
                free = joint not in roles.values() and role not in roles
                if free and joint >= 0 and is_below(skeleton.parents, joint, above):
                    roles[role] = joint
    chain = _trunk(skeleton, roles)
    shares = np.cumsum(np.linalg.norm(skeleton.offsets[[*chain, roles["neck"]]], axis=1))
    if not chain or not shares[-1] > 0.0:
        return
    shares = shares[:-1] / shares[-1]
    for role, share in _TRUNK.items():
        first = chain.index(roles["spine"]) + 1 if roles.get("spine") in chain else 0
        last = chain.index(roles["chest"]) if roles.get("chest") in chain else len(chain)
        if role not in roles and first < last:
            nearest = first + int(np.abs(shares[first:last] - share).argmin())
            roles[role] = chain[nearest]


def _trunk(skeleton: Skeleton, roles: Mapping[str, int]) -> list[int]:
    """Return the joints between the joint that carries both legs and the neck, from below."""
    parents = skeleton.parents
    chain = []
    joint = int(parents[roles["neck"]]) if roles["neck"] >= 0 else -1
    while joint >= 0 and not all(is_below(parents, roles[f"{s}_hip"], joint) for s in "lr"):
        chain.append(joint)
        joint = int(parents[joint])
    return chain[::-1] if joint >= 0 else []


_LIMBS = {
    f"{side}_{part}": (f"{side}_{limb[0]}", number)
    for side in "lr"
    for limb in (LEG, ("collar", *ARM))
    for number, part in enumerate(limb)
}  # Role -> its limb, and place within the limb


def crossed_names(skeleton: Skeleton, roles: Mapping[str, int]) -> tuple[str, ...]:
    """Note a joint that hangs from one that no body has above it, such as a hand from a knee.

    Two joints with each other's names are read without any other sign: the positions of the
    skeleton are right, only the body that is made of them is not. Skeletons that do not connect
    their joints, or have another joint of the trunk as their root, are no contradiction.

    >>> names = ("hips", "spine", "neck", "l_knee", "l_hip")
    >>> skeleton = Skeleton(names, np.array([-1, 0, 1, 0, 3]), np.zeros((5, 3)))
    >>> crossed_names(skeleton, {"l_hip": 4, "l_knee": 3})[0][:58]
    'l_hip (l_hip) hangs from l_knee (l_knee), as in no body: c'
    """
    joints = {r: j if j >= 0 else skeleton.end_sites[-1 - j][0] for r, j in roles.items()}
    of_joint = {joint: role for role, joint in joints.items() if roles[role] >= 0}
    for role, joint in joints.items():
        above = int(skeleton.parents[joint]) if roles[role] >= 0 else joint
        over = []
        while above >= 0:
            over += [of_joint[above]] if above in of_joint else []
            above = int(skeleton.parents[above])
        limb, number = _LIMBS.get(role, ("", 0))
        wrong = [
            o for o in over if o in _LIMBS and (_LIMBS[o][0] != limb or _LIMBS[o][1] >= number)
        ]
        is_loose = any(o in joints and o not in over for o, (of, n) in _LIMBS.items()
                       if of == limb and n < number)  # fmt: skip
        wrong += ["head"] if is_loose and "head" in over else []
        if wrong:
            return (
                f"{role} ({skeleton.names[joint]}) hangs from {wrong[0]} "
                f"({skeleton.names[joints[wrong[0]]]}), as in no body: compare the names of the "
                "joints with the motion, or name them with --joint-map",
            )
    return ()


def _read_user_map(user_map: Mapping[str, str], skeleton: Skeleton) -> dict[str, int]:
    """Return role -> joint number of the user's map: names as written, else normalised ones."""
    numbers = _numbers([normalised(name) for name in skeleton.names], skeleton)
    exact = _numbers(skeleton.names, skeleton)
    chosen: dict[str, int] = {}
    for role, name in user_map.items():
        if role not in body.INDEX:
            raise SkeletonError(
                f"joint map: expected a role among {', '.join(body.JOINTS)}, found {role!r}."
                + suggestion(role, body.JOINTS)
            )
        end = name.startswith("end:")
        key = ("end:" if end else "") + normalised(name.removeprefix("end:"))
        found = exact.get(name) or numbers.get(key)
        if not found:
            ends = [f"end:{skeleton.names[joint]}" for joint, _ in skeleton.end_sites]
            raise SkeletonError(
                f"joint map: expected a joint of the skeleton for {role}, found {name!r}."
                + suggestion(name, ends if end else skeleton.names)
            )
        chosen[role] = _of_equals(role, found, skeleton)
    return chosen
