"""Which files are captures, which reader reads them, and captures from bytes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motiondb.body import body
from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.folder import CAPTURE_ENDINGS, find_captures
from motiondb.files.formats import capture_format, read_capture, read_capture_bytes
from motiondb.files.limits import ReadOptions
from motiondb.records import Clip


def a_clip() -> Clip:
    turns = np.tile([1.0, 0, 0, 0], (3, 21, 1))
    return Clip(body.standard_skeleton(), 30.0, turns, np.ones((3, 3)), unit=0.01)


def test_find_captures(tmp_path: Path) -> None:
    (tmp_path / "b" / "c").mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    files = {
        "b/walk.BVH": b"",
        "a.bvh": b"",
        "b/c/16_01.amc": b"",
        "b/c/16.asf": b"",
        "notes.txt": b"a walk, then a jump",
        "flip.txt": b'{\n"Loop": "none",\n"Frames": []}',
        "late.json": b'{"x": "' + b"y" * 9000 + b'", "Frames": []}',
        "package.json": b'{"name": 1}',
        "poses.npz": b"",
        "take.C3D": b"",
        "sheet.tsv": b"",
        ".hidden/x.bvh": b"",
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "folder.bvh").mkdir()
    actual = [path.relative_to(tmp_path).as_posix() for path in find_captures(tmp_path)]
    assert actual == [
        "a.bvh",
        "b/c/16_01.amc",
        "b/walk.BVH",
        "flip.txt",
        "late.json",
        "poses.npz",
        "take.C3D",
    ]
    assert find_captures(tmp_path / "b" / "c" / "none") == []


def test_formats() -> None:
    assert [capture_format(f"a{ending}") for ending in CAPTURE_ENDINGS] == [
        "bvh",
        "amc",
        "deepmimic",
        "deepmimic",
        "amass",
        "c3d",
        "fbx",
        "trc",
        "movement",
        "positions",
        "robot",
        "markers",
        "markers",
        "robot",
        "opensim",
        "opensim",
    ]
    with pytest.raises(CaptureError) as caught:
        capture_format("walk.htr")
    assert str(caught.value) == (
        "walk.htr: expected a capture (.bvh, .amc, .txt, .json, .npz, .c3d, .fbx, .trc, .nc, "
        ".npy, .csv, .tsv, .mvnx, .pkl, .mot, .sto), found ending '.htr' (Motion Analysis HTR). "
        "Rename or convert it."
    )


def test_bytes_and_file_give_the_same(tmp_path: Path) -> None:
    write_bvh(a_clip(), tmp_path / "a.bvh")
    data = (tmp_path / "a.bvh").read_bytes()
    clips = [
        read_capture(tmp_path / "a.bvh"),
        read_capture(str(tmp_path / "a.bvh")),
        read_capture_bytes(data, "bvh"),
    ]
    for clip in clips:
        np.testing.assert_allclose(clip.root_positions, np.ones((3, 3)))
    assert read_capture(tmp_path / "a.bvh", unit=1.0).root_positions[0, 0] == 100.0


def test_refusals(tmp_path: Path) -> None:
    with pytest.raises(CaptureError) as caught:
        read_capture("none/walk.bvh")
    assert str(caught.value) == (
        "none/walk.bvh: expected a readable file, found: no such file or directory."
    )
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(b"x", "htr", path="a.htr")
    assert str(caught.value) == "a.htr: expected a known format, found 'htr'."
    for fps in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(CaptureError, match="expected a frame rate from 1 to 10000, found"):
            read_capture_bytes(b"x", "bvh", path="a.bvh", options=ReadOptions(fps=fps))
