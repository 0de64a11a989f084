"""What captures lack: measured once, kept, filtered by, shown and written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import MotionDB, QueryError, store
from motiondb.body.body import LEG_LENGTH
from motiondb.files.own_files import is_own
from motiondb.records import Box, Finding, Quality
from tests.sample_motions import SAMPLES

SEAT = Finding(
    "sits",
    "needs",
    0.5,
    1.5,
    0.5,
    "m",
    0.09,
    "seat",
    "sits on something 50 cm high, 0.5 to 1.5 s",
    (1.0, 0.6, 2.0),
    (Box((1.0, 0.25, 2.0), (0.4, 0.5, 0.4)),),
)
JUMP = Finding("jumps", "fault", 1.0, 1.1, 0.2, "m", 0.1, "l_wrist", "the left wrist jumps")


def made(*findings: Finding, number: float = 0.9) -> Quality:
    flights = ((9.8, 0.1), (9.7, 0.2))
    return Quality(findings, ("cannot say",), np.array([number, number]), 0.1, flights)


@pytest.fixture
def told(base: MotionDB) -> MotionDB:
    """Four captures of which things are known: a seat; a seat and a jump; a jump; nothing."""
    infos = base.captures(sort="name")
    found = (made(SEAT), made(SEAT, JUMP, number=0.3), made(JUMP, number=0.3), made())
    numbers = {info.capture_id: each for info, each in zip(infos, found)}
    with store.running(base.store, "quality") as run_id:
        store.save_quality(base.store, numbers, run_id)
    return base


def test_captures_are_measured_once_and_what_was_found_is_kept(base: MotionDB) -> None:
    progress: list[tuple[str, float, float]] = []
    first = base.captures.quality(progress=lambda *step: progress.append(step))
    again = base.captures.quality("name~ana")
    assert (first.measured, again.measured, first.problems) == (4, 0, [])
    assert [step[1:] for step in progress] == [(n, 4) for n in range(4)]
    assert again.captures == [c for c in first.captures if c.capture.startswith("ana/")]
    assert {rate.performer for rate in first.performers} == {"ana", "boris"}
    assert base.captures.quality("ana/jump_1", again=True).measured == 1
    assert base.captures.quality("jump_1").captures[0].capture == "ana/jump_1"
    runs = [run for run in store.load_runs(base.store) if run.kind == "quality"]
    assert len(runs) == 2
    assert all(run.finished for run in runs)
    assert base.check() == []


def test_findings_come_back_as_they_were_saved_and_go_with_their_capture(told: MotionDB) -> None:
    infos = told.captures(sort="name")
    known = store.load_quality(told.store, [infos[1].capture_id])[infos[1].capture_id]
    assert known.findings == (SEAT, JUMP)
    assert (known.untold, known.floor) == (("cannot say",), 0.1)
    assert known.flights == ((9.8, 0.1), (9.7, 0.2))
    assert told.captures.show(infos[1].name).lacks == [
        "quality 0.30",
        SEAT.sentence,
        JUMP.sentence,
        "cannot say",
    ]
    told.captures.remove([infos[1].name])
    assert set(store.load_quality(told.store)) == {i.capture_id for i in infos} - {
        infos[1].capture_id
    }
    assert told.store.connection.value("SELECT count(*) FROM finding") == 2
    assert told.check() == []


@pytest.mark.parametrize(
    ("where", "expected"),
    [
        ("needs", [0, 1]),
        ("not needs", [2, 3]),
        ("quality > .8 and not needs", [3]),
        ("quality>.8 and (needs)", [0]),
        ("finding=jumps or needs", [0, 1, 2]),
        ("finding ~ jump and not finding=sits", [2]),
        ("finding in (fault, file)", [1, 2]),
        ("finding != fault", [0, 3]),
    ],
)
def test_filters_ask_what_captures_lack(told: MotionDB, where: str, expected: list[int]) -> None:
    names = [info.name for info in told.captures(sort="name")]
    assert sorted(i.name for i in told.captures(where)) == [names[n] for n in expected]


def test_filters_say_of_what_nothing_is_known_and_leave_tags_alone(base: MotionDB) -> None:
    with pytest.raises(QueryError) as error:
        base.captures("not needs")
    assert str(error.value) == (
        "filter on quality: expected all 4 captures looked at, found 0. Run motiondb quality first."
    )
    base.captures.set_tags({"quality": "good"}, ["ana/jump_1"])
    assert [info.name for info in base.captures("quality=good")] == ["ana/jump_1"]


def test_boxes_are_written_in_the_world_of_the_file(told: MotionDB, tmp_path: Path) -> None:
    names = [info.name for info in told.captures(sort="name")]
    rows = json.loads(told.captures.write_boxes("", tmp_path / "all.json").read_text())["captures"]
    assert [len(row["boxes"]) for row in rows] == [1, 1, 0, 0]
    assert (rows[0]["capture"], rows[0]["up"], rows[0]["unit"]) == (names[0], "y", "m")
    assert rows[0]["boxes"][0]["centre"] == [1.0, 0.25, 2.0]
    text = told.captures.write_boxes(names[0], tmp_path / "one.xml").read_text()
    assert is_own(tmp_path / "one.xml")  # and may be written again
    assert is_own(tmp_path / "all.json")
    assert 'pos="1.0000 0.2500 2.0000" size="0.2000 0.2500 0.2000"' in text
    with pytest.raises(QueryError, match="expected one capture for boxes as MJCF, found 4"):
        told.captures.write_boxes("", tmp_path / "all.xml")
    assert not (tmp_path / "all.xml").exists()


def test_a_database_that_is_only_read_answers_too(base: MotionDB, tmp_path: Path) -> None:
    path = base.store.path
    base.close()
    with motiondb.open(path, read_only=True) as db:
        answer = db.captures.quality("ana/jump_1")
        assert answer.measured == 1
        assert len(answer.captures) == 1
        assert store.load_quality(db.store) == {}
        assert db.captures.draw_quality("ana/jump_1", tmp_path / "jump.png").exists()


def test_ghosts_stand_where_the_motion_is_played(tmp_path: Path) -> None:
    """In the size of the standard body: the seat under the pelvis, as high as its sentence says."""
    with motiondb.open(tmp_path / "seat.duckdb") as db:
        db.add([SAMPLES / "captures" / "ana" / f"{name}.bvh" for name in ("sit_down_1", "walk_1")])
        assert db.captures.ghosts("sit_down_1") == ()  # not measured yet
        db.captures.quality()
        (finding,) = db.captures.findings("sit_down_1")
        (ghost,) = db.captures.ghosts("sit_down_1")
        motion = db.motion("sit_down_1")
        assert db.captures.ghosts("walk_1") == ()
    scale = LEG_LENGTH / motion.leg_length
    top = ghost.centre[1] + ghost.size[1] / 2.0
    assert top == pytest.approx(scale * finding.measure, abs=0.03)
    assert ghost.centre[1] - ghost.size[1] / 2.0 == pytest.approx(0.0, abs=0.03)
    pelvis = motion.root_positions[round(15 * (ghost.start + ghost.end))]
    assert np.hypot(pelvis[0] - ghost.centre[0], pelvis[2] - ghost.centre[2]) < 0.25
    assert pelvis[1] > top
