"""Motion of a robot in the forms that its programs read: CSV of retargeted LAFAN1, and npz.

CSV: root x y z, quaternion x y z w, the joints of the model in its order; metres and radians, z up,
without a header. What the columns are, the rate and the model stand in a JSON file beside it.
npz: the arrays of BeyondMimic, mjlab and UniLab, with the names of joints and bodies, for all links
of the model in its order; quaternions w x y z.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from motiondb.body import hinges, rotation
from motiondb.body.hinges import Robot
from motiondb.files.arrays import velocities
from motiondb.files.readers.first_bytes import ROOT_COLUMNS
from motiondb.files.safe_files import output_file
from motiondb.records import FloatArray

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
    with output_file(path) as draft:
        draft.write_bytes(data.getvalue())
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
    with output_file(beside) as draft:
        draft.write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
    return beside


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
