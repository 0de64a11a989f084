"""What programs use beside the commands: motions as arrays, files with their provenance."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.body import body
from motiondb.records import Motion


def standing() -> Motion:
    """Two frames of the standard body with all rotations zero, the pelvis at 1, 2, 3 metres."""
    turned = np.zeros((2, len(body.JOINTS), 4), dtype=np.float32)
    turned[..., 0] = 1.0
    return Motion(turned, np.array([[1.0, 2.0, 3.0]] * 2, dtype=np.float32))


def test_joints_of_an_unturned_body_lie_at_the_sums_of_their_offsets() -> None:
    motion = standing()
    names, positions = motion.joint_names, motion.joint_positions()
    assert (len(names), positions.shape) == (21, (2, 21, 3))
    expected = np.zeros((21, 3))
    for joint, parent in enumerate(body.PARENTS):
        expected[joint] = [1, 2, 3] if parent < 0 else expected[parent] + body.OFFSETS[joint]
    np.testing.assert_allclose(positions, np.stack([expected, expected]), atol=1e-6)
    assert names[int(np.argmin(positions[0, :, 1]))] in ("l_toe", "r_toe")
    assert motion.duration == pytest.approx(2 / 30)


def test_a_generated_motion_writes_itself_with_its_provenance(
    learned_file: Path, tmp_path: Path
) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        made = db.generate("a person kicks", seed=3)
    facts = made.write(tmp_path / "kick.bvh")
    told = json.loads((tmp_path / "kick.provenance.json").read_text())
    assert (told["words"], told["seed"], told["method"]) == ("a person kicks", 3, "stitched")
    assert told["frames"][-1]["end"] == made.motion.n_frames
    assert facts["provenance"] == str(tmp_path / "kick.provenance.json")
    motiondb.write_bvh(made.motion, tmp_path / "plain.bvh")
    assert (tmp_path / "plain.bvh").read_bytes() == (tmp_path / "kick.bvh").read_bytes()
    with pytest.raises(motiondb.MotionDBError, match=r"expected an ending .bvh, .glb or .gltf"):
        made.write(tmp_path / "kick.txt")
    assert not (tmp_path / "kick.txt").exists()
    with pytest.raises(motiondb.MotionDBError, match=r"or a motiondb\.Motion, found Generated"):
        motiondb.write_bvh(made, tmp_path / "made.bvh")  # what is tested
    with pytest.raises(motiondb.MotionDBError, match="found NoneType"):
        motiondb.write_gltf(None, tmp_path / "none.glb")  # what is tested
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "kick.bvh",
        "kick.provenance.json",
        "plain.bvh",
    ]


def test_what_is_known_of_a_database_needs_no_command(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        facts = db.info()
        assert (facts.captures, facts.learned, facts.not_yet_learned) == (101, True, 0)
        assert [run["kind"] for run in db.runs()] == ["add", "learn"]
        assert db.word_rows()[0].count == max(row.count for row in db.word_rows())
        assert len(db.symbol_rows()) == facts.symbols
        assert db.show("ana/walk_1")["frames"] > 0
        assert len(db.vocabulary()) == facts.words
