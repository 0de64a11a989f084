"""Commands that meet: they wait for one another, say for whom, and read while one learns."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from holding import holding

import motiondb
from motiondb import store


def started(*words: object, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [str(Path(sys.executable).with_name("motiondb")), *(str(word) for word in words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
    )


@pytest.fixture
def copy(tmp_path: Path, small: Path) -> Path:
    return Path(shutil.copy(small, tmp_path / "motions.duckdb"))


def test_a_search_beside_a_learn_is_answered(copy: Path) -> None:
    learn = started("learn", "--symbols", 2, "--db", copy, "--wait", 100)
    search = started("search", "bow", "--db", copy, "--json", "--wait", 100)
    out, told = search.communicate(timeout=300)
    _, err = learn.communicate(timeout=300)
    assert learn.returncode == 0, err
    assert search.returncode == 0, told
    assert '"bow_1"' in out
    with motiondb.open(copy) as db:
        assert db.check() == []
        assert db.search("bow").matches[0].capture == "bow_1"


@pytest.mark.parametrize("told", ["option", "environment"])
def test_who_holds_the_file_is_said_when_waiting_was_in_vain(copy: Path, told: str) -> None:
    words = ["--wait", "0.2"] if told == "option" else []
    waiting = {} if told == "option" else {"MOTIONDB_WAIT": "0.2"}
    with holding(copy, "read") as pid:
        command = started("remove", "bow_1", "--db", copy, *words, **waiting)
        _, err = command.communicate(timeout=120)
    assert command.returncode == 1
    assert f"found it held by process {pid} (python" in err
    assert " after 0.2 s. Wait until it has ended, or wait longer with --wait SECONDS." in err


def test_captures_that_change_while_it_learns_are_learned_too(copy: Path) -> None:
    """A learn that was overtaken begins again, and counts what came."""
    changed = threading.Event()

    def change(what: str, _share: float) -> None:
        if what == "symbol space" and not changed.is_set():
            changed.set()
            command = started("words", "set", "bow_1", "curtsy", "--db", copy, "--wait", 60)
            assert command.communicate(timeout=120)[1] == ""
            assert command.returncode == 0

    with motiondb.open(copy) as db:
        db.learn(progress=change)
        assert changed.is_set()
        assert db.symbols.drift() is None or not db.symbols.drift().words
        assert db.search("curtsy").matches[0].capture == "bow_1"


def test_captures_that_keep_changing_are_told(copy: Path) -> None:
    turn = iter(range(100))

    def change(what: str, _share: float) -> None:
        if what == "symbol space":
            with motiondb.open(copy) as other:
                other.set_words("bow_1", f"bow number{next(turn)}")

    with motiondb.open(copy) as db:
        runs = store.load_runs(db.store)
        with pytest.raises(motiondb.MotionDBError, match="found them changed by others in 3"):
            db.learn(progress=change)
        assert len(store.load_runs(db.store)) == len(runs) + 3
        assert db.search("bow").matches[0].capture == "bow_1"
