"""SMPL-style npz: the world is set upright, the arrays may come in several shapes."""

from __future__ import annotations

import io
import pickle
import re

import numpy as np
import pytest

from motiondb.body import kinematics, rotation, world
from motiondb.body.joint_names import joint_map
from motiondb.errors import CaptureError
from motiondb.files.formats import read_capture_bytes
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.amass import read_amass


def npz(**arrays: object) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def standing(n_frames: int = 4, columns: int = 156) -> np.ndarray:
    """Bodies that stand along z and face -y, as AMASS has them after a quarter turn about x."""
    poses = np.zeros((n_frames, columns))
    poses[:, 0] = np.pi / 2
    return poses


def read(**changes: object):
    arrays: dict[str, object] = {
        "poses": standing(),
        "trans": np.tile([1.0, 2.0, 0.92], (4, 1)),
        "mocap_framerate": 120.0,
        "gender": np.array("female"),
        "betas": np.zeros(16),
    }
    arrays |= changes
    return read_amass(npz(**{k: v for k, v in arrays.items() if v is not None}), "a.npz")


def test_a_standing_body_by_hand() -> None:
    clip = read()
    assert (clip.fps, clip.format, clip.n_frames, clip.notes) == (120.0, "amass", 4, ())
    positions, _ = kinematics.clip_positions(clip)
    places = dict(zip(clip.skeleton.names, positions[0]))
    # x stays, z (1.1 + pelvis 0.03) becomes y, -y (-2 + 0.22) becomes z.
    np.testing.assert_allclose(places["Pelvis"], [1.0, 0.95, -1.78], atol=1e-12)
    np.testing.assert_allclose(places["Head"] - places["Pelvis"], [0, 0.57, 0.01], atol=1e-12)
    np.testing.assert_allclose(
        places["L_Foot"] - places["L_Ankle"], [0.03, -0.05, 0.12], atol=1e-12
    )
    assert len(joint_map(clip.skeleton)) == 18


@pytest.mark.parametrize("rate", ["60", b"60", ["60.0"], 60])
def test_a_rate_may_be_text(rate: object) -> None:
    assert read(mocap_framerate=np.array(rate)).fps == 60.0
    assert read(mocap_framerate=None, sample_rate=np.array(rate)).fps == 60.0


def test_an_elbow_turns_as_it_says() -> None:
    poses = standing()
    elbow = 18
    poses[:, 3 * elbow : 3 * elbow + 3] = [0.0, 0.3, 0.0]
    np.testing.assert_allclose(
        read(poses=poses).local_rotations[0, elbow], rotation.exp(np.array([0, 0.3, 0]))
    )


@pytest.mark.parametrize("columns", [66, 72, 156, 165])
def test_extra_joints_are_passed_over(columns: int) -> None:
    np.testing.assert_array_equal(
        read(poses=standing(4, columns)).local_rotations, read().local_rotations
    )


def walking(n_frames: int = 30) -> np.ndarray:
    """Rotation vectors (frames, 24, 3) of a body that stands along z and bends knees and elbows."""
    time = np.linspace(0.0, 2.0, n_frames)
    poses = 0.1 * np.sin(time[:, None, None] + np.arange(72).reshape(24, 3))
    poses[:, 0] = [np.pi / 2, 0.0, 0.0]
    poses[:, [1, 2, 4, 5], 0] = np.stack([-0.3 * time, 0.1 * time, 0.4 * time, time], axis=1)
    poses[:, 18, 1], poses[:, 19, 1] = -0.9 - time / 10, 0.5 + time / 5
    poses[:, 16, 2], poses[:, 17, 2] = -1.1, 1.1
    return poses


def as_form(form: str, poses: np.ndarray) -> np.ndarray:
    """The same rotations as programs write them, (frames, joints, numbers) or matrices."""
    quaternions = rotation.exp(poses)
    matrices = rotation.to_matrix(quaternions)
    return {
        "vectors": poses,
        "degrees": np.degrees(poses),
        "w first": quaternions * np.where(np.arange(len(poses)) % 2, 1, -1)[:, None, None],
        "w last": np.roll(quaternions, -1, axis=-1),
        "columns": np.concatenate([matrices[..., 0], matrices[..., 1]], axis=-1),
        "rows": matrices[..., :2, :].reshape(*poses.shape[:2], 6),
        "in turn": matrices[..., :2].reshape(*poses.shape[:2], 6),
        "matrices": matrices,
    }[form]


FORMS = ("vectors", "degrees", "w first", "w last", "columns", "rows", "in turn", "matrices")


def notes_of(form: str) -> tuple[str, ...]:
    return ("The angles are too large for radians: degrees.",) if form == "degrees" else ()


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.float16])
@pytest.mark.parametrize("form", FORMS)
def test_every_form_says_the_same(form: str, kind: type) -> None:
    numbers = as_form(form, walking()).astype(kind)
    arrays = {"trans": np.tile([1.0, 2.0, 0.92], (30, 1)), "fps": 30}
    wanted = read_amass(npz(poses=walking().reshape(30, 72), **arrays), "a.npz").local_rotations
    for n_joints in (22, 24):
        flat = numbers[:, :n_joints].reshape(30, -1)
        for poses in (flat, numbers[:, :n_joints], flat[None], numbers[None, :, :n_joints]):
            clip = read_amass(npz(poses=poses, **arrays), "a.npz")
            same = np.abs(np.einsum("fjk,fjk->fj", clip.local_rotations, wanted))
            assert same.min() > (1 - 2e-3 if kind is np.float16 else 1 - 1e-6)
            assert clip.notes == notes_of(form)


def test_a_root_in_degrees_shows_that_a_still_body_is() -> None:
    """Arms and legs turn by less than a degree, and the root by 90: where z is up, all do."""
    poses = walking() * 0.01
    poses[:, 0] = [np.pi / 2, 0.0, 0.0]
    arrays = {"trans": np.tile([1.0, 2.0, 0.92], (30, 1)), "fps": 30}
    wanted = read_amass(npz(poses=poses, **arrays), "a.npz")
    clip = read_amass(npz(poses=np.degrees(poses), **arrays), "a.npz")
    same = np.abs(np.einsum("fjk,fjk->fj", clip.local_rotations, wanted.local_rotations))
    assert same.min() > 1 - 1e-6
    assert set(notes_of("degrees")) == set(clip.notes) - set(wanted.notes)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "names", [("global_orient", "body_pose", "transl"), ("root_orient", "pose_body", "trans")]
)
def test_root_and_body_in_arrays_of_their_own(form: str, names: tuple[str, ...]) -> None:
    numbers, trans = as_form(form, walking()), np.tile([1.0, 2.0, 0.92], (30, 1))
    plain = read_amass(npz(poses=walking(), trans=trans, fps=60), "a.npz")
    for root, body in (
        (numbers[:, :1], numbers[:, 1:22]),
        (numbers[:, 0], numbers[:, 1:24]),
        (numbers[:, 0].reshape(30, -1), numbers[:, 1:].reshape(30, -1)),
        (numbers[None, :, :1], numbers[None, :, 1:]),
    ):
        clip = read_amass(npz(**dict(zip(names, (root, body, trans))), fps=60), "a.npz")
        same = np.abs(np.einsum("fjk,fjk->fj", clip.local_rotations, plain.local_rotations))
        assert same.min() > 1 - 1e-6
        np.testing.assert_allclose(clip.root_positions, plain.root_positions)
        assert clip.notes == notes_of(form)


def test_names_of_other_data() -> None:
    poses, trans = walking().reshape(30, 72), np.tile([1.0, 2.0, 0.92], (30, 1))
    data = npz(smpl_poses=poses, smpl_trans=90.0 * trans, smpl_scaling=[90.0], fps=60)
    plain = read_amass(npz(poses=poses, trans=trans, fps=60), "a.npz")
    np.testing.assert_allclose(read_amass(data, "a.npz").root_positions, plain.root_positions)
    assert read(mocap_framerate=None, fps=np.array([60])).fps == 60.0


@pytest.mark.parametrize(
    ("poses", "found"),
    [
        (
            np.ones((30, 96)),
            "quaternions, as 4 numbers a joint look like, found lengths from 2 to 2",
        ),
        (
            np.full((30, 24, 4), 0.5),
            "quaternions, as 4 numbers a joint look like, found no part that is the largest",
        ),
        (
            np.ones((30, 144)),
            "6D rotations, as 6 numbers a joint look like, found axes that are not orthonormal",
        ),
        (
            np.tile([1.0, 0, 0, 0, 1, 0], (30, 22)),
            "6D rotations, as 6 numbers a joint look like, found no bent knees or elbows to tell "
            "whether they are columns or rows",
        ),
        (
            np.tile(-np.eye(3).ravel(), (30, 24)),
            "matrices, as 9 numbers a joint look like, found ones that are no rotations",
        ),
    ],
)
def test_what_only_looks_like_rotations_is_refused(poses: np.ndarray, found: str) -> None:
    with pytest.raises(CaptureError) as caught:
        read_amass(npz(poses=poses, trans=np.zeros((30, 3)), fps=30), "a.npz")
    assert str(caught.value) == (
        f"a.npz: expected {found}. Export the poses of the SMPL body as axis-angle."
    )


@pytest.mark.parametrize("shape", [(30, 63), (30, 75), (30, 90), (30, 21, 3), (30, 22, 2), (30,)])
def test_other_widths_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(CaptureError, match=re.escape(f"found shape {shape}")):
        read_amass(npz(poses=np.zeros(shape), trans=np.zeros((30, 3)), fps=30), "a.npz")


def test_matrices_column_by_column() -> None:
    matrices = np.swapaxes(as_form("matrices", walking()), -1, -2)
    arrays = {"trans": np.tile([1.0, 2.0, 0.92], (30, 1)), "fps": 30}
    clip = read_amass(npz(poses=matrices, **arrays), "a.npz")
    plain = read_amass(npz(poses=walking(), **arrays), "a.npz")
    same = np.abs(np.einsum("fjk,fjk->fj", clip.local_rotations, plain.local_rotations))
    assert same.min() > 1 - 1e-6
    assert clip.notes == ("Knees and elbows show matrices column by column.",)


def test_a_missing_array_names_those_that_are_there() -> None:
    with pytest.raises(CaptureError, match=r"an array 'poses', found 'betas', 'fps', 'thetas'\."):
        read_amass(npz(betas=np.zeros(10), thetas=np.zeros((4, 72)), fps=30), "a.npz")
    with pytest.raises(CaptureError, match=r"an array 'trans', found 'fps', 'poses'\."):
        read_amass(npz(poses=np.zeros((4, 72)), fps=30), "a.npz")


@pytest.mark.parametrize("heading", [0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8, 5.6])
@pytest.mark.parametrize("face", ["up", "down"])
def test_a_posture_does_not_turn_the_world(heading: float, face: str) -> None:
    """A body that lies with its head anywhere; z is up."""
    poses = np.zeros((60, 66))
    about_z = rotation.from_axis_angle((0.0, 0.0, 1.0), heading)
    turn = rotation.from_axis_angle((0.0, 1.0, 0.0), 0.0 if face == "up" else np.pi)
    poses[:, :3] = rotation.log(rotation.multiply(about_z, turn))
    poses[:, 1 * 3] = 0.1 * np.sin(np.arange(60) / 10.0)
    clip = read_amass(npz(poses=poses, trans=np.tile([2.0, 1.0, 0.1], (60, 1)), fps=30), "a.npz")
    positions, _ = kinematics.clip_positions(clip)
    assert np.abs(positions[:, 15, 1] - positions[:, 0, 1]).max() < 0.1
    assert clip.up == "y"
    assert all(note.startswith("z is taken for up, as in AMASS") for note in clip.notes)
    data = npz(poses=poses, trans=np.zeros((60, 3)), fps=30)
    asked = read_amass(data, "a.npz", ReadOptions(up="y"))
    assert asked.up == "y"
    np.testing.assert_allclose(asked.local_rotations[:, 0], rotation.exp(poses[:, :3]), atol=1e-9)


def test_a_motion_shows_that_y_is_up() -> None:
    """A body that stands on a floor at y = 0, turns about, and bends its knees."""
    time = np.arange(120) / 30.0
    bend = 0.5 - 0.5 * np.cos(2.0 * time)
    poses = np.zeros((120, 24, 3))
    poses[:, 0, 1] = time / 2.0
    for joints, share in (([1, 2], -1.0), ([4, 5], 2.0), ([7, 8], -1.0)):
        poses[:, joints, 0] = share * bend[:, None]
    height = 0.78 * np.cos(bend) + 0.36  # thigh and shin; hip above pelvis, foot below ankle
    trans = np.stack([0.3 * np.sin(time), height, time / 5.0], axis=1)
    clip = read_amass(npz(poses=poses, trans=trans, fps=30), "a.npz")
    assert len(clip.notes) == 1
    assert clip.notes[0].startswith("y is taken for up")
    np.testing.assert_allclose(clip.root_positions[0], [0.0, height[0] - 0.22, 0.03], atol=1e-9)


@pytest.mark.parametrize("up", [up for up in world.UPS if up != "z"])
def test_a_body_that_stands_still_along_another_axis_is_told(up: str) -> None:
    poses = np.zeros((30, 66))
    poses[:, :3] = rotation.log(rotation.conjugate(world.to_y_up(up)))
    poses[:, 16 * 3 + 2], poses[:, 17 * 3 + 2] = -1.2, 1.2  # arms hang
    clip = read_amass(npz(poses=poses, trans=np.zeros((30, 3)), fps=30), "a.npz")
    (note,) = clip.notes
    assert note.startswith("z is taken for up, as in AMASS: the motion does not show for certain")


def test_of_two_rates_the_one_that_is_taken_is_told() -> None:
    assert read(mocap_framerate=120.0, fps=120).notes == ()
    clip = read(mocap_framerate=120.0, fps=30)
    assert (clip.fps, clip.notes) == (
        120.0,
        (
            "The file has mocap_framerate 120 and fps 30; 120 is taken. Give the right one (--fps) "
            "if this is wrong.",
        ),
    )


def test_bad_frames_can_be_left_out() -> None:
    poses = standing()
    poses[2, 5] = np.nan
    data = npz(poses=poses, trans=np.tile([1.0, 2.0, 0.92], (4, 1)), fps=30)
    clip = read_amass(data, "a.npz", ReadOptions(skip_bad_frames=True))
    assert clip.n_frames == 3
    assert clip.notes == ("Left out 1 bad frames; the first is 2.",)


def test_a_pickle_of_aist_is_read_like_arrays() -> None:
    """Its root is scaled, and it has no frame rate."""
    poses, trans = standing(columns=72), np.tile([1.0, 2.0, 0.92], (4, 1))
    motion = {"smpl_poses": poses, "smpl_trans": 90.0 * trans, "smpl_scaling": np.array([90.0])}
    clip = read_capture_bytes(pickle.dumps(motion), "robot", path="a.pkl")
    np.testing.assert_allclose(clip.world_positions(), read().world_positions(), atol=1e-12)
    assert clip.fps == 60.0
    assert clip.notes[0].startswith("The file has no frame rate; 60 a second are taken, as in AIST")


def test_one_rate_written_twice_is_one() -> None:
    assert read(mocap_framerate=np.array([120.0, 120.0])).fps == 120.0
