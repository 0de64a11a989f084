"""Motion as arrays or as a table: .npz, .csv, .parquet and .trc, for programs that compute.

Of bodies: positions and velocities are in metres and metres a second, in the world frame of the
clip. A table has a row a frame: ``time``, ``JOINT.x``, ``JOINT.y``, ``JOINT.z``, ``JOINT.vx``,
``JOINT.vy``, ``JOINT.vz`` and, where the feet are known, ``left_contact`` and ``right_contact`` (0
or 1).

Of robots, in the forms that their programs read: CSV of retargeted LAFAN1, and npz.
CSV: root x y z, quaternion x y z w, the joints of the model in its order; metres and radians, z up,
without a header. What the columns are, the rate and the model stand in a JSON file beside it.
npz: the arrays of BeyondMimic, mjlab and UniLab, with the names of joints and bodies, for all links
of the model in its order; quaternions w x y z.

Of markers or series without a body: .trc, and arrays (.npz) or tables (.csv, .parquet).
Places are metres with y up, at the rate of the file; a marker that was not seen is an empty cell,
or NaN in arrays. The npz has ``fps``, ``units``, ``up``, ``time``, ``markers`` (names) and
``positions`` (frames, markers, 3). A table has a row a frame: ``time``, ``MARKER.x``, ``MARKER.y``,
``MARKER.z``. TRC is in millimetres, as OpenSim reads it. Series have ``series`` (names) and
``values`` (frames, series) in an npz, and a column each in tables; they are no TRC.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from motiondb.body import hinges, rotation
from motiondb.body.hinges import Robot
from motiondb.body.kinematics import clip_positions
from motiondb.errors import MotionDBError, QueryError
from motiondb.files.readers.first_bytes import ROOT_COLUMNS
from motiondb.files.readers.markers import MarkerTracks
from motiondb.files.safe_files import write_bytes
from motiondb.files.sheet_writer import plain_cell
from motiondb.files.text import csv_bytes
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
            rows = zip(*(column.tolist() for column in columns.values()))
            data.write(csv_bytes([map(plain_cell, columns), *rows]))
        else:
            write_parquet(columns, data)
    write_bytes(path, data.getvalue())


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


ROBOT_ENDINGS = (".csv", ".npz")


def write_robot(
    path: Path, robot: Robot, fps: float, root: FloatArray, turns: FloatArray, values: FloatArray
) -> Path | None:
    """Write a motion: `root` (frames, 3), `turns` (frames, 4), `values` (frames, joints), z up.

    Returns the file beside it that says what its columns are.
    """
    joints = [robot.joint_names[number] for number in robot.free]
    data = io.BytesIO()
    if path.suffix.lower() == ".npz":
        posed = hinges.pose(robot, root, turns, values)
        np.savez_compressed(data, **_arrays(robot, fps, posed, values[:, robot.free]))
    else:
        table = np.concatenate([root, turns[:, [1, 2, 3, 0]], values[:, robot.free]], axis=1)
        np.savetxt(data, table, delimiter=",", fmt="%.6f")
    write_bytes(path, data.getvalue())
    if path.suffix.lower() == ".npz":
        return None
    beside = path.with_suffix(".json")
    said = {  # formats.with_rate_beside reads it
        "fps": fps,
        "up": "z",
        "units": "metres, radians",
        "quaternion_order": "x, y, z, w",
        "model": robot.name,
        "columns": [*ROOT_COLUMNS, *joints],
    }
    return write_bytes(beside, f"{json.dumps(said, indent=1)}\n".encode())


def _arrays(robot: Robot, fps: float, posed: hinges.Posed, values: FloatArray) -> dict[str, Any]:
    """Return the arrays of an npz file."""
    turns = rotation.unroll(posed.turns)
    spins = np.zeros_like(posed.places)
    if len(turns) > 1:
        steps = rotation.log(rotation.multiply(turns[1:], rotation.conjugate(turns[:-1]))) * fps
        spins = np.concatenate([steps[:1], (steps[1:] + steps[:-1]) / 2.0, steps[-1:]])
    return {
        "fps": np.array([fps]),
        "joint_pos": values.astype(np.float32),
        "joint_vel": velocities(values, fps).astype(np.float32),
        "body_pos_w": posed.places.astype(np.float32),
        "body_quat_w": turns.astype(np.float32),
        "body_lin_vel_w": velocities(posed.places, fps).astype(np.float32),
        "body_ang_vel_w": spins.astype(np.float32),
        "joint_names": np.array([robot.joint_names[number] for number in robot.free]),
        "body_names": np.array(robot.links),
        "quaternion_order": np.array("w, x, y, z"),
        "up": np.array("z"),
        "model": np.array(robot.name),
    }


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
            rows = np.stack(list(columns.values()), axis=1).tolist()
            cells = [["" if v != v else v for v in row] for row in rows]
            data.write(csv_bytes([map(plain_cell, columns), *cells]))
    write_bytes(path, data.getvalue())


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
