"""BVH out: what is read again is the same motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import body, kinematics, rotation
from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import to_bvh, write_bvh
from motiondb.files.limits import ReadOptions
from motiondb.files.readers.bvh import read_bvh
from motiondb.records import Clip, Skeleton

AXES = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def random_clip(seed: int, n_joints: int, n_frames: int, moved: bool) -> Clip:
    """Any tree, any channel order, any rotation; with ``moved`` every joint has positions."""
    rng = np.random.default_rng(seed)
    parents = np.array([-1] + [int(rng.integers(0, joint)) for joint in range(1, n_joints)])
    offsets = rng.normal(size=(n_joints, 3)) * 0.3
    channels = []
    for joint in range(n_joints):
        names = [f"{axis}rotation" for axis in AXES[rng.integers(6)]]
        if joint == 0 or moved:
            names = [f"{axis}position" for axis in "XYZ"] + names
        channels.append(tuple(rng.permutation(names)) if joint == 0 else tuple(names))
    rotations = rotation.normalize(rng.normal(size=(n_frames, n_joints, 4)))
    roots = rng.normal(size=(n_frames, 3))
    positions = offsets + rng.normal(size=(n_frames, n_joints, 3)) * 0.1
    positions[:, 0] = roots
    return Clip(
        skeleton=Skeleton(
            names=tuple(f"joint {n}" for n in range(n_joints)),
            parents=parents,
            offsets=offsets,
            end_sites=((n_joints - 1, (0.1, 0.0, -0.2)),),
            channels=tuple(channels),
        ),
        fps=60.0,
        local_rotations=rotations,
        root_positions=roots,
        joint_positions=positions if moved else None,
        unit=float(rng.choice([1.0, 0.01, 0.0254 / 0.45])),
    )


def by_name(clip: Clip) -> np.ndarray:
    """World positions with joints in order of their numbers."""
    order = np.argsort([int(name.split()[-1]) for name in clip.skeleton.names])
    return kinematics.clip_positions(clip)[0][:, order]


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n_joints=st.integers(1, 7),
    n_frames=st.integers(1, 4),
    moved=st.booleans(),
)
def test_what_is_written_is_read_again(
    seed: int, n_joints: int, n_frames: int, moved: bool
) -> None:
    clip = random_clip(seed, n_joints, n_frames, moved)
    again = read_bvh(to_bvh(clip).encode(), "x.bvh", ReadOptions(unit=clip.unit))
    np.testing.assert_allclose(by_name(again), by_name(clip), atol=1e-6)
    assert (n_joints - 1, (0.1, 0.0, -0.2)) in [
        (int(again.skeleton.names[joint].split()[-1]), tuple(np.round(offset, 6)))
        for joint, offset in again.skeleton.end_sites
    ]
    assert again.fps == clip.fps
    third = read_bvh(to_bvh(again).encode(), "x.bvh", ReadOptions(unit=clip.unit))
    np.testing.assert_allclose(third.root_positions, again.root_positions, atol=1e-8)
    alike = np.abs(np.sum(third.local_rotations * again.local_rotations, axis=-1))
    np.testing.assert_allclose(alike, 1.0, atol=1e-12)
    assert third.skeleton.channels == again.skeleton.channels


def test_text_by_hand(tmp_path: Path) -> None:
    skeleton = Skeleton(
        names=("Hips", "Leg"),
        parents=np.array([-1, 0]),
        offsets=np.array([[0, 0, 0], [0, -0.45, 0]]),
        end_sites=((1, (0.0, -0.4, 0.0)),),
        channels=(("Yposition", "Zrotation", "Yrotation", "Xrotation"), ("Xrotation",)),
    )
    turns = rotation.from_euler([[[0.0, 0, 0], [0, 0, -30.0]]], "ZYX")
    clip = Clip(skeleton, 30.0, turns, np.array([[0.0, 0.9, 0.0]]), unit=0.01)
    write_bvh(clip, tmp_path / "a.bvh")
    assert (tmp_path / "a.bvh").read_text() == (
        "HIERARCHY\n"
        "ROOT Hips\n"
        "{\n"
        "\tOFFSET 0.000000 0.000000 0.000000\n"
        "\tCHANNELS 4 Yposition Zrotation Yrotation Xrotation\n"
        "\tJOINT Leg\n"
        "\t{\n"
        "\t\tOFFSET 0.000000 -45.000000 0.000000\n"
        "\t\tCHANNELS 3 Xrotation Zrotation Yrotation\n"
        "\t\tEnd Site\n"
        "\t\t{\n"
        "\t\t\tOFFSET 0.000000 -40.000000 0.000000\n"
        "\t\t}\n"
        "\t}\n"
        "}\n"
        "MOTION\n"
        "Frames: 1\n"
        "Frame Time: 0.03333333333\n"
        "90.000000 0.000000 0.000000 0.000000 -30.000000 0.000000 0.000000\n"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["a.bvh"]


def test_channels_grow_where_they_cannot_say_the_motion() -> None:
    skeleton = Skeleton(
        names=("joint 0", "joint 1"),
        parents=np.array([-1, 0]),
        offsets=np.array([[0.0, 0, 0], [0, -0.45, 0]]),
        channels=((), ("Xrotation",)),
    )
    turns = rotation.normalize(np.random.default_rng(0).normal(size=(3, 2, 4)))
    clip = Clip(skeleton, 30.0, turns, np.ones((3, 3)), unit=0.01)
    again = read_bvh(to_bvh(clip).encode(), "x.bvh", ReadOptions(unit=0.01))
    assert again.skeleton.channels == (
        ("Xposition", "Yposition", "Zposition", "Zrotation", "Yrotation", "Xrotation"),
        ("Xrotation", "Zrotation", "Yrotation"),
    )
    np.testing.assert_allclose(by_name(again), by_name(clip), atol=1e-7)


def test_programs_that_add_and_that_replace_read_the_same() -> None:
    clip = random_clip(3, 4, 2, False)
    moved = replace(clip.skeleton, offsets=clip.skeleton.offsets + 1.0, channels=())
    text = to_bvh(replace(clip, skeleton=moved))
    assert text.splitlines()[3].split() == ["OFFSET", *["0." + "0" * 6] * 3]
    again = read_bvh(text.encode(), "x.bvh", ReadOptions(unit=clip.unit))
    np.testing.assert_allclose(again.root_positions, clip.root_positions, atol=1e-6)
    assert all(len(c) - ("Xposition" in c) * 3 == 3 for c in again.skeleton.channels)


def test_gimbal_lock_comes_back() -> None:
    skeleton = body.standard_skeleton()
    angles = np.zeros((3, 21, 3))
    angles[:, :, 0], angles[:, :, 1] = 30.0, [[90.0], [-90.0], [89.9999999]]
    turns = rotation.from_euler(angles, "ZYX")
    clip = Clip(skeleton, 30.0, turns, np.zeros((3, 3)), unit=0.01)
    again = read_bvh(to_bvh(clip).encode(), "x.bvh", ReadOptions(unit=0.01))
    alike = np.abs(np.sum(again.local_rotations * turns, axis=-1))
    np.testing.assert_allclose(alike, 1.0, atol=1e-12)


def test_angles_do_not_jump_by_a_turn() -> None:
    skeleton = body.standard_skeleton()
    turns = np.tile(rotation.IDENTITY, (73, 21, 1))
    turns[:, 0] = rotation.from_euler(np.arange(73)[:, None] * 10.0, "Y")
    clip = Clip(skeleton, 30.0, turns, np.zeros((73, 3)), unit=0.01)
    text = to_bvh(clip)
    rows = np.array([line.split() for line in text.splitlines()[-73:]], dtype=float)
    np.testing.assert_allclose(np.diff(rows[:, 4]), 10.0, atol=1e-5)
    np.testing.assert_allclose(rows[:, [3, 5]], 0.0, atol=1e-5)


def test_refusals(tmp_path: Path) -> None:
    clip = random_clip(0, 2, 1, False)
    bad = Clip(clip.skeleton, 30.0, clip.local_rotations * np.nan, clip.root_positions)
    empty = Clip(clip.skeleton, 30.0, clip.local_rotations[:0], clip.root_positions[:0])
    for refused, name, said in (
        (clip, "none/a.bvh", "expected a folder to write in, found no folder"),
        (bad, "a.bvh", r"a\.bvh: expected finite numbers to write, found NaN or infinity\."),
        (empty, "a.bvh", r"expected at least 1 frame to write, found 0\."),
    ):
        with pytest.raises(CaptureError, match=said):
            write_bvh(refused, tmp_path / name)
    assert list(tmp_path.iterdir()) == []
