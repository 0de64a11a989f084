"""Which reader reads a capture, and what every clip must fulfil.

Every reader turns bytes into a :class:`Clip`; paths serve for messages only, so that a capture can
be read again from the bytes that the store keeps. :func:`read_capture_bytes` is the boundary to
untrusted data: any exception of a reader that is not an error of this project becomes one here.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body.joint_names import mirror_joints
from motiondb.body.kinematics import as_asked
from motiondb.body.world import asked_unit_notes
from motiondb.errors import CaptureError
from motiondb.files.folder import (
    CAPTURE_ENDINGS,
    FORMATS,
    OTHER_FORMATS,
    TAKE_ENDINGS,
    WITH_TAKES,
    skeleton_path,
)
from motiondb.files.json_text import JSONError, parse_json
from motiondb.files.limits import (
    AS_USUAL,
    MAX_FPS,
    MIN_FPS,
    ReadOptions,
    SkeletonFile,
    check_clip_size,
    check_duration,
    check_file_size,
    check_options,
    guarded,
)
from motiondb.files.readers.first_bytes import is_marker_table
from motiondb.files.safe_files import is_file, open_file
from motiondb.files.text import clean_bytes, decode, quoted
from motiondb.records import Clip, Event

if TYPE_CHECKING:
    from motiondb.files.readers.markers import MarkerTracks

_MAX_BESIDE = 1_000_000  # Bytes of a JSON beside a table
_MAX_FIRST = 100_000  # Bytes of a table in which its header stands
_BESIDE = {"fps", "up", "units", "quaternion_order", "model", "columns"}  # What ours says
_OF_MARKERS = ("c3d", "trc", "markers")
_UNIT_LENGTH = 1e-3
"""How far the square of a quaternion's length may be from 1. Normalised ones are within 1e-15; a
larger difference comes from numbers that overflowed."""


def capture_format(path: Path | str) -> str:
    """Return the format that a file's ending names.

    >>> capture_format("walk.BVH")
    'bvh'
    """
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        known = ", ".join(CAPTURE_ENDINGS)
        what = f" ({OTHER_FORMATS[ending]})" if ending in OTHER_FORMATS else ""
        raise CaptureError(
            path,
            f"expected a capture ({known}), found ending {ending!r}{what}. Rename or convert it.",
        )
    return FORMATS[ending]


def data_format(data: bytes, path: Path | str) -> str:
    """Return the format of a file by its ending and, of arrays and tables, by what they hold."""
    kind = capture_format(path)
    if kind == "robot" and is_marker_table(data[:_MAX_FIRST]):
        return "markers"
    if kind != "amass":
        return kind
    from motiondb.files.readers.array_motion import array_kind

    return array_kind(data, kind)


def read_capture(
    path: Path | str,
    *,
    skeleton: Path | str | None = None,
    fps: float | None = None,
    unit: float | None = None,
    skip_bad_frames: bool = False,
    up: str = "",
    mirror_world: bool = False,
    swap_sides: bool = False,
) -> Clip:
    """Read the clip in a capture file.

    Parameters
    ----------
    path : Path or str
        The file; its ending names the format. ``FILE.fbx#TAKE`` is one of several takes.
    skeleton : Path or str or None
        The ASF file of an AMC, the model of a motion (MJCF, URDF, .osim), or a text file with the
        names of the joints of an array; None: the one that :func:`skeleton_path` finds.
    fps : float or None
        Frames per second, instead of the rate in the file.
    unit : float or None
        Metres per length unit; None: the unit in the file, or estimated from the size of the body.
    skip_bad_frames : bool
        Leave out bad frames instead of refusing the file.
    up : str
        The axis that points up: "x", "y", "z", "-x", "-y" or "-z"; "": as the file says.
    mirror_world : bool
        The axes of the file are left-handed: what it shows is a mirror image.
    swap_sides : bool
        The names of left and right are exchanged in the file.

    Returns
    -------
    Clip
        Metres, seconds; world axes as in the file (see each reader), the axis up in ``up``.

    Raises
    ------
    CaptureError
        When the file cannot be read; it lists every structural fault with its line.
    """
    path, take = split_take(path)
    capture_format(path)
    options = ReadOptions(
        fps,
        unit,
        skip_bad_frames,
        take=take,
        up=up,
        mirror_world=mirror_world,
        swap_sides=swap_sides,
    )
    options = with_rate_beside(path, options)
    beside, data = skeleton_path(path, skeleton), read_file(path, options)
    return read_capture_bytes(
        data,
        data_format(data, path),
        path=path,
        skeleton=None if beside is None else SkeletonFile(read_skeleton(beside, options), beside),
        options=options,
    )


def read_capture_bytes(
    data: bytes,
    kind: str,
    *,
    path: Path | str = "capture",
    skeleton: SkeletonFile | None = None,
    options: ReadOptions = AS_USUAL,
) -> Clip:
    """Read the clip in the bytes of a capture."""
    check_options(options, path)
    check_file_size(len(data), path, options.limits)
    with guarded(path):
        clip = _as_asked(_read(data, kind, path, skeleton, options), path, options)
        _check(clip, len(data), path, options)
    return clip


def read_takes_bytes(
    data: bytes,
    kind: str,
    *,
    path: Path | str = "capture",
    skeleton: SkeletonFile | None = None,
    options: ReadOptions = AS_USUAL,
) -> dict[str, Clip]:
    """Read the clips in the bytes of a capture by the names of their takes; "" for the only one."""
    if kind not in WITH_TAKES:
        return {"": read_capture_bytes(data, kind, path=path, skeleton=skeleton, options=options)}
    check_options(options, path)
    check_file_size(len(data), path, options.limits)
    with guarded(path):
        clips = _read_takes(data, kind, path, options)
        clips = {take: _as_asked(clip, path, options) for take, clip in clips.items()}
        for clip in clips.values():
            _check(clip, len(data), path, options)
    return clips if len(clips) > 1 else dict(zip(("",), clips.values()))


def read_marker_bytes(
    data: bytes,
    kind: str,
    *,
    path: Path | str = "capture",
    skeleton: SkeletonFile | None = None,
    options: ReadOptions = AS_USUAL,
) -> MarkerTracks:
    """Read the markers in the bytes of a file, without a body, gaps left as gaps.

    Of a motion of OpenSim: the bodies of its model, or series of its columns.
    """
    from motiondb.files.readers.c3d import c3d_markers
    from motiondb.files.readers.marker_tables import table_markers
    from motiondb.files.readers.markers import read_tracks
    from motiondb.files.readers.trc import trc_markers

    check_options(options, path)
    check_file_size(len(data), path, options.limits)
    with guarded(path):
        if kind == "opensim":
            from motiondb.files.readers.opensim_motion import opensim_tracks

            tracks = opensim_tracks(data, path, skeleton, options)
        else:
            readers = {"c3d": c3d_markers, "trc": trc_markers, "markers": table_markers}
            file = readers[kind](data, path, options)
            tracks = read_tracks(file, len(data), path, options)
        check_duration(len(tracks.places), tracks.fps, path)
    return tracks


def read_events_bytes(
    data: bytes, kind: str, *, path: Path | str = "capture", fps: float, take: str = ""
) -> list[Event]:
    """Read the events in the bytes of a capture, frames at 30 a second; only C3D has some."""
    if kind != "c3d":
        return []
    from motiondb.files.readers.c3d import c3d_events

    with guarded(path):
        return c3d_events(data, path, fps, take)


def _read_takes(data: bytes, kind: str, path: object, options: ReadOptions) -> dict[str, Clip]:
    """Call the reader of a format of which one file may hold several captures."""
    if kind == "c3d":
        from motiondb.files.readers.c3d import read_c3d_takes

        return read_c3d_takes(data, path, options)
    if kind == "trc":
        from motiondb.files.readers.trc import read_trc_takes

        return read_trc_takes(data, path, options)
    if kind == "markers":
        from motiondb.files.readers.marker_tables import read_table_takes

        return read_table_takes(data, path, options)
    from motiondb.files.readers.fbx import read_takes

    return read_takes(data, path, options)


def _as_asked(clip: Clip, path: object, options: ReadOptions) -> Clip:
    """Return a clip in the world that the user names; markers and positions are read so."""
    if options.rate_file:
        told = f"The frame rate, {options.fps:g} a second, is that of {quoted(options.rate_file)}."
        clip = replace(clip, notes=(*clip.notes, told))
    if options.unit is not None:
        clip = replace(clip, notes=clip.notes + asked_unit_notes(clip))
    if clip.format in (*_OF_MARKERS, "movement", "positions"):
        return clip
    names = mirror_joints(clip.skeleton) if options.swap_sides else None
    if names is not None and (names == np.arange(len(names))).all():
        raise CaptureError(
            path,
            "expected names of left and right joints to exchange, found none. Name the joints "
            "with --joint-map in place of --swap-sides.",
        )
    up = "" if clip.format in ("robot", "opensim") else options.up  # their readers turn
    return as_asked(clip, up, options.mirror_world, names)


def _check(clip: Clip, n_bytes: int, path: object, options: ReadOptions) -> None:
    """Check what every clip must fulfil (CaptureError)."""
    check_clip_size(clip.n_frames, len(clip.skeleton.names), n_bytes, path, options.limits)
    check_duration(clip.n_frames, clip.fps, path)
    _check_finite(clip, path)


def split_take(path: Path | str) -> tuple[Path, str]:
    """Split ``FILE#TAKE`` for a file of a format with takes; the take is "" where none is named.

    >>> split_take("a.fbx#walk")[1], split_take("walk#2.bvh")[1]
    ('walk', '')
    """
    text = str(path)
    file, _, take = text.rpartition("#")
    if Path(file).suffix.lower() in TAKE_ENDINGS and not is_file(text):
        return Path(file), take
    return Path(path), ""


def read_file(path: Path, options: ReadOptions) -> bytes:
    """Return the content of a file that is not too large."""
    try:
        with open_file(path, options.within) as file:
            check_file_size(os.fstat(file.fileno()).st_size, path, options.limits)
            return file.read()
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise CaptureError(path, f"expected a readable file, found: {reason}.") from error


def with_rate_beside(path: Path, options: ReadOptions) -> ReadOptions:
    """Return options with the frame rate of the JSON that `export --onto` writes beside a CSV."""
    said = path.with_suffix(".json")
    if options.fps is not None or path.suffix.lower() != ".csv" or not is_file(said):
        return options
    try:
        content = parse_json(read_file(said, options), _MAX_BESIDE)
        head = _first_cells(path, options)
    except (CaptureError, JSONError, UnicodeDecodeError):
        return options
    fps = content.get("fps") if isinstance(content, dict) else None
    if isinstance(fps, bool) or not isinstance(fps, float | int) or not MIN_FPS <= fps <= MAX_FPS:
        return options
    if not _names_columns(content, head):
        return options
    return replace(options, fps=float(fps), rate_file=said.name)


def _first_cells(path: Path, options: ReadOptions) -> list[str]:
    """Return the cells of the first line of a table that is no remark."""
    from motiondb.files.readers.first_bytes import cells

    with guarded(path), open_file(path, options.within) as file:
        start = clean_bytes(file.read(_MAX_FIRST), path)
    lines = decode(start).splitlines()
    return cells(next((line for line in lines if line.strip() and line[0] != "#"), ""))


def _names_columns(said: Mapping[str, object], head: list[str]) -> bool:
    """Whether a JSON beside a table names the columns of its header, or is ours of one without."""
    from motiondb.files.readers.first_bytes import ROOT_COLUMNS, is_number

    columns = said.get("columns")
    if not isinstance(columns, list) or not columns or not all(map(is_number, head)):
        return columns == head
    ours = {*said} == _BESIDE and columns[: len(ROOT_COLUMNS)] == [*ROOT_COLUMNS]
    return ours and len(columns) == len(head)


def read_skeleton(path: Path, options: ReadOptions) -> bytes:
    """Return the content of the skeleton file of a capture, with the files that it includes."""
    from motiondb.files.readers.first_bytes import MODEL_ENDINGS
    from motiondb.files.readers.robot_model import whole_model

    data = read_file(path, options)
    if path.suffix.lower() not in MODEL_ENDINGS:
        return data
    return whole_model(data, path, lambda inner: read_file(inner, options))


def _read(
    data: bytes, kind: str, path: Path | str, skeleton: SkeletonFile | None, options: ReadOptions
) -> Clip:
    """Call the reader of a format; each is imported where it is needed."""
    if kind == "bvh":
        from motiondb.files.readers.bvh import read_bvh

        return read_bvh(data, path, options)
    if kind == "amc":
        from motiondb.files.readers.amc import read_amc

        return read_amc(data, path, skeleton, options)
    if kind == "deepmimic":
        from motiondb.files.readers.deepmimic import read_deepmimic

        return read_deepmimic(data, path, options)
    if kind in ("amass", "robot", "positions"):
        from motiondb.files.readers.array_motion import read_array_motion

        return read_array_motion(data, path, skeleton, options)
    if kind in _OF_MARKERS:
        from motiondb.files.readers.markers import only_performer

        return only_performer(_read_takes(data, kind, path, options), path, options)
    if kind == "opensim":
        from motiondb.files.readers.opensim_motion import read_opensim

        return read_opensim(data, path, skeleton, options)
    if kind == "fbx":
        from motiondb.files.readers.fbx import read_fbx

        return read_fbx(data, path, options)
    if kind == "movement":
        from motiondb.files.readers.movement import read_movement

        return read_movement(data, path, options)
    raise CaptureError(path, f"expected a known format, found {kind!r}.")


def _check_finite(clip: Clip, path: object) -> None:
    """Refuse a clip in which numbers overflowed while it was computed (CaptureError)."""
    ends = np.array([offset for _, offset in clip.skeleton.end_sites])
    places = [clip.skeleton.offsets, clip.root_positions, ends]
    if clip.joint_positions is not None:
        places.append(clip.joint_positions)
    squares = np.einsum("fjq,fjq->fj", clip.local_rotations, clip.local_rotations)
    finite = all(np.isfinite(values).all() for values in places)
    if not (finite and np.all(np.abs(squares - 1.0) < _UNIT_LENGTH)):
        raise CaptureError(
            path,
            "expected lengths and angles of a body, found numbers that are too large or invalid "
            "rotations. Export it again.",
        )
