"""Motions of robots: one walk in every form is the same clip; faults are named."""

import json
import pickle
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motiondb.body import hinges, retarget, rotation
from motiondb.errors import CaptureError
from motiondb.files.arrays import write_robot
from motiondb.files.folder import find_captures, not_read
from motiondb.files.formats import read_capture, with_rate_beside
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.robot_model import read_robot
from motiondb.records import Clip
from tests import small_robot

ROBOT = read_robot(small_robot.mjcf().encode(), "small.xml")
ROOT, TURNS, VALUES = small_robot.walk()
# The order of the model is that of the document: the torso's hinge first, here, then the arms
VALUES = VALUES[:, [small_robot.JOINTS.index(name) for name in ROBOT.joint_names]]
POSED = hinges.pose(ROBOT, ROOT, TURNS, VALUES)
XYZW = TURNS[:, [1, 2, 3, 0]]
TABLE = np.concatenate([ROOT, XYZW, VALUES], axis=1)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "small.xml").write_text(small_robot.mjcf())
    return tmp_path


def _expected() -> Clip:
    return hinges.to_clip(ROBOT, POSED, 30.0)


def _save(folder: Path, name: str, **arrays: Any) -> Path:
    np.savez(folder / name, **arrays)
    return folder / name


def _csv(folder: Path, table: np.ndarray[Any, Any], head: str = "") -> Path:
    np.savetxt(folder / "w.csv", table, delimiter=",", header=head, comments="")
    return folder / "w.csv"


def _is_walk(clip: Clip) -> None:
    assert clip.format == "robot"
    assert clip.fps == 30.0
    expected = _expected().world_positions()
    np.testing.assert_allclose(clip.world_positions(), expected, atol=2e-5)


def test_csv_of_lafan1_has_its_rate_and_order_told(folder: Path) -> None:
    clip = read_capture(_csv(folder, TABLE))
    _is_walk(clip)
    assert clip.notes[0].startswith("The file has no frame rate; 30 a second are taken")
    assert clip.notes[1] == "The file names no joints; they are taken in the order of the model."


def test_csv_with_a_header_is_read_by_its_names_in_any_order(folder: Path) -> None:
    order = np.random.default_rng(1).permutation(TABLE.shape[1])
    names = ["root_x", "root_y", "root_z", "root_qx", "root_qy", "root_qz", "root_qw"]
    names = np.array([*names, *ROBOT.joint_names])
    times = np.arange(len(TABLE))[:, None] / 30.0
    table = np.concatenate([times, TABLE[:, order]], axis=1)
    clip = read_capture(_csv(folder, table, ",".join(["time", *names[order]])))
    _is_walk(clip)
    assert not any("frame rate" in note or "order" in note for note in clip.notes)


def test_the_rate_that_export_writes_beside_a_table_is_read(folder: Path) -> None:
    path = folder / "w.csv"
    write_robot(path, ROBOT, 50.0, ROOT, TURNS, VALUES)
    clip = read_capture(path)
    assert clip.fps == 50.0
    assert "The frame rate, 50 a second, is that of 'w.json'." in clip.notes
    assert not any("no frame rate" in note for note in clip.notes)
    given = read_capture(path, fps=25.0)
    assert given.fps == 25.0
    assert not any("w.json" in note for note in given.notes)
    _csv(folder, TABLE[:, :-1])  # another table than that which the file describes
    assert with_rate_beside(path, ReadOptions()) == ReadOptions()


_HEAD = ["root_x", "root_y", "root_z", "root_qx", "root_qy", "root_qz", "root_qw"]
_HEAD += ROBOT.joint_names


@pytest.mark.parametrize(
    ("said", "fps"),
    [
        ({"fps": 50, "columns": _HEAD}, 50.0),
        ({"fps": 50, "columns": _HEAD[::-1]}, None),
        ({"fps": 50, "columns": []}, None),
        ({"fps": True, "columns": _HEAD}, None),
        ({"fps": "50", "columns": _HEAD}, None),
        ({"fps": float("nan"), "columns": _HEAD}, None),
        ({"fps": 2001.0, "columns": _HEAD}, None),
        ([50], None),
    ],
)
def test_the_rate_beside_a_table_is_that_of_its_columns(
    folder: Path, said: object, fps: float | None
) -> None:
    path = _csv(folder, TABLE, ",".join(_HEAD))
    path.with_suffix(".json").write_text(json.dumps(said))
    assert with_rate_beside(path, ReadOptions()).fps == fps
    _csv(folder, TABLE)
    assert with_rate_beside(path, ReadOptions()).fps is None


@pytest.mark.parametrize(
    ("name", "step", "fps"),
    [
        *(("time_ms", 20.0, 50), ("timestamp [ms]", 20.0, 50), ("time", 20.0, 50)),
        *(("time_ms", 1.0, 1000), ("time [ms]", 2.0, 500), ("timeMs", 3.9, 256)),
        *(("t_us", 1000.0, 1000), ("timestamp_ns", 5e6, 200), ("time (\u00b5s)", 2e4, 50)),
        *(("timestamp_s", 0.02, 50), ("seconds", 0.02, 50), ("t", 0.02, 50), ("times", 5.0, 200)),
    ],
)
def test_times_are_in_the_unit_of_their_name(
    folder: Path, name: str, step: float, fps: int
) -> None:
    names = ["root_x", "root_y", "root_z", "root_qx", "root_qy", "root_qz", "root_qw"]
    times = np.arange(len(TABLE))[:, None] * step
    path = _csv(folder, np.concatenate([times, TABLE], axis=1))
    head = ",".join([name, *names, *ROBOT.joint_names])
    path.write_text(f"{head}\n{path.read_text().lstrip()}", encoding="utf-8")
    assert round(read_capture(path).fps) == fps


def test_a_workbook_called_a_table_is_named(folder: Path) -> None:
    (folder / "w.csv").write_bytes(b"PK\x03\x04" + bytes(100))
    with pytest.raises(CaptureError, match="expected a table as text, found a zip file"):
        read_capture(folder / "w.csv")


def test_a_scene_around_the_model_is_not_taken_for_another_robot(folder: Path) -> None:
    scene = '<mujoco model="scene"><include file="small.xml"/><worldbody/></mujoco>'
    (folder / "scene.xml").write_text(scene)
    _is_walk(read_capture(_csv(folder, TABLE), fps=30))


def test_turns_that_are_no_quaternions_are_refused(folder: Path) -> None:
    table = TABLE.copy()
    table[:, 3:7] = np.deg2rad([0.0, 0.0, 30.0, 0.0])
    with pytest.raises(CaptureError, match=r"found lengths from 0\.52 to 0\.52\. Are these other"):
        read_capture(_csv(folder, table))


def test_a_root_in_another_unit(folder: Path) -> None:
    table = TABLE * np.where(np.arange(TABLE.shape[1]) < 3, 1000.0, 1.0)
    _is_walk(read_capture(_csv(folder, table), unit=0.001))


@pytest.mark.parametrize("has_names", [True, False])
def test_csv_with_decimal_commas(folder: Path, has_names: bool) -> None:
    names = ["root_x", "root_y", "root_z", "root_qx", "root_qy", "root_qz", "root_qw"]
    head = ";".join([*names, *ROBOT.joint_names])
    path = _csv(folder, TABLE)
    text = path.read_text().replace(",", ";").replace(".", ",")
    path.write_text(f"{head}\n{text}" if has_names else text)
    assert find_captures(folder) == [path]
    _is_walk(read_capture(path))


@pytest.mark.parametrize(
    ("number", "name", "message"),
    [
        (6, "torso_lamp", "w, x, y and z of its quaternion"),
        (1, "torso_x", "found several for root x"),
        (8, ROBOT.joint_names[0], "expected one column a joint, found several"),
    ],
)
def test_columns_that_leave_it_open_are_refused(
    folder: Path, number: int, name: str, message: str
) -> None:
    names = ["root_x", "root_y", "root_z", "root_qx", "root_qy", "root_qz", "root_qw"]
    names += ROBOT.joint_names
    names[number] = name
    with pytest.raises(CaptureError, match=message):
        read_capture(_csv(folder, TABLE, ",".join(names)))


def test_columns_in_degrees_are_read_so_by_their_names(folder: Path) -> None:
    names = ["root_x", "root_y", "root_z", "root_qx", "root_qy", "root_qz", "root_qw"]
    names += [f"{name}_deg" for name in ROBOT.joint_names]
    table = np.concatenate([TABLE[:, :7], np.rad2deg(TABLE[:, 7:])], axis=1)
    _is_walk(read_capture(_csv(folder, table, ",".join(names))))


def _forms(folder: Path) -> dict[str, Path]:
    depth = np.zeros(len(ROBOT.links), dtype=int)
    for link, parent in enumerate(ROBOT.parents):
        depth[link] = 0 if parent < 0 else depth[parent] + 1
    moving = [0, *(joint.link for joint in ROBOT.joints)]
    by_depth = sorted(moving, key=lambda link: (depth[link], link))
    joint_of = {joint.link: number for number, joint in enumerate(ROBOT.joints)}
    joints = [joint_of[link] for link in by_depth[1:]]
    world = np.zeros((len(ROOT), 1, 3)), np.tile([1.0, 0, 0, 0], (len(ROOT), 1, 1))
    forms = {
        "isaac": {
            "joint_pos": VALUES[:, joints],
            "body_pos_w": POSED.places[:, by_depth],
            "body_quat_w": POSED.turns[:, by_depth],
        },
        "mjlab": {
            "joint_pos": VALUES,
            "body_pos_w": POSED.places,
            "body_quat_w": POSED.turns,
        },
        "with_world": {
            "joint_pos": np.concatenate([ROOT, TURNS, VALUES], axis=1),
            "body_pos_w": np.concatenate([world[0], POSED.places], axis=1),
            "body_quat_w": np.concatenate([world[1], POSED.turns], axis=1),
            "joint_names": np.array(ROBOT.joint_names),
            "body_names": np.array(["world", *ROBOT.links]),
        },
        "amass": {
            "dof_positions": VALUES[:, ::-1],
            "dof_names": np.array(ROBOT.joint_names[::-1]),
            "body_positions": POSED.places[:, moving],
            "body_rotations": POSED.turns[:, moving],
            "body_names": np.array([ROBOT.links[link] for link in moving]),
        },
        "qpos": {"qpos": np.concatenate([ROOT, TURNS, VALUES], axis=1)},
    }
    return {n: _save(folder, f"{n}.npz", fps=30, **arrays) for n, arrays in forms.items()}


def test_npz_of_simulators_are_the_same_walk_whatever_the_order_of_joints(folder: Path) -> None:
    for name, path in _forms(folder).items():
        clip = read_capture(path)
        _is_walk(clip)
        told = " ".join(clip.notes)
        assert ("as Isaac Lab has them: then bodies are within 0.0 mm" in told) == (name == "isaac")


def test_pickles_of_gmr_and_phc_are_the_same_walk(folder: Path) -> None:
    gmr = {"fps": 30, "root_pos": ROOT, "root_rot": XYZW, "dof_pos": VALUES}
    gmr |= {"local_body_pos": None, "link_body_list": None}
    phc = {"root_trans_offset": ROOT, "root_rot": XYZW, "dof": VALUES[..., None], "fps": 30}
    for protocol in range(2, 6):
        for motion in (gmr, {"walk": phc}):
            (folder / "w.pkl").write_bytes(pickle.dumps(motion, protocol))
            _is_walk(read_capture(folder / "w.pkl"))
    (folder / "w.pkl").write_bytes(pickle.dumps({"a": gmr, "b": gmr}))
    with pytest.raises(CaptureError, match="expected one motion, found 2"):
        read_capture(folder / "w.pkl")


def test_bodies_are_read_without_a_model_by_their_names(tmp_path: Path) -> None:
    clip = read_capture(_forms(tmp_path)["with_world"])
    expected, actual = (retarget.clip_keypoints(each) for each in (_expected(), clip))
    np.testing.assert_allclose(actual, expected, atol=0.02)  # toes are estimated
    with pytest.raises(CaptureError) as error:
        read_capture(_csv(tmp_path, np.zeros((2, 36)) + 0.1))
    assert "found none, or several; the motion has 29 joints (as many as Unitree's G1" in str(
        error.value
    )


def test_quaternions_in_the_other_order_are_told(folder: Path) -> None:
    table = np.concatenate([ROOT, TURNS, VALUES], axis=1)
    clip = read_capture(_csv(folder, table))
    _is_walk(clip)
    assert "as w x y z, not as x y z w" in " ".join(clip.notes)
    path = _save(folder, "a.npz", fps=30, root_pos=ROOT, root_quat=XYZW, dof_pos=VALUES)
    clip = read_capture(path)
    _is_walk(clip)
    assert "does not say the order of quaternions; x y z w is taken" in " ".join(clip.notes)


def test_values_beyond_the_limits_are_noted_and_kept(folder: Path) -> None:
    table = TABLE.copy()
    knee = 7 + ROBOT.joint_names.index("left_knee_joint")
    table[10:13, knee] = np.deg2rad(-12.0)
    clip = read_capture(_csv(folder, table))
    assert (
        "1 joints leave the limits of the model, left_knee_joint the most: by 7.0 degrees "
        "(-5 to 160 are allowed), in 3 frames." in clip.notes
    )


def test_names_of_other_robots_and_lists_of_other_lengths_are_refused(folder: Path) -> None:
    names = np.array([name.replace("knee", "knie") for name in ROBOT.joint_names])
    given = {"fps": 30, "root_pos": ROOT, "root_rot": XYZW, "dof_pos": VALUES}
    for more, said in (
        ({"joint_names": names}, "found 'left_knie_joint', 'right_knie_joint'"),
        ({"joint_names": names[:5]}, "expected 5 joints as there are names, found 21"),
        ({"dof_pos": VALUES[:, :19]}, "found 19 (as many as Unitree's H1)"),
        ({"dof_pos": VALUES[:50]}, "expected arrays of as many frames, found 50, 120"),
        ({"root_pos": ROOT[:, :2]}, "expected 'root_pos' of shape (frames, 3), found (120, 2)"),
        ({"dof_pos": VALUES.astype(str)}, "expected numbers in 'dof_pos'"),
        ({"fps": 0.01}, "expected a frame rate from 1 to 2000"),
    ):
        with pytest.raises(CaptureError) as error:
            read_capture(_save(folder, "w.npz", **(given | more)))
        assert said in str(error.value)


def test_bodies_that_are_not_where_the_model_has_them_are_refused(folder: Path) -> None:
    with pytest.raises(CaptureError) as error:
        read_capture(
            _save(
                folder,
                "w.npz",
                fps=30,
                joint_pos=VALUES,
                body_pos_w=POSED.places * 1.3,
                body_quat_w=POSED.turns,
            )
        )
    assert "m from where the model has them. Give the model with which" in str(error.value)


def test_frames_that_are_not_finite_are_refused_or_left_out(folder: Path) -> None:
    values = VALUES.copy()
    values[5, 3] = np.nan
    turns = XYZW.copy()
    turns[7] = 0.0
    path = _save(folder, "w.npz", fps=30, root_pos=ROOT, root_rot=turns, dof_pos=values)
    with pytest.raises(CaptureError, match="found others in 2 frames, the first is 5"):
        read_capture(path)
    assert read_capture(path, skip_bad_frames=True).n_frames == len(ROOT) - 2


def test_tables_with_other_columns_are_refused_by_line(folder: Path) -> None:
    path = _csv(folder, TABLE[:3])
    path.write_text(path.read_text() + "1,2,3\n")
    with pytest.raises(CaptureError) as error:
        read_capture(path)
    assert error.value.faults[0][0] == 4
    assert "expected 28 numbers, found 3 cells" in str(error.value)
    _csv(folder, TABLE[:, :7])
    with pytest.raises(CaptureError, match="found 7 columns"):
        read_capture(path)


def test_only_tables_and_arrays_of_motion_are_captures_of_a_folder(folder: Path) -> None:
    _csv(folder, TABLE)
    (folder / "words.csv").write_text("file,words,a,b,c,d,e,f\nw.csv,a walk,1,2,3,4,5,6\n")
    (folder / "weights.pkl").write_bytes(pickle.dumps({"layers": [1, 2]}))
    (folder / "v.pkl").write_bytes(pickle.dumps({"base_translation": 1, "link_names": ["a"]}))
    np.save(folder / "heights.npy", np.zeros((20, 3)))
    np.save(folder / "joints.npy", np.zeros((20, 22, 3)))
    found = [path.name for path in find_captures(folder)]
    assert found == ["joints.npy", "v.pkl", "w.csv"]
    assert [line.rpartition("/")[2].partition(":")[0] for line in not_read(folder)] == [
        "heights.npy",
        "weights.pkl",
    ]


def _columns(*before: str, names: str = "{}") -> str:
    return ",".join([*before, *(names.format(joint) for joint in ROBOT.joint_names)])


_TIMES = np.arange(len(TABLE)) / 50.0
_ROOT_WXYZ = np.concatenate([ROOT, TURNS, VALUES], axis=1)
_SEED = np.concatenate(
    [100 * ROOT, rotation.to_euler(TURNS, "ZYX")[:, ::-1], np.rad2deg(VALUES)], axis=1
)


@pytest.mark.parametrize(
    ("head", "table"),
    [
        (_columns("root_tx", "root_ty", "root_tz", "qw", "qx", "qy", "qz"), _ROOT_WXYZ),
        (_columns("x", "y", "z", "qx", "qy", "qz", "qw", names="{}_q"), TABLE),
        ("", np.column_stack([_TIMES, TABLE])),
        ("", np.column_stack([np.arange(len(TABLE)), TABLE])),
        ("", np.concatenate([TABLE[:, :7], np.rad2deg(VALUES)], axis=1)),
        (
            _columns(
                *(f"root_translate{axis}" for axis in "XYZ"),
                *(f"root_rotate{axis}" for axis in "XYZ"),
                names="{}_dof",
            ),
            _SEED,
        ),
    ],
    ids=["t", "q", "time", "number", "degrees", "seed"],
)
def test_tables_as_other_programs_have_them(
    folder: Path, head: str, table: np.ndarray[Any, Any]
) -> None:
    path = _csv(folder, table, head)
    assert find_captures(folder) == [path]
    clip = read_capture(path, fps=30.0)
    _is_walk(clip)
    told = " ".join(clip.notes)
    assert ("taken as degrees" in told) == (not head and np.abs(table[:, 7:]).max() > 10.0
                                            and table.shape[1] == TABLE.shape[1])  # fmt: skip
    assert ("BONES-SEED" in told) == ("rotateX" in head)


def test_a_table_between_spaces_and_the_rate_of_its_times(folder: Path) -> None:
    np.savetxt(folder / "w.csv", np.column_stack([_TIMES, TABLE]))
    assert read_capture(folder / "w.csv").fps == 50.0


@pytest.mark.parametrize(
    ("turn_name", "turns"),
    [("base_orientation", XYZW), ("root_quat_wxyz", TURNS), ("root_rotations", TURNS)],
)
def test_arrays_under_other_names(folder: Path, turn_name: str, turns: Any) -> None:
    path = _save(
        folder,
        "w.npz",
        dt=1.0 / 30.0,
        base_position=ROOT,
        joint_position=VALUES,
        **{turn_name: turns},
    )
    _is_walk(read_capture(path))


def test_bodies_whose_quaternions_end_with_w_are_told(folder: Path) -> None:
    path = _save(
        folder,
        "w.npz",
        fps=30,
        joint_pos=VALUES,
        body_pos_w=POSED.places,
        body_quat_w=POSED.turns[..., [1, 2, 3, 0]],
        body_names=list(ROBOT.links),
    )
    clip = read_capture(path)
    _is_walk(clip)
    assert "taken as x y z w" in " ".join(clip.notes)


def test_other_files_called_pickles_are_refused(folder: Path) -> None:
    (folder / "w.pkl").write_bytes(zlib.compress(b"root_pos"))
    with pytest.raises(CaptureError, match="found another file"):
        read_capture(folder / "w.pkl")


def test_the_axis_up_that_is_asked_for_is_turned_once(folder: Path) -> None:
    clip = read_capture(_csv(folder, TABLE), up="z")
    _is_walk(clip)
    assert clip.up == "y"


_PLACE = ["root_x", "root_y", "root_z"]
_RPY = np.stack([np.zeros(120), np.zeros(120), 2.0 * np.arctan2(TURNS[:, 3], TURNS[:, 0])], axis=1)


@pytest.mark.parametrize(
    ("names", "unit", "of_joints", "turns"),
    [
        (["roll", "pitch", "yaw"], "radians", "radians", 0),
        (["roll", "pitch", "yaw"], "radians", "radians", 3),
        (["root_rot_x", "root_rot_y", "root_rot_z"], "degrees", "degrees", 0),
        (["roll", "pitch", "yaw"], "degrees", "radians", 1),
    ],
)
def test_a_root_with_angles_is_read_in_their_unit(
    folder: Path, names: list[str], unit: str, of_joints: str, turns: int
) -> None:
    """The root may have turned several times before, and joints another unit."""
    scales = [1.0 if each == "radians" else np.rad2deg(1.0) for each in (unit, of_joints)]
    angles = _RPY + np.array([0.0, 0.0, 2.0 * np.pi * turns])
    table = np.concatenate([ROOT, angles * scales[0], VALUES * scales[1]], axis=1)
    clip = read_capture(_csv(folder, table, ",".join([*_PLACE, *names, *ROBOT.joint_names])))
    _is_walk(clip)
    assert f"yaw about z, in {unit}, those of joints in {of_joints}" in clip.notes[0]


def test_velocities_beside_a_motion_and_words_before_names(folder: Path) -> None:
    names = [f"dof_{name}" for name in ROBOT.joint_names]
    more = [*(f"{name}_vel" for name in names), "root_vx"]
    table = np.concatenate([TABLE, VALUES, ROOT[:, :1]], axis=1)
    clip = read_capture(_csv(folder, table, ",".join([*_HEAD[:7], *names, *more])))
    _is_walk(clip)
    assert "Left out 22 columns of velocities or forces: dof_torso_joint_vel, ..." in clip.notes


def _headed(yaw: float) -> np.ndarray[Any, Any]:
    """Quaternions w x y z of a robot that turns about a heading by 1 to either side."""
    half = (yaw + np.linspace(-1.0, 1.0, len(ROOT))) / 2.0
    return np.stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)], axis=1)


@pytest.mark.parametrize("yaw", [0.0, 1.6, 3.1, -1.6])
def test_the_upright_order_of_quaternions_is_taken_for_every_heading(
    folder: Path, yaw: float
) -> None:
    turns = _headed(yaw)
    true = read_capture(_save(folder, "w.npz", qpos=np.c_[ROOT, turns, VALUES], fps=30))
    assert not any("are taken as" in note for note in true.notes)
    other = np.c_[ROOT, np.roll(turns, -1, axis=1), VALUES]
    clip = read_capture(_save(folder, "w.npz", qpos=other, fps=30))
    np.testing.assert_allclose(clip.world_positions(), true.world_positions(), atol=1e-9)
    assert any("are taken as x y z w, not as w x y z" in note for note in clip.notes)


@pytest.mark.parametrize("up", ["y", "x"])
def test_a_robot_that_stands_along_another_axis_is_told(folder: Path, up: str) -> None:
    turn = rotation.from_euler([[-90.0 if up == "y" else 90.0]], "X" if up == "y" else "Y")[0]
    turns = rotation.multiply(np.broadcast_to(turn, TURNS.shape), TURNS)
    root = rotation.rotate(np.broadcast_to(turn, TURNS.shape), ROOT)
    path = _csv(folder, np.c_[root, np.roll(turns, -1, axis=1), VALUES])
    told = f"z is taken for up, and the robot lies along {up}. If it stands, give --up {up}."
    assert told in read_capture(path).notes
    upright = [part.world_positions() for part in (read_capture(path, up=up), _expected())]
    apart = [np.linalg.norm(at - at[:, :1], axis=2) for at in upright]
    np.testing.assert_allclose(*apart, atol=2e-5)
    heights = upright[0][..., "xyz".index(up)]  # the clip has the axes of its file
    np.testing.assert_allclose(heights, upright[1][..., 1], atol=2e-5)


def test_the_rate_of_times_beside_an_array(folder: Path) -> None:
    qpos, times = np.c_[ROOT, TURNS, VALUES], np.arange(len(ROOT))
    assert read_capture(_save(folder, "w.npz", qpos=qpos, time=times * 0.02)).fps == 50.0
    assert (
        read_capture(_save(folder, "w.npz", qpos=qpos, timestamps=times * 5_000_000)).fps == 200.0
    )


@pytest.mark.parametrize("is_before", [False, True])
def test_an_object_in_qpos_is_left_out_and_told(folder: Path, is_before: bool) -> None:
    robot, thing = np.c_[ROOT, TURNS, VALUES], np.c_[ROOT + 1.0, np.roll(TURNS, 5, axis=0)]
    qpos = np.c_[thing, robot] if is_before else np.c_[robot, thing]
    clip = read_capture(_save(folder, "w.npz", qpos=qpos, fps=30))
    _is_walk(clip)
    where = "before" if is_before else "behind"
    assert any(f"Left out 7 numbers {where} those of the robot" in note for note in clip.notes)


def test_joints_that_look_like_a_quaternion_are_no_object(folder: Path) -> None:
    still = np.c_[VALUES[:, :3], np.tile([1.0, 0.0, 0.0, 0.0], (len(VALUES), 1)), VALUES[:, 7:]]
    table = read_capture(_csv(folder, np.c_[ROOT, XYZW, still]))
    clip = read_capture(_save(folder, "w.npz", qpos=np.c_[ROOT, TURNS, still], fps=30))
    np.testing.assert_allclose(clip.world_positions(), table.world_positions(), atol=2e-5)
