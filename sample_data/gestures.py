"""Everyday actions on the spot: idling, waving, bowing, picking up, sitting and rising, jumping."""

from __future__ import annotations

import numpy as np

from .score import HANG, SEATED, STAND, Take

SEAT = 0.50
"""Height of the hip joints of somebody seated, metres on the standard body."""
GRAVITY = 9.81


def idle(take: Take, seconds: float = 1.0, label: str = "idle") -> None:
    """Stay in the posture of rest, the weight going from foot to foot."""
    start = take.begin()
    dh, dz = take.rest["dh"], take.rest["dz"]
    pieces = max(1, round(seconds / 1.1))
    side = 1.0 if take.random.randint(2) else -1.0
    for i in range(pieces):
        time = start + seconds * (i + 0.5) / pieces
        if dh > -0.3:
            take.pelvis(time, dx=0.018 * side, dh=dh - 0.003, dz=dz)
            take.key(time, roll=1.2 * side, side=-1.5 * side)
        side = -side
    end = start + seconds
    take.relax(end)
    take.end(label, end)


def wave(take: Take, side: str, times: int = 4) -> None:
    """Raise a hand beside the head and swing the forearm."""
    start, size = take.begin(), take.vigour
    sign = 1.0 if side == "l" else -1.0
    elbow = (0.9, -0.7, -0.1)
    up, period = start + take.beat(0.55), take.beat(0.46)
    take.hand(side, start + take.beat(0.28), (0.42, -0.45, 0.42), (0.8, -0.5, -0.3))
    for i in range(2 * times + 1):
        swing = (0.16 if i % 2 else -0.16) * size
        take.hand(side, up + i * period / 2, (0.34 + swing, 0.40 - 0.3 * abs(swing), 0.26), elbow)
        take.key(up + i * period / 2, side=-1.5 * sign, roll=0.0)
    done = up + times * period
    take.key(up, look=6.0 * sign, nod=-2.0)
    take.key(done, look=6.0 * sign, nod=-2.0)
    take.hand(side, done + take.beat(0.3), (0.40, -0.50, 0.36), (0.7, -0.5, -0.5))
    end = done + take.beat(0.65)
    take.relax(end)
    take.end("wave", end)


def bow(take: Take, depth: float = 55.0) -> None:
    """Bend forward from the hips, the hands along the thighs, stay, and come up."""
    start, depth = take.begin(), depth * (0.5 + 0.5 * take.vigour)
    down, up = start + take.beat(0.85), start + take.beat(1.35)
    for time in (down, up):
        take.pelvis(time, dh=-0.02, dz=-0.11)
        take.key(time, tilt=0.55 * depth, lean=0.5 * depth + take.person.lean, nod=14.0)
        for side in "lr":
            take.hand(side, time, (-0.02, -0.84, 0.34))
    end = up + take.beat(0.9)
    take.relax(end)
    take.end("bow", end)


def pick_up(take: Take, side: str, height: float = 0.12) -> None:
    """Squat and bend to an object before the feet, grasp it, lift it, and lower the hand again."""
    start = take.begin()
    sign = 1.0 if side == "l" else -1.0
    other = "r" if side == "l" else "l"
    grasp = start + take.beat(0.95)
    place = (-0.08, height, 0.52)
    take.key(start + take.beat(0.3), nod=18.0)
    for time in (grasp, grasp + take.beat(0.22)):
        take.pelvis(time, dh=-0.36, dz=-0.14)
        take.key(time, tilt=38.0, lean=30.0, nod=10.0, twist=-7.0 * sign, side=3.0 * sign)
        take.reach(side, time, place)
        take.hand(other, time, (0.06, -0.62, 0.52))
    take.key(start, **{f"{side}g{axis}": v for axis, v in zip("xyz", (0.15, 0.6, 0.25))})
    take.event(grasp, "contact", f"{side}_wrist", "object")
    carried = grasp + take.beat(1.15)
    take.posture(carried, take.rest)
    take.hand(side, carried, (-0.02, -0.52, 0.50))
    take.hand(side, carried + take.beat(0.25), (-0.02, -0.52, 0.50))
    end = carried + take.beat(0.75)
    take.relax(end)
    take.end("pick_up", end)


def sit_down(take: Take, stay: float = 1.0) -> None:
    """Lower onto a seat behind, then stay seated for a while."""
    start = take.begin()
    seated = SEATED | {"dh": SEAT - 0.924}
    lean, contact = start + take.beat(0.45), start + take.beat(1.15)
    take.pelvis(lean, dh=-0.08, dz=-0.10)
    take.key(lean, tilt=16.0, lean=22.0 + take.person.lean, nod=8.0)
    for side in "lr":
        take.hand(side, lean, (0.12, -0.80, 0.34))
    take.pelvis(contact, dh=seated["dh"], dz=seated["dz"])
    take.key(contact, tilt=14.0, lean=24.0 + take.person.lean, nod=4.0)
    for side in "lr":
        take.hand(side, contact, (0.0, -0.72, 0.50))
    take.event(contact, "sit_contact", "pelvis", "chair")
    take.rest = seated
    end = contact + take.beat(0.6)
    take.relax(end)
    take.end("sit_down", end)
    if stay:
        idle(take, stay, "sit")


def stand_up(take: Take) -> None:
    """Rise from the seat: lean forward over the feet, push up with the hands, straighten."""
    start = take.begin()
    leave, risen = start + take.beat(0.60), start + take.beat(1.35)
    take.pelvis(leave, dh=take.rest["dh"] + 0.01, dz=take.rest["dz"] + 0.05)
    take.key(leave, tilt=24.0, lean=30.0 + take.person.lean, nod=-4.0)
    for side in "lr":
        take.hand(side, leave, (0.02, -0.74, 0.44))
    take.event(leave, "sit_release", "pelvis", "chair")
    take.pelvis(leave + 0.55 * (risen - leave), dh=-0.12, dz=-0.08)
    take.key(leave + 0.55 * (risen - leave), tilt=16.0, lean=18.0 + take.person.lean)
    take.rest = STAND
    take.pelvis(risen, dh=0.004, dz=0.01)
    take.key(risen, tilt=0.0, lean=2.0 + take.person.lean, nod=0.0)
    for side in "lr":
        take.hand(side, risen, (HANG[0], -0.93, 0.16))
    end = risen + take.beat(0.3)
    take.relax(end)
    take.end("stand_up", end)


def jump(take: Take, height: float = 0.26, forward: float = 0.0, label: str = "jump") -> None:
    """Crouch with the arms back, jump with the arms up, land with bent knees."""
    start, height = take.begin(), height * take.vigour
    crouch = start + take.beat(0.55)
    take.pelvis(crouch, dh=-0.27, dz=-0.07)
    take.key(crouch, tilt=24.0, lean=22.0, nod=-4.0)
    for side in "lr":
        take.hand(side, crouch, (0.16, -0.80, -0.46))
    off = crouch + 0.27
    rise = {"lr"[i]: ((0.14, 0.62, 0.52), (0.5, -0.3, -0.6)) for i in range(2)}
    land = flight(take, off, height, forward)
    for side, (place, elbow) in rise.items():
        take.hand(side, crouch + 0.16, (0.08, -0.70, 0.52))
        take.hand(side, 0.5 * (off + land), tuple(np.array(place) * [1, take.vigour, 1]), elbow)
    take.key(off, tilt=6.0, lean=6.0, nod=-6.0)
    take.key(0.5 * (off + land), tilt=4.0, lean=5.0, nod=0.0)
    absorbed = land + take.beat(0.22)
    take.pelvis(absorbed, dh=-0.20, dz=-0.03)
    take.key(absorbed, tilt=18.0, lean=18.0, nod=4.0)
    for side in "lr":
        take.hand(side, absorbed, (0.24, -0.62, 0.46))
    end = absorbed + take.beat(0.6)
    take.relax(end)
    take.end(label, end)


def flight(take: Take, off: float, height: float, forward: float, tuck: float = 0.10) -> float:
    """Both feet leave the ground at ``off``, the pelvis on a parabola; returns the landing time.

    height : of the pelvis's rise, forward : of the place's advance, metres on the standard body;
    tuck : how far the feet are drawn up beside that, metres.
    """
    scale = take.person.scale
    duration = 2.0 * np.sqrt(2.0 * height * scale / GRAVITY)
    land, base = off + duration, 0.035
    here = take.place.copy()
    x, z = take.world(0.0, forward * scale)
    for i in range(7):
        share = i / 6
        rise = 4.0 * share * (1.0 - share)
        take.place[:2] = here[:2] + share * (np.array([x, z]) - here[:2])
        take.pelvis(off + share * duration, dh=base * (1 - share) + height * rise)
        for side in "lr":
            lifted = (height * rise + tuck * rise) * scale
            take.key(off + share * duration, **{f"{side}y": lifted})
    for side in "lr":
        for name, value in zip(("x", "z", "yaw"), take.stance(side, 0.05)):
            take.key(off, **{side + name: take.last(side + name)})
            take.key(land, **{side + name: value})
        take.key(off - 0.17, **{f"{side}heel": 0.0, f"{side}bend": 0.0})
        take.key(off, **{f"{side}heel": 34.0, f"{side}bend": 30.0})
        take.key(land - 0.03, **{f"{side}heel": 16.0, f"{side}bend": 8.0})
        take.key(land + 0.08, **{f"{side}heel": 0.0, f"{side}bend": 0.0})
        take.event(off, "take_off", f"{side}_ankle", "ground")
        take.event(land, "foot_strike", f"{side}_ankle", "ground")
    return land
