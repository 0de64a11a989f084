"""Facts and motions of scenes: made by a job of this server, or kept in the database.

The worker writes what the server needs of a made scene into its folder (``facts.json`` and
``motion.bin``), because the server does not hold the scene itself.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motiondb.database import MotionDB
from motiondb.database.scenes.scene_facts import action_captions
from motiondb.database.scenes.scene_reports import report_facts
from motiondb.errors import QueryError
from motiondb.page import container, figure
from motiondb.page.answers import unknown
from motiondb.page.container import Track, body_track
from motiondb.page.facts.board_facts import diagram_facts
from motiondb.records import MOTION_FPS, Caption, FloatArray, Motion
from motiondb.scene.language.tactics_file import parse_diagram
from motiondb.store import StoredScene

if TYPE_CHECKING:
    from motiondb.database.scenes.scene_verbs import Scene
    from motiondb.page.refs import Ref
    from motiondb.page.state import Page

FACTS_FILE, MOTION_FILE = "facts.json", "motion.bin"


def made_scene_facts(scene: Scene, curve: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return the facts of a scene that was made.

    Parameters
    ----------
    scene : Scene
        The scene.
    curve : sequence of (float, float)
        The share of the sampling that was done, and the error.
    """
    actions = {
        who.name: action_captions(placed, tuple(clip.terminal for clip in who.clips))
        for who, placed in zip(scene.record.players, scene.made.polished.players, strict=True)
    }
    took = {what: round(seconds, 3) for what, seconds in scene.made.seconds.items()}
    return _facts(scene.record, actions) | {"curve": list(curve), "took": took}


def kept_scene_facts(db: MotionDB, record: StoredScene) -> dict[str, Any]:
    """Return the facts of a kept scene; the times of actions are the captions of its captures."""
    actions: dict[str, list[Caption]] = {}
    for player in record.players:
        row = db.browsed(f"{record.name}/{player.name}")
        actions[player.name] = list(row.captions) if row else []
    return _facts(record, actions) | {"curve": [], "took": {}}


def _facts(record: StoredScene, actions: Mapping[str, Sequence[Caption]]) -> dict[str, Any]:
    return {
        "name": record.name,
        "text": record.diagram,
        "board": diagram_facts(parse_diagram(record.diagram, record.name)),
        "report": report_facts(record),
        "actions": {
            name: [{"terminal": c.words, "start": c.start, "end": c.end} for c in captions]
            for name, captions in actions.items()
        },
    }


def made_scene_motion(scene: Scene, ref: str) -> bytes:
    """Return the motions of a made scene as a container."""
    motions = {player.player: player.motion for player in scene.made.polished.players}
    return container.pack(_tracks(scene.record, motions, ref))


def _tracks(record: StoredScene, motions: Mapping[str, Motion], ref: str) -> list[Track]:
    teams = {player.name: player.team for player in record.players}
    tracks = [
        replace(body_track(name, ref, figure.figure_of(motion)), team=teams[name])
        for name, motion in motions.items()
    ]
    if len(record.ball):
        tracks.append(Track("ball", ref, record.ball))
    return tracks


def find_kept(db: MotionDB, name: str) -> StoredScene:
    """Return a kept scene.

    Raises
    ------
    PageError
        There is none of this name.
    """
    if name not in db.scenes.names():
        raise unknown("scene", name, "It may have been removed.")
    return db.scenes.load(name)


def read_scene_facts(folder: Path) -> dict[str, Any]:
    """Return the facts that a worker wrote."""
    facts: dict[str, Any] = json.loads((folder / FACTS_FILE).read_text(encoding="utf-8"))
    return facts


def scene_tracks(
    page: Page, db: MotionDB, ref: Ref, start: float | None, end: float | None, fps: float
) -> list[Track]:
    """Return the tracks of a scene, or of a part of it.

    Raises
    ------
    MotionDBError
        There is no such scene, or captures of a kept one were removed.
    """
    if ref.kind == "scene":
        data = (page.scene_folder(ref.name) / MOTION_FILE).read_bytes()
        tracks = container.read_tracks(data)
    else:
        record = find_kept(db, ref.name)
        gone = [player.name for player in record.players if player.capture_id == -1]
        if gone:
            raise QueryError(
                f"{ref.name}: expected the motions of its players, found that the captures of"
                f" {', '.join(gone)} were removed. Make the scene anew."
            )
        motions = {player.name: db.motion(f"{ref.name}/{player.name}") for player in record.players}
        tracks = _tracks(record, motions, str(ref))
    return [_part(track, start, end, fps) for track in tracks]


def _part(track: Track, start: float | None, end: float | None, fps: float) -> Track:
    """Return a part of a track (seconds) at a lower or the same rate."""
    n_frames = len(track.points)
    low = min(round((start or 0.0) * MOTION_FPS), n_frames)
    high = n_frames if end is None else min(round(end * MOTION_FPS), n_frames)
    kept = low + figure.thinned(max(high - low, 0), MOTION_FPS, fps)
    points: FloatArray = track.points[kept]
    contacts = None if track.contacts is None else track.contacts[kept]
    rate = min(fps, MOTION_FPS)
    return replace(track, points=points, contacts=contacts, start=low / MOTION_FPS, fps=rate)
