"""Foot strikes of a made walker whose times are known, and what its cycles measure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walker import SPEED, STANCE, STRIDE_TIME, WIDTH, strikes, walker

from motiondb.body import gait
from motiondb.body.body import INDEX


def known(seconds: float) -> list[gait.FootEvent]:
    """The events that the walker has, but for those near the ends of the motion."""
    events = []
    for side in "lr":
        hits = strikes(side, seconds)
        events += [gait.FootEvent(t, side, gait.STRIKE) for t in hits]
        events += [gait.FootEvent(t + STANCE * STRIDE_TIME, side, gait.OFF) for t in hits]
    return sorted(event for event in events if 0.05 < event.seconds < seconds - 0.05)


@pytest.mark.parametrize("fps", [50.0, 100.0, 240.0])
@pytest.mark.parametrize("size", [0.6, 1.0])
def test_strikes_are_found_at_every_rate_and_size(fps: float, size: float) -> None:
    found = gait.foot_events(walker(fps, size=size), fps)
    expected = known(4.0)
    assert [(e.side, e.name) for e in found] == [(e.side, e.name) for e in expected]
    late = [a.seconds - b.seconds for a, b in zip(found, expected)]
    assert np.abs(late).max() <= 0.02


def test_who_stands_shifts_or_lifts_one_foot_makes_no_steps() -> None:
    points = walker(100.0)[:1].repeat(400, axis=0)
    points += np.random.default_rng(0).normal(0.0, 0.001, points.shape)
    assert gait.foot_events(points, 100.0) == []
    kick = points.copy()
    out = 0.6 * np.exp(-0.5 * ((np.arange(400) - 200) / 15.0) ** 2)
    kick[:, [INDEX["l_ankle"], INDEX["l_toe"]], 2] += out[:, None]  # out and back
    assert gait.foot_events(kick, 100.0) == []


def test_who_sits_and_swings_the_feet_makes_no_steps() -> None:
    points = walker(100.0)
    sits = points.copy()
    legs = ("knee", "ankle", "toe")
    sits[:, [n for name, n in INDEX.items() if not name.endswith(legs)], 1] -= 0.6
    for side in "lr":
        sits[:, INDEX[f"{side}_knee"]] = sits[:, INDEX[f"{side}_ankle"]] + [0.0, 0.42, 0.0]
    assert gait.foot_events(points, 100.0)
    assert gait.foot_events(sits, 100.0) == []


def test_cycles_measure_what_the_walker_does() -> None:
    points = walker(100.0, seconds=6.0)
    events = gait.foot_events(points, 100.0)
    cycles = gait.gait_cycles(points, 100.0, events)
    assert {c.side for c in cycles} == {"l", "r"}
    for cycle in cycles:
        assert cycle.end - cycle.start == pytest.approx(STRIDE_TIME, abs=0.02)
        assert cycle.stance == pytest.approx(STANCE, abs=0.02)
        assert cycle.stride_length == pytest.approx(SPEED * STRIDE_TIME, rel=0.02)
        assert cycle.step_length == pytest.approx(SPEED * STRIDE_TIME / 2, rel=0.05)
        assert cycle.step_width == pytest.approx(WIDTH, abs=1e-6)
        assert cycle.speed == pytest.approx(SPEED, rel=0.02)
        assert cycle.turn == pytest.approx(0.0, abs=1e-6)
    told = {m.measure: m for m in gait.measures(cycles)}
    assert told["cadence"].both == pytest.approx(120.0 / STRIDE_TIME, rel=0.02)
    assert abs(told["stride time"].asymmetry or 0.0) < 2.0
    assert gait.measures(()) == ()


def test_steps_that_start_or_stop_are_not_steady() -> None:
    points = walker(100.0, seconds=6.0)
    cycles = gait.gait_cycles(points, 100.0, gait.foot_events(points, 100.0))
    slow, slower = (replace(cycles[0], speed=share * SPEED) for share in (0.7, 0.4))
    assert gait.steady((slower, slow, *cycles, slow, slower)) == cycles
    assert gait.steady((slow, slower)) == (slow, slower)  # nothing else is known
    assert gait.steady(()) == ()


def test_a_mirrored_and_turned_walker_has_the_other_side_and_the_same_measures() -> None:
    points = walker(100.0)
    names = [{"l": "r", "r": "l"}[n[0]] + n[1:] if n[1] == "_" else n for n in INDEX]
    mirrored = points[:, [INDEX[name] for name in names]] * [-1.0, 1.0, 1.0]
    turned = mirrored[..., [2, 1, 0]] * [1.0, 1.0, -1.0]  # a quarter turn
    found = gait.foot_events(turned, 100.0)
    before = gait.foot_events(points, 100.0)
    other = {"l": "r", "r": "l"}
    assert [(e.seconds, other[e.side], e.name) for e in found] == [
        pytest.approx((e.seconds, e.side, e.name)) for e in before
    ]
    widths = [c.step_width for c in gait.gait_cycles(turned, 100.0, found)]
    assert widths == pytest.approx([WIDTH] * len(widths))


def test_a_treadmill_is_told_and_taken_out() -> None:
    points = walker(100.0)
    times = np.arange(len(points)) / 100.0
    on_belt = points - times[:, None, None] * [0.0, 0.0, SPEED]
    restored, speed = gait.over_ground(on_belt, 100.0)
    assert speed == pytest.approx(SPEED, rel=0.01)
    np.testing.assert_allclose(restored, points, atol=0.05)
    same, none = gait.over_ground(points, 100.0)
    assert none == 0.0
    assert same is points


def test_a_turn_to_the_left_is_positive() -> None:
    points = walker(100.0)
    angles = np.linspace(0.0, np.pi / 2, len(points))[:, None]
    x, z = points[..., 0], points[..., 2]
    turned = points.copy()  # about the origin from +z towards +x, which is to the left
    turned[..., 0] = x * np.cos(angles) + z * np.sin(angles)
    turned[..., 2] = z * np.cos(angles) - x * np.sin(angles)
    events = gait.foot_events(points, 100.0)
    cycles = gait.gait_cycles(turned, 100.0, events)
    expected = 90.0 * STRIDE_TIME / 4.0
    assert [c.turn for c in cycles] == pytest.approx([expected] * len(cycles), rel=0.05)


def test_angles_of_a_straight_and_a_bent_leg() -> None:
    points = walker(100.0)[:1]
    hip, knee, ankle, toe = (INDEX[f"l_{j}"] for j in ("hip", "knee", "ankle", "toe"))
    place = points[0, hip]
    points[0, knee] = np.add(place, [0.0, 0.0, 0.43])  # the thigh is level
    points[0, ankle] = points[0, knee] + [0.0, -0.42, 0.0]
    points[0, toe] = points[0, ankle] + [0.0, -0.06, 0.14]
    angles = gait.leg_angles(points, "l")
    assert angles["hip"] == pytest.approx([90.0])
    assert angles["knee"] == pytest.approx([90.0])
    assert angles["ankle"] == pytest.approx([0.0], abs=1e-9)
    points[0, toe] = points[0, ankle] + [0.0, 0.14, 0.14]
    assert gait.leg_angles(points, "l")["ankle"][0] > 45.0


def test_mean_angles_are_those_of_each_cycle() -> None:
    points = walker(100.0)
    events = gait.foot_events(points, 100.0)
    cycles = gait.gait_cycles(points, 100.0, events)
    found = gait.cycle_angles(points, 100.0, cycles)
    one = [c for c in cycles if c.side == "l"]
    knee = next(a for a in found if (a.side, a.joint) == ("l", "knee"))
    slow = gait.leg_angles(points, "l")["knee"]
    at_start = np.mean([np.interp(c.start * 100.0, np.arange(len(slow)), slow) for c in one])
    assert knee.mean[0] == pytest.approx(at_start)
    assert len(knee.mean) == len(knee.deviation) == 101
