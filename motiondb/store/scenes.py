"""Scenes: the players' actions, places, times and clips, and how well the rules are kept.

A scene is saved, replaced (by its name) and removed as a whole, in one transaction. It keeps the
texts of its diagram and grammar, and the names and digests of the captures that its clips come
from. So it stays when one of these captures is removed. The players' motions, if they are kept, are
captures of their own.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from motiondb.errors import QueryError
from motiondb.records import FloatArray
from motiondb.store.catalogue.names import unknown_name
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import columns_of
from motiondb.store.connection.transactions import transaction

TABLES = ("scene", "scene_player", "scene_clip", "scene_rule", "scene_ball")


@dataclass(frozen=True)
class SceneClip:
    """A part of a capture that plays an action; see ``scene.clips.ClipSource``."""

    terminal: str
    capture: str  # Name of the capture
    sha256: str  # Digest of the capture, hexadecimal
    start: int  # Its first frame in the capture, at 30 a second
    end: int  # The frame of the capture after its last one
    mirrored: bool = False  # Whether left and right are exchanged
    bend: float = 0.0  # Angle by which its path is bent, radians
    stretch: float = 1.0  # Factor by which the lengths of its steps are multiplied
    begin: int = 0  # Frame of the scene, as sampled, at which it begins


@dataclass(frozen=True)
class ScenePlayer:
    """A player of a scene."""

    name: str  # Name in the diagram
    team: str  # Team in the diagram
    rules: tuple[int, ...]  # Numbers of the rules of the player's tree, in preorder
    # Place and heading at the start: x and z in metres, heading in radians
    origin: tuple[float, float, float]
    delay: int  # Frames before the first clip, at 30 a second
    clips: tuple[SceneClip, ...]  # The clips, in the order in which they are played
    # Number of the capture that holds the player's motion, -1 where it is not kept
    capture_id: int = -1


@dataclass(frozen=True)
class SceneRule:
    """A rule about a player or an object, and how well it is kept."""

    player: str  # Name of the player whose rule it is
    action: str  # The first action that the rule is about
    clip: int  # Index of this action in the player's string
    kind: str  # The kind of rule
    about: str  # The player or place that the rule refers to, in words
    unit: str  # Unit of ``before``, ``after`` and ``threshold``
    before: float  # Value before the scene was polished
    after: float  # Value after the scene was polished
    threshold: float
    frame: int  # Frame of the polished scene where the rule fails most
    kept: bool  # Whether the polished scene keeps the rule


@dataclass(frozen=True, eq=False)
class StoredScene:
    """A scene as it is stored."""

    name: str
    """Name of the scene."""
    diagram: str
    """Text of the tactics diagram."""
    grammar: str
    """Text of the motion grammar."""
    settings: Mapping[str, Any]
    """Settings with which the scene was made; only values that JSON can hold."""
    error: float
    """-log P(Z) of the sampled scene, nats."""
    n_frames: int
    """Number of frames, at 30 a second."""
    players: tuple[ScenePlayer, ...]
    """The players, in the order of the diagram."""
    rules: tuple[SceneRule, ...] = ()
    """The rules, and how well each is kept."""
    ball: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    """array (frames, 3): centre of the ball (x, y, z), metres; (0, 3) if there is no ball."""
    report: Mapping[str, Any] = field(default_factory=dict)
    """Further facts about the scene; only values that JSON can hold."""
    run_id: int = 0
    """The run that made the scene; set when it is saved."""


def save_scene(store: Store, scene: StoredScene, run_id: int) -> None:
    """Save a scene made by run ``run_id``, replacing any scene of the same name."""
    with transaction(store) as connection:
        _remove(store, scene.name)
        number = connection.value("SELECT coalesce(max(scene_id), 0) + 1 FROM scene")
        connection.insert_row(
            "scene",
            number,
            scene.name,
            scene.diagram,
            scene.grammar,
            json.dumps(dict(scene.settings), sort_keys=True),
            scene.error,
            json.dumps(dict(scene.report), sort_keys=True),
            scene.n_frames,
            run_id,
        )
        for ordinal, player in enumerate(scene.players):
            _insert_player(store, number, ordinal, player, run_id)
        _insert_rules(store, number, scene.rules, run_id)
        n = len(scene.ball)
        connection.insert(
            "scene_ball",
            scene_id=number,
            frame=np.arange(n),
            x=scene.ball[:, 0],
            y=scene.ball[:, 1],
            z=scene.ball[:, 2],
            run_id=run_id,
        )


def _insert_player(
    store: Store, number: int, ordinal: int, player: ScenePlayer, run_id: int
) -> None:
    connection = store.connection
    connection.insert_row(
        "scene_player",
        number,
        ordinal,
        player.name,
        player.team,
        list(player.rules),
        *player.origin,
        player.delay,
        player.capture_id,
        run_id,
    )
    clips = player.clips
    connection.insert(
        "scene_clip",
        scene_id=number,
        player=ordinal,
        ordinal=list(range(len(clips))),
        terminal=[clip.terminal for clip in clips],
        source_name=[clip.capture for clip in clips],
        source_sha256=[clip.sha256 for clip in clips],
        start_frame=[clip.start for clip in clips],
        end_frame=[clip.end for clip in clips],
        mirrored=[clip.mirrored for clip in clips],
        bend=[clip.bend for clip in clips],
        stretch=[clip.stretch for clip in clips],
        begin_frame=[clip.begin for clip in clips],
        run_id=run_id,
    )


def _insert_rules(store: Store, number: int, rules: Sequence[SceneRule], run_id: int) -> None:
    store.connection.insert(
        "scene_rule",
        scene_id=number,
        ordinal=list(range(len(rules))),
        **columns_of(SceneRule, rules),
        run_id=run_id,
    )


def load_scene(store: Store, name: str) -> StoredScene:
    """Load the scene of this name."""
    row = store.connection.execute(
        "SELECT scene_id, diagram, grammar, settings, error, report, n_frames, run_id FROM scene"
        " WHERE name = ?",
        [name],
    ).fetchone()
    if row is None:
        raise QueryError(_unknown(store, name))
    number, diagram, grammar, settings, error, report, n_frames, run_id = row
    rules = store.connection.execute(
        "SELECT player, action, clip, kind, about, unit, before, after, threshold, frame, kept FROM"
        " scene_rule WHERE scene_id = ? ORDER BY ordinal",
        [number],
    ).fetchall()
    ball = store.connection.arrays(
        "SELECT x, y, z FROM scene_ball WHERE scene_id = ? ORDER BY frame",
        [number],
    )
    return StoredScene(
        name,
        diagram,
        grammar,
        json.loads(settings),
        error,
        n_frames,
        _load_players(store, number),
        tuple(SceneRule(*rule) for rule in rules),
        np.stack([ball["x"], ball["y"], ball["z"]], axis=1),
        json.loads(report),
        run_id,
    )


def _load_players(store: Store, number: int) -> tuple[ScenePlayer, ...]:
    rows = store.connection.execute(
        "SELECT player, terminal, source_name, source_sha256, start_frame, end_frame, mirrored,"
        " bend, stretch, begin_frame FROM scene_clip WHERE scene_id = ? ORDER BY player, ordinal",
        [number],
    ).fetchall()
    clips: dict[int, list[SceneClip]] = {}
    for player, *clip in rows:
        clips.setdefault(player, []).append(SceneClip(*clip))
    players = store.connection.execute(
        "SELECT ordinal, name, team, rules, x, z, heading, delay, capture_id FROM scene_player"
        " WHERE scene_id = ? ORDER BY ordinal",
        [number],
    ).fetchall()
    return tuple(
        ScenePlayer(
            name, team, tuple(rules), (x, z, heading), delay, tuple(clips.get(k, ())), capture
        )
        for k, name, team, rules, x, z, heading, delay, capture in players
    )


def load_scene_names(store: Store) -> list[str]:
    """Load the names of all scenes, in alphabetical order."""
    return store.connection.column("SELECT name FROM scene ORDER BY name")


def load_scene_captures(store: Store, name: str) -> list[str]:
    """Load the names of the captures that hold the players' motions, in the order of players."""
    return store.connection.column(
        "SELECT c.name FROM scene s JOIN scene_player p USING (scene_id) JOIN capture c ON"
        " c.capture_id = p.capture_id WHERE s.name = ? ORDER BY ordinal",
        [name],
    )


def remove_scene(store: Store, name: str) -> None:
    """Remove a scene; the captures that hold its players' motions stay."""
    if name not in load_scene_names(store):
        raise QueryError(_unknown(store, name))
    with transaction(store):
        _remove(store, name)


def _remove(store: Store, name: str) -> None:
    with transaction(store) as connection:
        number = connection.value("SELECT scene_id FROM scene WHERE name = ?", [name])
        for table in TABLES:
            connection.execute(f"DELETE FROM {table} WHERE scene_id = ?", [number])


def _unknown(store: Store, name: str) -> str:
    remedy = "Make one: motiondb scene make DIAGRAM -o FOLDER --name NAME."
    return unknown_name(store, name, "scene", load_scene_names(store), remedy)
