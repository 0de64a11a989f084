"""glTF out: the structure of the file, and the motion that a viewer would compute from it."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
import pytest
from sample_motions import sample_clip

from motiondb.body import body, kinematics, rotation
from motiondb.errors import CaptureError
from motiondb.files.gltf_writer import Character, _keys, write_gltf, write_gltf_scene
from motiondb.records import Clip

COMPONENTS = {5126: np.float32, 5123: np.uint16, 5125: np.uint32}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def a_clip(n_frames: int = 4, seed: int = 3, moved: bool = False) -> Clip:
    rng = np.random.default_rng(seed)
    turns = rotation.exp(rng.normal(size=(n_frames, 21, 3)))
    roots = rng.normal(size=(n_frames, 3)) + seed
    positions = np.tile(body.OFFSETS, (n_frames, 1, 1))
    positions[:, 0], positions[:, 4] = roots, positions[:, 4] + rng.normal(size=(n_frames, 3))
    skeleton = body.standard_skeleton()
    return Clip(skeleton, 30.0, turns, roots, positions if moved else None)


def load(path: Path) -> tuple[dict, bytes]:
    content = path.read_bytes()
    if path.suffix == ".gltf":
        document = json.loads(content)
        return document, base64.b64decode(document["buffers"][0]["uri"].split(",", 1)[1])
    assert content[:4] == b"glTF"
    words = np.frombuffer(content[4:12], "<u4")
    assert words.tolist() == [2, len(content)]
    size, kind = int.from_bytes(content[12:16], "little"), content[16:20]
    assert (kind, size % 4) == (b"JSON", 0)
    rest = content[20 + size :]
    assert rest[4:8] == b"BIN\0"
    assert int.from_bytes(rest[:4], "little") == len(rest) - 8
    return json.loads(content[20 : 20 + size]), rest[8:]


def values(document: dict, data: bytes, number: int) -> np.ndarray:
    accessor = document["accessors"][number]
    view = document["bufferViews"][accessor["bufferView"]]
    kind, width = COMPONENTS[accessor["componentType"]], WIDTHS[accessor["type"]]
    assert view["byteOffset"] % 4 == 0
    assert view["byteOffset"] + view["byteLength"] <= document["buffers"][0]["byteLength"]
    assert view["byteLength"] == accessor["count"] * width * np.dtype(kind).itemsize
    raw = data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    array = np.frombuffer(raw, kind).reshape(accessor["count"], width)
    np.testing.assert_array_equal(array.min(axis=0), np.array(accessor["min"], kind))
    np.testing.assert_array_equal(array.max(axis=0), np.array(accessor["max"], kind))
    return array


def viewer_matrices(document: dict, data: bytes, frame: int) -> np.ndarray:
    """World matrices (nodes, 4, 4) as a viewer computes them at a key frame."""
    nodes = [dict(node) for node in document["nodes"]]
    animation = document["animations"][0]
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        key = values(document, data, sampler["output"])[frame]
        nodes[channel["target"]["node"]][channel["target"]["path"]] = key
    world = np.tile(np.eye(4), (len(nodes), 1, 1))

    def place(number: int, parent: np.ndarray) -> None:
        node = nodes[number]
        x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
        local = np.eye(4)
        local[:3, :3] = rotation.to_matrix(np.array([w, x, y, z]))
        local[:3, 3] = node.get("translation", (0, 0, 0))
        world[number] = parent @ local
        for child in node.get("children", []):
            place(child, world[number])

    for root in document["scenes"][0]["nodes"]:
        place(root, np.eye(4))
    return world


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
@pytest.mark.parametrize("moved", [False, True])
def test_a_viewer_sees_the_motion(tmp_path: Path, ending: str, moved: bool) -> None:
    clip = a_clip(moved=moved)
    write_gltf(clip, tmp_path / f"a{ending}")
    document, data = load(tmp_path / f"a{ending}")
    assert document["asset"]["version"] == "2.0"
    assert len(data) == document["buffers"][0]["byteLength"]
    positions, _ = kinematics.clip_positions(clip)
    for frame in (0, 3):
        world = viewer_matrices(document, data, frame)
        np.testing.assert_allclose(world[:21, :3, 3], positions[frame], atol=1e-5)
    animation = document["animations"][0]
    times = values(document, data, animation["samplers"][0]["input"])
    np.testing.assert_allclose(times[:, 0], np.arange(4) / 30, atol=1e-6)
    for channel in animation["channels"]:
        if channel["target"]["path"] == "rotation":  # no quaternion turns the long way round
            keys = values(document, data, animation["samplers"][channel["sampler"]]["output"])
            assert np.sum(keys[1:] * keys[:-1], axis=1).min() >= 0.0


def test_left_out_keys_lie_between_those_that_are_kept() -> None:
    turns = rotation.from_euler(np.linspace(0.0, 80.0, 41)[:, None], "Z")
    assert _keys(turns, 0.1) == [0, 40]
    turns[20:] = rotation.multiply(rotation.from_euler(np.array([[5.0]]), "X"), turns[20:])
    assert _keys(turns, 0.1) == [0, 19, 20, 40]
    line = np.linspace(0.0, 1.0, 11)[:, None] * np.ones(3)
    line[5, 1] += 0.02
    assert _keys(line, 3.0) == [0, 10]
    assert _keys(line, 1.0) == [0, 4, 5, 6, 10]
    assert _keys(line[:1], 1.0) == [0]


def test_a_file_has_fewer_keys_and_says_so(tmp_path: Path) -> None:
    still = sample_clip("ana/bow_1")
    (said,) = write_gltf(still, tmp_path / "a.glb", reduce_keys=1.0)
    document, data = load(tmp_path / "a.glb")
    samplers = document["animations"][0]["samplers"]
    counts = [len(values(document, data, sampler["input"])) for sampler in samplers]
    assert counts == [len(values(document, data, sampler["output"])) for sampler in samplers]
    assert said.startswith(f"keys: {sum(counts):,} of {22 * still.n_frames:,}, ")
    assert sum(counts) < 11 * still.n_frames


def test_the_body_hangs_on_its_joints(tmp_path: Path) -> None:
    clip = a_clip()
    write_gltf(clip, tmp_path / "a.glb")
    document, data = load(tmp_path / "a.glb")
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    corners = values(document, data, attributes["POSITION"]).astype(float)
    joints = values(document, data, attributes["JOINTS_0"])
    weights = values(document, data, attributes["WEIGHTS_0"])
    np.testing.assert_array_equal(weights, [[1, 0, 0, 0]] * len(corners))
    binds = values(document, data, document["skins"][0]["inverseBindMatrices"])
    binds = binds.reshape(-1, 4, 4).transpose(0, 2, 1)
    world = viewer_matrices(document, data, 2)
    posed = np.einsum(
        "nij,nj->ni",
        (world[:21] @ binds)[joints[:, 0]],
        np.concatenate([corners, np.ones((len(corners), 1))], axis=1),
    )
    # Every bone's octahedron starts at its joint and ends at the child: 8 faces of 3 corners.
    positions, _ = kinematics.clip_positions(clip)
    for child in range(1, 21):
        parent = body.PARENTS[child]
        start, end = positions[2, parent], positions[2, child]
        octahedron = posed.reshape(-1, 24, 4)[child - 1, :, :3]
        assert np.linalg.norm(octahedron - start, axis=1).min() < 1e-5
        assert np.linalg.norm(octahedron - end, axis=1).min() < 1e-5
    sides = corners.reshape(-1, 3, 3)
    normals = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    middles = corners.reshape(-1, 24, 3).mean(axis=1).repeat(8, axis=0)
    assert np.sum(normals * (sides.mean(axis=1) - middles), axis=1).min() > 0, "faces look outward"


def test_refusals(tmp_path: Path) -> None:
    clip = a_clip()
    bad = Clip(clip.skeleton, 30.0, clip.local_rotations, clip.root_positions * np.inf)
    for refused, name, said in (
        (clip, "a.fbx", "expected the ending .glb or .gltf, found '.fbx'"),
        (a_clip(0), "a.glb", "expected at least 1 frame to write, found 0"),
        (bad, "a.glb", "expected finite numbers to write"),
    ):
        with pytest.raises(CaptureError, match=said):
            write_gltf(refused, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


BALL = np.array([[0.0, 1.0, 2.0], [0.1, 1.5, 2.1], [0.2, 1.2, 2.2], [0.3, 0.12, 2.3]])


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_a_viewer_sees_all_where_they_are(tmp_path: Path, ending: str) -> None:
    clips = [a_clip(seed=1), a_clip(seed=2), a_clip(seed=5)]
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
    write_gltf_scene(
        [Character("A", a_clip(seed=1)), Character("B", a_clip(seed=2))], tmp_path / "s.glb"
    )
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
    write_gltf_scene([Character("A", a_clip(seed=1))], tmp_path / "s.glb", BALL)
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
        ([Character("A", a_clip()), Character("A", a_clip())], "s.glb", None, "two A"),
        ([Character("A", a_clip())], "s.fbx", None, "expected the ending .glb or .gltf"),
        (
            [Character("A", a_clip())],
            "s.glb",
            BALL * np.nan,
            "expected finite positions of the ball",
        ),
        ([Character("A", a_clip(0))], "s.glb", None, "expected at least 1 frame"),
    ],
)
def test_refusals_of_scenes(
    tmp_path: Path, people: list, name: str, ball: object, said: str
) -> None:
    with pytest.raises(CaptureError, match=said):
        write_gltf_scene(people, tmp_path / name, ball)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_whose_it_is_stands_in_the_file(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"walk{ending}"
    write_gltf(a_clip(), path)
    document, data = load(path)
    write_gltf(a_clip(), path, "ana/walk_1, licence CC0-1.0")
    marked, same = load(path)
    assert same == data
    assert marked["asset"].pop("copyright") == "ana/walk_1, licence CC0-1.0"
    assert marked == document
