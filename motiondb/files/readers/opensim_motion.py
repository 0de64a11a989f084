"""Reader of OpenSim's motions (.mot, .sto): values of a model's coordinates over time.

Lines ``key=value`` (or ``key value``, of SIMM) stand before ``endheader``, then a line of names
that begins with ``time``, then rows. Names are those of coordinates, or of states
(``/jointset/hip_r/hip_flexion_r/value``). ``inDegrees`` says the unit of angles; places are metres.
Rows at uneven times are interpolated. The model is the .osim beside it: bodies become joints.

Without a model, or with one that has no whole body (no arms), there is no motion of a body: angles
are kept as series, bodies as markers. Speeds, forces, moments, muscles, controls and orientations
of sensors are refused.

Source: OpenSim's documentation, "Motion (.mot) Files" and "Storage (.sto) Files".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from motiondb.body import coordinates, hinges, rates, rotation, world
from motiondb.body.coordinates import BodyModel
from motiondb.body.joint_names import joint_map
from motiondb.errors import CaptureError, NoBodyError, SkeletonError
from motiondb.files.limits import (
    AS_USUAL,
    MAX_FPS,
    ReadOptions,
    SkeletonFile,
    check_clip_size,
    check_duration,
    check_rate,
)
from motiondb.files.readers.array_files import frames_left_out
from motiondb.files.readers.first_bytes import ANGLE, cells_of, other_kind, read_head, some_names
from motiondb.files.readers.markers import MarkerTracks
from motiondb.files.readers.opensim_model import read_osim
from motiondb.files.text import clean_bytes, decode, quoted
from motiondb.records import Clip, FloatArray

_ONE_FPS = 30.0  # Of a motion of one row
_MOST_FPS = 120.0  # To which rows at uneven times, or faster than a file may be, are interpolated
_UNEVEN = 0.25  # Share of a frame by which times may miss those of an even rate
_TOO_FAR = 2.0 * np.pi  # No joint turns by more: such values are degrees


@dataclass(frozen=True)
class MotionTable:
    """What a .mot or .sto file has."""

    header: Mapping[str, str]  # Keys in lower case; "" for the first line
    names: tuple[str, ...]  # Without time
    times: FloatArray  # (frames,), seconds
    values: FloatArray  # (frames, names)
    notes: tuple[str, ...] = ()


def read_opensim(
    data: bytes,
    path: object,
    skeleton: SkeletonFile | None = None,
    options: ReadOptions = AS_USUAL,
) -> Clip:
    """Read the clip in the bytes of a motion; NoBodyError for one that moves no whole body."""
    table = _table(data, path, options)
    if skeleton is None:
        _check_angles(table, path)
        raise NoBodyError(
            path,
            "expected the model of the motion (.osim) beside it, found no model (or several). Give "
            "one beside it, or with --skeleton.",
        )
    model, posed, fps, notes = _posed(table, skeleton, path, options, len(data))
    zeros = {name: np.zeros(1) for name, c in model.coordinates.items() if c.follows is None}
    at_rest = coordinates.pose(model, coordinates.with_followers(model, zeros, 1), 1)
    places, turns = posed
    back = np.broadcast_to(rotation.conjugate(at_rest[1]), turns.shape)
    clip = hinges.of_frames(
        tuple(link.name for link in model.links),
        np.array([link.parent for link in model.links]),
        places,
        rotation.multiply(rotation.unroll(turns), back),
        fps,
        at_rest[0][0],
        up=options.up or model.up,
    )
    try:
        joint_map(clip.skeleton)
    except SkeletonError as error:
        raise NoBodyError(
            path,
            f"expected a model of a whole body, found {quoted(model.name)} of "
            f"{len(model.links)} bodies ({_missing(str(error))}). Give a model with arms.",
        ) from None
    return replace(clip, format="opensim", notes=notes + clip.notes)


def opensim_tracks(
    data: bytes, path: object, skeleton: SkeletonFile | None, options: ReadOptions
) -> MarkerTracks:
    """Return the values of coordinates as series; with a model its bodies as markers."""
    table = _table(data, path, options)
    if skeleton is None:
        _check_angles(table, path)
        fps, values, notes = _even(table, path, options)
        unit = {"yes": "degrees", "no": "radians"}.get(table.header.get("indegrees", ""), "")
        told = f"The file says that angles are in {unit}." if unit else _NO_UNIT
        notes = (*table.notes, *notes, told)
        return MarkerTracks(table.names, values[..., None], fps, "opensim", notes)
    model, (places, _), fps, notes = _posed(table, skeleton, path, options, len(data))
    turn = world.to_y_up(options.up or model.up)
    names = tuple(link.name for link in model.links)
    return MarkerTracks(names, rotation.rotate(turn, places), fps, "opensim", notes)


_NO_UNIT = "The file does not say whether angles are degrees or radians."


def _missing(message: str) -> str:
    """Return which roles a model lacks, from the message that says so."""
    return "none for " + message.partition("joints for ")[2].partition(", found")[0]


def _posed(
    table: MotionTable, skeleton: SkeletonFile, path: object, options: ReadOptions, n_bytes: int
) -> tuple[BodyModel, coordinates.Frame, float, tuple[str, ...]]:
    """Return the model, its bodies over time, the rate and notes (CaptureError)."""
    model = read_osim(skeleton.data, skeleton.path)
    check_clip_size(len(table.times), len(model.links), n_bytes, path, options.limits)
    at = {n: k for k, n in enumerate(map(_coordinate, table.names)) if n in model.coordinates}
    if not at:
        _check_angles(table, path)
        raise CaptureError(
            path,
            f"expected coordinates of the model {quoted(model.name)}, found "
            f"{some_names(table.names)}. Give the model of this motion with --skeleton.",
        )
    fps, values, notes = _even(table, path, options)
    given = {name: values[:, column] for name, column in at.items()}
    scale, unit_notes = _degrees(table, model, given)
    given = {n: v * scale if model.coordinates[n].is_angle else v for n, v in given.items()}
    needed = [n for n, c in model.coordinates.items() if c.follows is None]
    lacking = [name for name in needed if name not in at]
    told = f"The file has no values for {some_names(lacking)}; they stay as the model has them."
    notes = (*table.notes, *notes, *unit_notes, *((told,) if lacking else ()), *model.notes)
    whole = coordinates.with_followers(model, given, len(values))
    return model, coordinates.pose(model, whole, len(values)), fps, notes


def _degrees(
    table: MotionTable, model: BodyModel, given: Mapping[str, FloatArray]
) -> tuple[float, tuple[str, ...]]:
    """Return the factor to radians, and a note where the file does not say the unit, or errs."""
    roots = {axis.coordinate for axis in model.links[0].turns}
    limbs = {n: v for n, v in given.items() if model.coordinates[n].is_angle and n not in roots}
    most = max(limbs, key=lambda name: float(np.abs(limbs[name]).max()), default="")
    reach = float(np.abs(limbs[most]).max()) if most else 0.0
    said = table.header.get("indegrees", "")
    if said == "yes" or not (said or most):
        return np.pi / 180.0, ()
    if reach > _TOO_FAR:
        told = "says that angles are in radians" if said else "does not say the unit of angles"
        return np.pi / 180.0, (
            f"The file {told}; {most} reaches {reach:.4g}, so degrees are taken.",
        )
    if said == "no":
        return 1.0, ()
    return 1.0, (
        f"{_NO_UNIT} None is beyond {reach:.3g}, so radians are taken; add inDegrees=yes to its "
        "header if this is wrong.",
    )


def _check_kind(header: Mapping[str, str], path: object) -> None:
    """Refuse a file whose header says that its values are others than coordinates."""
    if other := other_kind(header, ()):
        raise CaptureError(path, f"expected values of a model's coordinates, found {other}.")


def _check_angles(table: MotionTable, path: object) -> None:
    """Refuse a file that holds no coordinates (CaptureError)."""
    other = other_kind(table.header, table.names)
    if not other and not any(map(ANGLE.search, table.names)):
        other = (
            f"columns that are known as no coordinates ({some_names(table.names)}); give the model"
        )
    if other:
        raise CaptureError(path, f"expected values of a model's coordinates, found {other}.")


def _coordinate(name: str) -> str:
    """Return the coordinate of a column: ``/jointset/hip_r/hip_flexion_r/value`` or its name."""
    parts = name.strip("/").split("/")
    if len(parts) == 1:
        return name
    return parts[-2] if parts[-1] == "value" else ""


def _table(data: bytes, path: object, options: ReadOptions) -> MotionTable:
    """Return the rows of a file at rising times (CaptureError)."""
    lines = decode(clean_bytes(data, path)).splitlines()
    header, names, first = read_head(lines)
    if not names:
        raise CaptureError(
            path, "expected a line of names that begins with time, found none. Export it again."
        )
    _check_kind(header, path)
    twice = sorted({name for name in names if (*names, "time").count(name) > 1})
    if twice:
        raise CaptureError(
            path, f"expected every column once, found {some_names(twice)} twice. Rename them."
        )
    rows = _rows(lines, first, len(names) + 1, path)
    if not rows:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    stated = header.get("nrows", header.get("datarows", ""))
    notes: tuple[str, ...] = ()
    if stated.isdecimal() and int(stated) != len(rows):
        notes = (f"The header says {stated} rows; there are {len(rows)}.",)
    table = np.array(rows)
    good = np.isfinite(table).all(axis=1)
    notes += frames_left_out(good, path, options.skip_bad_frames, "finite numbers", "others")
    table = table[good]
    rising = np.concatenate([[True], table[1:, 0] > np.maximum.accumulate(table[:-1, 0])])
    if not rising.all():
        notes += (f"{(~rising).sum()} rows are not later than the row before; they are left out.",)
    table = table[rising]
    return MotionTable(header, names, table[:, 0], table[:, 1:], notes)


def _rows(lines: list[str], first: int, width: int, path: object) -> list[list[float]]:
    """Return the numbers of the rows; CaptureError with every row that has others."""
    rows, faults = list[list[float]](), list[tuple[int | None, str]]()
    for number, line in enumerate(lines[first:], start=first + 1):
        cells = cells_of(line)
        try:
            row = [float(cell.replace(",", ".")) for cell in cells]
        except ValueError:
            row = []
        if cells and len(row) != width:
            what = f"{len(cells)} cells" if len(cells) != width else "other text"
            faults.append((number, f"expected {width} numbers, found {what}."))
        elif cells:
            rows.append(row)
    if faults:
        raise CaptureError(path, faults[:20])
    return rows


def _even(
    table: MotionTable, path: object, options: ReadOptions
) -> tuple[float, FloatArray, tuple[str, ...]]:
    """Return the rate, and the values at even times."""
    times, values = table.times, table.values
    if len(times) < 2:
        return options.fps or _ONE_FPS, values, ()
    step = (times[-1] - times[0]) / (len(times) - 1)
    missed = np.abs(times - times[0] - step * np.arange(len(times))).max()
    if missed <= _UNEVEN * step and 1.0 / step <= MAX_FPS:
        rate = rates.find_rate(float(step), f"{step:.5f}" if step > 0.002 else "")[0]
        return options.fps or check_rate(rate, path), values, ()
    rate = float(min(_MOST_FPS, max(1.0, np.round(1.0 / np.median(np.diff(times))))))
    n_frames = int((times[-1] - times[0]) * rate + 1e-6) + 1
    check_duration(n_frames, rate, path)
    check_clip_size(n_frames, values.shape[1], values.nbytes, path, options.limits)
    grid = times[0] + np.arange(n_frames) / rate
    even = np.stack([np.interp(grid, times, column) for column in values.T], axis=1)
    why = "at uneven times" if missed > _UNEVEN * step else f"faster than {MAX_FPS:g} a second"
    told = f"Its rows are {why}; they are interpolated to {rate:g} a second."
    return options.fps or rate, even, (told,)
