"""The command: address, token, what is refused before anything is opened."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import urllib.request
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.request import url2pathname

import pytest

from motiondb import store
from motiondb.errors import MotionDBError
from motiondb.page import serve as serving
from motiondb.page.settings import PageSettings


def test_the_address_names_host_port_and_token() -> None:
    local = PageSettings(Path("x"))
    assert serving.address_of(local, 8765) == "http://127.0.0.1:8765/"
    six = PageSettings(Path("x"), host="::1")
    assert serving.address_of(six, 1) == "http://[::1]:1/"
    wide = PageSettings(Path("x"), host="0.0.0.0", token="T")
    assert serving.address_of(wide, 1) == f"http://{socket.gethostname()}:1/?token=T"


def test_other_computers_never_come_without_a_token() -> None:
    wide = serving.with_token(PageSettings(Path("x"), host="0.0.0.0"))
    assert len(wide.token) >= 32
    assert wide.token != serving.with_token(PageSettings(Path("x"), host="0.0.0.0")).token
    assert serving.with_token(PageSettings(Path("x"))).token == ""
    assert len(serving.with_token(PageSettings(Path("x"), always_token=True)).token) > 20
    assert serving.with_token(PageSettings(Path("x"), host="0.0.0.0", token="T")).token == "T"


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MotionDBError, match="expected a folder to add captures from"):
        serving.check_settings(PageSettings(Path("x"), folders=(tmp_path / "none",)))


def test_folders_of_killed_servers_are_removed_and_no_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for name in ("motiondb-page-killed", "mine"):
        (tmp_path / name / "uploads").mkdir(parents=True)
    (tmp_path / "motiondb-page-link").symlink_to(tmp_path / "mine")
    with serving.private_folder() as first, serving.private_folder() as second:
        assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
            ["mine", "motiondb-page-link", first.name, second.name]
        )
    assert (tmp_path / "mine" / "uploads").is_dir()


def test_a_port_that_is_taken_is_told(command: Any, learned_file: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        ended = command("serve", "--no-open", "--port", port, "--db", learned_file)
    assert ended.code == 1
    assert "Choose another with --port" in ended.err


def test_a_read_only_page_needs_a_database(command: Any) -> None:
    ended = command("serve", "--no-open", "--port", 0, "--read-only", "--db", "none.duckdb")
    assert ended.code == 1
    assert "expected a database of motiondb, found no such file" in ended.err


def test_a_missing_log_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("uvicorn.Server.run", lambda *_arguments, **_options: None)
    path, copy = tmp_path / "m.duckdb", tmp_path / "copy.duckdb"
    with store.open_store(path) as database:
        store.save_synonyms(database, {"jog": "run"})
        shutil.copy(path, copy)
    said: list[str] = []
    serving.serve(PageSettings(copy, port=0), said.append, said.append, open_browser=False)
    assert [text for text in said if "expected its log copy.duckdb.wal beside it" in text]


def test_the_token_is_no_argument_of_the_browser(
    learned_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened, said = list[tuple[str, str, int]](), list[str]()

    def browse(shown: str) -> None:
        page = Path(url2pathname(shown.removeprefix("file://")))
        opened.append((shown, page.read_text(), page.stat().st_mode & 0o777))

    def now(_seconds: float, browse: Callable[[str], None], shown: list[str]) -> Any:
        return SimpleNamespace(start=lambda: browse(*shown))

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr("uvicorn.Server.run", lambda *_arguments, **_options: None)
    monkeypatch.setattr(serving, "is_built", lambda: True)
    monkeypatch.setattr(serving.webbrowser, "open", browse)
    monkeypatch.setattr(serving.threading, "Timer", now)
    settings = PageSettings(learned_file, port=0, read_only=True, token="secret")
    serving.serve(settings, said.append, said.append)
    ((shown, text, mode),) = opened
    assert "secret" not in shown
    assert f"url={said[0]}" in text
    assert mode == 0o600


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_it_serves_until_it_is_ended_and_leaves_nothing(
    ending: signal.Signals, learned_file: Path, tmp_path: Path
) -> None:
    code = "from motiondb.cli.main import main; main()"
    words = ["serve", "--no-open", "--port", "0", "--read-only", "--db", str(learned_file)]
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    with subprocess.Popen(
        [sys.executable, "-c", code, *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
        preexec_fn=partial(signal.signal, ending, signal.SIG_DFL),  # nohup would ignore it
    ) as server:  # fmt: skip
        assert server.stdout is not None
        try:
            line = server.stdout.readline()
            address = line.removeprefix("The page is at ").split()[0]
            with urllib.request.urlopen(f"{address}api/jobs", timeout=60) as answer:
                assert json.load(answer) == {"jobs": []}
        finally:
            server.send_signal(ending)
            try:
                server.communicate(timeout=60)
            finally:
                server.kill()  # under nohup, a hangup does not end it
    assert server.returncode == 128 + ending
    assert list(tmp_path.iterdir()) == []
