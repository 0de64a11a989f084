"""AMC (Acclaim motion capture): the motion of an ASF body.

A frame is its number on a line, then a line a bone: the bone's name and its degrees of freedom in
the order of the ASF. The format has no frame rate: 120 frames a second, as at CMU, unless given.
It has no number of frames either: an incomplete last frame, as in CMU's 07_12, is left out with a
note; any other fault refuses the file.
"""

from __future__ import annotations

import re

import numpy as np

from motiondb.capture.asf import AcclaimBody, Bone, axis_rotation, read_asf
from motiondb.capture.text import (
    CUT_SHORT,
    Faults,
    clean_bytes,
    decode,
    line_number,
    number,
    shorten,
)
from motiondb.errors import CaptureError, suggestion
from motiondb.pose import rotation
from motiondb.records import Clip, FloatArray

DEFAULT_FPS = 120.0
_FRAME_NUMBER = re.compile(rb"(?m)^[ \t]*\d+[ \t\r]*$")

Layout = list[tuple[str, int]]
"""(bone, number of values) in the order of the lines of a frame."""


def read_amc(
    data: bytes,
    path: object,
    asf: bytes | None,
    asf_path: object = "skeleton.asf",
    *,
    fps: float | None = None,
    unit: float | None = None,
    skip_bad_frames: bool = False,
) -> Clip:
    """The clip in the bytes of an AMC file and of its ASF.

    Parameters
    ----------
    data, asf : bytes of the motion and of the skeleton.
    path, asf_path : the files as messages shall name them.
    fps : frames per second; None: 120.
    unit : metres per length unit; None: as the ASF says.
    skip_bad_frames : leave out frames with wrong or unreadable values instead of refusing the file.

    Raises
    ------
    CaptureError
        without an ASF, with the ASF of another body, or with all structural faults and their lines.
    """
    if asf is None:
        raise CaptureError(
            path, "expected the ASF file of its body, found none. Put it beside the AMC."
        )
    body = read_asf(asf, asf_path, unit=unit)
    data = clean_bytes(data, path)
    first = _FRAME_NUMBER.search(data)
    if first is None:
        raise CaptureError(path, "expected at least 1 frame, found 0. Is this an AMC file?")
    header = decode(data[: first.start()]).upper()
    degrees = ":RADIANS" not in header and (":DEGREES" in header or body.degrees)
    line = line_number(data, first.start())
    block = data[first.start() :]
    layout = _first_layout(block, line, path, body)
    table, notes = _read_table(block, line, layout, path, skip_bad_frames)
    return _to_clip(body, layout, table, fps or DEFAULT_FPS, degrees, body.notes + notes)


def _read_table(
    block: bytes, line: int, layout: Layout, path: object, skip_bad: bool
) -> tuple[FloatArray, tuple[str, ...]]:
    """Table (frames, values) of the frames to keep, and what is to be noted about the others."""
    table, numbers = _read_fast(block, layout)
    if table is not None:
        jumps = bool(np.any(np.diff(numbers) != 1))
        note = "The frame numbers jump; the frames are taken as they come."
        return table, (note,) if jumps else ()
    table, faults = _read_slow(block, line, layout)
    if not faults:
        return table, ()
    cut = _cut_short(block, line, faults)
    if not ((skip_bad or cut) and len(table)):
        raise CaptureError(path, shorten(faults))
    if cut:
        return table, (f"The last frame (line {cut}) is incomplete and left out.",)
    first = faults[0][0]
    return table, (f"Left out {len(faults)} bad frames; the first is on line {first}.",)


def _first_layout(block: bytes, line: int, path: object, body: AcclaimBody) -> Layout:
    """The lines of the first frame, compared with the ASF."""
    bones = {bone.name: bone for bone in body.bones}
    layout: Layout = []
    faults: Faults = []
    for place, content in enumerate(block.split(b"\n", len(bones) + 400)[1 : len(bones) + 400]):
        words = decode(content).split()
        if not words:
            continue
        if len(words) == 1 and words[0].isdigit():
            break
        name, at = words[0], line + place + 1
        bone = bones.get(name)
        if bone is None:
            faults.append(
                (at, f"expected a bone of {body.name}, found {name!r}.{suggestion(name, bones)}")
            )
        elif len(words) - 1 != len(bone.dof):
            faults.append(
                (at, f"expected {_expected(bone)} as {body.name} says, found {len(words) - 1}.")
            )
        elif name in dict(layout):
            faults.append((at, f"expected {name!r} once a frame, found it twice."))
        layout.append((name, len(words) - 1))
    missing = [bone.name for bone in body.bones if bone.dof and bone.name not in dict(layout)]
    if missing:
        faults.append(
            (line, f"expected values for {', '.join(missing)} as {body.name} says, found none.")
        )
    if faults:
        advice = "Give the ASF of the same body, or export the file again if it is cut short."
        raise CaptureError(path, [*shorten(faults), (None, advice)])
    return layout


def _expected(bone: Bone) -> str:
    names = " ".join(bone.dof)
    return (
        f"{len(bone.dof)} value{'s' * (len(bone.dof) != 1)} for {bone.name} ({names or 'no dof'})"
    )


def _read_fast(block: bytes, layout: Layout) -> tuple[FloatArray | None, FloatArray]:
    """Table (frames, values) and frame numbers, if every frame is laid out like the first."""
    tokens = block.split()
    nothing = np.zeros(0)
    stride = 1 + sum(1 + count for _, count in layout)
    if len(tokens) % stride:
        return None, nothing
    columns, place = [0], 1
    for name, count in layout:
        if set(tokens[place::stride]) != {name.encode()}:
            return None, nothing
        columns += range(place + 1, place + 1 + count)
        place += 1 + count
    try:
        table = np.array([tokens[column::stride] for column in columns], dtype=float).T
    except ValueError:
        return None, nothing
    if not np.isfinite(table).all():
        return None, nothing
    return np.ascontiguousarray(table[:, 1:]), table[:, 0]


def _read_slow(block: bytes, line: int, layout: Layout) -> tuple[FloatArray, Faults]:
    """The good frames and the first fault of every bad frame, line by line."""
    rows: list[list[float]] = []
    faults: Faults = []
    frames: list[tuple[int, list[tuple[int, list[str]]]]] = []
    for at, content in enumerate(decode(block).split("\n"), start=line):
        words = content.split()
        if len(words) == 1 and words[0].isdigit():
            frames.append((at, []))
        elif words:
            frames[-1][1].append((at, words))
    for at, lines in frames:
        row, fault = _read_frame(at, lines, layout)
        if fault is not None:
            faults.append(fault)
        else:
            rows.append(row)
    width = sum(count for _, count in layout)
    return np.array(rows, dtype=float).reshape(-1, width), faults


def _cut_short(block: bytes, line: int, faults: Faults) -> int:
    """The line of the last frame if it alone has a fault, as in a file that was cut; else 0."""
    last = list(_FRAME_NUMBER.finditer(block))[-1].start()
    at = line + line_number(block, last) - 1
    return at if len(faults) == 1 and (faults[0][0] or 0) >= at else 0


def _read_frame(
    at: int, lines: list[tuple[int, list[str]]], layout: Layout
) -> tuple[list[float], tuple[int | None, str] | None]:
    """Values of one frame in the order of the layout, or its first fault."""
    counts, found = dict(layout), {}
    for line, words in lines:
        name, values = words[0], [number(word) for word in words[1:]]
        if name not in counts:
            return [], (line, f"expected a bone of the first frame, found {name!r}. {CUT_SHORT}")
        if len(values) != counts[name]:
            many = f"{counts[name]} values for {name}"
            return [], (line, f"expected {many}, found {len(values)}. {CUT_SHORT}")
        if None in values:
            bad = words[1 + values.index(None)][:20]
            return [], (
                line,
                f"expected numbers for {name}, found {bad!r}. "
                "Mend the line, or pass --skip-bad-frames to leave the frame out.",
            )
        found[name] = [value for value in values if value is not None]
    if len(found) != len(layout):
        missing = next(name for name in counts if name not in found)
        return [], (
            at,
            f"expected {len(layout)} bones in this frame, found {len(found)} "
            f"({missing} is missing). {CUT_SHORT}",
        )
    return [value for name, _ in layout for value in found[name]], None


def _to_clip(
    body: AcclaimBody,
    layout: Layout,
    table: FloatArray,
    fps: float,
    degrees: bool,
    notes: tuple[str, ...],
) -> Clip:
    """L = C R(dof) C^-1 for every bone; the root's translation in metres."""
    numbers = {bone.name: joint for joint, bone in enumerate(body.bones)}
    rotations = np.tile(rotation.IDENTITY, (len(table), len(body.bones), 1))
    root_positions = np.tile(body.root_position, (len(table), 1))
    column = 0
    for name, count in layout:
        joint = numbers[name]
        bone, axes = body.bones[joint], body.axes[joint]
        values = dict(zip(bone.dof, table[:, column : column + count].T))
        column += count
        order = [axis for axis in bone.order if f"r{axis.lower()}" in values]
        if order:
            angles = np.stack([values[f"r{axis.lower()}"] for axis in order], axis=-1)
            turn = axis_rotation(angles, "".join(order), degrees)
            rotations[:, joint] = rotation.multiply(
                rotation.multiply(axes, turn), rotation.conjugate(axes)
            )
        for number_of_axis, axis in enumerate("xyz"):
            if f"t{axis}" in values:
                root_positions[:, number_of_axis] += values[f"t{axis}"] * body.unit
    return Clip(
        skeleton=body.skeleton,
        fps=fps,
        local_rotations=rotation.normalize(rotations),
        root_positions=root_positions,
        format="amc",
        unit=body.unit,
        notes=notes,
    )
