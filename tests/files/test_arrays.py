"""Motion as arrays and tables."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import motiondb

pq = pytest.importorskip("pyarrow.parquet")


def test_a_capture_as_npz_csv_and_parquet(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some / "ana" / "bow_1.bvh")
        clip = db.clip("bow_1")
        for ending in ("npz", "csv", "parquet"):
            db.export("bow_1", tmp_path / f"a.{ending}", 0.5, 1.5)
    cut = clip.world_positions()[15:45]
    told = np.load(tmp_path / "a.npz")
    np.testing.assert_allclose(told["positions"], cut, atol=1e-12)
    speed = (cut[2] - cut[0]) / (2 / clip.fps)  # central difference
    np.testing.assert_allclose(told["velocities"][1], speed, atol=1e-9)
    assert told["joints"].tolist() == list(clip.joint_names)
    assert told["contacts"].shape == (30, 2)
    assert told["contact_names"].tolist() == ["left_foot", "right_foot"]
    assert (str(told["up"]), str(told["quaternion_order"])[:10]) == ("y", "w, x, y, z")
    assert told["contacts"].any()
    again = motiondb.forward_kinematics(
        told["parents"], told["offsets"], told["local_rotations"], told["root_positions"]
    )[0]
    np.testing.assert_allclose(again, told["positions"], atol=1e-12)
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    root = clip.joint_names[0]
    assert float(rows[3][f"{root}.y"]) == told["positions"][3, 0, 1]
    assert float(rows[3][f"{root}.vy"]) == told["velocities"][3, 0, 1]
    table = pq.read_table(tmp_path / "a.parquet")
    assert table.column_names == list(rows[0])
    assert table["time"].to_pylist() == told["time"].tolist()
