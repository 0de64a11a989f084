"""Single steps of chains over scenes: what stays where it was, ways back, worked ratios."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from motiondb.grammar.cfg.parse import parse
from motiondb.scene.clips.clips import ClipLibrary, ClipSource
from motiondb.scene.energy.binding import bind
from motiondb.scene.energy.energy import change, scene_arrays, token_errors, undo
from motiondb.scene.energy.placement import clip_arrays
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.sampling.clip_choice import clip_groups, smooth_entry
from motiondb.scene.sampling.metropolis import origin_for_tail
from motiondb.scene.sampling.play import make_play
from motiondb.scene.sampling.scene_chain import Chain, Structure, least_error

from .test_sampling import ALONE, EXCHANGES, TOY, toy_play, toy_state


def test_what_stands_behind_stays_and_the_way_back_is_the_same(wandering) -> None:
    _, play = toy_play(wandering)
    state = toy_state(play, (0, 1, 4, 2), (0, 6, 2))
    table = bind(ALONE, TOY, state.trees)
    scene = scene_arrays(state, play.library, table, TOY.weights)
    before, total = scene.placed.copy(), scene.total.copy()
    seams = scene.seams.copy()
    origin = origin_for_tail(scene, play.library, 0, 1, 7)
    change(scene, play.library, 0, 1, 7, (*origin, 5))
    turns = np.array([1.0, 1.0, 2 * np.pi])
    gap = scene.placed[0, 2:4, :3] - before[0, 2:4, :3]
    np.testing.assert_allclose(gap - turns * np.round(gap / turns) * [0, 0, 1], 0.0, atol=1e-9)
    back = origin_for_tail(scene, play.library, 0, 1, 6)
    np.testing.assert_allclose(back, before[0, 0, :3], atol=1e-9)
    undo(scene)
    np.testing.assert_array_equal(scene.placed, before)
    np.testing.assert_array_equal(scene.total, total)
    np.testing.assert_array_equal(scene.seams, seams)
    assert scene.entry[0].tolist() == [0, 6, 2]
    assert scene.begin[0, 0] == 0


def test_jumps_that_let_stand_what_stands_behind_keep_it(wandering) -> None:
    _, play = toy_play(wandering, tails=1.0)
    rng = np.random.default_rng(0)
    state = toy_state(play, (0, 1, 4, 2), (0, 6, 2))
    state = SceneState((PlayerState(state.trees[0], state.players[0].entries, (0, 0, 0), 300),))
    groups = clip_groups(play.library, 1.0, 1e9)
    moved = 0
    for _ in range(20):
        chain = Chain(play, state, rng)
        end, begin = chain.scene.placed[0, 3, :3].copy(), chain.scene.begin[0, 3]
        if chain.move(chain.jump, 0, groups, 1e9, EXCHANGES, 0.0):
            n = chain.scene.n_clips[0]
            np.testing.assert_allclose(chain.scene.placed[0, n, :3], end, atol=1e-9)
            assert chain.scene.begin[0, n] == begin
            moved += 1
    assert moved > 5


def test_a_clip_by_its_seams_has_the_ratio_of_its_seams(wandering) -> None:
    library = wandering(["a", "b"], each=6, seed=2)
    arrays = clip_arrays(library)
    groups = clip_groups(arrays, 0.5, 2.0)
    before, after = int(library.seam_class[7]), int(library.seam_class[9])
    new, ratio = smooth_entry(groups, 3, before, after, 0.4)

    def cost(k: int) -> float:
        seam_class = library.seam_class[k]
        return float(library.seam[before, seam_class] + library.seam[seam_class, after])

    assert ratio == pytest.approx((cost(new) - cost(3)) / (0.5 * 2.0), rel=1e-5)
    # every entry of the terminal in proportion to exp(-seams / (w T))
    grid = (np.arange(20_000) + 0.5) / 20_000
    seen = Counter(smooth_entry(groups, 3, before, after, u)[0] for u in grid)
    wanted = np.exp([-cost(k) for k in range(6)])
    got = np.array([seen[k] for k in range(6)]) / 20_000
    np.testing.assert_allclose(got, wanted / wanted.sum(), atol=2e-3)


def test_worked_ratio_of_a_jump(wandering) -> None:
    """Nodes S(A(a) B(c)): E of A and B are square roots of their leaves', of S a cube root."""
    _, play = toy_play(wandering)
    chain = Chain(play, toy_state(play, (0, 1, 3), (0, 4)), np.random.default_rng(0))
    errors = np.zeros(chain.scene.entry.shape)
    token_errors(chain.scene, play.library, errors)
    (actual,) = chain._subtree_errors(chain.scene, chain.shapes)
    a, c = errors[0]
    wanted = [(math.sqrt(a) * math.sqrt(c)) ** (1 / 3), math.sqrt(a), math.sqrt(c)]
    np.testing.assert_allclose(actual, wanted, rtol=1e-12)
    derivations = play.derivations[0]
    old, new = derivations.log_probability([3]), derivations.log_probability([4, 2])
    assert old - new == pytest.approx(math.log(0.6 / (0.4 * 0.3)))


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
    assert [one.spans for one in chain.strings] == [spans]
    assert chain.state.players[0].spans == spans
    of_all = []
    for chosen in play.binder.assignments(0, STRING):
        table = play.binder.bind([play.binder.string(0, tree, chosen)])
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
    assert [one.spans for one in chain.strings] == [worse]
    before = chain.energy
    assert chain.assign(0)
    assert [one.spans for one in chain.strings] == [((0, 1), (2, 5))]
    assert chain.energy < before
    known = Structure(chain.scene, chain.table, [play.binder.string(0, tree, worse)])
    best = least_error(play, state, known, 0, tree)
    assert [one.spans for one in best.strings] == [one.spans for one in chain.strings]
