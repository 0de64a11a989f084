"""Small footwork: turning on the spot, pivoting on one foot, shuffling sideways."""

from __future__ import annotations

import numpy as np

from .locomotion import other_side
from .score import Take


def turn(take: Take, angle: float = 90.0) -> None:
    """Turn on the spot by ``angle`` degrees to the left, in small steps, the head first."""
    start = take.begin()
    lead, follow = ("l", "r") if angle > 0 else ("r", "l")
    rounds = max(1, round(abs(angle) / 60.0))
    period, origin = take.beat(0.36), take.place[2]
    take.key(start + 0.2, look=np.clip(angle, -40, 40) * 0.8, twist=np.clip(angle, -30, 30) * 0.5)
    time = start + 0.18
    for i in range(rounds):
        share = angle / rounds
        for side, ahead in ((lead, 0.55), (follow, 1.0)):
            take.place[2] = origin + share * (i + ahead)
            land = time + period
            to = take.stance(side, 0.02 if side == lead else 0.0)
            take.step(side, time + 0.12 * period, land, to, height=0.05, roll=(14.0, 3.0))
            sign = 1.0 if side == "l" else -1.0
            take.pelvis(time + 0.5 * period, dx=-0.035 * sign, dh=-0.01)
            take.key(time + 0.5 * period, roll=-1.5 * sign)
            take.key(land, yaw=take.place[2] - (0.1 * share if ahead < 1 else 0.0))
            out = take.vigour * 0.10
            take.hand(side, land, (0.16 + out, -0.93, 0.12))
            take.hand(other_side(side), land, (0.12 + out / 2, -0.94, 0.0))
            time = land
    lift = time + 0.1 * period
    take.step(lead, lift, time + period, take.stance(lead), height=0.035, roll=(8.0, 0.0))
    end = time + period + take.beat(0.25)
    take.relax(end)
    take.end("turn_left" if angle > 0 else "turn_right", end)


def pivot(take: Take, angle: float) -> None:
    """Turn with the ball: one foot stays on its ball and turns, the other steps round it.

    A positive angle (degrees) turns left about the left foot.
    """
    start = take.begin()
    fixed, free = ("l", "r") if angle > 0 else ("r", "l")
    duration, sign = take.beat(0.95), np.sign(angle)
    yaw = np.deg2rad(take.last(f"{fixed}yaw"))
    reach = 0.14 * take.person.scale
    ball = np.array([take.last(f"{fixed}x"), take.last(f"{fixed}z")])
    ball = ball + reach * np.array([np.sin(yaw), np.cos(yaw)])
    pieces = 30
    for i in range(pieces + 1):
        share = i / pieces
        eased = share * share * (3.0 - 2.0 * share)
        angle_now = take.place[2] + sign * take.person.splay + angle * eased
        x, z = ball - reach * np.array(
            [np.sin(np.deg2rad(angle_now)), np.cos(np.deg2rad(angle_now))]
        )
        time = start + 0.15 + share * duration
        take.key(time, **{f"{fixed}x": x, f"{fixed}z": z, f"{fixed}yaw": angle_now})
        raised = 14.0 * np.sin(np.pi * share) ** 2
        take.key(time, **{f"{fixed}heel": raised, f"{fixed}bend": raised})
    take.place[2] += angle
    middle = np.array([take.last(f"{fixed}x"), take.last(f"{fixed}z")])
    back = np.array(take.stance(fixed)[:2]) - take.place[:2]
    take.place[:2] = middle - back
    land = start + 0.1 + duration
    take.step(free, start + 0.2, land, take.stance(free, 0.06), height=0.06, roll=(22.0, 3.0))
    take.key(start + 0.2, twist=sign * 12.0, look=sign * 30.0, side=0.0)
    take.pelvis(start + 0.1 + 0.55 * duration, dx=0.03 * sign, dh=take.rest["dh"] - 0.03)
    end = land + take.beat(0.3)
    take.relax(end)
    take.end("pivot_left" if angle > 0 else "pivot_right", end)


def shuffle(take: Take, metres: float, steps: int, label: str | None = None) -> None:
    """Slide sideways, left positive, without crossing the feet; the posture of rest stays."""
    start = take.begin()
    sign = np.sign(metres)
    lead, follow = ("l", "r") if metres > 0 else ("r", "l")
    period, share = take.beat(0.26), metres / steps * take.person.scale
    time = start
    for _ in range(steps):
        x, z = take.world(share, 0.0)
        take.place[:2] = x, z
        for side in (lead, follow):
            to = take.stance(side, 0.18)
            take.step(side, time + 0.02, time + period, to, height=0.035, roll=(6.0, 0.0))
            if side == lead:
                take.pelvis(time + period, dx=-0.5 * share, dh=take.rest["dh"])
                take.key(time + period, roll=-1.5 * sign, yaw=take.place[2])
            time += period
        take.pelvis(time, dh=take.rest["dh"] - 0.02, dz=take.rest["dz"])
        take.key(time, roll=1.0 * sign)
    end = time + take.beat(0.2)
    if label is not None:
        take.relax(end)
        take.end(label, end)
    else:
        take.now = end
