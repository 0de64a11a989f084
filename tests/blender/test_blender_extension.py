"""The Blender extension in real Blender, where it is installed, against a running server."""

from __future__ import annotations

import gzip
import importlib
import json
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.database.catalogue.exporting import MotionChanges
from motiondb.files import fbx_writer

ROOT = Path(__file__).resolve().parents[2]
EXTENSION = ROOT / "integrations" / "blender"


def packed(folder: Path) -> Path:
    """The extension as a zip."""
    target = folder / "motiondb-blender.zip"
    subprocess.run([sys.executable, EXTENSION / "build.py", target], check=True, timeout=60)
    return target


def test_the_zip_is_an_extension_of_this_version(tmp_path: Path) -> None:
    with zipfile.ZipFile(packed(tmp_path)) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert {"__init__.py", "panel.py", "LICENSE"} <= set(names)
    assert manifest["version"] == motiondb.__version__
    assert manifest["blender_version_min"] == "4.2.0"
    assert not manifest["tagline"].endswith(".")
    assert len(manifest["tagline"]) <= 64


def test_the_address_may_hold_the_token(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXTENSION / "motiondb")
    client = importlib.import_module("client")
    given = client.Server.at("http://192.168.0.7:8765/?token=abc")
    assert (given.address, given.token, given.is_local) == ("http://192.168.0.7:8765", "abc", False)
    assert client.Server.at("localhost:8765", " t ") == client.Server("http://localhost:8765", "t")
    assert client.Server.at("[::1]:8765").is_local
    with pytest.raises(client.ServerError, match="expected one such as http"):
        client.Server.at("ftp://here")


@pytest.mark.slow
@pytest.mark.skipif(not fbx_writer.find_blender(), reason="needs Blender (pip install bpy)")
def test_in_blender_answers_are_found_and_imported(learned_file: Path, tmp_path: Path) -> None:
    rig = tmp_path / "rig.fbx"
    rig.write_bytes(gzip.decompress((ROOT / "tests/files/fbx/mixamo.fbx.gz").read_bytes()))
    how = "import sys; sys.argv[0] = 'motiondb'; from motiondb.cli.main import main; main()"
    asked = ["serve", "--db", str(learned_file), "--host", "127.0.0.2", "--port", "0"]
    with subprocess.Popen(
        [sys.executable, "-c", how, *asked, "--read-only", "--no-open"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as server:
        try:
            assert server.stdout is not None
            address = next(
                word for line in server.stdout for word in line.split() if "?token=" in word
            )
            program = [arg for arg in fbx_writer.find_blender() if not arg.endswith("_fbx.py")]
            script = [str(ROOT / "tests/blender/in_blender.py"), "--"]
            ended = subprocess.run(
                [*program, *script, packed(tmp_path), address, rig, tmp_path],
                env={**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path / "blender")},
                capture_output=True,
                timeout=300,
            )
        finally:
            server.terminate()
    assert ended.returncode == 0, ended.stderr.decode()[-2000:]
    found = json.loads((tmp_path / "found.json").read_text())
    check_errors(found)
    assert found["said"] == "understood: kick"
    ref, start, end = found["answers"][0][:3]
    assert found["drawn"] > 200  # pixels of the picture
    assert [ref, start, end] in found["like_answers"]  # the imported action finds where it is from
    assert found["made"][0][1:] == ["shows all actions", "CC0-1.0"]
    assert json.loads(found["provenance"])["words"] == "a person walks then kicks"
    check_places(learned_file, tmp_path, found, (ref.removeprefix("capture:"), start, end))


def check_errors(found: dict) -> None:
    """What went wrong, and what had to."""
    assert found["enabled"]
    assert found["no_server"].startswith(
        "server: expected motiondb at http://127.0.0.1:9, found no answer ("
    )
    assert "Start it in a terminal: motiondb serve --db FILE." in found["no_server"]
    assert found["no_token"].startswith("token: expected the token that motiondb serve printed")
    assert "expected one of the list" in found["no_answer"]
    for step in ("error", "own", "like", "onto", "mapped", "generate", "load_made"):
        assert found[step] == "", step
    assert "A proposal is in the text 'motiondb joints of" in found["unknown"]
    assert "l_hip = b_LeftUpLeg_16" in found["texts"][0]


def check_places(database: Path, folder: Path, found: dict, part: tuple[str, float, float]) -> None:
    """Bones are at the places of the store within 1 mm, at the frame rates asked for."""
    name, start, end = part
    start, end = round(start, 4), round(end, 4)
    rig = folder / "rig.fbx"
    assert found["capture_fps"] == 30.0
    cases = {
        "capture": MotionChanges(),
        "own": MotionChanges(fps=24.0),
        "onto": MotionChanges(onto=rig),
    }
    for case, changes in cases.items():
        with motiondb.open(database, read_only=True) as db:
            db.export(name, folder / f"{case}-stored.npz", start, end, changes=changes)
        stored, imported = np.load(folder / f"{case}-stored.npz"), np.load(folder / f"{case}.npz")
        theirs = imported["names"].tolist()
        at = [theirs.index(joint) for joint in stored["joints"].tolist()]
        assert imported["places"].shape[0] == len(stored["time"]), case
        np.testing.assert_allclose(
            imported["places"][:, at], stored["positions"], atol=1e-3, err_msg=case
        )
    with motiondb.open(database, read_only=True) as db:
        clip = db.clip(name)
    first = round(start * clip.fps)
    with np.load(folder / "capture-stored.npz") as stored:
        whole = clip.world_positions()[first : first + len(stored["time"])]
        np.testing.assert_allclose(stored["positions"], whole, atol=1e-9)
