"""What captures lack: findings, and a number for each second."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

from motiondb.errors import QueryError
from motiondb.records import Box, Finding, Quality
from motiondb.store.catalogue.where import MEASURED
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction

_COLUMNS = (
    "kind",
    "family",
    "start_s",
    "end_s",
    "measure",
    "unit",
    "threshold",
    "part",
    "sentence",
    "place",
    "boxes",
)  # Of a finding, in the order of the record's fields


def save_quality(store: Store, found: Mapping[int, Quality], run_id: int) -> None:
    """Save what some captures lack, by their numbers, in place of what was saved of them."""
    with transaction(store) as connection:
        for number, quality in found.items():
            for table in ("finding", "capture_quality"):
                connection.execute(f"DELETE FROM {table} WHERE capture_id = ?", [number])
            connection.execute(
                "INSERT INTO capture_quality VALUES (?, ?, ?, ?, ?, ?)",
                [
                    number,
                    quality.seconds.tolist(),
                    list(quality.untold),
                    quality.floor,
                    list(chain.from_iterable(quality.flights)),
                    run_id,
                ],
            )
            for ordinal, finding in enumerate(quality.findings):
                *values, place, boxes = vars(finding).values()
                connection.execute(
                    f"INSERT INTO finding VALUES ({', '.join('?' * 14)})",
                    [
                        number,
                        ordinal,
                        *values,
                        None if place is None else list(place),
                        [number for box in boxes for number in (*box.centre, *box.size)],
                        run_id,
                    ],
                )


def load_quality(store: Store, captures: Iterable[int] | None = None) -> dict[int, Quality]:
    """Load what some captures lack, by their numbers, or all of which it is known."""
    some = "" if captures is None else "WHERE capture_id IN (SELECT unnest($1))"
    chosen = [] if captures is None else [list(captures)]
    found: dict[int, list[Finding]] = {}
    for number, *values, place, boxes in store.connection.execute(
        f"SELECT capture_id, {', '.join(_COLUMNS)} FROM finding {some} "
        "ORDER BY capture_id, ordinal",
        chosen,
    ).fetchall():
        at = None if place is None else tuple(place)
        things = tuple(
            Box(tuple(boxes[k : k + 3]), tuple(boxes[k + 3 : k + 6]))
            for k in range(0, len(boxes), 6)
        )
        fields: list[Any] = [*values, at, things]
        found.setdefault(number, []).append(Finding(*fields))
    rows = store.connection.execute(
        f"SELECT capture_id, seconds, untold, floor, flights FROM capture_quality {some} "
        "ORDER BY capture_id",
        chosen,
    ).fetchall()
    return {
        number: Quality(
            tuple(found.get(number, ())),
            tuple(untold),
            np.array(seconds),
            floor,
            tuple(zip(flights[::2], flights[1::2])),
        )
        for number, seconds, untold, floor, flights in rows
    }


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
