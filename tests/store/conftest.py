"""An empty store, and the module of small records."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
import store_samples

from motiondb import store


@pytest.fixture(scope="session")
def samples() -> ModuleType:
    return store_samples


@pytest.fixture(scope="session")
def empty_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("empty") / "motions.duckdb"
    store.open_store(path).close()
    return path


@pytest.fixture
def database(tmp_path: Path, empty_file: Path) -> Iterator[store.Store]:
    path = shutil.copy(empty_file, tmp_path / "motions.duckdb")
    with store.open_store(path) as opened:
        yield opened
