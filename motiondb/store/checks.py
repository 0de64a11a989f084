"""Check the store: every value readable, all tables present, no rule broken.

DuckDB compares a block of the file with its checksum when it reads the block. So every column of
every table is read, and every row is found by its key, which reads the indexes that questions use.

A rule is a sentence and a query that gives the names of the rows that break it (one text column).
The rules are those that constraints of the tables cannot express (see the head of ``schema.sql``).
A run that was killed is not a fault, unless derived rows refer to it.

DuckDB may crash on a file that is damaged in a way it does not expect: to check a file,
:func:`motiondb.database.check_process.check_file` runs this in another process.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from functools import cache
from typing import TypeVar

import duckdb
import numpy as np

from motiondb.errors import MotionDBError, StoreError
from motiondb.files.safe_files import log_of
from motiondb.store.catalogue.captures import load_poses, unflatten_motion
from motiondb.store.catalogue.parquet_files import (
    check_parquet_file,
    load_parquet_files,
    load_part,
)
from motiondb.store.catalogue.places import PlaceError
from motiondb.store.catalogue.sources import load_source
from motiondb.store.connection.faults import damage_sentence
from motiondb.store.connection.handle import Store
from motiondb.store.connection.migrations import present_schema
from motiondb.store.connection.transactions import read_meta
from motiondb.store.grammars import TABLES as GRAMMAR_TABLES
from motiondb.store.learned import SEGMENT_TABLES
from motiondb.store.learned import TABLES as LEARNED_TABLES
from motiondb.store.scenes import TABLES as SCENE_TABLES

Value = TypeVar("Value")

Columns = tuple[tuple[str, str, bool], ...]
"""Of a table, in order: name, type, whether NULL is allowed."""

_COLUMNS = (
    "SELECT table_name, column_name, data_type, is_nullable FROM duckdb_columns() "
    "WHERE NOT internal AND database_name = current_database() AND schema_name = 'main' "
    "ORDER BY table_name, column_index"
)
_KEYS = (
    "SELECT table_name, constraint_column_names[1] FROM duckdb_constraints() "
    "WHERE constraint_type IN ('PRIMARY KEY', 'UNIQUE') AND len(constraint_column_names) = 1 "
    "AND database_name = current_database() ORDER BY ALL"
)  # DuckDB finds rows by keys of one column only
_KEYS_AT_ONCE = 2000
"""Every second one is asked for. Up to about 2,000 rows DuckDB looks into the index, else it reads
the table."""

_HEADERS = 3 * 4096  # Bytes before the first block of a DuckDB file

_TOLERANCE = 1e-4  # By which a sum of probabilities may differ from 1; rounding errs by 1e-12
_UNIT_LENGTH = 1e-3  # By which the length of a quaternion may differ from 1; float32 errs by 1e-6

_RULES = (
    # rule, query for the offenders (one text column)
    (
        "expected one motion of as many frames as its row says",
        """SELECT c.name FROM capture c LEFT JOIN (SELECT capture_id, count(*) AS n,
           max(n_frames) AS length FROM motion GROUP BY ALL) m USING (capture_id)
           WHERE coalesce(n, 0) <> 1 OR length <> motion_frames""",
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
           (PARTITION BY capture_id ORDER BY start_frame, end_frame) AS previous FROM segment)
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
        "expected a score of every segment for every symbol",
        """SELECT c.name FROM (SELECT capture_id, count(*) AS n FROM segment GROUP BY ALL) s
           LEFT JOIN segment_score t USING (capture_id) LEFT JOIN capture c USING (capture_id)
           WHERE coalesce(scores_at.n_bytes // 4, len(scores))
           IS DISTINCT FROM n * (SELECT n_symbols FROM learning)""",
    ),
    (
        "expected one known source for every frame",
        """SELECT c.name FROM capture c JOIN (SELECT capture_id, count(*) AS n, max(frame) AS high,
           count(DISTINCT frame) AS d, max(source_ordinal) AS source FROM frame_source GROUP BY ALL)
           f USING (capture_id) LEFT JOIN (SELECT capture_id, count(*) AS k FROM generated_source
           GROUP BY ALL) g USING (capture_id)
           WHERE n <> motion_frames OR d <> n OR high <> n - 1 OR source >= coalesce(k, 0)""",
    ),
)
_ORIGINALS = (
    "expected the bytes of its file, which it was added with (motiondb add FILE fills them in)",
    """SELECT name FROM capture JOIN run r USING (run_id) JOIN source USING (sha256)
       WHERE r.kind = 'add' AND r.parameters LIKE '%"originals": true%'
       AND octet_length(data) = 0 AND data_at IS NULL ORDER BY ALL""",
)  # It reads the files
_GRAMMAR_RULES = (
    (
        "expected segments that tile its takes",
        """SELECT DISTINCT g.name FROM grammar g JOIN grammar_source c USING (grammar_id)
           LEFT JOIN (SELECT grammar_id, take, min(start_frame) AS low, max(end_frame) AS high,
           bool_and(end_frame > start_frame AND start_frame = previous) AS tiled FROM
           (SELECT *, lag(end_frame, 1, start_frame) OVER (PARTITION BY grammar_id, take
           ORDER BY ordinal) AS previous FROM terminal_segment) GROUP BY ALL) s
           USING (grammar_id, take) WHERE NOT coalesce(tiled, false) OR low <> 0
           OR high <> n_frames ORDER BY ALL""",
    ),
    (
        "expected one medoid for every terminal",
        """SELECT DISTINCT g.name FROM grammar g JOIN terminal t USING (grammar_id)
           LEFT JOIN (SELECT grammar_id, terminal, count(*) AS n FROM terminal_segment
           WHERE is_medoid GROUP BY ALL) s ON s.grammar_id = t.grammar_id
           AND s.terminal = t.ordinal WHERE coalesce(n, 0) <> 1 ORDER BY ALL""",
    ),
    (
        "expected the probabilities of a symbol's rules to sum to 1",
        """SELECT DISTINCT name FROM (SELECT grammar_id, left_symbol FROM grammar_rule
           GROUP BY ALL HAVING abs(sum(probability) - 1) > 1e-6) JOIN grammar USING (grammar_id)
           ORDER BY ALL""",
    ),
    (
        "expected sentences that tile the segments",
        """SELECT name FROM grammar LEFT JOIN (SELECT grammar_id, min(first_segment) AS low,
           max(end_segment) AS high, bool_and(end_segment > first_segment
           AND first_segment = previous) AS tiled FROM (SELECT *, lag(end_segment, 1,
           first_segment) OVER (PARTITION BY grammar_id ORDER BY ordinal) AS previous
           FROM sentence) GROUP BY ALL) s USING (grammar_id) LEFT JOIN (SELECT grammar_id,
           count(*) AS n FROM terminal_segment GROUP BY ALL) t USING (grammar_id)
           WHERE NOT coalesce(tiled, false) OR low <> 0 OR high <> n ORDER BY ALL""",
    ),
)
_SCENE_RULES = (
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

_REFERENCES = (
    # table, column, the table where the number must stand, its column
    ("capture_tag", "capture_id", "capture", "capture_id"),
    ("caption", "capture_id", "capture", "capture_id"),
    ("event", "capture_id", "capture", "capture_id"),
    ("motion", "capture_id", "capture", "capture_id"),
    ("relation", "capture_id", "capture", "capture_id"),
    ("relation", "other_id", "capture", "capture_id"),
    ("generated_source", "capture_id", "capture", "capture_id"),
    ("frame_source", "capture_id", "capture", "capture_id"),
    ("same_file", "capture_id", "capture", "capture_id"),
    ("source", "sha256", "capture", "sha256"),
    ("motion", "poses_at.file_id", "parquet_file", "file_id"),
    ("source", "data_at.file_id", "parquet_file", "file_id"),
    ("source", "skeleton_data_at.file_id", "parquet_file", "file_id"),
    ("segment", "capture_id", "capture", "capture_id"),
    ("segment", "symbol_id", "symbol", "symbol_id"),
    ("segment_score", "capture_id", "segment", "capture_id"),
    ("segment_score", "scores_at.file_id", "parquet_file", "file_id"),
    ("symbol", "cluster_id", "cluster", "cluster_id"),
    ("symbol_state", "symbol_id", "symbol", "symbol_id"),
    ("symbol_distance", "symbol_id", "symbol", "symbol_id"),
    ("symbol_distance", "other_id", "symbol", "symbol_id"),
    ("translation", "symbol_id", "symbol", "symbol_id"),
    ("translation", "word_id", "word", "word_id"),
    ("transition_count", "symbol_id", "symbol", "symbol_id"),
    ("transition_count", "next_id", "symbol", "symbol_id"),
)

_FINISHED = "SELECT run_id FROM run WHERE finished IS NOT NULL"


_LARGE = ("segment_score", "frame_source")
"""Tables with a row a frame or scores of segments, which a quick check does not read."""


def check_quickly(store: Store) -> list[str]:
    """Faults that show without reading motions, scores and files: tables, catalogue, references."""
    try:
        faults = [store.log_note] if store.lacked_log else []
        faults += _cut_short(store) + _wrong_tables(store)
        if faults:
            return faults
        rules = [rule for rule in _RULES if not any(table in rule[1] for table in _LARGE)]
        return _broken(store, rules) + _unresolved(store, _LARGE) + _bad_meta(store)
    except StoreError as error:
        return [str(error)]


def check_store(store: Store, *, sources: bool = False) -> list[str]:
    """Every fault in the store, one sentence each; none if it is sound.

    Nothing is called sound that could not be read. With ``sources`` every stored file is unpacked
    and its digest compared (0.1 s for every 30 MB).
    """
    faults: list[str] = []
    try:
        if store.lacked_log:
            faults.append(store.log_note)
        faults += _cut_short(store)
        damaged = _unreadable_columns(store)
        if damaged:
            listed = "; ".join(f"{table} ({', '.join(c)})" for table, c in damaged.items())
            faults.append(damage_sentence(store.path, f"damaged columns: {listed}."))
        faults += _wrong_tables(store)
        if faults:  # the rules read these tables
            return faults
        faults = _broken(store, (*_RULES, _ORIGINALS)) + _unresolved(store)
        bad_files, missing = _bad_parquet_files(store)
        faults += [*bad_files, *_foreign_rows(store), *_bad_poses(store, missing)]
        faults += _bad_scores(store, missing)
        faults += _bad_meta(store) + _broken(store, _GRAMMAR_RULES, "grammar ")
        faults += _broken(store, _SCENE_RULES, "scene ")
        return faults + (_bad_sources(store, missing) if sources else [])
    except StoreError as error:
        return [*faults, str(error)]


def _cut_short(store: Store) -> list[str]:
    """A sentence if the file ends within a block, or has fewer blocks than are in use.

    The head of a file may count more blocks than there are: DuckDB writes it, and then cuts the
    free blocks off the end. It cuts whole blocks only. Changes that are still in the log beside the
    file have their blocks in memory only.
    """
    if log_of(store.path).exists():
        return []
    ((size, total, used),) = store.connection.execute(
        "SELECT block_size, total_blocks, used_blocks FROM pragma_database_size() "
        "WHERE database_name = current_database()"
    ).fetchall()
    if not size:  # a copy in memory of an older file
        return []
    found = store.path.stat().st_size
    begun = math.ceil((found - _HEADERS) / size)
    expected = _HEADERS + size * max(used, min(begun, total))
    if found >= expected:
        return []
    return [damage_sentence(store.path, f"{found} bytes of {expected}.")]


@cache
def _expected_tables() -> dict[str, Columns]:
    """The tables of ``schema.sql``: name -> columns."""
    with duckdb.connect() as connection:
        connection.execute(present_schema())
        return _to_tables(connection.execute(_COLUMNS).fetchall())


def _wrong_tables(store: Store) -> list[str]:
    """A sentence for every table that differs from ``schema.sql``; others are not looked at."""
    columns_of = _to_tables(store.connection.execute(_COLUMNS).fetchall())
    faults = []
    for table, columns in _expected_tables().items():
        if table not in columns_of:
            faults.append(
                f"{store.path}: expected the table {table} as in schema.sql, found none. "
                "The file was changed by another program: restore a copy."
            )
        elif columns_of[table] != columns:
            faults.append(
                f"{store.path}: expected the table {table} with the columns {_listed(columns)} as "
                f"in schema.sql, found {_listed(columns_of[table])}. "
                "The file was changed by another program: restore a copy."
            )
    return faults


def _unreadable_columns(store: Store) -> dict[str, list[str]]:
    """Table -> its columns that cannot be read to the end, by rows or by their index."""
    connection, damaged = store.connection, {}
    for table, columns in _to_tables(connection.execute(_COLUMNS).fetchall()).items():
        names = [name for name, _type, _null in columns]
        if not _is_readable(store, table, names):
            wrong = [name for name in names if not _is_readable(store, table, [name])]
            damaged[table] = wrong or names
    for table, key in connection.execute(_KEYS).fetchall():
        if table not in damaged and not _is_indexed(store, table, key):
            damaged[table] = [f"index of {key}"]
    return damaged


def _is_readable(store: Store, table: str, columns: list[str]) -> bool:
    """Whether every value of some columns can be read; each goes into a hash."""
    hashes = ", ".join(f'bit_xor(hash("{column}"))' for column in columns)
    try:
        store.connection.execute(f'SELECT {hashes} FROM "{table}"').fetchall()
    except StoreError:
        return False
    return True


def _is_indexed(store: Store, table: str, key: str) -> bool:
    """Whether the index of a key finds every row of a table.

    Asked for every number from the least to the greatest, DuckDB knows without the index that all
    rows have one of them; so every second value is asked for, then the others.
    """
    run = store.connection.execute
    values = sorted(store.connection.column(f'SELECT "{key}" FROM "{table}"'))
    for start in (*range(0, len(values), _KEYS_AT_ONCE), *range(1, len(values), _KEYS_AT_ONCE)):
        some = values[start : start + _KEYS_AT_ONCE : 2]
        query = f'SELECT count(*) FROM "{table}" WHERE "{key}" IN ({", ".join("?" * len(some))})'
        try:
            if run(query, some).fetchone() != (len(some),):
                return False
        except StoreError:
            return False
    return True


def _broken(store: Store, rules: Sequence[tuple[str, str]], kind: str = "") -> list[str]:
    """Which rows break rules."""
    return [
        f"{kind}{name}: {rule}, found others."
        for rule, query in rules
        for name in store.connection.column(query)
    ]


def _foreign_rows(store: Store) -> list[str]:
    """Rows of another run than the one that their table's parent names, or of no parent."""
    learn = f"SELECT run_id FROM learning WHERE run_id IN ({_FINISHED})"
    wanted = [(t, "the finished run of learn", f"run_id NOT IN ({learn})") for t in LEARNED_TABLES]
    wanted += [(t, "a finished run", f"run_id NOT IN ({_FINISHED})") for t in SEGMENT_TABLES]
    for parent, tables in (("grammar", GRAMMAR_TABLES), ("scene", SCENE_TABLES)):
        for table in tables:
            key = f"{parent}_id"
            wanted.append((table, f"a {parent}", f"{key} NOT IN (SELECT {key} FROM {parent})"))
            wanted.append((table, "a finished run", f"run_id NOT IN ({_FINISHED})"))
            if table == "derivation":
                generated = "SELECT capture_id FROM capture WHERE kind = 'generated'"
                condition = f"capture_id NOT IN ({generated})"
                wanted.append((table, "a generated capture", condition))
            else:
                run = f"SELECT run_id FROM {parent} p WHERE p.{key} = {table}.{key}"
                wanted.append((table, f"the run of its {parent}", f"run_id <> ({run})"))
    faults = []
    for table, what, condition in wanted:
        found = store.connection.value(f"SELECT count(*) FROM {table} WHERE {condition}")
        if found:
            faults.append(f"{table}: expected rows of {what}, found {found} others.")
    return faults


def _bad_meta(store: Store) -> list[str]:
    """Keys that the table ``meta`` lacks or whose values are no numbers; lost changes."""
    faults = [store.loss_note] if store.loss_note else []
    for key in ("schema", "next_capture_id", "revision", "motion_revision", "segment_revision"):
        try:
            value = read_meta(store, key)
        except StoreError as error:
            faults.append(str(error))
            continue
        if key not in ("motion_revision", "segment_revision") and not value.isdecimal():
            faults.append(f"meta: expected a number for {key}, found {value!r}.")
    return faults


def _unresolved(store: Store, without: Collection[str] = ()) -> list[str]:
    faults: list[str] = []
    for table, column, target, key in _REFERENCES:
        if table in without:
            continue
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


def _bad_parquet_files(store: Store) -> tuple[list[str], list[int]]:
    """A sentence for every Parquet file that is damaged or missing, and numbers of missing ones."""
    faults, missing = [], []
    for file in load_parquet_files(store):
        try:
            check_parquet_file(store, file)
        except StoreError as error:
            faults.append(str(error))
            if isinstance(error, PlaceError):
                missing.append(file.file_id)
    return faults, missing


def _bad_poses(store: Store, without: Collection[int]) -> list[str]:
    """Motions with numbers that are not finite or quaternions that are not of length 1.

    `without`: Numbers of Parquet files that are not read.
    """
    faults: list[str] = []
    captures = store.connection.execute(
        "SELECT capture_id, name FROM capture WHERE capture_id NOT IN (SELECT capture_id "
        "FROM motion WHERE list_contains(?, poses_at.file_id)) ORDER BY 1",
        [list(without)],
    ).fetchall()
    for number, name in captures:
        try:
            poses = load_poses(store, number)
        except StoreError as error:
            faults.append(f"{name}: {error}")
            continue
        lengths = np.linalg.norm(unflatten_motion(poses).local_rotations, axis=2)
        good = np.isfinite(poses).all(axis=1) & (np.abs(lengths - 1) < _UNIT_LENGTH).all(axis=1)
        if not good.all():
            faults.append(
                f"{name}: expected finite positions and quaternions of length 1, found others "
                f"in frame {int(np.argmin(good))}."
            )
    return faults


def _bad_scores(store: Store, without: Collection[int]) -> list[str]:
    """Captures whose scores in Parquet files, but for some files, are damaged."""
    query = (
        "SELECT scores_at FROM segment_score WHERE scores_at IS NOT NULL "
        "AND NOT list_contains(?, scores_at.file_id) ORDER BY capture_id"
    )
    return _unreadable(store, load_part, store.connection.column(query, [list(without)]))


def _bad_sources(store: Store, without: Collection[int]) -> list[str]:
    query = (
        "SELECT capture_id FROM capture JOIN source USING (sha256) WHERE (octet_length(data) > 0 "
        "OR data_at IS NOT NULL) AND NOT coalesce(list_contains(?, data_at.file_id), false) "
        "ORDER BY ALL"
    )
    return _unreadable(store, load_source, store.connection.column(query, [list(without)]))


def _unreadable(
    store: Store, load: Callable[[Store, Value], object], each: Sequence[Value]
) -> list[str]:
    """What is wrong with those of some values that cannot be loaded."""
    faults: list[str] = []
    for one in each:
        try:
            load(store, one)
        except MotionDBError as error:
            faults.append(str(error))
    return faults


def _to_tables(rows: list[tuple[str, str, str, bool]]) -> dict[str, Columns]:
    tables: dict[str, list[tuple[str, str, bool]]] = {}
    for table, *column in rows:
        name, kind, nullable = column
        tables.setdefault(table, []).append((str(name), str(kind), bool(nullable)))
    return {table: tuple(columns) for table, columns in tables.items()}


def _listed(columns: Columns) -> str:
    return ", ".join(f"{name} {kind}" for name, kind, _null in columns)
