"""A motion that cannot be unpacked: its capture is named, and the others answer."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import motiondb

BAD = "ana/walk_1"


def damage(path: Path) -> None:
    """Damage the motion of a capture, and remove what was computed from it before."""
    with motiondb.open(path) as db:
        db.store.connection.execute(
            "UPDATE motion SET poses = 'walk'::BLOB WHERE capture_id ="
            " (SELECT capture_id FROM capture WHERE name = ?)",
            [BAD],
        )
    shutil.rmtree(path.with_name(f"{path.name}.cache"), ignore_errors=True)


@pytest.fixture
def damaged(few_copy: Path) -> Path:
    """A learned database with a damaged motion."""
    damage(few_copy)
    return few_copy


def test_the_others_answer_and_the_damaged_one_is_named(damaged: Path, some: Path) -> None:
    named = rf"motion \(of the capture {BAD}\) that cannot be unpacked"
    with motiondb.open(damaged) as db:
        assert db.damage_note == ""  # no question has met it
        assert BAD in {info.name for info in db.captures()}
        found = db.search("walk", limit=200).matches
        assert found
        assert BAD not in {match.capture for match in found}
        assert f"found damaged ones of {BAD}, which answers leave out" in db.damage_note
        assert BAD not in {match.capture for match in db.like("boris/walk_1", limit=200).matches}
        made = db.generate("walk", seed=3)
        assert BAD not in {source.name for source in made.provenance.sources}
        with pytest.raises(motiondb.StoreError, match=named):
            db.motion(BAD)
        with pytest.raises(motiondb.StoreError, match=f"found damaged ones of {BAD}"):
            db.learn()
        assert any(fault.startswith(f"{BAD}: ") for fault in db.check())
    with motiondb.open(damaged, read_only=True) as db:  # from the cache of the questions before
        again = db.search("walk", limit=200).matches
        assert [(m.capture, m.start) for m in again] == [(m.capture, m.start) for m in found]


def test_captures_are_added_beside_a_damaged_one_which_can_be_removed(
    damaged: Path, some: Path, samples_folder: Path
) -> None:
    clip = motiondb.read_capture(samples_folder / "boris" / "kick_1.bvh")
    motiondb.write_bvh(clip, some / "again.bvh")
    with motiondb.open(damaged) as db:
        report = db.add(some / "again.bvh", settings=motiondb.AddSettings(jobs=1))
        assert report.problems == ()
        assert db.like(BAD.replace("ana", "boris"), limit=3).matches
        db.captures.remove([BAD])
        assert db.check() == []
        assert db.search("walk").matches
        assert db.damage_note == ""
        np.testing.assert_allclose(db.motion("again").duration, clip.duration, atol=0.1)


@pytest.mark.parametrize("lost", ["nothing", "frames-*", "segments-*"])
def test_a_motion_that_is_mended_answers_again(few_copy: Path, lost: str) -> None:
    with motiondb.open(few_copy) as db:
        before = [(m.capture, m.start) for m in db.search("walk", limit=200).matches]
        whole = db.store.connection.execute("SELECT capture_id, poses FROM motion").fetchall()
    damage(few_copy)
    with motiondb.open(few_copy) as db:
        assert BAD not in {match.capture for match in db.search("walk", limit=200).matches}
        for number, poses in whole:
            update = "UPDATE motion SET poses = ? WHERE capture_id = ?"
            db.store.connection.execute(update, [poses, number])
    for file in few_copy.with_name(f"{few_copy.name}.cache").glob(lost):
        file.unlink()
    with motiondb.open(few_copy, read_only=True) as db:
        again = [(m.capture, m.start) for m in db.search("walk", limit=200).matches]
        assert again == before
        assert db.damage_note == ""
