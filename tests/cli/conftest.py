"""Small databases for tests of commands: two fights with a grammar, and two captures learned."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import motiondb
from motiondb.database.grammars.grammar_learning import GrammarSettings
from motiondb.grammar.terminals.terminals import TerminalSettings


@pytest.fixture(scope="session")
def taught(tmp_path_factory: pytest.TempPathFactory, samples_folder: Path) -> Path:
    """A database with two fights and the grammar of one."""
    folder = tmp_path_factory.mktemp("fights")
    for name in ("boris/long_fight_1", "boris/punch_1"):
        target = folder / "captures" / f"{name}.bvh"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(samples_folder / f"{name}.bvh", target)
    path = folder / "motions.duckdb"
    with motiondb.open(path) as db:
        db.add(folder / "captures")
        search = TerminalSettings(n_starts=1, n_trials=150)
        settings = GrammarSettings(6, search=search, evaluations=300)
        db.grammars.learn(["boris/long_fight_1"], "fight", settings)
    return path


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory, samples_folder: Path) -> Path:
    """A database of two captures that has learned."""
    path = tmp_path_factory.mktemp("small") / "small.duckdb"
    with motiondb.open(path) as db:
        for name in ("bow", "walk"):
            db.add(samples_folder / f"ana/{name}_1.bvh")
            db.words.set(f"{name}_1", name)
        db.learn()
    return path


@pytest.fixture
def copy(tmp_path: Path, taught: Path) -> Path:
    return Path(shutil.copy(taught, tmp_path / "motions.duckdb"))
