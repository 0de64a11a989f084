"""Odd files and texts by the thousand, in processes of their own, with time and memory measured.

A case is read, refused with one of the project's errors, or it fails: another exception, a process
that dies, more than ten seconds or more than 1 GB. Seconds are those of the processor, over all
threads and processes of the case, so that other work on the computer does not count; a process that
says nothing for five minutes is ended, and fails too. The memory of a case is the peak of the
resident size of its process while it is read (Linux; elsewhere the peak since the process began, an
upper bound), the libraries included.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import shutil
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from robustness_tasks.databases import import_everything
from robustness_tasks.reading import Case, Place, make_case

MOST_SECONDS, MOST_MEGABYTES = 10.0, 1000.0
"""The targets: a case above either fails."""
HANGS = 300.0
"""Seconds after which a process that says nothing is ended."""
CHUNK = 1000
"""Cases that one process reads. Chosen by hand: few enough to notice what grows with their number,
and enough that loading compiled code once for each chunk takes little of the time."""
SAFETY_NET = "expected a file that its reader knows"
"""How a refusal begins that no reader wrote: an exception was caught and translated."""


_Active = dict[Connection, tuple[BaseProcess, Sequence[int], float]]
"""Pipe -> its process, the cases that are left to it, and when it was last heard."""


@dataclass(frozen=True)
class Outcome:
    """What became of a case.

    Attributes
    ----------
    seed, kind : the case.
    result : "read", "refused", "caught" (by the safety net) or "failed".
    message : the refusal, or what failed.
    seconds, megabytes : what it cost; memory of the whole process at its peak.
    """

    seed: int
    kind: str
    result: str
    message: str
    seconds: float
    megabytes: float

    @property
    def is_failure(self) -> bool:
        """Whether a target was missed."""
        costly = self.seconds > MOST_SECONDS or self.megabytes > MOST_MEGABYTES
        return self.result == "failed" or costly


def read_one(seed: int, place: Place) -> Outcome:
    """Read the case of a seed in this process."""
    return measured(seed, make_case(seed), place)


def measured(seed: int, case: Case, place: Place) -> Outcome:
    """Read a case in this process, and measure it."""
    from motiondb.errors import MotionDBError

    _forget_peak()
    children = _megabytes(resource.RUSAGE_CHILDREN)
    began, result, message = _worked(), "read", ""
    try:
        case.read(place)
    except MotionDBError as error:
        message = str(error)
        result = "caught" if SAFETY_NET in message else "refused"
    except (Exception, SystemExit, RecursionError) as error:
        result, message = "failed", f"{type(error).__name__}: {error}"
    seconds = _worked() - began
    memory = _megabytes(resource.RUSAGE_SELF)
    after = _megabytes(resource.RUSAGE_CHILDREN)
    memory = max(memory, after if after > children else 0.0)
    return Outcome(seed, case.kind, result, message[:400], seconds, memory)


def run(seeds: Sequence[int], database: Path, processes: int = 2) -> Iterator[Outcome]:
    """Read the cases of all seeds, several at a time; in no particular order."""
    import_everything()  # once, before the processes part
    left = deque(seeds[n : n + CHUNK] for n in range(0, len(seeds), CHUNK))
    active: _Active = {}
    try:
        while left or active:
            while left and len(active) < processes:
                pipe, process = _start(left[0], database)
                active[pipe] = (process, left.popleft(), time.monotonic())
            yield from _outcomes(active, left)
    finally:
        for process, _, _ in active.values():
            process.kill()
            process.join()


def _outcomes(active: _Active, left: deque[Sequence[int]]) -> Iterator[Outcome]:
    """Take what the processes say; the cases of one that ended go on in another."""
    ready = wait(list(active), timeout=1.0)
    for pipe, (process, chunk, heard) in list(active.items()):
        late = pipe not in ready and time.monotonic() - heard > HANGS
        if pipe not in ready and not late:
            continue
        try:
            outcome = _hung(chunk[0]) if late else pipe.recv()
        except EOFError:
            process.join()
            outcome = _died(chunk[0], process.exitcode) if chunk else None
        if outcome is not None:
            yield outcome
            chunk = chunk[1:]
        if outcome is None or outcome.result == "failed" or not chunk:
            process.kill()
            process.join()
            del active[pipe]
            if chunk:
                left.appendleft(chunk)
        else:
            active[pipe] = (process, chunk, time.monotonic())


def read_beside(case: Case, place: Place) -> Outcome:
    """Read a case in a process of its own."""
    here, there = multiprocessing.get_context("fork").Pipe()
    process = multiprocessing.get_context("fork").Process(
        target=lambda: there.send(measured(0, case, place))
    )
    process.start()
    there.close()
    try:
        late = not here.poll(HANGS)
        return Outcome(0, case.kind, "failed", "no end", HANGS, 0.0) if late else here.recv()
    except EOFError:
        return Outcome(0, case.kind, "failed", "its process ended", 0.0, 0.0)
    finally:
        process.kill()
        process.join()


def _start(chunk: Sequence[int], database: Path) -> tuple[Connection, BaseProcess]:
    here, there = multiprocessing.get_context("fork").Pipe()
    process = multiprocessing.get_context("fork").Process(
        target=_read_chunk, args=(chunk, database, there)
    )
    process.start()
    there.close()
    return here, process


def _read_chunk(chunk: Sequence[int], database: Path, pipe: Connection) -> None:
    """Read cases one after the other, each in an empty folder."""
    with tempfile.TemporaryDirectory() as folder:
        for seed in chunk:
            empty = Path(folder) / "case"
            shutil.rmtree(empty, ignore_errors=True)
            empty.mkdir()
            pipe.send(read_one(seed, Place(empty, database)))


def _died(seed: int, code: int | None) -> Outcome:
    message = f"its process ended with {code}"
    return Outcome(seed, make_case(seed).kind, "failed", message, 0.0, 0.0)


def _hung(seed: int) -> Outcome:
    message = f"no end after {HANGS:g} s"
    return Outcome(seed, make_case(seed).kind, "failed", message, HANGS, 0.0)


def _forget_peak() -> None:
    """Reset the peak of resident memory, if the system can."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return


def _worked() -> float:
    """Processor seconds of this process and of those that it started and that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def _megabytes(who: int) -> float:
    peak = resource.getrusage(who).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)
