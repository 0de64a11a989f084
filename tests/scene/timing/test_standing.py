"""Who stands: turns to what matters, by small steps; a ball is kept out of bodies."""

from __future__ import annotations

import math

import numpy as np
import pytest
from activities import BASKETBALL
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.body import body, features, retarget, rotation
from motiondb.body.contacts import foot_slip
from motiondb.generate.contact import lock_feet
from motiondb.records import Motion
from motiondb.scene.energy.binding import DISTANCE, THROUGHOUT
from motiondb.scene.energy.energy import RADIUS
from motiondb.scene.language.activity import GIVE, SEND, Thing
from motiondb.scene.polish.facing import (
    AIMING,
    ASIDE,
    MOST_YAW,
    TURNING,
    ball_on_ground,
    look,
    turn_who_waits,
    turns_to,
)
from motiondb.scene.polish.path_editing import COMFORT, depths, edit_paths
from motiondb.scene.polish.splicing import LIFT, SWING, footing, step_feet
from motiondb.scene.thing.thing_acts import Aim, Bounce, Possession, ThingActs
from motiondb.scene.thing.thing_flight import clearance, held_thing

from ..polish.test_polish import posed
from .test_timeline import a_row, a_table, still

HOOP = Aim("rim", (1.0, 3.05, 2.0), 0.45)


def waiting(frames: int, heading: float = 0.0) -> np.ndarray:
    places = np.zeros((frames, 3))
    places[:, 2] = heading
    return places


def test_a_body_turns_until_the_head_can_do_the_rest() -> None:
    focus = np.tile([5.0, 0.0], (200, 1))  # 90 degrees to the left
    turned = turns_to(waiting(200), np.ones(200, dtype=bool), focus)
    assert turned == pytest.approx(np.full(200, math.pi / 2.0 - ASIDE))
    assert turns_to(waiting(9), np.ones(9, dtype=bool), focus[:9] @ [[0, 0.3], [1, 1]]).max() == 0


def test_turns_begin_and_end_with_the_string() -> None:
    waits = np.ones(300, dtype=bool)
    waits[100:160] = False
    focus = np.tile([0.0, -5.0], (300, 1))  # behind
    turned = turns_to(waiting(300), waits, focus)
    assert (turned[100:160] == 0.0).all()
    assert abs(turned[99]) < 0.02
    assert abs(turned[160]) < 0.02
    assert abs(turned[[0, 299]]) == pytest.approx(math.pi - ASIDE, abs=0.01)
    assert np.abs(np.diff(turned)).max() * 30.0 <= 1.01 * TURNING


def test_nobody_turns_away_and_back_in_a_short_pause() -> None:
    waits = np.zeros(120, dtype=bool)
    waits[40:80] = True
    assert not turns_to(waiting(120), waits, np.tile([5.0, 0.0], (120, 1))).any()


def test_what_circles_is_followed_without_a_leap() -> None:
    angle = np.linspace(0.0, 3.0 * math.pi, 400)
    focus = 4.0 * np.column_stack([np.sin(angle), np.cos(angle)])
    turned = turns_to(waiting(400), np.ones(400, dtype=bool), focus)
    assert np.abs(np.diff(turned)).max() < 0.05
    assert turned[-1] == pytest.approx(3.0 * math.pi - ASIDE, abs=0.3)


def test_the_ball_is_with_its_holder_and_on_the_way_between() -> None:
    timeline = still((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), frames=90)
    acts = ThingActs(
        (Possession(0, 0, 10, left=GIVE), Possession(1, 30, 40, left=SEND, aim=HOOP)), Thing("ball")
    )
    actual = ball_on_ground(acts, timeline.places)
    assert actual[[5, 20, 35]].tolist() == [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]]
    assert actual[-1].tolist() == [1.0, 2.0]


def test_guards_turn_between_opponent_and_ball_and_holders_do_not_turn() -> None:
    timeline = still((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, -3.0, math.pi), frames=100)
    row = a_row(
        kind=DISTANCE, player=0, last=1, moment=THROUGHOUT, target=1, near=0.5, far=4.0, weight=0.1
    )
    table = a_table(row, players=3)
    guards = type(table)(
        table.players, (("guard",), ("go",), ("go",)), table.rows, table.partners,
        table.contacts, table.rules, table.items, activity=BASKETBALL.activity,
    )  # fmt: skip
    acts = ThingActs((Possession(2, 0, 99),), Thing("ball"))
    waits = np.ones((3, 100), dtype=bool)
    turned = turn_who_waits(guards, timeline, waits, acts)[:, 50, 2]
    # opponent at +90, ball behind at 180 degrees: 135 between them, less what the head does
    assert turned[0] == pytest.approx(math.radians(135.0) - ASIDE, abs=0.01)
    assert turned[2] == math.pi
    without = turn_who_waits(guards, timeline, waits, None)[:, 50, 2]
    assert without.tolist() == pytest.approx([math.pi / 2.0 - ASIDE, 0.0, math.pi], abs=0.01)


@settings(max_examples=30, deadline=None)
@given(st.floats(-0.4, 0.4), st.floats(-3.0, 3.0), st.booleans())
def test_feet_stand_or_step_one_at_a_time(shift: float, turn: float, leading: bool) -> None:
    share = np.clip((np.arange(150) - 30) / 60.0, 0.0, 1.0)
    wanted = np.zeros((150, 2, 4))
    angle, side = turn * share, np.array([0.1, -0.1])
    wanted[:, :, 0] = shift * share[:, None] + side * np.cos(angle)[:, None]
    wanted[:, :, 2] = -side * np.sin(angle)[:, None]
    wanted[:, :, 3] = angle[:, None]
    positions = footing(wanted, leading)
    speed = np.linalg.norm(np.diff(positions[:, :, [0, 2]], axis=0), axis=2)
    assert ((speed > 1e-9).sum(axis=1) <= 1).all()  # the other foot is down
    assert positions[:, :, 1].max() <= LIFT + 1e-9
    assert (positions[1:, :, 1][speed < 1e-9] < LIFT * 0.6).all()
    if leading:
        off = np.linalg.norm((positions - wanted)[-1, :, [0, 2]], axis=0)
        assert off.max() < 0.03


def turned_on_the_spot(angle: float, frames: int = 120) -> Motion:
    motion = posed(frames)
    heading = angle * np.clip((np.arange(frames) - 20) / 70.0, 0.0, 1.0)
    local = motion.local_rotations.astype(float)
    local[:, 0] = rotation.from_axis_angle([0.0, 1.0, 0.0], heading)
    return Motion(local.astype(np.float32), motion.root_positions, body.LEG_LENGTH)


def test_who_turns_on_the_spot_steps_and_does_not_slide() -> None:
    motion = turned_on_the_spot(math.radians(120.0))
    out = step_feet(motion, np.ones(120, dtype=bool))
    joints, world = retarget.motion_positions(out)
    ankle = joints[:, body.INDEX["l_ankle"]]
    speed = np.linalg.norm(np.diff(ankle[:, [0, 2]], axis=0), axis=1) * 30.0
    assert (speed < 0.01).mean() > 0.5
    assert ankle[:, 1].max() > body.ANKLE_HEIGHT + 0.5 * LIFT
    assert joints[:, :, 1].min() > 0.0
    assert features.headings(world)[-1] == pytest.approx(math.radians(120.0), abs=1e-3)
    was, _ = retarget.motion_positions(motion)
    apart = np.linalg.norm(ankle - was[:, body.INDEX["l_ankle"]], axis=1)
    assert apart.max() < 0.2
    assert np.abs(joints[:, 0] - was[:, 0]).max() < 1e-6


def test_who_does_not_wait_is_left_alone() -> None:
    motion = turned_on_the_spot(1.0)
    assert step_feet(motion, np.zeros(120, dtype=bool)) is motion
    some = np.zeros(120, dtype=bool)
    some[60:] = True
    out = step_feet(motion, some)
    np.testing.assert_array_equal(out.local_rotations[:60], motion.local_rotations[:60])
    assert SWING < 60


def test_feet_that_an_edit_makes_slide_are_held_where_the_capture_stood() -> None:
    motion = posed(30, 0.6)  # glides at 0.6 m/s: no contact is seen
    stands = np.zeros((30, 2), dtype=bool)
    stands[8:16, 0] = True
    seen, told = lock_feet(motion), lock_feet(motion, contacts=stands)
    ankle = body.INDEX["l_ankle"]
    moved = [np.ptp(retarget.motion_positions(m)[0][8:16, ankle, 2]) for m in (motion, seen, told)]
    assert moved[0] == pytest.approx(0.14, abs=1e-3)
    assert moved[1] == pytest.approx(0.14, abs=1e-3)
    assert moved[2] < 0.02
    free = lock_feet(motion, np.ones(30, dtype=bool), stands)
    np.testing.assert_allclose(free.local_rotations, motion.local_rotations, atol=2e-3)
    assert foot_slip(told) < 0.3


def test_a_ball_in_a_body_is_brought_out_level() -> None:
    joints, _ = retarget.motion_positions(posed(1))
    hip = joints[0, body.INDEX["pelvis"]]
    ball = (hip + np.array([0.02, 0.2, 0.05]))[None]
    out = clearance(ball, joints, 0.12)
    assert out[0, 1] == 0.0
    way = np.linalg.norm((ball + out - joints[:, 0])[0, [0, 2]])
    assert way == pytest.approx(0.1 + 0.12, abs=0.01)  # the trunk is 10 cm thick
    assert not clearance(ball + 1.0, joints, 0.12).any()


def test_hands_go_out_with_the_ball() -> None:
    motion = posed(60)
    joints, world = retarget.motion_positions(motion)
    possession = Possession(0, 0, 59, 1, ((0, 60),), (Bounce(10, 22, 1),))
    held = held_thing(possession, joints, world, 0.24)
    reach = np.linalg.norm(held.palms[:, 1] - held.ball, axis=1)
    assert reach[5:55] == pytest.approx(0.11, abs=0.02)


def test_a_ball_changes_hands_only_while_it_bounces() -> None:
    possession = Possession(0, 0, 60, 1, ((0, 60),), (Bounce(5, 15, 0), Bounce(20, 30, 1)))
    assert possession.hand_at(60)[[0, 15, 20]].tolist() == [0, 0, 0]
    assert possession.hand_at(60)[[21, 30, 59]].tolist() == [1, 1, 1]


def test_who_passes_looks_at_the_receiver_before() -> None:
    one, other = posed(60), posed(60)
    root = other.root_positions.copy()
    root[:, 0] += 6.0
    other = Motion(other.local_rotations, root, body.LEG_LENGTH)
    ball = np.tile([0.0, 1.5, 4.0], (60, 1))
    acts = ThingActs((Possession(0, 0, 40, left=GIVE), Possession(1, 50, 59)), Thing("ball"))
    seen, _ = look(acts, ball, [one, other])
    _, world = retarget.motion_positions(seen)
    nose = rotation.rotate(world[:, body.INDEX["head"]], np.broadcast_to([0.0, 0.0, 1.0], (60, 3)))
    yaw = np.arctan2(nose[:, 0], nose[:, 2])
    assert yaw[0] == pytest.approx(0.0, abs=0.05)
    assert yaw[40 - AIMING // 2] == pytest.approx(MOST_YAW, abs=0.05)  # as far as necks turn


def test_people_keep_arms_length_where_nothing_is_against_it() -> None:
    timeline = still((0.0, 0.0, 0.0), (0.55, 0.0, 0.0), frames=40)
    table = a_table()
    assert edit_paths(table, timeline, timeline.places).rounds == 0
    apart = edit_paths(table, timeline, timeline.places, radius=COMFORT).timeline
    assert all(depth.max() <= 1e-6 for _, _, depth in depths(table, apart, COMFORT))
    assert COMFORT > RADIUS
