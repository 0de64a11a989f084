"""Reader of BVH (Biovision hierarchy).

What is kept: names, hierarchy, offsets, end sites, channel order, every frame. What is normalised:
Euler angles become quaternions, lengths become metres (``Clip.unit`` remembers the file's unit),
a frame time within 0.01 % of a whole number of frames a second becomes that number.

Convention: channels are applied in the order in which they are listed, the first outermost, so that
"Zrotation Xrotation Yrotation" means R = Rz Rx Ry. Position channels of a joint take the place of
its OFFSET (Meredith and Maddock, "Motion Capture File Formats Explained", 2001, leave this open;
Blender, MotionBuilder and the Bandai-Namco files read so); an axis without a channel keeps the
OFFSET's value. World axes are those of the file.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from motiondb.body import rotation
from motiondb.errors import CaptureError
from motiondb.files.limits import MAX_FPS, MIN_FPS, ReadOptions, check_clip_size
from motiondb.files.readers.bvh_header import read_header
from motiondb.files.text import (
    Faults,
    clean_bytes,
    decode,
    line_number,
    number,
    quoted,
    read_number_block,
    shorten,
    whole_number,
)
from motiondb.files.units import find_unit, scaled
from motiondb.records import Clip, FloatArray, Skeleton

MAX_HEADER = 10_000_000
"""Bytes of the HIERARCHY part that are read. A joint takes about 150 bytes, so that this is room
for more joints than any limit allows."""


def read_bvh(data: bytes, path: object, options: ReadOptions | None = None) -> Clip:
    """Read the clip in the bytes of a BVH file."""
    options = options or ReadOptions()
    n_bytes = len(data)
    data = clean_bytes(data, path)
    motion = re.search(rb"(?im)^[ \t]*MOTION[ \t\r]*$", data)
    header = data[: motion.start()] if motion else data
    if len(header) > MAX_HEADER:
        raise CaptureError(
            path,
            f"expected a HIERARCHY of at most {MAX_HEADER} bytes before a line MOTION, found "
            f"{len(header)} bytes. Is this a BVH file?",
        )
    skeleton, faults = read_header(decode(header))
    if motion is None:
        faults.append((None, "expected a line MOTION, found none. The file may be cut short."))
        raise CaptureError(path, shorten(faults))
    n_frames, file_fps, block_start = _read_counts(data, motion.end(), options.fps, faults)
    if skeleton is None:
        raise CaptureError(path, shorten(faults))
    width = sum(map(len, skeleton.channels))
    if width == 0:
        faults.append((None, "expected channels in the HIERARCHY, found none: nothing moves."))
        raise CaptureError(path, shorten(faults))
    table, frame_faults = read_number_block(
        data[block_start:],
        line_number(data, block_start),
        width,
        _expected_values(skeleton),
        options.skip_bad_frames,
    )
    notes: list[str] = []
    n_present = len(table) + len(frame_faults)
    if options.skip_bad_frames and frame_faults and len(table):
        first = frame_faults[0][0]
        notes.append(f"Left out {len(frame_faults)} bad frames; the first is on line {first}.")
    else:
        faults += shorten(frame_faults)
    faults += _check_frame_count(n_frames, n_present, options.skip_bad_frames, notes)
    if faults:
        raise CaptureError(path, faults)
    check_clip_size(len(table), len(skeleton.names), n_bytes, path, options.limits)
    clip = _to_clip(skeleton, table, file_fps)
    return _in_metres(replace(clip, notes=tuple(notes)), options.unit)


_COUNT_LINE = re.compile(rb"[\s]*(frames|frame[ \t]*time)[ \t]*:?[ \t]*([^\s]*)[^\n]*\n?", re.I)


def _read_counts(
    data: bytes, start: int, fps: float | None, faults: Faults
) -> tuple[int | None, float, int]:
    """Read the lines ``Frames:`` and ``Frame Time:``; add faults."""
    lines: dict[bytes, tuple[int, str]] = {}
    while match := _COUNT_LINE.match(data, start):
        kind = b"frames" if match.group(1).lower() == b"frames" else b"time"
        line = line_number(data, match.start(1))
        if kind in lines:
            what = "Frames" if kind == b"frames" else "Frame Time"
            faults.append((line, f"expected one line '{what}', found a second."))
            break
        lines[kind] = (line, decode(match.group(2)))
        start = match.end()
    line = line_number(data, start)
    n_frames = None
    if b"frames" not in lines:
        faults.append((line, "expected a line 'Frames: N', found none."))
    else:
        at, text = lines[b"frames"]
        n_frames = whole_number(text)
        if n_frames is None:
            faults.append((at, f"expected a number of frames, found {quoted(text)}."))
    if fps is None:
        fps = _read_frame_time(lines.get(b"time"), line, faults)
    return n_frames, fps, start


def _read_frame_time(written: tuple[int, str] | None, line: int, faults: Faults) -> float:
    """Return the frames per second of a frame time (line, text); 0 if there is a fault."""
    if written is None:
        faults.append((line, "expected a line 'Frame Time: seconds', found none. Give --fps."))
        return 0.0
    at, text = written
    seconds = number(text)
    if seconds is None or not 1 / MAX_FPS <= seconds <= 1 / MIN_FPS:
        shown = "no number" if seconds is None else f"{seconds:g}"
        faults.append(
            (
                at,
                f"expected a frame time from {1 / MAX_FPS:g} to {1 / MIN_FPS:g} s, found {shown}. "
                "Give the right frame rate with --fps.",
            )
        )
        return 0.0
    return _whole_fps(1 / seconds)


def _whole_fps(fps: float) -> float:
    """Undo the rounding of frame times such as 0.0083333 s.

    A rate within 0.01 % of a whole number becomes that number: frame times are written with five
    digits or more, and 29.97 lies ten times as far from 30.

    >>> _whole_fps(1 / 0.0083333), round(_whole_fps(1 / 0.0333667), 2)
    (120.0, 29.97)
    """
    return float(round(fps)) if abs(fps - round(fps)) < 1e-4 * fps else fps


def _expected_values(skeleton: Skeleton) -> str:
    """Describe a frame for messages: "63 values (6 for the root, 3 for each of 19 joints)"."""
    counts = [len(names) for names in skeleton.channels]
    rest = counts[1:]
    text = f"{sum(counts)} values ({counts[0]} for the root"
    if rest and min(rest) == max(rest):
        text += f", {rest[0]} for each of {len(rest)} joints"
    elif rest:
        text += f", {sum(rest)} for {len(rest)} joints"
    return text + ")"


def _check_frame_count(
    n_frames: int | None, n_present: int, skip_bad: bool, notes: list[str]
) -> Faults:
    """Compare the header's number of frames with the file's; with ``skip_bad`` only note it."""
    if n_present == 0:
        return [(None, "expected at least 1 frame, found 0. Export the motion again.")]
    if n_frames is None or n_frames == n_present:
        return []
    if skip_bad:
        notes.append(f"The header says {n_frames} frames; the file holds {n_present}.")
        return []
    return [
        (
            None,
            f"expected {n_frames} frames as the header says, found {n_present}. The file may be "
            "cut short: export it again, or pass --skip-bad-frames to read the frames that are "
            "there.",
        )
    ]


def _to_clip(skeleton: Skeleton, table: FloatArray, fps: float) -> Clip:
    """Turn the channel table (frames, channels) into a clip that is still in the file's unit."""
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
    """Scale a clip in file units to metres; estimate the unit if it is not given."""
    notes: tuple[str, ...] = ()
    if unit is None:
        unit, notes = find_unit(clip.skeleton, clip.joint_positions)
    return replace(
        clip,
        skeleton=scaled(clip.skeleton, unit),
        root_positions=clip.root_positions * unit,
        joint_positions=None if clip.joint_positions is None else clip.joint_positions * unit,
        unit=unit,
        notes=clip.notes + notes,
    )
