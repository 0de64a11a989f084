"""What the camera sees, in numbers worked by hand."""

from __future__ import annotations

import hand_made
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import body
from motiondb.pictures import stick

L_WRIST = body.INDEX["l_wrist"]


def test_from_the_front_the_left_hand_is_on_the_right() -> None:
    view = stick.view_motion(hand_made.rest(1), azimuth=0.0)
    # collar 0.03 + shoulder 0.14 + upper arm 0.28 + forearm 0.25 metres to the side
    assert view.points[0, L_WRIST, 0] == pytest.approx(0.70)
    # pelvis 0.93, spine 0.12, chest 0.14, collar 0.18, seen from 10 degrees above
    assert view.points[0, L_WRIST, 1] == pytest.approx(1.37 * np.cos(np.deg2rad(10.0)))
    assert view.points.shape == (1, 26, 2)


def test_from_its_left_the_left_hand_is_near_and_low() -> None:
    view = stick.view_motion(hand_made.rest(1), azimuth=np.pi / 2.0)
    up, near = 1.37, 0.70
    sine, cosine = np.sin(np.deg2rad(10.0)), np.cos(np.deg2rad(10.0))
    assert view.points[0, L_WRIST] == pytest.approx([0.0, up * cosine - near * sine], abs=1e-6)
    assert view.depths[0, L_WRIST] == pytest.approx(near * cosine + up * sine)


def test_the_view_stays_with_the_figure_and_the_track_tells_where_it_goes() -> None:
    view = stick.view_motion(hand_made.swing(31), azimuth=np.pi / 2.0)
    pelvis = view.points[:, 0]
    assert pelvis == pytest.approx(np.tile(pelvis[0], (31, 1)), abs=1e-6)
    # walking along +z, seen from +x: to the left
    assert view.track[30] == pytest.approx([-1.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("heading", [0.0, 70.0, 180.0, -135.0])
def test_the_best_view_is_a_three_quarter_one_whatever_the_heading(heading) -> None:
    azimuth = stick.best_azimuth(stick.world_points(hand_made.rest(3, heading)))
    turn = (np.rad2deg(azimuth) - heading + 180.0) % 360.0 - 180.0
    assert abs(turn) == pytest.approx(35.0, abs=1e-4)


def test_swinging_arms_are_seen_more_from_the_side() -> None:
    azimuth = stick.best_azimuth(stick.world_points(hand_made.swing(30)))
    assert abs(np.rad2deg(azimuth)) == pytest.approx(55.0, abs=1e-4)


@settings(max_examples=25, deadline=None)
@given(st.floats(-10.0, 10.0))
def test_no_view_makes_a_bone_longer_than_it_is(azimuth: float) -> None:
    motion = hand_made.swing(5)
    places = stick.world_points(motion)
    points = stick.view_motion(motion, azimuth).points
    for parent, child in stick.BONES:
        true = np.linalg.norm(places[:, child] - places[:, parent], axis=-1)
        seen = np.linalg.norm(points[:, child] - points[:, parent], axis=-1)
        assert np.all(seen <= true + 1e-6)
