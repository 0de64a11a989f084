"""Reader of AMC (Acclaim motion capture): the motion of an ASF body.

A frame is its number on a line, then a line a bone: the bone's name and its degrees of freedom in
the order of the ASF. A line ``:SAMPLES-PER-SECOND`` of the header names the frame rate; without it
it is 120, as at CMU. The format has no number of frames: an incomplete last frame, as in CMU's
07_12, is left out with a note; any other fault refuses the file.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from motiondb.body import rotation
from motiondb.errors import CaptureError, suggestion
from motiondb.files.limits import (
    AS_USUAL,
    ReadOptions,
    SkeletonFile,
    check_clip_size,
    check_rate,
)
from motiondb.files.readers.asf import AcclaimBody, Bone, axis_rotation, read_asf
from motiondb.files.text import (
    CUT_SHORT,
    MAX_FAULTS,
    Faults,
    clean_bytes,
    decode,
    line_number,
    number,
    quoted,
    shorten,
)
from motiondb.records import Clip, FloatArray

DEFAULT_FPS = 120.0  # The rate of the CMU database, from which most AMC files come
_RATE = re.compile(
    r"(?im)^\s*:?(?:(?:SAMPLES|FRAMES?)[-_ ]PER[-_ ]SECOND|FRAME[-_ ]?RATE|FPS)[\s:=]+(\S+)"
)
_FRAME_NUMBER = re.compile(rb"(?m)^[ \t]*[0-9]+[ \t\r]*$")
_MORE_LINES = 400
"""Lines of the first frame that are compared beyond one for each bone, so that the faults of a
frame with blank lines and unknown bones are all listed, and a file without frame numbers does not
make the comparison endless."""

Layout = list[tuple[str, int]]  # (bone, number of values) in the order of the lines of a frame


def read_amc(
    data: bytes, path: object, asf: SkeletonFile | None, options: ReadOptions = AS_USUAL
) -> Clip:
    """Read the clip in the bytes of an AMC file and of its ASF."""
    if asf is None:
        raise CaptureError(
            path, "expected the ASF file of its body, found none. Put it beside the AMC."
        )
    body = read_asf(asf.data, asf.path, unit=options.unit)
    n_bytes = len(data)
    data = clean_bytes(data, path)
    first = _FRAME_NUMBER.search(data)
    if first is None:
        raise CaptureError(path, "expected at least 1 frame, found 0. Is this an AMC file?")
    head = decode(data[: first.start()])
    header = head.upper()
    rate = _RATE.search(head)
    stated = None if rate is None else number(rate[1])
    if rate is not None and not options.fps:
        if stated is None:
            at = head.count("\n", 0, rate.start(1)) + 1
            fault = f"expected a frame rate, found {quoted(rate[1])}. Give --fps."
            raise CaptureError(path, [(at, fault)])
        check_rate(stated, path, "SAMPLES-PER-SECOND")
    degrees = ":RADIANS" not in header and (":DEGREES" in header or body.degrees)
    line = line_number(data, first.start())
    block = data[first.start() :]
    layout = _first_layout(block, line, path, body)
    table, notes = _read_table(block, line, layout, path, options.skip_bad_frames)
    check_clip_size(len(table), len(body.bones), n_bytes, path, options.limits)
    clip = _to_clip(body, layout, table, degrees)
    return replace(clip, fps=options.fps or stated or DEFAULT_FPS, notes=body.notes + notes)


def _read_table(
    block: bytes, line: int, layout: Layout, path: object, skip_bad: bool
) -> tuple[FloatArray, tuple[str, ...]]:
    """Read the frames to keep, as a table (frames, values), and notes about the others."""
    table, numbers = _read_fast(block, layout)
    if table is not None:
        jumps = bool(np.any(np.diff(numbers) != 1))
        note = "The frame numbers have gaps; the frames are taken in order."
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
    """Read the lines of the first frame and compare them with the ASF."""
    bones = {bone.name: bone for bone in body.bones}
    counts: dict[str, int] = {}
    faults: Faults = []
    n_lines = len(bones) + _MORE_LINES
    for place, content in enumerate(block.split(b"\n", n_lines)[1:n_lines]):
        words = decode(content).split()
        if not words:
            continue
        if len(words) == 1 and _is_frame_number(words[0]):
            break
        name, at = words[0], line + place + 1
        bone = bones.get(name)
        if bone is None:
            near = suggestion(name[:40], bones) if len(faults) < MAX_FAULTS else ""
            faults.append((at, f"expected a bone of {body.name}, found {quoted(name)}.{near}"))
        elif len(words) - 1 != len(bone.dof):
            faults.append(
                (at, f"expected {_expected(bone)} as {body.name} says, found {len(words) - 1}.")
            )
        elif name in counts:
            faults.append((at, f"expected {quoted(name)} once a frame, found it twice."))
        counts.setdefault(name, len(words) - 1)
    missing = [bone.name for bone in body.bones if bone.dof and bone.name not in counts]
    if missing:
        shown = ", ".join(missing[:MAX_FAULTS]) + ", ..." * (len(missing) > MAX_FAULTS)
        faults.append((line, f"expected values for {shown} as {body.name} says, found none."))
    if faults:
        advice = "Give the ASF of the same body, or export the file again if it is cut short."
        raise CaptureError(path, [*shorten(faults), (None, advice)])
    return list(counts.items())


def _is_frame_number(word: str) -> bool:
    """Return whether a word that is alone on its line begins a frame: ASCII digits only."""
    return word.isascii() and word.isdigit()


def _expected(bone: Bone) -> str:
    """Describe the values of a bone for messages: "1 value for shin (rx)"."""
    names = " ".join(bone.dof)
    return (
        f"{len(bone.dof)} value{'s' * (len(bone.dof) != 1)} for {bone.name} ({names or 'no dof'})"
    )


def _read_fast(block: bytes, layout: Layout) -> tuple[FloatArray | None, FloatArray]:
    """Read a table (frames, values) and the frame numbers, if all frames are laid out alike.

    The table is None if a frame differs from the first or a value is not a finite number.
    """
    from motiondb.files.number_words import read_words  # compiled code

    text = np.frombuffer(block, dtype=np.uint8)
    starts, ends, values = read_words(block)
    nothing = np.zeros(0)
    stride = 1 + sum(1 + count for _, count in layout)
    if not len(starts) or len(starts) % stride:
        return None, nothing
    starts, ends = starts.reshape(-1, stride), ends.reshape(-1, stride)
    is_value, place = np.ones(stride, dtype=bool), 1
    for name, count in layout:
        expected = np.frombuffer(name.encode(), dtype=np.uint8)
        if (ends[:, place] - starts[:, place] != len(expected)).any():
            return None, nothing
        if (text[starts[:, place, None] + np.arange(len(expected))] != expected).any():
            return None, nothing
        is_value[place] = False
        place += 1 + count
    table = values.reshape(-1, stride)[:, is_value]
    return (None, nothing) if np.isnan(table).any() else (table[:, 1:], table[:, 0])


def _read_slow(block: bytes, line: int, layout: Layout) -> tuple[FloatArray, Faults]:
    """Read the good frames, and the first fault of every bad frame, line by line."""
    rows: list[list[float]] = []
    faults: Faults = []
    frames: list[tuple[int, list[tuple[int, list[str]]]]] = []
    for at, content in enumerate(decode(block).split("\n"), start=line):
        words = content.split()
        if len(words) == 1 and _is_frame_number(words[0]):
            frames.append((at, []))
        elif words and frames:
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
    """Line of the last frame if it alone has a fault, as in a file that was cut; else 0."""
    last = list(_FRAME_NUMBER.finditer(block))[-1].start()
    at = line + line_number(block, last) - 1
    return at if len(faults) == 1 and (faults[0][0] or 0) >= at else 0


def _read_frame(
    at: int, lines: list[tuple[int, list[str]]], layout: Layout
) -> tuple[list[float], tuple[int | None, str] | None]:
    """Return the values of one frame in the order of the layout, or its first fault."""
    counts, row = dict(layout), {}
    for line, words in lines:
        name, values = words[0], [number(word) for word in words[1:]]
        if name not in counts:
            return [], (
                line,
                f"expected a bone of the first frame, found {quoted(name)}. {CUT_SHORT}",
            )
        if len(values) != counts[name]:
            many = f"{counts[name]} values for {name}"
            return [], (line, f"expected {many}, found {len(values)}. {CUT_SHORT}")
        if None in values:
            bad = words[1 + values.index(None)][:20]
            return [], (
                line,
                f"expected numbers for {name}, found {bad!r}. "
                "Correct the line, or pass --skip-bad-frames to leave the frame out.",
            )
        row[name] = [value for value in values if value is not None]
    if len(row) != len(layout):
        missing = next(name for name in counts if name not in row)
        return [], (
            at,
            f"expected {len(layout)} bones in this frame, found {len(row)} "
            f"({missing} is missing). {CUT_SHORT}",
        )
    return [value for name, _ in layout for value in row[name]], None


def _to_clip(body: AcclaimBody, layout: Layout, table: FloatArray, degrees: bool) -> Clip:
    """Compute L = C R(dof) C^-1 for every bone, and the root's translation in metres."""
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
        fps=DEFAULT_FPS,
        local_rotations=rotation.normalize(rotations),
        root_positions=root_positions,
        format="amc",
        unit=body.unit,
    )
