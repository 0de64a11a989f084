"""Known orders of joints in arrays of positions, by the program or data set that has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

_FINGERS = ("Thumb", "Index", "Middle", "Ring", "Pinky")
_LEG, _ARM = "{0}UpLeg {0}Leg {0}Foot {0}ToeBase", "{0}Shoulder {0}Arm {0}ForeArm {0}Hand"
_TABLE = """
SMPL:
    Pelvis L_Hip R_Hip Spine1 L_Knee R_Knee Spine2 L_Ankle R_Ankle Spine3 L_Foot R_Foot Neck
    L_Collar R_Collar Head L_Shoulder R_Shoulder L_Elbow R_Elbow L_Wrist R_Wrist
SMPL with hands:
    {SMPL} L_Hand R_Hand
KIT-ML:
    Pelvis Spine1 Spine3 Neck Head L_Shoulder L_Elbow L_Wrist R_Shoulder R_Elbow R_Wrist L_Hip
    L_Knee L_Ankle L_Middle L_Foot R_Hip R_Knee R_Ankle R_Middle R_Foot
Kinect:
    SpineBase SpineMid Neck Head ShoulderLeft ElbowLeft WristLeft HandLeft ShoulderRight ElbowRight
    WristRight HandRight HipLeft KneeLeft AnkleLeft FootLeft HipRight KneeRight AnkleRight FootRight
    SpineShoulder HandTipLeft ThumbLeft HandTipRight ThumbRight
Human3.6M:
    Pelvis R_Hip R_Knee R_Ankle L_Hip L_Knee L_Ankle Spine Neck Nose Head L_Shoulder L_Elbow L_Wrist
    R_Shoulder R_Elbow R_Wrist
Human3.6M (32):
    Pelvis R_Hip R_Knee R_Ankle R_Foot R_FootEnd L_Hip L_Knee L_Ankle L_Foot L_FootEnd Root Spine
    Neck Nose HeadTop LeftBase L_Shoulder L_Elbow L_Wrist L_Hand L_Thumb L_HandEnd L_ThumbEnd
    RightBase R_Shoulder R_Elbow R_Wrist R_Hand R_Thumb R_HandEnd R_ThumbEnd
COCO:
    Nose L_Eye R_Eye L_Ear R_Ear L_Shoulder R_Shoulder L_Elbow R_Elbow L_Wrist R_Wrist L_Hip R_Hip
    L_Knee R_Knee L_Ankle R_Ankle
HALPE:
    {COCO} HeadTop Neck Pelvis L_Foot R_Foot L_SmallToe R_SmallToe L_Heel R_Heel
BODY_25:
    Nose Neck R_Shoulder R_Elbow R_Wrist L_Shoulder L_Elbow L_Wrist Pelvis R_Hip R_Knee R_Ankle
    L_Hip L_Knee L_Ankle R_Eye L_Eye R_Ear L_Ear L_Foot L_SmallToe L_Heel R_Foot R_SmallToe R_Heel
OpenPose's COCO:
    Nose Neck R_Shoulder R_Elbow R_Wrist L_Shoulder L_Elbow L_Wrist R_Hip R_Knee R_Ankle L_Hip
    L_Knee L_Ankle R_Eye L_Eye R_Ear L_Ear
CMU Panoptic:
    Neck Nose Pelvis L_Shoulder L_Elbow L_Wrist L_Hip L_Knee L_Ankle R_Shoulder R_Elbow R_Wrist
    R_Hip R_Knee R_Ankle L_Eye L_Ear R_Eye R_Ear
MPI-INF-3DHP:
    HeadTop Neck R_Shoulder R_Elbow R_Wrist L_Shoulder L_Elbow L_Wrist R_Hip R_Knee R_Ankle L_Hip
    L_Knee L_Ankle Pelvis Spine Head
MediaPipe:
    Nose L_EyeIn L_Eye L_EyeOut R_EyeIn R_Eye R_EyeOut L_Ear R_Ear L_Mouth R_Mouth L_Shoulder
    R_Shoulder L_Elbow R_Elbow L_Wrist R_Wrist L_Pinky R_Pinky L_Index R_Index L_Thumb R_Thumb L_Hip
    R_Hip L_Knee R_Knee L_Ankle R_Ankle L_Heel R_Heel L_Foot R_Foot
Azure Kinect:
    Pelvis Spine1 Spine3 Neck L_Collar L_Shoulder L_Elbow L_Wrist L_Hand L_HandTip L_Thumb R_Collar
    R_Shoulder R_Elbow R_Wrist R_Hand R_HandTip R_Thumb L_Hip L_Knee L_Ankle L_Foot R_Hip R_Knee
    R_Ankle R_Foot Head Nose L_Eye L_Ear R_Eye R_Ear
"""
"""The name of an order, then its joints, of which some are those of an order before it."""


def _read_orders(table: str) -> dict[str, tuple[str, ...]]:
    orders: dict[str, tuple[str, ...]] = {}
    for line in table.strip().splitlines():
        if not line.startswith(" "):
            name = line.removesuffix(":")
            orders[name] = ()
            continue
        for word in line.split():
            orders[name] += orders[word[1:-1]] if word.startswith("{") else (word,)
    return orders


def _hand(side: str, fingers: Sequence[str], ends: Sequence[str]) -> str:
    return " ".join(f"{side}Hand{finger}{end}" for finger in fingers for end in ends)


def _soma(hand: bool) -> str:
    """Names of SOMA's 77 or 30 joints, in Kimodo's order."""
    four = ("1", "2", "3", "4", "End")
    text = "Hips Spine1 Spine2 Chest Neck1 Neck2 Head" + (" HeadEnd" if hand else "")
    text += " Jaw LeftEye RightEye "
    for side in ("Left", "Right"):
        text += _ARM.format(side) + " "
        thumb = _hand(side, ("Thumb",), ("1", "2", "3", "End"))
        ends = f"{side}HandThumbEnd {side}HandMiddleEnd"
        text += f"{thumb} {_hand(side, _FINGERS[1:], four)} " if hand else ends + " "
    for side in ("Left", "Right"):
        text += f"{side}Leg {side}Shin {side}Foot {side}ToeBase " + f"{side}ToeEnd " * hand
    return text


def _g1() -> str:
    """Names of the 34 joints of G1 in Kimodo's order."""
    text = "pelvis_skel "
    for side in ("left", "right"):
        for part in ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll"):
            text += f"{side}_{part}_skel "
        text += f"{side}_toe_base "
    text += "waist_yaw_skel waist_roll_skel waist_pitch_skel "
    for side in ("left", "right"):
        for part in ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow"):
            text += f"{side}_{part}_skel "
        for part in ("wrist_roll", "wrist_pitch", "wrist_yaw", "hand_roll"):
            text += f"{side}_{part}_skel "
    return text


_HANDS = " ".join(
    f"{_ARM.format(side)} {_hand(side, _FINGERS, '123')}" for side in ("Left", "Right")
)
_SMPL_FINGERS = tuple(
    f"{side}_{finger}{n}"
    for side in "LR"
    for finger in ("Index", "Middle", "Pinky", "Ring", "Thumb")
    for n in "123"
)


def _lafan1(sides: Sequence[str]) -> str:
    legs, arms = (" ".join(limb.format(side) for side in sides) for limb in (_LEG, _ARM))
    return f"Hips {legs} Spine Spine1 Spine2 Neck Head {arms}"


def _orders() -> dict[str, tuple[str, ...]]:
    """Return the orders of the table, those with fingers, and those with more behind."""
    orders = _read_orders(_TABLE)
    texts = {
        "LAFAN1": _lafan1(("Left", "Right")),
        "LAFAN1, right first": _lafan1(("Right", "Left")),
        "SOMA (77)": _soma(True),
        "SOMA (30)": _soma(False),
        "Unitree's G1 in Kimodo": _g1(),
        "MotionBuilder with fingers": f"Hips Spine Spine1 Neck Head {_HANDS} "
        + " ".join(_LEG.format(side) for side in ("Left", "Right"))
        + " LeftFootMod RightFootMod",
    }
    orders |= {name: tuple(text.split()) for name, text in texts.items()}
    orders["SMPL-H"] = orders["SMPL"] + _SMPL_FINGERS
    orders["SMPL-X"] = (*orders["SMPL"], "Jaw", "L_Eye", "R_Eye", *_SMPL_FINGERS)
    feet = ("L_Foot", "L_SmallToe", "L_Heel", "R_Foot", "R_SmallToe", "R_Heel")
    for name, first, count in (  # what follows is no part of the body: a face, hands
        ("SMPL with landmarks", orders["SMPL with hands"], 45),
        ("SMPL-X with landmarks (127)", orders["SMPL"], 127),
        ("SMPL-X with landmarks (144)", orders["SMPL"], 144),
        ("COCO-WholeBody", orders["COCO"] + feet, 133),
        ("FreeMoCap with hands and face", orders["MediaPipe"], 553),
    ):
        orders[name] = first + tuple(f"Other{n}" for n in range(count - len(first)))
    return orders


ORDERS: Mapping[str, tuple[str, ...]] = MappingProxyType(_orders())
"""Name of an order -> its joints."""
