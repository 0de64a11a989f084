"""Markers without a body that leave the database."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from motiondb import store
from motiondb.answers.catalogue import Exported
from motiondb.database.catalogue.file_reading import stored_options
from motiondb.database.catalogue.parts import outside, write_bytes
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.files.formats import read_marker_bytes
from motiondb.files.marker_writer import MARKER_ENDINGS, write_markers
from motiondb.records import CaptureInfo


def export_markers(
    session: Session,
    info: CaptureInfo,
    path: Path,
    unchanged: bool,
    part: tuple[float | None, float | None],
) -> Exported:
    """Write the markers of a capture; unchanged and in its own format the bytes that were added."""
    source = store.load_source(session.store, info.capture_id)
    run = {r.run_id: r for r in store.load_runs(session.store)}[info.run_id]
    ending = path.suffix.lower()
    if unchanged and ending == Path(source.own_name).suffix.lower():
        write_bytes(path, source.data)
        return Exported(info.name, path, info.fps, info.n_frames, "as added", True)
    if not unchanged and part == (None, None):
        raise QueryError(f"{info.name}: {store.MARKERS_ONLY}")
    if ending not in MARKER_ENDINGS:
        raise QueryError(f"{info.name}: {store.MARKERS_ONLY}")
    options = stored_options(info, source, run.parameters, info.fps)
    tracks = read_marker_bytes(source.data, source.format, path=info.name, options=options)
    low = round((part[0] or 0.0) * tracks.fps)
    high = len(tracks.places) if part[1] is None else round(part[1] * tracks.fps)
    if not 0 <= low < min(high, len(tracks.places)):
        raise QueryError(f"{info.name}: {outside(info.duration, *part)}")
    places = tracks.places[low:high]
    write_markers(replace(tracks, places=places), path)
    unit = "mm" if ending == ".trc" else "m"
    said = ("markers without a body, y up; those that were not seen are empty",)
    return Exported(info.name, path, tracks.fps, len(places), unit, False, said)
