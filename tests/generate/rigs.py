"""Rigs of three conventions, built by hand: each a clip of one frame, the pose of the rig."""

from __future__ import annotations

import numpy as np

from motiondb.body import rotation
from motiondb.records import Clip, Skeleton

Rows = list[tuple[str, str, tuple[float, float, float]]]  # Joint, parent, place in the world (cm)


def _both(rows: Rows, left: str, right: str) -> Rows:
    """Rows of the left side, and their mirror images with other names."""
    other = [
        (n.replace(left, right), p.replace(left, right), (-x, y, z)) for n, p, (x, y, z) in rows
    ]
    return rows + other


def _clip(rows: Rows, turns: dict[str, np.ndarray] | None = None, z_up: bool = False) -> Clip:
    """A clip of one frame; ``turns``: the rotations of joints in the world, else none."""
    names = [name for name, _, _ in rows]
    parents = np.array([names.index(p) if p else -1 for _, p, _ in rows])
    places = np.array([place for _, _, place in rows]) / 100.0
    world = np.array([(turns or {}).get(name, rotation.IDENTITY) for name in names])
    if z_up:
        turn = rotation.from_euler([90.0], "X")
        places, world = rotation.rotate(turn, places), rotation.multiply(turn, world)
    local, offsets = world.copy(), places.copy()
    for joint, parent in enumerate(parents):
        if parent >= 0:
            local[joint] = rotation.relative(world[parent], world[joint])
            back = rotation.conjugate(world[parent])
            offsets[joint] = rotation.rotate(back, places[joint] - places[parent])
    offsets[0] = 0.0
    skeleton = Skeleton(tuple(names), parents, offsets)
    return Clip(skeleton, 30.0, local[None], places[None, 0], unit=0.01)


def mixamo() -> Clip:
    """Mixamo: T-pose, 1.75 m, long arms; every joint has its own axes, along its bone."""
    rows: Rows = [
        ("mixamorig:Hips", "", (0, 100, 0)),
        ("mixamorig:Spine", "mixamorig:Hips", (0, 110, 1)),
        ("mixamorig:Spine1", "mixamorig:Spine", (0, 122, 1)),
        ("mixamorig:Spine2", "mixamorig:Spine1", (0, 135, 0)),
        ("mixamorig:Neck", "mixamorig:Spine2", (0, 150, 0)),
        ("mixamorig:Head", "mixamorig:Neck", (0, 160, 2)),
        ("mixamorig:HeadTop_End", "mixamorig:Head", (0, 178, 3)),
    ]
    sides: Rows = [
        ("mixamorig:LeftShoulder", "mixamorig:Spine2", (5, 145, 0)),
        ("mixamorig:LeftArm", "mixamorig:LeftShoulder", (18, 145, -1)),
        ("mixamorig:LeftForeArm", "mixamorig:LeftArm", (47, 145, -2)),
        ("mixamorig:LeftHand", "mixamorig:LeftForeArm", (74, 145, -1)),
        ("mixamorig:LeftHandIndex1", "mixamorig:LeftHand", (84, 145, 2)),
        ("mixamorig:LeftUpLeg", "mixamorig:Hips", (9, 95, 0)),
        ("mixamorig:LeftLeg", "mixamorig:LeftUpLeg", (9, 52, 0)),
        ("mixamorig:LeftFoot", "mixamorig:LeftLeg", (9, 9, -2)),
        ("mixamorig:LeftToeBase", "mixamorig:LeftFoot", (9, 2, 11)),
    ]
    rows += _both(sides, "Left", "Right")
    rng = np.random.default_rng(1)
    turns = {name: rotation.exp(rng.normal(size=3)) for name, _, _ in rows}
    return _clip(rows, turns)


def cmu() -> Clip:
    """The CMU BVH files: arms down at the sides by 20 degrees, short, 1.6 m."""
    rows: Rows = [
        ("Hips", "", (0, 90, 0)),
        ("Chest", "Hips", (0, 100, 0)),
        ("Chest2", "Chest", (0, 112, -1)),
        ("LowerNeck", "Chest2", (0, 132, -1)),
        ("Neck", "LowerNeck", (0, 136, 0)),
        ("Head", "Neck", (0, 142, 1)),
    ]
    sides: Rows = [
        ("LeftCollar", "LowerNeck", (1, 131, 0)),
        ("LeftShoulder", "LeftCollar", (15, 128, -1)),
        ("LeftElbow", "LeftShoulder", (38, 120, -1)),
        ("LeftWrist", "LeftElbow", (58, 113, 0)),
        ("LeftHip", "Hips", (8, 86, 0)),
        ("LeftKnee", "LeftHip", (9, 46, 1)),
        ("LeftAnkle", "LeftKnee", (9, 7, -1)),
        ("LeftToe", "LeftAnkle", (10, 1.5, 11)),
    ]
    return _clip(rows + _both(sides, "Left", "Right"))


def unreal() -> Clip:
    """Unreal's mannequin: z up, a root on the ground, five spines, A-pose, twist and IK bones."""
    rows: Rows = [
        ("root", "", (0, 0, 0)),
        ("pelvis", "root", (0, 97, 0)),
        ("spine_01", "pelvis", (0, 101, 0)),
        ("spine_02", "spine_01", (0, 108, 1)),
        ("spine_03", "spine_02", (0, 118, 1)),
        ("spine_04", "spine_03", (0, 126, 0)),
        ("spine_05", "spine_04", (0, 136, -1)),
        ("neck_01", "spine_05", (0, 154, -3)),
        ("neck_02", "neck_01", (0, 159, -2)),
        ("head", "neck_02", (0, 164, 0)),
        ("ik_foot_root", "root", (0, 0, 0)),
    ]
    sides: Rows = [
        ("clavicle_l", "spine_05", (3, 150, -2)),
        ("upperarm_l", "clavicle_l", (18, 147, -4)),
        ("upperarm_twist_01_l", "upperarm_l", (26, 137, -4)),
        ("lowerarm_l", "upperarm_l", (36, 125, -5)),
        ("hand_l", "lowerarm_l", (53, 105, 3)),
        ("thigh_l", "pelvis", (10, 95, 0)),
        ("thigh_twist_01_l", "thigh_l", (11, 75, 0)),
        ("calf_l", "thigh_l", (13, 51, -1)),
        ("foot_l", "calf_l", (15, 9, -4)),
        ("ball_l", "foot_l", (16, 2, 11)),
    ]
    rows += _both(sides, "_l", "_r")
    rng = np.random.default_rng(2)
    turns = {name: rotation.exp(rng.normal(size=3)) for name, _, _ in rows}
    return _clip(rows, turns, z_up=True)


RIGS = {"Mixamo": mixamo, "CMU BVH": cmu, "Unreal": unreal}
