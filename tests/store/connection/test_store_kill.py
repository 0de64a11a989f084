"""A process killed while it writes leaves a whole store: all of a step, or nothing of it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

from motiondb import store

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
