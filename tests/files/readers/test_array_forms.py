"""Arrays in forms of their own: MDM, Motion-X, MimicKit, poselib; several bodies in one file."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motiondb.body import hinges, kinematics, rotation
from motiondb.errors import CaptureError
from motiondb.files.folder import find_captures
from motiondb.files.formats import read_capture
from motiondb.files.readers.amass import read_amass
from motiondb.files.readers.robot_model import read_robot
from motiondb.records import Clip, FloatArray
from tests import small_robot
from tests.files.odd_npz import as_member, good_arrays, packed

FRAMES = 12


def saved(path: Path, value: Any) -> Clip:
    """Write a value as a npy of a dictionary or as a pickle, and read it."""
    if path.suffix == ".npy":
        np.save(path, value)
    else:
        path.write_bytes(pickle.dumps(value))
    assert find_captures(path.parent) == [path]
    return read_capture(path)


def smpl_body() -> tuple[Clip, FloatArray]:
    """A body of SMPL as AMASS has it, and its places with y up."""
    arrays = good_arrays(FRAMES)
    clip = read_amass(packed({f"{n}.npy": as_member(v) for n, v in arrays.items()}), "a.npz")
    return clip, kinematics.clip_positions(clip)[0][:, :22]


@pytest.mark.parametrize("padding", [0, 5])
def test_the_only_sample_of_mdm_is_read_as_long_as_it_is(padding: int, tmp_path: Path) -> None:
    _, places = smpl_body()
    motion = np.concatenate([places, np.zeros((padding, 22, 3))]).transpose(1, 2, 0)[None]
    said = {"text": ["walks"], "lengths": np.array([FRAMES]), "num_samples": 1}
    clip = saved(tmp_path / "results.npy", {"motion": motion, **said})
    np.save(tmp_path / "plain.npy", places)
    plain = read_capture(tmp_path / "plain.npy")
    np.testing.assert_allclose(clip.world_positions(), plain.world_positions(), atol=1e-9)


def test_several_samples_of_mdm_are_named(tmp_path: Path) -> None:
    said = {"motion": np.zeros((3, 22, 3, 9)), "lengths": np.array([9] * 3), "num_samples": 3}
    with pytest.raises(CaptureError, match=r"found 3 samples of shape \(22, 3, 9\)"):
        saved(tmp_path / "results.npy", said)


def test_motion_x_is_the_same_body_as_amass(tmp_path: Path) -> None:
    arrays, (clip, _) = good_arrays(FRAMES), smpl_body()
    turn = rotation.from_axis_angle([1.0, 0.0, 0.0], -np.pi / 2)
    root = rotation.multiply(turn, rotation.exp(arrays["poses"][:, :3]))
    table = np.zeros((FRAMES, 322))
    table[:, :66] = arrays["poses"][:, :66]
    table[:, :3] = rotation.log(root)
    table[:, 309:312] = rotation.rotate(turn, arrays["trans"])
    read = saved(tmp_path / "a.npy", table)
    assert read.fps == 30.0
    mine, theirs = (each.world_positions() for each in (read, clip))
    np.testing.assert_allclose(mine - mine[0, 0], theirs - theirs[0, 0], atol=1e-6)


def test_the_smpl_pickle_of_phc_is_no_robot(tmp_path: Path) -> None:
    arrays, (clip, _) = good_arrays(FRAMES), smpl_body()
    said = {"pose_aa": arrays["poses"][:, :72], "trans_orig": arrays["trans"], "fps": 60}
    read = saved(tmp_path / "a.pkl", {"0-walk": {**said, "root_trans_offset": arrays["trans"] + 1}})
    np.testing.assert_allclose(read.world_positions(), clip.world_positions(), atol=1e-6)


def test_places_in_the_world_go_before_those_in_the_camera(tmp_path: Path) -> None:
    arrays, (clip, _) = good_arrays(FRAMES), smpl_body()
    poses, trans = arrays["poses"][:, :72], arrays["trans"]
    said = {"pose": poses * 0, "trans": trans * 0, "pose_world": poses, "trans_world": trans}
    read = saved(tmp_path / "a.pkl", {0: {**said, "fps": 60}})
    np.testing.assert_allclose(read.world_positions(), clip.world_positions(), atol=1e-6)
    in_camera = {"poses": poses * 0, "trans": trans * 0, "fps": 60}
    in_world = {"poses": poses, "trans": trans, "fps": 60}
    value = {"smpl_params_incam": in_camera, "smpl_params_global": in_world}
    read = saved(tmp_path / "a.pkl", value)
    np.testing.assert_allclose(read.world_positions(), clip.world_positions(), atol=1e-6)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (
            {
                "fps": 60,
                "person1": {"pose_body": np.zeros(3)},
                "person2": {"pose_body": np.zeros(3)},
            },
            "expected one body, found 2: person1, person2",
        ),
        (
            {"poses": [np.zeros((9, 72))] * 2, "trans": [np.zeros((9, 3))] * 2, "fps": 30},
            "expected poses of one body, found 2 in poses",
        ),
    ],
    ids=["InterHuman", "3DPW"],
)
def test_two_bodies_are_named(value: Any, said: str, tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=said):
        saved(tmp_path / "a.pkl", value)


def robot_walk() -> tuple[Any, hinges.Posed, tuple[FloatArray, FloatArray, FloatArray]]:
    robot = read_robot(small_robot.mjcf().encode(), "small.xml")
    root, turns, values = small_robot.walk()
    values = values[:, [small_robot.JOINTS.index(name) for name in robot.joint_names]]
    return robot, hinges.pose(robot, root, turns, values), (root, turns, values)


def test_frames_of_mimickit_are_a_robot_s(tmp_path: Path) -> None:
    robot, posed, (root, turns, values) = robot_walk()
    (tmp_path / "small.xml").write_text(small_robot.mjcf())
    frames = np.concatenate([root, rotation.log(turns), values], axis=1)
    clip = saved(tmp_path / "a.pkl", {"fps": 30, "loop_mode": 0, "frames": frames})
    expected = hinges.to_clip(robot, posed, 30.0).world_positions()
    np.testing.assert_allclose(clip.world_positions(), expected, atol=2e-5)


def skeleton_motion(is_local: bool) -> dict[str, Any]:
    robot, posed, (root, _, _) = robot_walk()
    above = robot.parents
    turns = posed.turns.copy()
    if is_local:
        turns[:, 1:] = rotation.relative(posed.turns[:, above[1:]], posed.turns[:, 1:])
    tree = {
        "node_names": list(robot.links),
        "parent_indices": {"arr": above, "context": {"dtype": "int64"}},
        "local_translation": {"arr": robot.places, "context": {"dtype": "float32"}},
    }
    return {
        "rotation": {"arr": turns[..., [1, 2, 3, 0]], "context": {"dtype": "float32"}},
        "root_translation": {"arr": root, "context": {"dtype": "float32"}},
        "skeleton_tree": tree,
        "is_local": is_local,
        "fps": 30,
        "__name__": "SkeletonMotion",
    }


@pytest.mark.parametrize("is_local", [True, False])
def test_a_skeleton_motion_of_poselib_is_read_without_a_model(
    is_local: bool, tmp_path: Path
) -> None:
    robot, posed, _ = robot_walk()
    clip = saved(tmp_path / "a.npy", skeleton_motion(is_local))
    expected = hinges.to_clip(robot, posed, 30.0)
    at = [
        expected.joint_names.index(f"{s}_{part}_joint")
        for s in ("left", "right")
        for part in ("knee", "elbow")
    ]
    mine = [
        clip.joint_names.index(f"{s}_{part}")
        for s in ("left", "right")
        for part in ("knee", "elbow")
    ]
    np.testing.assert_allclose(
        clip.world_positions()[:, mine], expected.world_positions()[:, at], atol=2e-5
    )


def test_a_skeleton_motion_of_another_skeleton_is_refused(tmp_path: Path) -> None:
    value = skeleton_motion(True)
    value["skeleton_tree"]["parent_indices"]["arr"] = np.array([-1, 0])
    with pytest.raises(CaptureError, match="expected turns of as many links as the skeleton has"):
        saved(tmp_path / "a.npy", value)
