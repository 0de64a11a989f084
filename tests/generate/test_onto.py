"""Motion on rigs of three conventions (``rigs.py``): errors of feet and hands, and slip."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rigs import RIGS, mixamo
from sample_motions import sample_motion

from motiondb.body import body, changes, kinematics, retarget
from motiondb.database.catalogue.exporting import MotionChanges, write_motion
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.formats import read_capture
from motiondb.generate.onto import at_rest, onto
from motiondb.records import Skeleton


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("name", ["walk_1", "jump_1"])
def test_feet_and_hands_are_kept(rig: str, name: str) -> None:
    source = sample_motion(f"ana/{name}")
    fitted = onto(source, RIGS[rig]())
    fit = fitted.fit
    assert fit.foot_error < 0.006  # metres
    assert fit.most_foot_error < 0.025
    assert fit.hand_error < (0.04 if rig == "Unreal" else 0.012)  # its arms are shorter
    assert fit.slip < fit.slip_of_motion + 0.001
    assert fit.hands == "in place"
    again = retarget.to_motion(fitted.clip)
    away = np.linalg.norm(again.joint_positions() - source.joint_positions(), axis=-1).mean(axis=0)
    assert away.max() < 0.07
    assert away[[body.INDEX["l_ankle"], body.INDEX["r_ankle"]]].max() < 0.015


@pytest.mark.parametrize("rig", RIGS)
def test_bones_keep_their_lengths_and_the_pose_of_the_rig_has_no_rotations(rig: str) -> None:
    made = RIGS[rig]()
    fitted = onto(sample_motion("ana/walk_1"), made)
    places = kinematics.clip_positions(fitted.clip)[0]
    rest = kinematics.clip_positions(fitted.rig)[0][0]
    parents = made.skeleton.parents
    hips = changes.hips_joint(made.skeleton)
    for joint, parent in enumerate(parents):
        if parent >= 0 and joint != hips:
            lengths = np.linalg.norm(places[:, joint] - places[:, parent], axis=-1)
            assert lengths == pytest.approx(np.linalg.norm(rest[joint] - rest[parent]), abs=1e-6)
    world = at_rest(fitted.clip, fitted.rig)
    np.testing.assert_allclose(kinematics.clip_positions(world)[0], places, atol=1e-9)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            way = rest[joint] - rest[parent]
            np.testing.assert_allclose(world.skeleton.offsets[joint], way, atol=1e-9)


def test_a_rig_in_its_own_pose_stays_in_it() -> None:
    rig = mixamo()
    pose = retarget.to_motion(rig)
    fitted = onto(pose, rig)
    places = kinematics.clip_positions(fitted.clip)[0][0]
    rest = kinematics.clip_positions(rig)[0][0]
    rest = rest - rest[0] * [1.0, 0.0, 1.0]
    places = places - places[0] * [1.0, 0.0, 1.0]
    trunk = [not re.search("Arm|Hand", name) for name in rig.skeleton.names]
    assert np.abs(places - rest)[trunk].max() < 0.02  # the heights of ankles differ


def test_hands_follow_the_arm_where_arms_are_much_longer() -> None:
    rig = mixamo()
    offsets = rig.skeleton.offsets.copy()
    for name in ("LeftForeArm", "LeftHand", "RightForeArm", "RightHand"):
        offsets[rig.skeleton.names.index(f"mixamorig:{name}")] *= 1.6
    long = rig.__class__(**{**vars(rig), "skeleton": rig.skeleton.__class__(
        rig.skeleton.names, rig.skeleton.parents, offsets)})  # fmt: skip
    fit = onto(sample_motion("ana/walk_1"), long).fit
    assert fit.hands == "by the arm"
    assert fit.hand_error < 0.02


@pytest.mark.parametrize("rig", RIGS)
def test_a_bvh_file_of_the_rig_is_followed_as_well(rig: str, tmp_path: Path) -> None:
    """Without rotations the bones of some rigs lie as nobody could stand."""
    source, made = sample_motion("ana/walk_1"), RIGS[rig]()
    write_bvh(made, tmp_path / "rig.bvh")
    asked = MotionChanges(onto=tmp_path / "rig.bvh")
    write_motion(source, tmp_path / "out.bvh", asked)
    out = read_capture(tmp_path / "out.bvh")
    again = retarget.to_motion(out)
    away = np.linalg.norm(again.joint_positions() - source.joint_positions(), axis=-1).mean(axis=0)
    assert away.max() < 0.07
    lengths = [
        np.linalg.norm(clip.skeleton.offsets[1:], axis=-1)
        for clip in (out, read_capture(asked.onto))
    ]
    np.testing.assert_allclose(*lengths, atol=1e-6)


def test_a_foot_without_a_toe_rolls_and_does_not_slip() -> None:
    rig = mixamo()
    kept = [n for n, name in enumerate(rig.skeleton.names) if "Toe" not in name]
    place = {old: new for new, old in enumerate(kept)}
    skeleton = Skeleton(
        tuple(rig.skeleton.names[n] for n in kept),
        np.array([place.get(int(rig.skeleton.parents[n]), -1) for n in kept]),
        rig.skeleton.offsets[kept],
    )
    bare = replace(rig, skeleton=skeleton, local_rotations=rig.local_rotations[:, kept])
    fit = onto(sample_motion("ana/walk_1"), bare).fit
    assert fit.slip < fit.slip_of_motion + 0.001
