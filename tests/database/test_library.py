"""What to train on, what a library lacks, what another one has: on captures with known answers."""

from __future__ import annotations

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import CurateSettings, MotionDB, QueryError, store
from motiondb.body.body import INDEX
from motiondb.database import curating
from motiondb.database.catalogue import packs
from motiondb.files.formats import read_capture
from motiondb.records import Clip, Finding, Quality

JUMP = Finding("jumps", "fault", 0.0, 9.0, 0.2, "m", 0.1, "l_wrist", "the left wrist jumps")
SEAT = Finding("sits", "needs", 0.0, 9.0, 0.5, "m", 0.1, "seat", "sits on something 50 cm high")


@pytest.fixture
def base(tmp_path: Path, some: Path) -> MotionDB:
    """Four captures of two performers without faults, and a copy of one."""
    shutil.copy(some / "ana" / "bow_1.bvh", some / "boris" / "same_1.bvh")
    with (some / "boris" / "same_1.bvh").open("a") as file:
        file.write("\n")
    with motiondb.open(tmp_path / "motions.duckdb") as db:
        db.add(some)
        db.captures.set_tags({"licence": "free"}, where="name~ana")
        keep(db, {})
        yield db


def keep(db: MotionDB, lacks: dict[str, tuple[float, Finding]]) -> None:
    """Say what captures lack: a number of all seconds, and a finding."""
    found = {}
    for info in db.captures():
        number, *findings = lacks.get(info.name, (0.9,))
        seconds = np.full(int(np.ceil(info.duration)), number)
        found[info.capture_id] = Quality(tuple(findings), (), seconds, 0.0, ())
    with store.running(db.store, "quality") as run_id:
        store.save_quality(db.store, found, run_id)


def seconds_of(answer: motiondb.answers.CurateAnswer) -> float:
    chosen = sum(each.end - each.start for each in answer.intervals)
    return chosen + sum(each.end - each.start for each in answer.dropped)


def test_every_second_is_chosen_or_has_a_reason(base: MotionDB) -> None:
    lacks = {"ana/jump_1": (0.3, JUMP), "boris/kick_1": (0.9, SEAT)}
    keep(base, lacks)
    answer = base.curate(CurateSettings(share=1.0, shortest=1.0))
    by_name = {each.capture: each.reason for each in answer.dropped}
    assert by_name["boris/same_1"] == "copy: copy of ana/bow_1"
    assert by_name["ana/jump_1"] == "fault: jumps"
    assert by_name["boris/kick_1"] == "needs something: sits"
    assert {each.capture for each in answer.intervals} == {"ana/bow_1", "boris/punch_1"}
    total = sum(info.duration for info in base.captures())
    assert answer.seconds == pytest.approx(total, abs=0.01)
    assert seconds_of(answer) == pytest.approx(total, abs=0.2)
    assert sum(answer.reasons.values()) == pytest.approx(
        total - sum(e.end - e.start for e in answer.intervals), abs=0.2
    )
    needed = base.curate(CurateSettings(share=1.0, shortest=1.0, with_needs=True, quality=0.2))
    assert {e.capture for e in needed.intervals} == {i.name for i in base.captures()} - {
        "boris/same_1"
    }


def test_less_is_chosen_with_weights_that_stand_for_all(base: MotionDB) -> None:
    asked = CurateSettings(share=0.3, shortest=1.0)
    answer = base.curate(asked)
    (split,) = answer.splits
    assert split.chosen <= 0.3 * answer.seconds
    assert 0.0 < split.bound <= split.distance
    assert sum(each.weight for each in answer.intervals) == pytest.approx(split.seconds, abs=0.05)
    covered = [each for each in answer.dropped if each.reason.startswith("covered: by interval ")]
    assert covered
    assert base.curate(asked) == answer
    hours = base.curate(CurateSettings(hours=0.3 * answer.seconds / 3600.0, shortest=1.0))
    assert [e.capture for e in hours.intervals] == [e.capture for e in answer.intervals]
    assert {e.capture for e in base.curate(asked, "licence=free").intervals} <= {
        *("ana/bow_1", "ana/jump_1")
    }


def test_splits_share_no_performer(base: MotionDB) -> None:
    answer = base.curate(CurateSettings(share=0.5, shortest=1.0, split="performer", seed=3))
    people = {each.split: set(each.performers) for each in answer.splits}
    assert people.keys() == {"train", "test"}
    assert not people["train"] & people["test"]
    folders = {split: set() for split in people}
    for each in answer.intervals:
        folders[each.split].add(each.capture.partition("/")[0])
    assert not folders["train"] & folders["test"]
    with pytest.raises(QueryError, match="split: expected captures of two performers"):
        base.curate(CurateSettings(share=0.5, shortest=1.0, split="performer"), "name~ana")


def test_a_folder_is_written_whole_with_its_manifest(base: MotionDB, tmp_path: Path) -> None:
    folder = tmp_path / "train"
    asked = CurateSettings(share=0.5, shortest=1.0, ending="bvh")
    answer = base.curate(asked, folder=folder)
    with (folder / "manifest.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    told = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert len(rows) == len(told["intervals"]) == len(answer.intervals)
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        [*(each.file for each in answer.intervals), "manifest.csv", "manifest.json"]
    )
    for each, row in zip(answer.intervals, rows):
        assert (row["file"], row["licence"], row["reason"]) == (
            *(each.file, each.licence),
            each.reason,
        )
        clip = read_capture(folder / each.file)
        assert clip.duration == pytest.approx(each.end - each.start, abs=0.05)
    assert told["reasons"] == answer.reasons
    with pytest.raises(QueryError, match="expected a new or an empty folder, found "):
        base.curate(asked, folder=folder)


def test_nothing_is_left_of_a_folder_that_failed(
    base: MotionDB, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "no space")

    monkeypatch.setattr(packs, "write_manifest", fail)
    before = set(tmp_path.iterdir())
    with pytest.raises(motiondb.MotionDBError, match=r"found: no space\. Check its permissions"):
        base.curate(CurateSettings(share=0.5, shortest=1.0), folder=tmp_path / "train")
    assert set(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({}, "share, hours: expected one of them"),
        ({"share": 0.1, "hours": 1.0}, "share, hours: expected one of them"),
        ({"share": 1.5}, "share, hours: expected one of them"),
        ({"share": float("nan")}, "share, hours: expected one of them"),
        ({"share": 0.1, "shortest": 6.0}, "shortest, longest"),
        ({"share": 0.1, "balance": "colour"}, "balance: expected words or symbols"),
        ({"share": 0.1, "split": "capture"}, "split: expected performer"),
        ({"share": 0.1, "quality": 2.0}, "quality: expected 0 to 1"),
        ({"share": 0.1, "quality": 1.0}, "expected captures with something to choose"),
        ({"share": 0.1, "balance": "symbols"}, "expected a database that has learned"),
    ],
)
def test_what_means_nothing_is_refused(
    base: MotionDB, settings: dict[str, float], said: str
) -> None:
    with pytest.raises(motiondb.MotionDBError, match=said):
        base.curate(CurateSettings(**settings))


def test_words_and_symbols_can_be_balanced(few_copy: Path) -> None:
    with motiondb.open(few_copy) as db:
        every = db.curate(CurateSettings(share=1.0, shortest=1.0))
        assert any(each.symbols for each in every.intervals)
        assert any(each.words for each in every.intervals)
        for balance in ("words", "symbols"):
            answer = db.curate(CurateSettings(share=0.1, shortest=1.0, balance=balance))
            assert answer.splits[0].bound <= answer.splits[0].distance


def test_captures_that_cannot_be_measured_are_told(
    base: MotionDB, monkeypatch: pytest.MonkeyPatch
) -> None:
    from motiondb.database.catalogue import assessing

    def fail(*_of: object) -> Quality:
        raise motiondb.MotionDBError("expected joints, found none")

    for table in ("finding", "capture_quality"):
        base.store.connection.execute(f"DELETE FROM {table}")
    keep(base, {})
    number = base.captures("name=ana/jump_1")[0].capture_id
    base.store.connection.execute("DELETE FROM capture_quality WHERE capture_id = ?", [number])
    monkeypatch.setattr(assessing, "points_of", fail)
    answer = base.curate(CurateSettings(share=1.0, shortest=1.0))
    reasons = {each.capture: each.reason for each in answer.dropped}
    assert reasons["ana/jump_1"] == "not measured: ana/jump_1: expected joints, found none"


def test_every_frame_of_a_fast_file_is_measured(some: Path) -> None:
    from motiondb.database.catalogue.assessing import points_of
    from motiondb.quality.assess import assess

    clip = read_capture(some / "ana" / "bow_1.bvh")
    clip, points, has_toes = points_of(replace(clip, fps=120.0), {})
    assert len(points) == clip.n_frames
    points[31, INDEX["l_wrist"], 0] += 0.3  # of which no other frame tells
    found = assess(points, clip.fps, has_toes).findings
    assert [each.part for each in found if each.kind == "jumps"] == ["l_wrist"]


def test_coverage_counts_each_motion_once_and_shows_what_is_most_like_what_lacks(
    base: MotionDB, tmp_path: Path
) -> None:
    answer = base.coverage(png=tmp_path / "coverage.png")
    assert (tmp_path / "coverage.png").stat().st_size > 10_000
    assert answer.captures == 4
    counted = sum(info.duration for info in base.captures() if info.name != "boris/same_1")
    held = sum(cell.amount for cell in answer.cells if cell.table == "going")
    assert held + answer.not_upright == pytest.approx(counted, abs=0.6)
    cells = {(cell.row, cell.column): cell for cell in answer.cells}
    assert cells["stand", "none"].performers == 2
    run = cells["run", "sharp left"]
    assert run.shot == "To record: run with a sharp left turn (none)"
    assert len({each.capture for each in run.nearest}) == 3
    assert run.shot in answer.shots
    with pytest.raises(motiondb.NotLearnedError, match="words: expected a database that has"):
        base.coverage(words=["kick"])
    with pytest.raises(QueryError, match="coverage: expected captures, found none"):
        base.coverage("name=nobody")


def test_coverage_of_symbols_and_words(learned_file: Path, tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("kick\n\nxqzzy\nkick\n", encoding="utf-8")
    with motiondb.open(learned_file, read_only=True) as db:
        answer = db.coverage(words=tmp_path / "list.txt")
        n_symbols = db.learned.symbols.n_symbols
        one = db.coverage("name~bow_1")
    words = {cell.row: cell for cell in answer.cells if cell.table == "words"}
    assert list(words) == ["kick", "xqzzy"]
    assert words["kick"].amount > 1.0
    assert words["kick"].performers > 1
    assert "xqzzy" in words["xqzzy"].shot
    for found in (answer, one):
        totals = [c for c in found.cells if c.table == "symbols" and c.column == "all"]
        parts = [c for c in found.cells if c.table == "symbols" and c.column != "all"]
        assert len(totals) == n_symbols
        assert sum(c.amount for c in totals) == pytest.approx(sum(c.amount for c in parts), abs=1)
    lacking = [c for c in one.cells if c.table == "symbols" and not c.amount]
    assert lacking
    assert all(c.nearest and c.shot.endswith("(none)") for c in lacking)


def test_one_performer_is_no_reason_to_record_where_there_is_only_one(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        both, one = db.coverage(), db.coverage("performer=ana")
    assert any("one performer" in shot for shot in both.shots)
    for shot in both.shots:
        assert ", as in " in shot or not shot.startswith("To record: symbol") or "none" in shot
    assert one.shots
    assert all(cell.amount < 1.0 for cell in one.cells if cell.shot)


def write_other(clip: Clip, path: Path, step: int = 1) -> None:
    from dataclasses import replace

    from motiondb.files.bvh_writer import write_bvh

    cut = replace(
        clip,
        fps=clip.fps / step,
        local_rotations=clip.local_rotations[::step],
        root_positions=clip.root_positions[::step],
    )
    write_bvh(cut, path)


def test_another_library_is_compared_and_not_changed(
    base: MotionDB, tmp_path: Path, some: Path
) -> None:
    folder = tmp_path / "theirs"
    folder.mkdir()
    shutil.copy(some / "ana" / "jump_1.bvh", folder / "jump.bvh")
    base.export("boris/kick_1", folder / "mirror.bvh", changes=motiondb.MotionChanges(mirror=True))
    kick = read_capture(some / "boris" / "punch_1.bvh")
    write_other(kick, folder / "slow.bvh", 2)
    base.export("ana/bow_1", folder / "part.bvh", 0.3, 1.3)
    with motiondb.open(tmp_path / "theirs.duckdb") as db:
        db.add(folder)
        db.captures.set_tags({"licence": "theirs"}, where="name~s")
    before = (tmp_path / "theirs.duckdb").read_bytes()
    answer = base.diff(tmp_path / "theirs.duckdb")
    assert (tmp_path / "theirs.duckdb").read_bytes() == before
    found = {(e.capture, e.other): e for e in answer.shared}
    assert found["ana/jump_1", "jump"].kind == "same file"
    assert found["boris/kick_1", "mirror"].kind == "mirrored"
    slow = found["boris/punch_1", "slow"]
    assert (slow.kind, slow.resampled, slow.other_licence) == ("same motion", True, "theirs")
    part = found["ana/bow_1", "part"]
    assert (part.kind, part.licence) == ("contains it", "free")
    assert (part.start, part.end) == pytest.approx((0.3, 1.3), abs=0.05)
    assert (answer.only_here, answer.only_there) == (0, 0)
    base.close()
    with motiondb.open(tmp_path / "theirs.duckdb") as db:
        back = {(e.capture, e.other): e.kind for e in db.diff(base.store.path).shared}
    assert back["part", "ana/bow_1"] == "part of it"
    assert back["jump", "ana/jump_1"] == "same file"


def test_no_other_library_and_the_same_one_are_refused(base: MotionDB, tmp_path: Path) -> None:
    with pytest.raises(QueryError, match="expected another database, found this one"):
        base.diff(base.store.path)
    with pytest.raises(motiondb.StoreError, match="expected another database, found no such file"):
        base.diff(tmp_path / "none.duckdb")


def test_a_copy_of_a_capture_that_is_not_asked_for_stays(base: MotionDB) -> None:
    infos = base.captures()
    assert curating.only_once(base.session, infos) == {"boris/same_1": "copy: copy of ana/bow_1"}
    assert curating.only_once(base.session, base.captures("name~boris")) == {}
