"""``add`` and ``learn`` killed or interrupted: the store is as it was, or all is done.

Moments are shares of the time that the same command takes when nobody interrupts it.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import motiondb

# A shell starts background jobs with interrupts ignored; what the tests start must heed them.
HEEDED = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
PROGRAM = [sys.executable, "-c", f"{HEEDED}; from motiondb.cli.main import main; main()"]
Contents = Callable[[Path], dict[str, list[Any]]]


def started(words: list[Any]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*PROGRAM, *map(str, words)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
    )  # fmt: skip


@pytest.fixture(scope="module")
def before(tmp_path_factory: pytest.TempPathFactory, samples_folder: Path) -> Path:
    """A small database that has learned."""
    path = tmp_path_factory.mktemp("before") / "motions.duckdb"
    with motiondb.open(path) as db:
        db.add(samples_folder / "ana/bow_1.bvh")
        db.add(samples_folder / "ana/jump_1.bvh")
        db.set_words("bow_1", "bow")
        db.learn()
    return path


@pytest.fixture(scope="module")
def commands(before: Path, samples_folder: Path) -> dict[str, tuple[list[Any], float]]:
    """What is interrupted, and how long it takes, seconds."""
    folder = before.parent / "more"
    folder.mkdir()
    for name in ("dance_1", "kick_1", "punch_1"):
        actual = sorted(samples_folder.glob(f"*/{name}.bvh"))[0]
        shutil.copy(actual, folder)
    jobs = {"add": ["add", folder], "learn": ["learn", "--symbols", 2]}
    timed = {}
    for name, words in jobs.items():
        path = shutil.copy(before, before.parent / f"{name}.duckdb")
        start = time.monotonic()
        ended = started([*words, "--db", path])
        out = ended.communicate(timeout=120)[0]
        assert ended.returncode == 0, out
        timed[name] = (words, time.monotonic() - start)
    return timed


@pytest.mark.parametrize("name", ["add", "learn"])
@pytest.mark.parametrize("share", [0.7])
def test_interrupted(
    tmp_path: Path, before: Path, commands: Any, contents: Contents, name: str, share: float
) -> None:
    words, seconds = commands[name]
    path = shutil.copy(before, tmp_path / "motions.duckdb")
    process = started([*words, "--db", path])
    time.sleep(share * seconds)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    out = process.communicate(timeout=120)[0]
    assert "Traceback" not in out
    done = contents(path)["run"] != contents(before)["run"]
    if process.returncode == 0 or (done and process.returncode == -signal.SIGINT):
        return  # it was quicker this time: saved, and perhaps met while Python itself was ending
    assert process.returncode == 130, out
    if done:
        assert out.endswith(
            "interrupted: complete changes up to then are saved, and nothing else\n"
        )
        return
    assert out.endswith("interrupted: the database is unchanged\n")
    assert contents(path) == contents(before)


LOST = """
import ctypes, os, signal, time
from motiondb.cli import main

@ctypes.CFUNCTYPE(None)
def callback():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5)

main._run = lambda: callback() or 0
main.main()
"""


def test_an_interrupt_inside_a_callback_is_not_lost() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", f"{HEEDED}\n{LOST}"], capture_output=True, text=True, timeout=120
    )
    assert ended.returncode == 130
    assert ended.stderr == "interrupted: the database is unchanged\n"


READER = """
import signal
from motiondb.database.catalogue.file_reading import _interrupts_wait, _pool_of

if __name__ == "__main__":
    with _pool_of(1) as pool:
        with _interrupts_wait():
            blocked = pool.schedule(signal.pthread_sigmask, args=(signal.SIG_BLOCK, ()))
        print(signal.SIGINT in blocked.result())
"""


def test_processes_that_read_leave_interrupts_to_the_command() -> None:
    ended = subprocess.run([sys.executable, "-c", READER], capture_output=True, text=True)
    assert (ended.stdout, ended.stderr) == ("True\n", "")
