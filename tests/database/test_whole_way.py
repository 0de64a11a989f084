"""Questions to a database that learned from the sample data, whose truth is known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from motiondb.errors import QueryError


def test_filter_and_limit(db: MotionDB) -> None:
    matches = db.search("walk", where="performer=ana", limit=2).matches
    assert len(matches) == 2
    assert {m.capture.split("/")[0] for m in matches} == {"ana"}
    assert {m.capture[:4] for m in db.like("emil/bow_1", where="performer=dora")} == {"dora"}
    with pytest.raises(QueryError, match="Did you mean performer"):
        db.search("walk", where="performr=ana")


def test_a_file_finds_the_stored_capture(db: MotionDB, samples_folder: Path) -> None:
    info = store.load_capture(db.store, "fatou/layup_1")
    first = db.like(samples_folder / "fatou/layup_1.bvh", limit=1)[0]
    assert first.capture == "fatou/layup_1"
    assert (first.start, first.end) == pytest.approx((0.0, info.duration), abs=0.2)


@pytest.mark.parametrize(
    "at", [{"start": 40.0, "end": 50.0}, {"start": math.inf}, {"end": math.inf}]
)
def test_a_part_outside_the_example_is_refused(db: MotionDB, at: dict[str, float]) -> None:
    with pytest.raises(QueryError, match="expected an interval within 0 to"):
        db.like("ana/bow_1", **at)


def test_description_tiles_the_motion(db: MotionDB) -> None:
    told = db.describe("ana/bow_1")
    assert told[0].start == 0.0
    assert told[-1].end == pytest.approx(store.load_capture(db.store, "ana/bow_1").duration)
    assert [d.end for d in told[:-1]] == [d.start for d in told[1:]]
    assert "bow" in {d.words[0][0] for d in told}
    for d in told:
        probabilities = [p for _, p in d.words]
        assert probabilities == sorted(probabilities, reverse=True)
        assert all(0.0 <= p <= 1.0 for p in probabilities)


@pytest.mark.parametrize("method", ["stitched", "trajectory"])
def test_same_seed_generates_the_same(db: MotionDB, tmp_path: Path, method: str) -> None:
    one, two = (db.generate("a person walks then kicks", 7, method) for _ in range(2))
    for name, made in (("a", one), ("b", two)):
        made.write(tmp_path / f"{name}.bvh")
    assert (tmp_path / "a.bvh").read_bytes() == (tmp_path / "b.bvh").read_bytes()
    assert one.actions == (("walk",), ("kick",))
    assert np.isfinite(one.motion.root_positions).all()
    assert len(one.provenance.edits) == one.motion.n_frames
    with pytest.raises(QueryError, match="expected one of stitched, trajectory,"):
        db.generate("walk", 0, "magic")


def test_a_kept_generated_capture_names_its_sources(learned_copy: Path) -> None:

    with motiondb.open(learned_copy) as db:
        made = db.generate("a person walks then kicks", 7)
        db.captures.save_generated("made/one", "a person walks then kicks", made, 7)
        facts = db.captures.show("made/one")
        assert facts.kind == "generated"
        assert facts.tags["licence"] == "CC0-1.0"
        assert len(facts.sources) == len(made.provenance.sources)
        assert all("licence CC0-1.0" in line for line in facts.sources)
        assert db.captures.unlearned() == []
        assert db.check() == []
        with pytest.raises(QueryError, match="made/one: expected a name that is free"):
            db.captures.check_name_free("made/one")
