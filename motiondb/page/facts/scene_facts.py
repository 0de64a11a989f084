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

import numpy as np

from motiondb.database import MotionDB
from motiondb.database.scenes.scene_facts import action_captions
from motiondb.database.scenes.scene_folder import report_facts
from motiondb.page.answers import unknown
from motiondb.page.facts.board_facts import diagram_facts
from motiondb.page.motion import container, figure
from motiondb.page.motion.container import Track, body_track
from motiondb.records import Caption, FloatArray, Motion
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.language.tactics_file import parse_diagram
from motiondb.store import StoredScene

if TYPE_CHECKING:
    from motiondb.database.scenes.scene_verbs import Scene
    from motiondb.scene.polish.polish import PolishedScene

FACTS_FILE, MOTION_FILE, FIRST_FILE = "facts.json", "motion.bin", "first.bin"


def made_scene_facts(scene: Scene, curve: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return the facts of a scene that was made.

    `curve`: Share of the sampling that was done (0 to 1), and the error of the scene, -log P.
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
    return first_motion(scene.made.polished, scene.made.text.diagram, ref)


def first_motion(polished: PolishedScene, diagram: Diagram, ref: str) -> bytes:
    """Return the motions of a polished scene as a container; no report is needed."""
    motions = {player.player: player.motion for player in polished.players}
    teams = {player.name: player.team for player in diagram.players}
    ball = np.zeros((0, 3)) if polished.ball is None else polished.ball.positions
    return container.pack(_tracks(motions, teams, ball, ref))


def scene_tracks(record: StoredScene, motions: Mapping[str, Motion], ref: str) -> list[Track]:
    """Return the tracks of a scene: its players with their teams, and the ball."""
    teams = {player.name: player.team for player in record.players}
    return _tracks(motions, teams, record.ball, ref)


def _tracks(
    motions: Mapping[str, Motion], teams: Mapping[str, str], ball: FloatArray, ref: str
) -> list[Track]:
    tracks = [
        replace(body_track(name, ref, figure.figure_of(motion)), team=teams[name])
        for name, motion in motions.items()
    ]
    if len(ball):
        tracks.append(Track("ball", ref, ball))
    return tracks


def find_kept(db: MotionDB, name: str) -> StoredScene:
    """Return a kept scene."""
    if name not in db.scenes.names():
        raise unknown("scene", name, "It may have been removed.")
    return db.scenes.load(name)


def read_scene_facts(folder: Path) -> dict[str, Any]:
    """Return the facts that a worker wrote."""
    facts: dict[str, Any] = json.loads((folder / FACTS_FILE).read_text(encoding="utf-8"))
    return facts
