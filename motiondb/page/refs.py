"""Refs: names by which the browser requests anything that can be played.

``capture:NAME`` is a stored capture, ``upload:ID/FILE`` an uploaded file, ``made:ID`` a motion
generated from a sentence, ``sequence:ID`` one from a grammar, ``scene:ID`` a scene that was made,
``kept:NAME`` a scene in the database. ``first:ID`` is the first motion of a scene that is being
updated.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.body.features import FEATURE_STEP
from motiondb.database import MotionDB
from motiondb.database.catalogue.browsing import BrowsedCapture
from motiondb.database.catalogue.parts import cut_motion
from motiondb.page.errors import PageError, unknown
from motiondb.page.jobs import FIRST_FILE, MOTION_FILE
from motiondb.page.motion import Track, part_of, read_tracks, scene_tracks
from motiondb.page.state import Page
from motiondb.records import MOTION_FPS, Motion
from motiondb.store import StoredScene

KINDS = ("capture", "upload", "made", "sequence", "scene", "first", "kept")


@dataclass(frozen=True)
class Ref:
    """A ref in its parts."""

    kind: str
    name: str

    def __str__(self) -> str:
        """Return the ref as text."""
        return f"{self.kind}:{self.name}"


def read_ref(text: str) -> Ref:
    """Return the parts of a ref."""
    kind, colon, name = text.partition(":")
    if not colon or kind not in KINDS or not name:
        raise PageError(
            f"ref: expected one of {', '.join(f'{k}:NAME' for k in KINDS)}, found {text[:100]!r}."
        )
    return Ref(kind, name)


def find_row(db: MotionDB, name: str) -> BrowsedCapture:
    """Return the row of a stored capture."""
    row = db.captures.browsed(name)
    if row is None:
        raise unknown("capture", name, "It may have been removed or renamed.")
    return row


def find_kept(db: MotionDB, name: str) -> StoredScene:
    """Return a scene that is kept in the database."""
    if name not in db.scenes.names():
        raise unknown("scene", name, "It may have been removed.")
    return db.scenes.load(name)


def load_motion(
    page: Page, db: MotionDB, ref: Ref, start: float | None = None, end: float | None = None
) -> Motion:
    """Return the motion of a ref, or the part of it from start to end (seconds)."""
    if ref.kind == "capture":
        return db.motion(find_row(db, ref.name).info.name, start, end)
    if ref.kind == "upload":
        upload_id, _, file = ref.name.partition("/")
        return db.motion(page.uploads.path(upload_id, file or "/"), start, end)
    if ref.kind == "made":
        return cut_motion(page.made.get(ref.name).generated.motion, start, end, FEATURE_STEP)
    if ref.kind == "sequence":
        return cut_motion(page.sequences.get(ref.name).sequence.motion, start, end, FEATURE_STEP)
    raise PageError(f"{ref}: expected one motion, found a scene with several. Name a capture.")


def load_scene(
    page: Page, db: MotionDB, ref: Ref, start: float | None, end: float | None, fps: float
) -> list[Track]:
    """Return the tracks of a scene, or of a part of it."""
    made = made_scene(page, ref)
    if made is not None:
        tracks = read_tracks(made)
    else:
        record = find_kept(db, ref.name)
        motions = db.scenes.motions(record)
        teams = {player.name: player.team for player in record.players}
        tracks = scene_tracks(motions, teams, record.ball, str(ref))
    return [_part(track, start, end, fps) for track in tracks]


def made_scene(page: Page, ref: Ref) -> bytes | None:
    """Return the whole motion of a scene that a job of this server made, as binary.

    None for a scene that is kept in the database.
    """
    if ref.kind == "scene":
        return (page.scene_folder(ref.name) / MOTION_FILE).read_bytes()
    if ref.kind == "first":
        return (page.scene_folder(ref.name, FIRST_FILE) / FIRST_FILE).read_bytes()
    return None


def _part(track: Track, start: float | None, end: float | None, fps: float) -> Track:
    """Return the part of a track from start to end (seconds), at the same or a lower frame rate."""
    n_frames = len(track.points)
    low = min(round((start or 0.0) * MOTION_FPS), n_frames)
    high = n_frames if end is None else min(round(end * MOTION_FPS), n_frames)
    return part_of(track, low, high, fps)
