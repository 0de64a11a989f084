"""Limits of size, time and memory for one file, and the translation of unexpected errors.

A file from an unknown source can be large, slow to read, or provoke errors in the libraries that
read it. The readers check sizes before they allocate; :func:`guarded` turns all other exceptions
into a :class:`CaptureError` that names the file, so that one invalid file does not stop an import.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import numpy as np

from motiondb.body.world import UPS
from motiondb.errors import CaptureError, MotionDBError, suggestion

MIN_FPS, MAX_FPS = 1.0, 2000.0
"""Frame rates outside this range are refused in a file. Optical systems record 30 to 1,000 frames a
second; slower or faster rates come from damaged headers."""
MAX_GIVEN_FPS = 10_000.0  # The highest frame rate that a user may give, in an option or in a sheet
BYTES_PER_JOINT_FRAME = 100
"""Memory that a reader needs for one joint in one frame: a quaternion and a position in float64 (56
bytes) and the temporary copies of them."""
SLOW_FPS = 10.0
"""Below this rate, resampling to 30 frames a second multiplies the frames. Every real capture has a
higher rate."""
MAX_SLOW_FRAMES = 100_000
"""Canonical frames (55 minutes) that a capture below ``SLOW_FPS`` may fill."""


@dataclass(frozen=True)
class ReadLimits:
    """Limits for reading one file.

    The slowest of 540 real captures (CMU, Bandai-Namco) takes 0.3 s to read, and a process that
    reads all of them peaks at 130 MB, so real captures stay far below the defaults. Files that are
    large on disk may take more: see the attributes.
    """

    seconds: float = 60.0
    """Time to read a file of 10 MB; larger files get more time in proportion."""
    memory: int = 400_000_000
    """Bytes that the clip may fill in memory: 22 joints for 25 minutes at 120 frames a second. A
    file that holds at least one byte for each joint in each frame may fill more, because then
    its data are real; every real capture in text is such a file."""
    file_bytes: int = 2_000_000_000
    """Largest file that is opened."""
    joints: int = 20_000
    """Largest number of joints. Rigs with faces and fingers have up to about 1,500."""

    def seconds_for(self, n_bytes: int) -> float:
        """Return the time limit for a file of so many bytes, in seconds.

        >>> ReadLimits().seconds_for(5_000_000), ReadLimits().seconds_for(50_000_000)
        (60.0, 300.0)
        """
        return self.seconds * max(1.0, n_bytes / 1e7)


NO_LIMITS = ReadLimits(sys.float_info.max, sys.maxsize, sys.maxsize, sys.maxsize)
"""For bytes that were accepted before, such as those that a database keeps."""


class SkeletonFile(NamedTuple):
    """The file beside a capture that it needs: its content, and its name in messages.

    The ASF of an AMC, the model of a robot, the names of the joints of an array.
    """

    data: bytes
    path: object = "skeleton.asf"


@dataclass(frozen=True)
class ReadOptions:
    """How a capture is read."""

    fps: float | None = None  # Frames per second, instead of the rate in the file
    # Metres per length unit; None: the unit in the file, or estimated from the size of the body
    unit: float | None = None
    # Leave out frames with wrong or unreadable values instead of refusing the file
    skip_bad_frames: bool = False
    limits: ReadLimits = field(default_factory=ReadLimits)  # What reading may cost
    within: Path | None = None  # Folder that links must not lead out of
    take: str = ""  # Which take of a file with several; "": the only one
    up: str = ""  # Axis that points up, whatever the file says: x, y, z, -x, -y, -z
    mirror_world: bool = False  # The axes of the file are left-handed
    swap_sides: bool = False  # The names of left and right are exchanged
    rate_file: str = ""  # Name of the file beside the capture that says `fps`; "": none


AS_USUAL = ReadOptions()


def check_options(options: ReadOptions, path: object) -> None:
    """Refuse a frame rate or a unit that no capture can have."""
    check_up(options.up, path)
    if options.fps is not None:
        check_rate(options.fps, path, most=MAX_GIVEN_FPS, advice="Give another.")
    unit = options.unit
    if unit is not None and not 0 < unit < float("inf"):
        raise CaptureError(
            path, f"expected a length unit above 0 metres, found {unit:g}. Give another."
        )


def check_up(up: str, where: object) -> str:
    """Return an axis that may point up; CaptureError for another word."""
    up = up.strip().lower()
    if up and up not in UPS:
        raise CaptureError(
            where,
            f"expected an axis that points up, one of {', '.join(UPS)}, found {up!r}. Give one."
            + suggestion(up, UPS),
        )
    return up


def check_rate(
    fps: float,
    path: object,
    what: str = "a frame rate",
    most: float = MAX_FPS,
    advice: str = "Give the right frame rate with --fps.",
) -> float:
    """Return the frame rate of a file; CaptureError if no capture has it."""
    if not MIN_FPS <= fps <= most:
        raise CaptureError(
            path, f"expected {what} from {MIN_FPS:g} to {most:g}, found {fps:g}. {advice}"
        )
    return fps


def check_file_size(n_bytes: int, path: object, limits: ReadLimits) -> None:
    """Refuse a file that is empty, or too large to be opened."""
    if n_bytes == 0:
        raise CaptureError(path, "expected a capture, found an empty file. Export it again.")
    if n_bytes > limits.file_bytes:
        raise CaptureError(
            path,
            f"expected at most {_megabytes(limits.file_bytes)}, found {_megabytes(n_bytes)}. "
            "Cut the capture into shorter takes.",
        )


def check_clip_size(
    n_frames: int, n_joints: int, n_bytes: int, path: object, limits: ReadLimits
) -> None:
    """Refuse a clip that would fill too much memory, before the memory is allocated."""
    if n_joints > limits.joints:
        raise CaptureError(
            path, f"expected at most {limits.joints} joints, found {n_joints}. Export fewer."
        )
    cells = n_frames * n_joints
    if cells * BYTES_PER_JOINT_FRAME > limits.memory and cells > n_bytes:
        raise CaptureError(
            path,
            f"expected a clip of at most {_megabytes(limits.memory)} in memory, found {n_frames} "
            f"frames of {n_joints} joints ({_megabytes(cells * BYTES_PER_JOINT_FRAME)}) in a file "
            f"of {_megabytes(n_bytes)}. Cut the capture, or allow more with --memory-limit.",
        )


def check_duration(n_frames: int, fps: float, path: object) -> None:
    """Refuse a slow frame rate that would make resampling fill the memory."""
    if fps < SLOW_FPS and n_frames / fps * 30.0 > MAX_SLOW_FRAMES:
        raise CaptureError(
            path,
            f"expected a frame rate above {SLOW_FPS:g} for {n_frames} frames, found {fps:g} "
            f"({n_frames / fps / 3600.0:.3g} hours). Give the right frame rate with --fps.",
        )


@contextmanager
def guarded(path: object, seconds: float | None = None) -> Iterator[None]:
    """Run a block that reads a file, so that only errors of this project leave it.

    Floating-point warnings are off inside: values that overflow are refused afterwards, as not
    finite.

    `seconds`: Time limit. It works in the main thread of a process on systems with interval timers;
    elsewhere there is none.
    """
    try:
        with np.errstate(all="ignore"), _alarm(seconds):
            yield
    except MotionDBError:
        raise
    except _TimeUp:
        if seconds is None:  # the limit of a block around this one
            raise
        raise CaptureError(
            path,
            f"expected to read the file within {seconds:.3g} s, found that it takes longer. "
            "Cut the capture, or allow more with --time-limit.",
        ) from None
    except MemoryError as error:
        raise CaptureError(
            path, "expected a file that fits into memory, found a larger one. Cut the capture."
        ) from error
    except RecursionError as error:
        raise CaptureError(
            path, "expected data that are not deeply nested, found deep nesting. Export it again."
        ) from error
    except Exception as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0][:120]
        raise CaptureError(
            path,
            f"expected a file that its reader knows, found one that it cannot read ({what}). "
            "Export it again.",
        ) from error


def cap_memory(n_bytes: float) -> None:
    """Limit how much more memory this process may take; beyond it, MemoryError is raised.

    Address space is limited, of which a process uses a part, so this is a bound that keeps a
    computer alive, not an exact measure. Does nothing if the system has no such limit.
    """
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = int(pages * resource.getpagesize() + n_bytes)
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    except (ImportError, OSError, ValueError, OverflowError):  # the last: no limit, in effect
        return


class _TimeUp(BaseException):
    """The time limit of a file has passed. No reader catches it by accident."""


@contextmanager
def _alarm(seconds: float | None) -> Iterator[None]:
    """Raise :class:`_TimeUp` in the block after so many seconds, and every second from then on."""
    main = threading.current_thread() is threading.main_thread()
    if seconds is None or seconds > 1e8 or not main or not hasattr(signal, "setitimer"):
        yield
        return

    def end(_number: int, _frame: FrameType | None) -> None:
        raise _TimeUp

    before = signal.signal(signal.SIGALRM, end)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _megabytes(n_bytes: int) -> str:
    """Write a number of bytes for a message.

    >>> _megabytes(1_000_000_000), _megabytes(900)
    ('1000 MB', '0.0009 MB')
    """
    return f"{n_bytes / 1e6:.4g} MB"
