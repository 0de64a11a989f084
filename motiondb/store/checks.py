"""Check the store: every value readable, all tables present, no rule broken.

DuckDB compares a block of the file with its checksum when it reads the block. So every column of
every table is read, and every row is found by its key, which reads the indexes that questions use.

The rules of the tables stand in ``rules.sql`` beside ``schema.sql``.

DuckDB may crash on a file that is damaged in a way it does not expect: to check a file,
:func:`motiondb.database.checking.check_file` runs this in another process.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

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
from motiondb.store.connection.migrations import present_schema, rules_text

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

_UNIT_LENGTH = 1e-3  # By which the length of a quaternion may differ from 1; float32 errs by 1e-6


def check_quickly(store: Store) -> list[str]:
    """Faults that show without reading motions, scores and files: tables, catalogue, references."""
    try:
        faults = [store.log_note] if store.lacked_log else []
        faults += _cut_short(store) + _wrong_tables(store)
        return faults or _broken(store, quick=True)
    except StoreError as error:
        return [str(error)]


def check_store(store: Store, *, sources: bool = False) -> list[str]:
    """Every fault in the store, one sentence each; none if it is sound.

    Nothing is called sound that could not be read. With ``sources`` every stored file is unpacked
    and its digest compared (0.1 s for every 30 MB).
    """
    faults = [store.log_note] if store.lacked_log else []
    try:
        faults += _cut_short(store)
        damaged = _unreadable_columns(store)
        if damaged:
            listed = "; ".join(f"{table} ({', '.join(c)})" for table, c in damaged.items())
            faults.append(damage_sentence(store.path, f"damaged columns: {listed}."))
        faults += _wrong_tables(store)
        if faults:  # the rules read these tables
            return faults
        faults = _broken(store)
        missing = list[int]()  # Parquet files, which are told once
        for file in load_parquet_files(store):
            try:
                check_parquet_file(store, file)
            except StoreError as error:
                faults.append(str(error))
                missing += [file.file_id] if isinstance(error, PlaceError) else []
        loads: Sequence[Callable[[Store, Any], object]] = (_check_poses, load_part, load_source)
        for load, query in zip(loads, _READ if sources else _READ[:2]):
            for value in store.connection.column(query, [missing]):
                try:
                    load(store, value)
                except MotionDBError as error:
                    faults.append(str(error))
    except StoreError as error:
        faults.append(str(error))
    return faults


_READ = (
    "SELECT capture_id FROM capture WHERE capture_id NOT IN "
    "(SELECT capture_id FROM motion WHERE list_contains(?, poses_at.file_id)) ORDER BY 1",
    "SELECT scores_at FROM segment_score WHERE scores_at IS NOT NULL "
    "AND NOT list_contains(?, scores_at.file_id) ORDER BY capture_id",
    "SELECT capture_id FROM capture JOIN source USING (sha256) WHERE (octet_length(data) > 0 "
    "OR data_at IS NOT NULL) AND NOT coalesce(list_contains(?, data_at.file_id), false) "
    "ORDER BY ALL",
)
"""Motions, scores in Parquet files, and files, but for those that lie in some Parquet files."""


@cache
def _rules() -> list[tuple[str, str, bool]]:
    """Sentence and query of every rule of ``rules.sql``, and whether a quick check asks it."""
    rules = []
    for block in rules_text().split("\n\n"):
        comments = [line[3:] for line in block.splitlines() if line.startswith("--")]
        query = "\n".join(block.splitlines()[len(comments) :])
        names, *table = [line[2:].split(" | ") for line in comments if line[:1] == "|"] or [[], []]
        sentence = " ".join(line for line in comments if line[:1] != "|" and line != "not quick")
        for values in table if query else ():
            texts = [sentence, query]
            for name, value in zip(names, values, strict=True):
                texts = [text.replace(f"{{{name}}}", value) for text in texts]
            rules.append((texts[0], texts[1], "not quick" not in comments))
    return rules


def _broken(store: Store, *, quick: bool = False) -> list[str]:
    """A sentence for every row that breaks a rule; for changes that were lost, another one."""
    found = [
        sentence.format(*row)
        for sentence, query, is_quick in _rules()
        if is_quick or not quick
        for row in sorted(store.connection.execute(query).fetchall(), key=repr)
    ]
    return [*found, store.loss_note] if store.loss_note else found


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


def _check_poses(store: Store, capture_id: int) -> None:
    """Refuse a motion with numbers that are not finite or quaternions that are not of length 1."""
    name = store.connection.value("SELECT name FROM capture WHERE capture_id = ?", [capture_id])
    try:
        poses = load_poses(store, capture_id)
    except StoreError as error:
        raise StoreError(f"{name}: {error}") from error
    lengths = np.linalg.norm(unflatten_motion(poses).local_rotations, axis=2)
    good = np.isfinite(poses).all(axis=1) & (np.abs(lengths - 1) < _UNIT_LENGTH).all(axis=1)
    if not good.all():
        raise StoreError(
            f"{name}: expected finite positions and quaternions of length 1, found others in frame "
            f"{int(np.argmin(good))}."
        )


def _to_tables(rows: list[tuple[str, str, str, bool]]) -> dict[str, Columns]:
    tables: dict[str, list[tuple[str, str, bool]]] = {}
    for table, *column in rows:
        name, kind, nullable = column
        tables.setdefault(table, []).append((str(name), str(kind), bool(nullable)))
    return {table: tuple(columns) for table, columns in tables.items()}


def _listed(columns: Columns) -> str:
    return ", ".join(f"{name} {kind}" for name, kind, _null in columns)
