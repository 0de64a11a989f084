"""Rigs of this program with the joints of LAFAN1, SOMA, Mixamo and SMPL.

The names and the hierarchy are those of the programs; the proportions are those of the canonical
body, in T-pose, y up, facing +z. SOMA's is without fingers and face.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from motiondb.body import body, rotation
from motiondb.files.readers.amass import skeleton as smpl_skeleton
from motiondb.records import Clip, FloatArray, Skeleton

_TRUNK = {
    "lafan1": "Hips=pelvis Spine=.25 Spine1=.5 Spine2=.75 Neck=neck Head=head",
    "mixamo": "Hips=pelvis Spine=.25 Spine1=.5 Spine2=.75 Neck=neck Head=head",
    "soma": "Hips=pelvis Spine1=.25 Spine2=.5 Chest=.75 Neck1=neck Neck2=1.1 Head=head",
}  # Joint = role, or share of the way from the pelvis to the neck; each hangs from the one before
_LIMBS = {
    "lafan1": ("UpLeg Leg Foot Toe", "Shoulder Arm ForeArm Hand"),
    "mixamo": ("UpLeg Leg Foot ToeBase", "Shoulder Arm ForeArm Hand"),
    "soma": ("Leg Shin Foot ToeBase", "Shoulder Arm ForeArm Hand"),
}
_ROLES = (("hip", "knee", "ankle", "toe"), ("collar", "shoulder", "elbow", "wrist"))
_PREFIX: Mapping[str, str] = MappingProxyType({"mixamo": "mixamorig:"})
OWN_RIGS = ("lafan1", "soma", "mixamo", "smpl")
"""Names of the rigs."""


def own_rig(name: str) -> Clip:
    """Return a rig of this program in T-pose, one of ``OWN_RIGS``.

    >>> own_rig("mixamo").joint_names[:3], len(own_rig("smpl").joint_names)
    (('mixamorig:Hips', 'mixamorig:Spine', 'mixamorig:Spine1'), 22)
    """
    skeleton = smpl_skeleton() if name == "smpl" else _skeleton(name)
    still = np.tile(rotation.IDENTITY, (1, len(skeleton.names), 1))
    height = body.LEG_LENGTH + body.ANKLE_HEIGHT
    return Clip(
        skeleton, 30.0, still, np.array([[0.0, height, 0.0]]), unit=0.01, up="y", format="bvh"
    )


def _skeleton(name: str) -> Skeleton:
    at = _places()
    names, parents, places = list[str](), list[int](), list[FloatArray]()
    ends: list[tuple[int, tuple[float, float, float]]] = []

    def add(joint: str, parent: int, place: FloatArray, role: str) -> int:
        names.append(_PREFIX.get(name, "") + joint)
        parents.append(parent)
        places.append(place)
        for number, offset in body.END_SITES:
            if body.JOINTS[number] == role:
                ends.append((len(names) - 1, offset))
        return len(names) - 1

    joint, trunk = -1, list[int]()
    for entry in _TRUNK[name].split():
        label, _, role = entry.partition("=")
        share = float(role) if role not in at else 0.0
        place = at[role] if role in at else at["pelvis"] + share * (at["neck"] - at["pelvis"])
        joint = add(label, joint, place, role)
        trunk.append(joint)
    chest = trunk[3]
    for limb, roles, start in zip(_LIMBS[name], _ROLES, (trunk[0], chest)):
        for side in ("Left", "Right"):
            joint = start
            for part, role in zip(limb.split(), roles):
                of_side = f"{side[0].lower()}_{role}"
                joint = add(side + part, joint, at[of_side], of_side)
    above = np.array(parents)
    where = np.array(places)
    offsets = np.where(above[:, None] >= 0, where - where[above.clip(0)], 0.0)
    return Skeleton(tuple(names), above, offsets, tuple(ends))


def _places() -> dict[str, FloatArray]:
    """Return where the joints of the canonical body are in its rest pose."""
    at: dict[str, FloatArray] = {}
    for number, joint in enumerate(body.JOINTS):
        parent = int(body.PARENTS[number])
        above = at[body.JOINTS[parent]] if parent >= 0 else np.zeros(3)
        at[joint] = above + body.OFFSETS[number]
    return at
