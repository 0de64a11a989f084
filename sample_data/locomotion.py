"""Ways of getting about: walking, running, and following a path at any gait.

The footsteps come first: step i lands at time L_i at distance d_i along the path; the pelvis passes
between them, and the arms swing against the legs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .score import Take


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
    length=0.62, period=0.54, swing=0.84, lead=0.5, height=0.045, roll=(44.0, 14.0),
    low=-0.022, high=-0.012, bob=0.0, tilt=3.0, lean=1.0,
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
