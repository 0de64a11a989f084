"""Events of captures: foot strikes, catches, releases, contacts.

The events of a capture are replaced as a whole. Nothing is learned from events, so the learned
model remains current.
"""

from __future__ import annotations

from collections.abc import Iterable

from motiondb.errors import StoreError
from motiondb.records import Event
from motiondb.store.connection.columns import insert
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction


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
        insert(
            connection,
            "event",
            capture_id=[capture_id] * len(rows),
            frame=[row.frame for row in rows],
            name=[row.name for row in rows],
            joint=[row.joint for row in rows],
            other=[row.other for row in rows],
        )


def load_events(store: Store, capture_id: int | None = None) -> dict[int, tuple[Event, ...]]:
    """Load the events of one capture or of all captures."""
    some = "" if capture_id is None else "WHERE capture_id = ?"
    rows = store.connection.execute(
        f"SELECT capture_id, frame, name, joint, other FROM event {some} ORDER BY ALL",
        [] if capture_id is None else [capture_id],
    ).fetchall()
    events: dict[int, list[Event]] = {}
    for number, *event in rows:
        events.setdefault(number, []).append(Event(*event))
    return {number: tuple(of_one) for number, of_one in events.items()}
