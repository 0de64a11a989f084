"""Data sets of the package movement, written and read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sample_motions import sample_clip, sample_motion

import motiondb
from motiondb.body import body, retarget
from motiondb.files.readers import movement
from motiondb.files.readers.movement import to_dataset

pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")
COCO = {
    f"{long}_{part}": f"{long[0]}_{part}"
    for long in ("left", "right")
    for part in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
}


def of_camera() -> Any:
    """A walk by the names of COCO, which have no neck, in cm with z up."""
    clip = retarget.to_clip(sample_motion("ana/walk_1"))
    data = to_dataset(clip, "ana").sel(keypoint=list(COCO.values()))
    position = 100.0 * data["position"].values[:, [2, 0, 1]]
    data = data.assign_coords(keypoint=list(COCO)).copy()
    data["position"].values[:] = position
    return data


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Convert in this process: each child imports xarray for a second."""

    def convert(_module: str, data: bytes, *_limits: object) -> dict[str, Any]:
        source, target = tmp_path / "copy", tmp_path / "arrays.npz"
        source.write_bytes(data)
        movement.convert(str(source), str(target), [])
        with np.load(target) as file:
            return dict(file)

    monkeypatch.setattr(movement, "read_in_child", convert)


def read(data: Any, path: Path, **how: Any) -> motiondb.Clip:
    data.to_netcdf(path)
    return motiondb.read_capture(path, **how)


def test_the_form_of_movement() -> None:
    clip = sample_clip("ana/bow_1")
    data = to_dataset(clip, "ana", "bow_1.bvh")
    assert data["position"].dims == ("time", "space", "keypoint", "individual")
    assert data["confidence"].dims == ("time", "keypoint", "individual")
    assert data.attrs == {
        "fps": 30.0,
        "time_unit": "seconds",
        "source_software": "motiondb",
        "source_file": "bow_1.bvh",
        "ds_type": "poses",
    }
    one = data["position"].sel(individual="ana", keypoint="LeftHand", space="y").values
    np.testing.assert_array_equal(
        one, clip.world_positions()[:, clip.joint_names.index("LeftHand"), 1]
    )


def test_a_written_capture_is_read_again(tmp_path: Path) -> None:
    read_back = read(to_dataset(sample_clip("ana/long_1"), "ana"), tmp_path / "a.nc")
    apart = retarget.to_motion(read_back).joint_positions()
    apart = apart - sample_motion("ana/long_1").joint_positions()
    assert np.linalg.norm(apart, axis=-1).max() < 0.02


@pytest.mark.usefixtures("here")
def test_keypoints_of_a_camera_become_a_body(tmp_path: Path) -> None:
    clip = read(of_camera(), tmp_path / "a.nc")
    assert (clip.unit, clip.up, clip.fps) == (0.01, "y", 30.0)
    solved = retarget.to_motion(clip).joint_positions()
    true = sample_motion("ana/walk_1").joint_positions()
    for joint in ("l_knee", "r_ankle", "l_wrist"):  # relative to the pelvis, whatever the heading
        height = [p[:, body.INDEX[joint], 1] - p[:, 0, 1] for p in (solved, true)]
        np.testing.assert_allclose(*height, atol=0.03)
    swapped = read(of_camera(), tmp_path / "b.nc", swap_sides=True)
    assert not np.allclose(swapped.local_rotations, clip.local_rotations)


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.rename(keypoint="keypoints", individual="individuals"),
        lambda d: d.isel(individual=0),
        lambda d: d.isel(individual=0, drop=True).rename(keypoint="keypoints"),
    ],
    ids=["before 0.17", "one individual selected", "one without a name"],
)
def test_other_names_of_dimensions_are_the_same(change: Any, tmp_path: Path) -> None:
    clip, other = read(of_camera(), tmp_path / "a.nc"), read(change(of_camera()), tmp_path / "b.nc")
    np.testing.assert_array_equal(clip.local_rotations, other.local_rotations)


@pytest.mark.usefixtures("here")
def test_gaps_are_filled_or_left_out(tmp_path: Path) -> None:
    data = of_camera()
    data["position"].values[10:15, :, 3] = np.nan
    assert read(data, tmp_path / "a.nc").n_frames == len(data.time)
    data["position"].values[10:60, :, 3] = np.nan
    with pytest.raises(motiondb.CaptureError, match=r"lost keypoints: left_shoulder \(1\.7 s\)"):
        read(data, tmp_path / "b.nc")
    assert read(data, tmp_path / "b.nc", skip_bad_frames=True).n_frames == len(data.time) - 50


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.isel(space=[0, 1]), "found x and y alone"),
        (lambda d: d.drop_vars("position"), "found other data"),
        (lambda d: d.isel(keypoint=0), "found position over individual, space, time"),
        (lambda d: d.isel(keypoint=[0, 1, 2]), "expected joints for r_hip"),
        (
            lambda d: d.sel(individual=["ana"] * 2).assign_coords(individual=["ana", "boris"]),
            "found 2: ana, boris",
        ),
        (lambda d: d.assign_attrs(fps=0.0, time_unit="frames"), "expected the attribute fps"),
    ],
)
def test_what_is_no_pose_of_a_person_is_refused(change: Any, said: str, tmp_path: Path) -> None:
    with pytest.raises(motiondb.CaptureError, match=said):
        read(change(of_camera()), tmp_path / "a.nc")


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(range(256)))
    with pytest.raises(motiondb.CaptureError, match="expected a file that can be read"):
        motiondb.read_capture(tmp_path / "a.nc")
