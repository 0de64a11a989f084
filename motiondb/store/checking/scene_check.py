"""Check scenes: clips and rules of their players, a ball in every frame or none, and their runs."""

from __future__ import annotations

from motiondb.store.checking.offenders import FINISHED_RUN, broken_rules, foreign_rows
from motiondb.store.connection.handle import Store
from motiondb.store.grammars.scenes import TABLES

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
