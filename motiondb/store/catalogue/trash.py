"""Removed captures: their rows wait in the schema ``trash`` until the file is compacted.

A table of the trash has the columns of its table in ``main``, and is made when it is first needed.
A capture keeps its number in the trash, and so when it is restored.
"""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.errors import QueryError
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import touch, transaction

OWN_TABLES = (
    "capture",
    "capture_tag",
    "caption",
    "event",
    "motion",
    "generated_source",
    "frame_source",
    "derivation",
    "same_file",
    "scene_player",
)  # Whose rows have the number of their capture
_OF_CAPTURE = {
    **dict.fromkeys(OWN_TABLES, "capture_id IN (SELECT unnest($numbers))"),
    "relation": "(capture_id IN (SELECT unnest($numbers)) "
    "OR other_id IN (SELECT unnest($numbers)))",
    "source": "sha256 IN (SELECT sha256 FROM {schema}.capture "
    "WHERE capture_id IN (SELECT unnest($numbers)))",
}  # Table -> its rows that belong to captures
_THERE = {
    "relation": "AND capture_id IN (SELECT capture_id FROM main.capture) "
    "AND other_id IN (SELECT capture_id FROM main.capture)",
    "derivation": "AND EXISTS (FROM main.grammar g WHERE g.grammar_id = derivation.grammar_id "
    "AND g.run_id <= derivation.run_id)",
}  # Table -> which of the rows can be restored: those of captures and grammars that are there
_ONCE = "AND sha256 NOT IN (SELECT sha256 FROM trash.source)"
_LAST = "AND (SELECT count(*) FROM trash.capture c WHERE c.sha256 = source.sha256) = 1"
_LEFT_OUT = "octet_length(data) = 0 AND data_at IS NULL"
# The same content may be removed twice: its source is kept once, until the last of them is
# restored; one without its bytes makes place for any other


def put_in_trash(store: Store, numbers: Sequence[int]) -> None:
    """Copy captures and everything that belongs to them into the trash; inside a transaction."""
    connection, asked = store.connection, {"numbers": list(numbers)}
    connection.execute("CREATE SCHEMA IF NOT EXISTS trash")
    for table, rows in _OF_CAPTURE.items():
        connection.execute(
            f"CREATE TABLE IF NOT EXISTS trash.{table} AS SELECT * FROM main.{table} LIMIT 0"
        )
        rows = rows.format(schema="main")
        if table == "source":
            connection.execute(f"DELETE FROM trash.source WHERE {rows} AND {_LEFT_OUT}", asked)
            rows = f"{rows} {_ONCE}"
        connection.execute(
            f"INSERT INTO trash.{table} BY NAME SELECT * FROM main.{table} WHERE {rows}", asked
        )


def restore_captures(store: Store, numbers: Sequence[int]) -> None:
    """Take captures out of the trash, in one transaction; QueryError if one is not there."""
    if not numbers:
        return
    with transaction(store) as connection:
        asked = {"numbers": list(numbers)}
        for number in sorted(set(numbers) - dict(load_trash(store)).keys()):
            raise QueryError(
                f"capture {number}: expected it in the trash, found that it was emptied "
                "(motiondb compact). Add the file again."
            )
        taken = connection.execute(
            "SELECT t.name, c.name FROM capture c JOIN trash.capture t "
            "ON c.name = t.name OR c.sha256 = t.sha256 "
            "WHERE t.capture_id IN (SELECT unnest($numbers)) ORDER BY t.capture_id",
            asked,
        ).fetchone()
        if taken is not None:
            raise QueryError(
                f"{taken[0]}: expected its name and its content to be free, found the capture"
                f" {taken[1]}. Rename or remove that one first."
            )
        for table, rows in _OF_CAPTURE.items():
            if table != "scene_player":
                rows = f"{rows.format(schema='trash')} {_THERE.get(table, '')}"
                once = "DISTINCT ON (sha256)" if table == "source" else ""
                connection.execute(
                    f"INSERT INTO main.{table} BY NAME SELECT {once} * FROM trash.{table} "
                    f"WHERE {rows}",
                    asked,
                )
        connection.execute(
            "UPDATE main.scene_player p SET capture_id = t.capture_id "
            "FROM trash.scene_player t WHERE t.capture_id IN (SELECT unnest($numbers)) "
            "AND p.capture_id = -1 AND p.scene_id = t.scene_id "
            "AND p.ordinal = t.ordinal AND p.run_id = t.run_id",
            asked,
        )
        for table in reversed(_OF_CAPTURE):  # the source is found by the capture
            only = _LAST if table == "source" else _THERE.get(table, "")
            rows = f"{_OF_CAPTURE[table].format(schema='trash')} {only}"
            connection.execute(f"DELETE FROM trash.{table} WHERE {rows}", asked)
        touch(store, motions=True)


def load_trash(store: Store) -> list[tuple[int, str]]:
    """Load number and name of the captures in the trash, in order of number."""
    if not _is_there(store):
        return []
    query = "SELECT capture_id, name FROM trash.capture ORDER BY capture_id"
    return [(int(number), str(name)) for number, name in store.connection.execute(query).fetchall()]


def empty_trash(store: Store) -> None:
    """Remove for good what is in the trash."""
    if _is_there(store):
        with transaction(store) as connection:
            connection.execute("DROP SCHEMA trash CASCADE")


def _is_there(store: Store) -> bool:
    query = "SELECT count(*) FROM duckdb_tables() WHERE schema_name = 'trash' AND table_name ="
    return bool(store.connection.value(f"{query} 'capture' AND database_name = current_database()"))
