"""Captures of markers or series without a body: how they are kept, and how they leave the database.

In place of a motion, a standing body of no size is stored; its leg length, 0, tells them.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from motiondb import store
from motiondb.answers.catalogue import Exported
from motiondb.body import body, retarget
from motiondb.database.catalogue.parts import outside
from motiondb.database.session import Session
from motiondb.errors import NoBodyError, QueryError
from motiondb.files.arrays import MARKER_ENDINGS, write_markers
from motiondb.files.formats import read_marker_bytes
from motiondb.files.limits import ReadOptions, SkeletonFile
from motiondb.files.readers.markers import MarkerTracks
from motiondb.files.safe_files import write_bytes
from motiondb.records import MOTION_FPS, CaptureInfo, Motion


def kept_markers(
    data: bytes,
    kind: str,
    path: Path,
    skeleton: SkeletonFile | None,
    options: ReadOptions,
    error: NoBodyError,
) -> tuple[MarkerTracks, Motion, str]:
    """Return the markers in a file, what is stored in place of a motion, and a note with reasons.

    `error`: why they are no body.
    """
    tracks = read_marker_bytes(data, kind, path=path, skeleton=skeleton, options=options)
    n_frames = max(1, round(len(tracks.places) / tracks.fps * MOTION_FPS))
    rotations = np.zeros((n_frames, len(body.JOINTS), 4), np.float32)
    rotations[..., 0] = 1.0
    root = np.zeros((n_frames, 3), np.float32)
    standing = Motion(rotations, root)
    root[:, 1] -= retarget.ground_height(retarget.motion_positions(standing)[0])
    why, _, mend = error.faults[0][1].partition("found ")[2].rstrip(".").partition(". ")
    if kind in ("c3d", "trc", "markers"):
        mend = "rename them to those of a whole body for that"
    told = (
        f"Kept as {tracks.what}, without the motion of a body: {why}. They are found by words and "
        f"tags and exported, not searched by motion; {mend[:1].lower()}{mend[1:]}."
    )
    return tracks, Motion(rotations, root, 0.0), told


def export_markers(
    session: Session,
    info: CaptureInfo,
    path: Path,
    unchanged: bool,
    part: tuple[float | None, float | None],
) -> Exported:
    """Write the markers of a capture; unchanged and in its own format the bytes that were added."""
    source = store.load_source(session.store, info.capture_id)
    run = store.load_run(session.store, info.run_id)
    ending = path.suffix.lower()
    if unchanged and ending == Path(source.own_name).suffix.lower():
        write_bytes(path, source.data)
        return Exported(info.name, path, info.fps, info.n_frames, "as added", True)
    if (not unchanged and part == (None, None)) or ending not in MARKER_ENDINGS:
        raise QueryError(f"{info.name}: {store.MARKERS_ONLY}")
    from motiondb.database.catalogue.file_reading import stored_options, stored_skeleton

    options = stored_options(info, source, run.parameters, info.fps)
    skeleton = stored_skeleton(source)
    tracks = read_marker_bytes(
        source.data, source.format, path=info.name, skeleton=skeleton, options=options
    )
    low = round((part[0] or 0.0) * tracks.fps)
    high = len(tracks.places) if part[1] is None else round(part[1] * tracks.fps)
    if not 0 <= low < min(high, len(tracks.places)):
        raise QueryError(f"{info.name}: {outside(info.duration, *part)}")
    places = tracks.places[low:high]
    write_markers(replace(tracks, places=places), path)
    unit = "mm" if ending == ".trc" else "m"
    said = ("markers without a body, y up; those that were not seen are empty",)
    if tracks.what == "series":
        unit, said = "its own units", ("series of the columns of the file, without a body",)
    return Exported(info.name, path, tracks.fps, len(places), unit, False, said)
