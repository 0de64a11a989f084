"""BVH (Biovision hierarchy), read and written.

What is kept: names, hierarchy, offsets, end sites, channel order, every frame. What is normalised:
Euler angles become quaternions, lengths become metres (``Clip.unit`` remembers the file's unit),
a frame time within 0.01 % of a whole number of frames a second becomes that number.

Convention: channels are applied in the order in which they stand, the first outermost, so that
"Zrotation Xrotation Yrotation" means R = Rz Rx Ry. Position channels of a joint take the place of
its OFFSET (Meredith and Maddock, "Motion Capture File Formats Explained", 2001, leave this open;
Blender, MotionBuilder and the Bandai-Namco files read so); an axis without a channel keeps the
OFFSET's value. World axes are those of the file.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from motiondb.capture.bvh_header import read_header
from motiondb.capture.text import (
    Faults,
    clean_bytes,
    decode,
    line_number,
    number,
    read_number_block,
    shorten,
)
from motiondb.capture.units import find_unit
from motiondb.errors import CaptureError
from motiondb.pose import rotation
from motiondb.records import Clip, FloatArray, Skeleton

MIN_FPS, MAX_FPS = 1.0, 2000.0
"""Frame rates outside are taken for faults."""


def read_bvh(
    data: bytes,
    path: object,
    *,
    fps: float | None = None,
    unit: float | None = None,
    skip_bad_frames: bool = False,
) -> Clip:
    """The clip in the bytes of a BVH file.

    Parameters
    ----------
    data : the file's bytes.
    path : the file as messages shall name it.
    fps : frames per second, in place of what the file says.
    unit : metres per length unit; None: found from the size of the body.
    skip_bad_frames : leave out frames with wrong or unreadable values instead of refusing the file.

    Raises
    ------
    CaptureError
        with all structural faults and their lines.
    """
    data = clean_bytes(data, path)
    motion = re.search(rb"(?im)^[ \t]*MOTION[ \t\r]*$", data)
    skeleton, faults = read_header(decode(data[: motion.start()] if motion else data))
    if motion is None:
        faults.append((None, "expected a line MOTION, found none. The file may be cut short."))
        raise CaptureError(path, faults)
    n_frames, file_fps, block_start = _read_counts(data, motion.end(), fps, faults)
    if skeleton is None:
        raise CaptureError(path, faults)
    width = sum(map(len, skeleton.channels))
    if width == 0:
        faults.append((None, "expected channels in the HIERARCHY, found none: nothing moves."))
        raise CaptureError(path, faults)
    table, frame_faults = read_number_block(
        data[block_start:],
        line_number(data, block_start),
        width,
        _expected_values(skeleton),
        skip_bad_frames,
    )
    notes = []
    n_found = len(table) + len(frame_faults)
    if skip_bad_frames and frame_faults and len(table):
        first = frame_faults[0][0]
        notes.append(f"Left out {len(frame_faults)} bad frames; the first is on line {first}.")
    else:
        faults += shorten(frame_faults)
    faults += _check_frame_count(n_frames, n_found, skip_bad_frames, notes)
    if faults:
        raise CaptureError(path, faults)
    clip = _to_clip(skeleton, table, file_fps)
    return _in_metres(replace(clip, notes=tuple(notes)), unit)


def _read_counts(
    data: bytes, start: int, fps: float | None, faults: Faults
) -> tuple[int | None, float, int]:
    """Frame count, frames per second and where the numbers begin; adds faults."""
    n_frames, seconds, at_frames, at_time = None, None, None, None
    pattern = re.compile(rb"[\s]*(frames|frame[ \t]*time)[ \t]*:?[ \t]*([^\s]*)[^\n]*\n?", re.I)
    while match := pattern.match(data, start):
        line, value = line_number(data, match.start(1)), decode(match.group(2))
        if match.group(1).lower() == b"frames":
            at_frames, n_frames = line, int(value) if value.isdigit() else None
            if n_frames is None:
                faults.append((line, f"expected a number of frames, found {value!r}."))
        else:
            at_time, seconds = line, number(value)
        start = match.end()
    line = line_number(data, start)
    if at_frames is None:
        faults.append((line, "expected a line 'Frames: N', found none."))
    if fps is not None:
        return n_frames, fps, start
    if at_time is None:
        faults.append((line, "expected a line 'Frame Time: seconds', found none. Give --fps."))
    elif seconds is None or not 1 / MAX_FPS <= seconds <= 1 / MIN_FPS:
        found = "no number" if seconds is None else f"{seconds:g}"
        faults.append(
            (
                at_time,
                f"expected a frame time from {1 / MAX_FPS:g} to {1 / MIN_FPS:g} s, found {found}. "
                "Give the right frame rate with --fps.",
            )
        )
        seconds = None
    return n_frames, _whole_fps(1 / seconds) if seconds else 0.0, start


def _whole_fps(fps: float) -> float:
    """Undo the rounding of frame times such as 0.0083333 s.

    >>> _whole_fps(1 / 0.0083333), round(_whole_fps(1 / 0.0333667), 2)
    (120.0, 29.97)
    """
    return float(round(fps)) if abs(fps - round(fps)) < 1e-4 * fps else fps


def _expected_values(skeleton: Skeleton) -> str:
    """Say what a frame holds: "63 values (6 for the root, 3 for each of 19 joints)"."""
    counts = [len(names) for names in skeleton.channels]
    rest = counts[1:]
    text = f"{sum(counts)} values ({counts[0]} for the root"
    if rest and min(rest) == max(rest):
        text += f", {rest[0]} for each of {len(rest)} joints"
    elif rest:
        text += f", {sum(rest)} for {len(rest)} joints"
    return text + ")"


def _check_frame_count(
    n_frames: int | None, n_found: int, skip_bad: bool, notes: list[str]
) -> Faults:
    """Compare the header's number of frames with the file's; with ``skip_bad`` only note it."""
    if n_found == 0:
        return [(None, "expected at least 1 frame, found 0. Export the motion again.")]
    if n_frames is None or n_frames == n_found:
        return []
    if skip_bad:
        notes.append(f"The header says {n_frames} frames; the file holds {n_found}.")
        return []
    return [
        (
            None,
            f"expected {n_frames} frames as the header says, found {n_found}. The file may be cut "
            "short: export it again, or pass --skip-bad-frames to read the frames that are there.",
        )
    ]


def _to_clip(skeleton: Skeleton, table: FloatArray, fps: float) -> Clip:
    """Rotations and positions of the channel table (frames, channels), still in the file's unit."""
    n_frames, n_joints = len(table), len(skeleton.names)
    positions = np.broadcast_to(skeleton.offsets, (n_frames, n_joints, 3)).copy()
    orders: dict[str, list[tuple[int, list[int]]]] = {}
    column, moved = 0, False
    for joint, channels in enumerate(skeleton.channels):
        turns = []
        for name in channels:
            if name.endswith("position"):
                positions[:, joint, "XYZ".index(name[0])] = table[:, column]
                moved |= joint > 0
            else:
                turns.append(column)
            column += 1
        order = "".join(name[0] for name in channels if name.endswith("rotation"))
        orders.setdefault(order, []).append((joint, turns))
    rotations = np.empty((n_frames, n_joints, 4))
    for order, group in orders.items():
        joints = [joint for joint, _ in group]
        angles = table[:, np.array([turns for _, turns in group], dtype=int)]
        rotations[:, joints] = rotation.from_euler(angles, order)
    return Clip(
        skeleton=skeleton,
        fps=fps,
        local_rotations=rotations,
        root_positions=positions[:, 0].copy(),
        joint_positions=positions if moved else None,
        format="bvh",
    )


def _in_metres(clip: Clip, unit: float | None) -> Clip:
    """Scale a clip in file units; find the unit if it is not given."""
    notes: tuple[str, ...] = ()
    if unit is None:
        unit, notes = find_unit(clip.skeleton, clip.joint_positions)
    skeleton = replace(
        clip.skeleton,
        offsets=clip.skeleton.offsets * unit,
        end_sites=tuple(
            (joint, (x * unit, y * unit, z * unit)) for joint, (x, y, z) in clip.skeleton.end_sites
        ),
    )
    return replace(
        clip,
        skeleton=skeleton,
        root_positions=clip.root_positions * unit,
        joint_positions=None if clip.joint_positions is None else clip.joint_positions * unit,
        unit=unit,
        notes=clip.notes + notes,
    )
