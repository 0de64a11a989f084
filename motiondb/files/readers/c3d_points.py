"""Marker tracks of a C3D file, read by ezc3d in a separate process.

A damaged file can make ezc3d loop for ever, fill the memory or end its process. A child process
with limits on time and memory turns all of these into a message, and lets the other captures of a
folder be read.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass

import numpy as np

from motiondb.errors import CaptureError
from motiondb.files.limits import ReadLimits
from motiondb.files.readers.child_process import end_child_with_parent, read_in_child
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
    module = "motiondb.files.readers.c3d_points"
    read = read_in_child(module, data, limits or ReadLimits(), CPU_SECONDS)
    if read is None or not {"labels", "points", "fps", "unit"} <= read.keys():
        raise CaptureError(path, "expected a whole C3D file, found a damaged one. Export it again.")
    recording = Recording(
        tuple(read["labels"].tolist()), read["points"], float(read["fps"]), str(read["unit"])
    )
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


if __name__ == "__main__":
    convert(*end_child_with_parent()[:2])
