"""Jobs in other processes, each of which ends when the one that it works for has ended.

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
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import Future

    from joblib.externals.loky.backend.context import LokyContext
    from pebble import ProcessPool

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


Job = TypeVar("Job")
Result = TypeVar("Result")
_AHEAD = 4
"""Jobs that are handed out for each process before the first of them is saved: the others go on
beside a slow one, and few results wait in memory."""
_ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)  # Environment of the processes: there is one for each core already


def in_processes(
    jobs: Iterable[Job],
    n_jobs: int,
    submit: Callable[[ProcessPool, Job], Future[Result]],
    result: Callable[[Job, Future[Result] | None], Result],
) -> Iterator[Result]:
    """The results of jobs in other processes, in their order.

    `result` is given None where a job cannot be handed out.
    """
    n_jobs = min(n_jobs, os.cpu_count() or 1)
    running: deque[tuple[Job, Future[Result] | None]] = deque()
    with pool_of(n_jobs) as pool:
        for job in jobs:
            try:
                with interrupts_wait():
                    future = submit(pool, job)
            except (OSError, RuntimeError):  # it cannot start, or it is broken
                future = None
            running.append((job, future))
            if len(running) == _AHEAD * n_jobs:
                yield result(*running.popleft())
        while running:
            yield result(*running.popleft())


@contextmanager
def pool_of(n_jobs: int) -> Iterator[ProcessPool]:
    """Processes that read, which end with the block."""
    from pebble import ProcessPool

    parent = (os.getpid(), is_main_thread())
    pool = ProcessPool(n_jobs, initializer=end_with_parent, initargs=parent, context=_context())
    try:
        yield pool
    finally:
        with suppress(Exception):  # a pool that could not start has nothing to end
            pool.stop()  # files that are left belong to an error
            pool.join()


def _context() -> LokyContext:
    """How processes are started: without importing again the program that adds captures."""
    from joblib.externals.loky.backend.context import LokyContext
    from joblib.externals.loky.backend.process import LokyProcess

    # Now, since its start ends the block of Ctrl-C that processes after it should inherit
    with suppress(ImportError):  # Windows, which has none
        resource_tracker.ensure_running()
    context = LokyContext()
    context.Process = partial(LokyProcess, env=_ONE_THREAD)
    return context


@contextmanager
def interrupts_wait() -> Iterator[None]:
    """Block Ctrl-C while processes start: they inherit this, so that only this process gets it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
