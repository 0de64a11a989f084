"""Robots in a database: added with their model, exported as added and on hinges."""

from pathlib import Path

import numpy as np
import pytest

from motiondb import AddSettings, MotionChanges, MotionDB
from motiondb.errors import CaptureError
from tests import small_robot


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    takes = tmp_path / "takes"
    takes.mkdir()
    (tmp_path / "small.urdf").write_text(small_robot.urdf())
    root, turns, values = small_robot.walk(60)
    table = np.concatenate([root, turns[:, [1, 2, 3, 0]], values], axis=1)
    np.savetxt(takes / "walk.csv", table, delimiter=",")
    np.savez(takes / "walk_npz.npz", fps=30, root_pos=root, root_rot=table[:, 3:7], dof_pos=values)
    return takes


def test_a_robot_is_added_with_its_model_and_comes_back_bit_for_bit(
    folder: Path, tmp_path: Path
) -> None:
    with MotionDB(tmp_path / "m.duckdb", create=True) as db:
        failed = db.add(folder)
        assert len(failed.problems) == 2
        assert "expected the model of the robot" in failed.problems[0]
        report = db.add(folder, settings=AddSettings(skeleton=tmp_path / "small.urdf"))
        assert not report.problems
        assert {info.name: info.format for info in db.captures()} == {
            "walk": "robot",
            "walk_npz": "robot",
        }
        assert db.clip("walk").n_frames == 60
        exported = db.export("walk", tmp_path / "out.csv")
        assert exported.skeleton == tmp_path / "out.urdf"
        assert (tmp_path / "out.csv").read_bytes() == (folder / "walk.csv").read_bytes()
        assert (tmp_path / "out.urdf").read_text() == small_robot.urdf()


def test_a_capture_is_exported_on_the_hinges_of_a_robot(folder: Path, tmp_path: Path) -> None:
    model = tmp_path / "small.xml"
    model.write_text(small_robot.mjcf())
    with MotionDB(tmp_path / "m.duckdb", create=True) as db:
        db.add(folder, settings=AddSettings(skeleton=tmp_path / "small.urdf"))
        asked = MotionChanges(onto=model, mirror=True, fps=50.0)
        made = db.export("walk", tmp_path / "on.csv", changes=asked)
        assert made.fit is not None
        assert made.fps == 50.0
        assert np.loadtxt(tmp_path / "on.csv", delimiter=",").shape == (100, 28)
        assert any("quaternions x, y, z, w" in said for said in made.changes)
        for name in ("lafan1", "soma", "mixamo", "smpl"):
            made = db.export(
                "walk", tmp_path / f"{name}.bvh", changes=MotionChanges(onto=Path(name))
            )
            assert made.fit is not None
            assert made.fit.foot_error < 0.06
        with pytest.raises(CaptureError, match=r"or lafan1, soma, mixamo, smpl\), found ending ''"):
            db.export("walk", tmp_path / "x.bvh", changes=MotionChanges(onto=Path("lafan2")))
