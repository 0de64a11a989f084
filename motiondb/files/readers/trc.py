"""Reader of TRC: marker positions of Motion Analysis, OpenSim and Pose2Sim (:mod:`.markers`).

Five lines say what follows: the rate, the counts and the unit stand in the third, the names of the
markers in the fourth, each over three columns. A cell without a number, or 0 or 9999.99 three
times, is a marker that was not seen, as in the frames that their numbers leave out. Where
the times of the frames contradict the rate, they hold. The axis up is not in the file: y is usual.

Source: Motion Analysis, "Track Row Column (.trc) file format", as OpenSim's documentation has it.
"""

from __future__ import annotations

import numpy as np

from motiondb.body.rates import find_rate
from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, MAX_FPS, MIN_FPS, ReadOptions
from motiondb.files.readers.marker_gaps import count_notes, is_place, with_missing
from motiondb.files.readers.markers import MarkerFile, read_markers
from motiondb.files.text import quoted
from motiondb.records import Clip, FloatArray

_TIMES_WITHIN, _ROUNDED = 0.02, 0.02
"""Share by which times may miss the rate of the header, and seconds that two rounded ones may."""


def read_trc_takes(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> dict[str, Clip]:
    """Read the clip of each performer in the bytes of a TRC file; "" for the only one."""
    return read_markers(trc_markers(data, path, options), len(data), path, options)


def trc_markers(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> MarkerFile:
    """Read the markers in the bytes of a TRC file."""
    lines = data.decode("utf-8", errors="replace").lstrip("\ufeff").splitlines()
    if len(lines) < 5 or not lines[0].startswith("PathFileType"):
        raise CaptureError(path, "expected a TRC file, found something else. Export it again.")
    if "\t" not in lines[2]:
        raise CaptureError(path, "expected cells between tabs, found none. Export it with tabs.")
    said = dict(zip(lines[1].split("\t"), lines[2].split("\t")))
    said = {key.strip().lower(): value.strip() for key, value in said.items()}
    names = [name.strip() for name in lines[3].rstrip().split("\t")[2:]]
    labels = names if any(names[1::3]) else names[::3]  # some write them without blank cells
    frames, places = _places(lines, len(labels), path)
    notes = count_notes(said.get("numframes", ""), len(places))
    places, gap_notes = with_missing(frames[:, 0], places)
    fps, rate_notes = _rate(said.get("datarate", ""), frames[:, 1], len(places))
    notes += gap_notes + (rate_notes if options.fps is None else ())
    unit = said.get("units", "")
    return MarkerFile(labels, len(places), lambda n: places[:, n], fps, unit, "", "y", "trc", notes)


def _places(lines: list[str], n_markers: int, path: object) -> tuple[FloatArray, FloatArray]:
    """Return frame number and time of the rows, and the places (frames, markers, 3).

    NaN where a marker was not seen, or a time is no number.
    """
    rows = []
    for number, line in enumerate(lines[4:], start=5):
        cells = [cell.strip().replace(",", ".") for cell in line.rstrip("\r\n").split("\t")]
        if not _is_number(cells[0]):  # the names of columns, blank lines
            continue
        while len(cells) > 2 and not cells[-1]:
            cells.pop()
        n_cells = 2 + 3 * n_markers
        if len(cells) < n_cells and (len(cells) - 2) % 3:
            raise CaptureError(
                path,
                f"line {number}: expected {n_cells} cells for {n_markers} markers, found "
                f"{len(cells)}. The file may be cut short: export it again.",
            )
        cells = cells[:n_cells] + [""] * (n_cells - len(cells))
        cells[1] = cells[1] if _is_number(cells[1]) else ""
        try:
            rows.append([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            wrong = next(cell for cell in cells if cell and not _is_number(cell))
            raise CaptureError(
                path, f"line {number}: expected numbers, found {quoted(wrong)}. Export it again."
            ) from None
    if not rows:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the markers again.")
    values = np.array(rows)
    places = values[:, 2:].reshape(len(rows), n_markers, 3)
    return values[:, :2], np.where(is_place(places)[..., None], places, np.nan)


def _rate(said: str, times: FloatArray, n_frames: int) -> tuple[float, tuple[str, ...]]:
    """Return the frames per second of the times if the header says another rate, with a note."""
    fps = float(text) if _is_number(text := said.replace(",", ".")) else 0.0
    span = float(np.nan_to_num(times[-1] - times[0]))
    by_times = (n_frames - 1) / span if span > 0 else fps
    if not MIN_FPS <= by_times <= MAX_FPS or abs(by_times / (fps or np.inf) - 1.0) < (
        _TIMES_WITHIN + _ROUNDED / max(span, _ROUNDED)
    ):
        return fps, ()
    near, _ = find_rate(1.0 / by_times, f"{1.0 / by_times:.3g}")
    return near, (
        f"The header says {said or 'no'} frames a second, the times of the frames say {near:g}, "
        "which are taken. Give the right rate (--fps) if this is wrong.",
    )


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
