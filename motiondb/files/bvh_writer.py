"""Writer of BVH: a clip on its own skeleton, with its own channels and unit.

Joints are written depth first. A joint keeps the channels of ``Skeleton.channels``; it gets
position channels where it moves, and always three rotation channels, since programs refuse fewer. A
root with position channels has the OFFSET 0 0 0, since some programs add the positions to it. A
leaf without an end site gets one at distance 0, as the format requires. Of the angles that
represent a rotation, those nearest to the frame before are written, so that programs that
interpolate do not spin. Resolution: 1e-6 degrees and 1e-8 m.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from motiondb.body import rotation
from motiondb.body.retarget import to_clip
from motiondb.errors import CaptureError
from motiondb.files.safe_files import whole_file
from motiondb.records import Clip, FloatArray, Motion, Skeleton

DEFAULT_ORDER = "ZYX"
_DEFAULT = tuple(f"{axis}rotation" for axis in DEFAULT_ORDER)
_CLOSE = 1e-7
"""Metres below which a joint counts as not moved, and the sine of half the angle below which two
rotations count as equal: both below the resolution that is written."""


def write_bvh(motion: Clip | Motion, path: str | Path) -> None:
    """Write a clip or a motion as BVH; the file appears whole or not at all.

    Parameters
    ----------
    motion : Clip or Motion
        A clip is written in its own unit; a motion on the canonical body in the performer's size,
        30 frames a second.
    path : str or Path
        The file.

    Raises
    ------
    MotionDBError
        When it has no frames or numbers that are not finite, or the file cannot be written.
    """
    write_atomically(Path(path), to_bvh(to_clip(motion), path).encode())


def to_bvh(clip: Clip, path: object = "clip") -> str:
    """Return the text of a BVH file."""
    check_clip(clip, path)
    translations = local_places(clip)
    order = _depth_first(clip.skeleton)
    chosen = {joint: _channels(clip, translations, joint) for joint, _ in order}
    decimals = max(2, math.ceil(8 + math.log10(clip.unit) - 1e-9))
    lines = ["HIERARCHY", *_hierarchy(clip, order, chosen, decimals)]
    lines += ["MOTION", f"Frames: {clip.n_frames}", f"Frame Time: {1.0 / clip.fps:.10g}"]
    names = [name for joint, _ in order for name in chosen[joint][0]]
    table = np.concatenate([chosen[joint][1] for joint, _ in order], axis=1)
    digits = [decimals if name.endswith("position") else 6 for name in names]
    table = np.round(table, np.max(digits, initial=6)) + 0.0
    row_format = " ".join(f"%.{n}f" for n in digits)
    lines += [row_format % tuple(row) for row in table.tolist()]
    return "\n".join(lines) + "\n"


def write_atomically(path: Path, data: bytes) -> None:
    """Write to another name in same folder, then rename, so that the file is never incomplete."""
    try:
        with whole_file(path) as draft:
            draft.write_bytes(data)
    except OSError as error:
        expected = "to write the file" if path.parent.is_dir() else "a folder to write in"
        reason = error.strerror or error
        raise CaptureError(path, f"expected {expected}, found {reason}.") from error


def check_clip(clip: Clip, path: object) -> None:
    """Refuse clips without frames and numbers that are not finite (CaptureError)."""
    if clip.n_frames == 0:
        raise CaptureError(path, "expected at least 1 frame to write, found 0.")
    if not (np.isfinite(clip.local_rotations).all() and np.isfinite(local_places(clip)).all()):
        raise CaptureError(path, "expected finite numbers to write, found NaN or infinity.")


def local_places(clip: Clip) -> FloatArray:
    """Return every joint's place in its parent's frame: array (frames, joints, 3), metres."""
    shape = (clip.n_frames, len(clip.skeleton.names), 3)
    source = clip.skeleton.offsets if clip.joint_positions is None else clip.joint_positions
    places = np.broadcast_to(source, shape).copy()
    places[:, 0] = clip.root_positions
    return places


def _depth_first(skeleton: Skeleton) -> list[tuple[int, int]]:
    """Return (joint, depth) in the order in which BVH lists them."""
    children: dict[int, list[int]] = {}
    for joint, parent in enumerate(skeleton.parents.tolist()):
        children.setdefault(parent, []).append(joint)
    order, stack = [], [(0, 0)]
    while stack:
        joint, depth = stack.pop()
        order.append((joint, depth))
        stack += [(child, depth + 1) for child in reversed(children.get(joint, []))]
    return order


def _channels(
    clip: Clip, translations: FloatArray, joint: int
) -> tuple[tuple[str, ...], FloatArray]:
    """Names of a joint's channels, and values (frames, channels) in file units and degrees."""
    declared = _declared_channels(clip, translations, joint)
    order = "".join(name[0] for name in declared if name.endswith("rotation"))
    angles = _smooth(rotation.to_euler(clip.local_rotations[:, joint], order))
    columns, turn = [], 0
    for name in declared:
        if name.endswith("position"):
            columns.append(translations[:, joint, "XYZ".index(name[0])] / clip.unit)
        else:
            columns.append(angles[:, turn])
            turn += 1
    return declared, np.array(columns).reshape(len(columns), clip.n_frames).T


def _declared_channels(clip: Clip, translations: FloatArray, joint: int) -> tuple[str, ...]:
    """Return the channels of a joint: three rotations, and all positions where it moves."""
    positions = tuple(f"{axis}position" for axis in "XYZ")
    declared = clip.skeleton.channels[joint] if clip.skeleton.channels else ()
    turns = [name[0] for name in declared if name.endswith("rotation")]
    kept = [*turns, *(axis for axis in DEFAULT_ORDER if axis not in turns)]
    missing = [f"{axis}rotation" for axis in kept[len(turns) :]]
    if len(kept) != 3:  # an axis twice
        declared, missing = tuple(c for c in declared if c in positions), list(_DEFAULT)
    axes = "".join(name[0] for name in declared if name.endswith("position"))
    moved = np.abs(translations[:, joint] - clip.skeleton.offsets[joint]).max(axis=0) > _CLOSE
    if joint == 0 and not clip.skeleton.channels:
        moved[:] = True
    if any(moved["XYZ".index(axis)] and axis not in axes for axis in "XYZ") and len(axes) < 3:
        declared = (*positions, *(name for name in declared if name.endswith("rotation")))
    return (*declared, *missing)


def _smooth(angles: FloatArray) -> FloatArray:
    """Return angles (frames, n), degrees, of the same rotations that change least between frames.

    (a, b, c) and (a + 180, 180 - b, c + 180) are one rotation. Exchanging one form for the other
    preserves distances, so a frame takes another form than its predecessor exactly where the
    computed angles of the two are farther apart than with one of them exchanged.
    """
    if angles.shape[1] == 3:
        other = angles * [1.0, -1.0, 1.0] + 180.0
        stay = np.abs(_half_turn(angles[1:] - angles[:-1])).max(axis=1)
        change = np.abs(_half_turn(other[1:] - angles[:-1])).max(axis=1)
        changed = np.cumsum(np.append(False, change < stay)) % 2 == 1
        angles = np.where(changed[:, None], other, angles)
    return np.asarray(np.unwrap(angles, axis=0, period=360.0))


def _half_turn(degrees: FloatArray) -> FloatArray:
    """Return the same angles from -180 to 180 degrees."""
    return (degrees + 180.0) % 360.0 - 180.0


def _hierarchy(
    clip: Clip,
    order: list[tuple[int, int]],
    chosen: dict[int, tuple[tuple[str, ...], FloatArray]],
    decimals: int,
) -> list[str]:
    """Return the lines of the HIERARCHY part after its first."""
    ends: dict[int, list[tuple[float, float, float]]] = {}
    for joint, offset in clip.skeleton.end_sites:
        ends.setdefault(joint, []).append(offset)
    parents = set(clip.skeleton.parents.tolist())
    lines: list[str] = []
    for place, (joint, depth) in enumerate(order):
        tab, names = "\t" * depth, chosen[joint][0]
        lines += [f"{tab}{'JOINT' if depth else 'ROOT'} {clip.skeleton.names[joint]}", f"{tab}{{"]
        start = clip.skeleton.offsets[joint]
        if not depth and {"Xposition", "Yposition", "Zposition"} <= set(names):
            start = 0.0 * start
        lines.append(f"{tab}\tOFFSET {_numbers(start, clip.unit, decimals)}")
        lines.append(f"{tab}\tCHANNELS {' '.join([str(len(names)), *names])}")
        for offset in ends.get(joint, [] if joint in parents else [(0.0, 0.0, 0.0)]):
            text = _numbers(np.array(offset), clip.unit, decimals)
            lines += [f"{tab}\tEnd Site", f"{tab}\t{{", f"{tab}\t\tOFFSET {text}", f"{tab}\t}}"]
        next_depth = order[place + 1][1] if place + 1 < len(order) else 0
        lines += ["\t" * level + "}" for level in range(depth, next_depth - 1, -1)]
    return lines


def _numbers(vector: FloatArray, unit: float, decimals: int) -> str:
    """Write a vector in metres in the file's unit; no negative zeros."""
    return " ".join(
        f"{round(value / unit, decimals) + 0.0:.{decimals}f}" for value in vector.tolist()
    )
