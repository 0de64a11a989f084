"""Scenes: what each player does, where and when, by which clips, and how well the rules are kept.

A scene is saved, replaced (by its name) and removed as a whole, in one transaction. It keeps the
texts of its diagram and grammar, and names and digests of the captures its clips come from, so that
it stays when one of them is removed. The players' motions, where they are kept, are captures.
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
from motiondb.store.checking.offenders import FINISHED_RUN, broken_rules, foreign_rows
from motiondb.store.connection.columns import fetch, insert
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction

TABLES = ("scene", "scene_player", "scene_clip", "scene_rule", "scene_ball")


@dataclass(frozen=True)
class SceneClip:
    """A piece of a capture that plays an action; see ``scene.clips.ClipSource``.

    Attributes
    ----------
    start, end : frames of the capture, half-open. bend : radians. stretch : of the steps.
    begin : frame of the scene, as sampled, at which it begins.
    """

    terminal: str
    capture: str
    sha256: str
    start: int
    end: int
    mirrored: bool = False
    bend: float = 0.0
    stretch: float = 1.0
    begin: int = 0


@dataclass(frozen=True)
class ScenePlayer:
    """A player of a scene.

    Attributes
    ----------
    rules : numbers of the rules of the tree, in preorder.
    origin : x, z, metres, and heading, radians. delay : frames.
    capture_id : of the motion, where it is kept as a capture; -1 where not.
    """

    name: str
    team: str
    rules: tuple[int, ...]
    origin: tuple[float, float, float]
    delay: int
    clips: tuple[SceneClip, ...]
    capture_id: int = -1


@dataclass(frozen=True)
class SceneRule:
    """How far a rule about somebody or something is from being kept, in its unit."""

    player: str
    action: str
    clip: int
    kind: str
    about: str
    unit: str
    before: float
    after: float
    threshold: float
    frame: int
    kept: bool


@dataclass(frozen=True, eq=False)
class StoredScene:
    """A scene as it is kept.

    Attributes
    ----------
    diagram, grammar : texts of the files.
    settings, report : what JSON can hold.
    error : -log P(Z) of what was sampled.
    ball : array (frames, 3), metres, or (0, 3) where there is none.
    """

    name: str
    diagram: str
    grammar: str
    settings: Mapping[str, Any]
    error: float
    n_frames: int
    players: tuple[ScenePlayer, ...]
    rules: tuple[SceneRule, ...] = ()
    ball: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    report: Mapping[str, Any] = field(default_factory=dict)
    run_id: int = 0


def save_scene(store: Store, scene: StoredScene, run_id: int) -> None:
    """Save a scene in place of the one of the same name, if there is one."""
    with transaction(store) as connection:
        _remove(store, scene.name)
        row = connection.execute("SELECT coalesce(max(scene_id), 0) + 1 FROM scene").fetchone()
        number = int(row[0]) if row else 1
        connection.execute(
            "INSERT INTO scene VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
            [
                number,
                scene.name,
                scene.diagram,
                scene.grammar,
                json.dumps(dict(scene.settings), sort_keys=True),
                scene.error,
                json.dumps(dict(scene.report), sort_keys=True),
                scene.n_frames,
                run_id,
            ],
        )
        for ordinal, player in enumerate(scene.players):
            _insert_player(store, number, ordinal, player, run_id)
        _insert_rules(store, number, scene.rules, run_id)
        n = len(scene.ball)
        insert(
            connection,
            "scene_ball",
            scene_id=np.full(n, number),
            frame=np.arange(n),
            x=scene.ball[:, 0],
            y=scene.ball[:, 1],
            z=scene.ball[:, 2],
            run_id=np.full(n, run_id),
        )


def _insert_player(
    store: Store, number: int, ordinal: int, player: ScenePlayer, run_id: int
) -> None:
    connection = store.connection
    connection.execute(
        "INSERT INTO scene_player VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
        [
            number,
            ordinal,
            player.name,
            player.team,
            list(player.rules),
            *player.origin,
            player.delay,
            player.capture_id,
            run_id,
        ],
    )
    clips = player.clips
    insert(
        connection,
        "scene_clip",
        scene_id=[number] * len(clips),
        player=[ordinal] * len(clips),
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
        run_id=[run_id] * len(clips),
    )


def _insert_rules(store: Store, number: int, rules: Sequence[SceneRule], run_id: int) -> None:
    insert(
        store.connection,
        "scene_rule",
        scene_id=[number] * len(rules),
        ordinal=list(range(len(rules))),
        player=[rule.player for rule in rules],
        action=[rule.action for rule in rules],
        clip=[rule.clip for rule in rules],
        kind=[rule.kind for rule in rules],
        about=[rule.about for rule in rules],
        unit=[rule.unit for rule in rules],
        before=[rule.before for rule in rules],
        after=[rule.after for rule in rules],
        threshold=[rule.threshold for rule in rules],
        frame=[rule.frame for rule in rules],
        kept=[rule.kept for rule in rules],
        run_id=[run_id] * len(rules),
    )


def load_scene(store: Store, name: str) -> StoredScene:
    """The scene of this name (QueryError: none; suggests the nearest)."""
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
    ball = fetch(
        store.connection,
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
    """The names of all scenes, in order."""
    rows = store.connection.execute("SELECT name FROM scene ORDER BY name").fetchall()
    return [name for (name,) in rows]


def load_scene_captures(store: Store, name: str) -> list[str]:
    """The names of the captures that keep the motions of a scene's players, in their order."""
    rows = store.connection.execute(
        "SELECT c.name FROM scene s JOIN scene_player p USING (scene_id) JOIN capture c ON"
        " c.capture_id = p.capture_id WHERE s.name = ? ORDER BY ordinal",
        [name],
    ).fetchall()
    return [capture for (capture,) in rows]


def remove_scene(store: Store, name: str) -> None:
    """Take a scene out; captures that keep its players' motions stay (QueryError: no such)."""
    if name not in load_scene_names(store):
        raise QueryError(_unknown(store, name))
    with transaction(store):
        _remove(store, name)


def _remove(store: Store, name: str) -> None:
    with transaction(store) as connection:
        row = connection.execute("SELECT scene_id FROM scene WHERE name = ?", [name]).fetchone()
        if row is not None:
            for table in TABLES:
                connection.execute(f"DELETE FROM {table} WHERE scene_id = ?", [row[0]])


def _unknown(store: Store, name: str) -> str:
    remedy = "Make one: motiondb scene make DIAGRAM -o FOLDER --name NAME."
    return unknown_name(store, name, "scene", load_scene_names(store), remedy)


_RULES = (
    # rule, query for the offenders (one text column)
    (
        "expected clips of its players, numbered from 0",
        """SELECT DISTINCT s.name FROM scene s LEFT JOIN scene_player p USING (scene_id)
           LEFT JOIN (SELECT scene_id, player, count(*) AS n, max(ordinal) AS high,
           bool_and(end_frame > start_frame) AS long FROM scene_clip GROUP BY ALL) c
           ON c.scene_id = p.scene_id AND c.player = p.ordinal
           WHERE coalesce(n, 0) = 0 OR high <> n - 1 OR NOT long ORDER BY ALL""",
    ),
    (
        "expected rules about its players",
        """SELECT DISTINCT s.name FROM scene s JOIN scene_rule r USING (scene_id)
           LEFT JOIN scene_player p ON p.scene_id = r.scene_id AND p.name = r.player
           WHERE p.name IS NULL ORDER BY ALL""",
    ),
    (
        "expected its ball in every frame, or in none",
        """SELECT DISTINCT s.name FROM scene s JOIN (SELECT scene_id, count(*) AS n,
           count(DISTINCT frame) AS d, max(frame) AS high FROM scene_ball GROUP BY ALL) b
           USING (scene_id) WHERE n <> n_frames OR d <> n OR high <> n - 1 ORDER BY ALL""",
    ),
    (
        "expected captures that were generated, or none",
        """SELECT DISTINCT s.name FROM scene s JOIN scene_player p USING (scene_id)
           WHERE capture_id <> -1 AND capture_id NOT IN
           (SELECT capture_id FROM capture WHERE kind = 'generated') ORDER BY ALL""",
    ),
)


def broken_scenes(store: Store) -> list[str]:
    """Every fault in scenes, one sentence each."""
    foreign = [fault for table in TABLES for fault in _unresolved(store, table)]
    return broken_rules(store, _RULES, "scene ") + foreign


def _unresolved(store: Store, table: str) -> list[str]:
    """Rows of no scene, or of another run than their scene's, or of one that did not finish."""
    own_run = f"run_id <> (SELECT run_id FROM scene s WHERE s.scene_id = {table}.scene_id)"
    no_scene = {"a scene": "scene_id NOT IN (SELECT scene_id FROM scene)"}
    return foreign_rows(store, table, no_scene | FINISHED_RUN | {"the run of its scene": own_run})
