"""The motions of scenes: made by a job of this server, or kept in the database."""

from __future__ import annotations

from dataclasses import replace

from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.page.delivery.refs import Ref
from motiondb.page.facts.scene_facts import FIRST_FILE, MOTION_FILE, find_kept, scene_tracks
from motiondb.page.motion import container, figure
from motiondb.page.motion.container import Track
from motiondb.page.session.state import Page
from motiondb.records import MOTION_FPS, FloatArray


def load_scene(
    page: Page, db: MotionDB, ref: Ref, start: float | None, end: float | None, fps: float
) -> list[Track]:
    """Return the tracks of a scene, or of a part of it."""
    made = made_scene(page, ref)
    if made is not None:
        tracks = container.read_tracks(made)
    else:
        record = find_kept(db, ref.name)
        gone = [player.name for player in record.players if player.capture_id == -1]
        if gone:
            raise QueryError(
                f"{ref.name}: expected the motions of its players, found that the captures of"
                f" {', '.join(gone)} were removed. Make the scene again."
            )
        motions = {player.name: db.motion(f"{ref.name}/{player.name}") for player in record.players}
        tracks = scene_tracks(record, motions, str(ref))
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
    kept = low + figure.thinned(max(high - low, 0), MOTION_FPS, fps)
    points: FloatArray = track.points[kept]
    contacts = None if track.contacts is None else track.contacts[kept]
    rate = min(fps, MOTION_FPS)
    return replace(track, points=points, contacts=contacts, start=low / MOTION_FPS, fps=rate)
