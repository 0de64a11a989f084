"""Positions alone: names beside them, known orders, Kimodo's and HumanML3D's arrays."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motiondb.body import body, hinges, kinematics, retarget, rotation
from motiondb.errors import CaptureError
from motiondb.files.formats import read_capture
from motiondb.files.readers.point_motion import ORDERS, humanml3d_positions
from motiondb.files.readers.robot_model import read_robot
from motiondb.files.rigs import own_rig
from motiondb.generate.onto import onto
from motiondb.records import FloatArray, Motion
from tests import small_robot


def _walk() -> Motion:
    robot = read_robot(small_robot.urdf().encode(), "small")
    posed = hinges.pose(robot, *small_robot.walk())
    return retarget.to_motion(hinges.to_clip(robot, posed, 30.0))


def _positions(rig: str) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """The walk on a rig: names, places (frames, joints, 3), turns (frames, joints, 4)."""
    clip = onto(_walk(), own_rig(rig)).clip
    return clip.joint_names, clip.world_positions(), clip.world_rotations()


def _z_up(points: FloatArray) -> FloatArray:
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([x, -z, y], axis=-1)


def test_orders_have_the_numbers_of_joints_that_their_programs_have() -> None:
    sizes = {name: len(order) for name, order in ORDERS.items()}
    assert sizes == {
        "SMPL": 22,
        "SMPL with hands": 24,
        "SMPL-H": 52,
        "LAFAN1": 22,
        "LAFAN1, right first": 22,
        "SOMA (77)": 77,
        "SOMA (30)": 30,
        "Unitree's G1 in Kimodo": 34,
        "Kinect": 25,
        "Human3.6M": 17,
        "Human3.6M (32)": 32,
        "COCO": 17,
        "COCO-WholeBody": 133,
        "HALPE": 26,
        "BODY_25": 25,
        "OpenPose's COCO": 18,
        "CMU Panoptic": 19,
        "MPI-INF-3DHP": 17,
        "MediaPipe": 33,
        "FreeMoCap with hands and face": 553,
        "Azure Kinect": 32,
        "SMPL with landmarks": 45,
        "SMPL-X": 55,
        "SMPL-X with landmarks (127)": 127,
        "SMPL-X with landmarks (144)": 144,
        "KIT-ML": 21,
        "MotionBuilder with fingers": 53,
    }
    assert all(len({*order}) == len(order) for order in ORDERS.values())


@pytest.mark.parametrize(
    ("rig", "order"), [("smpl", "SMPL"), ("lafan1", "LAFAN1"), ("lafan1", "LAFAN1, right first")]
)
def test_the_order_under_which_limbs_keep_their_lengths_is_taken_and_told(
    rig: str, order: str, tmp_path: Path
) -> None:
    names, points, _ = _positions(rig)
    at = [names.index(name.replace("ToeBase", "Toe")) for name in ORDERS[order]]
    np.save(tmp_path / "w.npy", _z_up(points[:, at]))
    clip = read_capture(tmp_path / "w.npy", up="z")
    assert f"its 22 are taken in the order of {order}, under which" in clip.notes[0]
    assert clip.notes[1].startswith("The file has no frame rate; 30 frames a second are taken.")
    mine, theirs = retarget.clip_keypoints(clip), retarget.to_motion(clip).joint_positions()
    hips = names.index("L_Hip" if rig == "smpl" else "LeftUpLeg")
    np.testing.assert_allclose(mine[:, 1], points[:, hips], atol=0.02)
    assert theirs[:, :, 1].max() > 1.3  # it stands


ROLES = {"Hip": "hip", "Knee": "knee", "Ankle": "ankle", "Shoulder": "shoulder", "Elbow": "elbow"}
ROLES |= {"Wrist": "wrist", "Foot": "toe"}


@pytest.mark.parametrize(
    "order", [name for name, joints in ORDERS.items() if "L_Hip" in joints and name != "SMPL"]
)
def test_a_body_in_any_order_has_its_limbs_where_they_were(order: str, tmp_path: Path) -> None:
    """Joints that no order shares with the body (eyes, hands) are at its head."""
    at = dict(zip(body.JOINTS, _walk().joint_positions().transpose(1, 0, 2)))
    at |= {"l_": at["head"], "r_": at["head"]}
    trunk = {"Pelvis": "pelvis", "Spine1": "spine", "Spine": "spine", "Spine3": "chest"}
    trunk |= {"Neck": "neck"}
    spelt = [
        f"{n[0].lower()}_{ROLES.get(n[2:], '')}" if n[:2] in ("L_", "R_") else trunk.get(n, "head")
        for n in ORDERS[order]
    ]
    np.save(tmp_path / "w.npy", np.stack([at[role] for role in spelt], axis=1))
    clip = read_capture(tmp_path / "w.npy", up="y")
    assert any(f"in the order of {order}, under which" in note for note in clip.notes)
    assert clip.fps == (12.5 if order == "KIT-ML" else 30.0)
    found = retarget.clip_keypoints(clip)
    for part in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist"):
        for side in "lr":
            place = found[:, body.INDEX[f"{side}_{part}"]]
            np.testing.assert_allclose(place, at[f"{side}_{part}"], atol=0.01)


def test_the_rate_follows_from_what_only_one_program_writes(tmp_path: Path) -> None:
    _, points, _ = _positions("smpl")
    names = [name.replace("ToeBase", "Toe") for name in ORDERS["SMPL"]]
    points = points[:, [_positions("smpl")[0].index(name) for name in names]]
    left = points[0, 1] - points[0, 2] + points[0, 16] - points[0, 17]
    turn = rotation.from_axis_angle([0.0, 1.0, 0.0], np.arctan2(left[2], left[0]))
    points = rotation.rotate(turn, points - points[0, 0] * [1.0, 0.0, 1.0])
    np.save(tmp_path / "w.npy", points)
    clip = read_capture(tmp_path / "w.npy", up="y")
    assert clip.fps == 20.0
    assert clip.notes[1].startswith("The file has no frame rate; 20 frames a second are taken, as")
    coco = np.random.default_rng(0).normal(size=(9, 17, 3))
    (tmp_path / "d.pkl").write_bytes(pickle.dumps({"keypoints3d_optim": coco}))
    with pytest.raises(CaptureError, match="or a known order whose"):
        read_capture(tmp_path / "d.pkl")


@pytest.mark.parametrize("axis", [0, 1])
def test_several_bodies_in_one_array_are_named(axis: int, tmp_path: Path) -> None:
    np.save(tmp_path / "w.npy", np.stack([np.zeros((20, 22, 3))] * 2, axis=axis))
    with pytest.raises(CaptureError, match="expected positions of one body, found 2 in an array"):
        read_capture(tmp_path / "w.npy")


def test_zeros_are_lost_points_but_at_the_root(tmp_path: Path) -> None:
    names, points, _ = _positions("mixamo")
    wrist, points = names.index("mixamorig:LeftHand"), points + np.array([0.5, 0.0, 0.3])
    lost = points.copy()
    lost[20:26, wrist] = 0.0
    lost[3] = 0.0
    clips = []
    for each in (points, lost, points - points[:, :1], points - points[0, 0]):
        np.savez(tmp_path / "w.npz", positions=each, joint_names=np.array(names), fps=30)
        clips.append(read_capture(tmp_path / "w.npz", up="y").world_positions())
    np.testing.assert_allclose(clips[1], clips[0], atol=0.06)  # the arm swings
    for relative in clips[2:]:
        np.testing.assert_allclose(*(c - c[:, :1] for c in (relative, clips[0])), atol=1e-6)


def test_names_beside_a_file_hold_and_must_be_as_many_as_its_joints(tmp_path: Path) -> None:
    names, points, _ = _positions("mixamo")
    order = np.random.default_rng(2).permutation(len(names))
    np.save(tmp_path / "w.npy", points[:, order])
    with pytest.raises(CaptureError, match="expected names of the joints, or a known order whose"):
        read_capture(tmp_path / "w.npy")
    listed = "\n".join(names[n] for n in order)
    (tmp_path / "joint_names.txt").write_text(listed)
    clip = read_capture(tmp_path / "w.npy", fps=30)
    assert not any("order" in note for note in clip.notes)
    knee = retarget.clip_keypoints(clip)[:, 2]
    np.testing.assert_allclose(knee, points[:, names.index("mixamorig:LeftLeg")], atol=1e-6)
    (tmp_path / "joint_names.txt").write_text(listed + "\nmore")
    with pytest.raises(CaptureError, match="expected names of 22 joints, found 23"):
        read_capture(tmp_path / "w.npy")


def _kimodo(names: tuple[str, ...], points: FloatArray, turns: FloatArray, path: Path) -> None:
    found: dict[str, Any] = {
        "posed_joints": points,
        "global_rot_mats": rotation.to_matrix(turns),
        "foot_contacts": np.zeros((len(points), 4)),
    }
    np.savez(path, **found)


def test_kimodo_s_soma_is_read_with_y_up(tmp_path: Path) -> None:
    names, points, turns = _positions("soma")
    order = ORDERS["SOMA (30)"]
    at = [names.index(name) if name in names else names.index("Head") for name in order]
    _kimodo(order, points[:, at], turns[:, at], tmp_path / "m.npz")
    clip = read_capture(tmp_path / "m.npz")
    assert "in the order of SOMA (30)" in clip.notes[0]
    knee = retarget.clip_keypoints(clip)[:, 2]
    np.testing.assert_allclose(knee, points[:, names.index("LeftShin")], atol=1e-6)


def test_kimodo_s_g1_is_read_as_a_robot(tmp_path: Path) -> None:
    robot = read_robot(small_robot.urdf().encode(), "small")
    clip = hinges.to_clip(robot, hinges.pose(robot, *small_robot.walk()), 30.0)
    places, turns = kinematics.clip_positions(clip)
    known = {name.removesuffix("_joint"): n for n, name in enumerate(clip.joint_names)}
    at = []
    for name in ORDERS["Unitree's G1 in Kimodo"]:
        part = name.removesuffix("_skel").replace("toe_base", "ankle_roll")
        part = part.replace("hand_roll", "hand")
        side = part.partition("_")[0]
        found = known.get(part, known[f"{side}_hand"] if "wrist" in part else known["torso"])
        at.append(known["pelvis"] if part == "pelvis" else found)
    _kimodo((), places[:, at], turns[:, at], tmp_path / "m.npz")
    read = read_capture(tmp_path / "m.npz")
    assert read.format == "robot"
    actual, expected = (retarget.clip_keypoints(each) for each in (read, clip))
    limbs = [1, 2, 3, 5, 6, 7, 14, 15, 18, 19]
    np.testing.assert_allclose(actual[:, limbs], expected[:, limbs], atol=1e-6)


def test_humanml3d_numbers_become_positions() -> None:
    # Three frames: a turn by 60 degrees (half angles are summed) and a metre along the own z
    numbers = np.zeros((3, 263))
    numbers[0, :4] = [np.deg2rad(30.0), 0.0, 1.0, 0.9]
    numbers[1:, 3] = 0.9
    numbers[:, 4:7] = [0.1, 0.8, 0.0]
    points = humanml3d_positions(numbers)
    assert points.shape == (3, 22, 3)
    np.testing.assert_allclose(points[0, :2], [[0.0, 0.9, 0.0], [0.1, 0.8, 0.0]], atol=1e-12)
    way = np.array([-np.sin(np.pi / 3.0), 0.0, np.cos(np.pi / 3.0)])
    np.testing.assert_allclose(points[1, 0], way + np.array([0.0, 0.9, 0.0]), atol=1e-12)
    left = np.array([np.cos(np.pi / 3.0), 0.0, np.sin(np.pi / 3.0)])
    np.testing.assert_allclose(
        points[1, 1], way + 0.1 * left + np.array([0.0, 0.8, 0.0]), atol=1e-12
    )
    np.testing.assert_allclose(points[2], points[1], atol=1e-12)


def test_normalised_numbers_of_humanml3d_are_named(tmp_path: Path) -> None:
    np.save(tmp_path / "w.npy", np.random.default_rng(0).normal(size=(40, 263)))
    with pytest.raises(CaptureError, match=r"multiply them by Std\.npy and add Mean\.npy"):
        read_capture(tmp_path / "w.npy")


def test_a_confidence_beside_places_is_left_out(tmp_path: Path) -> None:
    names, points, _ = _positions("mixamo")
    seen = np.full((*points.shape[:2], 1), 0.9)
    seen[20:23, names.index("mixamorig:LeftHand")] = 0.0
    clips = []
    for each in (points, np.where(seen > 0.0, points, np.nan), np.concatenate([points, seen], 2)):
        np.savez(tmp_path / "w.npz", keypoints3d=each, joint_names=np.array(names), fps=30)
        clips.append(read_capture(tmp_path / "w.npz", up="y").world_positions())
    np.testing.assert_array_equal(clips[2], clips[1])
    np.testing.assert_allclose(clips[2], clips[0], atol=0.06)


def test_quaternions_are_no_places_with_a_confidence(tmp_path: Path) -> None:
    names = _positions("mixamo")[0]
    turns = np.random.default_rng(0).normal(size=(40, len(names), 4))
    turns /= np.linalg.norm(turns, axis=2, keepdims=True) * np.sign(turns[..., 3:])
    np.savez(tmp_path / "w.npz", positions=turns, joint_names=np.array(names), fps=30)
    with pytest.raises(CaptureError, match=r"expected positions of shape \(frames, joints, 3\)"):
        read_capture(tmp_path / "w.npz")


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.zeros((10, 22, 2)), "expected positions of shape (frames, joints, 3)"),
        (np.zeros((10, 13, 3)), "or a known order of 13 (known: 17, 18, 19, 21"),
        (np.full((10, 22, 3), np.nan), "or a known order whose limbs keep their lengths"),
        (np.zeros((0, 22, 3)), "expected positions of shape"),
    ],
)
def test_other_arrays_are_refused(array: FloatArray, said: str, tmp_path: Path) -> None:
    np.save(tmp_path / "w.npy", array)
    with pytest.raises(CaptureError) as error:
        read_capture(tmp_path / "w.npy")
    assert said in str(error.value)
