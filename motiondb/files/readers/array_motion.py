"""Which reader reads the arrays of an .npz, .npy, .pkl or .csv file, by what they are called."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from motiondb.errors import CaptureError
from motiondb.files.limits import ReadOptions, SkeletonFile
from motiondb.files.readers import point_motion, robot_motion, robot_table
from motiondb.files.readers.amass import is_amass, read_amass, read_poses
from motiondb.files.readers.array_files import (
    RATES,
    Arrays,
    load_npy,
    load_npz,
    load_pickle,
    npz_names,
)
from motiondb.files.readers.first_bytes import ROBOT_KEYS, is_model
from motiondb.files.readers.robot_model import read_robot
from motiondb.files.text import quoted
from motiondb.records import Clip

_KEYS = (*RATES, *ROBOT_KEYS, *point_motion.KEYS, "quaternion_order")


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
        return _points({"positions": load_npy(data, path)}, path, skeleton, options, len(data))
    if start[:4] == b"PK\x03\x04" or Path(path).suffix.lower() == ".npz":
        names = npz_names(data, path)
        if is_amass(names):
            return read_amass(data, path, options)
        _check_known(names, path)
        arrays = load_npz(data, path, _KEYS)[0]
    elif start[:1] == b"\x80":
        arrays = load_pickle(data, path)
        if is_amass(tuple(arrays)):
            return read_poses(arrays, tuple(arrays), path, options, len(data))
        _check_known(tuple(arrays), path)
    elif Path(path).suffix.lower() == ".pkl":
        raise CaptureError(
            path,
            "expected a pickle of plain arrays, found a compressed or another file (joblib?). Save "
            "the arrays as npz.",
        )
    else:
        return _robot(robot_table.from_csv(data, path), path, skeleton, options, len(data))
    if robot_motion.is_robot(tuple(arrays)):
        said = robot_motion.from_arrays(arrays, path)
        arrays.clear()
        return _robot(said, path, skeleton, options, len(data))
    return _points(arrays, path, skeleton, options, len(data))


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
