"""Ways of getting about: walking, running, turning on the spot, pivoting, shuffling sideways.

The footsteps come first: step i lands at time L_i at distance d_i along the path; the pelvis passes
between them, and the arms swing against the legs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sample_data.score import Take


@dataclass(frozen=True)
class Gait:
    """A way of stepping: metres and seconds on the standard body, degrees.

    Attributes
    ----------
    length, period : of one step.
    swing : share of the period that a foot is in the air (over 1: there is flight).
    lead : where the pelvis is at landing, as a share of a step behind the landing foot.
    height : of the swinging foot; roll : heel up at lifting, toes up at landing.
    low, high : pelvis height against standing, at share ``bob`` of the period after a landing
        and half a period away from that.
    tilt, lean : of pelvis and trunk.
    forward, back : the hands at the ends of their swing (outward, up, ahead).
    """

    length: float
    period: float
    swing: float
    lead: float
    height: float
    roll: tuple[float, float]
    low: float
    high: float
    bob: float
    tilt: float
    lean: float
    forward: tuple[float, float, float]
    back: tuple[float, float, float]


WALK = Gait(
    length=0.66, period=0.54, swing=0.84, lead=0.5, height=0.045, roll=(34.0, 13.0),
    low=-0.035, high=-0.012, bob=0.0, tilt=3.0, lean=1.0,
    forward=(0.02, -0.88, 0.36), back=(0.14, -0.92, -0.26),
)  # fmt: skip
RUN = Gait(
    length=1.05, period=0.36, swing=1.42, lead=0.30, height=0.30, roll=(46.0, 3.0),
    low=-0.075, high=0.015, bob=0.3, tilt=7.0, lean=6.0,
    forward=(-0.10, -0.34, 0.46), back=(0.18, -0.58, -0.24),
)  # fmt: skip


def walk(take: Take, steps: int = 6, turn: float = 0.0, label: str = "walk") -> None:
    """Walk ``steps`` steps, heading ``turn`` degrees to the left by the end."""
    travel(take, personal(take, WALK), [1.0] * steps, turn, label)


def run(take: Take, steps: int = 8, turn: float = 0.0, label: str = "run") -> None:
    """Run ``steps`` steps, picking up speed and slowing down."""
    sizes = [0.55, 0.8] + [1.0] * (steps - 4) + [0.8, 0.5]
    travel(take, personal(take, RUN), sizes, turn, label)


def personal(take: Take, gait: Gait) -> Gait:
    """A gait as this performer does it."""
    amount, size = take.vigour, take.person.scale
    forward = (*gait.forward[:2], gait.forward[2] * amount)
    back = (*gait.back[:2], gait.back[2] * amount)
    length = gait.length * size * (0.5 + 0.5 * amount)
    return replace(gait, length=length, period=take.beat(gait.period), forward=forward, back=back)


def travel(
    take: Take,
    gait: Gait,
    sizes: list[float],
    turn: float,
    label: str,
    arms: str = "lr",
) -> float:
    """Step along a path; ``sizes`` scale the steps, a closing step follows. Returns the end time.

    turn : degrees to the left over the whole path; arms : the sides whose arms swing.
    """
    start, period = take.begin() + 0.12, gait.period
    first = "lr"[take.random.randint(2)]
    centres = _centres(take, gait, sizes, turn)
    sides = [first if i % 2 == 0 else other_side(first) for i in range(len(centres))]
    before = passed = take.place.copy()
    for i, (centre, side) in enumerate(zip(centres, sides)):
        land = start + (i + 1) * period
        closing = i == len(centres) - 1
        take.place = centre
        widen = 0.0 if closing else -0.35 * take.width
        lift = max(land - gait.swing * period, start - 0.08 + 0.05 * i)
        ease = 0.5 if closing or i == 0 else 1.0
        take.step(
            side, lift, land, take.stance(side, widen),
            height=gait.height * ease, roll=(gait.roll[0] * ease, 0 if closing else gait.roll[1]),
        )  # fmt: skip
        now = centre if closing else centre + gait.lead * (before - centre)
        _body_over_step(take, gait, land, side, (passed, now), closing)
        if not closing:
            _arms_over_step(take, gait, land, side, arms)
        before, passed = centre, now
    take.place = centres[-1]
    end = start + len(centres) * period + take.beat(0.28)
    take.relax(end)
    take.end(label, end)
    return end


def _centres(take: Take, gait: Gait, sizes: list[float], turn: float) -> list[np.ndarray]:
    """Where the middle of the path is (x, z, heading) at each footfall, the last one closing."""
    here, centres = take.place.copy(), []
    for i, size in enumerate(sizes):
        share = turn / len(sizes)
        yaw = np.deg2rad(here[2] + share / 2)
        length = gait.length * size * (0.55 if i == 0 else 1.0)
        here = here + np.array([length * np.sin(yaw), length * np.cos(yaw), share])
        centres.append(here)
    return [*centres, here]


def _body_over_step(
    take: Take,
    gait: Gait,
    land: float,
    side: str,
    path: tuple[np.ndarray, np.ndarray],
    closing: bool,
) -> None:
    """Pelvis and trunk at a landing and in the middle of the step before it.

    path : (x, z, heading) of the pelvis at the landing before and at this one.
    """
    sign, amount = (1.0 if side == "l" else -1.0), take.vigour * (0.4 if closing else 1.0)
    passed, now = path
    middle, bob = land - 0.5 * gait.period, gait.bob * gait.period
    take.place = 0.5 * (passed + now)
    take.pelvis(middle, dx=-0.022 * sign, dh=None)
    take.key(middle, roll=-2.5 * sign, yaw=take.place[2], side=0.0)
    take.key(middle + bob, py=take.height(gait.high))
    take.place = now
    take.pelvis(land, dh=None)
    if not closing:
        take.key(land + bob, py=take.height(gait.low))
    take.key(
        land,
        yaw=now[2] - 5.0 * sign * amount,
        twist=9.0 * sign * amount,
        tilt=gait.tilt * (0.5 if closing else 1.0),
        lean=gait.lean + take.person.lean,
        roll=0.0,
        nod=2.0,
    )


def _arms_over_step(take: Take, gait: Gait, land: float, side: str, arms: str) -> None:
    """The arm opposite to the landing foot is forward, the other one back."""
    for arm in arms:
        take.hand(arm, land, gait.back if arm == side else gait.forward)


def other_side(side: str) -> str:
    """The other one of "l" and "r"."""
    return "r" if side == "l" else "l"


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
