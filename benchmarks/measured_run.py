"""Run a command and measure it: seconds, and the most memory that it and its children held.

Memory is the resident size summed over the command and everything it started, looked at twenty
times a second; pages that processes share are counted in each, so the figure is an upper bound.
"""

from __future__ import annotations

import itertools
import os
import platform
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import psutil

LOOKS_PER_SECOND = 20
"""How often memory is read. A shorter peak than 50 ms may be missed."""
LOOKS_PER_FAMILY = 4
"""Looks after which new processes are looked for: this reads all processes of the machine (3 ms of
370; the memory of one takes .015 ms)."""


@dataclass(frozen=True)
class MeasuredRun:
    """seconds of wall clock; processor seconds and the peak of resident memory, children included;
    what it printed."""

    seconds: float
    processor_seconds: float
    peak_bytes: int
    exit_code: int
    output: str
    complaints: str


def run_measured(command: Sequence[str], settings: Mapping[str, str] | None = None) -> MeasuredRun:
    """Run a command to its end; ``settings`` are environment variables on top of the present.

    Modules are compiled once, as they are for users: where ``PYTHONDONTWRITEBYTECODE`` is set,
    every command compiles them again, which takes longer than ``info``.
    """
    environment = {**os.environ, **(settings or {})}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        before = _children_seconds()
        started = time.perf_counter()
        process = subprocess.Popen(list(command), stdout=out, stderr=err, env=environment)
        ended, sizes = threading.Event(), [0]
        watcher = threading.Thread(target=_watch, args=(process.pid, ended, sizes))
        watcher.start()
        process.wait()
        seconds = time.perf_counter() - started
        ended.set()
        watcher.join()
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
    worked = _children_seconds() - before
    return MeasuredRun(seconds, worked, max(sizes), process.returncode, *texts)


def _children_seconds() -> float:
    """Processor time of all ended children so far."""
    times = os.times()
    return times.children_user + times.children_system


def _watch(pid: int, ended: threading.Event, sizes: list[int]) -> None:
    family: list[psutil.Process] = []
    for look in itertools.count():
        if ended.wait(1.0 / LOOKS_PER_SECOND):
            return
        if look % LOOKS_PER_FAMILY == 0:
            family = _family(pid)
        sizes.append(_resident_bytes(family))


def _family(pid: int) -> list[psutil.Process]:
    """A process and everything below it; nothing for one that has ended."""
    try:
        process = psutil.Process(pid)
        return [process, *process.children(recursive=True)]
    except psutil.Error:
        return []


def _resident_bytes(processes: Sequence[psutil.Process]) -> int:
    """Resident memory of those processes that run."""
    total = 0
    for process in processes:
        with suppress(psutil.Error):
            total += process.memory_info().rss
    return total


def motiondb_command(*arguments: str) -> list[str]:
    """The command line of this Python's motiondb."""
    return [str(Path(sys.executable).with_name("motiondb")), *arguments]


def machine() -> str:
    """Processor, cores, memory, system and Python in a line."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    name = names[0] if names else platform.processor() or platform.machine()
    memory = psutil.virtual_memory().total / 2**30
    return (
        f"{name}, {psutil.cpu_count()} cores, {memory:.0f} GiB, {platform.system()}, "
        f"Python {platform.python_version()}"
    )


def versions(*packages: str) -> str:
    """Packages with their versions in a line."""
    return ", ".join(f"{package} {version(package)}" for package in packages)
