"""Scenes as glTF: what a viewer computes for every character and the ball."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_gltf_writer import load, values, viewer_matrices

from motiondb.body import body, kinematics, rotation
from motiondb.errors import CaptureError
from motiondb.files import Character, write_gltf_scene
from motiondb.records import Clip


def a_clip(seed: int, n_frames: int = 4) -> Clip:
    rng = np.random.default_rng(seed)
    turns = rotation.exp(rng.normal(size=(n_frames, 21, 3)))
    return Clip(body.standard_skeleton(), 30.0, turns, rng.normal(size=(n_frames, 3)) + seed)


BALL = np.array([[0.0, 1.0, 2.0], [0.1, 1.5, 2.1], [0.2, 1.2, 2.2], [0.3, 0.12, 2.3]])


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_a_viewer_sees_all_where_they_are(tmp_path: Path, ending: str) -> None:
    clips = [a_clip(1), a_clip(2), a_clip(5)]
    people = [Character(f"P{n}", clip, (0.1 * n, 0.2, 0.3)) for n, clip in enumerate(clips)]
    write_gltf_scene(people, tmp_path / f"s{ending}", BALL)
    document, data = load(tmp_path / f"s{ending}")
    names = [node["name"] for node in document["nodes"]]
    assert len(set(names)) == len(names) == 3 * 23 + 1
    for frame in (0, 3):
        world = viewer_matrices(document, data, frame)
        for number, clip in enumerate(clips):
            root = names.index(f"P{number}_{body.JOINTS[0]}")
            places, _ = kinematics.clip_positions(clip)
            np.testing.assert_allclose(world[root : root + 21, :3, 3], places[frame], atol=1e-5)
        np.testing.assert_allclose(world[names.index("ball"), :3, 3], BALL[frame], atol=1e-6)


def test_each_body_hangs_on_its_own_joints(tmp_path: Path) -> None:
    write_gltf_scene([Character("A", a_clip(1)), Character("B", a_clip(2))], tmp_path / "s.glb")
    document, data = load(tmp_path / "s.glb")
    for number in range(len(document["accessors"])):
        values(document, data, number)
    children = [child for node in document["nodes"] for child in node.get("children", [])]
    assert sorted([*children, *document["scenes"][0]["nodes"]]) == list(range(46))
    for name in "AB":
        node = next(n for n in document["nodes"] if n["name"] == f"{name}_body")
        joints = document["skins"][node["skin"]]["joints"]
        assert [document["nodes"][j]["name"] for j in joints] == [
            f"{name}_{j}" for j in body.JOINTS
        ]
        mesh = document["meshes"][node["mesh"]]
        assert document["materials"][mesh["primitives"][0]["material"]]["name"] == name
    targets = [
        (c["target"]["node"], c["target"]["path"]) for c in document["animations"][0]["channels"]
    ]
    assert len(set(targets)) == len(targets) == 44
    samplers = [c["sampler"] for c in document["animations"][0]["channels"]]
    assert samplers == list(range(44))


def test_the_ball_is_round_and_seen_from_outside(tmp_path: Path) -> None:
    write_gltf_scene([Character("A", a_clip(1))], tmp_path / "s.glb", BALL)
    document, data = load(tmp_path / "s.glb")
    part = document["meshes"][-1]["primitives"][0]
    points = values(document, data, part["attributes"]["POSITION"]).astype(float)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.12, atol=1e-6)
    sides = points[values(document, data, part["indices"])[:, 0].reshape(-1, 3)]
    normals = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    assert (np.sum(normals * sides.mean(axis=1), axis=1) > 0).all()
    volume = np.sum(sides[:, 0] * normals) / 6.0
    assert 0.9 < volume / (4.0 / 3.0 * np.pi * 0.12**3) < 1.0


@pytest.mark.parametrize(
    ("people", "name", "ball", "said"),
    [
        ([], "s.glb", None, "expected at least 1 character"),
        ([Character("A", a_clip(1)), Character("A", a_clip(2))], "s.glb", None, "two A"),
        ([Character("A", a_clip(1))], "s.fbx", None, "expected the ending .glb or .gltf"),
        ([Character("A", a_clip(1))], "s.glb", BALL * np.nan, "expected finite places of the ball"),
        ([Character("A", a_clip(1, 0))], "s.glb", None, "expected at least 1 frame"),
    ],
)
def test_refusals(tmp_path: Path, people: list, name: str, ball: object, said: str) -> None:
    with pytest.raises(CaptureError, match=said):
        write_gltf_scene(people, tmp_path / name, ball)
    assert list(tmp_path.iterdir()) == []
