"""FBX through Blender, and USD through usd-core, where they are installed."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motiondb.body import kinematics
from motiondb.errors import CaptureError
from motiondb.files import fbx_writer
from motiondb.files.formats import read_capture
from motiondb.files.usd_writer import write_usd
from motiondb.records import Clip

SAMPLE = Path(__file__).parent.parent.parent / "sample_data" / "captures" / "ana" / "jump_1.bvh"


def a_clip(n_frames: int = 12) -> Clip:
    """Some frames, with a joint's name that Blender's importer would change."""
    clip = read_capture(SAMPLE)
    part = slice(30, 30 + n_frames)
    names = ("my Hips", *clip.skeleton.names[1:])
    return replace(
        clip,
        skeleton=replace(clip.skeleton, names=names),
        local_rotations=clip.local_rotations[part],
        root_positions=clip.root_positions[part],
    )


@pytest.mark.skipif(not fbx_writer.find_blender(), reason="needs Blender (pip install bpy)")
def test_fbx_reads_back_within_a_millimetre(tmp_path: Path) -> None:
    clip, path = a_clip(), tmp_path / "jump.fbx"
    fbx_writer.write_fbx(clip, path)
    back = read_capture(path)
    assert (back.n_frames, back.fps, back.unit) == (12, 30.0, 0.01)
    assert set(back.skeleton.names) == set(clip.skeleton.names)
    assert len(back.skeleton.end_sites) == len(clip.skeleton.end_sites)
    ours, theirs = kinematics.clip_positions(clip)[0], kinematics.clip_positions(back)[0]
    order = [back.skeleton.names.index(name) for name in clip.skeleton.names]
    np.testing.assert_allclose(theirs[:, order], ours, atol=1e-5)


def test_without_blender_fbx_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fbx_writer, "find_blender", list)
    with pytest.raises(CaptureError) as caught:
        fbx_writer.write_fbx(a_clip(), tmp_path / "a.fbx")
    assert str(caught.value) == (
        f"{tmp_path / 'a.fbx'}: expected Blender, which writes FBX, found neither a program "
        "`blender` on the PATH nor the package bpy. Install Blender (https://www.blender.org), or "
        "write .glb or .bvh."
    )


@pytest.mark.skipif(importlib.util.find_spec("pxr") is None, reason="needs usd-core")
@pytest.mark.parametrize("ending", [".usda", ".usdc"])
def test_usd_has_the_joints_at_their_places(ending: str, tmp_path: Path) -> None:
    from pxr import Usd, UsdGeom, UsdSkel

    clip, path = a_clip(), tmp_path / f"jump{ending}"
    write_usd(clip, path)
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert (stage.GetTimeCodesPerSecond(), stage.GetEndTimeCode()) == (30.0, 11.0)
    skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath("/Person/Skeleton"))
    assert tuple(skeleton.GetJointNamesAttr().Get()) == clip.skeleton.names
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root(stage.GetPrimAtPath("/Person")), Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(skeleton)
    expected = kinematics.clip_positions(clip)[0] * 100.0
    for frame in (0, 7):
        placed = np.array(query.ComputeJointSkelTransforms(frame))[:, 3, :3]
        np.testing.assert_allclose(placed, expected[frame], atol=0.01)


@pytest.mark.skipif(importlib.util.find_spec("pxr") is not None, reason="usd-core is installed")
def test_without_usd_core_usd_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=r"pip install motiondb\[usd\]"):
        write_usd(a_clip(), tmp_path / "a.usd")


def test_a_program_of_the_working_folder_is_not_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows looks there first, and others where the PATH says so."""
    (tmp_path / "bin").mkdir()
    for folder in (tmp_path, tmp_path / "bin"):
        for name in ("tool", "tool.EXE"):
            (folder / name).touch(mode=0o700)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", os.pathsep.join([".", "", str(tmp_path / "bin")]))
    assert fbx_writer.find_program("tool") == str(tmp_path / "bin" / "tool")
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setenv("PATHEXT", os.pathsep.join([".COM", ".EXE"]))
    assert fbx_writer.find_program("tool") == str(tmp_path / "bin" / "tool.EXE")
    monkeypatch.setenv("PATH", ".")
    assert fbx_writer.find_program("tool") is None
