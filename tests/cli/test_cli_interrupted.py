"""``add`` and ``learn`` interrupted: the store is as it was, or all is done."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

# A shell starts background jobs with interrupts ignored; what the tests start must heed them.
HEEDED = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
INTERRUPTED = """
import os
from motiondb import store
from motiondb.store import learned
from motiondb.cli import main, printing

def interrupt(*_):
    os.killpg(0, signal.SIGINT)  # as a terminal does

{place} = interrupt
main.main()
"""
KICK = Path(__file__).parents[2] / "sample_data/captures/boris/kick_1.bvh"
UNCHANGED = "interrupted: the database is unchanged\n"
SAVED = "interrupted: complete changes up to then are saved, and nothing else\n"


@pytest.mark.parametrize(
    ("words", "place", "said"),
    [
        (["add", KICK], "store.save_relations", UNCHANGED),
        (["add", KICK], "printing.number", SAVED),  # of the captures that were added
        (["learn", "--symbols", "2"], "learned.finish_run", UNCHANGED),
    ],
)
def test_interrupted(
    tmp_path: Path, small: Path, contents: Any, words: list[Any], place: str, said: str
) -> None:
    path = shutil.copy(small, tmp_path / "motions.duckdb")
    program = HEEDED + INTERRUPTED.format(place=place)
    ended = subprocess.run(
        [sys.executable, "-c", program, *words, "--db", path],
        capture_output=True,
        text=True,
        start_new_session=True,
    )
    assert (ended.returncode, ended.stderr.endswith(said)) == (130, True), ended.stderr
    assert "Traceback" not in ended.stderr
    assert (contents(path) == contents(small)) == (said == UNCHANGED)


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
    assert ended.stderr == UNCHANGED


READER = """
import signal
from motiondb.files.processes import interrupts_wait, pool_of

if __name__ == "__main__":
    with pool_of(1) as pool:
        with interrupts_wait():
            blocked = pool.schedule(signal.pthread_sigmask, args=(signal.SIG_BLOCK, ()))
        print(signal.SIGINT in blocked.result())
"""


def test_processes_that_read_leave_interrupts_to_the_command() -> None:
    ended = subprocess.run([sys.executable, "-c", READER], capture_output=True, text=True)
    assert (ended.stdout, ended.stderr) == ("True\n", "")
