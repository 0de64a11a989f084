"""A browser, and servers of copies of the learned sample data.

The tests are skipped with a word where there is no browser, or where the page is not built.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from page_tools import WAIT

import motiondb

_HERE = Path(__file__).resolve().parent
_ROOT = _HERE.parents[1]
_BUNDLE = _ROOT / "motiondb" / "page" / "bundle"
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
_SWITCHES = [
    "--no-sandbox",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """An installed Chromium, headless."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not (_BUNDLE / "app.js").is_file():
        pytest.skip("the page is not built: python build_backend.py")
    with sync_api.sync_playwright() as playwright:
        try:  # that of `playwright install chromium`
            opened = playwright.chromium.launch(args=_SWITCHES)
        except sync_api.Error:
            program = next((path for name in _BROWSERS if (path := shutil.which(name))), None)
            if program is None:
                pytest.skip("no Chromium is installed: python -m playwright install chromium")
            opened = playwright.chromium.launch(executable_path=program, args=_SWITCHES)
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def learned_database(request: pytest.FixtureRequest) -> Path:
    """The learned sample data; ``MOTIONDB_TEST_DATABASE`` names one that was learned before."""
    known = os.environ.get("MOTIONDB_TEST_DATABASE")
    return Path(known) if known else request.getfixturevalue("learned_file")


def _start(database: Path, *options: str) -> tuple[subprocess.Popen[str], str]:
    process = subprocess.Popen(
        [sys.executable, str(_HERE / "page_serving.py"), str(database), *options],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    address = process.stdout.readline().strip()
    if not address.startswith("http"):
        _stop(process)
        pytest.fail("the server did not start")
    return process, address


def _stop(process: subprocess.Popen[str]) -> None:
    process.terminate()
    try:
        process.wait(60)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()


@pytest.fixture(scope="session")
def asked_server(
    browser: Any, learned_database: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[str]:
    """The address of a server that is only asked; tests that write take ``serve_copy``."""
    database = tmp_path_factory.mktemp("asked") / "samples.duckdb"
    shutil.copy(learned_database, database)
    process, address = _start(database)
    yield address
    _stop(process)


@pytest.fixture(scope="session")
def grammar_database(learned_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample data with the grammar ``play`` of README."""
    path = Path(shutil.copy(learned_database, tmp_path_factory.mktemp("grammar") / "play.duckdb"))
    captures = ["chidi/long_play_1", "fatou/long_play_2"]
    with motiondb.open(path) as db:
        db.grammars.learn(captures, "play", motiondb.GrammarSettings(n_terminals=8, longest=8))
    return path


@pytest.fixture(scope="session")
def grammar_server(
    browser: Any, grammar_database: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[str]:
    """The address of a server with a grammar; tests that write take ``serve_copy``."""
    database = tmp_path_factory.mktemp("grammar_asked") / "play.duckdb"
    shutil.copy(grammar_database, database)
    process, address = _start(database)
    yield address
    _stop(process)


Serve = Callable[..., str]


@pytest.fixture
def serve_copy(browser: Any, learned_database: Path, tmp_path: Path) -> Iterator[Serve]:
    """Serve a database of the test's own; without a file, a copy of the learned sample data."""
    running: list[subprocess.Popen[str]] = []

    def serve(*options: str, database: Path | None = None) -> str:
        if database is None:
            database = tmp_path / "copy.duckdb"
            shutil.copy(learned_database, database)
        process, address = _start(database, *options)
        running.append(process)
        return address

    yield serve
    for process in running:
        _stop(process)


@pytest.fixture
def new_page(browser: Any) -> Iterator[Callable[..., Any]]:
    """Open an address; the test fails on any error that the page throws."""
    contexts: list[Any] = []
    errors: list[str] = []

    def page(address: str, **options: Any) -> Any:
        size = options.pop("size", (1400, 900))
        settings = {"reduced_motion": "reduce", "accept_downloads": True, **options}
        context = browser.new_context(viewport={"width": size[0], "height": size[1]}, **settings)
        contexts.append(context)
        opened = context.new_page()
        opened.set_default_timeout(WAIT)
        opened.on("pageerror", lambda error: errors.append(str(error)))
        opened.goto(address)
        return opened

    yield page
    for context in contexts:
        context.close()
    assert errors == []
