"""A process killed while it writes leaves a whole store: all of a step, or nothing of it."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from types import ModuleType

import pytest

import motiondb
from motiondb import store
from motiondb.errors import StoreError
from motiondb.store.connection.transactions import revision

_WRITER = Path(__file__).parents[1] / "killed_writer.py"


def _kill(path: Path, what: str, line: str, delay: float) -> int:
    """Start the writer, kill it ``delay`` seconds after it printed ``line``.

    Gives the last turn that it reported as done, -1 for none.
    """
    with subprocess.Popen(
        [sys.executable, str(_WRITER), str(path), what], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        told: list[str] = []
        while line not in told:
            told.append(process.stdout.readline().strip())
            assert told[-1], "the writer ended by itself"
        time.sleep(delay)
        process.kill()
        told += process.stdout.read().split()
    turns = [int(text) for text in told if text.isdigit()]
    return turns[-1] if turns else -1


@pytest.mark.parametrize("delay", [0.0, 0.02])
def test_killed_while_making_the_file(tmp_path: Path, delay: float) -> None:
    path = tmp_path / "m.duckdb"
    _kill(path, "add", "opening", delay)
    with store.open_store(path) as database:
        assert store.check_store(database, sources=True) == []


@pytest.mark.parametrize(("line", "delay"), [("writing", 0.01), ("5", 0.011)])
def test_killed_while_adding_one_by_one(tmp_path: Path, line: str, delay: float) -> None:
    path = tmp_path / "m.duckdb"
    done = _kill(path, "add", line, delay)
    with store.open_store(path) as database:
        assert store.check_store(database, sources=True) == []
        n = len(store.load_captures(database))
    assert n - 1 in (done, done + 1)


def test_killed_while_adding_a_batch(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    done = _kill(path, "batch", "1", 0.03)
    with store.open_store(path, read_only=True) as database:  # replays the log without writing
        assert store.check_store(database, sources=True) == []
        n = len(store.load_captures(database))
    assert n in (4 * (done + 1), 4 * (done + 2))


def test_killed_while_removing(tmp_path: Path) -> None:
    path = tmp_path / "m.duckdb"
    done = _kill(path, "remove", "3", 0.005)
    with store.open_store(path) as database:
        assert store.check_store(database, sources=True) == []
        assert len(store.load_captures(database)) in (0, 1)
        assert [info.capture_id for info in store.load_captures(database)] in ([], [done + 2])


@pytest.mark.parametrize("delay", [0.0, 0.05])
def test_killed_while_learning_keeps_a_whole_learning(
    tmp_path: Path, samples: ModuleType, delay: float
) -> None:
    path = tmp_path / "m.duckdb"
    with store.open_store(path) as database:
        infos = [samples.add(database, name) for name in ("a", "bb")]
    done = _kill(path, "learn", "1", delay)
    with store.open_store(path) as database:
        assert store.check_store(database) == []
        learning = store.load_learning(database)
        seeds = {run.run_id: run.seed for run in store.load_runs(database)}
    seed = seeds[learning.run_id]
    assert seed in (done, done + 1)
    samples.assert_equal(
        learning, samples.learning(infos, learning.run_id, n_symbols=40, seed=seed)
    )


def test_killed_while_replacing_a_grammar_keeps_a_whole_one(
    tmp_path: Path, samples: ModuleType
) -> None:
    path = tmp_path / "m.duckdb"
    with store.open_store(path) as database:
        for name in ("a", "bb"):
            samples.add(database, name)
    done = _kill(path, "grammar", "1", 0.02)
    with store.open_store(path) as database:
        assert store.check_store(database) == []
        assert store.load_grammar(database, "dance").objective in (done, done + 1)


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


def test_rows_that_a_killed_process_moved_out_of_memory_are_deleted(tmp_path: Path) -> None:
    path, folder = tmp_path / "motions.duckdb", tmp_path / "motions.duckdb.tmp"
    store.open_store(path).close()
    folder.mkdir()
    killed, other = folder / "duckdb_temp_99999999_0_owner", folder / "duckdb_temp_1_0_owner"
    for left in (killed, other):
        left.write_bytes(b"rows")
    store.open_store(path, read_only=True).close()
    assert killed.exists()
    store.open_store(path).close()
    assert list(folder.iterdir()) == [other]
    other.unlink()
    store.open_store(path).close()
    assert not folder.exists()
