"""Dance steps: to the side and back, a turn, a clap, a sway, a dip, in bars of 1.1 s."""

from __future__ import annotations

from .score import Take

BAR = 1.1
"""Seconds that a step of the dance lasts at the usual tempo."""


def side_step(take: Take, side: str) -> None:
    """Step to one side, close with the other foot, arms opening and closing."""
    start, bar = take.begin(), take.beat(BAR)
    sign, other = (1.0, "r") if side == "l" else (-1.0, "l")
    x, z = take.world(0.34 * sign * take.person.scale * take.vigour, 0.0)
    wide = start + 0.42 * bar
    take.place[:2] = x, z
    take.step(side, start + 0.04 * bar, wide, take.stance(side), height=0.05, roll=(16.0, 0.0))
    take.pelvis(wide, dx=-0.14 * sign, dh=-0.06)
    take.key(wide, roll=3.0 * sign, side=-7.0 * sign, twist=8.0 * sign, look=14.0 * sign)
    take.hand(side, wide, (0.66, -0.22, 0.42), (0.3, -0.9, -0.3))
    take.hand(other, wide, (0.30, -0.50, 0.46), (0.7, -0.6, -0.3))
    close = start + 0.86 * bar
    take.step(other, start + 0.5 * bar, close, take.stance(other), height=0.06, roll=(18.0, 0.0))
    take.pelvis(close, dx=0.02 * sign, dh=-0.035)
    take.key(close, roll=-2.0 * sign, side=4.0 * sign, twist=-4.0 * sign)
    for arm in "lr":
        take.hand(arm, close, (-0.04, -0.42, 0.46), (0.8, -0.5, -0.3))
    take.relax(start + bar)
    take.end("dance_left" if side == "l" else "dance_right", start + bar)


def twirl(take: Take, side: str) -> None:
    """A whole turn to one side in six small steps, the arms rising."""
    start, bar = take.begin(), 2.0 * take.beat(BAR)
    sign, other = (1.0, "r") if side == "l" else (-1.0, "l")
    origin, steps = take.place[2], 6
    for i in range(steps):
        lift, land = start + (0.03 + i / steps) * bar * 0.95, start + (i + 1) / steps * bar * 0.95
        foot = side if i % 2 == 0 else other
        take.place[2] = origin + sign * 360.0 * (i + 1) / steps
        take.step(foot, lift, land, take.stance(foot, 0.02), height=0.04, roll=(20.0, 0.0))
        take.pelvis(land, dx=0.015 * (1 if foot == "l" else -1), dh=-0.02)
        take.key(land, yaw=take.place[2] - sign * 24.0)
    for share in (0.3, 0.62):
        take.hand(side, start + share * bar, (0.30, 0.62, 0.30), (0.9, -0.2, 0.1))
        take.hand(other, start + share * bar, (0.42, -0.22, 0.52), (0.6, -0.7, -0.2))
        take.key(start + share * bar, look=20.0 * sign, side=-3.0 * sign)
    end = start + bar + take.beat(0.28)
    lift = start + bar * 0.96
    take.step(side, lift, end - 0.03, take.stance(side), height=0.03, roll=(8.0, 0.0))
    take.relax(end)
    take.end("dance_twirl", end)


def clap(take: Take) -> None:
    """Two claps before the chest, the knees bending to the beat."""
    start, bar = take.begin(), take.beat(BAR)
    inward = -(take.person.shoulders - 0.045) / take.person.arm
    for i, time in enumerate((start + 0.32 * bar, start + 0.72 * bar)):
        take.pelvis(time, dx=0.02 * (-1) ** i, dh=-0.09)
        take.key(time, tilt=5.0, lean=4.0, twist=6.0 * (-1) ** i, nod=6.0)
        opened = time - 0.19 * bar
        take.pelvis(opened, dh=-0.02)
        for side in "lr":
            take.hand(side, opened, (0.18, -0.18, 0.52), (0.8, -0.6, -0.2))
            take.hand(side, time, (inward, -0.12, 0.60), (0.8, -0.6, -0.2))
        take.event(time, "contact", "l_wrist", "r_wrist")
    take.relax(start + bar)
    take.end("dance_clap", start + bar)


def sway(take: Take) -> None:
    """Hips and raised arms from side to side, twice."""
    start, bar = take.begin(), 2.0 * take.beat(BAR)
    sign = 1.0 if take.random.randint(2) else -1.0
    for time in (start + 0.11 * bar, start + 0.89 * bar):
        for side in "lr":
            take.hand(side, time, (0.42, -0.30, 0.50), (0.9, -0.4, -0.1))
    for i in range(4):
        time, way = start + (0.21 + 0.19 * i) * bar, sign * (-1) ** i
        take.pelvis(time, dx=0.085 * way * take.vigour, dh=-0.04)
        take.key(time, roll=7.0 * way, side=11.0 * way, look=-10.0 * way)
        for side in "lr":
            out = 0.20 + 0.20 * (way if side == "l" else -way)
            take.hand(side, time, (out, 0.58, 0.36), (0.9, -0.3, 0.1))
        free = "r" if way > 0 else "l"
        take.key(time, **{f"{free}heel": 22.0, f"{free}bend": 20.0})
        take.key(time - 0.095 * bar, **{f"{free}heel": 0.0, f"{free}bend": 0.0})
        take.key(time + 0.095 * bar, **{f"{free}heel": 0.0, f"{free}bend": 0.0})
    take.relax(start + bar)
    take.end("dance_sway", start + bar)


def dip(take: Take) -> None:
    """Sink with one foot behind the other, arms wide, head bowed: the end of a figure."""
    start, bar = take.begin(), 1.6 * take.beat(BAR)
    side = take.person.hand
    sign = 1.0 if side == "l" else -1.0
    foot = take.stance(side)
    x, z = take.world(-0.12 * sign, -0.26 * take.person.scale)
    take.step(side, start + 0.04 * bar, start + 0.30 * bar, (x, z, foot[2]), 0.06, (14.0, 0.0))
    low = start + 0.50 * bar
    for time in (low, low + 0.10 * bar):
        take.pelvis(time, dx=-0.03 * sign, dh=-0.26, dz=-0.08)
        take.key(time, tilt=10.0, lean=16.0, nod=22.0)
        take.key(time, **{f"{side}heel": 38.0, f"{side}bend": 38.0})
        for arm in "lr":
            take.hand(arm, time, (0.80, -0.36, 0.10), (0.1, -0.9, -0.4))
    for time in (start + 0.28 * bar, start + 0.80 * bar):
        take.key(time, **{f"{side}heel": 6.0, f"{side}bend": 6.0})
    take.step(side, start + 0.80 * bar, start + 0.98 * bar, foot, 0.05, (6.0, 0.0))
    take.relax(start + bar)
    take.end("dance_dip", start + bar)
