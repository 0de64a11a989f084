"""Basketball with the ball: holding, dribbling, passing, catching, shooting, laying up, feints.

Actions with a ball begin and end in the posture of holding it (``HOLD``); those that give it away
end standing. There is no ball in the files: its instants are among the events.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .gestures import GRAVITY, flight
from .locomotion import WALK, other_side, personal, travel
from .score import HOLD, STAND, Take

_INWARD = -0.13
"""How far inside its shoulder a hand on the ball is, arm lengths."""


def both(take: Take, time: float, up: float, ahead: float, flex: float = 0.0) -> None:
    """Both hands on the ball, ``up`` and ``ahead`` of the shoulders, arm lengths."""
    elbow = (0.5, -0.8, -0.4) if up < 0.1 else (0.45, -0.5, 0.7)
    for side in "lr":
        take.hand(side, time, (_INWARD, up, ahead), elbow, flex)


def hold(take: Take, seconds: float = 1.4) -> None:
    """Hold the ball before the body, in a low stance, and look about."""
    start = take.begin()
    take.rest = HOLD
    raised = start + take.beat(0.4)
    take.relax(raised)
    end = max(raised + 0.4, start + take.beat(seconds))
    take.key(0.5 * (raised + end), look=take.random.uniform(-18, 18))
    shift = take.random.uniform(-0.08, 0.08)
    both(take, 0.5 * (raised + end), -0.34 + shift, 0.50)
    take.relax(end)
    take.end("hold", end)


def catch(take: Take) -> None:
    """Reach out with both hands, take the ball, and draw it in to the body."""
    start = take.begin()
    reached, drawn = start + take.beat(0.42), start + take.beat(0.80)
    take.pelvis(reached, dh=-0.05, dz=0.03)
    take.key(reached, tilt=4.0, lean=7.0, nod=-2.0)
    both(take, reached, take.random.uniform(-0.16, 0.12), 0.86)
    for side in "lr":
        take.event(reached, "catch", f"{side}_wrist", "ball")
    take.rest = HOLD
    take.pelvis(drawn, dh=-0.13, dz=-0.06)
    take.key(drawn, tilt=16.0, lean=12.0)
    both(take, drawn, -0.40, 0.40)
    end = drawn + take.beat(0.35)
    take.relax(end)
    take.end("catch", end)


def throw(take: Take, way: str = "chest") -> None:
    """Pass with both hands from the chest ("chest") or from over the head ("overhead")."""
    start = take.begin()
    lead = other_side(take.person.hand)
    sign = 1.0 if lead == "l" else -1.0
    loaded, gone = start + take.beat(0.42), start + take.beat(0.66)
    through = gone + 0.14
    foot = take.stance(lead)
    x, z = take.world(0.55 * take.width * sign, 0.30 * take.person.scale)
    take.step(lead, loaded - 0.12, gone - 0.04, (x, z, foot[2]), height=0.05, roll=(10.0, 4.0))
    high = way == "overhead"
    both(take, loaded, 0.42 if high else -0.22, 0.12 if high else 0.30)
    take.pelvis(loaded, dh=-0.08, dz=-0.03)
    take.key(loaded, tilt=4.0, lean=-2.0 if high else 10.0)
    for time, ahead in ((gone, 0.86), (through, 0.90)):
        both(take, time, 0.28 if high else -0.02, ahead - 0.1 * high, flex=28.0)
        take.pelvis(time, dh=-0.10, dz=0.14)
        take.key(time, tilt=12.0, lean=10.0, nod=-6.0)
    for side in "lr":
        take.event(gone, "release", f"{side}_wrist", "ball")
    take.rest = STAND
    back = through + take.beat(0.22)
    take.step(lead, back, back + take.beat(0.36), foot, height=0.05, roll=(8.0, 0.0))
    end = back + take.beat(0.65)
    take.relax(end)
    take.end("pass", end)


def dribble(take: Take, bounces: int = 5, steps: int = 0) -> None:
    """Bounce the ball with one hand, standing or walking ``steps`` steps."""
    start, side = take.now, take.person.hand
    other, period = other_side(side), take.beat(0.56)
    if steps:
        gait = personal(take, replace(WALK, low=-0.13, high=-0.10, tilt=12.0, lean=6.0))
        take.rest = HOLD
        end = travel(take, gait, [0.8] * steps, 0.0, "dribble", arms="")
        bounces = max(2, int((end - start - 0.6) / period))
    else:
        take.begin()
        end = start + take.beat(0.55) + bounces * period
        for i in range(bounces + 1):
            time = start + take.beat(0.25) + i * period
            take.pelvis(time, dx=0.012 * (-1) ** i, dh=-0.15, dz=-0.05)
            take.key(time, tilt=17.0, lean=10.0, nod=4.0)
    sign = 1.0 if side == "l" else -1.0
    if not steps:
        take.key(start + 0.4, twist=-8.0 * sign)
    for i in range(bounces):
        time = start + take.beat(0.30) + i * period
        take.hand(side, time, (0.10, -0.50, 0.52), (0.7, -0.2, -0.7), flex=-12.0)
        take.hand(side, time + 0.45 * period, (0.12, -0.76, 0.50), (0.7, -0.2, -0.7), flex=30.0)
        take.event(time, "catch", f"{side}_wrist", "ball")
        take.event(time + 0.45 * period, "release", f"{side}_wrist", "ball")
        take.hand(other, time + 0.2, (0.22, -0.50, 0.40), (0.9, -0.4, -0.2))
    caught = start + take.beat(0.30) + bounces * period
    take.hand(side, caught, (0.02, -0.50, 0.52))
    take.event(caught, "catch", f"{side}_wrist", "ball")
    if not steps:
        take.rest = HOLD
        end = caught + take.beat(0.35)
        take.relax(end)
        take.end("dribble", end)
    else:
        end = max(end, caught + take.beat(0.3))
        take.relax(end)
        take.segments[-1] = ("dribble", start, end)
        take.now = end


def shoot(take: Take, height: float = 0.16) -> None:
    """Dip, rise with the ball over the forehead, jump, release at the top, follow through, land."""
    start, side = take.begin(), take.person.hand
    other = other_side(side)
    dip, off = start + take.beat(0.42), start + take.beat(0.42) + 0.34
    take.pelvis(dip, dh=-0.24, dz=-0.07)
    take.key(dip, tilt=20.0, lean=12.0, nod=-8.0)
    both(take, dip, -0.52, 0.40)
    both(take, off - 0.06, 0.34, 0.34)
    take.key(off, tilt=2.0, lean=1.0, nod=-14.0)
    land = flight(take, off, height * take.vigour, 0.06, tuck=0.0)
    gone = off + 0.45 * (land - off)
    up = (0.4, -0.3, 0.8)
    take.hand(side, gone, (-0.10, 0.86, 0.42), up, flex=10.0)
    take.hand(side, gone + 0.16, (-0.10, 0.80, 0.52), up, flex=62.0)
    take.hand(other, gone, (-0.02, 0.66, 0.36), up)
    take.hand(other, gone + 0.16, (0.10, 0.52, 0.40), up)
    take.event(gone, "release", f"{side}_wrist", "ball")
    absorbed = land + take.beat(0.2)
    take.pelvis(absorbed, dh=-0.11)
    take.key(absorbed, tilt=7.0, lean=6.0, nod=-10.0)
    take.hand(side, absorbed, (0.02, 0.22, 0.72), up, flex=48.0)
    take.hand(other, absorbed, (0.14, -0.10, 0.62))
    take.rest = STAND
    end = absorbed + take.beat(0.65)
    take.relax(end)
    take.end("shoot", end)


def fake_shot(take: Take) -> None:
    """Raise the ball and the eyes as for a shot, the feet staying, and come down at once."""
    start = take.begin()
    take.rest = HOLD
    up = start + take.beat(0.36)
    both(take, up, 0.24, 0.40)
    take.pelvis(up, dh=-0.03, dz=-0.02)
    take.key(up, tilt=5.0, lean=2.0, nod=-16.0)
    down = up + take.beat(0.30)
    take.pelvis(down, dh=-0.17, dz=-0.06)
    take.key(down, tilt=20.0, lean=12.0, nod=0.0)
    both(take, down, -0.44, 0.42)
    end = down + take.beat(0.30)
    take.relax(end)
    take.end("fake_shot", end)


def feint(take: Take, side: str) -> None:
    """A quick false step to one side, with trunk and ball, and back."""
    start = take.begin()
    sign = 1.0 if side == "l" else -1.0
    gone, back = start + take.beat(0.32), start + take.beat(0.72)
    foot = take.stance(side)
    x, z = take.world((0.5 * take.width + 0.30) * sign, 0.20 * take.person.scale)
    take.step(side, start + 0.06, gone, (x, z, foot[2] + 12 * sign), height=0.05, roll=(10.0, 0.0))
    take.pelvis(gone, dx=0.10 * sign, dh=take.rest["dh"] - 0.08, dz=0.05)
    take.key(gone, side=-10.0 * sign, twist=14.0 * sign, look=16.0 * sign, tilt=16.0)
    if take.rest is HOLD:
        near, far = (0.16, -0.50, 0.46), (-0.40, -0.48, 0.50)
        take.hand(side, gone, near)
        take.hand(other_side(side), gone, far)
    else:
        for arm in "lr":
            take.hand(arm, gone, (0.20, -0.60, 0.40))
    take.step(side, gone + 0.08, back, foot, height=0.05, roll=(10.0, 0.0))
    end = back + take.beat(0.35)
    take.relax(end)
    take.end("feint", end)


def layup(take: Take) -> None:
    """Two long steps, a jump off one foot, the other knee up, the ball laid up with one hand."""
    start, hand = take.begin(), take.person.hand
    plant, knee = other_side(hand), hand
    scale, sign = take.person.scale, (1.0 if hand == "l" else -1.0)
    period, time = take.beat(0.40), start + 0.1
    for side, ahead in ((knee, 0.65), (plant, 0.85)):
        x, z = take.world(0.0, ahead * scale)
        before = take.place.copy()
        take.place[:2] = x, z
        to = take.stance(side, -0.3 * take.width)
        lift = time + (0.03 if side == knee else -0.12)
        take.step(side, lift, time + period, to, height=0.16, roll=(38.0, 8.0))
        middle = 0.6 * take.place + 0.4 * before
        keep, take.place = take.place, middle
        take.pelvis(time + period, dh=-0.10)
        take.place = keep
        time += period
    take.key(time, tilt=8.0, lean=8.0, nod=-8.0)
    both(take, start + 0.1 + period, -0.40, 0.42)
    both(take, time, -0.30, 0.46)
    off = time + 0.20
    _layup_flight(take, off, (plant, knee), sign)
    take.rest = STAND
    end = max(take.keys["py"]) + take.beat(0.65)
    take.relax(end)
    take.end("layup", end)


def _layup_flight(take: Take, off: float, feet: tuple[str, str], sign: float) -> None:
    """Take off from the planted foot, release near the top, land on both feet."""
    plant, knee = feet
    scale, height = take.person.scale, 0.34 * take.vigour
    duration = 2.0 * np.sqrt(2.0 * height * scale / GRAVITY)
    land, here = off + duration, take.place.copy()
    there = np.array([*take.world(0.0, 0.75 * scale), here[2]])
    take.key(off, tilt=0.0, lean=2.0, nod=-16.0, side=-4.0 * sign)
    for i in range(7):
        share = i / 6
        take.place = here + (0.10 + 0.90 * share) * (there - here)
        time, rise = off + share * duration, 4 * height * share * (1 - share)
        take.pelvis(time, dh=0.03 * (1 - share) + rise)
        take.key(time, **{f"{plant}y": 0.92 * rise * scale})
    lift = off - 0.30
    take.key(lift, **{f"{knee}y": 0.0})
    for name, value in zip(("x", "z", "yaw"), take.stance(knee, 0.05)):
        take.key(lift, **{knee + name: take.last(knee + name)})
        take.key(land, **{knee + name: value})
    take.place = here + 0.35 * (there - here)
    x, z = take.world(sign * 0.09 * scale, 0.12 * scale)
    take.key(off + 0.1 * duration, **{f"{knee}x": x, f"{knee}z": z, f"{knee}y": 0.50 * scale})
    take.key(off + 0.6 * duration, **{f"{knee}y": 0.52 * scale})
    take.key(land, **{f"{knee}y": 0.0})
    take.place = there
    for name, value in zip(("x", "z", "yaw"), take.stance(plant, 0.05)):
        take.key(off, **{plant + name: take.last(plant + name)})
        take.key(land, **{plant + name: value})
    for side, first in ((plant, off), (knee, lift)):
        times = (first - 0.16, first, land - 0.03, land + 0.08)
        for time, heel in zip(times, (0.0, 36.0, 16.0, 0.0)):
            take.key(time, **{f"{side}heel": heel, f"{side}bend": 0.7 * heel})
        take.event(land, "foot_strike", f"{side}_ankle", "ground")
    take.event(lift, "foot_off", f"{knee}_ankle", "ground")
    take.event(off, "take_off", f"{plant}_ankle", "ground")
    _layup_hands(take, off, land, feet)


def _layup_hands(take: Take, off: float, land: float, feet: tuple[str, str]) -> None:
    """The ball goes up with both hands, and leaves the one over the raised knee."""
    plant, knee = feet
    duration = land - off
    gone, up = off + 0.48 * duration, (0.5, -0.2, 0.7)
    both(take, off, 0.24, 0.44)
    take.hand(knee, gone, (-0.02, 0.92, 0.34), up, flex=15.0)
    take.hand(plant, gone, (0.10, 0.10, 0.60), (0.9, -0.4, -0.2))
    take.event(gone, "release", f"{knee}_wrist", "ball")
    absorbed = land + take.beat(0.22)
    take.hand(knee, absorbed, (0.14, -0.40, 0.56))
    take.hand(plant, absorbed, (0.22, -0.55, 0.46))
    take.key(absorbed, tilt=14.0, lean=14.0, nod=-4.0, side=0.0)
    take.pelvis(absorbed, dh=-0.18)
