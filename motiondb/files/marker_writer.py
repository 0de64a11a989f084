"""Markers or series without a body as files: .trc, and arrays (.npz) or tables (.csv, .parquet).

Places are metres with y up, at the rate of the file; a marker that was not seen is an empty cell,
or NaN in arrays. The npz has ``fps``, ``units``, ``up``, ``time``, ``markers`` (names) and
``positions`` (frames, markers, 3). A table has a row a frame: ``time``, ``MARKER.x``, ``MARKER.y``,
``MARKER.z``. TRC is in millimetres, as OpenSim reads it. Series have ``series`` (names) and
``values`` (frames, series) in an npz, and a column each in tables; they are no TRC.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from motiondb.errors import QueryError
from motiondb.files.arrays import write_parquet
from motiondb.files.readers.markers import MarkerTracks
from motiondb.files.safe_files import output_file
from motiondb.files.sheet_writer import plain_cell

MARKER_ENDINGS = (".trc", ".npz", ".csv", ".parquet")


def write_markers(tracks: MarkerTracks, path: Path) -> None:
    """Write markers in the format that the ending names, whole or not at all (QueryError)."""
    ending = path.suffix.lower()
    if ending not in MARKER_ENDINGS:
        raise QueryError(
            f"{path}: expected {', '.join(MARKER_ENDINGS[:-1])} or {MARKER_ENDINGS[-1]} for "
            f"{tracks.what} without a body, found {ending or 'no ending'}."
        )
    if tracks.what == "series" and ending == ".trc":
        raise QueryError(f"{path}: expected .npz, .csv or .parquet for series, found .trc.")
    data = io.BytesIO()
    times = np.arange(len(tracks.places)) / tracks.fps
    if ending == ".npz" and tracks.what == "series":
        said: dict[str, Any] = {"fps": tracks.fps, "time": times, "series": np.array(tracks.labels)}
        np.savez_compressed(data, values=tracks.places[..., 0], **said)
    elif ending == ".npz":
        np.savez_compressed(
            data,
            fps=tracks.fps,
            units=np.array("metres, seconds; right-handed world"),
            up=np.array("y"),
            time=times,
            markers=np.array(tracks.labels),
            positions=tracks.places,
        )
    elif ending == ".trc":
        data.write(_trc(tracks, path.name).encode())
    else:
        columns: dict[str, Any] = {"time": times}
        for number, label in enumerate(tracks.labels):
            for axis, letter in enumerate(("",) if tracks.what == "series" else (".x", ".y", ".z")):
                columns[label + letter] = tracks.places[:, number, axis]
        if ending == ".parquet":
            write_parquet(columns, data)
        else:
            text = io.StringIO(newline="")
            writer = csv.writer(text, lineterminator="\n")
            writer.writerow(map(plain_cell, columns))
            rows = np.stack(list(columns.values()), axis=1).tolist()
            writer.writerows([["" if v != v else v for v in row] for row in rows])
            data.write(text.getvalue().encode())
    with output_file(path) as draft:
        draft.write_bytes(data.getvalue())


def _trc(tracks: MarkerTracks, name: str) -> str:
    """Return the text of a TRC file."""
    labels = [" ".join(label.split()) for label in tracks.labels]  # no tabs, no lines
    numbers = range(1, len(labels) + 1)
    n_frames, rate = len(tracks.places), f"{tracks.fps:.6g}"
    counts = (rate, rate, n_frames, len(labels), "mm", rate, 1, n_frames)
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame"
        "\tOrigNumFrames",
        "\t".join(map(str, counts)),
        "Frame#\tTime\t" + "\t\t\t".join(labels) + "\t\t",
        "\t\t" + "\t".join(f"X{n}\tY{n}\tZ{n}" for n in numbers),
        "",
    ]
    for frame, places in enumerate(1000.0 * tracks.places.reshape(n_frames, -1)):
        cells = ("" if v != v else f"{v:.5f}" for v in places.tolist())
        lines.append("\t".join([str(frame + 1), f"{frame / tracks.fps:.6f}", *cells]))
    return "\n".join(lines) + "\n"
