"""Cycles that close, and parts that are joined by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sample_motions import sample_clip, sample_motion

from motiondb.body import changes, kinematics, rotation
from motiondb.body.contacts import foot_slip
from motiondb.body.pose_vectors import yaw
from motiondb.errors import QueryError
from motiondb.generate.cycles import looped
from motiondb.generate.joining import join
from motiondb.generate.stitching import Piece


@pytest.mark.parametrize("fps", [30.0, 90.0])
def test_a_cycle_of_a_walk_closes(fps: float) -> None:
    clip = changes.resampled(sample_clip("ana/walk_1"), fps)
    loop = looped(clip)
    assert 0.8 < loop.clip.duration < 3.0
    assert loop.clip.duration == pytest.approx(loop.end - loop.start)
    assert loop.step < loop.usual_step
    assert loop.travel > 0.8 * loop.clip.duration  # it walks at more than 0.8 m/s
    still, _ = changes.in_place(loop.clip, loop.clip.root_positions, is_cycle=True)
    places = kinematics.clip_positions(still)[0]
    speed = np.linalg.norm(np.diff(places, axis=0, append=places[:1]), axis=-1).max(axis=1)
    assert speed[-1] < 1.3 * speed[:-1].max()
    again = np.concatenate([places, places])  # no jump of the velocity either
    jerk = np.linalg.norm(np.diff(again, n=2, axis=0), axis=-1).max(axis=1)
    seam = len(places) - 2
    assert jerk[seam : seam + 2].max() < 2.0 * jerk[:seam].max()


def test_a_cycle_in_place_does_not_turn() -> None:
    """A walk in a circle of 45 degrees a second keeps its turn, unless it is played in place."""
    clip = sample_clip("ana/walk_1")
    turns = yaw(np.arange(clip.n_frames) / clip.fps * np.radians(45.0))
    local = clip.local_rotations.copy()
    local[:, 0] = rotation.multiply(turns, local[:, 0])
    step = np.diff(clip.root_positions, axis=0, prepend=clip.root_positions[:1])
    root = clip.root_positions[0] + np.cumsum(rotation.rotate(turns, step), axis=0)
    circle = replace(clip, local_rotations=local, root_positions=root)
    kept, taken = looped(circle), looped(circle, is_straight=True)
    assert np.degrees(kept.turning) == pytest.approx(45.0 * kept.clip.duration, abs=10.0)
    assert (kept.turn, taken.turning) == (0.0, pytest.approx(0.0, abs=1e-9))
    assert taken.turn == pytest.approx(kept.turning)
    assert taken.step < 1.3 * taken.usual_step


def test_too_short_and_too_long_for_a_cycle() -> None:
    clip = sample_clip("ana/walk_1")
    with pytest.raises(QueryError) as caught:
        looped(changes.part(clip, 0, 9))
    assert str(caught.value) == (
        "loop: expected at least 0.47 s of motion, found 0.30 s. Choose a longer part."
    )


def test_parts_keep_their_frames_away_from_seams() -> None:
    motions = [sample_motion("ana/walk_1"), sample_motion("ana/jump_1")]
    parts = [Piece(0, 10, 70), Piece(1, 0, 60), Piece(1, 60, 80)]
    joined = join(motions, parts)
    assert joined.made.motion.n_frames == 140
    assert joined.made.captures.tolist() == [0] * 60 + [1] * 80
    assert joined.made.frames.tolist() == [*range(10, 70), *range(80)]
    rough, none = joined.seams
    assert (rough.seconds, rough.is_rough) == (2.0, rough.gap > 0.4)
    assert rough.gap > 0.02
    assert rough.blended > 0.2
    assert (none.seconds, none.gap, none.blended) == (4.0, 0.0, 0.0)  # they follow one another
    assert "blend" in joined.made.edits[59]
    assert "blend" not in joined.made.edits[20]
    steps = np.linalg.norm(np.diff(joined.made.motion.joint_positions(), axis=0), axis=-1)
    assert steps[50:70].max() < 1.5 * steps[:40].max()
    assert foot_slip(joined.made.motion) < 0.1


def test_a_part_of_a_frame_is_refused() -> None:
    with pytest.raises(QueryError, match=r"part 2: expected at least 0\.1 s, found 0\.03 s\."):
        join([sample_motion("ana/jump_1")], [Piece(0, 0, 30), Piece(0, 40, 41)])
