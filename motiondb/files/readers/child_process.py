"""A child process with limits, in which a library in C reads one file.

A damaged file can make such a library loop for ever, fill the memory or end its process. The child
turns all of these into an error that says which it was, and lets the other captures of a folder be
read. A reader module calls :func:`read_in_child` with its own name; run as a program, it begins
with :func:`end_child_with_parent`, reads the file and writes arrays as npz.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from motiondb.errors import CaptureError
from motiondb.files.limits import ReadLimits, cap_memory
from motiondb.files.processes import end_with_parent, is_main_thread

_NO_MEMORY = 77  # Exit code of a child that found too little memory


def read_in_child(
    module: str,
    data: bytes,
    limits: ReadLimits,
    cpu_seconds: float,
    given: Sequence[str] = (),
    path: object = "capture",
) -> dict[str, Any]:
    """The arrays that a module reads from bytes; CaptureError with the way in which it failed.

    `cpu_seconds`: Processor time for 10 MB under the usual limit of time, in proportion to it and
    to the bytes. `path`: The file's, for messages.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "copy"), Path(folder, "arrays.npz")
        seconds = min(limits.seconds_for(len(data)), 1e6)
        share = min(cpu_seconds / ReadLimits().seconds, 1.0)
        # -P: modules of the working folder must not replace those that are imported
        command = [sys.executable, "-P", "-m", module, str(share * seconds)]
        command += [str(2.0 * limits.memory), str(os.getpid()), str(int(is_main_thread()))]
        command += [str(source), str(target), *given]
        try:
            source.write_bytes(data)
            done = subprocess.run(command, capture_output=True, timeout=seconds)
        except subprocess.TimeoutExpired:
            raise CaptureError(path, too_slow(seconds)) from None
        except OSError as error:
            raise CaptureError(
                path,
                "expected a process that reads the file, found that none can be started "
                f"({error.strerror}). The file was not looked at: try again.",
            ) from None
        if done.returncode:
            raise CaptureError(path, how_ended(done.returncode, done.stderr, share * seconds))
        with np.load(target) as file:
            return {key: file[key] for key in file.files}


def too_slow(seconds: float) -> str:
    """What to say of a file that takes longer than it may."""
    return (
        f"expected to read the file within {seconds:.3g} s, found that it takes longer. "
        "Cut the capture, or allow more with --time-limit."
    )


def how_ended(code: int, said: bytes = b"", cpu_seconds: float = 0.0) -> str:
    """What to say of a file whose process ended with a code; below 0: by this signal.

    `said`: What the process wrote on standard error. `cpu_seconds`: Its limit of processor time.

    >>> how_ended(3)[:78]
    'expected a file that can be read, found that its process ended with code 3. Ex'
    """
    if code == _NO_MEMORY:
        return (
            "expected a file that fits into memory, found a larger one. Cut the capture, or allow "
            "more with --memory-limit."
        )
    name = f"signal {-code}"
    with suppress(ValueError):
        name = signal.Signals(-code).name
    if name == "SIGXCPU":
        return too_slow(cpu_seconds).replace(" s,", " s of processor time,")
    if name in ("SIGKILL", "SIGTERM"):
        return (
            f"expected to read the file, found that the process was ended from outside ({name}), "
            "as the system does where memory is short. The file may be whole: close other "
            "programs, or read fewer files at once (--jobs 1)."
        )
    if code < 0:
        return (
            f"expected a file that can be read, found that it ends the process that reads it "
            f"({name}). It is damaged, or needs more memory: export it again, or allow more with "
            "--memory-limit."
        )
    if b"emory" in said[-2000:]:  # of libraries that end the process, as OpenBLAS does
        return how_ended(_NO_MEMORY)
    last = said.decode(errors="replace").strip().rpartition("\n")[2][:120]
    found = f"its reader fails ({last})" if last else f"its process ended with code {code}"
    return f"expected a file that can be read, found that {found}. Export it again."


def end_child_with_parent() -> tuple[str, str, list[str]]:
    """Limit this process, tie it to its parent; return source, target and further arguments."""
    sys.excepthook = _end
    _limit_process(float(sys.argv[1]), float(sys.argv[2]))
    end_with_parent(int(sys.argv[3]), sys.argv[4] == "1")
    return sys.argv[5], sys.argv[6], sys.argv[7:]


def _limit_process(cpu_seconds: float, memory: float) -> None:
    """Limit the processor time and the memory of this process, if the system can."""
    cap_memory(memory)
    try:
        import resource
    except ImportError:
        return
    seconds = min(int(cpu_seconds) + 1, 10**6)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))  # SIGXCPU, then SIGKILL


def _end(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Say with the exit code what a message may not: there is too little memory for more."""
    if issubclass(kind, MemoryError):
        os._exit(_NO_MEMORY)
    sys.__excepthook__(kind, error, trace)
