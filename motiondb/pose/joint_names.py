"""Which joint of a capture's skeleton is which joint of the canonical body.

A *convention* names, for every role (a joint of :mod:`motiondb.pose.body`), the joint that stands
there; ``end:NAME`` means the end site of NAME. Names are compared without namespace, prefix, case
and separators, so that ``mixamorig:LeftUpLeg``, ``Neo_LeftUpLeg`` and ``LeftUpLeg`` are one.
The convention with the most roles found is taken; :func:`joint_map` refuses a skeleton without
hips, knees, ankles, shoulders, elbows and a neck, and says what it found.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from motiondb.errors import SkeletonError, suggestion
from motiondb.pose import body
from motiondb.records import Skeleton

REQUIRED = (
    "l_hip", "l_knee", "l_ankle", "r_hip", "r_knee", "r_ankle", "neck",
    "l_shoulder", "l_elbow", "r_shoulder", "r_elbow",
)  # fmt: skip


def _sided(centre: dict[str, str], left: dict[str, str], swap: tuple[str, str]) -> dict[str, str]:
    """Add both sides to the central roles: ``swap`` = (left, right) spelling in joint names."""
    sides = {f"l_{role}": name.replace("*", swap[0]) for role, name in left.items()}
    sides |= {f"r_{role}": name.replace("*", swap[1]) for role, name in left.items()}
    return centre | sides


CONVENTIONS: dict[str, dict[str, str]] = {
    "CMU ASF": _sided(
        {"spine": "upperback", "chest": "thorax", "neck": "lowerneck", "head": "head"},
        {"hip": "*femur", "knee": "*tibia", "ankle": "*foot", "toe": "*toes",
         "shoulder": "*humerus", "elbow": "*radius", "wrist": "*wrist"},
        ("l", "r"),
    ),
    "CMU BVH": _sided(
        {"spine": "chest", "chest": "chest2", "neck": "lowerneck", "head": "head"},
        {"hip": "*hip", "knee": "*knee", "ankle": "*ankle", "toe": "*toe",
         "shoulder": "*shoulder", "elbow": "*elbow", "wrist": "*wrist"},
        ("left", "right"),
    ),
    "BVH hip-knee-ankle": _sided(
        {"spine": "chest", "chest": "chest2", "neck": "neck", "head": "head"},
        {"hip": "*hip", "knee": "*knee", "ankle": "*ankle", "toe": "*toe",
         "shoulder": "*shoulder", "elbow": "*elbow", "wrist": "*wrist"},
        ("left", "right"),
    ),
    "Mixamo / MotionBuilder": _sided(
        {"spine": "spine1", "chest": "spine2", "neck": "neck", "head": "head"},
        {"hip": "*upleg", "knee": "*leg", "ankle": "*foot", "toe": "*toebase",
         "shoulder": "*arm", "elbow": "*forearm", "wrist": "*hand"},
        ("left", "right"),
    ),
    "MotionBuilder without toes and hands": _sided(
        {"spine": "spine1", "chest": "spine2", "neck": "neck", "head": "end:neck"},
        {"hip": "*upleg", "knee": "*leg", "ankle": "*foot", "toe": "end:*foot",
         "shoulder": "*arm", "elbow": "*forearm", "wrist": "end:*forearm"},
        ("left", "right"),
    ),
    "MotionBuilder with two spines": _sided(
        {"spine": "spine", "chest": "spine1", "neck": "neck", "head": "head"},
        {"hip": "*upleg", "knee": "*leg", "ankle": "*foot", "toe": "*toebase",
         "shoulder": "*arm", "elbow": "*forearm", "wrist": "*hand"},
        ("left", "right"),
    ),
    "Poser": _sided(
        {"spine": "abdomen", "chest": "chest", "neck": "neck", "head": "head"},
        {"hip": "*thigh", "knee": "*shin", "ankle": "*foot", "toe": "end:*foot",
         "shoulder": "*shldr", "elbow": "*forearm", "wrist": "*hand"},
        ("l", "r"),
    ),
    "Character Creator": _sided(
        {"spine": "waist", "chest": "spine02", "neck": "necktwist01", "head": "head"},
        {"hip": "*thigh", "knee": "*calf", "ankle": "*foot", "toe": "*toebase",
         "shoulder": "*upperarm", "elbow": "*forearm", "wrist": "*hand"},
        ("l", "r"),
    ),
    "Bandai-Namco": _sided(
        {"spine": "spine", "chest": "chest", "neck": "neck", "head": "head"},
        {"hip": "upperleg*", "knee": "lowerleg*", "ankle": "foot*", "toe": "toes*",
         "shoulder": "upperarm*", "elbow": "lowerarm*", "wrist": "hand*"},
        ("l", "r"),
    ),
    "SMPL": _sided(
        {"spine": "spine1", "chest": "spine3", "neck": "neck", "head": "head"},
        {"hip": "*hip", "knee": "*knee", "ankle": "*ankle", "toe": "*foot",
         "shoulder": "*shoulder", "elbow": "*elbow", "wrist": "*wrist"},
        ("l", "r"),
    ),
    "DeepMimic": _sided(
        {"spine": "chest", "neck": "neck", "head": "end:neck"},
        {"hip": "*hip", "knee": "*knee", "ankle": "*ankle", "toe": "end:*ankle",
         "shoulder": "*shoulder", "elbow": "*elbow", "wrist": "end:*elbow"},
        ("left", "right"),
    ),
    "3ds Max Biped": _sided(
        {"spine": "spine1", "chest": "spine2", "neck": "neck", "head": "head"},
        {"hip": "*thigh", "knee": "*calf", "ankle": "*foot", "toe": "*toe0",
         "shoulder": "*upperarm", "elbow": "*forearm", "wrist": "*hand"},
        ("l", "r"),
    ),
    "motiondb": _sided(
        {"spine": "spine", "chest": "chest", "neck": "neck", "head": "head"},
        {"hip": "*hip", "knee": "*knee", "ankle": "*ankle", "toe": "*toe",
         "shoulder": "*shoulder", "elbow": "*elbow", "wrist": "*wrist"},
        ("l", "r"),
    ),
}  # fmt: skip
"""Role -> normalised joint name, per convention."""


def normalised(name: str) -> str:
    """A joint name without namespace, known prefix, case and separators.

    >>> normalised("mixamorig:LeftUpLeg"), normalised("CC_Base_L_Thigh"), normalised("L_Hip")
    ('leftupleg', 'lthigh', 'lhip')
    """
    name = name.rsplit(":", 1)[-1].lower()
    name = re.sub(r"^(mixamorig\d*|neo_|cc_base_|bip\d+|joint_|m_avg_|f_avg_)", "", name)
    return re.sub(r"[\s_.\-]", "", name)


def joint_map(skeleton: Skeleton, user_map: Mapping[str, str] | None = None) -> dict[str, int]:
    """Role -> joint number of the skeleton; an end site e of joint j counts as -1 - e.

    Parameters
    ----------
    skeleton : the capture's skeleton.
    user_map : role -> joint name (or ``end:NAME``) for skeletons that no convention fits;
        entries override what the convention says.

    Raises
    ------
    SkeletonError
        when a required role is not found; the message names the nearest convention.
    """
    found: dict[str, int] = {}
    for number, name in enumerate(skeleton.names):
        found.setdefault(normalised(name), number)
    for number, (joint, _) in enumerate(skeleton.end_sites):
        found.setdefault("end:" + normalised(skeleton.names[joint]), -1 - number)
    maps = {
        name: {role: found[joint] for role, joint in roles.items() if joint in found}
        for name, roles in CONVENTIONS.items()
    }
    best = max(
        maps, key=lambda name: (sum(role in maps[name] for role in REQUIRED), len(maps[name]))
    )
    chosen = maps[best] | _read_user_map(user_map or {}, found, skeleton)
    missing = [role for role in REQUIRED if role not in chosen]
    if missing:
        names = ", ".join(skeleton.names[:40]) + (", ..." if len(skeleton.names) > 40 else "")
        raise SkeletonError(
            f"skeleton: expected joints for {', '.join(missing)}, found none among: {names} "
            f"(nearest convention: {best}). Name them in a joint map, lines of `role = joint`."
        )
    return chosen


def _read_user_map(
    user_map: Mapping[str, str], found: Mapping[str, int], skeleton: Skeleton
) -> dict[str, int]:
    chosen: dict[str, int] = {}
    for role, name in user_map.items():
        if role not in body.INDEX:
            raise SkeletonError(
                f"joint map: expected a role among {', '.join(body.JOINTS)}, found {role!r}."
                + suggestion(role, body.JOINTS)
            )
        end = name.startswith("end:")
        key = ("end:" if end else "") + normalised(name.removeprefix("end:"))
        if key not in found:
            ends = [f"end:{skeleton.names[joint]}" for joint, _ in skeleton.end_sites]
            raise SkeletonError(
                f"joint map: expected a joint of the skeleton for {role}, found {name!r}."
                + suggestion(name, ends if end else skeleton.names)
            )
        chosen[role] = found[key]
    return chosen
