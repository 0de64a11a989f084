"""Generated captures that were kept are found, marked as such, and teach nothing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.database import MotionDB


@pytest.fixture
def db(learned_copy: Path) -> Iterator[MotionDB]:
    with motiondb.open(learned_copy) as opened:
        yield opened


def test_a_kept_generated_capture_is_found_and_marked(db: MotionDB) -> None:
    before = db.like("goran/kick_1", limit=3)
    made = db.generate("a person kicks", seed=3)
    db.save_generated("made/kick", "a person kicks", made, 3)
    nearest = db.like("made/kick", limit=1)[0]
    assert (nearest.capture, nearest.reason) == ("made/kick", "generated")
    assert {m.capture for m in db.like("goran/kick_1", where="kind=captured", limit=3)} == {
        m.capture for m in before
    }
    actual = db.search("kick", where="kind=generated").matches
    assert [m.capture for m in actual] == ["made/kick"]
    assert actual[0].reason.endswith("; generated")
    assert db.search("kick", where="kind=captured", limit=1).matches[0].reason.endswith(" s")


def test_generated_captures_are_no_material(db: MotionDB) -> None:
    made = db.generate("a person kicks", seed=3)
    db.save_generated("made/kick", "a person kicks", made, 3)
    again = db.generate("a person kicks", seed=3)
    np.testing.assert_array_equal(again.motion.local_rotations, made.motion.local_rotations)
    number = db.captures("kind=generated")[0].capture_id
    assert number in db.searchable.rows
    assert number not in db.learned.rows
    assert (np.diff(db.searchable.segments.capture_ids) >= 0).all()
