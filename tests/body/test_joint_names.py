"""Joint names: every convention on a made-up skeleton, user maps, and the messages."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest

from motiondb.body import body
from motiondb.body.joint_names import (
    CONVENTIONS,
    REQUIRED,
    crossed_names,
    joint_map,
    mirror_joints,
    normalised,
    same_names,
)
from motiondb.errors import SkeletonError
from motiondb.records import Skeleton

SPELLINGS = {
    "Visual3D": """pelvis torso neck head l_thigh l_shank l_foot l_toes r_thigh r_shank r_foot
        r_toes l_uarm l_larm l_hand r_uarm r_larm r_hand""",
    "CMU ASF": """root lhipjoint lfemur ltibia lfoot ltoes rhipjoint rfemur rtibia rfoot rtoes
        lowerback upperback thorax lowerneck upperneck head lclavicle lhumerus lradius lwrist lhand
        rclavicle rhumerus rradius rwrist rhand""",
    "CMU BVH": """Hips LHipJoint LeftHip LeftKnee LeftAnkle LeftToe RHipJoint RightHip RightKnee
        RightAnkle RightToe lowerback Chest Chest2 lowerneck Neck Head LeftCollar LeftShoulder
        LeftElbow LeftWrist RightCollar RightShoulder RightElbow RightWrist""",
    "BVH hip-knee-ankle": """Hips Chest Chest2 Neck Head LeftCollar LeftShoulder LeftElbow LeftWrist
        RightCollar RightShoulder RightElbow RightWrist LeftHip LeftKnee LeftAnkle LeftToe RightHip
        RightKnee RightAnkle RightToe""",
    "Mixamo / MotionBuilder": """mixamorig:Hips mixamorig:Spine mixamorig:Spine1 mixamorig:Spine2
        mixamorig:Neck mixamorig:Head mixamorig:LeftShoulder mixamorig:LeftArm
        mixamorig:LeftForeArm mixamorig:LeftHand mixamorig:RightShoulder mixamorig:RightArm
        mixamorig:RightForeArm mixamorig:RightHand mixamorig:LeftUpLeg mixamorig:LeftLeg
        mixamorig:LeftFoot mixamorig:LeftToeBase mixamorig:RightUpLeg mixamorig:RightLeg
        mixamorig:RightFoot mixamorig:RightToeBase""",
    "MotionBuilder without toes and hands": """Neo_Hips Neo_LeftUpLeg Neo_LeftLeg Neo_LeftFoot
        Neo_RightUpLeg Neo_RightLeg Neo_RightFoot Neo_Spine Neo_Spine1 Neo_Spine2 Neo_LeftShoulder
        Neo_LeftArm Neo_LeftForeArm Neo_RightShoulder Neo_RightArm Neo_RightForeArm Neo_Neck
        end:Neo_LeftFoot end:Neo_RightFoot end:Neo_LeftForeArm end:Neo_RightForeArm end:Neo_Neck""",
    "MotionBuilder with two spines": """
        a:b:Hips Hero:Spine Spine1 Neck Head LeftShoulder LeftArm LeftForeArm
        LeftHand RightShoulder RightArm RightForeArm RightHand LeftUpLeg LeftLeg LeftFoot
        LeftToeBase RightUpLeg RightLeg RightFoot RightToeBase""",
    "Poser": """hip abdomen chest neck head rCollar rShldr rForeArm rHand lCollar lShldr lForeArm
        lHand rButtock rThigh rShin rFoot lButtock lThigh lShin lFoot end:rFoot end:lFoot""",
    "Character Creator": """CC_Base_Hip CC_Base_Pelvis CC_Base_L_Thigh CC_Base_L_Calf CC_Base_L_Foot
        CC_Base_L_ToeBaseShareBone CC_Base_L_ToeBase CC_Base_R_Thigh CC_Base_R_Calf CC_Base_R_Foot
        CC_Base_R_ToeBase CC_Base_Waist CC_Base_Spine01 CC_Base_Spine02 CC_Base_NeckTwist01
        CC_Base_NeckTwist02 CC_Base_Head CC_Base_L_Clavicle CC_Base_L_Upperarm CC_Base_L_Forearm
        CC_Base_L_Hand CC_Base_R_Clavicle CC_Base_R_Upperarm CC_Base_R_Forearm CC_Base_R_Hand""",
    "Bandai-Namco": """joint_Root Hips Spine Chest Neck Head Shoulder_L UpperArm_L LowerArm_L Hand_L
        Shoulder_R UpperArm_R LowerArm_R Hand_R UpperLeg_L LowerLeg_L Foot_L Toes_L UpperLeg_R
        LowerLeg_R Foot_R Toes_R""",
    "SMPL": """
        m_avg_Pelvis m_avg_L_Hip R_Hip Spine1 L_Knee R_Knee Spine2 L_Ankle R_Ankle Spine3 L_Foot
        R_Foot
        Neck L_Collar R_Collar Head L_Shoulder R_Shoulder L_Elbow R_Elbow L_Wrist R_Wrist""",
    "DeepMimic": """root chest neck right_hip right_knee right_ankle right_shoulder right_elbow
        left_hip left_knee left_ankle left_shoulder left_elbow end:neck end:right_ankle
        end:left_ankle end:right_elbow end:left_elbow""",
    "3ds Max Biped": """Bip01 Bip01_Pelvis Bip01_Spine Bip01_Spine1 Bip01_Spine2 Bip01_Neck
        Bip01_Head Bip01_L_Clavicle Bip01_L_UpperArm Bip01_L_Forearm Bip01_L_Hand Bip01_R_Clavicle
        Bip01_R_UpperArm Bip01_R_Forearm Bip01_R_Hand Bip01_L_Thigh Bip01_L_Calf Bip01_L_Foot
        Bip01_L_Toe0 Bip01_R_Thigh Bip01_R_Calf Bip01_R_Foot Bip01_R_Toe0""",
    "Xsens BVH": """Hips Chest Chest2 Chest3 Chest4 Neck Head RightCollar RightShoulder RightElbow
        RightWrist LeftCollar LeftShoulder LeftElbow LeftWrist RightHip RightKnee RightAnkle
        RightToe LeftHip LeftKnee LeftAnkle LeftToe""",
    "Rigify": """root DEF-spine DEF-spine.001 DEF-spine.002 DEF-spine.003 DEF-spine.004
        DEF-spine.005 DEF-spine.006 DEF-shoulder.L DEF-upper_arm.L DEF-upper_arm.L.001
        DEF-forearm.L DEF-forearm.L.001 DEF-hand.L DEF-shoulder.R DEF-upper_arm.R
        DEF-upper_arm.R.001 DEF-forearm.R DEF-forearm.R.001 DEF-hand.R DEF-thigh.L DEF-thigh.L.001
        DEF-shin.L DEF-shin.L.001 DEF-foot.L DEF-toe.L DEF-thigh.R DEF-thigh.R.001 DEF-shin.R
        DEF-shin.R.001 DEF-foot.R DEF-toe.R""",
    "Blender": """hips spine chest neck head shoulder.L upper_arm.L forearm.L hand.L shoulder.R
        upper_arm.R forearm.R hand.R thigh.L shin.L foot.L toe.L thigh.R shin.R foot.R toe.R""",
    "Unreal": """root pelvis spine_01 spine_02 spine_03 clavicle_l upperarm_l lowerarm_l hand_l
        clavicle_r upperarm_r lowerarm_r hand_r neck_01 head thigh_l calf_l foot_l ball_l thigh_r
        calf_r foot_r ball_r""",
    "Unity Humanoid": """Hips Spine Chest UpperChest Neck Head LeftShoulder LeftUpperArm
        LeftLowerArm LeftHand RightShoulder RightUpperArm RightLowerArm RightHand LeftUpperLeg
        LeftLowerLeg LeftFoot LeftToes RightUpperLeg RightLowerLeg RightFoot RightToes""",
    "Xsens": """Pelvis L5 L3 T12 T8 Neck Head RightShoulder RightUpperArm RightForeArm RightHand
        LeftShoulder LeftUpperArm LeftForeArm LeftHand RightUpperLeg RightLowerLeg RightFoot
        RightToe LeftUpperLeg LeftLowerLeg LeftFoot LeftToe""",
    "Rokoko": """Hips LeftThigh LeftShin LeftFoot LeftToe LeftToeTip RightThigh RightShin RightFoot
        RightToe RightToeTip Spine1 Spine2 Spine3 Spine4 LeftShoulder LeftArm LeftForeArm LeftHand
        Neck Head RightShoulder RightArm RightForeArm RightHand""",
    "SOMA": """Root Hips Spine1 Spine2 Chest Neck1 Neck2 Head HeadEnd LeftShoulder LeftArm
        LeftForeArm LeftHand RightShoulder RightArm RightForeArm RightHand LeftLeg LeftShin LeftFoot
        LeftToeBase LeftToeEnd RightLeg RightShin RightFoot RightToeBase RightToeEnd""",
    "OptiTrack": """Hip Ab Chest Neck Head LShoulder LUArm LFArm LHand RShoulder RUArm RFArm RHand
        LThigh LShin LFoot LToe RThigh RShin RFoot RToe""",
    "Daz Genesis 3 and 8": """hip pelvis lThighBend lThighTwist lShin lFoot lToe rThighBend
        rThighTwist rShin rFoot rToe abdomenLower abdomenUpper chestLower chestUpper lCollar
        lShldrBend lShldrTwist lForearmBend lForearmTwist lHand rCollar rShldrBend rShldrTwist
        rForearmBend rForearmTwist rHand neckLower neckUpper head""",
    "Daz Genesis 9": """hip pelvis l_thigh l_thightwist1 l_shin l_foot l_toes r_thigh r_thightwist1
        r_shin r_foot r_toes spine1 spine2 spine3 spine4 l_shoulder l_upperarm l_forearm l_hand
        r_shoulder r_upperarm r_forearm r_hand neck1 neck2 head""",
    "MikuMikuDance": """センター 上半身 上半身2 首 頭 左肩 左腕 左ひじ 左手首 右肩 右腕
        右ひじ 右手首 下半身 左足 左ひざ 左足首 左つま先 右足 右ひざ 右足首 右つま先""",
    "German": """Becken Bauch Brust Hals Kopf LinksSchulter LinksOberarm LinksUnterarm LinksHand
        RechtsSchulter RechtsOberarm RechtsUnterarm RechtsHand LinksOberschenkel
        LinksUnterschenkel LinksFuss LinksZehen RechtsOberschenkel RechtsUnterschenkel RechtsFuss
        RechtsZehen""",
    "mocopi": """root torso_1 torso_2 torso_3 torso_4 torso_5 torso_6 torso_7 neck_1 neck_2 head
        l_shoulder l_up_arm l_low_arm l_hand r_shoulder r_up_arm r_low_arm r_hand l_up_leg l_low_leg
        l_foot l_toes r_up_leg r_low_leg r_foot r_toes""",
    "Cascadeur": """pelvis stomach chest neck head clavicle_l arm_l forearm_l hand_l clavicle_r
        arm_r forearm_r hand_r thigh_l calf_l foot_l toe_l thigh_r calf_r foot_r toe_r""",
    "VRChat": """Hips Spine Chest Neck Head Left_shoulder Left_arm Left_elbow Left_wrist
        Right_shoulder Right_arm Right_elbow Right_wrist Left_leg Left_knee Left_ankle Left_toe
        Right_leg Right_knee Right_ankle Right_toe""",
    "motiondb": " ".join(body.JOINTS),
}


def skeleton(spelled: str) -> Skeleton:
    """A skeleton with these joints, and end sites at those named ``end:``."""
    words = spelled.split()
    names = tuple(w for w in words if not w.startswith("end:"))
    ends = tuple((names.index(w[4:]), (0.0, 0.1, 0.0)) for w in words if w.startswith("end:"))
    parents = np.zeros(len(names), dtype=np.int64)
    parents[0] = -1
    return Skeleton(names, parents, np.zeros((len(names), 3)), ends)


def spelled_roles(made: Skeleton) -> dict[str, str]:
    """Role -> normalised name of what the map found."""
    names = [normalised(n) for n in made.names]
    return {
        role: names[j] if j >= 0 else "end:" + names[made.end_sites[-1 - j][0]]
        for role, j in joint_map(made).items()
    }


@pytest.mark.parametrize("convention", list(CONVENTIONS))
def test_a_convention_finds_all_its_roles(convention: str) -> None:
    assert spelled_roles(skeleton(SPELLINGS[convention])) == CONVENTIONS[convention]


def test_required_joints_are_named_when_missing() -> None:
    names = "Hips LeftUpLeg LeftLeg LeftFoot RightUpLeg RightLeg RightFoot Spine1 Spine2 Neck"
    names += " LeftArm LeftForeArm RightArm"
    with pytest.raises(SkeletonError) as caught:
        joint_map(skeleton(names))
    assert str(caught.value) == (
        "skeleton: expected joints for r_elbow, found none among: Hips, LeftUpLeg, LeftLeg, "
        "LeftFoot, RightUpLeg, RightLeg, RightFoot, Spine1, Spine2, Neck, LeftArm, LeftForeArm, "
        "RightArm (nearest convention: Mixamo / MotionBuilder). "
        "Name them in a joint map, lines of `role = joint`; motiondb joints proposes one."
    )


BODY = (
    "Hips< Spine<Hips Chest<Spine Neck<Chest Head<Neck "
    "Shoulder_L<Chest UpperArm_L<Shoulder_L LowerArm_L<UpperArm_L Hand_L<LowerArm_L "
    "Shoulder_R<Chest UpperArm_R<Shoulder_R LowerArm_R<UpperArm_R Hand_R<LowerArm_R "
    "UpperLeg_L<Hips LowerLeg_L<UpperLeg_L Foot_L<LowerLeg_L Toes_L<Foot_L "
    "UpperLeg_R<Hips LowerLeg_R<UpperLeg_R Foot_R<LowerLeg_R Toes_R<Foot_R"
)  # Joint<the joint from which it hangs


def test_a_long_list_of_names_is_cut() -> None:
    with pytest.raises(SkeletonError, match=r"joint39, \.\.\. \(nearest convention"):
        joint_map(skeleton(" ".join(f"joint{n}" for n in range(60))))


def test_a_users_map_fits_any_skeleton() -> None:
    made = skeleton(" ".join(f"bone{n}" for n in range(len(REQUIRED))) + " end:bone0")
    given = {role: f"Bone{n}" for n, role in enumerate(REQUIRED)} | {"head": "end:bone0"}
    actual = joint_map(made, given)
    assert [actual[role] for role in REQUIRED] == list(range(len(REQUIRED)))
    assert actual["head"] == -1


def test_a_users_map_overrides_the_convention() -> None:
    made = skeleton(SPELLINGS["CMU BVH"])
    assert made.names[joint_map(made, {"neck": "Neck"})["neck"]] == "Neck"


@pytest.mark.parametrize(
    ("convention", "given", "text"),
    [
        (
            "SMPL",
            {"l_ellbow": "L_Elbow"},
            f"joint map: expected a role among {', '.join(body.JOINTS)}, found 'l_ellbow'. "
            "Did you mean l_elbow or r_elbow?",
        ),
        (
            "SMPL",
            {"l_elbow": "L_Elbo"},
            "joint map: expected a joint of the skeleton for l_elbow, found 'L_Elbo'. "
            "Did you mean L_Elbow or R_Elbow?",
        ),
        ("Poser", {"l_toe": "end:lFot"}, "found 'end:lFot'. Did you mean end:lFoot or end:rFoot?"),
    ],
)
def test_a_wrong_map_gets_a_suggestion(convention: str, given: dict[str, str], text: str) -> None:
    with pytest.raises(SkeletonError, match=re.escape(text)):
        joint_map(skeleton(SPELLINGS[convention]), given)


@pytest.mark.parametrize(
    ("one", "other", "note"),
    [
        ("Hand_L", "Hand_R", "l_wrist (Hand_L) hangs from r_elbow (LowerArm_R)"),
        ("LowerLeg_R", "Foot_R", "r_knee (LowerLeg_R) hangs from r_ankle (Foot_R)"),
        ("Head", "UpperLeg_L", "l_knee (LowerLeg_L) hangs from head (Head)"),
        ("Head", "UpperArm_L", "l_elbow (LowerArm_L) hangs from head (Head)"),
        ("Hips", "Foot_L", "spine (Spine) hangs from l_ankle (Foot_L)"),
        ("Hand_L", "Hand_L", ""),
    ],
)
def test_exchanged_names_are_noted(one: str, other: str, note: str) -> None:
    parents = dict(pair.split("<") for pair in BODY.split())
    names = [{one: other, other: one}.get(name, name) for name in parents]
    above = np.array([[*parents].index(p) if p else -1 for p in parents.values()])
    made = Skeleton(tuple(names), above, np.zeros((len(names), 3)))
    assert [found.partition(",")[0] for found in crossed_names(made, joint_map(made))] == (
        [note] * bool(note)
    )


def test_another_root_contradicts_nothing() -> None:
    """Rooted at the head, from which the shoulders hang."""
    parts = ("UpperArm", "LowerArm"), ("UpperLeg", "LowerLeg", "Foot")
    limbs = [f"{part}_{side}" for of_limb in parts for side in "LR" for part in of_limb]
    names = ["Head", "Neck", "Chest", "Spine", "Hips", *limbs]
    parents = np.array([-1, 0, 1, 2, 3, 0, 5, 0, 7, 4, 9, 10, 4, 12, 13])
    made = Skeleton(tuple(names), parents, np.zeros((len(names), 3)))
    assert crossed_names(made, joint_map(made)) == ()


def test_joints_without_connections_contradict_nothing() -> None:
    made = skeleton(SPELLINGS["CMU BVH"])
    assert crossed_names(made, joint_map(made)) == ()


MIXAMO = [name.removeprefix("mixamorig:") for name in SPELLINGS["Mixamo / MotionBuilder"].split()]
DECORATED = {
    "a word before": [f"Actor01_{name}" for name in MIXAMO],
    "a name before": [f"Ana_{name}" for name in MIXAMO],
    "a word before without mark": [f"robot{name}" for name in MIXAMO],
    "before all but the root": ["Reference", *(f"Robot_{name}" for name in MIXAMO)],
    "a word after": [f"{name}_jnt" for name in MIXAMO],
    "a number after": [f"{name}.001" for name in MIXAMO],
    "other numbers after": [f"{name}_{n:02}" for n, name in enumerate(MIXAMO)],
    "both": [f"a_{name}_x" for name in MIXAMO],
    "words before": [f"Ana_Rig_{name}" for name in MIXAMO],
    "a word after without mark": [f"{name}Jnt" for name in MIXAMO],
    "small letters alone": [f"actor{name.lower()}" for name in MIXAMO],
    "other numbers before": [f"{n:02}_{name}" for n, name in enumerate(MIXAMO)],
    "a name and other numbers": [f"Ana_{n}_{name}" for n, name in enumerate(MIXAMO)],
    "words before some": [
        *(f"Ana_Rig_{name}" for name in MIXAMO),
        *(f"Hair_{n}" for n in range(30)),
    ],
    "a path": [f"|Bob|{name}" for name in MIXAMO],
    "sides elsewhere": [
        name.replace("Left", "L_").replace("Right", "R_") for name in (f"J_{m}" for m in MIXAMO)
    ],
    "sides behind": [
        re.sub("(Left|Right)(.*)", r"\2_\1", name) for name in (f"J_{m}" for m in MIXAMO)
    ],
}


@pytest.mark.parametrize("how", DECORATED)
def test_what_all_names_share_is_no_part_of_them(how: str) -> None:
    names = DECORATED[how]
    extra = next(n for n, name in enumerate(names) if "hips" in name.lower())
    skeleton = Skeleton(tuple(names), np.arange(len(names)) - 1, np.zeros((len(names), 3)))
    plain = Skeleton(tuple(MIXAMO), np.arange(len(MIXAMO)) - 1, np.zeros((len(MIXAMO), 3)))
    wanted = {role: joint + extra for role, joint in joint_map(plain).items()}
    assert joint_map(skeleton) == wanted


def chain(**renamed: str) -> Skeleton:
    """The canonical body with Mixamo's names, and collars; some are renamed."""
    standard = body.standard_skeleton()
    names = dict(
        zip(
            body.JOINTS,
            [
                "Hips",
                "LeftUpLeg",
                "LeftLeg",
                "LeftFoot",
                "LeftToeBase",
                "RightUpLeg",
                "RightLeg",
                "RightFoot",
                "RightToeBase",
                "Spine",
                "Spine1",
                "Neck",
                "Head",
                "LeftShoulder",
                "LeftArm",
                "LeftForeArm",
                "LeftHand",
                "RightShoulder",
                "RightArm",
                "RightForeArm",
                "RightHand",
            ],
            strict=True,
        )
    )
    return Skeleton(
        tuple((names | renamed)[joint] for joint in body.JOINTS),
        body.PARENTS,
        standard.offsets,
        standard.end_sites,
    )


@pytest.mark.parametrize(
    ("joint", "name", "role"),
    [
        ("l_collar", "LeftArm", "l_shoulder"),
        ("r_collar", "right_arm", "r_shoulder"),
        ("l_toe", "LeftFoot", "l_ankle"),
        ("chest", "Neck", "neck"),
    ],
)
def test_of_two_joints_with_one_name_the_right_one_is_taken_and_told(
    joint: str, name: str, role: str
) -> None:
    skeleton = chain(**{joint: name})
    roles = joint_map(skeleton)
    assert roles[role] == body.INDEX[role]
    note, *_ = same_names(skeleton, roles)
    assert note.startswith("2 joints are called ")
    assert role in note


@pytest.mark.parametrize(
    ("leg", "arm"),
    [("UpperLeg{:02}.{} LowerLeg{:02}.{}", "UpperArm{:02}.{} LowerArm{:02}.{}"),
     ("{1}Hip{0} {1}Knee{0}", "{1}Shoulder{0} {1}Elbow{0}")],
)  # fmt: skip
def test_of_a_bone_in_two_pieces_the_upper_one_is_taken(leg: str, arm: str) -> None:
    names, parents = ["Hips", "Spine", "Neck"], [-1, 0, 1]
    for side, (limb, end, above) in itertools.product("LR", ((leg, "Foot", 0), (arm, "Hand", 1))):
        upper, lower = limb.replace("{1}", side).replace(".{}", f".{side}").split()
        for name in (upper, lower):
            for piece in (1, 2):
                names.append(name.format(piece))
                parents.append(above if (name, piece) == (upper, 1) else len(names) - 2)
        names.append(f"{end}.{side}" if "." in upper else side + end.replace("Foot", "Ankle"))
        parents.append(len(names) - 2)
    offsets = np.full((len(names), 3), 0.1)
    roles = joint_map(Skeleton(tuple(names), np.array(parents), offsets))
    for role in ("l_hip", "l_knee", "r_shoulder", "r_elbow"):
        assert "1" in names[roles[role]], (role, names[roles[role]])


def test_the_neck_may_be_called_as_in_another_program() -> None:
    names = SPELLINGS["Unreal"].replace("neck_01", "Neck")
    roles = joint_map(skeleton(names))
    assert names.split()[roles["neck"]] == "Neck"


def test_of_two_bodies_with_the_same_names_the_one_near_the_root_is_taken() -> None:
    """A puppet hangs from a hand, and comes before the legs in the file."""
    one = chain()
    hand = body.INDEX["l_wrist"]
    order = [*range(hand + 1)], [*range(hand + 1, 21)]
    puppet = np.where(body.PARENTS > 0, body.PARENTS + hand, hand)[1:]
    after = np.where(body.PARENTS[order[1]] > hand, body.PARENTS[order[1]] + 20, 0)
    known = np.where(body.PARENTS[order[1]] <= hand, body.PARENTS[order[1]], after)
    skeleton = Skeleton(
        (*one.names[: hand + 1], *one.names[1:], *one.names[hand + 1 :]),
        np.concatenate([body.PARENTS[: hand + 1], puppet, known]),
        np.concatenate([one.offsets[: hand + 1], one.offsets[1:] * 0.2, one.offsets[hand + 1 :]]),
    )
    at = [*range(hand + 1), *range(hand + 21, 41)]
    roles = joint_map(skeleton)
    assert [roles[role] for role in REQUIRED] == [at[body.INDEX[role]] for role in REQUIRED]


def test_ends_and_the_trunk_are_found_under_names_of_other_programs() -> None:
    skeleton = chain(l_toe="l_ball", spine="Waist", chest="Ribs", head="Skull", l_wrist="hand_l")
    roles = joint_map(skeleton)
    found = ["spine", "chest", "l_wrist", "r_toe"]
    assert [roles[role] for role in found] == [body.INDEX[role] for role in found]
    assert "l_toe" not in roles  # "l_ball" is no name of any convention
    assert joint_map(chain(l_toe="ball_l"))["l_toe"] == body.INDEX["l_toe"]


def test_a_trunk_has_its_roles_under_any_names() -> None:
    """Lengths of Mixamo's X Bot; the collars hang from the last joint of the spine."""
    names = "Hips LeftUpLeg LeftLeg LeftFoot RightUpLeg RightLeg RightFoot Spine Spine1 Spine2 Neck"
    names += " LeftArm LeftForeArm RightArm RightForeArm"
    parents = np.array([-1, 0, 1, 2, 0, 4, 5, 0, 7, 8, 9, 9, 11, 9, 13])
    offsets = np.zeros((15, 3))
    offsets[7:11, 1] = 9.9, 11.7, 13.5, 15.0
    wanted = joint_map(Skeleton(tuple(names.split()), parents, offsets))
    for other in ("Lumbar Ribs Thorax0", "Lumbar Spine1 Ribs", "Lumbar Ribs Spine2"):
        renamed = names.replace("Spine Spine1 Spine2", other)
        assert joint_map(Skeleton(tuple(renamed.split()), parents, offsets)) == wanted, other


def test_sides_are_exchanged_for_all_joints_or_told() -> None:
    names = ("Hips", "UpperLegL", "LowerLegL", "FootL", "UpperLegR", "LowerLegR", "FootR")
    skeleton = Skeleton(names, np.array([-1, 0, 1, 2, 0, 4, 5]), np.zeros((7, 3)))
    assert mirror_joints(skeleton).tolist() == [0, 4, 5, 6, 1, 2, 3]
