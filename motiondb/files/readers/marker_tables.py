"""Reader of tables of markers or joints that capture systems export (:mod:`.markers`).

OptiTrack Motive's CSV: a line of keys and values, rows of types, names and axes, then a row a
frame. Where it has the places of bones, these are the joints, and markers are not needed. Vicon
Nexus's CSV: the section Trajectories, with its rate below. Qualisys's TSV: a key a line, then a row
a frame. Others: columns of places that are called after joints and axes (``nose_x``, ``Hips.y``,
``LeftArm_position_z``), as FreeMoCap, Rokoko and sheets of Xsens have them. Xsens' MVNX: places of
segments a frame. Cells without a number, or one number three times, are markers that were not seen,
as in the frames that their numbers leave out. The axis up is not in these files: y is usual for
Motive, z for the others. Lost are rotations, rigid bodies, devices and events.

Source: MVN User Manual, "MVNX" (version 4); OptiTrack, "Data Export: CSV" (formats 1.2 to 1.25);
Qualisys, "Motion data (.tsv)"; Vicon Nexus, export of ASCII.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from xml.etree import ElementTree

import numpy as np

from motiondb.body import world
from motiondb.body.rates import rate_of_times
from motiondb.errors import CaptureError, NoBodyError
from motiondb.files.limits import AS_USUAL, ReadOptions, check_rate
from motiondb.files.readers.first_bytes import TIDY, cells, column, is_number, joint_columns
from motiondb.files.readers.marker_gaps import count_notes, is_place, with_missing
from motiondb.files.readers.markers import MarkerFile, read_markers, unit_of
from motiondb.files.readers.point_motion import clip_of_points
from motiondb.files.text import clean_bytes, decode, quoted, take_name
from motiondb.records import Clip, FloatArray

_TYPES = ("Marker", "Bone Marker", "Skeleton Marker", "Rigid Body Marker")
"""Columns of Motive that are markers, the seen ones before those that it expects."""
_SECTIONS = ("Devices", "Model Outputs", "Segments", "Joints", "Events")
_NAMED = "expected a table of markers (Motive's CSV, Vicon's CSV or Qualisys's TSV), found "


@dataclass(frozen=True)
class _Table:
    """What a table says."""

    labels: Sequence[str]
    places: FloatArray  # (frames, markers, 3), file units, NaN where not seen
    fps: float
    unit: str | None  # None where nothing says it
    usual_up: str
    bones: Mapping[str, Mapping[str, FloatArray]] = field(default_factory=dict)
    """Performer -> bone -> its places (frames, 3)."""
    up: str = ""  # The axis up where the format says it
    notes: tuple[str, ...] = ()


Rows = Sequence[tuple[int, Sequence[str]]]  # Number of the line, cells


def read_table_takes(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> dict[str, Clip]:
    """Read the clip of each performer in the bytes of a table; "" for the only one."""
    table = _table(data, path)
    if not table.bones:
        return read_markers(_file(table), len(data), path, options)
    clips, rate = dict[str, Clip](), options.fps or check_rate(table.fps, path)
    stated, options = options.unit, replace(options, up=options.up or table.up)
    if stated is None and table.unit is not None:
        stated = unit_of(table.unit, path)
    try:
        for who, bones in table.bones.items():
            clip, notes = _of_bones(bones, stated, rate, path, options), table.notes
            if options.unit is None and stated is not None:
                lengths = np.linalg.norm(clip.skeleton.offsets, axis=1)
                size, typical = world.body_size(clip.skeleton, lengths)
                unit, told = world.checked_unit(stated, size / stated, typical)
                notes += told
                clip = _of_bones(bones, unit, rate, path, options) if unit != stated else clip
            clips[take_name(who or "unnamed")] = replace(clip, notes=notes + clip.notes)
    except CaptureError as error:  # hands, or an animal
        try:
            return read_markers(_file(table), len(data), path, options)
        except NoBodyError:
            raise error from None
    return clips if len(clips) > 1 else dict(zip(("",), clips.values()))


def _of_bones(
    bones: Mapping[str, FloatArray],
    unit: float | None,
    rate: float,
    path: object,
    options: ReadOptions,
) -> Clip:
    """Return the clip of places of bones in a unit of so many metres; None: as legs are long."""
    points = np.stack(list(bones.values()), axis=1)
    if unit is None:
        return clip_of_points(list(bones), points, rate, options, path, "markers")
    points, in_metres = points * unit, replace(options, unit=1.0)
    clip = clip_of_points(list(bones), points, rate, in_metres, path, "markers")
    return replace(clip, unit=unit)


def table_markers(data: bytes, path: object, _options: ReadOptions = AS_USUAL) -> MarkerFile:
    """Read the markers in the bytes of a table."""
    return _file(_table(data, path))


def _file(table: _Table) -> MarkerFile:
    places = table.places
    return MarkerFile(
        table.labels,
        len(places),
        lambda n: places[:, n],
        table.fps,
        table.unit or "",
        "",
        table.usual_up,
        "markers",
        table.notes,
    )


def _table(data: bytes, path: object) -> _Table:
    """Read a table of one of the three forms (CaptureError)."""
    if data.lstrip(b"\xef\xbb\xbf \r\n").startswith((b"<?xml", b"<mvnx")):
        return _mvnx(data, path)
    lines = decode(clean_bytes(data, path)).splitlines()
    first = next((line for line in lines if line.strip()), "")
    if first.startswith("Format Version"):
        return _motive(list(enumerate(csv.reader(lines), 1)), path)
    if first.startswith("NO_OF_FRAMES") or first.startswith("FILE_VERSION"):
        return _qualisys([(n, line.split("\t")) for n, line in enumerate(lines, 1)], path)
    rows = [(n, row) for n, row in enumerate(csv.reader(lines), 1)]
    for at, (_, row) in enumerate(rows):
        if _joined(row) == "Trajectories":
            return _vicon(rows[at + 1 :], path)
    if {*TIDY} <= {*cells(first)}:
        return _tidy([(n, cells(line)) for n, line in enumerate(lines, 1) if line.strip()], path)
    if joint_columns(first):
        return _named(lines, path)
    section = first.strip(", ")
    if section in _SECTIONS:
        found = f"the section {section} alone. Export the trajectories of markers, too."
    else:
        found = "something else. Export the markers again."
    raise CaptureError(path, _NAMED + found)


_FPS = 30.0  # Of tables that tell no rate
_NO_RATE = (
    f"The table has no frame rate; {_FPS:g} frames a second are taken. Give the right one (--fps) "
    "if this is wrong.",
)


def _named(lines: Sequence[str], path: object) -> _Table:
    """Read columns that are called after joints and axes."""
    said = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    head, joints = cells(said[0][1]), joint_columns(said[0][1])
    values = _values([(n, cells(line)) for n, line in said[1:]], len(head), path)
    places = {
        name: np.where(is_place(found := values[:, list(at)])[:, None], found, np.nan)
        for name, at in joints.items()
    }
    kinds = [column(name) for name in head]
    times = [(values[:, n], unit) for n, (kind, unit) in enumerate(kinds) if kind == "time"]
    fps = rate_of_times(*times[0]) if times else None
    labels = [*places]
    every = np.stack(list(places.values()), axis=1)
    return _Table(
        labels, every, fps or _FPS, None, "y", {"": places}, notes=() if fps else _NO_RATE
    )


def _tidy(rows: Rows, path: object) -> _Table:
    """Read a row a keypoint and frame; of several models the body, of several trajectories one."""
    head = [name.strip() for name in rows[0][1]]
    at = {name: head.index(name) for name in head}
    told = [row for row in rows[1:] if len(row[1]) == len(head)]
    for name in ("model", "trajectory"):
        if name in at and told:
            said = list(dict.fromkeys(row[at[name]] for _, row in told))
            chosen = next((one for one in said if one.endswith("body")), said[0])
            told = [row for row in told if row[1][at[name]] == chosen]
    wanted = [at["frame"], *(at[axis] for axis in "xyz")]
    wanted += [at["timestamp"]] if "timestamp" in at else []
    values = _values([(n, [row[c] for c in wanted]) for n, row in told], len(wanted), path)
    frames, of_frame = np.unique(values[:, 0], return_inverse=True)
    labels = list(dict.fromkeys(row[at["keypoint"]] for _, row in told))
    columns = {label: n for n, label in enumerate(labels)}
    places = np.full((len(frames), len(labels), 3), np.nan)
    places[of_frame, [columns[row[at["keypoint"]]] for _, row in told]] = values[:, 1:4]
    times = np.full(len(frames), np.nan)
    times[of_frame] = values[:, 4] if values.shape[1] > 4 else values[:, 0]
    fps = rate_of_times(times) if values.shape[1] > 4 else None
    bones = {label: places[:, n] for n, label in enumerate(labels)}
    return _Table(
        labels, places, fps or _FPS, None, "y", {"": bones}, notes=() if fps else _NO_RATE
    )


def _mvnx(data: bytes, path: object) -> _Table:
    """Read the places of segments of each subject in Xsens' MVNX; metres, z up."""
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise CaptureError(path, "expected XML without a DOCTYPE, found one. Take it out.")
    labels, frames, rate = [""], list[str](), 0.0
    performers: dict[str, dict[str, FloatArray]] = {}
    try:
        for event, element in ElementTree.iterparse(io.BytesIO(data), ("start", "end")):
            tag = element.tag.rpartition("}")[2]
            if event == "start" and tag == "subject":
                labels, frames, rate = [], [], _number(element.get("frameRate", ""))
            elif event == "start" and tag == "segment":
                labels.append(element.get("label", ""))
            elif event == "end" and tag == "frame":
                if element.get("type", "normal") == "normal":
                    frames += [part.text or "" for part in element if part.tag.endswith("position")]
                element.clear()
            elif event == "end" and tag == "subject":
                values = np.array([text.split() for text in frames], dtype=np.float64)
                places = values.reshape(len(frames), len(labels), 3)
                who = element.get("label", "")
                performers[who] = {name: places[:, n] for n, name in enumerate(labels)}
    except (ElementTree.ParseError, ValueError) as error:
        raise CaptureError(
            path,
            f"expected Xsens' MVNX with as many places as segments, found a fault ({error}). "
            "Export it again.",
        ) from None
    if not performers or not all(len(each) and frames for each in performers.values()):
        raise CaptureError(
            path, "expected places of segments (position), found none. Export them, too."
        )
    first = next(iter(performers.values()))
    every = np.stack(list(first.values()), axis=1)
    return _Table([*first], every, rate, "m", "z", performers, "z")


def _joined(row: Sequence[str]) -> str:
    return "".join(row).strip()


def _motive(rows: Rows, path: object) -> _Table:
    """Read the columns of markers and bones of Motive's CSV."""
    keys = rows[0][1]
    said = {key.strip(): value.strip() for key, value in zip(keys[::2], keys[1::2])}
    at = next((n for n, (_, row) in enumerate(rows) if row and row[0] == "Frame"), 0)
    heads = [row for _, row in rows[1:at] if _joined(row)]
    kinds = next((row for row in heads if {*row} & {*_TYPES, "Bone", "Rigid Body"}), [])
    if at == 0 or len(heads) < 3 or not kinds:
        found = "no rows of types and names" if at else "no row that begins with Frame"
        raise CaptureError(path, f"expected Motive's CSV with its header, found {found}.")
    names, what, axes = heads[heads.index(kinds) + 1], heads[-1], rows[at][1]
    columns = [
        n
        for n in range(2, len(axes) - 2)
        if [axis.strip() for axis in axes[n : n + 3]] == ["X", "Y", "Z"]
        and what[n].strip() == "Position"
    ]
    kind = next((one for one in _TYPES if any(kinds[n] == one for n in columns)), "")
    markers = [n for n in columns if kinds[n] == kind]
    bones = [n for n in columns if kinds[n] == "Bone" and said.get("Coordinate Space") == "Global"]
    if not markers and not bones:
        alone = ", ".join(sorted({kinds[n] for n in columns})) or "none"
        raise CaptureError(
            path,
            f"expected markers, or bones in global coordinates, found {alone}. Export them, too.",
        )
    values = _values(rows[at + 1 :], len(axes), path)
    notes = count_notes(said.get("Total Exported Frames", ""), len(values))
    values, gap_notes = with_missing(values[:, 0], values)
    performers: dict[str, dict[str, FloatArray]] = {}
    for n in bones:
        who, _, bone = names[n].rpartition(":")
        performers.setdefault(who, {})[bone] = _at(values, [n])[:, 0]
    fps = said.get("Export Frame Rate") or said.get("Capture Frame Rate", "")
    return _Table(
        [names[n] for n in markers],
        _at(values, markers),
        _number(fps),
        said.get("Length Units", ""),
        "y",
        performers,
        notes=notes + gap_notes,
    )


def _vicon(rows: Rows, path: object) -> _Table:
    """Read the section Trajectories of Vicon's CSV, from the line below its name."""
    heads = [row for _, row in rows[:4]]
    if len(heads) < 4 or heads[2][:1] != ["Frame"]:
        raise CaptureError(
            path, "expected rate, names, axes and units below Trajectories, found others."
        )
    axes = [cell.strip() for cell in heads[2]]
    columns = [n for n in range(2, len(axes) - 2) if axes[n : n + 3] == ["X", "Y", "Z"]]
    names = [*heads[1], *[""] * len(axes)]
    end = next((n for n, (_, row) in enumerate(rows) if n > 4 and not _joined(row)), len(rows))
    values = _values(rows[4:end], len(axes), path)
    values, notes = with_missing(values[:, 0], values)
    unit = next((cell.strip() for cell in heads[3] if cell.strip()), "")
    labels = [names[n].strip() for n in columns]
    fps = _number("".join(heads[0]))
    return _Table(labels, _at(values, columns), fps, unit, "z", notes=notes)


def _qualisys(rows: Rows, path: object) -> _Table:
    """Read Qualisys's TSV."""
    said: dict[str, list[str]] = {}
    first = len(rows)
    for at, (_, row) in enumerate(rows):
        key = row[0].strip()  # none where the first marker was not seen
        if is_number(key.replace(",", ".")) or key == "Frame" or (not key and _joined(row)):
            first = at
            break
        said.setdefault(key, [cell.strip() for cell in row[1:]])
    labels = [label for label in said.get("MARKER_NAMES", []) if label]
    kind = "".join(said.get("DATA_INCLUDED", ["3D"])[:1])
    if not labels or kind != "3D":
        others = [key for key in ("BODY_NAMES", "SKELETON_NAME", "SKELETON") if key in said]
        found = kind if kind != "3D" else "".join(others[:1]) or "no MARKER_NAMES"
        raise CaptureError(
            path,
            f"expected places of markers in 3D with MARKER_NAMES, found {found}. Export 3D data "
            "with a header.",
        )
    has_names = first < len(rows) and rows[first][1][0].strip() == "Frame"
    rows = [(n, [cell.replace(",", ".") for cell in row]) for n, row in rows[first + has_names :]]
    numbered = 2 if has_names or (rows and len(_filled(rows[0][1])) == 3 * len(labels) + 2) else 0
    width = numbered + 3 * len(labels)
    values = _values(rows, width, path)
    notes = count_notes("".join(said.get("NO_OF_FRAMES", [])[:1]), len(values))
    if numbered:
        values, gap_notes = with_missing(values[:, 0], values)
        notes += gap_notes
    columns = list(range(numbered, width, 3))
    fps = _number("".join(said.get("FREQUENCY", [])[:1]).replace(",", "."))
    return _Table(labels, _at(values, columns), fps, "mm", "z", notes=notes)


def _filled(row: Sequence[str]) -> list[str]:
    """Return the cells of a row up to the last that is not blank."""
    cells = list(row)
    while cells and not cells[-1].strip():
        cells.pop()
    return cells


def _values(rows: Rows, width: int, path: object) -> FloatArray:
    """Return the numbers (frames, cells), NaN for blank cells; CaptureError by line."""
    found = []
    for line, row in rows:
        cells = _filled(row)[:width]
        if not cells:
            continue
        try:
            numbers = [float(cell) if cell.strip() else np.nan for cell in cells]
        except ValueError:
            wrong = next(cell for cell in cells if cell.strip() and not is_number(cell))
            told = f"line {line}: expected numbers, found {quoted(wrong, 40)}. Export it again."
            raise CaptureError(path, told) from None
        found.append(numbers + [np.nan] * (width - len(numbers)))
    if not found:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the markers again.")
    return np.array(found)


def _at(values: FloatArray, columns: Sequence[int]) -> FloatArray:
    """Return places (frames, columns, 3), NaN where they are none."""
    if not columns:
        return np.zeros((len(values), 0, 3))
    places = values[:, np.array(columns)[:, None] + np.arange(3)]
    return np.where(is_place(places)[..., None], places, np.nan)


def _number(text: str) -> float:
    return float(text) if is_number(text) else 0.0
