"""Which actions belong to which walk of a diagram: those with the least error."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.grammar.cfg.parse import parse
from motiondb.scene.clips.clips import ClipLibrary, ClipSource
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.sampling.play import make_play
from motiondb.scene.sampling.scene_chain import Chain, least_error

GRAMMAR = read_motion_grammar(
    """
    grammar greeting
    start S
    S -> Act | Act S
    Act -> walk | bow
    walk := "walk"
    bow := "bow"
    """,
    "greeting.grammar",
)
WALKS = """diagram "Two walks"
grammar greeting
court 20 x 20
player A at 0 0
1 walk A to 0 {0}
2 walk A to 0 {1}
"""
STRING = ("walk", "bow", "walk", "walk", "walk")


def metre_library() -> ClipLibrary:
    """A walk of a metre straight ahead in 30 frames, and a bow in place."""
    n_frames = np.array([30, 30], dtype=np.int32)
    ahead = np.zeros((30, 3))
    ahead[:, 1] = np.arange(30) / 30.0
    return ClipLibrary(
        terminals=("walk", "bow"),
        terminal=np.array([0, 1], dtype=np.int32),
        first=np.array([0, 1, 2], dtype=np.int32),
        n_frames=n_frames,
        step=np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]),
        event_frame=np.array([-1, -1], dtype=np.int32),
        path_start=np.array([0, 30], dtype=np.int32),
        path=np.concatenate([ahead, np.zeros((30, 3))]),
        seam=np.zeros((2, 2), dtype=np.float32),
        seam_class=np.array([0, 1], dtype=np.int32),
        hand=np.zeros((2, 3)),
        source=(ClipSource("walk", 0, 30), ClipSource("bow", 0, 30)),
    )


@pytest.mark.parametrize(
    ("ends", "spans"),
    [
        ((1, 4), ((0, 1), (2, 5))),  # the first walk is one metre
        ((2, 4), ((2, 3), (3, 5))),  # it ends where the second action in a row does
        ((3, 4), ((2, 4), (4, 5))),
    ],
)
def test_actions_are_assigned_where_the_walks_end(ends: tuple, spans: tuple) -> None:
    diagram = read_diagram(WALKS.format(*ends), "walks.tactics")
    play = make_play(diagram, GRAMMAR, metre_library())
    tree = parse(GRAMMAR.started(), list(STRING))
    entries = np.array([0 if action == "walk" else 1 for action in STRING])
    state = SceneState((PlayerState(tree, entries, (0.0, 0.0, 0.0)),))
    chain = Chain(play, state, np.random.default_rng(0))
    assert chain.spans == [spans]
    assert chain.state.players[0].spans == spans
    of_all = []
    for chosen in play.binder.assignments(0, STRING):
        table = play.binder.bind([tree], [chosen])
        of_all.append(play.energy(play.arrays(state, table), table))
    assert len(of_all) == 3
    assert chain.energy == min(of_all)
    assert not chain.assign(0)  # it is the best already


def test_an_assignment_that_was_chosen_stays_until_another_is_better() -> None:
    diagram = read_diagram(WALKS.format(1, 4), "walks.tactics")
    play = make_play(diagram, GRAMMAR, metre_library())
    tree = parse(GRAMMAR.started(), list(STRING))
    entries = np.array([0, 1, 0, 0, 0])
    worse = ((2, 4), (4, 5))
    state = SceneState((PlayerState(tree, entries, (0.0, 0.0, 0.0), 0, worse),))
    chain = Chain(play, state, np.random.default_rng(0))
    assert chain.spans == [worse]
    before = chain.energy
    assert chain.assign(0)
    assert chain.spans == [((0, 1), (2, 5))]
    assert chain.energy < before
    best = least_error(play, state, [tree], [worse], 0)
    assert best.spans == chain.spans
