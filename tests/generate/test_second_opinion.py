"""What a motion shows whose origin is not known: actions, order, counts, durations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import answers
from motiondb.errors import NotLearnedError, QueryError
from motiondb.meaning.occurrences import measured_track


@pytest.fixture(scope="module")
def theirs(db: motiondb.MotionDB, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file that shows walking, then a kick, and that says nothing about its origin."""
    path = tmp_path_factory.mktemp("theirs") / "walk_kick.bvh"
    made = db.generate("walk, then kick", seed=3)
    made.write(path)
    path.with_name(f"{path.name}.provenance.json").unlink()
    return path


def _shown(told: answers.Judgement) -> list[bool | None]:
    return [one.shown for one in told.actions]


def test_actions_in_order_are_found_where_they_are(db: motiondb.MotionDB, theirs: Path) -> None:
    told = db.judge(theirs, "a person walks, then kicks")
    assert (told.shown, told.in_order, _shown(told)) == (True, True, [True, True])
    walk, kick = told.actions
    assert walk.start < kick.start
    assert walk.end < kick.end
    seam = db.generate("walk, then kick", seed=3).spans[1][0] / 30.0
    assert walk.end <= seam + 1.0
    assert kick.start >= seam - 1.5


def test_another_order_is_not_shown_though_each_action_is(
    db: motiondb.MotionDB, theirs: Path
) -> None:
    told = db.judge(theirs, "kick, then walk")
    assert (told.shown, told.in_order, _shown(told)) == (False, False, [True, True])
    assert told.reason == "not in this order: seen are walk, then kick"
    both = db.judge(theirs, "kick and walk")  # asks for no order
    assert (both.shown, both.in_order) == (True, None)


def test_a_wrong_number_is_not_sure_and_a_right_one_shown(db: motiondb.MotionDB) -> None:
    made = db.generate("jump twice").motion
    assert db.judge(made, "jump twice").shown is True
    told = db.judge(made, "jump three times")
    assert told.shown is None
    assert told.reason == "not sure: jump ('3 times' is not met: 2 measured in the motion)"
    with pytest.raises(motiondb.QueryError, match=r"at least 0.5 s of motion to judge, found 0.3"):
        db.judge(db.motion("ana/walk_1", 1.0, 1.3), "walk")
    walked = db.judge("ana/walk_1", "walk twice")  # nobody counts walks
    assert walked.shown is None
    assert "are counted" in walked.reason


def test_a_duration_is_that_of_the_part(db: motiondb.MotionDB) -> None:
    seconds = db.motion("ana/walk_1").duration
    assert db.judge("ana/walk_1", f"walk for {seconds:.0f} seconds").shown is True
    assert "it lasts" in db.judge("ana/walk_1", "walk for 60 seconds").reason


def test_an_angle_is_measured_in_the_part(db: motiondb.MotionDB) -> None:
    made = db.generate("turn left").motion
    speeds = measured_track(made)[:, 3]
    angle = float(np.degrees(speeds[speeds > 0.0].sum() / 30.0))
    assert db.judge(made, f"turn left by {angle:.0f} degrees").shown is True
    told = db.judge(made, "turn left by 700 degrees")
    assert told.shown is None
    assert "'700 degrees' is not met: it turns by" in told.reason


@pytest.mark.parametrize(("far", "seed"), [(1, 0), (2, 0), (3, 0), (2, 1)])
def test_a_walk_goes_as_far_as_is_asked_for(db: motiondb.MotionDB, far: int, seed: int) -> None:
    made = db.generate(f"walk {far} m", seed=seed)
    assert not made.not_used
    way = np.diff(made.motion.root_positions[:, [0, 2]], axis=0)
    assert np.hypot(*way.T).sum() == pytest.approx(far, rel=0.3)


def test_what_goes_as_far_as_is_asked_for_stays_so(db: motiondb.MotionDB) -> None:
    made = db.generate("walk 2 m and walk 5 steps")
    assert [one.shown for one in made.shown] == [True, True]


def test_a_motion_of_no_steps_is_not_made_without_end(db: motiondb.MotionDB) -> None:
    told = db.generate("take four steps").shown[0]
    assert told.reason == "'4 steps' is not met: it takes 0 steps"
    assert told.end < 300


def test_of_alternatives_the_best_one_counts(db: motiondb.MotionDB) -> None:
    told = db.judge("ana/walk_1", "kick or walk")
    assert (told.shown, told.chosen) == (True, "walk")
    assert db.judge("ana/walk_1", "walk, but not forward").shown is False


def test_words_that_nothing_says_are_not_sure_and_not_denied(db: motiondb.MotionDB) -> None:
    told = db.judge("ana/walk_1", "walk, then xylophone", exact=True)
    assert _shown(told) == [True, None]
    assert told.shown is None
    with pytest.raises(QueryError):
        db.judge("ana/walk_1", "xylophone", exact=True)
    with pytest.raises(QueryError, match="expected a text"):
        db.judge("ana/walk_1", ["walk"])  # type: ignore[arg-type]


def test_copies_and_sources_are_no_evidence(db: motiondb.MotionDB, tmp_path: Path) -> None:
    assert db.judge("ana/walk_1", "walk").left_out == ("ana/walk_1",)
    copy = tmp_path / "copy.bvh"
    db.export("ana/walk_1", copy, canonical=True, changes=motiondb.MotionChanges(fps=24.0))
    told = db.judge(copy, "walk")
    assert told.left_out == ("ana/walk_1",)
    assert told.nearest is not None
    assert told.nearest.capture == "ana/walk_1"  # as ``like`` finds it
    made = db.generate("walk, then kick", seed=3)
    made.write(tmp_path / "made.bvh")
    names = {source.name for source in made.provenance.sources}
    assert names <= set(db.judge(tmp_path / "made.bvh", "walk").left_out)
    (tmp_path / "made.bvh.provenance.json").write_text('[{"sources": 1}')  # damaged: as if none
    assert not names & set(db.judge(tmp_path / "made.bvh", "walk").left_out)


def test_a_short_action_in_a_long_motion_is_shown(db: motiondb.MotionDB) -> None:
    """Most of the motion is standing: as a whole, it looks like no jump."""
    jump = db.motion("ana/jump_1")
    stand = np.zeros(300, dtype=int)
    order = np.concatenate([stand, np.arange(jump.n_frames), stand + jump.n_frames - 1])
    long = motiondb.Motion(jump.local_rotations[order], jump.root_positions[order])
    told = db.judge(long, "jump")
    assert told.shown is True
    assert told.actions[0].start > 5.0
    assert told.actions[0].end < 15.0


def test_who_sits_down_and_rises_again_has_sat_down(db: motiondb.MotionDB) -> None:
    sit = db.motion("ana/sit_down_1")
    order = np.concatenate([np.arange(sit.n_frames), np.arange(sit.n_frames)[::-1]])
    again = motiondb.Motion(sit.local_rotations[order], sit.root_positions[order])
    assert db.judge(again, "sit down").actions[0].shown is not False
    stand = motiondb.Motion(sit.local_rotations[order * 0], sit.root_positions[order * 0])
    told = db.judge(stand, "sit down")
    assert (told.shown, told.actions[0].reason) == (False, "it does not go down")


def test_a_database_that_has_not_learned_cannot_judge(
    some: Path, tmp_path: Path, theirs: Path
) -> None:
    with motiondb.open(tmp_path / "new.duckdb") as new:
        new.add(some)
        with pytest.raises(NotLearnedError):
            new.judge(theirs, "walk")
