"""A write-ahead log that was cut short: what is known of the changes that it held, and what is not.

DuckDB replays the log up to its last whole transaction, and says nothing of what follows. So a
database whose log was cut holds an earlier state, a whole one. It is not known that later changes
were lost: `check` calls it sound, and only its revision is lower than it was.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

import motiondb
from motiondb import store
from motiondb.errors import StoreError
from motiondb.store.connection.transactions import revision

CHANGES = 4
_KILLED = f"""
import os, sys
from motiondb import store
opened = store.open_store(sys.argv[1])
for turn in range({CHANGES}):
    store.save_synonyms(opened, {{f"word{{n}}": "walk" for n in range(turn + 1)}})
os._exit(0)
"""


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database whose latest changes are only in its log."""
    path = tmp_path_factory.mktemp("logged") / "motions.duckdb"
    store.open_store(path).close()
    subprocess.run([sys.executable, "-c", _KILLED, str(path)], check=True)
    assert path.with_name("motions.duckdb.wal").stat().st_size > 0
    return path


def test_a_log_that_was_cut_leaves_a_whole_earlier_state(logged: Path, tmp_path: Path) -> None:
    log = logged.with_name(f"{logged.name}.wal").read_bytes()
    cuts = [*range(0, len(log), max(1, len(log) // 6)), len(log)]
    states, revisions = [], []
    for size in cuts:
        folder = tmp_path / str(size)
        folder.mkdir()
        path = Path(shutil.copy(logged, folder))
        path.with_name(f"{path.name}.wal").write_bytes(log[:size])
        with suppress(StoreError), store.open_store(path, read_only=True) as opened:
            states.append(len(store.load_synonyms(opened)))
            revisions.append(revision(opened))
    assert states[0] == 0
    assert states[-1] == CHANGES
    assert states == sorted(states)  # never a part of a later change without an earlier one
    assert [number - revisions[0] for number in revisions] == states


def test_a_cut_log_is_not_told_from_one_that_was_never_longer(logged: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(logged, tmp_path))
    log = logged.with_name(f"{logged.name}.wal").read_bytes()
    path.with_name(f"{path.name}.wal").write_bytes(log[:-1])
    assert motiondb.check_file(path) == []
    with store.open_store(path, read_only=True) as opened:
        assert len(store.load_synonyms(opened)) == CHANGES - 1
