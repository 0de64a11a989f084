"""FBX: files that Blender wrote from captures of the sample data (``fbx_by_blender.py``)."""

from __future__ import annotations

import gzip
import importlib.util
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import fbx_by_blender
import numpy as np
import pytest

from motiondb.body import kinematics, retarget
from motiondb.errors import CaptureError
from motiondb.files.formats import read_capture, read_capture_bytes, split_take
from motiondb.files.limits import NO_LIMITS, ReadLimits, ReadOptions
from motiondb.files.readers import fbx
from motiondb.files.readers.fbx_takes import FbxFile
from motiondb.records import Clip

FOLDER = Path(__file__).parent.parent / "fbx"


def data(name: str) -> bytes:
    return gzip.decompress((FOLDER / f"{name}.fbx.gz").read_bytes())


def opened(name: str, **how) -> FbxFile:
    return FbxFile(data(name), f"{name}.fbx", ReadOptions(**how))


def from_bvh(name: str, folder: Path) -> Clip:
    return read_capture(fbx_by_blender.cut(f"ana/{name}", folder))


def positions(clip: Clip) -> dict[str, np.ndarray]:
    places = kinematics.clip_positions(clip)[0]
    names = [name.rpartition(":")[2] for name in clip.skeleton.names]
    return {name: places[:, joint] for joint, name in enumerate(names)}


def distance(clip: Clip, other: Clip) -> float:
    """Largest distance of joints of one name, metres."""
    ours, theirs = positions(clip), positions(other)
    assert set(theirs) <= set(ours)
    return max(np.linalg.norm(ours[name] - theirs[name], axis=-1).max() for name in theirs)


@pytest.mark.parametrize("take", ["bow_1", "jump_1"])
def test_joints_stand_where_the_bvh_has_them(take: str, tmp_path: Path) -> None:
    assert opened("two_takes").labels == ("bow_1", "jump_1")
    clip, bvh = opened("two_takes").clip(take), from_bvh(take, tmp_path)
    assert distance(clip, bvh) < 1e-4  # a millimetre is asked for
    assert (clip.fps, clip.n_frames, clip.unit, clip.notes) == (30.0, 9, 1.0, ())
    ours, theirs = retarget.to_motion(clip), retarget.to_motion(bvh)
    apart = ours.joint_positions()[:, :4] - theirs.joint_positions()[:, :4]
    assert np.abs(apart).max() < 1e-3


def test_namespaces_axes_and_a_moved_armature(tmp_path: Path) -> None:
    clip, bvh = opened("mixamo").clip("jump_1"), from_bvh("jump_1", tmp_path)
    assert clip.skeleton.names[0] == "mixamorig:Hips"
    assert len(clip.skeleton.end_sites) == 5  # the leaf bones of Blender
    assert clip.joint_positions is None  # every bone keeps its length
    places, others = positions(clip), positions(bvh)
    turned = np.array([[np.cos(0.5), 0, np.sin(0.5)], [0, 1, 0], [-np.sin(0.5), 0, np.cos(0.5)]])
    for name, place in others.items():  # the armature stands at (1, 2, 0) with z up, turned by 0.5
        np.testing.assert_allclose(places[name], place @ turned.T + [1.0, 0.0, -2.0], atol=1e-4)


def test_the_child_process_reads_the_same() -> None:
    here = opened("two_takes").clip("jump_1")
    options = ReadOptions(limits=NO_LIMITS, take="jump_1")
    clip = fbx.read_fbx(data("two_takes"), "two_takes.fbx", options)
    for name in ("local_rotations", "root_positions", "joint_positions"):
        np.testing.assert_array_equal(getattr(clip, name), getattr(here, name))
    assert clip.skeleton.names == here.skeleton.names
    np.testing.assert_array_equal(clip.skeleton.parents, here.skeleton.parents)


def test_given_rate_and_unit() -> None:
    clip = opened("mixamo", fps=60.0, unit=0.02).clip("jump_1")
    assert (clip.fps, clip.n_frames, clip.unit) == (60.0, 17, 0.02)
    plain = opened("mixamo").clip("jump_1")
    np.testing.assert_allclose(clip.root_positions[::2], 2.0 * plain.root_positions, atol=1e-6)


def test_a_unit_that_cannot_be_is_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    file = opened("mixamo")
    monkeypatch.setattr(file._scene, "unit", 1.0)
    clip = file.clip("jump_1")
    assert clip.unit == 0.01
    assert clip.notes == (
        "The file says that its unit is 1 m; the body would be 96 times the usual size, so 0.01 m "
        "is taken. Give the unit if it is wrong.",
    )


ERRORS = [
    (
        "junk",
        b"Kaydara? " * 50,
        "expected an FBX file, found other content. Check what the file is.",
    ),
    ("empty", b"", "expected a whole FBX file, found one that is cut short. Export it again."),
    (
        "still",
        data("still"),
        "expected a take with animation of the skeleton, found none. Plot the animation onto the "
        "skeleton and export it with the file.",
    ),
]


@pytest.mark.parametrize(("name", "content", "said"), ERRORS)
def test_files_that_cannot_be_read(name: str, content: bytes, said: str) -> None:
    with pytest.raises(CaptureError) as caught:
        FbxFile(content, f"{name}.fbx", ReadOptions())
    assert str(caught.value) == f"{name}.fbx: {said}"


def test_a_file_with_takes_needs_one() -> None:
    with pytest.raises(CaptureError) as caught:
        opened("two_takes").chosen("")
    assert str(caught.value) == (
        "two_takes.fbx: expected the name of one of its 2 takes after #, found none. There are: "
        "bow_1, jump_1."
    )
    with pytest.raises(CaptureError) as caught:
        opened("two_takes").chosen("jump1")
    assert str(caught.value) == (
        "two_takes.fbx: expected a take, found 'jump1'. There are: bow_1, jump_1. Did you mean "
        "jump_1?"
    )
    assert split_take("a/b.fbx#jump_1") == (Path("a/b.fbx"), "jump_1")


def test_damaged_files_end_in_a_sentence() -> None:
    whole, rng = bytearray(data("mixamo")), np.random.default_rng(4)
    for cut in (100, 5_000, 60_000):
        with pytest.raises(CaptureError):
            FbxFile(bytes(whole[:cut]), "cut.fbx", ReadOptions())
    for place in rng.integers(30, len(whole), 3):
        broken = bytes(whole[:place]) + b"\xff" * 8 + bytes(whole[place + 8 :])
        with suppress(CaptureError):  # it may be read, if no joint stands there
            FbxFile(broken, "broken.fbx", ReadOptions()).clip("jump_1")


def test_limits() -> None:
    with pytest.raises(CaptureError) as caught:
        opened("mixamo", limits=ReadLimits(joints=10))
    assert str(caught.value) == "mixamo.fbx: expected at most 10 joints, found 21. Export fewer."
    with pytest.raises(CaptureError, match=r"within 0\.01 s, found .* --time-limit"):
        fbx.read_fbx(data("mixamo"), "slow.fbx", ReadOptions(limits=ReadLimits(seconds=0.01)))


@pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="needs bpy (pip install bpy)")
def test_blender_writes_what_the_tests_read(tmp_path: Path) -> None:
    fbx_by_blender.write(tmp_path, "mixamo")
    new = FbxFile((tmp_path / "mixamo.fbx").read_bytes(), "new.fbx", ReadOptions()).clip("jump_1")
    assert distance(new, from_bvh("jump_1", tmp_path)) > 1.0  # moved, as the test above measures
    assert distance(new, opened("mixamo").clip("jump_1")) < 1e-6


def test_keys_say_the_rate_and_the_length(tmp_path: Path) -> None:
    clip = read_capture_bytes(data("dense"), "fbx", path="dense.fbx")
    assert (clip.fps, clip.n_frames) == (30.0, 17)
    assert clip.notes == (
        "Left out 22 still frames before the first key and after the last.",
        "The scene has 15 frames a second and the take 30 keys a second: 30 is taken.",
    )
    every = distance(replace_frames(clip, slice(None, None, 2)), from_bvh("jump_1", tmp_path))
    assert every < 1e-2  # Blender leaves keys out that change little
    assert read_capture_bytes(data("dense"), "fbx", options=ReadOptions(fps=15.0)).n_frames == 9


def replace_frames(clip: Clip, chosen: slice) -> Clip:
    moved = clip.joint_positions
    return replace(
        clip,
        local_rotations=clip.local_rotations[chosen],
        root_positions=clip.root_positions[chosen],
        joint_positions=None if moved is None else moved[chosen],
    )
