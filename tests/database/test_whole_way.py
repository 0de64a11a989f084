"""Questions to a database that learned from the sample data, whose truth is known."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from motiondb.errors import QueryError


@pytest.fixture(scope="module")
def db(learned_file: Path) -> Iterator[MotionDB]:
    with motiondb.open(learned_file, read_only=True) as opened:
        yield opened


@pytest.fixture(scope="module")
def labels(samples_sheet: Path) -> dict[str, list[tuple[float, float, str]]]:
    """capture -> (start, end, label), seconds: how the sample captures were made."""
    truth: dict[str, list[tuple[float, float, str]]] = {}
    with samples_sheet.with_name("segments.tsv").open() as file:
        for row in csv.DictReader(file, delimiter="\t"):
            part = (float(row["start_s"]), float(row["end_s"]), row["label"])
            truth.setdefault(row["file"].removesuffix(".bvh"), []).append(part)
    return truth


@pytest.mark.parametrize(
    ("question", "label"),
    [("bow", "bow"), ("sit down", "sit"), ("dribble", "dribble")],
)
def test_words_find_what_shows_them(
    db: MotionDB, labels: dict[str, list[tuple[float, float, str]]], question: str, label: str
) -> None:
    answer = db.search(question, limit=3)
    assert [m.rank for m in answer.matches] == [1, 2, 3]
    assert sorted((m.score for m in answer.matches), reverse=True) == [
        m.score for m in answer.matches
    ]
    first = answer.matches[0]
    assert 0.0 <= first.start < first.end
    inside = [x for a, b, x in labels[first.capture] if a < first.end and b > first.start]
    assert any(label in x for x in inside), inside


def test_actions_are_found_in_their_order(db: MotionDB) -> None:
    answer = db.search("walk, turn left, sit down", limit=1)
    assert answer.actions == (("walk",), ("turn", "left"), ("sit", "down"))
    (match,) = answer.matches
    assert "long" in match.capture
    assert match.reason.count(" s") >= 3


def test_unknown_words_are_named_and_the_rest_answered(db: MotionDB) -> None:
    answer = db.search("wlak, kick", limit=2)
    assert dict(answer.unknown) == {"wlak": ("walk",)}
    assert [m.words for m in answer.matches] == [("kick",), ("kick",)]
    with pytest.raises(QueryError, match="in the captions, found 'xyzzy'"):
        db.search("xyzzy")
    with pytest.raises(QueryError, match="Ask for example for"):
        db.search("  ")


def test_filter_and_limit(db: MotionDB) -> None:
    matches = db.search("walk", where="performer=ana", limit=2).matches
    assert len(matches) == 2
    assert {m.capture.split("/")[0] for m in matches} == {"ana"}
    assert {m.capture[:4] for m in db.like("emil/bow_1", where="performer=dora")} == {"dora"}
    with pytest.raises(QueryError, match="Did you mean performer"):
        db.search("walk", where="performr=ana")


@pytest.mark.parametrize("name", ["ana/bow_1", "fatou/layup_1"])
def test_a_stored_capture_finds_itself(db: MotionDB, samples_folder: Path, name: str) -> None:
    info = store.load_capture(db.store, name)
    for example in (name, samples_folder / f"{name}.bvh"):
        first = db.like(example, limit=1)[0]
        assert first.capture == name
        assert (first.start, first.end) == pytest.approx((0.0, info.duration), abs=0.2)


def test_a_part_finds_its_place(db: MotionDB) -> None:
    first = db.like("ana/long_1", 2.0, 4.5, limit=1)[0]
    assert first.capture == "ana/long_1"
    assert (first.start, first.end) == pytest.approx((2.0, 4.5), abs=0.2)
    with pytest.raises(QueryError, match="expected an interval within 0 to"):
        db.like("ana/bow_1", 40.0, 50.0)


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


def test_decoded_search_carries_its_certificate(db: MotionDB) -> None:
    answer = db.search("walk", by_symbols=True, limit=3)
    assert answer.decoding is not None
    assert answer.decoding.certificate in ("optimal", "beam-limited")
    assert answer.matches[0].score == pytest.approx(1.0)


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


def test_every_frame_has_an_origin_with_its_licence(db: MotionDB) -> None:
    made = db.generate("a person walks then kicks", 7)
    actual = made.provenance
    assert (actual.source_numbers >= 0).all()
    for number, source in enumerate(actual.sources):
        info = store.load_capture(db.store, source.name)
        frames = actual.source_frames[actual.source_numbers == number]
        assert len(frames)
        assert (frames >= 0).all()
        assert (frames < info.motion_frames).all()
        assert source.licence == "CC0-1.0"


def test_a_kept_generated_capture_names_its_sources(learned_copy: Path) -> None:

    with motiondb.open(learned_copy) as db:
        made = db.generate("a person walks then kicks", 7)
        db.save_generated("made/one", "a person walks then kicks", made, 7)
        facts = db.show("made/one")
        assert facts.kind == "generated"
        assert facts.tags["licence"] == "CC0-1.0"
        assert len(facts.sources) == len(made.provenance.sources)
        assert all("licence CC0-1.0" in line for line in facts.sources)
        assert db.unlearned() == []
        assert db.check() == []
        with pytest.raises(QueryError, match="made/one: expected a name that is free"):
            db.check_name_free("made/one")


def test_read_only_refuses_to_write(db: MotionDB) -> None:
    with pytest.raises(motiondb.MotionDBError, match="found one opened for reading"):
        db.set_words("ana/bow_1", "x")
