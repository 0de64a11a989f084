"""Marker tracks of a C3D file, read by ezc3d in a separate process.

A damaged file can make ezc3d loop for ever, fill the memory or end its process. A child process
with limits on time and memory turns all of these into a message, and lets the other captures of a
folder be read.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motiondb.errors import CaptureError
from motiondb.files.limits import ReadLimits, cap_memory
from motiondb.files.parent_process import end_with_parent, is_main_thread
from motiondb.records import FloatArray

CPU_SECONDS = 5.0
"""Processor time of the child for a file of 10 MB, in proportion for larger ones. ezc3d reads 13 MB
in 0.4 s; a damaged file that makes it loop takes all of the time."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Marker tracks as a file has them."""

    labels: tuple[str, ...]  # Name of each marker, as written
    points: FloatArray  # (markers, frames, 3): file axes and units; NaN where a marker was not seen
    fps: float
    unit: str  # Name of the length unit, such as "mm"


def read_points(data: bytes, path: object, limits: ReadLimits | None = None) -> Recording:
    """Read the markers in the bytes of a C3D file."""
    if importlib.util.find_spec("ezc3d") is None:
        raise CaptureError(
            path,
            "expected the package ezc3d to read C3D, found none. pip install motiondb[c3d]",
        )
    _check_size(data, path)
    limits = limits or ReadLimits()
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "copy.c3d"), Path(folder, "points.npz")
        source.write_bytes(data)
        costs = [str(CPU_SECONDS * max(1.0, len(data) / 1e7)), str(2.0 * limits.memory)]
        # -P: modules of the working folder must not replace those that are imported
        command = [sys.executable, "-P", "-m", "motiondb.files.readers.c3d_points", *costs]
        command += [str(source), str(target), str(os.getpid()), str(int(is_main_thread()))]
        try:
            seconds = min(limits.seconds_for(len(data)), 1e6)
            subprocess.run(command, capture_output=True, timeout=seconds, check=True)
            with np.load(target) as file:
                recording = Recording(
                    labels=tuple(file["labels"].tolist()),
                    points=file["points"],
                    fps=float(file["fps"]),
                    unit=str(file["unit"]),
                )
        except (subprocess.SubprocessError, OSError, ValueError, KeyError) as error:
            raise CaptureError(
                path, "expected a whole C3D file, found a damaged one. Export it again."
            ) from error
    if recording.points.ndim != 3 or recording.points.shape[1] == 0:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    return recording


def _check_size(data: bytes, path: object) -> None:
    """Refuse bytes that are not a C3D file, or are shorter than their header says.

    The header holds 16-bit words: word 2 is the number of points, word 3 the number of analog
    values in a frame, words 4 and 5 the first and the last frame, word 9 the block (of 512 bytes)
    where the data begin. Words 7 and 8 are the scale, which is negative when the data are floats.
    Byte 4 of the parameters names the byte order.
    """
    if data[1:2] != b"\x50" or len(data) < 512:
        raise CaptureError(path, "expected a C3D file, found something else. Export it again.")
    processor = data[(data[0] - 1) * 512 :][3:4] if data[0] else b""
    order = ">" if processor == b"\x56" else "<"
    words = np.frombuffer(data[:20], f"{order}u2").astype(int)
    high = data[15] if order == "<" else data[12]
    frame = (4 * words[1] + words[2]) * (4 if high >= 128 else 2)
    expected = (words[8] - 1) * 512 + (words[4] - words[3] + 1) * frame
    if len(data) < expected:
        raise CaptureError(
            path,
            f"expected {expected} bytes as the header says, found {len(data)}. "
            "The file is cut short: export it again.",
        )


def convert(source: str, target: str) -> None:
    """Read a C3D file with ezc3d and write its markers as npz: the work of the child process."""
    import ezc3d

    content = ezc3d.c3d(source)
    parameters = content["parameters"]["POINT"]
    points = np.asarray(content["data"]["points"], dtype=float)[:3]
    units = parameters["UNITS"]["value"] if "UNITS" in parameters else ["mm"]
    np.savez(
        target,
        labels=np.array([str(label) for label in parameters["LABELS"]["value"]], dtype=str),
        points=np.moveaxis(points, 0, -1),
        fps=float(parameters["RATE"]["value"][0]),
        unit=str(units[0]) if len(units) else "mm",
    )


def limit_process(cpu_seconds: float, memory: float) -> None:
    """Limit the processor time and the memory of this process, if the system can."""
    cap_memory(memory)
    try:
        import resource
    except ImportError:
        return
    seconds = min(int(cpu_seconds) + 1, 10**6)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))


if __name__ == "__main__":
    end_with_parent(int(sys.argv[5]), sys.argv[6] == "1")
    limit_process(float(sys.argv[1]), float(sys.argv[2]))
    convert(sys.argv[3], sys.argv[4])
