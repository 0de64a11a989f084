"""Joint maps that are proposed for names of no convention."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motiondb.body import body
from motiondb.body.joint_names import joint_map
from motiondb.body.joint_proposals import map_text, propose_map
from motiondb.errors import SkeletonError

NAMES = {
    "studio": (
        "b_Hips_x b_LeftThigh_x b_LeftShin_x b_LeftFoot_x b_LeftToe_x b_RightThigh_x b_RightShin_x "
        "b_RightFoot_x b_RightToe_x b_Spine_x b_Chest_x b_Neck_x b_Head_x b_LeftClav_x b_LeftArm_x "
        "b_LeftForeArm_x b_LeftHand_x b_RightClav_x b_RightArm_x b_RightForeArm_x b_RightHand_x"
    ),
    "parts first": (
        "cog leg_upper_l leg_lower_l foot_l ball_l leg_upper_r leg_lower_r foot_r ball_r spine1 "
        "spine2 neck head clavicle_l arm_upper_l arm_lower_l hand_l clavicle_r arm_upper_r "
        "arm_lower_r hand_r"
    ),
    "short": (
        "base L_leg L_knee L_ankle L_toe R_leg R_knee R_ankle R_toe waist torso neck skull L_clav "
        "L_arm L_elbow L_wrist R_clav R_arm R_elbow R_wrist"
    ),
}


@pytest.mark.parametrize("style", NAMES)
def test_every_role_is_proposed(style: str) -> None:
    names = tuple(NAMES[style].split())
    skeleton = replace(body.standard_skeleton(), names=names)
    if style == "parts first":  # the others are of a convention, but for what all joints share
        with pytest.raises(SkeletonError):
            joint_map(skeleton)
    proposed = propose_map(skeleton)
    for role, name in proposed.items():
        assert name == names[body.INDEX[role]], role
    left = set(body.JOINTS) - set(proposed)
    assert left == {"pelvis", "l_collar", "r_collar"}
    assert joint_map(skeleton, proposed)


def test_the_map_lists_what_is_missing() -> None:
    names = (*(f"joint{number}" for number in range(20)), "HandLeft")
    text = map_text(replace(body.standard_skeleton(), names=names), "a.fbx")
    assert "# l_knee = ? (needed)\n" in text
    assert "# l_toe = ?\n" in text
    assert "#   joint7\n" in text
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert lines == ["l_wrist = HandLeft"]


LETTERS = {
    "one letter": ("UArm FArm Hand", "ULeg LLeg Foot"),
    "long": ("UpArm LowArm Wrist", "Thigh Shin Foot"),
    "anatomy": ("Humerus Radius Hand", "Femur Tibia Foot"),
}


@pytest.mark.parametrize("before", ["", "Ana_"])
@pytest.mark.parametrize("style", LETTERS)
def test_both_sides_get_the_same_words(style: str, before: str) -> None:
    arm, leg = (words.split() for words in LETTERS[style])
    names = list(body.JOINTS)
    for side in "lr":
        for parts, words in (
            (("shoulder", "elbow", "wrist"), arm),
            (("hip", "knee", "ankle"), leg),
        ):
            for part, word in zip(parts, words, strict=True):
                names[body.INDEX[f"{side}_{part}"]] = before + side.upper() + word
        names[body.INDEX[f"{side}_collar"]] = f"{side.upper()}Shoulder"
    proposed = propose_map(replace(body.standard_skeleton(), names=tuple(names)))
    for side in "lr":
        for part in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle"):
            role = f"{side}_{part}"
            assert proposed[role] == names[body.INDEX[role]]
