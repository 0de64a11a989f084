"""SMPL-style npz: the world is set upright, the arrays may come in several shapes."""

from __future__ import annotations

import io

import numpy as np
import pytest

from motiondb.body import kinematics, rotation
from motiondb.body.joint_names import joint_map
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.amass import N_JOINTS, read_amass


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
        "trans": np.tile([1.0, 2.0, 1.1], (4, 1)),
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
    np.testing.assert_allclose(places["Pelvis"], [1.0, 1.13, -1.78], atol=1e-12)
    np.testing.assert_allclose(places["Head"] - places["Pelvis"], [0, 0.57, 0.01], atol=1e-12)
    np.testing.assert_allclose(
        places["L_Foot"] - places["L_Ankle"], [0.03, -0.05, 0.12], atol=1e-12
    )
    assert len(joint_map(clip.skeleton)) == 18


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


def test_other_arrays_that_say_the_same() -> None:
    whole = standing(4, 66)
    parts = read(poses=None, root_orient=whole[:, :3], pose_body=whole[:, 3:])
    np.testing.assert_array_equal(parts.local_rotations, read().local_rotations)
    cubes = read(poses=whole.reshape(4, N_JOINTS, 3))
    np.testing.assert_array_equal(cubes.local_rotations, read().local_rotations)
    assert read(mocap_framerate=None, fps=np.array([60])).fps == 60.0


def test_a_world_with_y_up_is_kept() -> None:
    clip = read(poses=np.zeros((4, 66)))
    assert clip.notes == ("The bodies stand along y: the world is taken to have y up.",)
    np.testing.assert_allclose(clip.root_positions[0], [1.0, 1.78, 1.13])


def test_bad_frames_can_be_left_out() -> None:
    poses = standing()
    poses[2, 5] = np.nan
    data = npz(poses=poses, trans=np.zeros((4, 3)), fps=30)
    clip = read_amass(data, "a.npz", ReadOptions(skip_bad_frames=True))
    assert clip.n_frames == 3
    assert clip.notes == ("Left out 1 bad frames; the first is 2.",)
