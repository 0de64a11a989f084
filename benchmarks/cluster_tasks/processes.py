"""A scheduler and workers, each a process, and what their processes took."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
from dask.utils import key_split
from distributed import Client, Worker, get_task_stream
from tornado.iostream import IOStream

from motiondb.database.cluster import ready
from motiondb.symbols.spread import Part

Row = dict[str, float]
_RECEIVED = 0  # Bytes that this process read from its connections since `begin`
LOOK_SECONDS = 2.0
BENCHMARKS = Path(__file__).parent.parent


def begin() -> None:
    """In a worker: import what it needs, and count from now on what it receives."""
    global _RECEIVED
    ready()
    read = IOStream.read_from_fd

    def counted(stream: IOStream, buffer: bytearray | memoryview) -> int | None:
        global _RECEIVED
        n_bytes = read(stream, buffer)
        _RECEIVED += n_bytes or 0
        return n_bytes

    IOStream.read_from_fd = counted  # type: ignore[method-assign,assignment]


def took() -> tuple[float, float, float]:
    """In a worker: bytes received, processor seconds, and the largest resident size so far."""
    return float(_RECEIVED), time.process_time(), _peak(os.getpid())


def held(dask_worker: Worker) -> float:
    """In a worker: bytes of frames of captures that it holds."""
    found = list(dask_worker.data.values())
    return float(sum(each.frames.nbytes for each in found if isinstance(each, Part)))


@dataclass
class Processes:
    """A scheduler and its workers."""

    address: str
    scheduler: psutil.Popen
    client: Client


@contextmanager
def started(n_workers: int, folder: Path) -> Iterator[Processes]:
    """A scheduler and workers of one thread each, which end with the block."""
    place = folder / "scheduler.json"
    place.unlink(missing_ok=True)
    common = ["--scheduler-file", str(place), "--no-dashboard"]
    path = os.pathsep.join([str(BENCHMARKS), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"}

    def start(what: str, *options: str) -> psutil.Popen:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *common, *options]
        return psutil.Popen(
            command,
            env=environment,
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    running = [start("scheduler", "--host", "127.0.0.1", "--port", "0")]
    running += [start("worker", "--nthreads", "1", "--no-nanny") for _ in range(n_workers)]
    try:
        while not (place.exists() and place.read_text().rstrip().endswith("}")):
            time.sleep(0.1)
        with Client(json.loads(place.read_text())["address"], set_as_default=False) as client:
            client.wait_for_workers(n_workers, timeout=60)
            client.run(begin)
            yield Processes(client.scheduler.address, running[0], client)
    finally:
        for process in running:
            process.kill()
            process.wait()


def measured(processes: Processes, work: Callable[[], Row]) -> Row:
    """Do some work; gives its row with what scheduler and workers took for it."""
    before, idle = _of_workers(processes), _seconds(processes.scheduler)
    most, done = [0.0], threading.Event()

    def look() -> None:
        while not done.wait(LOOK_SECONDS):
            most[0] = max(most[0], *processes.client.run(held).values())

    looking = threading.Thread(target=look)
    looking.start()
    try:
        with get_task_stream(processes.client) as stream:
            row = work()
    finally:
        done.set()
        looking.join()
    after = _of_workers(processes)
    spent = [[b - a for a, b in zip(*pair)] for pair in zip(before, after)]
    worked = sum(each[1] for each in spent)
    return (
        row
        | _by_work(stream.data, worked)
        | {
            "received, bytes": sum(each[0] for each in spent),
            "received most, bytes": max(each[0] for each in spent),
            "worked, s": worked,
            "worked most, s": max(each[1] for each in spent),
            "held, bytes": most[0],
            "worker peak, bytes": max(each[2] for each in after),
            "scheduler, s": _seconds(processes.scheduler) - idle,
            "scheduler peak, bytes": _peak(processes.scheduler.pid),
            "tasks": float(len(stream.data)),
        }
    )


def _by_work(tasks: Sequence[Mapping[str, Any]], worked: float) -> Row:
    """Processor seconds of the workers, shared out by the time that tasks of each name took."""
    seconds = Counter[str]()
    for task in tasks:
        name = key_split(task["key"])
        for span in task["startstops"]:
            if span["action"] == "compute":
                seconds[f"{name}, s"] += span["stop"] - span["start"]
    every = sum(seconds.values()) or 1.0
    return {name: worked * part / every for name, part in seconds.items()}


def _of_workers(processes: Processes) -> list[tuple[float, float, float]]:
    found = processes.client.run(took)
    return [found[worker] for worker in sorted(found)]


def _seconds(process: psutil.Process) -> float:
    """Processor seconds of a process."""
    times = process.cpu_times()
    return float(times.user + times.system)


def _peak(pid: int) -> float:
    """Largest resident size of a process, bytes; ``getrusage`` counts that of its parent."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    (size,) = (line.split()[1] for line in lines if line.startswith("VmHWM"))
    return float(size) * 1024
