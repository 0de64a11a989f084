"""OpenSim's motions on its models: places by hand, forms of the header, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.body import retarget, rotation
from motiondb.body.coordinates import BodyModel, Coordinate, with_followers
from motiondb.errors import CaptureError, NoBodyError
from motiondb.files.folder import find_captures, not_read
from motiondb.files.formats import read_capture
from motiondb.files.readers.first_bytes import read_head
from motiondb.records import Clip, FloatArray
from tests import small_osim

STILL = {"time": [0.0, 1.0 / 60.0], "pelvis_ty": [0.9, 0.9]}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "small.osim").write_text(small_osim.osim())
    return tmp_path


def _read(folder: Path, text: str, name: str = "small_walk.mot") -> Clip:
    (folder / name).write_text(text)
    return read_capture(folder / name)


def _at(clip: Clip, joint: str, frame: int = 0) -> list[float]:
    return clip.world_positions()[frame, clip.joint_names.index(joint)].round(6).tolist()


def test_places_by_hand(folder: Path) -> None:
    """The hip flexes by 90 degrees: the shank lies ahead, along x, and the knee has glided."""
    values = STILL | {"hip_flexion_r": [np.pi / 2] * 2, "knee_angle_r": [1.0] * 2}
    clip = _read(folder, small_osim.mot(values))
    assert (clip.format, clip.fps, clip.up) == ("opensim", 60.0, "y")
    assert _at(clip, "femur_r") == [-0.07, 0.84, 0.08]
    # the thigh points along x; the knee glides by -0.01 along x of the thigh, which is y
    assert _at(clip, "tibia_r") == [0.33, 0.83, 0.08]
    # the shank points down, and is turned by 90 degrees + 1 radian
    angle = np.pi / 2 + 1.0
    expected = [0.33 + 0.4 * np.sin(angle), 0.83 - 0.4 * np.cos(angle), 0.08]
    np.testing.assert_allclose(_at(clip, "talus_r"), expected, atol=1e-6)
    assert _at(clip, "femur_l") == [-0.07, 0.84, -0.08]


def test_turns_of_a_joint_follow_one_another_in_the_order_of_the_model(folder: Path) -> None:
    """Tilt about z, then list about the turned x, then rotation about the turned y."""
    angles = {"pelvis_tilt": 0.7, "pelvis_list": 0.4, "pelvis_rotation": -1.1}
    clip = _read(folder, small_osim.mot(STILL | {n: [v] * 2 for n, v in angles.items()}))
    turn = rotation.from_euler(np.rad2deg(list(angles.values())), "ZXY")
    expected = np.array([0.0, 0.9, 0.0]) + rotation.rotate(turn, np.array([-0.07, -0.06, 0.08]))
    np.testing.assert_allclose(_at(clip, "femur_r"), expected, atol=1e-6)
    other = _read(folder, small_osim.mot(STILL | {"arm_x_r": [0.3] * 2, "arm_y_r": [0.5] * 2}))
    arm = rotation.rotate(
        rotation.from_euler(np.rad2deg([0.3, 0.5]), "XY"), np.array([0.0, -0.28, 0.0])
    )
    np.testing.assert_allclose(np.subtract(_at(other, "ulna_r"), _at(other, "humerus_r")), arm,
                               atol=1e-6)  # fmt: skip


_FORMS = {
    "opensim": {},
    "radians": {"degrees": False, "header": "Coordinates\nversion=1\ninDegrees=no\nendheader\n"},
    "states": {
        "degrees": False,
        "header": "states\nDataType=double\nversion=3\ninDegrees=no\nendheader\n",
        "spelt": "/jointset/j/{}/value",
    },
    "simm": {"header": "walk\nname walk\ndatacolumns {columns}\ndatarows {rows}\nendheader\n"},
    "spaced": {"header": "walk\n nRows = {rows}\ninDegrees = yes\nendheader\t\n"},
}


@pytest.mark.parametrize("form", _FORMS)
@pytest.mark.parametrize("version", [3, 4])
def test_forms_of_model_and_header_are_the_same_walk(
    tmp_path: Path, form: str, version: int
) -> None:
    (tmp_path / "small.osim").write_text(small_osim.osim())
    expected = _read(tmp_path, small_osim.mot(small_osim.walk()))
    (tmp_path / "small.osim").write_text(small_osim.osim(version))
    clip = _read(tmp_path, small_osim.mot(small_osim.walk(), **_FORMS[form]), "small_other.sto")
    places = {n: clip.world_positions()[:, k] for k, n in enumerate(clip.joint_names)}
    for number, name in enumerate(expected.joint_names):
        np.testing.assert_allclose(places[name], expected.world_positions()[:, number], atol=1e-6)
    units = [note for note in clip.notes if "degrees are taken" in note]
    assert bool(units) == (form == "simm")


def test_a_walk_is_a_body_with_left_and_right(folder: Path) -> None:
    motion, _ = retarget.solved(_read(folder, small_osim.mot(small_osim.walk())))
    assert motion.leg_length == pytest.approx(0.8, abs=0.01)
    places = dict(zip(motion.joint_names, np.moveaxis(motion.joint_positions(), 1, 0)))
    ahead = places["pelvis"][-1] - places["pelvis"][0]
    left = places["l_hip"][0] - places["r_hip"][0]
    assert np.cross(left, ahead)[1] < 0  # left of who goes ahead


def test_gravity_says_the_axis_up(tmp_path: Path) -> None:
    (tmp_path / "small.osim").write_text(small_osim.osim(gravity="0 0 -9.8"))
    clip = _read(tmp_path, small_osim.mot(STILL | {"pelvis_tz": [0.2] * 2}))
    assert clip.up == "y"
    assert _at(clip, "pelvis") == [0.0, 0.2, -0.9]


def test_wrong_units_in_a_header_are_told(folder: Path) -> None:
    text = small_osim.mot(small_osim.walk()).replace("inDegrees=yes", "inDegrees=no")
    clip = _read(folder, text)
    assert "says that angles are in radians; knee_angle_r reaches 34.38" in clip.notes[0]
    expected = _read(folder, small_osim.mot(small_osim.walk()), "small_right.mot")
    np.testing.assert_allclose(clip.world_positions(), expected.world_positions())


def test_uneven_times_are_interpolated_and_repeated_rows_left_out(folder: Path) -> None:
    times = [0.0, 0.01, 0.02, 0.02, 0.05, 0.051, 0.1]
    values = {"time": times, "pelvis_tx": [2.0 * t for t in times], "pelvis_ty": [0.9] * 7}
    clip = _read(folder, small_osim.mot(values))
    assert "1 rows are not later" in clip.notes[0]
    assert clip.notes[1].startswith("Its rows are at uneven times; they are interpolated to ")
    steps = np.diff(clip.world_positions()[:, 0, 0])
    np.testing.assert_allclose(steps, 2.0 / clip.fps)


def test_what_is_left_to_the_model_is_told(folder: Path) -> None:
    (note,) = _read(folder, small_osim.mot(STILL)).notes[:1]
    assert note.startswith("The file has no values for 'pelvis_tilt', 'pelvis_list'")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("BallJoint", "ScapulothoracicJoint", "found the 'ScapulothoracicJoint' 'j_humerus_r'"),
        ("SimmSpline", "Sine", "splines as functions of coordinates, found 'Sine'"),
        ("1 0</coefficients>", "1 a</coefficients>", "numbers as coefficients of LinearFunction"),
        ("SpatialTransform", "TransformAxisSet", "found the 'CustomJoint'"),
        ("JointSet", "Joints", "expected joints as OpenSim 2 or newer"),
        ("OpenSimDocument", "Other", "expected a model of OpenSim"),
    ],
)
def test_models_that_are_not_understood(tmp_path: Path, old: str, new: str, message: str) -> None:
    (tmp_path / "m.mot").write_text(small_osim.mot(STILL))
    (tmp_path / "m.osim").write_text(small_osim.osim().replace(old, new))
    with pytest.raises(CaptureError, match=message):
        read_capture(tmp_path / "m.mot", skeleton=tmp_path / "m.osim")


@pytest.mark.parametrize(
    ("title", "names", "message"),
    [
        ("Coordinates", ("ground_force_vx", "ground_force_px"), "forces, moments, muscles"),
        ("Inverse Dynamics", ("pelvis_tx_force", "hip_flexion_r_moment"), "forces, moments"),
        ("Speeds", ("hip_flexion_r", "knee_angle_r"), "speeds of coordinates"),
        ("Coordinates", ("glut_med1_r", "soleus_r"), "known as no coordinates"),
        ("x\nDataType=Quaternion", ("pelvis_imu", "torso_imu"), "orientations of sensors"),
    ],
)
def test_other_tables_are_refused_with_their_reason(
    tmp_path: Path, title: str, names: tuple[str, ...], message: str
) -> None:
    cell = "1,0,0,0" if "Quaternion" in title else "1.0"
    rows = "".join(f"{t}\t{cell}\t{cell}\n" for t in (0.0, 0.1))
    head = "\t".join(("time", *names))
    path = tmp_path / "x.sto"
    path.write_text(f"{title}\nversion=1\nendheader\n{head}\n{rows}")
    with pytest.raises(CaptureError, match=message) as caught:
        read_capture(path)
    assert not isinstance(caught.value, NoBodyError)
    assert find_captures(tmp_path) == []
    assert "(OpenSim table of forces" in not_read(tmp_path)[0]


def test_speeds_and_equal_columns_are_refused_with_a_model_too(folder: Path) -> None:
    text = small_osim.mot(small_osim.walk())
    with pytest.raises(CaptureError, match="found speeds of coordinates"):
        _read(folder, text.replace("Coordinates", "Speeds", 1))
    with pytest.raises(CaptureError, match="expected every column once, found 'pelvis_tx' twice"):
        _read(folder, text.replace("pelvis_ty", "pelvis_tx"))
    late = text.rstrip().splitlines()
    late[-1] = "\t".join(["1e7", *late[-1].split("\t")[1:]])
    with pytest.raises(CaptureError, match=r"of at most .* in memory"):
        _read(folder, "\n".join(late))


def test_a_header_of_blanks_is_read() -> None:
    header, names, first = read_head(["Coordinates", " " * 30_000 + "!", "key = a b", "time\tx"])
    assert (header["key"], names, first) == ("a b", ("x",), 4)


def test_what_follows_a_follower_follows_its_value() -> None:
    def twice(value: FloatArray) -> FloatArray:
        return 2.0 * value

    known = {
        "a": Coordinate("a", True, 0.0, ("b", twice)),
        "b": Coordinate("b", True, 0.0, ("c", twice)),
        "c": Coordinate("c", True, 0.0),
    }
    values = with_followers(BodyModel("m", (), known), {"c": np.ones(1)}, 1)
    assert {name: value.tolist() for name, value in values.items()} == {
        "a": [4.0], "b": [2.0], "c": [1.0],
    }  # fmt: skip


def test_broken_rows_are_named(folder: Path) -> None:
    text = small_osim.mot(small_osim.walk())
    with pytest.raises(CaptureError, match=r"mot:12: expected 8 numbers, found 7 cells"):
        _read(folder, "\n".join(
            line.rpartition("\t")[0] if number == 12 else line
            for number, line in enumerate(text.splitlines(), 1)
        ))  # fmt: skip
    with pytest.raises(CaptureError, match="expected coordinates of the model 'small', found"):
        _read(folder, text.replace("pelvis_", "q_").replace("_r", "_rr").replace("_l", "_ll"))


def test_without_a_model_angles_are_kept_as_series(tmp_path: Path) -> None:
    (tmp_path / "walk.mot").write_text(small_osim.mot(small_osim.walk()))
    with motiondb.open(tmp_path / "a.duckdb") as db:
        db.add(tmp_path)
        (info,) = db.captures()
        assert not info.has_body
        assert "Kept as series, without the motion of a body: no model" in info.notes[0]
        assert "give one beside it, or with --skeleton." in info.notes[0]
        db.export("walk", tmp_path / "out.csv")
        db.export("walk", tmp_path / "same.mot")
    head, first = (tmp_path / "out.csv").read_text().splitlines()[:2]
    assert head.split(",") == list(small_osim.walk())
    assert float(first.split(",")[-1]) == pytest.approx(np.rad2deg(0.5))
    assert (tmp_path / "same.mot").read_bytes() == (tmp_path / "walk.mot").read_bytes()


def test_a_model_without_arms_is_kept_as_the_places_of_its_bodies(tmp_path: Path) -> None:
    (tmp_path / "Kinematics").mkdir()
    (tmp_path / "Model").mkdir()  # as OpenCap has them
    (tmp_path / "Model" / "legs.osim").write_text(small_osim.osim(with_arms=False))
    (tmp_path / "Kinematics" / "walk.mot").write_text(small_osim.mot(small_osim.walk()))
    with motiondb.open(tmp_path / "a.duckdb") as db:
        db.add(tmp_path)
        (info,) = db.captures()
        assert "Kept as markers" in info.notes[0]
        assert "none for neck, l_shoulder" in info.notes[0]
        db.export(info.name, tmp_path / "out.npz")
    out = np.load(tmp_path / "out.npz")
    femur = out["positions"][0, out["markers"].tolist().index("femur_r")]
    tilted = rotation.rotate(
        rotation.from_euler([np.rad2deg(0.05)], "Z"), np.array([-0.07, -0.06, 0.08])
    )
    np.testing.assert_allclose(femur, np.add(tilted, [0.0, 0.93, 0.0]), atol=1e-6)
