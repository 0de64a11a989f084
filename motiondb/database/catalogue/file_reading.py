"""Reading capture files: several at a time, in other processes.

A file becomes everything that is to be saved, or the sentence that says why not; nothing here
touches the store.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from motiondb import capture, store
from motiondb.capture.sheet import SheetEntry
from motiondb.errors import MotionDBError
from motiondb.pose import retarget
from motiondb.records import Motion

_FEW = 4
"""Files that are read faster than other processes start."""
_WATCH = "end with parent"


@dataclass(frozen=True)
class AddSettings:
    """How files are read. unit: metres per length unit (None: found). joint_map: role -> joint."""

    unit: float | None = None
    fps: float | None = None
    skip_bad_frames: bool = False
    joint_map: Mapping[str, str] = field(default_factory=dict)
    jobs: int = 2


@dataclass(frozen=True, eq=False)
class Reading:
    """A file read by a worker: everything to save, or why not."""

    name: str
    path: str
    source: store.Source | None = None
    motion: Motion | None = None
    fps: float = 0.0
    n_frames: int = 0
    notes: tuple[str, ...] = ()
    problem: str = ""


_Job = tuple[str, Path, SheetEntry | None, Path, AddSettings]


def read_all(jobs: Sequence[_Job], n_jobs: int) -> Iterator[Reading]:
    """Readings in the order of the jobs; in other processes where there are more than a few."""
    if len(jobs) <= _FEW or n_jobs == 1:
        yield from (_read_one(*job) for job in jobs)
        return
    from joblib import Parallel, delayed

    n_jobs = min(n_jobs, len(jobs), os.cpu_count() or 1)
    with _interrupts_wait():
        readings = Parallel(n_jobs=n_jobs, return_as="generator")(
            delayed(_read_beside)(os.getpid(), str(Path.cwd()), *job) for job in jobs
        )
    yield from readings


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Hold Ctrl-C back while processes start: they inherit that, and leave it to this one."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _read_beside(parent: int, folder: str, *job: Any) -> Reading:
    """Read in another process, which ends when its parent has been killed.

    Processes are used again: ``folder`` is where relative paths begin now.
    """
    os.chdir(folder)
    if not any(thread.name == _WATCH for thread in threading.enumerate()):
        threading.Thread(target=_end_with, args=(parent,), name=_WATCH, daemon=True).start()
    return _read_one(*job)


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def _read_one(
    name: str, path: Path, entry: SheetEntry | None, folder: Path, settings: AddSettings
) -> Reading:
    try:
        data = path.read_bytes()
        kind = capture.capture_format(path)
        asf = _skeleton(path, entry, folder)
        skeleton_data = asf.read_bytes() if asf else None
        fps = entry.fps if entry and entry.fps else settings.fps
        clip = capture.read_capture_bytes(
            data,
            kind,
            path=path,
            skeleton=skeleton_data,
            skeleton_path=asf or "",
            fps=fps,
            unit=settings.unit,
            skip_bad_frames=settings.skip_bad_frames,
        )
        motion = retarget.to_motion(clip, settings.joint_map)
        source = store.pack_source(path.name, data, kind, asf.name if asf else None, skeleton_data)
    except MotionDBError as error:
        message = str(error)
        return Reading(
            name, str(path), problem=message if str(path) in message else f"{path}: {message}"
        )
    except OSError as error:
        return Reading(
            name, str(path), problem=f"{path}: expected a readable file, found {error.strerror}."
        )
    if not np.isfinite(motion.root_positions).all():
        return Reading(name, str(path), problem=f"{path}: expected finite positions, found none.")
    notes = clip.notes + motion.notes
    return Reading(name, str(path), source, motion, clip.fps, clip.n_frames, notes)


def _skeleton(path: Path, entry: SheetEntry | None, folder: Path) -> Path | None:
    """The ASF of an AMC: as the sheet names it below the folder or beside the file, or found."""
    if path.suffix.lower() != ".amc":
        return None
    if entry and entry.skeleton:
        for base in (folder, path.parent):
            for ending in ("", ".asf"):
                candidate = base / (entry.skeleton + ending)
                if candidate.is_file():
                    return candidate
    return capture.skeleton_path(path)


def read_joint_map(path: Path) -> dict[str, str]:
    """Read lines ``role = joint`` (# begins a comment) for skeletons that no convention fits.

    Raises
    ------
    MotionDBError
        with every line that is no such pair.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise MotionDBError(f"{path}: expected a readable joint map, found {error}.") from None
    pairs: dict[str, str] = {}
    faults = []
    for number, line in enumerate(lines, start=1):
        text = line.split("#")[0].strip()
        role, equals, joint = (part.strip() for part in text.partition("="))
        if text and not (role and equals and joint):
            faults.append(f"{path}:{number}: expected `role = joint`, found {text!r}.")
        elif text:
            pairs[role] = joint
    if faults:
        raise MotionDBError("\n".join(faults))
    return pairs
