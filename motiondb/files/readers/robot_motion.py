"""Reader of motions of robots: the pose of the root and values of hinges, in CSV, npz and pkl.

CSV of retargeted LAFAN1: root x y z, quaternion x y z w, joints in radians, 30 frames a second, no
header; or a header that names the columns. npz of BeyondMimic, mjlab, UniLab and holosoma:
``joint_pos`` and the places of all bodies (``body_pos_w``, ``body_quat_w``: w x y z); of Isaac Lab
and AMASS for G1: ``dof_positions``, ``body_positions``, ``body_rotations`` (w x y z); of MuJoCo:
``qpos`` (w x y z). pkl of GMR: ``root_pos``, ``root_rot`` (x y z w), ``dof_pos``. Metres, z up.

A motion without names has the joints in the order of its model, or, from Isaac Lab, all of one
depth after those of the depth before; which of the two is found by the places of the bodies, where
there are any. Velocities are not read. Values outside a hinge's limits are noted and kept.

Source: https://huggingface.co/datasets/unitreerobotics/LAFAN1_Retargeting_Dataset;
https://github.com/HybridRobotics/whole_body_tracking; https://github.com/YanjieZe/GMR;
https://isaac-sim.github.io/IsaacLab (motion files of direct AMP).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from motiondb.body import hinges, rotation
from motiondb.body.hinges import Robot
from motiondb.body.rates import rate_of_times
from motiondb.body.robot_names import part_of
from motiondb.errors import CaptureError, suggestion
from motiondb.files.limits import ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.array_files import (
    RATES,
    Arrays,
    as_numbers,
    frames_left_out,
    texts_of,
)
from motiondb.files.readers.first_bytes import (
    BODY_NAMES,
    BODY_TURNS,
    JOINT_NAMES,
    JOINTS,
    PLACES,
    ROOTS,
    TIMES,
    TURNS,
    WHOLES,
)
from motiondb.files.text import quoted
from motiondb.records import Clip, FloatArray

_KNOWN: Mapping[int, str] = MappingProxyType(
    {29: "Unitree's G1 (29)", 23: "Unitree's G1 (23) and Booster's T1", 19: "Unitree's H1"}
    | {27: "Unitree's H1-2", 12: "the legs of many robots", 43: "Unitree's G1 with hands"}
)  # Number of joints -> robots that have as many
DEFAULT_FPS = 30.0  # Of CSV files: that of retargeted LAFAN1
_FITS, _UPRIGHT, _LYING, _TILTS = 0.03, 0.7, 0.4, 0.05
"""Metres within which bodies are where the model has them; mean cosines with the vertical of a base
that is upright, and of one that is not; by how much it is less upright in the wrong order: there
the yaw is a tilt, so by 1 less its cosine."""
_Z = np.array([0.0, 0.0, 1.0])
_ALONG = 0.9  # Mean cosine of a base with an axis along which it stands for the whole take
_LIKE_1 = 0.001  # By which quaternions among other numbers differ from length 1 at most
_OF_LENGTH_1 = 0.05  # By which quaternions may differ from length 1 in the median
_SUFFIX = re.compile(r"(_?(joint|dof|link|pos|position|skel|angle|rad|deg|q))+$")
_PREFIX = re.compile(r"^((dof|joint|pos|position|angle|q)_)+")


@dataclass(frozen=True)
class RobotFile:
    """What a file says of a motion."""

    values: FloatArray | None = None  # (frames, joints)
    names: tuple[str, ...] = ()  # Of the joints; () where the file has none
    root: FloatArray | None = None  # (frames, 3)
    turns: FloatArray | None = None  # (frames, 4), in the order that follows
    order: str = ""  # "xyzw" or "wxyz"; "" where nothing says it
    is_said: bool = False  # Whether the file itself says the order
    bodies: FloatArray | None = None  # (frames, bodies, 3)
    body_turns: FloatArray | None = None  # (frames, bodies, 4), w x y z
    body_names: tuple[str, ...] = ()
    fps: float | None = None
    is_table: bool = False  # Whether it is CSV
    notes: tuple[str, ...] = ()


def is_robot(names: Sequence[str]) -> bool:
    """Whether arrays of these names are a motion of a robot."""
    given = {*names}
    has_joints = bool({*JOINTS, *WHOLES} & given)
    return (has_joints and bool({*ROOTS, *PLACES, *WHOLES, *TURNS} & given)) or (
        bool({*PLACES} & given) and bool({*BODY_TURNS} & given)
    )


def _divided(whole: FloatArray, path: object) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Divide the numbers of a frame into root, quaternion and joints."""
    if whole.shape[1] < 8:
        raise CaptureError(
            path, f"expected a root and joints in qpos, found {whole.shape[1]} numbers a frame."
        )
    return whole[:, :3], whole[:, 3:7], whole[:, 7:]


def from_arrays(arrays: Arrays, path: object) -> RobotFile:
    """Return what arrays by name say of a motion of a robot (CaptureError)."""

    def first(names: Sequence[str], width: int | None = None) -> FloatArray | None:
        for name in names:
            if name in arrays:
                return _numbers(arrays[name], name, width, path)
        return None

    def texts(names: Sequence[str]) -> tuple[str, ...]:
        found = next((arrays[n] for n in names if n in arrays), np.zeros(0))
        if found.dtype.kind not in "US" or found.ndim != 1:
            return ()
        return texts_of(found)

    names, bodies = texts(JOINT_NAMES), first(PLACES, 3)
    values, root = first(JOINTS), first(ROOTS, 3)
    turn_name = next((n for n in TURNS if n in arrays), "")
    turns, order = first((turn_name,), 4), TURNS.get(turn_name, "")
    if values is None:
        values = first(WHOLES)
        if values is not None and root is None and turns is None:  # else the root is not in it
            root, turns, values = _divided(values, path)
            order = "wxyz"
    if values is not None and names and values.shape[1] - len(names) in (7, 6):
        values = values[:, -len(names) :]
    if values is not None and names and len(names) == values.shape[1] + 1:
        names = names[1:]  # that of the free joint
    body_turns = first(BODY_TURNS, 4)
    said = str(arrays["quaternion_order"]) if "quaternion_order" in arrays else ""
    letters = "".join(re.findall("[wxyz]", said.split(";")[0]))
    is_said = letters in ("wxyz", "xyzw")
    return RobotFile(
        values=values,
        names=names,
        root=root,
        turns=turns,
        order=letters if is_said and turns is not None else order,
        is_said=is_said,
        bodies=bodies,
        body_turns=body_turns,
        body_names=texts(BODY_NAMES),
        fps=_rate_in(arrays),
    )


def _rate_in(arrays: Arrays) -> float | None:
    """Return the frames per second that arrays say, or the seconds of a frame (dt)."""
    for name in (*RATES, "dt"):
        rate = as_numbers(arrays[name]) if name in arrays else np.zeros(0)
        if rate.size and rate.dtype.kind in "iuf":
            number = float(rate.reshape(-1)[0])
            return number if name != "dt" else 1.0 / number if number > 0 else None
    times = next((arrays[name] for name in TIMES if name in arrays), np.zeros(0))
    return (
        rate_of_times(times.astype(float))
        if times.ndim == 1 and times.dtype.kind in "iuf"
        else None
    )


def _numbers(
    array: NDArray[np.generic], name: str, width: int | None, path: object
) -> FloatArray | None:
    """Return an array of numbers whose last axis has a width (CaptureError)."""
    if array.dtype.kind not in "iuf":
        raise CaptureError(path, f"expected numbers in {name!r}, found other values.")
    values = array.astype(np.float64)
    if name in RATES:
        return values
    if values.ndim == 3 and values.shape[1] == 1:
        values = values[:, 0]
    if name in JOINTS and values.ndim == 3 and values.shape[2] == 1:
        values = values[:, :, 0]
    wanted = 3 if name in (*PLACES, *BODY_TURNS) else 2
    if values.ndim != wanted or width not in (None, values.shape[-1]):
        last = "n" if width is None else str(width)
        shape = f"(frames, {'bodies, ' if wanted == 3 else ''}{last})"
        raise CaptureError(path, f"expected {name!r} of shape {shape}, found {values.shape}.")
    return values


# The clip


def to_clip(
    said: RobotFile, robot: Robot | None, path: object, options: ReadOptions, n_bytes: int
) -> Clip:
    """Return the clip of a motion and its model (CaptureError)."""
    n_frames = _count(said, path)
    links = len(robot.links) if robot is not None else 1
    check_clip_size(n_frames, links, n_bytes, path, options.limits)
    said, notes = _good_frames(said, path, options.skip_bad_frames)
    fps, rate_notes = _rate(said, path, options)
    if options.unit is not None and said.root is not None:
        said = replace(said, root=said.root * options.unit)
    if robot is None:
        clip = _of_bodies(said, path, fps, options)
    else:
        clip = _of_robot(said, robot, path, fps, options)
    return replace(clip, notes=said.notes + rate_notes + notes + clip.notes)


def _count(said: RobotFile, path: object) -> int:
    """Return the number of frames, the same in all arrays."""
    parts = (said.values, said.root, said.turns, said.bodies, said.body_turns)
    counts = {len(part) for part in parts if part is not None}
    if len(counts) != 1 or 0 in counts:
        raise CaptureError(
            path,
            f"expected arrays of as many frames, found {', '.join(map(str, sorted(counts)))}. "
            "Export the motion again.",
        )
    return counts.pop()


def _good_frames(
    said: RobotFile, path: object, skip_bad: bool
) -> tuple[RobotFile, tuple[str, ...]]:
    """Leave out frames that are not finite, or refuse the file."""
    parts = {
        name: part
        for name in ("values", "root", "turns", "bodies", "body_turns")
        if (part := getattr(said, name)) is not None
    }
    rows = [np.isfinite(part.reshape(len(part), -1)).all(axis=1) for part in parts.values()]
    if said.turns is not None:
        rows.append(np.linalg.norm(said.turns, axis=1) > 1e-6)
    good = np.all(rows, axis=0)
    notes = frames_left_out(good, path, skip_bad, "finite numbers and quaternions", "others")
    return replace(said, **{name: part[good] for name, part in parts.items()}), notes


def _rate(said: RobotFile, path: object, options: ReadOptions) -> tuple[float, tuple[str, ...]]:
    if options.fps:
        return options.fps, ()
    if said.fps is not None:
        return check_rate(said.fps, path), ()
    if said.is_table:
        told = f"The file has no frame rate; {DEFAULT_FPS:g} a second are taken, as in retargeted "
        return DEFAULT_FPS, (told + "LAFAN1. Give another one (--fps) if this is wrong.",)
    raise CaptureError(path, "expected a frame rate (fps), found none. Give it with --fps.")


def _of_robot(
    said: RobotFile, robot: Robot, path: object, fps: float, options: ReadOptions
) -> Clip:
    """Return the clip of a motion on its model."""
    if said.values is None:
        raise CaptureError(
            path, "expected values of joints (joint_pos, dof_pos), found none. Export them, too."
        )
    if said.bodies is not None:
        root, turns, values, notes = _by_bodies(said, robot, path)
    else:
        if said.root is None or said.turns is None:
            raise CaptureError(
                path, "expected places and turns of the root, found none. Export them, too."
            )
        said, object_notes = _behind_object(said, len(robot.free))
        values, notes = _values(said, robot, path)
        notes += object_notes
        values, unit_notes = _radians(values, robot)
        notes += unit_notes
        assert said.root is not None
        root = said.root
        turns, order_notes = _root_turns(said, path, options.up)
        notes += order_notes
    notes += () if options.up else hinges.lying_notes(turns)
    values = hinges.with_mimics(robot, values)
    posed = hinges.pose(robot, root, rotation.unroll(turns), values)
    clip = hinges.to_clip(robot, posed, fps, options.up)
    notes = robot.notes + notes + hinges.limit_notes(robot, values)
    return replace(clip, notes=notes + clip.notes)


def _radians(values: FloatArray, robot: Robot) -> tuple[FloatArray, tuple[str, ...]]:
    """Return values in radians; those that no hinge reaches are taken as degrees, with a note."""
    limited = [n for n, joint in enumerate(robot.joints) if joint.limits and not joint.slides]
    if not limited:
        return values, ()
    ends = np.array([robot.joints[n].limits or (0.0, 0.0) for n in limited])
    low, high = ends[:, 0], ends[:, 1]
    given = values[:, limited]
    beyond = float(np.maximum(low - given, given - high).max())
    fits = ((np.deg2rad(given) > low - 0.1) & (np.deg2rad(given) < high + 0.1)).mean()
    if beyond < 2.0 * np.pi or fits < 0.99:
        return values, ()
    slides = np.array([joint.slides for joint in robot.joints])
    most = float(np.abs(given).max())
    return np.where(slides, values, np.deg2rad(values)), (
        f"Values of hinges reach {most:.4g}, far beyond their limits in radians; they are taken as "
        "degrees.",
    )


def _root_turns(said: RobotFile, path: object, up: str) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the turns of the root, w x y z; where nothing says their order, the upright one.

    `up`: the axis that is up, "" for z.
    """
    assert said.turns is not None
    lengths = np.linalg.norm(said.turns, axis=1)
    if float(np.median(np.abs(lengths - 1.0))) > _OF_LENGTH_1:
        raise CaptureError(
            path,
            f"expected quaternions of length 1 as turns of the root, found lengths from "
            f"{lengths.min():.2g} to {lengths.max():.2g}. Are these other columns, or angles? "
            "Name the columns, or export quaternions.",
        )
    given = rotation.normalize(said.turns)
    each = {"wxyz": given, "xyzw": given[:, [3, 0, 1, 2]]}
    ways = {name: rotation.rotate(turns, _Z).mean(axis=0) for name, turns in each.items()}
    sign, axis = -1.0 if up[:1] == "-" else 1.0, "xyz".index(up[-1:] or "z")
    stands = {name: float(sign * way[axis]) for name, way in ways.items()}
    order = said.order or max(stands, key=lambda one: stands[one])
    other = "wxyz" if order == "xyzw" else "xyzw"
    along = float(np.abs(np.delete(ways[order], axis)).max())  # as where another axis is up
    tilts = stands[order] < stands[other] - _TILTS and stands[other] > max(_ALONG, along)
    lies = stands[order] < _LYING and stands[other] > max(_UPRIGHT, along)
    if said.order and not said.is_said and (tilts or lies):
        return each[other], (
            f"The quaternions of the root are taken as {' '.join(other)}, not as "
            f"{' '.join(order)}, as the format has them: then the robot stands more upright "
            f"({stands[other]:.2f} against {stands[order]:.2f}).",
        )
    if not said.order:
        return each[order], (
            f"The file does not say the order of quaternions; {' '.join(order)} is taken, with "
            f"which the robot is more upright ({stands[order]:.2f} against {stands[other]:.2f}).",
        )
    return each[order], ()


def _values(said: RobotFile, robot: Robot, path: object) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the values (frames, joints of the model) in the order of the model, and notes."""
    assert said.values is not None
    n_frames, width = said.values.shape
    values = np.zeros((n_frames, len(robot.joints)))
    if said.names:
        if len(said.names) != width:
            raise CaptureError(
                path, f"expected {len(said.names)} joints as there are names, found {width}."
            )
        return _by_names(said, robot, values, path)
    body = [n for n in robot.free if part_of(robot.joints[n].name)[1] or not _is_finger(robot, n)]
    choices = (
        (list(robot.free), "in the order of the model"),
        (list(range(len(robot.joints))), "in the order of the model"),
        (body, "in the order of the model, without fingers"),
    )
    for chosen, how in choices:
        if len(chosen) == width or (width - len(chosen) == 7 and said.order == "wxyz"):
            values[:, chosen] = said.values[:, : len(chosen)]
            told = f"The file names no joints; they are taken {how}."
            return values, (told, _OBJECT.format("behind"))[: 2 if len(chosen) < width else 1]
    raise CaptureError(
        path,
        f"expected {len(robot.free)} joints as the model {quoted(robot.name, 40)} has, found "
        f"{width}{_robots_of(width)}. Give the model of this robot with --skeleton.",
    )


_OBJECT = "Left out 7 numbers {} those of the robot: place and quaternion of an object."


def _behind_object(said: RobotFile, n_free: int) -> tuple[RobotFile, tuple[str, ...]]:
    """Return what is said of a robot before which an object is in qpos, and a note."""
    assert said.values is not None
    values = said.values
    if said.names or said.order != "wxyz" or values.shape[1] in (*range(8), n_free):
        return said, ()
    sizes = np.linalg.norm(values[:, 3:7], axis=1)
    if len(values) < 2 or np.abs(sizes - 1.0).max() > _LIKE_1:
        return said, ()
    robot = replace(said, root=values[:, :3], turns=values[:, 3:7], values=values[:, 7:])
    return robot, (_OBJECT.format("before"),)


def _is_finger(robot: Robot, joint: int) -> bool:
    words = ("thumb", "index", "middle", "ring", "pinky", "little", "finger", "gripper", "hand")
    return any(word in robot.joints[joint].name.lower() for word in words)


def _plain(name: str) -> str:
    text = name.lower().strip().replace("-", "_").replace(" ", "_").replace("/", "_")
    return _PREFIX.sub("", _SUFFIX.sub("", text))


def _by_names(
    said: RobotFile, robot: Robot, values: FloatArray, path: object
) -> tuple[FloatArray, tuple[str, ...]]:
    """Put values in their places by the names of their joints."""
    assert said.values is not None
    exact = {name: n for n, name in enumerate(robot.joint_names)}
    plain = {_plain(name): n for n, name in enumerate(robot.joint_names)}
    found = [exact.get(name, plain.get(_plain(name), -1)) for name in said.names]
    unknown = [name for name, n in zip(said.names, found) if n < 0]
    if unknown:
        raise CaptureError(
            path,
            f"expected joints of the model {quoted(robot.name, 40)}, found "
            f"{', '.join(quoted(name, 40) for name in unknown[:5])}"
            f"{f' and {len(unknown) - 5} more' if len(unknown) > 5 else ''}."
            f"{suggestion(unknown[0], robot.joint_names)} Give the model of this robot.",
        )
    twice = [robot.joints[n].name for n in sorted({*found}) if found.count(n) > 1]
    if twice:
        raise CaptureError(
            path, f"expected one column a joint, found several of {', '.join(twice[:5])}. Keep one."
        )
    degrees = np.array([name.lower().endswith("deg") for name in said.names])
    values[:, found] = np.where(degrees, np.deg2rad(said.values), said.values)
    left = [robot.joints[n].name for n in robot.free if n not in found]
    more = f" and {len(left) - 5} more" if len(left) > 5 else ""
    note = f"The file has no values for {', '.join(left[:5])}{more}; they are 0."
    return values, (note,) if left else ()


def _robots_of(width: int) -> str:
    """Say which robots have so many joints."""
    return f" (as many as {_KNOWN[width]})" if width in _KNOWN else ""


def _breadth_first(robot: Robot) -> list[int]:
    """Return the links in the order of Isaac Lab: by depth, then by their parents."""
    depth = np.zeros(len(robot.links), dtype=np.int64)
    order, waiting = [0], [0]
    while waiting:
        link = waiting.pop(0)
        below = [n for n, parent in enumerate(robot.parents) if parent == link]
        depth[below] = depth[link] + 1
        order += below
        waiting += below
    return order


def _by_bodies(
    said: RobotFile, robot: Robot, path: object
) -> tuple[FloatArray, FloatArray, FloatArray, tuple[str, ...]]:
    """Return root, turns, values and notes, in the order in which bodies are where they should be.

    The root is the pose of the first link in the arrays of all bodies.
    """
    assert said.bodies is not None
    assert said.values is not None
    if said.body_turns is None:
        raise CaptureError(path, "expected the turns of bodies (body_quat_w), found none.")
    moved = {joint.link for joint in robot.joints}
    breadth = _breadth_first(robot)
    in_model = list(range(len(robot.links)))
    bodies = {
        "model": [in_model, [-1, *in_model], [n for n in in_model if n in moved or n == 0]],
        "depth": [breadth, [-1, *breadth], [n for n in breadth if n in moved or n == 0]],
    }
    if said.body_names:
        known = {name: n for n, name in enumerate(robot.links)}
        named = [known.get(name, -1) for name in said.body_names]
        bodies = {"model": [named], "depth": [named]}
    fits: list[_Fit] = []
    faults = []
    for order, lists in bodies.items():
        try:
            values = _in_order(said, robot, breadth if order == "depth" else in_model, path)
        except CaptureError as error:
            faults.append(error)
            continue
        for links in lists:
            if len(links) != said.bodies.shape[1] or 0 not in links:
                continue
            fits += [_apart(said, given, robot, links, values, order) for given in ("wxyz", "xyzw")]
    if not fits and faults:
        raise faults[0]
    best = min(fits, key=lambda fit: round(fit.apart, 9), default=None)
    if best is None or best.apart > _FITS:
        what = (
            f"{said.bodies.shape[1]} bodies"
            if best is None
            else f"bodies {best.apart:.3f} m from where the model has them"
        )
        raise CaptureError(
            path,
            f"expected the bodies of the model {quoted(robot.name, 40)} ({len(robot.links)} links),"
            f" found {what}. Give the model with which the file was made (--skeleton).",
        )
    how = "the model" if best.order == "model" else "their depth, as Isaac Lab has them"
    note = (
        f"The file names no joints; they are taken in the order of {how}: then bodies are within "
        f"{1000 * best.apart:.1f} mm of the file's."
    )
    told = [] if said.names else [note]
    if best.quaternions == "xyzw":
        told.append("The quaternions of the bodies are taken as x y z w: then the bodies fit.")
    return best.root, best.turns, best.values, tuple(told)


@dataclass(frozen=True, eq=False)
class _Fit:
    """One way to take the arrays of bodies, and how far they are from where the model has them."""

    apart: float
    root: FloatArray
    turns: FloatArray
    values: FloatArray
    order: str
    quaternions: str


def _apart(
    said: RobotFile,
    quaternions: str,
    robot: Robot,
    links: Sequence[int],
    values: FloatArray,
    order: str,
) -> _Fit:
    """Return how the bodies fit the model, with quaternions in an order."""
    assert said.bodies is not None
    assert said.body_turns is not None
    at, bodies = links.index(0), said.bodies
    columns = [0, 1, 2, 3] if quaternions == "wxyz" else [3, 0, 1, 2]
    root, turn = bodies[:, at], rotation.normalize(said.body_turns[:, at][:, columns])
    posed = hinges.pose(robot, root, turn, hinges.with_mimics(robot, values))
    there = [n for n, link in enumerate(links) if link >= 0]
    apart = posed.places[:, [links[n] for n in there]] - bodies[:, there]
    size = float(np.median(np.linalg.norm(apart, axis=-1)))
    return _Fit(size, root, turn, values, order, quaternions)


def _in_order(said: RobotFile, robot: Robot, links: Sequence[int], path: object) -> FloatArray:
    """Return values whose joints come in the order of links."""
    assert said.values is not None
    values, _ = _values(replace(said, order="wxyz"), robot, path)
    if said.names or list(links) == sorted(links):
        return values
    free = robot.free
    wanted = sorted(free, key=lambda n: (links.index(robot.joints[n].link), n))
    out = np.zeros_like(values)
    if said.values.shape[1] != len(free):
        return values
    out[:, wanted] = said.values
    return out


def _of_bodies(said: RobotFile, path: object, fps: float, options: ReadOptions) -> Clip:
    """Return the clip of places and turns of bodies, without a model."""
    width = 0 if said.values is None else said.values.shape[1]
    if said.bodies is None or said.body_turns is None or not said.body_names:
        raise CaptureError(
            path,
            f"expected the model of the robot (MJCF or URDF) beside the motion, found none, or "
            f"several; the motion has {width or 'no'} joints{_robots_of(width)}. Give it with "
            "--skeleton, or in the sheet's column skeleton.",
        )
    names = said.body_names
    if len(names) != said.bodies.shape[1]:
        raise CaptureError(
            path, f"expected {len(names)} bodies as named, found {said.bodies.shape[1]}."
        )
    keep = [n for n, name in enumerate(names) if name.lower() not in ("world", "universe")]
    places, turns = said.bodies[:, keep], rotation.normalize(said.body_turns[:, keep])
    parents, order = rigid_tree(places, [names[n] for n in keep])
    labels = tuple(names[keep[n]] for n in order)
    clip = hinges.of_frames(
        labels, parents, places[:, order], turns[:, order], fps, up=options.up or "z"
    )
    note = "Without a model, the bodies hang from those to which they keep their distance."
    return replace(clip, notes=(note, *clip.notes))


_SAMPLES = 200  # Frames in which distances are compared


def rigid_tree(places: FloatArray, names: Sequence[str]) -> tuple[NDArray[np.int64], list[int]]:
    """Return parents and an order in which they come first, for points (frames, points, 3).

    The tree joins points that keep their distance, near ones first, and none of the left side to
    one of the right. The first point is the root.
    """
    from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

    some = places[np.linspace(0, len(places) - 1, min(len(places), _SAMPLES)).astype(int)]
    apart = np.linalg.norm(some[:, :, None] - some[:, None], axis=-1)
    cost = apart.std(axis=0) + 1e-3 * apart.mean(axis=0) + 1e-9
    sides = [part_of(name)[0] for name in names]
    cost += np.array([[bool(a and b and a != b) for a in sides] for b in sides])
    np.fill_diagonal(cost, 0.0)
    tree = minimum_spanning_tree(cost)
    order, above = breadth_first_order(tree, 0, directed=False)
    at = {int(point): n for n, point in enumerate(order)}
    parents = [at[int(above[p])] if above[p] >= 0 else -1 for p in order]
    return np.array(parents, dtype=np.int64), [int(p) for p in order]
