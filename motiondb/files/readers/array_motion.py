"""Which reader reads the arrays of an .npz, .npy, .pkl or .csv file, by what they are called.

Tables (CSV) with the motion of a robot have names of columns in any order, or none.
Without names: root x y z, quaternion x y z w, joints; a number or time of the frame may stand
before. Names with angles of the root in place of a quaternion are those of BONES-SEED where places
are called translations.

Source: https://huggingface.co/datasets/unitreerobotics/LAFAN1_Retargeting_Dataset;
https://github.com/NVIDIA/soma-retargeter (robot CSV).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from motiondb.body import rotation
from motiondb.body.rates import rate_of_times
from motiondb.body.world import UPS
from motiondb.errors import CaptureError
from motiondb.files.limits import ReadOptions, SkeletonFile
from motiondb.files.readers import point_motion, robot_motion
from motiondb.files.readers.amass import is_amass, read_amass, read_poses
from motiondb.files.readers.array_files import (
    RATES,
    Arrays,
    inflated,
    load_npy,
    load_npz,
    load_pickle,
    npz_names,
)
from motiondb.files.readers.array_forms import (
    is_skeleton_motion,
    plain_form,
    read_skeleton_motion,
)
from motiondb.files.readers.first_bytes import (
    ROBOT_KEYS,
    TIMES,
    cells,
    column,
    is_model,
    is_number,
)
from motiondb.files.readers.robot_model import read_robot
from motiondb.files.readers.robot_motion import RobotFile
from motiondb.files.text import clean_bytes, decode, quoted
from motiondb.records import Clip, FloatArray

_KEYS = (*RATES, *TIMES, *ROBOT_KEYS, *point_motion.KEYS, "quaternion_order")


def array_kind(data: bytes, kind: str) -> str:
    """Return the format of a file of arrays, which its ending does not tell."""
    if data[:4] != b"PK\x03\x04":
        return kind
    try:
        names = npz_names(data, "")
    except CaptureError:
        return kind
    if is_amass(names) or not (robot_motion.is_robot(names) or point_motion.is_points(names)):
        return "amass"
    return "robot" if robot_motion.is_robot(names) else "positions"


def read_array_motion(
    data: bytes, path: Path | str, skeleton: SkeletonFile | None, options: ReadOptions
) -> Clip:
    """Read the clip in the bytes of a file of arrays; its form is known by its first bytes."""
    start = data[:6]
    if start[:4] == b"PK\x03\x04" and Path(path).suffix.lower() == ".csv":
        raise CaptureError(
            path, "expected a table as text, found a zip file (a workbook?). Export it as CSV."
        )
    if start == b"\x93NUMPY":
        arrays = load_npy(data, path)
    elif start[:4] == b"PK\x03\x04" or Path(path).suffix.lower() == ".npz":
        names = npz_names(data, path)
        if is_amass(names):
            return read_amass(data, path, options)
        _check_known(names, path)
        arrays = load_npz(data, path, _KEYS)[0]
    elif Path(path).suffix.lower() == ".pkl":
        if (whole := inflated(data, path))[:1] not in (b"\x80", b"("):  # of Python 2
            raise CaptureError(
                path,
                "expected a pickle of plain arrays, as it is or compressed by zlib or gzip, found "
                "another file. Save the arrays as npz.",
            )
        arrays = load_pickle(whole, path)
    else:
        return _robot(from_csv(data, path), path, skeleton, options, len(data))
    return _clip_of(plain_form(arrays, path), path, skeleton, options, len(data))


def _clip_of(
    arrays: Arrays,
    path: Path | str,
    skeleton: SkeletonFile | None,
    options: ReadOptions,
    n_bytes: int,
) -> Clip:
    """Return the clip of arrays under the names that others use."""
    if "up" in arrays and str(arrays["up"]) in UPS:
        options = replace(options, up=options.up or str(arrays["up"]))
    if is_skeleton_motion(arrays):
        return read_skeleton_motion(arrays, path, options, n_bytes)
    if is_amass(tuple(arrays)):
        return read_poses(arrays, tuple(arrays), path, options, n_bytes)
    _check_known(tuple(arrays), path)
    if robot_motion.is_robot(tuple(arrays)):
        said = robot_motion.from_arrays(arrays, path)
        arrays.clear()
        return _robot(said, path, skeleton, options, n_bytes)
    return _points(arrays, path, skeleton, options, n_bytes)


def _check_known(names: Sequence[str], path: object) -> None:
    """Refuse arrays by whose names no motion is known."""
    if robot_motion.is_robot(names) or point_motion.is_points(names):
        return
    found = ", ".join(quoted(name, 40) for name in sorted(names)[:20]) or "none"
    raise CaptureError(
        path,
        "expected arrays of SMPL (poses, trans), of a robot (qpos; or root_pos, root_rot and "
        f"dof_pos), or places of joints (positions), found {found}. Save them under these names.",
    )


def _robot(
    said: robot_motion.RobotFile,
    path: object,
    skeleton: SkeletonFile | None,
    options: ReadOptions,
    n_bytes: int,
) -> Clip:
    """Return the clip of a robot, whose model is the skeleton."""
    robot = None
    if skeleton is not None and is_model(skeleton.data):
        robot = read_robot(skeleton.data, skeleton.path)
        name = Path(str(skeleton.path)).name
        robot = replace(robot, name=name or robot.name)
    return robot_motion.to_clip(said, robot, path, options, n_bytes)


def _points(
    arrays: Arrays,
    path: object,
    skeleton: SkeletonFile | None,
    options: ReadOptions,
    n_bytes: int,
) -> Clip:
    """Return the clip of positions, whose names may stand in a file beside it."""
    names = None if skeleton is None or is_model(skeleton.data) else skeleton.data
    return point_motion.read_points(arrays, names, path, options, n_bytes)


_SEED_FPS = 120.0
_AS_SEED = (
    "The root has angles in place of a quaternion; the file is read as those of BONES-SEED: "
    "centimetres, degrees, turns about x, y and z of the world, 120 a second without times."
)
_MOST_OF_JOINTS, _MOST_OF_ROOT = 2.0 * np.pi, 12.0 * np.pi
"""Radians, of a hinge and of a root that turns six times: above, angles are degrees. Where joints
have degrees, so has the root."""


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
    if len(faults) > len(body) / 2:
        raise CaptureError(
            path,
            f"expected a table of a robot's motion, or of markers (Motive, Vicon), found "
            f"{len(head)} cells in its first row, and others in {len(faults)} of {len(body)}. Is "
            "it a capture?",
        )
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
        fps = rate_of_times(table[:, 0]) if low else None
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
    places, values = table[:, [root[axis] for axis in "xyz"]], table[:, joints]
    turns = table[:, [turn[axis] for axis in ("zyx" if is_euler else "wxyz")]]
    fps = rate_of_times(*times[0]) if times else None
    notes: tuple[str, ...] = ()
    if is_euler and any("translate" in name.lower() for name in names):
        turns, places, values = rotation.from_euler(turns, "ZYX"), places * 0.01, np.deg2rad(values)
        fps, notes = fps or _SEED_FPS, (_AS_SEED,)
    elif is_euler:
        turns, values, unit, of_joints = _of_angles(turns, values)
        notes = (
            "The root has angles in place of a quaternion; they are taken as roll about x, pitch "
            f"about y and yaw about z, in {unit}, those of joints in {of_joints}, and places in "
            "metres (--unit).",
        )
    if changes := [name for name, (kind, _) in zip(names, kinds) if kind == "change"]:
        notes += (f"Left out {len(changes)} columns of velocities or forces: {changes[0]}, ...",)
    return RobotFile(
        values,
        tuple(names[n] for n in joints),
        places,
        turns,
        "wxyz",
        is_said=True,
        is_table=True,
        fps=fps,
        notes=notes,
    )


def _of_angles(turns: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, str, str]:
    """Return quaternions of yaw, pitch and roll, values of joints in radians, and both units."""
    of_joints = "degrees" if np.abs(values).max(initial=0.0) > _MOST_OF_JOINTS else "radians"
    unit = "degrees" if np.abs(turns).max() > _MOST_OF_ROOT else of_joints
    degrees = turns if unit == "degrees" else np.rad2deg(turns)
    radians = values if of_joints == "radians" else np.deg2rad(values)
    return rotation.from_euler(degrees, "ZYX"), radians, unit, of_joints
