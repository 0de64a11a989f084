"""A process that works for another one ends when that one has ended, however it ended.

A process that is killed (SIGKILL) cannot tell those that it started. So each of them looks for
itself, in two ways:

* On Linux the kernel is asked to kill it (``prctl``, PR_SET_PDEATHSIG). This works at once, also
  inside a library that does not let Python run. The kernel watches the *thread* that started the
  process, so this is asked for only where that was the main thread, which ends with its process.
* On every POSIX system a thread looks every 0.25 s whether the parent is still the same one: a
  process whose parent has ended is given another.

Windows does neither: there, a process ends with the file that it reads.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from contextlib import suppress

_INTERVAL = 0.25
"""Seconds between two looks at the parent. Chosen by hand: short beside the second within which a
killed command should be gone, and far too seldom to cost time."""
_PR_SET_PDEATHSIG = 1  # From ``linux/prctl.h``


def is_main_thread() -> bool:
    """Return whether this is the main thread: a process that it starts may be tied to it."""
    return threading.current_thread() is threading.main_thread()


def end_with_parent(parent: int, by_main_thread: bool) -> None:
    """End this process within a second after its parent has ended."""
    if by_main_thread and sys.platform == "linux":
        import ctypes

        with suppress(OSError, AttributeError):  # a C library without prctl: the thread looks
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL))
    threading.Thread(target=_watch, args=(parent,), name="parent process", daemon=True).start()


def _watch(parent: int) -> None:
    """End this process when it has another parent; also when that happened before."""
    while os.getppid() == parent:
        time.sleep(_INTERVAL)
    os._exit(1)
