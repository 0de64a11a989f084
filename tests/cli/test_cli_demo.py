"""The sample data: one command makes a database that answers, and spoils no other."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from command_answers import answer

import motiondb
from motiondb.database.catalogue import sample

_ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def few(samples_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four captures in place of the sample data, with its sheets."""
    folder = tmp_path / "sample_data"
    names = ("ana/walk_1", "boris/kick_1", "fatou/kick_1", "goran/kick_1")
    for name in names:
        target = folder / "captures" / f"{name}.bvh"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(samples_folder / f"{name}.bvh", target)
    for sheet in ("captions.tsv", "events.tsv"):
        shutil.copy(samples_folder.parent / sheet, folder / sheet)
    monkeypatch.setattr(sample, "sample_folder", lambda: folder)
    return folder


@pytest.mark.usefixtures("few")
def test_one_command_makes_a_database_to_try(command: Any) -> None:
    made = command("demo")
    assert made.code == 0, made.err
    assert made.out.startswith("4 captures and ")
    assert made.out.endswith("Now: motiondb search kick, or motiondb serve\n")
    found = answer(command("search", "kick", "--json"))
    assert found["matches"][0]["capture"].endswith("kick_1")
    with motiondb.open("motions.duckdb", read_only=True) as db:
        assert {info.tags["licence"] for info in db.captures()} == {"CC0-1.0"}
        assert db.captures.events("boris/kick_1")
    again = answer(command("demo", "--json"))  # it goes on where it was interrupted
    assert again["captures"] == 4


@pytest.mark.usefixtures("few")
def test_it_is_not_mixed_with_captures_of_others(command: Any, some: Path) -> None:
    command("add", some / "ana", "--db", "own.duckdb")
    refused = command("demo", "--db", "own.duckdb")
    assert refused.code == 1
    assert "expected a database without captures for the sample data, found" in refused.err
    with motiondb.open("own.duckdb", read_only=True) as db:
        assert not [info for info in db.captures() if "/" in info.name]


def test_the_sample_data_is_shipped() -> None:
    """A wheel has all files that it needs: those that its list of data names."""
    folder = sample.sample_folder()
    captures = sorted((folder / "captures").rglob("*.bvh"))
    assert len(captures) == 101
    settings = tomllib.loads((_ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    assert settings["setuptools"]["package-dir"]["motiondb.sample_data"] == "sample_data"
    patterns = settings["setuptools"]["package-data"]["motiondb.sample_data"]
    shipped = {path for pattern in patterns for path in folder.glob(pattern)}
    assert {*captures, folder / "captions.tsv", folder / "events.tsv"} <= shipped
