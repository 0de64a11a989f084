"""Motions as compact binary."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import body
from motiondb.page import motion
from motiondb.page.motion import Track
from motiondb.records import Motion


def standing(n_frames: int) -> Motion:
    """A body that stands in T-pose and moves 1 cm along z for each frame."""
    rotations = np.zeros((n_frames, 21, 4), dtype=np.float32)
    rotations[..., 0] = 1.0
    roots = np.zeros((n_frames, 3), dtype=np.float32)
    roots[:, 1] = body.LEG_LENGTH + body.ANKLE_HEIGHT
    roots[:, 2] = 0.01 * np.arange(n_frames)
    return Motion(rotations, roots, 0.9)


def test_a_figure_in_t_pose_has_its_points_where_the_body_has_them() -> None:
    at = dict(zip(motion.POINTS, motion.points_of(standing(3))[0]))
    np.testing.assert_allclose(at["pelvis"], [0.0, 0.93, 0.0], atol=1e-6)
    np.testing.assert_allclose(at["l_ankle"], [0.09, 0.08, 0.0], atol=1e-6)
    np.testing.assert_allclose(at["head_end"] - at["head"], [0.0, 0.18, 0.0], atol=1e-6)
    np.testing.assert_allclose(at["r_hand_end"] - at["r_wrist"], [-0.17, 0.0, 0.0], atol=1e-6)


def test_points_have_a_parent_before_them_and_a_radius() -> None:
    assert len(motion.POINTS) == len(motion.PARENTS) == len(motion.RADII) == 26
    assert len(set(motion.POINTS)) == 26
    assert motion.PARENTS[0] == -1
    assert motion.RADII[0] == 0.0
    for number, parent in enumerate(motion.PARENTS[1:], start=1):
        assert 0 <= parent < number
        assert motion.RADII[number] > 0.0


def test_a_container_is_laid_out_as_its_docstring_says() -> None:
    track = motion.body_track("ana/walk", "capture:ana/walk", standing(4), 1.5)
    data = motion.pack([track, Track("ball", "capture:ana/walk", np.zeros((4, 3)))])
    assert data[:4] == b"MDBM"
    length = int.from_bytes(data[4:8], "little")
    assert length % 4 == 0
    header = json.loads(data[8 : 8 + length])
    first, ball = header["tracks"]
    assert (first["kind"], first["frames"], first["fps"], first["start"]) == ("body", 4, 30.0, 1.5)
    assert (ball["kind"], ball["contacts"], ball["radius"]) == ("ball", None, 0.12)
    payload = data[8 + length :]
    values = np.frombuffer(payload, "<i2", 4 * 26 * 3, first["offset"]).reshape(4, 26, 3)
    points = np.array(first["origin"]) + np.array(first["scale"]) * values
    np.testing.assert_allclose(points, track.points, atol=1e-4)
    bits = np.frombuffer(payload, np.uint8, 4, first["contacts"])
    assert bits.tolist() == (track.contacts @ [1, 2]).tolist()


@given(st.lists(st.tuples(*[st.floats(-50.0, 50.0, width=32)] * 3), min_size=1, max_size=20))
def test_quantised_points_are_accurate_to_a_millimetre(points: list[tuple[float, ...]]) -> None:
    array = np.array(points, dtype=float).reshape(-1, 3)
    origin, scale, values = motion.quantise(array)
    assert values.dtype == np.dtype("<i2")
    error = np.abs(origin + scale * values - array)
    assert (error <= scale / 2 + 1e-6).all()
    assert (scale <= 100.0 / 65534 + 1e-9).all()


def test_what_is_packed_is_read_again() -> None:
    tracks = [
        motion.body_track("A1", "scene:s", standing(5), 0.5),
        Track("ball", "scene:s", np.arange(15.0).reshape(5, 3)),
        Track("nobody", "capture:x", np.zeros((0, 3))),
    ]
    again = motion.read_tracks(motion.pack(tracks))
    assert [t.name for t in again] == ["A1", "ball", "nobody"]
    for before, after in zip(tracks, again):
        assert after.points.shape == before.points.shape
        np.testing.assert_allclose(after.points, before.points, atol=3e-4)
    assert (again[0].contacts == tracks[0].contacts).all()
    assert (again[0].start, again[0].fps, again[0].leg_length) == (0.5, 30.0, 0.9)


@pytest.mark.parametrize(("wanted", "kept"), [(30.0, 7), (15.0, 4), (10.0, 3), (1.0, 1)])
def test_a_lower_rate_keeps_frames_at_equal_distances(wanted: float, kept: int) -> None:
    frames = motion.thinned(7, 30.0, wanted)
    assert len(frames) == kept
    assert frames[0] == 0
    assert len(set(np.diff(frames))) <= 1


@given(st.floats(-3.1, 3.1), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_figure_faces_forward_whatever_its_heading(angle: float, x: float, z: float) -> None:
    points = motion.points_of(standing(3))
    turn = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    moved = points @ turn.T + [x, 0.0, z]
    np.testing.assert_allclose(motion.facing_forward(moved), points, atol=1e-9)
