"""The performers: their proportions, their style, and the skeleton that each one's files use.

World frame: y up, facing +z at zero rotation, left is +x, metres. Joints are known by role (the
names of the canonical body); two naming conventions spell the roles in the files.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import Skeleton

ROLES = (
    ("pelvis", -1), ("spine", 0), ("chest", 1), ("neck", 2), ("head", 3),
    ("l_collar", 2), ("l_shoulder", 5), ("l_elbow", 6), ("l_wrist", 7),
    ("r_collar", 2), ("r_shoulder", 9), ("r_elbow", 10), ("r_wrist", 11),
    ("l_hip", 0), ("l_knee", 13), ("l_ankle", 14), ("l_toe", 15),
    ("r_hip", 0), ("r_knee", 17), ("r_ankle", 18), ("r_toe", 19),
)  # fmt: skip
"""(role, parent) of the 21 joints, in file order."""
INDEX = {role: number for number, (role, _) in enumerate(ROLES)}

_CENTRE = ("pelvis", "spine", "chest", "neck", "head")
_LIMBS = ("collar", "shoulder", "elbow", "wrist", "hip", "knee", "ankle", "toe")
NAMINGS = {
    "leg": (
        ("Hips", "Spine", "Spine1", "Neck", "Head"),
        ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase"),
    ),
    "knee": (
        ("Hips", "Chest", "Chest2", "Neck", "Head"),
        ("Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Toe"),
    ),
}
"""Spelling of the central roles and of the limbs (after Left or Right), by naming."""


@dataclass(frozen=True)
class Performer:
    """A person: lengths in metres, style as multiples of the usual (1) unless a unit is named.

    Attributes
    ----------
    leg, arm : hip to ankle, shoulder to wrist.
    hips, shoulders : half the distance between the two joints.
    trunk : hip line to base of the neck.
    tempo : how fast actions are; ``vigour`` : how large.
    stance : distance between the feet; ``lean`` : of the trunk, degrees forward.
    sway : size of the slow wander of the body; ``tremor`` : of the fast one, degrees.
    hand : the side that acts, "l" or "r"; ``splay`` : toes outward, degrees.
    """

    name: str
    leg: float
    arm: float
    hips: float
    shoulders: float
    trunk: float
    naming: str
    tempo: float
    vigour: float
    stance: float
    lean: float
    sway: float
    tremor: float
    hand: str = "r"
    splay: float = 8.0

    @property
    def scale(self) -> float:
        """Size with respect to a standard body with legs of 0.85 m."""
        return self.leg / 0.85


PERFORMERS = {
    person.name: person
    for person in (
        #          name   leg   arm    hips   should trunk  naming tempo vig. stance lean sway trem
        Performer("ana",   0.80, 0.500, 0.088, 0.155, 0.47, "leg", 1.05, 1.00, 0.95, 2, 1.0, 0.10),
        Performer("boris", 0.91, 0.590, 0.095, 0.190, 0.54, "leg", 0.90, 1.10, 1.25, 5, 0.8, 0.08),
        Performer("chidi", 0.88, 0.570, 0.090, 0.180, 0.50, "knee", 1.15, 1.15, 1.05, 3, 1.2, 0.12),
        Performer("dora",  0.76, 0.480, 0.092, 0.150, 0.45, "knee", 0.95, 0.85, 0.90, 4, 1.5, 0.15,
                  hand="l", splay=5.0),
        Performer("emil",  0.85, 0.540, 0.088, 0.175, 0.51, "leg", 0.82, 0.80, 1.10, 9, 1.6, 0.14,
                  splay=13.0),
        Performer("fatou", 0.84, 0.530, 0.090, 0.160, 0.48, "knee", 1.10, 1.05, 1.00, 1, 0.7, 0.06),
        Performer("goran", 0.96, 0.620, 0.096, 0.195, 0.56, "leg", 1.00, 1.05, 1.15, 4, 1.0, 0.10,
                  splay=10.0),
    )
}  # fmt: skip
"""All performers by name."""


def skeleton(person: Performer) -> Skeleton:
    """The skeleton of a performer in T-pose, with the channels of a BVH file."""
    up, leg, arm = person.trunk / 0.50, person.leg / 0.85, person.arm / 0.53
    toe = 0.14 * person.scale
    limbs = {
        "collar": (0.03, 0.18 * up, 0.0),
        "shoulder": (person.shoulders - 0.03, 0.0, 0.0),
        "elbow": (0.28 * arm, 0.0, 0.0),
        "wrist": (0.25 * arm, 0.0, 0.0),
        "hip": (person.hips, 0.0, 0.0),
        "knee": (0.0, -0.43 * leg, 0.0),
        "ankle": (0.0, -0.42 * leg, 0.0),
        "toe": (0.0, -0.06 * person.scale, toe),
    }
    places = {
        "pelvis": (0.0, 0.0, 0.0),
        "spine": (0.0, 0.12 * up, 0.0),
        "chest": (0.0, 0.14 * up, 0.0),
        "neck": (0.0, 0.24 * up, 0.0),
        "head": (0.0, 0.10 * up, 0.01),
    }
    for limb, (x, y, z) in limbs.items():
        places[f"l_{limb}"], places[f"r_{limb}"] = (x, y, z), (-x, y, z)
    ends = (
        ("head", (0.0, 0.17, 0.0)),
        ("l_wrist", (0.16, 0.0, 0.0)),
        ("r_wrist", (-0.16, 0.0, 0.0)),
    )
    toes = tuple((INDEX[f"{s}_toe"], (0.0, -0.02 * person.scale, 0.4 * toe)) for s in "lr")
    turns = ("Zrotation", "Xrotation", "Yrotation")
    if person.naming == "knee":
        turns = ("Zrotation", "Yrotation", "Xrotation")
    root = ("Xposition", "Yposition", "Zposition", *turns)
    return Skeleton(
        names=tuple(spelled(role, person.naming) for role, _ in ROLES),
        parents=np.array([parent for _, parent in ROLES]),
        offsets=np.array([places[role] for role, _ in ROLES]).round(4),
        end_sites=tuple((INDEX[role], place) for role, place in ends) + toes,
        channels=(root, *(turns for _ in ROLES[1:])),
    )


def spelled(role: str, naming: str) -> str:
    """How a naming spells a role.

    >>> spelled("l_knee", "leg"), spelled("l_knee", "knee")
    ('LeftLeg', 'LeftKnee')
    """
    centre, limbs = NAMINGS[naming]
    if role in _CENTRE:
        return centre[_CENTRE.index(role)]
    return {"l": "Left", "r": "Right"}[role[0]] + limbs[_LIMBS.index(role[2:])]
