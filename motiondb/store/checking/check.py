"""Check the store: every value readable, all tables present, no rule broken.

A rule is a query that gives the rows that break it. The rules are those that constraints of the
tables cannot express (see the head of ``schema.sql``). A run that was killed is not a fault, unless
derived rows refer to it.
"""

from __future__ import annotations

import numpy as np

from motiondb.errors import MotionDBError, StoreError
from motiondb.store.catalogue.poses import POSE_SIZE, unflatten_motion
from motiondb.store.catalogue.sources import load_source
from motiondb.store.checking.beside import block_faults
from motiondb.store.checking.grammar_check import broken_grammars
from motiondb.store.checking.offenders import broken_rules, foreign_rows
from motiondb.store.checking.readable import unreadable_columns, wrong_tables
from motiondb.store.checking.scene_check import broken_scenes
from motiondb.store.connection.columns import fetch, from_rows
from motiondb.store.connection.faults import damage_sentence
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import read_meta
from motiondb.store.learned.learning import DERIVED_TABLES

_TOLERANCE = 1e-4
"""By which a sum of probabilities may differ from 1. Chosen by hand: rounding errs by 1e-12."""
_UNIT_LENGTH = 1e-3
"""By which the length of a quaternion may differ from 1. Chosen by hand: float32 errs by 1e-6."""

_RULES = (
    # rule, query for the offenders (one text column)
    (
        "expected as many motion frames as its row says, numbered from 0",
        """SELECT c.name FROM capture c LEFT JOIN (SELECT capture_id, count(*) AS n, min(frame) AS
           low, max(frame) AS high, count(DISTINCT frame) AS d FROM motion_frame GROUP BY ALL) f
           USING (capture_id) WHERE coalesce(n, 0) <> motion_frames
           OR (n > 0 AND (low <> 0 OR high <> n - 1 OR d <> n))""",
    ),
    (
        "expected events within its motion",
        """SELECT DISTINCT c.name FROM capture c JOIN event e USING (capture_id)
           WHERE e.frame >= motion_frames""",
    ),
    (
        "expected its file in the table source",
        "SELECT name FROM capture ANTI JOIN source USING (sha256)",
    ),
    (
        "expected segments that tile its motion",
        """SELECT name FROM capture c JOIN (SELECT capture_id, min(start_frame) AS low,
           max(end_frame) AS high, bool_and(end_frame > start_frame AND start_frame = previous)
           AS tiled FROM (SELECT *, lag(end_frame, 1, start_frame) OVER
           (PARTITION BY capture_id ORDER BY start_frame, ordinal) AS previous FROM segment)
           GROUP BY ALL) s USING (capture_id)
           WHERE NOT tiled OR low <> 0 OR high <> motion_frames""",
    ),
    (
        "expected the probabilities of its words to sum to 1",
        f"""SELECT 'symbol ' || symbol_id FROM translation GROUP BY symbol_id
            HAVING abs(sum(coalesce(probability, 'nan'::DOUBLE)) - 1) > {_TOLERANCE}
            OR isnan(sum(coalesce(probability, 'nan'::DOUBLE)))""",
    ),
    (
        "expected l + 1 alignment probabilities that sum to 1",
        f"""SELECT 'alignment ' || l || ', ' || m || ', ' || j FROM alignment
            WHERE len(probabilities) <> l + 1
            OR abs(list_sum(probabilities) - 1) > {_TOLERANCE}""",
    ),
    (
        "expected states numbered from 0, as many as its row says",
        """SELECT 'symbol ' || s.symbol_id FROM symbol s LEFT JOIN (SELECT symbol_id, count(*) AS n,
           max(state) AS high FROM symbol_state GROUP BY ALL) t USING (symbol_id)
           WHERE coalesce(n, 0) <> n_states OR high <> n_states - 1""",
    ),
    (
        "expected as many rows as the table learning says",
        """SELECT 'table ' || name FROM (
           SELECT 'symbol' AS name, n_symbols = (SELECT count(*) FROM symbol) AS fits FROM learning
           UNION ALL SELECT 'symbol_distance', n_symbols ** 2 = (SELECT count(*) FROM
           symbol_distance) FROM learning
           UNION ALL SELECT 'cluster', n_clusters = (SELECT count(*) FROM cluster) FROM learning
           UNION ALL SELECT 'word', n_words = (SELECT count(*) FROM word) FROM learning
           UNION ALL SELECT 'learning', count(*) <= 1 FROM learning) WHERE NOT fits""",
    ),
    (
        "expected a score for every symbol",
        """SELECT 'segment ' || s.ordinal FROM segment s LEFT JOIN segment_score t USING (ordinal)
           WHERE len(scores) IS DISTINCT FROM (SELECT n_symbols FROM learning)""",
    ),
)

_REFERENCES = (
    # table, column, the table where the number must stand, its column
    ("capture_tag", "capture_id", "capture", "capture_id"),
    ("caption", "capture_id", "capture", "capture_id"),
    ("event", "capture_id", "capture", "capture_id"),
    ("motion_frame", "capture_id", "capture", "capture_id"),
    ("relation", "capture_id", "capture", "capture_id"),
    ("relation", "other_id", "capture", "capture_id"),
    ("generated_source", "capture_id", "capture", "capture_id"),
    ("frame_source", "capture_id", "capture", "capture_id"),
    ("source", "sha256", "capture", "sha256"),
    ("segment", "capture_id", "capture", "capture_id"),
    ("segment", "symbol_id", "symbol", "symbol_id"),
    ("segment_score", "ordinal", "segment", "ordinal"),
    ("segment_movement", "ordinal", "segment", "ordinal"),
    ("symbol", "cluster_id", "cluster", "cluster_id"),
    ("symbol_state", "symbol_id", "symbol", "symbol_id"),
    ("symbol_distance", "symbol_id", "symbol", "symbol_id"),
    ("symbol_distance", "other_id", "symbol", "symbol_id"),
    ("translation", "symbol_id", "symbol", "symbol_id"),
    ("translation", "word_id", "word", "word_id"),
    ("transition_count", "symbol_id", "symbol", "symbol_id"),
    ("transition_count", "next_id", "symbol", "symbol_id"),
)


def check_store(store: Store, *, sources: bool = False, blocks: bool | None = None) -> list[str]:
    """Every fault in the store, one sentence each; none if it is sound.

    Reads every column of every table, compares the tables with ``schema.sql``, and looks for rows
    that break a rule. Nothing is called sound that could not be read.

    `sources`: Whether to unpack every stored file and compare its digest (0.1 s for every 30 MB).

    `blocks`: Whether to compare every block of the file with its checksum, in another process (0.4
    s); None: where ``sources`` is True.
    """
    faults = block_faults(store.path) if (sources if blocks is None else blocks) else []
    try:
        damaged = unreadable_columns(store)
        if damaged:
            listed = "; ".join(f"{table} ({', '.join(c)})" for table, c in damaged.items())
            faults.append(damage_sentence(store.path, f"damaged columns: {listed}."))
        faults += wrong_tables(store)
        if faults:  # the rules read these tables
            return faults
        faults = broken_rules(store, _RULES) + _unresolved(store) + _bad_provenance(store)
        faults += _bad_runs(store) + _bad_poses(store) + _bad_meta(store)
        faults += broken_grammars(store) + broken_scenes(store)
        return faults + (_bad_sources(store) if sources else [])
    except StoreError as error:
        return [*faults, str(error)]


def _bad_meta(store: Store) -> list[str]:
    """Keys that the table ``meta`` lacks, or whose values are no numbers where they must be."""
    faults = []
    for key in ("schema", "next_capture_id", "revision", "motion_revision"):
        try:
            value = read_meta(store, key)
        except StoreError as error:
            faults.append(str(error))
            continue
        if key != "motion_revision" and not value.isdecimal():
            faults.append(f"meta: expected a number for {key}, found {value!r}.")
    return faults


def _unresolved(store: Store) -> list[str]:
    faults: list[str] = []
    for table, column, target, key in _REFERENCES:
        allowed = "" if column == "sha256" else f"AND {column} <> -1"
        row = store.connection.execute(
            f"SELECT count(*), min({column}) FROM {table} "
            f"WHERE {column} NOT IN (SELECT {key} FROM {target}) {allowed}"
        ).fetchone()
        if row and row[0]:
            faults.append(
                f"{table}: expected every {column} in {target}, found {row[0]} rows without, "
                f"such as {row[1]}."
            )
    return faults


def _bad_provenance(store: Store) -> list[str]:
    """Generated captures whose frames do not each have one source."""
    rows = store.connection.execute(
        "SELECT c.name FROM capture c JOIN (SELECT capture_id, count(*) AS n, max(frame) AS high, "
        "count(DISTINCT frame) AS d, max(source_ordinal) AS source FROM frame_source GROUP BY ALL) "
        "f USING (capture_id) LEFT JOIN (SELECT capture_id, count(*) AS k FROM generated_source "
        "GROUP BY ALL) g USING (capture_id) "
        "WHERE n <> motion_frames OR d <> n OR high <> n - 1 OR source >= coalesce(k, 0)"
    ).fetchall()
    return [f"{name}: expected one known source for every frame, found others." for (name,) in rows]


def _bad_runs(store: Store) -> list[str]:
    """Derived rows of another run than the learning's, or a learning that never finished."""
    run = "SELECT run_id FROM learning JOIN run USING (run_id) WHERE finished IS NOT NULL"
    references = {"the finished run of learn": f"run_id NOT IN ({run})"}
    return [fault for table in DERIVED_TABLES for fault in foreign_rows(store, table, references)]


def _bad_poses(store: Store) -> list[str]:
    """Motions with numbers that are not finite or quaternions that are not of length 1."""
    faults: list[str] = []
    captures = store.connection.execute(
        "SELECT capture_id, name FROM capture ORDER BY 1"
    ).fetchall()
    for number, name in captures:
        query = "SELECT pose FROM motion_frame WHERE capture_id = ? ORDER BY frame"
        poses = from_rows(
            fetch(store.connection, query, [number])["pose"], (POSE_SIZE,), np.float32
        )
        lengths = np.linalg.norm(unflatten_motion(poses).local_rotations, axis=2)
        good = np.isfinite(poses).all(axis=1) & (np.abs(lengths - 1) < _UNIT_LENGTH).all(axis=1)
        if not good.all():
            faults.append(
                f"{name}: expected finite positions and quaternions of length 1, found others "
                f"in frame {int(np.argmin(good))}."
            )
    return faults


def _bad_sources(store: Store) -> list[str]:
    faults: list[str] = []
    for (number,) in store.connection.execute("SELECT capture_id FROM capture").fetchall():
        try:
            load_source(store, number)
        except MotionDBError as error:
            faults.append(str(error))
    return faults
