"""A capture in the names of each program, written by the test, read back, and brought on the body.

The body is the canonical one in a pose in which no two limbs are alike; the joints bear the names
of the program, and those that the canonical body lacks (more spines, twists, tips) stand between.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motiondb.body import body, kinematics, retarget, rotation
from motiondb.files import read_capture, write_bvh
from motiondb.records import Clip, Skeleton

LIMBS = ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist")
PROGRAMS = {
    "Rigify": (
        "DEF-spine DEF-spine.001 DEF-spine.003 DEF-spine.004 DEF-spine.006 DEF-shoulder.*",
        "DEF-thigh.* DEF-shin.* DEF-foot.* DEF-toe.* DEF-upper_arm.* DEF-forearm.* DEF-hand.*",
        "LR",
    ),
    "Rigify metarig": (
        "spine spine.001 spine.003 spine.004 spine.006 shoulder.*",
        "thigh.* shin.* foot.* toe.* upper_arm.* forearm.* hand.*",
        "LR",
    ),
    "Blender": (
        "hips spine chest neck head shoulder.*",
        "thigh.* shin.* foot.* toe.* upper_arm.* forearm.* hand.*",
        "LR",
    ),
    "Unreal": (
        "pelvis spine_01 spine_03 neck_01 head clavicle_*",
        "thigh_* calf_* foot_* ball_* upperarm_* lowerarm_* hand_*",
        "lr",
    ),
    "Unity Humanoid": (
        "Hips Spine Chest Neck Head *Shoulder",
        "*UpperLeg *LowerLeg *Foot *Toes *UpperArm *LowerArm *Hand",
        ("Left", "Right"),
    ),
    "Xsens": (
        "Pelvis L5 T12 Neck Head *Shoulder",
        "*UpperLeg *LowerLeg *Foot *Toe *UpperArm *ForeArm *Hand",
        ("Left", "Right"),
    ),
    "Xsens BVH": (
        "Hips Chest Chest3 Neck Head *Collar",
        "*Hip *Knee *Ankle *Toe *Shoulder *Elbow *Wrist",
        ("Left", "Right"),
    ),
    "Rokoko": (
        "Hips Spine1 Spine3 Neck Head *Shoulder",
        "*Thigh *Shin *Foot *Toe *Arm *ForeArm *Hand",
        ("Left", "Right"),
    ),
    "Vicon Shogun": (
        "Hips Spine1 Spine2 Neck Head *Shoulder",
        "*UpLeg *Leg *Foot *ToeBase *Arm *ForeArm *Hand",
        ("Left", "Right"),
    ),
}


def names_of(program: str) -> tuple[str, ...]:
    """The program's names in the order of the canonical joints."""
    trunk, limbs, sides = PROGRAMS[program]
    pelvis, spine, chest, neck, head, collar = trunk.split()
    names = {"pelvis": pelvis, "spine": spine, "chest": chest, "neck": neck, "head": head}
    for side, spelled in zip("lr", sides):
        names[f"{side}_collar"] = collar.replace("*", spelled)
        names |= {
            f"{side}_{role}": name.replace("*", spelled) for role, name in zip(LIMBS, limbs.split())
        }
    return tuple(names[joint] for joint in body.JOINTS)


def pose() -> np.ndarray:
    """Local rotations (10, 21, 4) that turn every joint by up to 20 degrees, each its own way."""
    angles = np.random.default_rng(7).uniform(-20, 20, (1, len(body.JOINTS), 3))
    return np.tile(rotation.from_euler(angles, "ZYX"), (10, 1, 1))


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_capture_of_the_program_has_its_joints_where_they_belong(
    tmp_path: Path, program: str
) -> None:
    standard = body.standard_skeleton()
    skeleton = Skeleton(
        names_of(program), standard.parents, standard.offsets, standard.end_sites, standard.channels
    )
    root = np.tile([0.0, 0.93, 0.0], (10, 1))
    clip = Clip(skeleton, 30.0, pose(), root, unit=0.01)
    write_bvh(clip, tmp_path / "take.bvh")
    again = read_capture(tmp_path / "take.bvh")
    assert again.skeleton.names == (
        *(names_of(program)[joint] for joint in range(len(body.JOINTS))),
    )
    expected, _ = kinematics.clip_positions(clip)
    points = retarget.clip_keypoints(again)
    for joint, name in enumerate(body.JOINTS):
        if "collar" not in name:  # collars are placed by the neck and the shoulder
            np.testing.assert_allclose(
                points[:, joint], expected[:, joint], atol=1e-4, err_msg=name
            )
    assert retarget.to_motion(again).leg_length == pytest.approx(body.LEG_LENGTH, abs=1e-3)
