"""A server over a database, asked in this process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from page_serving import ADDRESS, INDEX, Serve
from starlette.testclient import TestClient

from motiondb.page.app import make_application
from motiondb.page.settings import PageSettings


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    """Files of the page as a build makes them, but without a page."""
    folder = tmp_path / "bundle"
    folder.mkdir()
    (folder / "index.html").write_text(INDEX)
    for name in ("app.js", "file.js"):
        (folder / name).write_text("const page = '<!-- </script>';")
    (folder / "app.css").write_text("body { margin: 0 }")
    return folder


@pytest.fixture
def serve(tmp_path: Path, bundle: Path) -> Iterator[Serve]:
    """Makes servers, as browsers on this computer reach them."""
    with ExitStack() as stack:

        def start(database: Path, **settings: object) -> TestClient:
            folder = tmp_path / f"private-{len(list(tmp_path.iterdir()))}"
            folder.mkdir()
            chosen = replace(PageSettings(database, warm=False), **settings)  # type: ignore[arg-type]
            application = make_application(chosen, folder, bundle)
            return stack.enter_context(TestClient(application, base_url=ADDRESS))

        yield start


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory, learned_file: Path) -> Iterator[TestClient]:
    """A read-only server over the sample data."""
    folder = tmp_path_factory.mktemp("page")
    settings = PageSettings(learned_file, read_only=True, warm=False)
    with TestClient(make_application(settings, folder, folder), base_url=ADDRESS) as asked:
        yield asked
