"""A box in both hands: lifting it from a table, carrying, handing over, receiving, setting down.

There is no box in the files: its instants are among the events. A box is carried before the body in
the posture ``CARRY``; the table is 0.75 m high, a hand's breadth before the feet.
"""

from __future__ import annotations

from dataclasses import replace

from .locomotion import WALK, personal, travel
from .score import STAND, Take, hands

_INWARD = -0.16
"""How far inside its shoulder a hand at the box is, arm lengths."""
CARRY = STAND | {"dz": -0.03, "tilt": -2.0, "lean": -2.0}
CARRY |= hands((_INWARD, -0.52, 0.52), (_INWARD, -0.52, 0.52))


def _hands(take: Take, time: float, up: float, ahead: float) -> None:
    for side in "lr":
        take.hand(side, time, (_INWARD, up, ahead), (0.6, -0.6, -0.5))


def _event(take: Take, time: float, event: str) -> None:
    for side in "lr":
        take.event(time, event, f"{side}_wrist", "box")


def lift(take: Take) -> None:
    """Bend to a box on a table, take it with both hands, and draw it to the body."""
    start = take.begin()
    reached, raised = start + take.beat(0.75), start + take.beat(1.30)
    for time in (reached, reached + 0.15):
        take.pelvis(time, dh=-0.06, dz=-0.06)
        take.key(time, tilt=20.0, lean=16.0, nod=10.0)
        _hands(take, time, -0.58, 0.70)
    _event(take, reached, "catch")
    take.rest = CARRY
    take.pelvis(raised, dh=-0.03, dz=-0.04)
    take.key(raised, tilt=4.0, lean=2.0, nod=0.0)
    _hands(take, raised, -0.48, 0.56)
    end = raised + take.beat(0.45)
    take.relax(end)
    take.end("lift", end)


def set_down(take: Take) -> None:
    """Lower a box onto a table, and let it go."""
    start = take.begin()
    low, free = start + take.beat(0.75), start + take.beat(1.05)
    for time in (low, low + 0.12):
        take.pelvis(time, dh=-0.06, dz=-0.06)
        take.key(time, tilt=20.0, lean=16.0, nod=10.0)
        _hands(take, time, -0.58, 0.70)
    _event(take, low + 0.12, "release")
    take.rest = STAND
    for side in "lr":
        take.hand(side, free + 0.1, (0.06, -0.50, 0.44))
    end = free + take.beat(0.75)
    take.relax(end)
    take.end("set_down", end)


def carry(take: Take, steps: int = 5) -> None:
    """Walk with a box before the body, the arms still."""
    take.rest = CARRY
    gait = personal(take, replace(WALK, tilt=0.0, lean=-2.0))
    travel(take, gait, [0.85] * steps, 0.0, "carry", arms="")


def carry_still(take: Take, seconds: float = 2.0) -> None:
    """Stand with a box before the body."""
    start = take.begin()
    take.rest = CARRY
    end = start + seconds
    take.relax(start + take.beat(0.4))
    take.pelvis(0.5 * (start + end), dx=0.012, dz=-0.03)
    take.relax(end)
    take.end("hold_box", end)


def hand_over(take: Take) -> None:
    """Hold a box out to somebody, and let it go when they have it."""
    start = take.begin()
    out, gone = start + take.beat(0.60), start + take.beat(0.90)
    for time in (out, gone):
        take.pelvis(time, dh=-0.02, dz=0.02)
        take.key(time, tilt=5.0, lean=6.0, nod=2.0)
        _hands(take, time, -0.32, 0.88)
    _event(take, gone, "release")
    take.rest = STAND
    for side in "lr":
        take.hand(side, gone + 0.2, (0.04, -0.34, 0.66))
    end = gone + take.beat(0.85)
    take.relax(end)
    take.end("hand_over", end)


def receive(take: Take) -> None:
    """Reach out for a box that is held out, take it, and draw it to the body."""
    start = take.begin()
    out, taken = start + take.beat(0.60), start + take.beat(0.90)
    for time in (out, taken):
        take.pelvis(time, dh=-0.02, dz=0.02)
        take.key(time, tilt=5.0, lean=6.0, nod=2.0)
        _hands(take, time, -0.32, 0.86)
    _event(take, taken, "catch")
    take.rest = CARRY
    end = taken + take.beat(0.75)
    take.relax(end)
    take.end("receive", end)
