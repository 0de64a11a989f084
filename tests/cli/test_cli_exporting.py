"""The commands that write motion, one smoke test each."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from command_answers import answer

from motiondb.files.formats import read_capture


def test_export_changes_the_motion_and_says_how(
    command, learned_file: Path, tmp_path: Path
) -> None:
    out = tmp_path / "walk.bvh"
    options = ["--loop", "--in-place", "--mirror", "--fps", "60", "--unit", "m"]
    text = command("export", "ana/walk_1", "-o", out, *options, "--db", learned_file).out
    assert f"ana/walk_1 written to {out}: " in text
    for said in ("mirrored", "loop: ", "in place: ", "resampled from 30 to 60", " in m"):
        assert said in text
    clip = read_capture(out)
    assert (clip.fps, clip.unit) == (60.0, 1.0)


def test_tempo_and_keys(command, learned_file: Path, tmp_path: Path) -> None:
    out, options = tmp_path / "walk.glb", ["--speed", "1.25", "--reduce-keys", "0.5"]
    text = command("export", "ana/walk_1", "-o", out, *options, "--db", learned_file).out
    assert "1.25 times as fast: 4.90 s became 3.93 s" in text
    assert re.search(r"keys: [0-9,]+ of [0-9,]+, within 0.5 degrees", text)
    refused = command(
        "export", "ana/walk_1", "-o", tmp_path / "a.bvh", *options, "--db", learned_file
    )
    assert (refused.code, "expected .glb or .gltf to reduce keys" in refused.err) == (2, True)


def test_join(command, learned_file: Path, tmp_path: Path) -> None:
    out, parts = tmp_path / "j.bvh", ["ana/walk_1:0-2", "ana/jump_1:0.5-"]
    facts = answer(command("join", *parts, "-o", out, "--db", learned_file, "--json"))
    assert [part["capture"] for part in facts["parts"]] == ["ana/walk_1", "ana/jump_1"]
    assert len(facts["seams"]) == 1
    assert read_capture(out).duration == pytest.approx(facts["seconds"], abs=1e-3)
    assert Path(facts["provenance"]).exists()


UNUSUAL = {"UpLeg": "LegUpper", "Leg": "LegLower", "Arm": "ArmUpper", "ForeArm": "ArmLower"}


def test_onto_a_rig_of_unknown_names(command, learned_file: Path, tmp_path: Path) -> None:
    rig, out = tmp_path / "rig.bvh", tmp_path / "out.bvh"
    text = (Path(__file__).parent.parent.parent / "sample_data/captures/ana/bow_1.bvh").read_text()
    for number, name in enumerate(re.findall(r"(?:ROOT|JOINT) (\w+)", text)):
        strange = re.sub("UpLeg|Leg|ForeArm|Arm", lambda m: UNUSUAL[m[0]], name)
        text = re.sub(rf"(ROOT|JOINT) {name}\n", rf"\1 b{number}_{strange}_x\n", text)
    rig.write_text(text)
    export = ("export", "ana/walk_1", "-o", out, "--onto", rig, "--db", learned_file)
    refused = command(*export)
    assert refused.code == 1
    assert f"A proposal was written to {tmp_path / 'rig.map'}: check it" in refused.err
    facts = answer(command(*export, "--joint-map", tmp_path / "rig.map", "--json"))
    assert facts["fit"]["foot_error"] < 0.01
    assert read_capture(out).skeleton.names[1] == "b1_Spine_x"
    shown = answer(command("joints", rig, "--json"))
    assert shown["roles"]["l_knee"] == "b14_LeftLegLower_x"
    assert shown["is_known"] is False
