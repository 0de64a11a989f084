"""Which captures there are: who performs what, in which order, under which name."""

from __future__ import annotations

from dataclasses import dataclass

from .carrying import CARRY
from .gestures import idle
from .grammars import Derivation, derive
from .performers import PERFORMERS
from .repertoire import ACTIONS, Move, coarse
from .score import HOLD, READY, SEATED, STAND, Posture, Take


@dataclass(frozen=True)
class Capture:
    """A capture to make.

    Attributes
    ----------
    performer, name : ``captures/<performer>/<name>.bvh``.
    moves : the actions, in order; empty where ``grammar`` gives them.
    rest : the posture it begins in: "stand", "hold" (a ball), "sit" or "ready".
    grammar, sentences : a grammar of :mod:`sample_data.grammars` and how many sentences of it.
    """

    performer: str
    name: str
    moves: tuple[Move, ...] = ()
    rest: str = "stand"
    grammar: str = ""
    sentences: int = 0

    @property
    def file(self) -> str:
        """The file's path below the folder of captures."""
        return f"{self.performer}/{self.name}.bvh"

    @property
    def is_long(self) -> bool:
        """Whether it strings many actions together."""
        return self.name.startswith("long_")

    @property
    def action(self) -> str:
        """The one action that it shows, or "sequence"."""
        kinds = {coarse(move) for move, _ in self.moves}
        return kinds.pop() if len(kinds) == 1 else "sequence"


_RESTS: dict[str, tuple[Posture, str]] = {
    "stand": (STAND, "idle"),
    "hold": (HOLD, "hold"),
    "ready": (READY, "ready"),
    "sit": (SEATED | {"dh": -0.424}, "sit"),
    "carry": (CARRY, "hold_box"),
}

_SINGLES: dict[str, list[tuple[str, dict[str, object]]]] = {
    # move -> (performers who do it, with these arguments)
    "walk": [("ana boris fatou goran", {"steps": 6}), ("chidi", {"steps": 8}),
             ("dora emil", {"steps": 5})],
    "run": [("ana fatou", {"steps": 8}), ("chidi goran", {"steps": 9})],
    "turn_left": [("ana dora", {}), ("boris", {"angle": 180.0})],
    "turn_right": [("boris dora", {}), ("chidi", {"angle": 180.0})],
    "curve_left": [("emil", {}), ("goran", {"steps": 7})],
    "curve_right": [("fatou", {})],
    "jump": [("ana emil", {}), ("chidi", {"forward": 0.7}), ("goran", {"height": 0.34})],
    "sit_down": [("ana boris dora emil", {})],
    "stand_up": [("ana boris emil fatou", {})],
    "wave": [("ana dora", {"side": "own"}), ("boris", {"side": "off"}),
             ("emil", {"side": "own", "times": 6})],
    "kick": [("boris", {"side": "own"}), ("chidi", {"side": "own", "way": "round"}),
             ("fatou", {"side": "off"}), ("goran", {"side": "own", "way": "low"})],
    "punch": [("boris", {"side": "own"}), ("chidi fatou", {"side": "own", "times": 2}),
              ("goran", {"side": "off"})],
    "bow": [("ana", {}), ("dora", {"depth": 40.0}), ("emil", {"depth": 65.0})],
    "pick_up": [("ana boris dora", {}), ("emil", {"height": 0.30})],
    "dribble": [("chidi", {"bounces": 6}), ("fatou", {"bounces": 5}), ("goran", {"steps": 6})],
    "pass": [("chidi", {}), ("goran", {"way": "overhead"})],
    "catch": [("fatou goran", {})],
    "shoot": [("chidi fatou goran", {})],
    "layup": [("chidi fatou", {})],
    "feint": [("chidi", {"side": "l"}), ("goran", {"side": "r"})],
    "fake_shot": [("fatou goran", {})],
    "pivot_left": [("chidi", {}), ("fatou", {"angle": 120.0})],
    "pivot_right": [("goran", {}), ("chidi", {"angle": 120.0})],
    "screen": [("boris goran", {})],
    "guard": [("boris", {}), ("fatou", {"slides": (-0.5, 0.5, -0.3)})],
    "block": [("chidi goran", {})],
    "push": [("boris goran", {})],
    "hold": [("fatou", {"seconds": 2.2}), ("goran", {"seconds": 2.6})],
    "idle": [("dora", {"seconds": 3.0}), ("boris", {"seconds": 2.6})],
}  # fmt: skip
_WITH_BALL = {
    "pass",
    "shoot",
    "layup",
    "feint",
    "fake_shot",
    "pivot_left",
    "pivot_right",
    "dribble",
}

_ACTIVITIES: dict[str, list[tuple[str, dict[str, object]]]] = {
    # a collection of its own: what the shipped activities need beside the others
    "sit": [("ana boris", {"seconds": 3.0})],
    "stance": [("boris chidi", {"seconds": 3.0}), ("goran", {"seconds": 2.6})],
    "parry": [("boris", {"side": "own"}), ("chidi", {"side": "off"}), ("goran", {"side": "own"})],
    "duck": [("boris chidi goran", {})],
    "lift": [("ana boris dora", {})],
    "carry": [("ana", {"steps": 5}), ("boris", {"steps": 6}), ("dora emil", {"steps": 5})],
    "hold_box": [("ana boris", {"seconds": 2.6})],
    "hand_over": [("ana boris emil", {})],
    "receive": [("ana boris dora", {})],
    "set_down": [("boris dora emil", {})],
}  # fmt: skip
_BEGINS = {
    "sit": "sit", "stance": "ready", "parry": "ready", "duck": "ready",
    "carry": "carry", "hold_box": "carry", "hand_over": "carry", "set_down": "carry",
}  # fmt: skip

_DANCES = {
    "ana": "left right twirl",
    "dora": "sway clap right left",
    "fatou": "right left clap dip",
    "emil": "sway left right",
}

_LONG: dict[str, tuple[str, str, str]] = {
    # name -> (performer, rest, moves; a number after a colon is the steps of a walk or run)
    "long_1": ("ana", "stand",
               "walk:6 turn_left sit_down stand_up wave idle walk:5 jump bow"),
    "long_2": ("boris", "stand",
               "idle walk:5 turn_right pick_up walk:6 turn_left kick idle punch wave"),
    "long_3": ("chidi", "stand",
               "run:8 jump turn_right walk:5 kick punch turn_left run:7 idle bow"),
    "long_4": ("dora", "stand",
               "wave walk:5 sit_down stand_up turn_right walk:6 pick_up bow idle"),
    "long_5": ("emil", "stand",
               "walk:4 bow sit_down idle stand_up wave turn_left walk:5 pick_up"),
    "long_6": ("fatou", "stand",
               "run:7 turn_left kick walk:6 turn_right jump run:8 wave idle sit_down stand_up"),
    "long_7": ("goran", "stand",
               "guard walk:5 catch pivot_left dribble shoot run:6 block idle screen walk:5"),
    "long_8": ("chidi", "hold",
               "hold feint dribble layup run:6 catch pivot_right fake_shot pass walk:5 catch "
               "shoot guard"),
}  # fmt: skip
_GRAMMAR_TAKES = (
    ("dora", "long_dance_1", "dance", 2), ("ana", "long_dance_2", "dance", 2),
    ("boris", "long_fight_1", "fight", 3), ("goran", "long_fight_2", "fight", 4),
    ("chidi", "long_play_1", "play", 4), ("fatou", "long_play_2", "play", 3),
)  # fmt: skip


def activities() -> list[Capture]:
    """Every capture of the second collection, in the order of their files."""
    made = []
    for move, lines in _ACTIVITIES.items():
        for people, arguments in lines:
            for person in people.split():
                rest = _BEGINS.get(move, "stand")
                made.append(Capture(person, f"{move}_1", ((move, arguments),), rest))
    return sorted(made, key=lambda capture: capture.file)


def captures() -> list[Capture]:
    """Every capture of the collection, in the order of their files."""
    made = []
    for move, lines in _SINGLES.items():
        counts: dict[str, int] = {}
        for people, arguments in lines:
            for person in people.split():
                counts[person] = counts.get(person, 0) + 1
                rest = "hold" if move in _WITH_BALL else "sit" if move == "stand_up" else "stand"
                name = f"{move}_{counts[person]}"
                made.append(Capture(person, name, ((move, arguments),), rest))
    for person, steps in _DANCES.items():
        moves: tuple[Move, ...] = tuple((f"dance_{step}", {}) for step in steps.split())
        made.append(Capture(person, "dance_1", moves))
    for name, (person, rest, text) in _LONG.items():
        made.append(Capture(person, name, tuple(_move(word) for word in text.split()), rest))
    for person, name, grammar, sentences in _GRAMMAR_TAKES:
        made.append(Capture(person, name, grammar=grammar, sentences=sentences))
    return sorted(made, key=lambda capture: capture.file)


def _move(word: str) -> Move:
    name, _, steps = word.partition(":")
    return name, {"steps": int(steps)} if steps else {}


def perform(capture: Capture, seed: int) -> tuple[Take, list[Derivation]]:
    """Play a capture; also returns the derivations of its sentences, where it has a grammar."""
    rest, label = _RESTS[capture.rest]
    take = Take(PERFORMERS[capture.performer], capture.name, seed, rest)
    derivations: list[Derivation] = []
    moves: list[Move] = list(capture.moves)
    for _ in range(capture.sentences):
        derivation = derive(capture.grammar, take.random)
        derivations.append(derivation)
        moves += derivation.moves()
    idle(take, take.random.uniform(0.3, 0.6), label)
    for name, arguments in moves:
        ACTIONS[name](take, **arguments)
    _ease_out(take)
    take.segments = _merged(take.segments)
    return take, derivations


def _ease_out(take: Take) -> None:
    """A moment of rest at the end, under the label of the posture that the take ends in."""
    for posture, label in _RESTS.values():
        if take.rest is posture:
            idle(take, take.random.uniform(0.25, 0.5), label)
            return
    idle(take, take.random.uniform(0.25, 0.5), "sit")


def _merged(segments: list[tuple[str, float, float]]) -> list[tuple[str, float, float]]:
    """Neighbouring stretches of rest become one; repeated actions stay apart."""
    merged: list[tuple[str, float, float]] = []
    for label, start, end in segments:
        if merged and merged[-1][0] == label and label in ("idle", "hold", "sit", "ready"):
            merged[-1] = (label, merged[-1][1], end)
        else:
            merged.append((label, start, end))
    return merged
