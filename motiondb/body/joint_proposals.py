"""A joint map proposed for a skeleton whose names no convention has.

Names are split into words (``b_LeftArm_x``: b, left, arm, x). A side is a word such as left, l or
rt, or a first letter (``LUArm``); a part of the body is a run of the others that means one, the
first meanings of :data:`MEANINGS` before the later. Of hip, knee and ankle, and of shoulder, elbow
and wrist, each must hang from the one before, and both sides have the same words. The trunk's
joints are found by their places. What is proposed is for a person to check.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import pairwise, product
from types import MappingProxyType

from motiondb.body import body
from motiondb.body.joint_names import ARM, LEG, REQUIRED, joint_map
from motiondb.body.kinematics import is_below
from motiondb.errors import SkeletonError
from motiondb.records import IntArray, Skeleton

_WORDS = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+")
_SIDES = MappingProxyType(
    {"l": "l", "left": "l", "lft": "l", "lf": "l", "lt": "l"}
    | {"r": "r", "right": "r", "rgt": "r", "rt": "r"}
)
MEANINGS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "hip": ("upleg", "uleg", "upperleg", "legupper", "thigh", "femur", "hip", "leg"),
        "knee": ("lowleg", "lleg", "lowerleg", "leglower", "knee", "shin", "calf", "tibia", "leg"),
        "ankle": ("ankle", "foot"),
        "toe": ("toebase", "ball", "toe", "toes"),
        "shoulder": (
            *("uparm", "uarm", "upperarm", "armupper", "humerus", "shldr", "arm", "shoulder"),
        ),
        "elbow": ("forearm", "farm", "larm", "lowarm", "lowerarm", "armlower", "elbow", "radius"),
        "wrist": ("wrist", "hand"),
        "neck": ("neck", "lowerneck"),
        "head": ("head", "skull"),
        "chest": ("chest", "thorax", "ribcage", "torso", "spine3", "spine2", "spine"),
        "spine": ("spine", "spine1", "abdomen", "waist", "belly", "chest"),
    }
)
"""Part of the body -> words that mean it, the surest first."""
_NOT = frozenset(
    {"twist", "roll", "ik", "fk", "pole", "ctrl", "helper", "target", "end", "nub", "finger"}
    | {"thumb", "index", "middle", "ring", "pinky", "eye", "jaw", "tongue", "hair", "prop"}
)  # Words of joints that are no part of the body


def propose_map(skeleton: Skeleton) -> dict[str, str]:
    """Propose the joint of every role by the words in its name.

    >>> import numpy as np
    >>> names = ("b_Hips_x", "b_LeftThigh_x", "b_LeftShin_x", "b_LeftFoot_x")
    >>> propose_map(Skeleton(names, np.array([-1, 0, 1, 2]), np.zeros((4, 3))))["l_knee"]
    'b_LeftShin_x'
    """
    try:
        known = joint_map(skeleton)
    except SkeletonError:
        known = {}
    found = {role: skeleton.names[joint] for role, joint in known.items() if joint >= 0}
    words = [_read(name) for name in skeleton.names]
    for chain in (LEG, ARM):
        sides = [_chain(skeleton.parents, words, side, chain) for side in "lr"]
        fewer, more = sorted(sides, key=len)
        meant = {part: _meant(words[joint][1], part) for part, joint in more.items()}
        differ = any(meant.get(p) != _meant(words[joint][1], p) for p, joint in fewer.items())
        if differ and len(fewer) < len(more):
            sides = [  # the words of one side for both
                {p: j for p, j in side.items() if _meant(words[j][1], p) == meant.get(p)}
                for side in sides
            ]
        for side, chosen in zip("lr", sides):
            proposed = {f"{side}_{part}": skeleton.names[j] for part, j in chosen.items()}
            found = proposed | found
    for part in ("neck", "head"):
        taken = set(found.values())
        options = [j for j in _candidates(words, "", part) if skeleton.names[j] not in taken]
        if options and part not in found:
            found[part] = skeleton.names[options[0]]
    if {*REQUIRED} <= found.keys() and "chest" not in found:
        full = joint_map(skeleton, found)
        found |= {part: skeleton.names[full[part]] for part in ("spine", "chest") if part in full}
    return {role: found[role] for role in body.JOINTS if role in found}


def map_text(skeleton: Skeleton, name: str) -> str:
    """Return the text of a joint map with what is proposed, and the joints to choose from."""
    proposed = propose_map(skeleton)
    lines = [
        f"# Joint map for {name}: role = joint. Check it, correct it, and pass it as --joint-map.",
        "# Roles without a joint are estimated, but those marked as needed must be named.",
    ]
    for role in body.JOINTS:
        if role.endswith("collar") or role == "pelvis":
            continue
        needed = " (needed)" if role in REQUIRED else ""
        lines.append(f"{role} = {proposed[role]}" if role in proposed else f"# {role} = ?{needed}")
    lines += ["", "# The joints of the skeleton:"]
    lines += [f"#   {joint}" for joint in skeleton.names]
    return "\n".join(lines) + "\n"


def _read(name: str) -> tuple[str, str, bool]:
    """Return the side ("" for none), the other words joined, and whether it is a part of a body."""
    own = name.rpartition(":")[2]
    words = [word.lower() for word in _WORDS.findall(own)]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    own = re.split(r"[\s_.\-|]", own)[-1]
    if own[:1] in tuple("lrLR") and (not sides or own[1:2].isupper()):  # lfemur, Ana_LUArm, LFArm
        rest = [word.lower() for word in _WORDS.findall(own[1:])]
        if any("".join(rest) in means for means in MEANINGS.values()):
            return own[0].lower(), " ".join(rest), True
    rest = [word for word in words if word not in _SIDES]
    return (sides[0] if sides else ""), " ".join(rest), not _NOT.intersection(rest)


def _candidates(words: list[tuple[str, str, bool]], side: str, part: str) -> list[int]:
    """Return joints of a side whose words mean a part of the body, the surest first."""
    ranked = []
    for number, (of_side, text, is_part) in enumerate(words):
        if of_side != side or not is_part:
            continue
        if (word := _meant(text, part)) is not None:
            ranked.append((MEANINGS[part].index(word), text.count(" "), number))
    return [number for _, _, number in sorted(ranked)]


def _meant(text: str, part: str) -> str | None:
    """Return the surest word for a part of the body among the words of a name, or None."""
    words = text.split(" ")
    runs = {"".join(words[a:b]) for a in range(len(words)) for b in range(a + 1, len(words) + 1)}
    return next((word for word in MEANINGS[part] if word in runs), None)


def _chain(
    parents: IntArray, words: list[tuple[str, str, bool]], side: str, chain: tuple[str, ...]
) -> dict[str, int]:
    """Return the joints of a limb, each below the one before, as many as there are."""
    options = [[*_candidates(words, side, part)[:6], -1] for part in chain]
    best: dict[str, int] = {}
    best_value = (0, 0)
    for chosen in product(*options):
        joints = [joint for joint in chosen if joint >= 0]
        if len(set(joints)) < len(joints):
            continue
        if any(not is_below(parents, b, a) for a, b in pairwise(joints)):
            continue
        ranks = -sum(row.index(joint) for row, joint in zip(options, chosen) if joint >= 0)
        if (len(joints), ranks) > best_value:
            best_value = len(joints), ranks
            best = {part: joint for part, joint in zip(chain, chosen) if joint >= 0}
    return best
