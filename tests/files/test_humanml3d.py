"""HumanML3D's numbers: worked by hand, recovered as published, and written as a folder."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.body import kinematics, rotation
from motiondb.body.body import LEG_LENGTH
from motiondb.files import humanml3d
from motiondb.files.readers.point_motion import humanml3d_positions
from motiondb.files.rigs import own_rig
from motiondb.records import Caption, FloatArray
from tests.sample_motions import SAMPLES

STANDING = kinematics.clip_positions(own_rig("smpl"))[0][0]


def _walk(turn: float, frames: int = 40) -> FloatArray:
    """A stiff body that goes ahead by 5 cm a frame, and turns by an angle a frame."""
    heading = turn * np.arange(frames)
    turns = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), heading)
    ahead = rotation.rotate(turns, np.array([0.0, 0.0, 0.05]))
    way = np.concatenate([np.zeros((1, 3)), np.cumsum(ahead[:-1], axis=0)])
    bodies = rotation.rotate(
        np.broadcast_to(turns[:, None], (frames, 22, 4)),
        np.broadcast_to(STANDING, (frames, 22, 3)),
    )
    return bodies + way[:, None] + [3.0, 0.4, -2.0]


def test_numbers_of_a_body_that_goes_ahead_by_hand() -> None:
    numbers = humanml3d.motion_numbers(_walk(0.0))
    assert numbers.shape == (39, 263)
    height = STANDING[0, 1] - STANDING[:, 1].min()
    np.testing.assert_allclose(numbers[:, :4], [[0.0, 0.0, 0.05, height]] * 39, atol=1e-9)
    ways = numbers[:, 193:259].reshape(39, 22, 3)
    np.testing.assert_allclose(ways, np.broadcast_to([0.0, 0.0, 0.05], ways.shape), atol=1e-9)
    assert not numbers[:, 259:].any()  # 0.05 m a frame is more than sqrt(0.002) = 0.0447
    hip = numbers[0, 4:7]
    np.testing.assert_allclose(hip[[0, 2]], (STANDING[1] - STANDING[0])[[0, 2]], atol=1e-9)
    assert hip[0] > 0.0  # The left hip is at +x of who looks along +z
    # the first bone, of the left hip, points along x where nothing is turned
    bone = STANDING[1] - STANDING[0]
    first = np.concatenate([numbers[0, 67:70], numbers[0, 70:73]])
    np.testing.assert_allclose(first[:3], bone / np.linalg.norm(bone), atol=1e-9)
    assert humanml3d.motion_numbers(np.repeat(_walk(0.0)[:1], 5, axis=0))[:, 259:].all()


def test_places_come_back_up_to_where_the_motion_begins() -> None:
    places = _walk(0.03)
    numbers = humanml3d.motion_numbers(places)
    back = humanml3d_positions(numbers)
    given = places[:-1]
    apart = np.linalg.norm(given[:, :, None] - given[:, None], axis=-1)
    np.testing.assert_allclose(
        np.linalg.norm(back[:, :, None] - back[:, None], axis=-1), apart, atol=1e-6
    )
    steps = np.linalg.norm(np.diff(back[:, 0], axis=0), axis=1)
    np.testing.assert_allclose(steps, 0.05, atol=1e-6)
    # one turn about y takes all frames there; the height is over the lowest joint
    flat = given - given[:, :1].mean(axis=0) * [1.0, 0.0, 1.0]
    there = back - back[:, :1].mean(axis=0) * [1.0, 0.0, 1.0]
    angles = np.arctan2(there[..., 0], there[..., 2]) - np.arctan2(flat[..., 0], flat[..., 2])
    far = np.hypot(flat[..., 0], flat[..., 2]) > 0.1
    assert np.abs(np.angle(np.exp(1j * (angles[far] - angles[far][0])))).max() < 1e-6
    np.testing.assert_allclose(back[..., 1], given[..., 1] - given[..., 1].min(), atol=1e-9)


def test_turns_of_bones_give_their_directions_back() -> None:
    """Chains anew from the root, as HumanML3D's own forward kinematics goes."""
    places = _walk(0.03)
    numbers = humanml3d.motion_numbers(places)
    columns = numbers[:, 67:193].reshape(-1, 21, 2, 3)
    third = np.cross(columns[:, :, 0], columns[:, :, 1])
    local = rotation.from_matrix(np.stack([columns[:, :, 0], columns[:, :, 1], third], axis=-1))
    root = humanml3d._into_root(places, 20.0)[:-1]
    for chain in humanml3d._CHAINS:
        above = root
        for start, end in pairwise(chain):
            above = rotation.multiply(above, local[:, end - 1])
            bone = rotation.normalize(places[:-1, end] - places[:-1, start])
            found = rotation.rotate(above, np.broadcast_to(humanml3d._BONES[end], bone.shape))
            np.testing.assert_allclose(found, bone, atol=1e-6)


def test_lines_of_texts() -> None:
    lines = humanml3d.text_lines(
        [Caption("he walks#and turns\nleft"), Caption("Stop!", 2.0, 4.25)], 9.0
    )
    first, second = lines.splitlines()
    assert first.split("#")[0] == "he walks and turns left"
    assert first.split("#")[1].startswith("he/PRON walk/OTHER and/CCONJ turn/OTHER")
    assert first.split("#")[2:] == ["0.0", "0.0"]
    assert second == "Stop!#stop/OTHER#2.0#4.2"
    parts = [Caption("walk", 5.0), Caption("jump", 0.0, 0.04)]
    assert humanml3d.text_lines(parts, 9.0) == "walk#walk/OTHER#5.0#9.0\n"


def test_a_folder_that_others_read(tmp_path: Path) -> None:
    paths = [SAMPLES / "captures" / "ana" / name for name in ("walk_1.bvh", "jump_1.bvh")]
    with motiondb.open(tmp_path / "a.duckdb") as db:
        db.add(paths)
        names = [info.name for info in db.captures()]
        db.words.add("she walks", ["walk_1"])
        written = db.captures.to_humanml3d("", tmp_path / "set")
    assert (written.captures, written.captions, written.without_captions) == (2, 1, 1)
    folder = tmp_path / "set"
    numbers = np.load(folder / "new_joint_vecs" / "000001.npy")
    joints = np.load(folder / "new_joints" / "000001.npy")
    assert numbers.shape == (len(joints), 263)
    np.testing.assert_allclose(humanml3d_positions(numbers), joints, atol=1e-4)
    assert (folder / "all.txt").read_text() == "000001\n"
    assert (folder / "texts" / "000001.txt").read_text().startswith("she walks#she/PRON walk/")
    every = np.concatenate(
        [np.load(path) for path in sorted((folder / "new_joint_vecs").iterdir())]
    )
    np.testing.assert_allclose(np.load(folder / "Mean.npy"), every.mean(axis=0), atol=1e-4)
    deviation = np.load(folder / "Std.npy")
    assert deviation.shape == (263,)
    assert len({*deviation[4:67].tolist()}) == 1
    expected = [every.std(axis=0)[low:high].mean() for low, high in humanml3d.PARTS.values()]
    found = [deviation[low] for low, _ in humanml3d.PARTS.values()]
    np.testing.assert_allclose(found, expected, rtol=1e-4)
    said = json.loads((folder / "humanml3d.json").read_text())
    assert (said["fps"], said["columns"]["ways"]) == (20.0, [193, 259])
    rows = (folder / "captures.csv").read_text().splitlines()
    assert [row.split(",")[1] for row in rows[1:]] == names
    # the way of the capture is that of the numbers, in the size of the legs
    with motiondb.open(tmp_path / "a.duckdb") as db:
        motion = db.motion("walk_1")
    way = np.linalg.norm(motion.root_positions[-1, [0, 2]] - motion.root_positions[0, [0, 2]])
    leg = np.linalg.norm(np.diff(STANDING[[1, 4, 7]], axis=0), axis=1).sum()
    assert np.linalg.norm(joints[-1, 0, [0, 2]] - joints[0, 0, [0, 2]]) == pytest.approx(
        way * leg / LEG_LENGTH, rel=0.03
    )
