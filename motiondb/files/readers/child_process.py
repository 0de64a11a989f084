"""A child process with limits, in which a library in C reads one file.

A damaged file can make such a library loop for ever, fill the memory or end its process. The child
turns all of these into an answer that does not come, and lets the other captures of a folder be
read. A reader module calls :func:`read_in_child` with its own name; run as a program, it begins
with :func:`end_child_with_parent`, reads the file and writes arrays as npz.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from motiondb.files.limits import ReadLimits, cap_memory
from motiondb.files.parent_process import end_with_parent, is_main_thread


def read_in_child(
    module: str,
    data: bytes,
    limits: ReadLimits,
    cpu_seconds: float,
    given: Sequence[str] = (),
) -> dict[str, Any] | None:
    """The arrays that a module reads from bytes, None if it failed; seconds for 10 MB."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "copy"), Path(folder, "arrays.npz")
        source.write_bytes(data)
        costs = [str(cpu_seconds * max(1.0, len(data) / 1e7)), str(2.0 * limits.memory)]
        # -P: modules of the working folder must not replace those that are imported
        command = [sys.executable, "-P", "-m", module, *costs]
        command += [str(os.getpid()), str(int(is_main_thread())), str(source), str(target), *given]
        try:
            seconds = min(limits.seconds_for(len(data)), 1e6)
            subprocess.run(command, capture_output=True, timeout=seconds, check=True)
            with np.load(target) as file:
                return {key: file[key] for key in file.files}
        except (subprocess.SubprocessError, OSError, ValueError, KeyError):
            return None


def end_child_with_parent() -> tuple[str, str, list[str]]:
    """Limit this process, tie it to its parent; return source, target and further arguments."""
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
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
