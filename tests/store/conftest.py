"""An empty store, and the module of small records."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
import store_samples

from motiondb import store
from motiondb.store.catalogue import places


@pytest.fixture(scope="session")
def samples() -> ModuleType:
    return store_samples


@pytest.fixture(scope="session")
def empty_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("empty") / "motions.duckdb"
    store.open_store(path).close()
    return path


@pytest.fixture(params=["folder", "url"])
def moved_to(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> str:
    """A place for Parquet files: a folder, then a URL."""
    monkeypatch.setattr(places, "_NOT_KEPT", ())  # memory:// is, as long as a test runs
    is_url = request.param == "url"
    return f"memory://{tmp_path.name}/out" if is_url else str(tmp_path / "out")


@pytest.fixture
def database(tmp_path: Path, empty_file: Path) -> Iterator[store.Store]:
    path = shutil.copy(empty_file, tmp_path / "motions.duckdb")
    with store.open_store(path) as opened:
        yield opened
