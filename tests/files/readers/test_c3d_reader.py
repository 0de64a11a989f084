"""C3D through ezc3d, on files that the tests write: a person who stands in T-pose."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from odd_c3d import MARKERS

from motiondb.body import body, kinematics
from motiondb.errors import CaptureError
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.c3d import read_c3d

ezc3d = pytest.importorskip("ezc3d")


def tracks(n_frames: int = 30) -> dict[str, np.ndarray]:
    """The markers of a person who slides ahead by 1 cm a frame, metres, y up."""
    ahead = np.arange(n_frames)[:, None] * [0.0, 0.0, 0.01]
    return {name: np.array(place) / 100.0 + ahead for name, place in MARKERS.items()}


def write(
    folder: Path,
    markers: dict[str, np.ndarray],
    *,
    z_up: bool = True,
    prefix: str = "",
    units: str = "mm",
) -> bytes:
    points = np.array(list(markers.values()))
    if z_up:
        points = points[..., [0, 2, 1]] * [1.0, -1.0, 1.0]
    points = points * {"mm": 1000.0, "m": 1.0}[units]
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100]
    file["parameters"]["POINT"]["UNITS"]["value"] = [units]
    file["parameters"]["POINT"]["LABELS"]["value"] = [prefix + name for name in markers]
    data = np.ones((4, *points.shape[:2]))
    data[:3] = np.moveaxis(points, -1, 0)
    file["data"]["points"] = data
    file.write(str(folder / "a.c3d"))
    return (folder / "a.c3d").read_bytes()


@pytest.mark.parametrize(
    "how", [{}, {"z_up": False}, {"prefix": "Anna:"}, {"units": "m"}, {"prefix": "lab:Anna:"}]
)
def test_joint_centres_by_hand(tmp_path: Path, how: dict) -> None:
    clip = read_c3d(write(tmp_path, tracks(), **how), "a.c3d")
    assert (clip.fps, clip.format, clip.n_frames, clip.notes) == (100.0, "c3d", 30, ())
    assert clip.skeleton.names == body.JOINTS
    positions, _ = kinematics.clip_positions(clip)
    places = dict(zip(body.JOINTS, positions[10]))
    # W = 0.24 m: hips 0.0864 m to the side, 0.0456 m back, 0.072 m down from the front markers.
    np.testing.assert_allclose(places["l_hip"], [0.0864, 0.928, 0.1 - 0.0456 + 0.1], atol=2e-3)
    np.testing.assert_allclose(places["r_hip"], [-0.0864, 0.928, 0.1 - 0.0456 + 0.1], atol=2e-3)
    np.testing.assert_allclose(places["l_knee"], [0.1, 0.5, 0.1], atol=1e-2)
    np.testing.assert_allclose(places["r_ankle"], [-0.1, 0.08, 0.1], atol=1e-2)
    np.testing.assert_allclose(places["r_toe"], [-0.1, 0.03, 0.24], atol=1e-2)
    np.testing.assert_allclose(places["l_wrist"], [0.7, 1.45, 0.1], atol=2e-2)
    np.testing.assert_allclose(places["head"], [0.0, 1.7, 0.1], atol=2e-2)
    np.testing.assert_allclose(np.diff(clip.root_positions, axis=0), [[0, 0, 0.01]] * 29, atol=1e-6)


def test_cmu_names_of_the_pelvis(tmp_path: Path) -> None:
    names = {"LASI": "LFWT", "RASI": "RFWT", "LPSI": "LBWT", "RPSI": "RBWT"}
    markers = {names.get(name, name): track for name, track in tracks().items()}
    clip = read_c3d(write(tmp_path, markers), "a.c3d")
    plain = read_c3d(write(tmp_path, tracks()), "a.c3d")
    np.testing.assert_allclose(clip.local_rotations, plain.local_rotations, atol=1e-6)


def test_without_markers_that_can_be_spared(tmp_path: Path) -> None:
    spared = ("TOE", "WRA", "WRB", "TRN", "LAV", "FHD", "BHD")  # of STRN, CLAV, or of each side
    markers = {name: track for name, track in tracks().items() if name[1:] not in spared}
    positions, _ = kinematics.clip_positions(read_c3d(write(tmp_path, markers), "a.c3d"))
    places = dict(zip(body.JOINTS, positions[0]))
    for side, sign in (("l", 1), ("r", -1)):
        foot = places[f"{side}_toe"] - places[f"{side}_ankle"]
        np.testing.assert_allclose(foot, [0, -0.06, 0.14], atol=0.03)
        assert sign * (places[f"{side}_wrist"] - places[f"{side}_elbow"])[0] > 0.2


def test_a_missing_toe_points_ahead_of_the_heel(tmp_path: Path) -> None:
    markers = {name: track for name, track in tracks().items() if name not in ("LTOE", "RTOE")}
    markers["LHEE"] = markers["LANK"] + [-0.05, -0.03, -0.05]
    positions, _ = kinematics.clip_positions(read_c3d(write(tmp_path, markers), "a.c3d"))
    places = dict(zip(body.JOINTS, positions[0]))
    assert (places["l_toe"] - places["l_ankle"])[2] > 0.1


def test_gaps(tmp_path: Path) -> None:
    plain = read_c3d(write(tmp_path, tracks(200)), "a.c3d")
    markers = tracks(200)
    markers["LKNE"][20:40] = np.nan
    markers["RKNE"][:30] = np.nan
    markers["LTOE"][100:170] = np.nan
    clip = read_c3d(write(tmp_path, markers), "a.c3d")
    assert clip.notes == ("Left out markers that are lost for long: LTOE.",)
    np.testing.assert_allclose(
        clip.local_rotations[40:, 2], plain.local_rotations[40:, 2], atol=1e-5
    )
    markers["LKNE"][20:80] = np.nan
    data = write(tmp_path, markers)
    with pytest.raises(CaptureError) as caught:
        read_c3d(data, "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected no gap above 0.5 s, found lost markers: LKNE (0.6 s). Fill the gaps "
        "before the export, or pass --skip-bad-frames to leave those frames out."
    )
    clip = read_c3d(data, "a.c3d", ReadOptions(skip_bad_frames=True))
    assert clip.n_frames == 140
    assert clip.notes[0] == "Left out 60 frames with lost markers."


def test_missing_markers_are_named(tmp_path: Path) -> None:
    markers = {
        name: track for name, track in tracks().items() if name not in ("LKNE", "RPSI", "T10")
    }
    with pytest.raises(CaptureError) as caught:
        read_c3d(write(tmp_path, markers), "a.c3d")
    assert str(caught.value).startswith(
        "a.c3d: expected the markers of Plug-in Gait, found none named LKNE; "
        "LPSI and RPSI, or SACR (of the set there are: C7, CLAV, LANK, LASI,"
    )
    assert str(caught.value).endswith(
        "). Rename the markers, or export the solved skeleton as BVH."
    )


def test_two_performers_are_refused(tmp_path: Path) -> None:
    markers = {
        f"{who}:{name}": track for who in ("Ben", "Anna") for name, track in tracks().items()
    }
    with pytest.raises(CaptureError) as caught:
        read_c3d(write(tmp_path, markers), "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected one performer, found 2: Anna, Ben. Export one performer a file."
    )


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(CaptureError) as caught:
        read_c3d(b"HIERARCHY", "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected a C3D file, found something else. Export it again."
    )
    whole = write(tmp_path, tracks())
    for size in (600, 900, len(whole) - 2000):
        with pytest.raises(CaptureError) as caught:
            read_c3d(whole[:size], "a.c3d")
        assert str(caught.value).endswith(
            f" bytes as the header says, found {size}. The file is cut short: export it again."
        )


def test_a_damaged_file_cannot_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = bytearray(write(tmp_path, tracks()))
    data[512:1600] = bytes(range(256)) * 4 + bytes(64)
    monkeypatch.setattr("motiondb.files.readers.c3d.CPU_SECONDS", 2.0)
    with pytest.raises(CaptureError) as caught:
        read_c3d(bytes(data), "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected a whole C3D file, found a damaged one. Export it again."
    )


def test_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(CaptureError) as caught:
        read_c3d(b"", "a.c3d")
    assert str(caught.value) == (
        "a.c3d: expected the package ezc3d to read C3D, found none. pip install motiondb[c3d]"
    )
