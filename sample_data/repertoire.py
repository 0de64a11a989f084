"""What can be performed: the name of an action, and the function that plays it on a take."""

from __future__ import annotations

from collections.abc import Callable

from sample_data import (
    basketball,
    carrying,
    dancing,
    defence,
    fighting,
    footwork,
    gestures,
    locomotion,
)

from .score import Take

Move = tuple[str, dict[str, object]]
"""An action's name in :data:`ACTIONS` and the arguments for it."""


def _side(take: Take, side: object = None) -> str:
    """A named side ("own", "off" of the acting hand, "l", "r"), or one drawn: mostly the own."""
    hand = take.person.hand
    if side in ("l", "r"):
        return str(side)
    if side == "off" or (side is None and take.random.uniform() < 0.3):
        return locomotion.other_side(hand)
    return hand


def _wave(take: Take, side: object = None, times: int = 4) -> None:
    gestures.wave(take, _side(take, side), times)


def _pick_up(take: Take, side: object = "own", height: float = 0.12) -> None:
    gestures.pick_up(take, _side(take, side), height)


def _kick(take: Take, side: object = None, way: str = "front") -> None:
    fighting.kick(take, _side(take, side), way)


def _punch(take: Take, side: object = None, times: int = 1) -> None:
    for _ in range(times):
        fighting.punch(take, _side(take, side), take.random.uniform(-0.1, 0.2))


def _parry(take: Take, side: object = None) -> None:
    fighting.parry(take, _side(take, side))


def _feint(take: Take, side: object = None) -> None:
    basketball.feint(take, _side(take, side))


ACTIONS: dict[str, Callable[..., None]] = {
    "idle": gestures.idle,
    "walk": locomotion.walk,
    "run": locomotion.run,
    "turn_left": lambda take, angle=90.0: footwork.turn(take, angle),
    "turn_right": lambda take, angle=90.0: footwork.turn(take, -angle),
    "curve_left": lambda take, steps=6, angle=100.0: locomotion.walk(
        take, steps, angle, "turn_left"
    ),
    "curve_right": lambda take, steps=6, angle=100.0: locomotion.walk(
        take, steps, -angle, "turn_right"
    ),
    "jump": gestures.jump,
    "sit_down": gestures.sit_down,
    "stand_up": gestures.stand_up,
    "wave": _wave,
    "bow": gestures.bow,
    "pick_up": _pick_up,
    "kick": _kick,
    "punch": _punch,
    "ready": fighting.ready,
    "lower": fighting.lower_fists,
    "parry": _parry,
    "duck": fighting.duck,
    "push": fighting.push,
    "dance_left": lambda take: dancing.side_step(take, "l"),
    "dance_right": lambda take: dancing.side_step(take, "r"),
    "dance_twirl": lambda take: dancing.twirl(take, _side(take)),
    "dance_clap": dancing.clap,
    "dance_sway": dancing.sway,
    "dance_dip": dancing.dip,
    "hold": basketball.hold,
    "catch": basketball.catch,
    "pass": basketball.throw,
    "dribble": basketball.dribble,
    "shoot": basketball.shoot,
    "layup": basketball.layup,
    "feint": _feint,
    "fake_shot": basketball.fake_shot,
    "pivot_left": lambda take, angle=90.0: footwork.pivot(take, angle),
    "pivot_right": lambda take, angle=90.0: footwork.pivot(take, -angle),
    "block": defence.block,
    "screen": defence.screen,
    "guard": defence.guard,
    "lift": carrying.lift,
    "carry": carrying.carry,
    "hold_box": carrying.carry_still,
    "hand_over": carrying.hand_over,
    "receive": carrying.receive,
    "set_down": carrying.set_down,
    "sit": lambda take, seconds=2.0: gestures.idle(take, seconds, "sit"),
    "stance": lambda take, seconds=2.0: gestures.idle(take, seconds, "ready"),
}
"""Every action by name; all take the take first."""

_COARSE = {
    "curve_left": "turn_left",
    "curve_right": "turn_right",
    "lower": "idle",
    "sit": "sit_down",
}


def coarse(name: str) -> str:
    """The action that a move or a label belongs to.

    >>> coarse("dance_twirl"), coarse("curve_left"), coarse("kick")
    ('dance', 'turn_left', 'kick')
    """
    return "dance" if name.startswith("dance_") else _COARSE.get(name, name)
