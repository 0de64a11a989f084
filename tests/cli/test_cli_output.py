"""What commands write never takes the place of a database, and output that is full is told."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from motiondb.cli.main import app

PROGRAM = [sys.executable, "-c", "from motiondb.cli.main import main; main()"]


@pytest.mark.parametrize("name", ["motions.duckdb", "other.bvh"])
def test_no_file_is_written_over_a_database(tmp_path: Path, learned_file: Path, name: str) -> None:
    path = Path(shutil.copy(learned_file, tmp_path / name))
    before = path.read_bytes()
    words = ["knowledge", "export"] if name.endswith("duckdb") else ["export", "ana/walk_1", "-o"]
    ended = CliRunner().invoke(app, [*words, str(path), "--db", str(path)])
    assert ended.exit_code == 1
    assert "found: a database of that name, which is never overwritten" in (
        str(ended.exception).replace("found a database", "found: a database")
    )
    assert path.read_bytes() == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="output that is always full")
def test_output_that_is_full_is_told(learned_file: Path) -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [*PROGRAM, "list", "--db", str(learned_file)],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert ended.returncode == 1
    assert ended.stderr == (
        "error: output: expected to write all of it, found: no space left on device.\n"
    )
