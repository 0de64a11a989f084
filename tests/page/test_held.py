"""What the server loads before it is asked for."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

import motiondb
from motiondb.database.loading import make_frames
from motiondb.learn.learned import Learned
from motiondb.page.state import HeldDatabase
from motiondb.records import Motion


def cached(database: Path) -> set[str]:
    """Kinds of arrays in the cache beside a database."""
    folder = database.with_name(f"{database.name}.cache")
    return {path.name.split("-")[0] for path in folder.glob("*.arrays")}


def test_what_examples_need_is_computed_before_the_first_example(few_copy: Path) -> None:
    shutil.rmtree(f"{few_copy}.cache", ignore_errors=True)
    held = HeldDatabase(few_copy, read_only=False, wait=0.0)
    held.warm_view()
    assert "frames" not in cached(few_copy)
    held.warm()
    assert "frames" in cached(few_copy)
    with held.use() as db:
        assert db.like("ana/bow_1", limit=1)[0].capture == "ana/bow_1"
    held.close()


def test_the_file_is_free_while_frames_are_computed(
    few_copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(f"{few_copy}.cache", ignore_errors=True)
    opened: list[int] = []

    def compute(learned: Learned, motions: Sequence[Motion]) -> list[Any]:
        code = "import motiondb, sys; motiondb.open(sys.argv[1]).close()"
        opened.append(subprocess.run([sys.executable, "-c", code, few_copy]).returncode)
        return make_frames(learned, motions)

    monkeypatch.setattr("motiondb.page.state.make_frames", compute)
    held = HeldDatabase(few_copy, read_only=False, wait=0.0)
    held.warm()
    held.warm()  # they are there now
    assert opened == [0]
    held.close()


def test_a_command_has_its_turn_beside_requests_without_a_break(few_copy: Path) -> None:
    held, ended = HeldDatabase(few_copy, read_only=False, wait=60.0), threading.Event()

    def ask() -> None:
        while not ended.is_set():
            with held.use() as db:
                db.revision()
                time.sleep(0.05)

    requests = [threading.Thread(target=ask) for _ in range(3)]
    for request in requests:
        request.start()
    code = "import motiondb, sys; motiondb.open(sys.argv[1], wait=10).close()"
    codes = [subprocess.run([sys.executable, "-c", code, few_copy]).returncode for _ in "ab"]
    ended.set()
    for request in requests:
        request.join()
    held.close()
    assert codes == [0, 0]
    assert not list(few_copy.parent.glob(".*.waits"))


def test_nothing_is_loaded_where_nothing_was_learned(tmp_path: Path) -> None:
    path = tmp_path / "new.duckdb"
    motiondb.open(path).close()
    held = HeldDatabase(path, read_only=True, wait=0.0)
    held.warm()
    assert cached(path) == set()
    held.close()
