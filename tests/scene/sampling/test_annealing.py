"""The same seed on any threads, first scenes and warm starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motiondb.database.scenes import scene_texts
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.expressions import g_user
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.sampling.annealing import (
    WARM,
    SamplerSettings,
    bootstrap,
    common_actions,
    sample,
    warm_start,
)
from motiondb.scene.sampling.play import Prices, make_play
from motiondb.scene.sampling.scene_chain import Chain

SHORT = SamplerSettings(
    chains=3, temperature=0.5, rounds=4, jumps=3, inner=60, steps=60, cooling=400
)


def read(name: str):
    text = read_scene_text(name)
    return text.diagram, text.grammar


def library_for(grammar, wandering, **options):
    return wandering([terminal.name for terminal in grammar.terminals], **options)


def sampled(library, diagram, grammar, settings, rng, state=None, progress=None):
    play = make_play(diagram, grammar, library, settings.most_actions, settings.prices)
    return sample(play, settings, rng, state, progress)


def bytes_of(state: SceneState) -> list[object]:
    return [
        (p.tree, np.asarray(p.entries).tobytes(), np.array(p.origin).tobytes(), p.delay)
        for p in state.players
    ]


@pytest.mark.parametrize("name", ["pass-and-shoot", "screen"])
def test_the_same_seed_gives_the_same_bytes_on_any_threads(wandering, name: str) -> None:
    diagram, grammar = read(name)
    library = library_for(grammar, wandering)
    actual = [
        sampled(library, diagram, grammar, replace(SHORT, threads=n), np.random.default_rng(7))
        for n in (1, 2)
    ]
    assert bytes_of(actual[0][0]) == bytes_of(actual[1][0])
    np.testing.assert_array_equal(actual[0][1].best, actual[1][1].best)
    other = sampled(library, diagram, grammar, SHORT, np.random.default_rng(8))
    assert bytes_of(other[0]) != bytes_of(actual[0][0])


def test_what_comes_out_fits_and_is_the_best_of_the_trace(wandering) -> None:
    diagram, grammar = read("give-and-go")
    library = library_for(grammar, wandering)
    told: list[int] = []

    def progress(done: int, best: float) -> bool:
        told.append(done)
        return done == 3

    actual, trace = sampled(
        library, diagram, grammar, SHORT, np.random.default_rng(1), progress=progress
    )
    assert told == [1, 2, 3]
    assert trace.best.shape == (4,)
    assert (np.diff(trace.best) <= 0.0).all()
    assert trace.final <= trace.cooled <= trace.best[-1] < trace.best[0]
    play = make_play(diagram, grammar, library, prices=Prices(delay=SHORT.prices.delay))
    assert Chain(play, actual, np.random.default_rng(0)).energy == pytest.approx(trace.final)
    for player, items in zip(actual.players, play.binder.items, strict=True):
        actions = player.tree.leaves()
        assert g_user(actions, [item.actions for item in items]) == 0
        for action, entry in zip(actions, player.entries, strict=True):
            assert entry in library.of(action)


@pytest.mark.parametrize("name", list(scene_texts.shipped(".tactics")))
def test_the_first_scene_does_what_is_asked(wandering, name: str) -> None:
    diagram, grammar = read(name)
    play = make_play(diagram, grammar, library_for(grammar, wandering, each=2))
    state = bootstrap(play, np.random.default_rng(3))
    for player, items in zip(state.players, play.binder.items, strict=True):
        assert g_user(player.tree.leaves(), [item.actions for item in items]) == 0
        assert 0 < len(player.entries) == len(player.tree.leaves()) <= play.most_actions
    assert np.isfinite(Chain(play, state, np.random.default_rng(0)).energy)


def test_a_warm_start_keeps_who_does_the_same_and_moves_whom_the_diagram_moves(wandering) -> None:
    diagram, grammar = read("pass-and-shoot")
    library = library_for(grammar, wandering)
    rng = np.random.default_rng(5)
    state, _ = sampled(library, diagram, grammar, SHORT, rng)
    moved = list(diagram.players)
    at = moved[1].at
    moved[1] = replace(moved[1], at=Spot(at.x + 0.5, at.z - 0.25))
    shot = replace(diagram.elements[4], kind="layup")
    assert diagram.elements[4].kind == "shoot"
    changed = replace(
        diagram,
        players=tuple(moved),
        elements=(*diagram.elements[:4], shot, *diagram.elements[5:]),
    )
    play = make_play(changed, grammar, library)
    warm = warm_start(state, diagram, play, rng)
    for k in (0, 2, 3):  # A1, D1, D2
        assert bytes_of(SceneState((warm.players[k],))) == bytes_of(SceneState((state.players[k],)))
    actions, before = warm.players[1].tree.leaves(), state.players[1].tree.leaves()
    assert actions[-1] == "layup"
    assert before[-1] == "shoot"
    for k, m in common_actions(actions, before):
        assert warm.players[1].entries[k] == state.players[1].entries[m]
    again, trace = sampled(library, changed, grammar, WARM, np.random.default_rng(0), warm)
    assert trace.final <= trace.best[0]
    assert again.players[1].tree.leaves()[-1] == "layup"
