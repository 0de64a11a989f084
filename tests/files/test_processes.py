"""Processes that work for another one end when it is killed, whatever they are at.

All write to the output of the one that is killed, which is therefore read to its end only when all
of them have ended; those that did not would wait for ten minutes.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

WAITS = "__import__('time').sleep(600)"
HOLDS_PYTHON = "__import__('ctypes').PyDLL(None).sleep(600)"
"""Waits in C without letting any Python run, as a library may that reads a damaged file."""

READS = """
import sys
from pathlib import Path
from motiondb.database.catalogue.file_reading import AddSettings, FileToRead, read_all

class Slow(type(Path())):
    def __reduce__(self):  # a path whose reading waits
        begun = f"__import__('pathlib').Path({str(self) + '.begun'!r}).touch()"
        methods = f"dict.fromkeys(('stat', 'is_file'), lambda *_, **__: {begun} or {sys.argv[2]})"
        base = "type(__import__('pathlib').Path())"
        return eval, (f"type('Slow', ({base},), {methods})({str(self)!r})",)

folder = Path(sys.argv[1])
paths = [Slow(folder / f"take{n}") for n in range(6)]
jobs = [FileToRead(path.name, path, None, folder, AddSettings()) for path in paths]
print(list(read_all(jobs, 2)))
"""
STARTS = """
import os, subprocess, sys, threading
from motiondb.files.processes import is_main_thread

child = '''
import pathlib, sys
from motiondb.files.processes import end_with_parent
end_with_parent(int(sys.argv[1]), sys.argv[2] == "True")
pathlib.Path(sys.argv[3], "child.begun").touch()
{waits}
'''.format(waits=sys.argv[2])

def start():
    subprocess.run([sys.executable, "-c", child, str(os.getpid()), str(is_main_thread()),
                    sys.argv[1]])

thread = threading.Thread(target=start)
thread.start()
thread.join()
"""


def killed_when_begun(program: str, folder: Path, waits: str, n: int) -> subprocess.Popen[str]:
    """A program that was killed when ``n`` processes had begun to wait."""
    process = subprocess.Popen(
        [sys.executable, "-c", program, str(folder), waits], stdout=subprocess.PIPE, text=True
    )
    limit = time.monotonic() + 120
    while len(list(folder.glob("*.begun"))) < n and time.monotonic() < limit:
        assert process.poll() is None, "it ended before the others had begun"
        time.sleep(0.05)
    process.kill()
    return process


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX")
@pytest.mark.parametrize(
    "waits",
    [
        WAITS,
        pytest.param(
            HOLDS_PYTHON,
            marks=pytest.mark.skipif(sys.platform != "linux", reason="only Linux kills for it"),
        ),
    ],
)
def test_readers_end_when_add_is_killed(tmp_path: Path, waits: str) -> None:
    process = killed_when_begun(READS, tmp_path, waits, 2)
    assert process.communicate(timeout=60)[0] == ""


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX")
def test_a_process_that_a_thread_started_ends_too(tmp_path: Path) -> None:
    process = killed_when_begun(STARTS, tmp_path, WAITS, 1)
    assert process.communicate(timeout=60)[0] == ""
