"""Reader of DeepMimic's text format: JSON frames of the 12-joint humanoid.

``{"Loop": ..., "Frames": [[dt, root position 3, root rotation 4, chest 4, neck 4, right hip 4,
right knee 1, right ankle 4, right shoulder 4, right elbow 1, left ... ], ...]}``: 44 numbers,
quaternions w, x, y, z in the parent's frame, knees and elbows radians about z. Metres. The world is
right-handed with x ahead, y up, z to the performer's right, so it is used unchanged; the
performer faces +x in the rest pose.

Source: Peng, Abbeel, Levine, van de Panne, "DeepMimic", ACM Transactions on Graphics 37(4), 2018;
bone lengths of its humanoid; lengths of head, hands and toes are approximate.
"""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np

from motiondb.body import rotation
from motiondb.body.rates import find_rate
from motiondb.errors import CaptureError
from motiondb.files.json_text import JSONError, parse_json
from motiondb.files.limits import AS_USUAL, MAX_FPS, MIN_FPS, ReadOptions, check_clip_size
from motiondb.files.text import MAX_DIGITS, Faults, clean_bytes, decode, shorten
from motiondb.records import Clip, FloatArray, Skeleton

_HIP, _SHOULDER = 0.084887, (-0.02405, 0.24350, 0.18311)
"""Offsets of the right hip (z) and the right shoulder in metres, from DeepMimic's humanoid3d."""


def _side(name: str, sign: float) -> tuple[tuple[str, str, tuple[float, float, float], int], ...]:
    """Return joint, parent, offset and numbers a frame of one side; ``sign`` of z, + is right."""
    x, y, z = _SHOULDER
    return (
        (f"{name}_hip", "root", (0.0, 0.0, sign * _HIP), 4),
        (f"{name}_knee", f"{name}_hip", (0.0, -0.421546, 0.0), 1),
        (f"{name}_ankle", f"{name}_knee", (0.0, -0.409870, 0.0), 4),
        (f"{name}_shoulder", "chest", (x, y, sign * z), 4),
        (f"{name}_elbow", f"{name}_shoulder", (0.0, -0.274788, 0.0), 1),
    )


_TABLE = (
    ("root", "", (0.0, 0.0, 0.0), 4),
    ("chest", "root", (0.0, 0.236151, 0.0), 4),
    ("neck", "chest", (0.0, 0.223894, 0.0), 4),
    *_side("right", 1.0),
    *_side("left", -1.0),
)
_NAMES = tuple(row[0] for row in _TABLE)
_ENDS = MappingProxyType(
    {"neck": (0.0, 0.175, 0.0), "ankle": (0.13, -0.05, 0.0), "elbow": (0.0, -0.258947, 0.0)}
)
_WIDTH = 4 + sum(row[3] for row in _TABLE)
_DEFAULT_FPS = 30.0  # The rate of DeepMimic's own motions, for files whose frames last 0 s
_UNEVEN = 0.02
"""Frames whose durations differ by more than this share are noted: more than rounding to four
digits does at any rate up to 200 frames a second."""
_MAX_BYTES = 200_000_000
"""A frame takes about 800 bytes, so that this is more than two hours at 30 frames a second. JSON
fills several times its size in memory before its content can be checked."""


def skeleton(unit: float = 1.0) -> Skeleton:
    """Return the humanoid, scaled by metres per unit."""
    ends = [
        (joint, _ENDS[name.split("_")[-1]])
        for joint, name in enumerate(_NAMES)
        if name.split("_")[-1] in _ENDS
    ]
    return Skeleton(
        names=_NAMES,
        parents=np.array([_NAMES.index(row[1]) if row[1] else -1 for row in _TABLE]),
        offsets=np.array([row[2] for row in _TABLE]) * unit,
        end_sites=tuple((joint, (x * unit, y * unit, z * unit)) for joint, (x, y, z) in ends),
    )


def read_deepmimic(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of a DeepMimic file, in metres unless told."""
    frames = _read_frames(data, path)
    check_clip_size(len(frames), len(_NAMES), len(data), path, options.limits)
    table, faults = _read_table(frames)
    if faults and not (options.skip_bad_frames and len(table)):
        raise CaptureError(path, shorten(faults))
    notes = (f"Left out {len(faults)} bad frames.",) if faults else ()
    fps, fps_notes = (options.fps, ()) if options.fps else _fps(table[:, 0], path)
    unit = 1.0 if options.unit is None else options.unit
    return Clip(
        skeleton=skeleton(unit),
        fps=fps,
        local_rotations=_rotations(table[:, 4:]),
        root_positions=table[:, 1:4] * unit,
        format="deepmimic",
        unit=unit,
        notes=notes + fps_notes,
    )


def _read_frames(data: bytes, path: object) -> list[object]:
    """Return the list "Frames" of the JSON text."""
    data = clean_bytes(data, path)
    if data.lstrip()[:1] not in (b"{", b"["):
        raise CaptureError(
            path,
            'expected JSON of DeepMimic with a list "Frames", found other text. Leave the file '
            "out, or export its motion in another format, such as BVH.",
        )
    try:
        content = parse_json(decode(data), _MAX_BYTES, _number)
    except JSONError as fault:
        advice = "The file may be cut short." if fault.line else "Export the motion again."
        raise CaptureError(path, [(fault.line, f"{fault}. {advice}")]) from None
    frames = content.get("Frames") if isinstance(content, dict) else None
    if not isinstance(frames, list):
        raise CaptureError(
            path, 'expected a list "Frames", found none. Is this a DeepMimic motion file?'
        )
    if not frames:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    return frames


def _number(text: str) -> float:
    """Return a number of the JSON; infinity, which is refused later, for one that is too long."""
    return float(text) if len(text) <= MAX_DIGITS else math.inf


def _read_table(frames: list[object]) -> tuple[FloatArray, Faults]:
    """Return a table (frames, 44) of the good frames, and the faults of the others."""
    widths = {len(frame) if isinstance(frame, list) else -1 for frame in frames}
    if len(widths) == 1 and (width := widths.pop()) not in (-1, _WIDTH):
        found = f"expected {_WIDTH} numbers a frame, as DeepMimic's humanoid has, found {width} in "
        return np.zeros((0, _WIDTH)), [
            (None, f"{found}all: the motion of another body. Export it in another format.")
        ]
    rows: list[list[float]] = []
    faults: Faults = []
    for place, frame in enumerate(frames):
        fault = _frame_fault(frame)
        if fault is None and isinstance(frame, list):
            rows.append(frame)
        else:
            advice = "Export it again, or pass --skip-bad-frames to leave it out."
            faults.append((None, f"frame {place}: {fault}. {advice}"))
    return np.array(rows, dtype=float).reshape(-1, _WIDTH), faults


def _frame_fault(frame: object) -> str | None:
    """Describe what is wrong with a frame; None for a good one."""
    if not isinstance(frame, list) or len(frame) != _WIDTH:
        shown = len(frame) if isinstance(frame, list) else "no list"
        return f"expected {_WIDTH} numbers (4, root 4, 12 joints 36), found {shown}"
    for place, value in enumerate(frame):
        if not isinstance(value, float) or not np.isfinite(value):
            shown = str(value) if isinstance(value, float | bool) else value
            shown = shown[:20] if isinstance(shown, str) else type(shown).__name__
            return f"expected finite numbers, found {shown!r} as value {place + 1}"
    column = 4
    for name, _, _, size in _TABLE:
        length = sum(value * value for value in frame[column : column + size])
        if size == 4 and not 1e-12 <= length < math.inf:
            shown = "zeros" if length < 1.0 else "numbers that are too large"
            return f"expected a quaternion for {name}, found {shown}"
        column += size
    return None


def _fps(durations: FloatArray, path: object) -> tuple[float, tuple[str, ...]]:
    """Frames per second of durations (frames,), seconds, and notes; the last is often 0."""
    good = durations[durations > 0]
    if len(good) == 0:
        return _DEFAULT_FPS, ("The frames last 0 s; 30 frames a second are taken.",)
    seconds = float(np.median(good))
    fps = 1.0 / seconds
    if not MIN_FPS <= fps <= MAX_FPS:
        raise CaptureError(
            path,
            f"expected frames of {1 / MAX_FPS:g} to {1 / MIN_FPS:g} s, found {seconds:g} s. "
            "Give the right frame rate with --fps.",
        )
    uneven = float(np.ptp(good)) > _UNEVEN / fps
    notes = ("The durations of frames differ; their median is taken.",) if uneven else ()
    return find_rate(seconds)[0], notes


def _rotations(table: FloatArray) -> FloatArray:
    """Return local rotations (frames, joints, 4) of the columns after the root's position."""
    rotations = np.empty((len(table), len(_TABLE), 4))
    column = 0
    for joint, (_, _, _, size) in enumerate(_TABLE):
        if size == 4:
            rotations[:, joint] = rotation.normalize(table[:, column : column + 4])
        else:
            rotations[:, joint] = rotation.from_axis_angle((0.0, 0.0, 1.0), table[:, column])
        column += size
    return rotations
