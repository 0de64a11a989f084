"""What the first bytes of a table, an array or a model tell: whether it holds motion.

The head of a motion of OpenSim (MOT, STO): its columns, and whether they are angles.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from motiondb.files.text import quoted

MODEL_ENDINGS = (".xml", ".mjcf", ".urdf")
"""Of models of robots."""
HUMANML3D_WIDTH, MOTION_X_WIDTH = 263, 322  # Numbers a frame
_ROOT_COLUMN = re.compile(
    r"^(root|base|pelvis|torso|floating_?base)?[_ .]?(joint)?[_ .]?(pos|position|translate|trans|"
    r"quat|quaternion|rot|rotation|rotate|orientation)?[_ .]?([qt]?[xyzw])$"
)
_ROOT_ANGLE = re.compile(
    r"^(?:(?:root|base|floating_?base)[_ .]?(?:rot|rpy|euler)?[_ .]?)?(roll|pitch|yaw)$"
)
_ANGLES, _LIMB = {"roll", "pitch", "yaw"}, re.compile("joint|dof|hip|knee|ankle|shoulder|elbow")
_CHANGE = re.compile(
    r"[_ ./](vel|velocity|dq|qd|qvel|acc|acceleration|tau|torque|effort|force)([_ ./][xyz])?$"
    r"|^(root|base)[_ .]?(v|w|omega|lin_?vel|ang_?vel)[_ .]?[xyz]$"
)  # Columns of what is no pose

ROOT_COLUMNS = ("root_x", "root_y", "root_z", "root_qx", "root_qy", "root_qz", "root_qw")
"""Of the tables that `export --onto` writes, before those of the joints."""
JOINTS = (
    *("joint_pos", "dof_pos", "dof_positions", "dof", "joint_angles", "joint_positions"),
    *("joint_position", "joint_pos_rad"),
)
ROOTS = (
    *("root_pos", "root_trans", "root_trans_offset", "root_positions", "base_pos", "root_pos_w"),
    *("base_position", "root_position", "root_translation", "base_trans", "base_pos_w"),
)
TURNS: Mapping[str, str] = MappingProxyType(
    {"root_rot": "xyzw", "root_quat": "", "root_rotation": "", "base_quat": ""}
    | {"root_quat_w": "wxyz", "root_orientation": "", "base_rot": "", "base_orientation": ""}
    | {"root_rotations": "", "root_ori": "", "base_quat_w": "wxyz", "root_quaternion": ""}
    | {f"{of}_quat_{order}": order for of in ("root", "base") for order in ("wxyz", "xyzw")}
)  # Name -> order of the quaternion by its format; "" where none says it
PLACES = ("body_pos_w", "body_positions", "xpos")
BODY_TURNS = ("body_quat_w", "body_rotations", "xquat")
JOINT_NAMES = ("joint_names", "dof_names", "joints_list")
BODY_NAMES = ("body_names", "link_names", "link_body_list")
WHOLES = ("qpos", "q")
TIMES = ("time", "times", "timestamps", "timestamp", "t")
ROBOT_KEYS = (
    *JOINTS,
    *ROOTS,
    *TURNS,
    *PLACES,
    *BODY_TURNS,
    *JOINT_NAMES,
    *BODY_NAMES,
    *WHOLES,
    "dt",
)
"""Names of the arrays of a robot's motion."""
_SMPL_KEYS = (
    "smpl_poses",
    "fullpose",
    "pose_aa",
    "pose_quat",
    "pose_world",
    "root_orient",
    "global_orient",
    "pose_body",
    "body_pose",
)
_POINT_KEYS = ("loop_mode", "keypoints3d", "joints_3d", "joints3d", "num_samples")
_MOTION_ARRAY = re.compile(
    "|".join(name for name in (*ROBOT_KEYS, *_SMPL_KEYS, *_POINT_KEYS) if len(name) > 3).encode()
    + rb"|[\x00-\x1f](?:joints|poses?|motion)(?:q.|\W)|rotation\W.{0,20}arr\W",
    re.DOTALL,
)
_UNITS: Mapping[str, str] = MappingProxyType(
    {"": "s", "m": "ms", "milli": "ms", "u": "us", "\u00b5": "us", "\u03bc": "us", "micro": "us"}
    | {"n": "ns", "nano": "ns"}
)  # What stands before "s" or "seconds" -> unit of times
_TIME = re.compile(
    r"^(?:time|timestamp|t|(?=seconds))(?:s?|[ _/.]*[\[(]?"
    rf"(?P<unit>{'|'.join(_UNITS)})(?:s|secs?|seconds)[\])]?)$"
)
_FRAME = re.compile(r"^(frame|index|frame_?(id|number|index)|)$")


def is_model(data: bytes) -> bool:
    """Say whether the start of a file is that of MJCF, URDF or a model of OpenSim."""
    return re.search(rb"<(mujoco|robot|OpenSimDocument)[\s>/]", data[:65536]) is not None


def is_points_shape(shape: tuple[int, ...]) -> bool:
    """Whether an array of a shape may be positions of joints over time, or HumanML3D's numbers.

    >>> is_points_shape((100, 22, 3)), is_points_shape((100, 263)), is_points_shape((100, 3))
    (True, True, False)
    """
    if len(shape) == 4 and 1 in shape[:2]:
        shape = tuple(size for at, size in enumerate(shape) if at > 1 or size > 1)
    if len(shape) == 2 or (len(shape) == 3 and shape[0] == 1 and shape[2] > 4):
        return shape[-1] in (HUMANML3D_WIDTH, MOTION_X_WIDTH)
    return len(shape) == 3 and shape[2] in (3, 4) and 11 <= shape[1] <= 1000


def is_motion_pickle(start: bytes) -> bool:
    """Say whether the start of a pickle holds names of arrays of a motion (of a robot, SMPL)."""
    return _MOTION_ARRAY.search(start) is not None


def is_marker_table(start: bytes) -> bool:
    """Say whether the start of a table is that of Motive, Vicon, Qualisys or of places of joints.

    >>> is_marker_table(b"Format Version,1.23,Take Name,a"), is_marker_table(b"file,words")
    (True, False)
    """
    text = start.removeprefix(b"\xef\xbb\xbf").lstrip()
    if _TABLE.match(text):
        places = (b"MARKER_NAMES", b"BODY_NAMES", b"SKELETON")
        return not text.startswith((b"FILE_V", b"NO_OF")) or any(key in text for key in places)
    lines = [line for line in text.decode("utf-8", "replace").splitlines() if line[:1] != "#"]
    return len(lines) > 1 and bool(joint_columns(lines[0]) or {*TIDY} <= {*cells(lines[0])})


_PLACE = re.compile(
    r"^(.+?)(?:[ _.:/|-]+(?:pos|position|loc|location|trans|translation|t|p)?[ _.:/|-]*([xyz])"
    r"|(?<=[a-z0-9])([XYZ]))(?:[ _]*[\[(]\w*[\])])?$",
    re.IGNORECASE,
)
_NO_PLACE = re.compile(
    r"rot|quat|euler|vel|acc|gyr|mag|ang|ori|force|moment|torque|conf|power|dir|eul|free|sensor",
    re.IGNORECASE,
)
_JOINTS_NEEDED = 11  # Of a body
TIDY = ("frame", "keypoint", "x", "y", "z")  # Columns of a table with a row a keypoint


def joint_columns(head: str) -> dict[str, tuple[int, int, int]]:
    """Return the joints that a line of columns names, with those of x, y and z; few are none.

    >>> joint_columns(",".join(f"joint{n} {axis}" for n in range(12) for axis in "xyz"))["joint9"]
    (27, 28, 29)
    >>> joint_columns("time,hip_x,hip_y,hip_z")
    {}
    """
    found: dict[str, dict[str, int]] = {}
    for number, name in enumerate(cells(head)):
        match = _PLACE.match(name.strip())
        if match and not _NO_PLACE.search(name):
            axis = (match[2] or match[3]).lower()
            found.setdefault(match[1].strip(), {}).setdefault(axis, number)
    joints = {n: (at["x"], at["y"], at["z"]) for n, at in found.items() if {*at} == {*"xyz"}}
    return joints if len(joints) >= _JOINTS_NEEDED else {}


def is_robot_csv(start: bytes) -> bool:
    r"""Say whether the start of a CSV file is that of a motion: numbers, or names of joints.

    >>> row = b"\n1,2,3,4,5,6,7,8"
    >>> [is_robot_csv(b"t,x,y,z,roll,pitch,yaw," + name + row) for name in (b"l_knee", b"blink")]
    [True, False]
    """
    lines = [line for line in start.decode("latin-1").splitlines() if line.strip()]
    if not lines:
        return False
    head = cells(lines[0])
    if len(head) < 8:
        return False
    if all(map(is_number, head)):
        return True
    names = [name.lower() for name in head]
    if _ANGLES & {*names} and not any(map(_LIMB.search, names)):
        return False  # places and angles of a head, a camera or a drone
    columns = {kind for kind, _ in map(column, head)}
    return {"root", "turn"} <= columns and len(lines) > 1 and all(map(is_number, cells(lines[1])))


def cells(line: str) -> list[str]:
    r"""Return the cells of a line; beside enough ; or tabs, a comma is that of decimals.

    >>> cells("x;0,5"), cells("x, 0.5"), cells("0 0.5")
    (['x', '0.5'], ['x', '0.5'], ['0', '0.5'])
    >>> cells("0.1,\t0.2"), cells("1,2,3\t")
    (['0.1', '0.2'], ['1', '2', '3'])
    """
    commas = line.count(",")
    mark = next((mark for mark in ";\t" if 2 * line.count(mark) > commas), ",")
    split = line.split(mark) if mark in line else line.split()
    parts = [cell.strip().rstrip(",").strip('"') for cell in split]
    if mark == ",":
        return parts
    points = [part.replace(",", ".", 1) for part in parts]
    return [point if is_number(point) else part for part, point in zip(parts, points)]


def is_number(cell: str) -> bool:
    """Whether a cell is a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def column(name: str) -> tuple[str, str]:
    """Return what a column holds ("root", "turn", "time", "frame", "joint" or "change"); its axis.

    Of times it says the unit: "s", "ms", "us", "ns", or "" where the name has none.

    >>> column("root_pos_x"), column("root_qw"), column("left_knee_joint"), column("root_rot_x")
    (('root', 'x'), ('turn', 'w'), ('joint', ''), ('turn', 'x'))
    >>> column("base_yaw"), column("left_knee_vel"), column("torso_yaw")
    (('turn', 'z'), ('change', ''), ('joint', ''))
    >>> column("time [ms]"), column("t_us"), column("timestamp_s"), column("times")
    (('time', 'ms'), ('time', 'us'), ('time', 's'), ('time', ''))
    """
    text = re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower().strip()
    if times := _TIME.match(text):
        return "time", _UNITS.get(times["unit"], "")
    if _FRAME.match(text):
        return "frame", ""
    if angle := _ROOT_ANGLE.match(text):
        return "turn", "xyz"[("roll", "pitch", "yaw").index(angle[1])]
    if _CHANGE.search(text):
        return "change", ""
    found = _ROOT_COLUMN.match(text)
    if found is None:
        return "joint", ""
    axis = found[4][-1]
    turned = found[4].startswith("q") or axis == "w"
    turned |= bool(found[3]) and not found[3].startswith(("pos", "trans"))
    return ("turn" if turned else "root"), axis


_TABLE = re.compile(
    rb"Format Version,|(FILE_VERSION|NO_OF_FRAMES)\t"
    rb"|(Trajectories|Devices|Model Outputs|Segments|Joints),*\s*\n\s*[0-9.]+,*\s*\n,"
    rb"|Events,*\s*\n\s*[0-9.]+,*\s*\nSubject,"
)  # How tables of markers begin
_OTHERS = (
    ("quaternion", "orientations of sensors; compute joint angles with OpenSense (IK)"),
    ("vec3", "vectors; export places of markers as TRC"),
    ("speeds", "speeds of coordinates; give their values (_q)"),
    ("velocities", "velocities; give values of coordinates (_q)"),
    ("accelerations", "accelerations; give values of coordinates (_q)"),
)  # What the header may say, and why the file is no motion
_FORCE = re.compile(
    r"force|moment|torque|grf|(^|_)cop|activation|excitation|fiber|tendon|emg|reserve|power|contact"
    r"|(^|[_.])[fmpv][xyz]\d?$|residual|work|control",
    re.IGNORECASE,
)
ANGLE = re.compile(
    r"flex|adduct|abduct|rotat|angle|tilt|_list|pelvis_t|_t[xyz]$|bend|exten|pro_?sup|hip_|knee"
    r"|ankle|elbow|shoulder|/value$|lumbar|subtalar|mtp|_dev|elv|elev|yaw|pitch|roll",
    re.IGNORECASE,
)


def is_angles(start: bytes) -> bool:
    """Say whether the start of a file may be that of coordinates."""
    header, names, _ = read_head(start.decode("latin-1").splitlines())
    return not other_kind(header, names) and any(map(ANGLE.search, names))


def read_head(lines: list[str]) -> tuple[dict[str, str], tuple[str, ...], int]:
    """Return the header, the names of the columns without time, and the first row's number."""
    header = {"": lines[0].strip()} if lines else {}
    for number, line in enumerate(lines):
        cells = cells_of(line)
        if cells and cells[0].lower() in ("time", "times", "#time"):
            return header, tuple(cells[1:]), number + 1
        key, _, value = (part.strip() for part in line.partition("="))
        if not value:
            key, _, value = line.strip().partition(" ")
        header.setdefault(key.lower(), value.strip().lower())
    return header, (), 0


def cells_of(line: str) -> list[str]:
    """Return the cells of a line, between tabs, else between spaces or commas."""
    line = line.strip(" \r\n") if "\t" in line else line.strip()
    cells = line.split("\t") if "\t" in line else re.split(r"\s*,\s*|\s+", line)
    cells = [cell.strip() for cell in cells]
    while cells and not cells[-1]:
        cells.pop()
    return cells[1:] if cells and not cells[0] else cells


def other_kind(header: Mapping[str, str], names: tuple[str, ...]) -> str:
    """Say what a file holds that are no coordinates; "" for what may be some."""
    said = f"{header.get('', '')} {header.get('datatype', '')}".lower()
    for word, what in _OTHERS:
        if word in re.split(r"[^a-z0-9]+", said):
            return what
    if any(name.endswith("_Ox") for name in names):
        return "places and angles of bodies (BodyKinematics); give values of coordinates (_q)"
    forces = [name for name in names if _FORCE.search(name)]
    values = [name for name in names if name.endswith("/value")]
    if 2 * len(forces) > len(names) and not values:
        found = some_names(forces)
        return f"forces, moments, muscles or controls ({found}); give joint angles (IK)"
    return ""


def some_names(names: tuple[str, ...] | list[str]) -> str:
    """Return the first names, and how many there are beside them."""
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(quoted(name, 60) for name in names[:4]) + more
