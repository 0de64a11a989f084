"""Reader of TRC: marker positions of Motion Analysis, OpenSim and Pose2Sim (:mod:`.markers`).

Five lines say what follows: the rate, the counts and the unit stand in the third, the names of the
markers in the fourth, each over three columns. A cell without a number, or three zeros, is a marker
that was not seen. The axis up is not in the file: y is usual.

Source: Motion Analysis, "Track Row Column (.trc) file format", as OpenSim's documentation has it.
"""

from __future__ import annotations

import numpy as np

from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, ReadOptions
from motiondb.files.readers.markers import MarkerFile, only_performer, read_markers
from motiondb.files.text import quoted
from motiondb.records import Clip, FloatArray


def read_trc_takes(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> dict[str, Clip]:
    """Read the clip of each performer in the bytes of a TRC file; "" for the only one."""
    lines = data.decode("utf-8", errors="replace").lstrip("\ufeff").splitlines()
    if len(lines) < 5 or not lines[0].startswith("PathFileType"):
        raise CaptureError(path, "expected a TRC file, found something else. Export it again.")
    said = dict(zip(lines[1].split("\t"), lines[2].split("\t")))
    said = {key.strip(): value.strip() for key, value in said.items()}
    labels = [name.strip() for name in lines[3].rstrip().split("\t")[2::3]]
    places = _places(lines, len(labels), path)
    notes: tuple[str, ...] = ()
    stated = said.get("NumFrames", "")
    if stated.isdecimal() and int(stated) != len(places):
        notes = (f"The header says {stated} frames; there are {len(places)}.",)
    try:
        fps = float(said.get("DataRate", "").replace(",", "."))
    except ValueError:
        fps = 0.0
    tracks = [places[:, n] for n in range(len(labels))]
    read = MarkerFile(labels, tracks, fps, said.get("Units", ""), "", "y", "trc", notes)
    return read_markers(read, len(data), path, options)


def read_trc(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of a TRC file."""
    return only_performer(read_trc_takes(data, path, options), path, options)


def _places(lines: list[str], n_markers: int, path: object) -> FloatArray:
    """Return the places (frames, markers, 3) of the rows, NaN where a marker was not seen."""
    rows = []
    for number, line in enumerate(lines[4:], start=5):
        cells = line.rstrip("\r\n").split("\t")
        if not cells[0].strip().isdecimal():  # the names of columns, blank lines
            continue
        cells = [cell.strip().replace(",", ".") for cell in cells[2:]][: 3 * n_markers]
        cells += [""] * (3 * n_markers - len(cells))
        try:
            rows.append([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            wrong = next(cell for cell in cells if cell and not _is_number(cell))
            raise CaptureError(
                path, f"line {number}: expected numbers, found {quoted(wrong)}. Export it again."
            ) from None
    if not rows:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the markers again.")
    places = np.array(rows).reshape(len(rows), n_markers, 3)
    is_seen = np.isfinite(places).all(axis=2) & places.any(axis=2)
    return np.where(is_seen[..., None], places, np.nan)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
