"""Basketball without the ball: guarding, blocking a shot, setting a screen."""

from __future__ import annotations

from .footwork import shuffle
from .gestures import flight
from .locomotion import other_side
from .score import HOLD, STAND, Posture, Take, hands

DEFEND: Posture = (
    STAND
    | {"dh": -0.17, "dz": -0.06, "tilt": 18.0, "lean": 8.0, "nod": -2.0}
    | hands((0.52, -0.42, 0.42), (0.52, -0.42, 0.42))
)
"""Low, the arms wide."""


def block(take: Take) -> None:
    """Jump straight up with one hand high to block a shot."""
    start, side = take.begin(), take.person.hand
    crouch = start + take.beat(0.40)
    take.pelvis(crouch, dh=-0.25, dz=-0.06)
    take.key(crouch, tilt=18.0, lean=14.0, nod=-10.0)
    for arm in "lr":
        take.hand(arm, crouch, (0.20, -0.60, 0.36))
    off = crouch + 0.25
    land = flight(take, off, 0.30 * take.vigour, 0.12, tuck=0.03)
    top = off + 0.45 * (land - off)
    take.key(off, tilt=2.0, lean=2.0, nod=-16.0)
    sign = 1.0 if side == "l" else -1.0
    take.key(top, side=-7.0 * sign)
    take.hand(side, top, (0.02, 0.97, 0.16), (0.6, 0.0, 0.7), flex=-5.0)
    take.hand(other_side(side), top, (0.34, 0.16, 0.50), (0.9, -0.3, -0.2))
    take.event(top, "contact", f"{side}_wrist", "ball")
    absorbed = land + take.beat(0.2)
    take.pelvis(absorbed, dh=-0.17, dz=-0.03)
    take.key(absorbed, tilt=14.0, lean=12.0, nod=-2.0, side=0.0)
    take.hand(side, absorbed, (0.22, 0.05, 0.70))
    take.hand(other_side(side), absorbed, (0.26, -0.50, 0.46))
    end = absorbed + take.beat(0.6)
    take.relax(end)
    take.end("block", end)


def screen(take: Take, seconds: float = 1.5) -> None:
    """Stand wide and still in the way of an opponent, the forearms crossed before the body."""
    start = take.begin()
    home, place = {side: take.stance(side) for side in "lr"}, take.place.copy()
    for i, side in enumerate("lr"):
        lift = start + take.beat(0.06 + 0.28 * i)
        take.step(side, lift, lift + take.beat(0.28), take.stance(side, 0.26), height=0.05)
    set_up, stay = start + take.beat(0.75), start + take.beat(0.75 + seconds)
    crossed = {"l": (-0.34, -0.52, 0.34), "r": (-0.34, -0.60, 0.28)}
    for time in (set_up, stay):
        take.pelvis(time, dh=-0.12, dz=-0.02)
        take.key(time, tilt=3.0, lean=3.0 + take.person.lean, nod=2.0)
        for side in "lr":
            take.hand(side, time, crossed[side], (0.9, -0.5, -0.1))
    take.event(0.5 * (set_up + stay), "contact", "chest", "opponent")
    take.key(0.5 * (set_up + stay), tilt=-3.0)
    take.place = place
    for i, side in enumerate("lr"):
        lift = stay + take.beat(0.05 + 0.28 * i)
        take.step(side, lift, lift + take.beat(0.28), home[side], height=0.05)
    end = stay + take.beat(0.75)
    take.relax(end)
    take.end("screen", end)


def guard(take: Take, slides: tuple[float, ...] = (0.5, -0.5)) -> None:
    """Defend: low, the arms wide, sliding to the left (positive metres) and right."""
    start, before = take.begin(), take.rest
    take.rest = DEFEND
    set_up = start + take.beat(0.62)
    lift = start + take.beat(0.08)
    for side in "lr":
        to = take.stance(side, 0.18)
        take.step(side, lift, lift + take.beat(0.25), to, height=0.04, roll=(6.0, 0.0))
        lift += take.beat(0.25)
    take.relax(set_up)
    take.now = set_up
    for metres in slides:
        shuffle(take, metres, max(1, round(abs(metres) / 0.28)))
    lift = take.begin() + 0.05
    take.rest = STAND if before is HOLD else before
    for side in "lr":
        take.step(
            side, lift, lift + take.beat(0.3), take.stance(side), height=0.04, roll=(6.0, 0.0)
        )
        lift += take.beat(0.3)
    end = lift + take.beat(0.25)
    take.relax(end)
    take.now = start
    take.end("guard", end)
