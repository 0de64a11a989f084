"""Where a string begins best, beside optimisation and by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scene_energy import energy

from motiondb.database.scenes import scene_texts
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.scene.clips import clip_cutting
from motiondb.scene.energy.binding import POSITION, SYNCHRONISATION, bind
from motiondb.scene.energy.energy import scene_arrays
from motiondb.scene.energy.placement import clip_arrays
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState, scene_state
from motiondb.scene.energy.start_placement import place_start
from motiondb.scene.language.semantic_rules import Weights
from motiondb.scene.services import casting


def scene_of(wandering, name: str, seed: int = 0):
    """A diagram's shortest strings with clips drawn at random, everybody at the origin."""
    text = read_scene_text(name)
    diagram, grammar = text.diagram, text.grammar
    trees = casting.cast(diagram, grammar)
    table = bind(diagram, grammar, trees)
    library = wandering([t.name for t in grammar.terminals], seed=seed)
    rng = np.random.default_rng(seed)
    players = []
    for player in table.players:
        tree = trees[player]
        entries = np.array([int(rng.choice(library.of(action))) for action in tree.leaves()])
        players.append(PlayerState(tree, entries, (0.0, 0.0, 0.0)))
    return SceneState(tuple(players)), library, table


def test_a_string_is_laid_upon_its_places(wandering) -> None:
    """From (2, 1) to (2, 5) at 4 m: the origin is there, and the way is +z."""
    state, library, table = scene_of(wandering, "carrying")
    rows = table.rows[table.rows["kind"] == POSITION][:2].copy()
    rows["first"], rows["last"], rows["moment"] = 0, 1, [0, 1]
    rows["x"], rows["z"] = 2.0, [1.0, 5.0]
    entry = int(state.players[0].entries[0])
    n, start = int(library.n_frames[entry]), int(library.path_start[entry])
    library.path[start : start + n] = 0.0
    library.path[start : start + n, 0] = np.linspace(0.0, 4.0, n)
    table = replace(table, rows=rows)
    scene = scene_arrays(state, clip_arrays(library), table, Weights())
    place_start(scene, clip_arrays(library))
    np.testing.assert_allclose(scene.cost, 0.0, atol=1e-9)
    np.testing.assert_allclose(scene.placed[0, 0, :3], [2.0, 1.0, -math.pi / 2], atol=1e-9)


def squares(scene) -> float:
    """The sum of w d^2 over the position rules, which the closed form makes least."""
    chosen = scene.rows["kind"] == POSITION
    values = scene.cost[chosen] * scene.rows["weight"][chosen]
    return float(np.sum(values**2 / scene.rows["weight"][chosen]))


def test_no_place_nearby_is_better(wandering) -> None:
    """A player under position rules alone: small motions all cost more."""
    for seed in range(4):
        state, library, table = scene_of(wandering, "carrying", seed)
        arrays = clip_arrays(library)
        rows = table.rows[table.rows["kind"] == POSITION].copy()
        rows["first"], rows["last"] = np.arange(len(rows)), np.arange(len(rows)) + 1
        rows["x"] += np.arange(len(rows))
        table = replace(table, rows=rows)
        scene = scene_arrays(state, arrays, table, Weights())
        place_start(scene, arrays)
        best, actual = squares(scene), scene_state(scene, state.trees)
        rng = np.random.default_rng(seed)
        for _ in range(50):
            moved = clip_cutting.compose(
                rng.normal(0.0, 0.02, 3), np.array(actual.players[0].origin)
            )
            player = replace(actual.players[0], origin=tuple(moved.tolist()))
            other = scene_arrays(SceneState((player,)), arrays, table, Weights())
            assert squares(other) >= best - 1e-9


def test_one_pass_is_caught_in_time(wandering) -> None:
    """With one link between two strings, delays fulfil it within a frame; nobody waits in vain."""
    for seed in range(4):
        state, library, table = scene_of(wandering, "pass-and-shoot", seed)
        arrays = clip_arrays(library)
        table = replace(table, rows=table.rows[table.rows["player"] == 0])
        scene = scene_arrays(state, arrays, table, Weights())
        place_start(scene, arrays)
        (number,) = np.flatnonzero(scene.rows["kind"] == SYNCHRONISATION)
        assert scene.cost[number] * 0.1 <= 1.0 / 30.0
        assert scene.begin[:, 0].min() == 0
        assert np.count_nonzero(scene.begin[:, 0]) <= 1


@pytest.mark.parametrize("name", scene_texts.shipped(".tactics"))
def test_a_start_costs_less_than_the_middle_of_the_court(wandering, name: str) -> None:
    state, library, table = scene_of(wandering, name, 1)
    arrays = clip_arrays(library)
    scene = scene_arrays(state, arrays, table, Weights())
    before = float(scene.cost.sum())
    total = place_start(scene, arrays)
    assert scene.cost.sum() < before
    assert total == pytest.approx(
        energy(scene_state(scene, state.trees), arrays, table, Weights(), 3).total
    )
