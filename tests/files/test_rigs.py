"""Rigs in BVH, FBX and glTF."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np
import pytest

from motiondb.body import kinematics
from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.formats import read_capture
from motiondb.files.gltf_writer import write_gltf
from motiondb.files.rigs import read_rig

SAMPLE = Path(__file__).parent.parent.parent / "sample_data" / "captures" / "ana" / "bow_1.bvh"
FBX = Path(__file__).parent / "fbx" / "still.fbx.gz"


def places(clip) -> np.ndarray:
    return kinematics.clip_positions(clip)[0][0]


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_gltf(ending: str, tmp_path: Path) -> None:
    clip = read_capture(SAMPLE)
    write_gltf(clip, tmp_path / f"a{ending}")
    rig = read_rig(tmp_path / f"a{ending}")
    assert rig.skeleton.names == clip.skeleton.names
    assert (rig.n_frames, rig.unit) == (1, 1.0)
    np.testing.assert_allclose(places(rig), places(clip), atol=1e-9)  # posed as in the first frame


def lengths(clip) -> dict[str, float]:
    at, parents = places(clip), clip.skeleton.parents
    steps = np.linalg.norm(at - at[parents], axis=-1)
    return dict(zip(clip.skeleton.names, np.where(parents >= 0, steps, 0.0).tolist()))


def test_bvh_and_fbx_have_the_same_bones(tmp_path: Path) -> None:
    (tmp_path / "a.fbx").write_bytes(gzip.decompress(FBX.read_bytes()))
    write_bvh(read_capture(SAMPLE), tmp_path / "a.bvh")
    fbx, bvh = read_rig(tmp_path / "a.fbx"), read_rig(tmp_path / "a.bvh")
    assert lengths(fbx) == pytest.approx(lengths(bvh), abs=1e-4)
    assert np.abs(bvh.local_rotations - [1.0, 0.0, 0.0, 0.0]).max() == 0.0


def test_refusals(tmp_path: Path) -> None:
    cut = tmp_path / "a.glb"
    cut.write_bytes(
        b"glTF" + bytes([2, 0, 0, 0]) + bytes(4) + (99).to_bytes(4, "little") + b"JSON{}"
    )
    meshes = tmp_path / "b.gltf"
    meshes.write_text(json.dumps({"nodes": [{"mesh": 0}]}))
    circle = tmp_path / "c.gltf"
    nodes = [{"children": [1]}, {"children": [0]}]
    circle.write_text(json.dumps({"nodes": nodes, "skins": [{"joints": [0, 1]}]}))
    expected = {
        cut: "expected a whole glTF file, found one that is cut short.",
        meshes: "expected a skin with joints, found none. Export the skeleton with the file.",
        circle: "expected a tree of nodes, found a circle.",
        tmp_path / "d.obj": "expected a rig (.bvh, .fbx, .glb, .gltf, .xml, .mjcf, .urdf, or "
        "lafan1, soma, mixamo, smpl), found ending '.obj'.",
    }
    for path, said in expected.items():
        with pytest.raises(CaptureError) as caught:
            read_rig(path)
        assert str(caught.value) == f"{path}: {said}"
