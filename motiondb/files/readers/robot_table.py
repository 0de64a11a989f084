"""Tables (CSV) with the motion of a robot: with names of columns in any order, or without.

Without names: root x y z, quaternion x y z w, joints; a number or time of the frame may stand
before. Names with angles of the root in place of a quaternion are those of BONES-SEED.

Source: https://huggingface.co/datasets/unitreerobotics/LAFAN1_Retargeting_Dataset;
https://github.com/NVIDIA/soma-retargeter (robot CSV).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from motiondb.body import rotation
from motiondb.body.world import find_rate
from motiondb.errors import CaptureError
from motiondb.files.readers.first_bytes import cells, column, is_number
from motiondb.files.readers.robot_motion import RobotFile
from motiondb.files.text import clean_bytes, decode, quoted
from motiondb.records import FloatArray

_SEED_FPS = 120.0
_SECONDS: Mapping[str, float] = MappingProxyType({"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9})
_LEAST_MS = 4.0  # A step of times without a unit above this is milliseconds: 250 frames a second
_AS_SEED = (
    "The root has angles in place of a quaternion; the file is read as those of BONES-SEED: "
    "centimetres, degrees, turns about x, y and z of the world, 120 a second without times."
)


def from_csv(data: bytes, path: object) -> RobotFile:
    """Return what a CSV file says of a motion of a robot (CaptureError)."""
    lines = decode(clean_bytes(data, path)).splitlines()
    rows = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    if not rows:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    head = cells(rows[0][1])
    names = () if all(map(is_number, head)) else tuple(head)
    body = rows[1:] if names else rows
    table = np.full((len(body), len(head)), np.nan)
    faults: list[tuple[int | None, str]] = []
    for at, (number, line) in enumerate(body):
        row = cells(line)
        if len(row) != len(head) or not all(map(is_number, row)):
            count = f"{len(row)} cells" if len(row) != len(head) else "other text"
            faults.append((number, f"expected {len(head)} numbers, found {count}. Mend the row."))
        else:
            table[at] = [float(cell) for cell in row]
    if faults:
        raise CaptureError(path, faults[:20])
    if not len(table):
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    if not names:
        if table.shape[1] < 8:
            raise CaptureError(
                path,
                "expected root x y z, quaternion x y z w and joints, found "
                f"{table.shape[1]} columns. Export the motion again.",
            )
        low = _numbered(table)
        root, turns, values = (
            table[:, low : low + 3],
            table[:, low + 3 : low + 7],
            table[:, low + 7 :],
        )
        fps = _rate_of(table[:, 0]) if low else None
        return RobotFile(values, (), root, turns, "xyzw", fps=fps, is_table=True)
    return _named_columns(table, names, path)


def _numbered(table: FloatArray) -> int:
    """Return 1 where a number or time of the frame stands before the root, else 0."""
    if table.shape[1] < 9 or len(table) < 2:
        return 0
    apart = [np.abs(np.linalg.norm(table[:, n : n + 4], axis=1) - 1.0).max() for n in (3, 4)]
    steps = np.diff(table[:, 0])
    even = steps.min() > 0 and np.ptp(steps) < 0.1 * steps.mean()
    return int(even and apart[1] < 0.01 < apart[0])


def _rate_of(times: FloatArray, unit: str = "") -> float | None:
    """Return the frames per second of times, in s or ms without a unit; None for numbers."""
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    step *= _SECONDS[unit or ("ms" if step >= _LEAST_MS else "s")]
    return find_rate(step)[0] if 1e-4 < step < 1.0 else None


def _named_columns(table: FloatArray, names: tuple[str, ...], path: object) -> RobotFile:
    """Return what named columns hold."""
    kinds = [column(name) for name in names]
    root = {axis: n for n, (kind, axis) in enumerate(kinds) if kind == "root"}
    turn = {axis: n for n, (kind, axis) in enumerate(kinds) if kind == "turn"}
    joints = [n for n, (kind, _) in enumerate(kinds) if kind == "joint"]
    placed = [f"{kind} {axis}" for kind, axis in kinds if kind in ("root", "turn")]
    if twice := sorted({one for one in placed if placed.count(one) > 1}):
        raise CaptureError(path, f"expected one column each, found several for {', '.join(twice)}.")
    is_quaternion = any(re.search("q[xyz]$|quat", names[n].lower()) for n in turn.values())
    is_euler = {*turn} == {*"xyz"} and not is_quaternion
    if {*root} != {*"xyz"} or ({*turn} != {*"wxyz"} and not is_euler):
        raise CaptureError(
            path,
            "expected columns for x, y and z of the root and w, x, y and z of its quaternion, "
            f"found {', '.join(quoted(n, 30) for n in names[:12])}. Name them root_x and root_qx.",
        )
    times = [(table[:, n], unit) for n, (kind, unit) in enumerate(kinds) if kind == "time"]
    places = table[:, [root[axis] for axis in "xyz"]]
    turns = table[:, [turn[axis] for axis in ("zyx" if is_euler else "wxyz")]]
    fps = _rate_of(*times[0]) if times else None
    notes: tuple[str, ...] = ()
    if is_euler:
        turns, places = rotation.from_euler(turns, "ZYX"), places * 0.01
        fps, notes = fps or _SEED_FPS, (_AS_SEED,)
    return RobotFile(
        np.deg2rad(table[:, joints]) if is_euler else table[:, joints],
        tuple(names[n] for n in joints),
        places,
        turns,
        "wxyz",
        is_said=True,
        is_table=True,
        fps=fps,
        notes=notes,
    )
