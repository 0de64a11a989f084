"""Words for captures, as people write them: sentences, keywords, lists, and now and then a typo."""

from __future__ import annotations

import numpy as np

PHRASES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    # label -> (what a person does, keywords)
    "idle": (("stands still", "stands and waits", "waits"), ("stand", "idle", "standing")),
    "walk": (("walks forward", "walks", "takes a few steps", "walks straight ahead"),
             ("walk", "walking", "walk forward")),
    "run": (("runs forward", "runs", "jogs ahead", "is running"), ("run", "running", "jog")),
    "turn_left": (("turns left", "turns to the left", "makes a left turn"),
                  ("turn left", "left turn")),
    "turn_right": (("turns right", "turns to the right", "makes a right turn"),
                   ("turn right", "right turn")),
    "jump": (("jumps", "jumps up", "jumps with both feet", "makes a jump"), ("jump", "jumping")),
    "sit_down": (("sits down", "sits down on a chair", "takes a seat"), ("sit down", "sit")),
    "sit": (("stays seated", "remains seated and stays"), ("stay seated",)),
    "stand_up": (("stands up", "gets up from the chair", "rises from a chair"),
                 ("stand up", "get up")),
    "wave": (("waves", "waves a hand", "waves hello", "is waving"),
             ("wave", "waving", "wave hello")),
    "bow": (("bows", "bows politely", "takes a bow"), ("bow", "bowing")),
    "pick_up": (("picks something up from the floor", "picks up an object", "bends down and picks "
                 "something up"), ("pick up", "pick up object")),
    "kick": (("kicks", "kicks forward", "does a kick", "kicks something"), ("kick", "kicking")),
    "punch": (("punches", "throws a punch", "punches straight ahead"),
              ("punch", "punching", "boxing")),
    "ready": (("raises the fists", "gets into a fighting stance"), ("fighting stance",)),
    "parry": (("parries a blow", "parries"), ("parry",)),
    "duck": (("ducks", "ducks under a blow"), ("duck",)),
    "push": (("pushes with both hands", "pushes someone away"), ("push", "pushing")),
    "dance_left": (("dances a step to the left", "steps to the left"), ("side step left",)),
    "dance_right": (("dances a step to the right", "steps to the right"), ("side step right",)),
    "dance_twirl": (("twirls", "twirls around", "does a full turn"), ("twirl", "spin")),
    "dance_clap": (("claps", "claps twice"), ("clap", "clapping")),
    "dance_sway": (("sways with raised arms", "sways the hips"), ("sway", "swaying")),
    "dance_dip": (("sinks into a curtsy", "dips"), ("curtsy", "dip")),
    "dance": (("dances", "is dancing", "dances a few steps"), ("dance", "dancing", "dance steps")),
    "hold": (("holds the ball", "holds the basketball"), ("hold ball",)),
    "catch": (("catches the ball", "catches a basketball"), ("catch", "catch ball")),
    "pass": (("passes the ball", "throws a pass"), ("pass", "pass ball")),
    "dribble": (("dribbles the ball", "dribbles", "dribbles the basketball"),
                ("dribble", "basketball dribble")),
    "shoot": (("shoots the ball", "shoots a basket", "takes a jump shot"), ("shoot", "jump shot")),
    "layup": (("does a layup", "lays the ball up", "goes for a layup"), ("layup", "lay up")),
    "feint": (("feints", "makes a feint to the side"), ("feint",)),
    "fake_shot": (("fakes a shot", "pretends to shoot"), ("fake shot", "shot fake")),
    "pivot_left": (("pivots left", "pivots to the left with the ball"), ("pivot left",)),
    "pivot_right": (("pivots right", "pivots to the right with the ball"), ("pivot right",)),
    "screen": (("sets a screen", "stands in the way as a screen"), ("screen", "set screen")),
    "guard": (("guards the opponent", "defends with arms wide"), ("guard", "defend")),
    "block": (("blocks a shot", "jumps to block the ball"), ("block", "block shot")),
    "lift": (("lifts a box from a table", "lifts a box"), ("lift box",)),
    "carry": (("carries a box", "walks with a box"), ("carry box",)),
    "hold_box": (("stands with a box",), ("hold box",)),
    "hand_over": (("hands a box over", "hands over a box to someone"), ("hand over box",)),
    "receive": (("receives a box", "receives a box from someone"), ("receive box",)),
    "set_down": (("sets a box down", "sets down a box on a table"), ("set down box",)),
}  # fmt: skip
"""The words of every label."""

_PEOPLE = ("a person", "someone", "a man", "a woman", "the subject", "Person")
_WOMEN = ("ana", "dora", "fatou")
_MANNERS = {"emil": "slowly", "dora": "gently", "chidi": "quickly"}
_JOINS = (" then ", ", then ", " and ", ", ", " and then ")


def short_captions(performer: str, labels: list[str], random: np.random.RandomState) -> list[str]:
    """Two captions of a short capture: a sentence and keywords; ``labels`` in order, no rests."""
    manner = _MANNERS.get(performer, "")
    doing = _joined([_phrase(label, random) for label in labels], random)
    if manner and random.uniform() < 0.4:
        doing += f" {manner}"
    return [
        _mistyped(f"{_who(performer, random)} {doing}", random),
        _mistyped(", ".join(_keyword(label, random) for label in labels), random),
    ]


def long_captions(performer: str, labels: list[str], random: np.random.RandomState) -> list[str]:
    """Two captions of a long capture: the actions as a list of keywords, and as sentences."""
    if len(labels) > 12:  # nobody lists so many: each kind once
        labels = list(dict.fromkeys(labels))
    listed = ", ".join(_keyword(label, random) for label in labels)
    sentences = []
    for first in range(0, len(labels), 4):
        who = _who(performer, random) if first == 0 else "then " + _pronoun(performer)
        some = [_phrase(label, random) for label in labels[first : first + 4]]
        sentences.append(f"{who} {_joined(some, random)}")
    return [_mistyped(listed, random), _mistyped(". ".join(sentences) + ".", random)]


def timed_caption(performer: str, label: str, random: np.random.RandomState) -> str:
    """A caption of one action within a long capture."""
    if random.uniform() < 0.5:
        return _mistyped(_keyword(label, random), random)
    return _mistyped(f"{_who(performer, random)} {_phrase(label, random)}", random)


def _phrase(label: str, random: np.random.RandomState) -> str:
    choices = PHRASES[label][0]
    return choices[random.randint(len(choices))]


def _keyword(label: str, random: np.random.RandomState) -> str:
    choices = PHRASES[label][1]
    return choices[random.randint(len(choices))]


def _who(performer: str, random: np.random.RandomState) -> str:
    other = "a man" if performer in _WOMEN else "a woman"
    choices = [who for who in _PEOPLE if who != other]
    return choices[random.randint(len(choices))]


def _pronoun(performer: str) -> str:
    return "she" if performer in _WOMEN else "he"


def _joined(parts: list[str], random: np.random.RandomState) -> str:
    text = parts[0]
    for part in parts[1:]:
        text += _JOINS[random.randint(len(_JOINS))] + part
    return text


def _mistyped(words: str, random: np.random.RandomState) -> str:
    """Now and then two letters of a word change places."""
    if random.uniform() > 0.025 or len(words) < 6:
        return words
    at = 1 + random.randint(len(words) - 3)
    if not words[at : at + 2].isalpha():
        return words
    return words[:at] + words[at + 1] + words[at] + words[at + 2 :]
