"""Kicks and punches, and what goes with them: the ready stance, parrying, ducking, pushing."""

from __future__ import annotations

from .score import FISTS, READY, STAND, Take

Place = tuple[float, float, float]
_KICKS: dict[str, tuple[Place, Place, float]] = {
    # chambered and extended ankle: (outward, up, ahead) of the place, metres; trunk back, degrees
    "front": ((0.06, 0.52, 0.26), (0.02, 0.82, 0.74), -14.0),
    "low": ((0.06, 0.34, 0.22), (0.0, 0.38, 0.66), -6.0),
    "round": ((0.34, 0.56, 0.10), (-0.10, 0.72, 0.66), -12.0),
}


def kick(take: Take, side: str, way: str = "front") -> None:
    """Shift the weight, chamber the knee, kick out, draw back and put the foot down.

    way : "front", "low" or "round" (from the side).
    """
    start, scale = take.begin(), take.person.scale
    sign = 1.0 if side == "l" else -1.0
    other = "r" if side == "l" else "l"
    chamber, extended, back = _KICKS[way]
    times = [start + take.beat(s) for s in (0.22, 0.36, 0.58, 0.75, 0.83, 1.02, 1.30)]
    lift, swung, drawn, struck, held, folded, down = times
    stance = take.stance(side)
    size = 0.6 + 0.4 * take.vigour
    behind = (0.02, 0.10, -0.24)
    path = [(swung, behind, 38.0), (drawn, chamber, 30.0), (struck, extended, 12.0),
            (held, extended, 12.0), (folded, chamber, 20.0)]  # fmt: skip
    for name, value in zip(("x", "z", "yaw"), stance):
        take.key(lift, **{side + name: take.last(side + name)})
        take.key(down, **{side + name: value})
    take.key(lift - 0.1, **{f"{side}heel": 0.0, f"{side}bend": 0.0})
    take.key(lift, **{f"{side}y": 0.0, f"{side}heel": 20.0, f"{side}bend": 18.0})
    for time, (out, up, ahead), heel in path:
        x, z = take.world(sign * (0.09 + out) * scale, ahead * scale)
        height = (0.08 + (up - 0.08) * size) * scale
        take.key(time, **{f"{side}x": x, f"{side}z": z, f"{side}y": height})
        take.key(time, **{f"{side}heel": heel, f"{side}bend": 0.0, f"{side}toe": 0.0})
    take.key(down, **{f"{side}y": 0.0, f"{side}heel": 0.0})
    _balance(take, side, times, back, way)
    for arm, place in ((side, (0.30, -0.66, -0.24)), (other, (0.0, -0.36, 0.52))):
        low = take.rest["rhy"] < -0.6
        take.hand(arm, struck, place if low else (FISTS[0] + 0.04, -0.2, 0.36))
    take.event(lift, "foot_off", f"{side}_ankle", "ground")
    take.event(struck, "contact", f"{side}_toe", "target")
    take.event(down, "foot_strike", f"{side}_ankle", "ground")
    end = down + take.beat(0.35)
    take.relax(end)
    take.end("kick", end)


def _balance(take: Take, side: str, times: list[float], back: float, way: str) -> None:
    """Pelvis and trunk of a kick: over the standing foot, leaning away."""
    sign = 1.0 if side == "l" else -1.0
    lift, _, drawn, struck, held, _, down = times
    turned = {"front": 12.0, "low": 8.0, "round": 42.0}[way] * sign
    for time, share in ((lift, 0.2), (drawn, 0.6), (struck, 1.0), (held, 1.0)):
        take.pelvis(time, dx=-0.085 * sign, dh=-0.03, dz=-0.05 * share)
        take.key(time, tilt=back * share, yaw=take.place[2] - turned * share)
        take.key(time, lean=take.rest["lean"] + 8.0 * share, roll=4.0 * sign * share)
        take.key(time, twist=0.5 * turned * share, nod=6.0)
    take.pelvis(down, dx=-0.02 * sign, dh=take.rest["dh"] - 0.03)


def punch(take: Take, side: str, height: float = 0.0) -> None:
    """Raise the fists, drive one straight ahead with the trunk behind it, and draw it back.

    height : of the target over the shoulder, arm lengths.
    """
    start = take.begin()
    sign = 1.0 if side == "l" else -1.0
    other = "r" if side == "l" else "l"
    drawn = start + take.beat(0.16 if take.rest is READY else 0.45)
    struck, back = drawn + take.beat(0.20), drawn + take.beat(0.52)
    ahead = 0.20 * take.vigour * take.person.scale
    foot = take.stance(other)
    x, z = take.world((0.5 * take.width + 0.02) * -sign, ahead)
    lift = drawn - take.beat(0.04)
    take.step(other, lift, struck, (x, z, foot[2]), height=0.04, roll=(6.0, 0.0))
    for time, value in ((drawn, 0.0), (struck, 24.0), (back, 4.0), (back + 0.1, 0.0)):
        take.key(time, **{f"{side}heel": value, f"{side}bend": value})
    take.pelvis(drawn, dh=-0.05, dz=-0.02)
    take.key(drawn, twist=16.0 * sign, yaw=take.place[2] + 6.0 * sign, lean=8.0, tilt=4.0, nod=5.0)
    take.hand(side, drawn, (0.04, -0.22, 0.26))
    take.hand(other, drawn, FISTS)
    for time in (struck, struck + 0.07):
        take.pelvis(time, dh=-0.08, dz=0.11)
        take.key(time, twist=-24.0 * sign, yaw=take.place[2] - 14.0 * sign, lean=10.0, tilt=8.0)
        # outward in the chest's frame is ahead in the world: the chest has turned
        take.hand(side, time, (0.40, height - 0.02, 0.87), (0.6, -0.8, -0.2))
        take.hand(other, time, (-0.12, -0.12, 0.34))
    take.event(struck, "contact", f"{side}_wrist", "target")
    take.posture(back, READY)
    take.step(other, back, back + take.beat(0.28), foot, height=0.04, roll=(6.0, 0.0))
    end = back + take.beat(0.32 if take.rest is READY else 0.75)
    take.relax(end)
    take.end("punch", end)


def ready(take: Take) -> None:
    """Raise the fists into the ready stance, or bounce in it."""
    start = take.begin()
    take.rest = READY
    up = start + take.beat(0.5)
    take.relax(up)
    for i in range(2):
        take.pelvis(up + take.beat(0.15 + 0.3 * i), dh=-0.10)
        take.pelvis(up + take.beat(0.30 + 0.3 * i), dh=-0.05)
    end = up + take.beat(0.7)
    take.relax(end)
    take.end("ready", end)


def lower_fists(take: Take) -> None:
    """Leave the ready stance."""
    start = take.begin()
    take.rest = STAND
    end = start + take.beat(0.6)
    take.relax(end)
    take.end("idle", end)


def parry(take: Take, side: str) -> None:
    """Sweep one forearm up before the face, the trunk turning away."""
    start = take.begin()
    sign = 1.0 if side == "l" else -1.0
    other = "r" if side == "l" else "l"
    swept, held = start + take.beat(0.26), start + take.beat(0.42)
    for time in (swept, held):
        take.pelvis(time, dx=0.02 * sign, dh=-0.09, dz=-0.04)
        take.key(time, twist=14.0 * sign, lean=4.0, tilt=-2.0)
        take.hand(side, time, (0.10, 0.36, 0.44), (0.9, 0.1, 0.2))
        take.hand(other, time, (-0.12, -0.16, 0.32))
    take.event(swept, "contact", f"{side}_wrist", "target")
    end = held + take.beat(0.4)
    take.relax(end)
    take.end("parry", end)


def duck(take: Take) -> None:
    """Drop under a blow, fists up, and come back."""
    start = take.begin()
    down = start + take.beat(0.34)
    for time in (down, down + take.beat(0.14)):
        take.pelvis(time, dh=-0.34, dz=-0.05)
        take.key(time, tilt=24.0, lean=28.0, nod=-6.0)
        for side in "lr":
            take.hand(side, time, (-0.10, 0.0, 0.36))
    end = down + take.beat(0.62)
    take.relax(end)
    take.end("duck", end)


def push(take: Take) -> None:
    """Bring both hands to the chest and push away with a step behind them."""
    start = take.begin()
    side, other = take.person.hand, "l" if take.person.hand == "r" else "r"
    sign = 1.0 if other == "l" else -1.0
    loaded, pushed = start + take.beat(0.40), start + take.beat(0.66)
    back = pushed + take.beat(0.30)
    foot = take.stance(other)
    x, z = take.world(0.55 * take.width * sign, 0.26 * take.person.scale)
    take.step(other, loaded - 0.05, pushed, (x, z, foot[2]), height=0.04, roll=(8.0, 0.0))
    for time, value in ((loaded, 0.0), (pushed, 20.0), (back, 3.0), (back + 0.1, 0.0)):
        take.key(time, **{f"{side}heel": value, f"{side}bend": value})
    take.pelvis(loaded, dh=-0.10, dz=-0.05)
    take.key(loaded, tilt=6.0, lean=4.0)
    for time in (pushed, pushed + 0.12):
        take.pelvis(time, dh=-0.10, dz=0.15)
        take.key(time, tilt=14.0, lean=10.0, nod=-6.0)
    for arm in "lr":
        take.hand(arm, loaded, (-0.02, -0.12, 0.30), (0.8, -0.6, -0.4))
        take.hand(arm, pushed, (0.0, -0.02, 0.90), (0.8, -0.6, -0.4), flex=-40.0)
        take.hand(arm, pushed + 0.12, (0.0, -0.02, 0.92), (0.8, -0.6, -0.4), flex=-40.0)
        take.event(pushed, "contact", f"{arm}_wrist", "opponent")
    take.step(other, back, back + take.beat(0.32), foot, height=0.04, roll=(8.0, 0.0))
    end = back + take.beat(0.6)
    take.relax(end)
    take.end("push", end)
