"""Relations: captures that repeat another one, its mirror image or a part of it."""

from __future__ import annotations

from collections.abc import Iterable

from motiondb.errors import QueryError
from motiondb.records import Relation
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


def save_relations(store: Store, relations: Iterable[Relation]) -> None:
    """Add relations between captures.

    A relation replaces an earlier one of the same captures and the same kind.
    """
    numbers = dict(store.connection.execute("SELECT name, capture_id FROM capture").fetchall())
    with transaction(store) as connection:
        for relation in relations:
            for name in (relation.capture, relation.other):
                if name not in numbers:
                    raise QueryError(
                        f"{name!r}: expected the name of a capture, found none in {store.path}."
                    )
            connection.execute(
                "INSERT OR REPLACE INTO relation VALUES (?, ?, ?, ?, ?, ?)",
                [
                    numbers[relation.capture],
                    numbers[relation.other],
                    relation.kind,
                    relation.start,
                    relation.end,
                    relation.distance,
                ],
            )


def load_relations(store: Store, capture: str | None = None) -> list[Relation]:
    """Load all relations, or those of one capture.

    `capture`: Name of a capture: load the relations in which it repeats another capture or is
    repeated. None: load all relations.
    """
    rows = store.connection.execute(
        "SELECT a.name, b.name, r.kind, start_s, end_s, distance FROM relation r "
        "JOIN capture a ON a.capture_id = r.capture_id "
        "JOIN capture b ON b.capture_id = r.other_id "
        "WHERE $name IS NULL OR $name IN (a.name, b.name) ORDER BY a.name, b.name, r.kind",
        {"name": capture},
    ).fetchall()
    return [Relation(*row) for row in rows]
