"""Events are kept, replaced, refused outside the motion, and go with their capture."""

from __future__ import annotations

from types import ModuleType

import pytest

from motiondb import store
from motiondb.errors import StoreError
from motiondb.records import Event

CATCH = Event(3, "catch", "r_wrist", "ball")
STEP = Event(7, "foot_strike", "l_ankle", "ground")


def test_events_come_back_in_order_and_replace_earlier_ones(
    database: store.Store, samples: ModuleType
) -> None:
    first, second = samples.add(database, "a"), samples.add(database, "b")
    store.save_events(database, first.capture_id, [STEP, CATCH, STEP])
    store.save_events(database, second.capture_id, [CATCH])
    assert store.load_events(database) == {
        first.capture_id: (CATCH, STEP),
        second.capture_id: (CATCH,),
    }
    store.save_events(database, first.capture_id, [STEP])
    assert store.load_events(database, [first.capture_id]) == {first.capture_id: (STEP,)}
    store.save_events(database, first.capture_id, [])
    assert store.load_events(database, [first.capture_id]) == {}


def test_an_event_outside_the_motion_is_refused_and_nothing_changes(
    database: store.Store, samples: ModuleType
) -> None:
    info = samples.add(database, "a")
    store.save_events(database, info.capture_id, [CATCH])
    for frame in (-1, info.motion_frames):
        with pytest.raises(StoreError) as error:
            store.save_events(database, info.capture_id, [STEP, Event(frame, "release")])
        assert str(error.value) == (
            f"a: expected events within its {info.motion_frames} frames at 30 a second, found "
            f"'release' at frame {frame}. Correct the sheet."
        )
    assert store.load_events(database) == {info.capture_id: (CATCH,)}


def test_events_go_with_their_capture_and_leave_the_revision(
    database: store.Store, samples: ModuleType
) -> None:
    info = samples.add(database, "a")
    before = store.content_revision(database)
    store.save_events(database, info.capture_id, [CATCH])
    assert store.content_revision(database) == before
    store.remove_captures(database, [info.capture_id])
    assert store.content_revision(database) != before
    assert store.load_events(database) == {}
    assert store.check_store(database) == []


def test_check_finds_events_of_nobody_and_after_the_end(
    database: store.Store, samples: ModuleType
) -> None:
    info = samples.add(database, "a")
    row = "INSERT INTO event VALUES (?, ?, 'catch', '', '')"
    database.connection.execute(row, [info.capture_id, info.motion_frames])
    database.connection.execute(row, [info.capture_id + 50, 0])
    assert store.check_store(database) == [
        "a: expected events within its motion, found others.",
        f"event: expected every capture_id in capture, found 1 rows without, such as "
        f"{info.capture_id + 50}.",
    ]
