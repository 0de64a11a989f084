"""Which captures repeat others: the same motion, its mirror image, or a cut of it."""

from __future__ import annotations

from collections.abc import Iterable

from motiondb.errors import QueryError
from motiondb.records import Relation
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


def save_relations(store: Store, relations: Iterable[Relation]) -> None:
    """Add relations; one of the same captures and kind replaces the earlier.

    Raises
    ------
    QueryError : a name that is no capture's.
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
    """All relations, or those in which ``capture`` stands on either side, by names."""
    rows = store.connection.execute(
        "SELECT a.name, b.name, r.kind, start_s, end_s, distance FROM relation r "
        "JOIN capture a ON a.capture_id = r.capture_id "
        "JOIN capture b ON b.capture_id = r.other_id "
        "WHERE $name IS NULL OR $name IN (a.name, b.name) ORDER BY a.name, b.name, r.kind",
        {"name": capture},
    ).fetchall()
    return [Relation(*row) for row in rows]
