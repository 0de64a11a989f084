"""Grammars of a dance and of a cup, and what is said of diagrams."""

from __future__ import annotations

import pytest

from motiondb.errors import SceneError
from motiondb.scene.language.expressions import expressions
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.services.casting import cast

DANCE = read_motion_grammar(
    """
    grammar dance
    start S_L for leader
    start S_F for follower
    role leader, follower of leader
    ground hall 10 x 8 from -2 -1
    mark arc 0 0 1 0 180
    S_L -> step | turn | bow | step S_L | turn S_L | bow S_L
    S_F -> step | bow | step S_F | bow S_F
    step := "step"
    turn := "turn"
    bow := "bow" event lowest(head)
    verb travel = step | turn to X Z
    step in S_F: distance(leader, <= 2 m)
    bow: direction(partner, 180 deg) at start, synchronisation(partner, bow, 0 s)
    """,
    "dance",
)
PAIR = "leader Lea at 0 0\nfollower Finn at 1 0\n"

CUP = read_motion_grammar(
    """
    start S
    object cup size 8 cm at table
    place table height 70 cm size 60 cm
    place goal at 0 4 height 1 m size 3 x 2 m
    S -> flick | flick S | take | walk | drink | give_it | toss | bear | put_it
    S -> take S | walk S | drink S | give_it S | toss S | bear S | put_it S
    take := "take"
    walk := "walk"
    bear := "bear"
    drink := "drink"
    flick := "flick" event contact
    give_it := "give" event release
    toss := "toss" event release
    put_it := "put" event release
    take: take(cup)
    bear, drink: keep(cup)
    give_it: give(cup)
    toss: send(cup, goal)
    put_it: put(cup)
    flick: strike(cup, goal)
    verb go = walk to X Z
    verb go = bear to X Z with cup
    rest walk
    """,
    "cup",
)
TABLE = "place table at 2 0\nplayer Ana at 0 0\nplayer Bo at 3 3\n"


def texts(grammar: MotionGrammar, text: str) -> dict[str, str]:
    diagram = read_diagram(text, "x", grammar.activity)
    return {name: "".join(map(str, items)) for name, items in expressions(diagram).items()}


def refusal(grammar: MotionGrammar, text: str) -> str:
    with pytest.raises(SceneError) as caught:
        cast(read_diagram(text, "x", grammar.activity), grammar, "x")
    return str(caught.value)
