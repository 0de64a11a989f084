"""Motion as arrays or as a table: .npz, .csv and .parquet, for programs that compute.

Positions and velocities are in metres and metres a second, in the world frame of the clip. A table
has a row a frame: ``time``, ``JOINT.x``, ``JOINT.y``, ``JOINT.z``, ``JOINT.vx``, ``JOINT.vy``,
``JOINT.vz`` and, where the feet are known, ``left_contact`` and ``right_contact`` (0 or 1).
"""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from motiondb.body.kinematics import clip_positions
from motiondb.errors import MotionDBError
from motiondb.files.safe_files import output_file
from motiondb.files.sheet_writer import plain_cell
from motiondb.records import BoolArray, Clip, FloatArray

ARRAY_ENDINGS = (".npz", ".csv", ".parquet")
NO_PYARROW = (
    "expected the library pyarrow for Arrow tables and Parquet, found none. Install it: "
    "pip install 'motiondb[arrow]'."
)


def write_arrays(clip: Clip, path: Path, contacts: BoolArray | None = None) -> None:
    """Write positions, velocities and contacts (frames, 2: left, right) of a clip, whole."""
    positions = clip_positions(clip)[0]
    speeds = velocities(positions, clip.fps)
    times = np.arange(clip.n_frames) / clip.fps
    data = io.BytesIO()
    ending = path.suffix.lower()
    if ending == ".npz":
        found: dict[str, Any] = {}
        if contacts is not None:
            found = {"contacts": contacts, "contact_names": np.array(["left_foot", "right_foot"])}
        np.savez_compressed(
            data,
            fps=clip.fps,
            units=np.array("metres, seconds; right-handed world"),
            up=np.array("y" if contacts is not None else clip.up or "unknown"),
            quaternion_order=np.array("w, x, y, z; relative to the parent"),
            time=times,
            joints=np.array(clip.skeleton.names),
            parents=clip.skeleton.parents,
            offsets=clip.skeleton.offsets,
            positions=positions,
            velocities=speeds,
            local_rotations=clip.local_rotations,
            root_positions=clip.root_positions,
            **found,
        )
    else:
        columns = _columns(clip.skeleton.names, times, positions, speeds)
        for foot, side in enumerate(("left", "right") if contacts is not None else ()):
            columns[f"{side}_contact"] = np.asarray(contacts)[:, foot].astype(np.int64)
        if ending == ".csv":
            text = io.StringIO(newline="")
            writer = csv.writer(text, lineterminator="\n")
            writer.writerow(map(plain_cell, columns))
            writer.writerows(zip(*(column.tolist() for column in columns.values())))
            data.write(text.getvalue().encode())
        else:
            write_parquet(columns, data)
    with output_file(path) as draft:
        draft.write_bytes(data.getvalue())


def velocities(positions: FloatArray, fps: float) -> FloatArray:
    """Velocities by central differences, one-sided at both ends; shapes as `positions`.

    >>> velocities(np.array([[0.0], [1.0], [4.0]]), 10.0)[:, 0].tolist()
    [10.0, 20.0, 30.0]
    """
    if len(positions) < 2:
        return np.zeros_like(positions)
    return np.asarray(np.gradient(positions, axis=0) * fps)


def _columns(
    names: tuple[str, ...], times: FloatArray, positions: FloatArray, speeds: FloatArray
) -> dict[str, Any]:
    """The columns of a table; a joint name that stands twice gets a number."""
    columns: dict[str, Any] = {"time": times}
    for joint, name in enumerate(names):
        unique = name if names.index(name) == joint else f"{name}#{joint}"
        for values, prefix in ((positions, ""), (speeds, "v")):
            for axis, letter in enumerate("xyz"):
                columns[f"{unique}.{prefix}{letter}"] = values[:, joint, axis]
    return columns


def write_parquet(columns: dict[str, Any], data: io.BytesIO) -> None:
    """Write columns as Parquet (MotionDBError without pyarrow)."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise MotionDBError(f"parquet: {NO_PYARROW}") from None
    parquet.write_table(pa.table(columns), data)
