"""What belongs to captures beside motions: tags, captions, events, relations, synonyms, faults.

Tags, captions, events and synonyms are written by people; each function that saves them replaces
the whole set. Nothing is learned from events, so the learned model remains current. Relations join
captures that repeat another one, its mirror image or a part of it. What captures lack is kept as
findings, and as a number for each second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

from motiondb.errors import QueryError, StoreError
from motiondb.records import Box, Caption, Event, Finding, Quality, Relation
from motiondb.store.catalogue.where import MEASURED
from motiondb.store.connection.handle import Store
from motiondb.store.connection.statements import Connection, columns_of
from motiondb.store.connection.transactions import touch, transaction


def save_tags(store: Store, capture_id: int, tags: Mapping[str, str]) -> None:
    """Replace all tags of a capture."""
    with transaction(store) as connection:
        connection.execute("DELETE FROM capture_tag WHERE capture_id = ?", [capture_id])
        add_tags(connection, {capture_id: tags})


def add_tags(connection: Connection, tags: Mapping[int, Mapping[str, str]]) -> None:
    """Add tags of captures, by their numbers, that have none."""
    rows = [(number, *tag) for number, of_one in tags.items() for tag in of_one.items()]
    connection.insert(
        "capture_tag",
        capture_id=[number for number, _, _ in rows],
        key=[key for _, key, _ in rows],
        value=[str(value) for _, _, value in rows],
    )


def save_captions(store: Store, capture_id: int, captions: Iterable[Caption]) -> None:
    """Replace all captions of a capture; the learned model is then no longer current."""
    with transaction(store) as connection:
        connection.execute("DELETE FROM caption WHERE capture_id = ?", [capture_id])
        add_captions(connection, {capture_id: list(captions)})
        touch(store)


def add_captions(connection: Connection, captions: Mapping[int, Sequence[Caption]]) -> None:
    """Add captions of captures, by their numbers, that have none."""
    rows = [(n, at, each) for n, of_one in captions.items() for at, each in enumerate(of_one)]
    connection.insert(
        "caption",
        capture_id=[number for number, _, _ in rows],
        ordinal=[at for _, at, _ in rows],
        start_s=np.array([each.start for *_, each in rows], dtype=float),  # None is NaN: NULL
        end_s=np.array([each.end for *_, each in rows], dtype=float),
        words=[each.words for *_, each in rows],
    )


def _of_captures(
    store: Store, columns: str, table: str, captures: Iterable[int] | None, order: str
) -> dict[int, list[Any]]:
    """The rows of a table that belong to some captures, by their numbers, or to all."""
    some = "" if captures is None else "WHERE capture_id IN (SELECT unnest($1))"
    rows = store.connection.execute(
        f"SELECT capture_id, {columns} FROM {table} {some} ORDER BY capture_id, {order}",
        [] if captures is None else [list(captures)],
    ).fetchall()
    found: dict[int, list[Any]] = {}
    for number, *row in rows:
        found.setdefault(number, []).append(row)
    return found


def load_tags(store: Store, captures: Iterable[int] | None = None) -> dict[int, dict[str, str]]:
    """Load the tags of some captures, by their numbers, or of all that have any."""
    rows = _of_captures(store, "key, value", "capture_tag", captures, "key")
    return {number: dict(of_one) for number, of_one in rows.items()}


def load_captions(
    store: Store, captures: Iterable[int] | None = None
) -> dict[int, tuple[Caption, ...]]:
    """Load the captions of some captures, by their numbers, or of all."""
    rows = _of_captures(store, "words, start_s, end_s", "caption", captures, "ordinal")
    return {n: tuple(Caption(*each) for each in of_one) for n, of_one in rows.items()}


def load_texts(store: Store) -> dict[str, int]:
    """Load how often each text was written about captures that were not generated."""
    rows = store.connection.execute(
        "SELECT words, count(*) FROM caption JOIN capture USING (capture_id) "
        "WHERE kind = 'captured' GROUP BY words ORDER BY words"
    ).fetchall()
    return dict(rows)


def save_synonyms(store: Store, synonyms: Mapping[str, str]) -> None:
    """Replace the user's synonyms; the learned model is then no longer current."""
    with transaction(store) as connection:
        connection.execute("DELETE FROM synonym")
        connection.insert("synonym", word=list(synonyms), canonical=list(synonyms.values()))
        touch(store)


def load_synonyms(store: Store) -> dict[str, str]:
    """Load the user's synonyms."""
    rows = store.connection.execute("SELECT word, canonical FROM synonym ORDER BY word").fetchall()
    return dict(rows)


def save_events(store: Store, capture_id: int, events: Iterable[Event]) -> None:
    """Replace all events of a capture."""
    rows = sorted(set(events))
    with transaction(store) as connection:
        capture = connection.execute(
            "SELECT name, motion_frames FROM capture WHERE capture_id = ?", [capture_id]
        ).fetchone()
        name, n_frames = capture or (f"capture {capture_id}", 0)
        if rows and not 0 <= rows[0].frame <= rows[-1].frame < n_frames:
            wrong = rows[0] if rows[0].frame < 0 else rows[-1]
            raise StoreError(
                f"{name}: expected events within its {n_frames} frames at 30 a second, found"
                f" {wrong.name!r} at frame {wrong.frame}. Correct the sheet."
            )
        connection.execute("DELETE FROM event WHERE capture_id = ?", [capture_id])
        connection.insert("event", capture_id=capture_id, **columns_of(Event, rows))


def load_events(
    store: Store, captures: Iterable[int] | None = None
) -> dict[int, tuple[Event, ...]]:
    """Load the events of some captures, by their numbers, or of all."""
    columns = "frame, name, joint, other"
    rows = _of_captures(store, columns, "event", captures, columns)
    return {n: tuple(Event(*each) for each in of_one) for n, of_one in rows.items()}


def save_relations(store: Store, relations: Iterable[Relation]) -> None:
    """Add relations, each in the place of an earlier one of its captures and kind."""
    numbers = dict(store.connection.execute("SELECT name, capture_id FROM capture").fetchall())
    rows = {(r.capture, r.other, r.kind): r for r in relations}
    for name in (name for capture, other, _kind in rows for name in (capture, other)):
        if name not in numbers:
            raise QueryError(
                f"{name!r}: expected the name of a capture, found none in {store.path}."
            )
    with transaction(store) as connection:
        connection.insert_or_replace(
            "relation",
            capture_id=[numbers[capture] for capture, _, _ in rows],
            other_id=[numbers[other] for _, other, _ in rows],
            kind=[kind for _, _, kind in rows],
            start_s=[relation.start for relation in rows.values()],
            end_s=[relation.end for relation in rows.values()],
            distance=[relation.distance for relation in rows.values()],
        )


def load_relations(store: Store, capture: str | None = None) -> list[Relation]:
    """Load all relations, or those in which a capture repeats another one or is repeated."""
    rows = store.connection.execute(
        "SELECT a.name, b.name, r.kind, start_s, end_s, distance FROM relation r "
        "JOIN capture a ON a.capture_id = r.capture_id "
        "JOIN capture b ON b.capture_id = r.other_id "
        "WHERE $name IS NULL OR $name IN (a.name, b.name) ORDER BY a.name, b.name, r.kind",
        {"name": capture},
    ).fetchall()
    return [Relation(*row) for row in rows]


def save_quality(store: Store, found: Mapping[int, Quality], run_id: int) -> None:
    """Save what some captures lack, by their numbers, in place of what was saved of them."""
    with transaction(store) as connection:
        for number, quality in found.items():
            for table in ("finding", "capture_quality"):
                connection.execute(f"DELETE FROM {table} WHERE capture_id = ?", [number])
            connection.insert_row(
                "capture_quality",
                number,
                quality.seconds.tolist(),
                list(quality.untold),
                quality.floor,
                list(chain.from_iterable(quality.flights)),
                run_id,
            )
            for ordinal, finding in enumerate(quality.findings):
                *values, place, boxes = vars(finding).values()
                connection.insert_row(
                    "finding",
                    number,
                    ordinal,
                    *values,
                    None if place is None else list(place),
                    [number for box in boxes for number in (*box.centre, *box.size)],
                    run_id,
                )


def load_quality(store: Store, captures: Iterable[int] | None = None) -> dict[int, Quality]:
    """Load what some captures lack, by their numbers, or all of which it is known."""
    some = None if captures is None else list(captures)
    columns = "* EXCLUDE (capture_id, ordinal, run_id)"  # those of a finding, in its order
    findings = _of_captures(store, columns, "finding", some, "ordinal")
    rows = _of_captures(store, "seconds, untold, floor, flights", "capture_quality", some, "run_id")
    return {
        number: Quality(
            tuple(map(_to_finding, findings.get(number, ()))),
            tuple(untold),
            np.array(seconds),
            floor,
            tuple(zip(flights[::2], flights[1::2])),
        )
        for number, [(seconds, untold, floor, flights)] in rows.items()
    }


def _to_finding(row: Sequence[Any]) -> Finding:
    """A finding of its columns; a box is six numbers, of its centre and its size."""
    *values, place, numbers = row
    boxes = (numbers[k : k + 6] for k in range(0, len(numbers), 6))
    at = None if place is None else tuple(place)
    things = tuple(Box(tuple(box[:3]), tuple(box[3:])) for box in boxes)
    fields: list[Any] = [*values, at, things]
    return Finding(*fields)


UNMEASURED: Mapping[str, Sequence[str]] = dict.fromkeys(MEASURED.values(), ())


def load_measured(store: Store, n_captures: int) -> dict[int, Mapping[str, Sequence[str]]]:
    """Load what filters ask of every capture (``MEASURED``), where it is known of all."""
    rows = store.connection.execute(
        "SELECT capture_id, list_avg(seconds), list(DISTINCT kind) FILTER (kind NOTNULL), "
        "list(DISTINCT family) FILTER (family NOTNULL) "
        "FROM capture_quality LEFT JOIN finding USING (capture_id) GROUP BY ALL"
    ).fetchall()
    if len(rows) < n_captures:
        raise QueryError(
            f"filter on quality: expected all {n_captures} captures looked at, found {len(rows)}. "
            "Run motiondb quality first."
        )
    return {
        number: {
            MEASURED["quality"]: (str(mean),),
            MEASURED["finding"]: (*(kinds or ()), *(families or ())),
        }
        for number, mean, kinds, families in rows
    }
