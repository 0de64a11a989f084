"""Strings of clips on the ground beside composition, place by place."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_energy import energy

from motiondb.database.scenes import scene_texts
from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.scene.clips import clip_cutting
from motiondb.scene.energy.binding import POSITION, bind
from motiondb.scene.energy.energy import scene_arrays
from motiondb.scene.energy.placement import (
    chain,
    clip_arrays,
    clip_at,
    place_in_clip,
    put_origin,
)
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState, scene_state
from motiondb.scene.energy.start_placement import place_start
from motiondb.scene.language.semantic_rules import Weights
from motiondb.scene.services import casting

QUARTER = math.pi / 2


def placed_string(library, entries, origin, delay):
    arrays = clip_arrays(library)
    placed, begin = np.zeros((len(entries) + 1, 5)), np.zeros(len(entries) + 1, np.int64)
    put_origin(placed, *origin)
    begin[0] = delay
    chain(placed, begin, np.asarray(entries, dtype=np.int64), arrays.clips, 0, len(entries))
    return placed, begin, arrays


def test_two_clips_by_hand(wandering) -> None:
    """From (1, 0) facing +x: 2 m ahead and a quarter turn on, then 3 m ahead: at (3, -3)."""
    library = wandering(["walk"], each=2)
    library.step[:] = [[0.0, 2.0, QUARTER], [0.0, 3.0, 0.0]]
    placed, begin, _ = placed_string(library, [0, 1], (1.0, 0.0, QUARTER), 5)
    np.testing.assert_allclose(placed[1, :3], [3.0, 0.0, math.pi], atol=1e-12)
    np.testing.assert_allclose(placed[2, :3], [3.0, -3.0, math.pi], atol=1e-12)
    assert begin.tolist() == [5, 5 + library.n_frames[0], 5 + library.n_frames.sum()]


seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(1, 9))
def test_products_are_compositions_and_a_swap_moves_the_tail_as_one(wandering, seed, n) -> None:
    rng = np.random.default_rng(seed)
    library = wandering(["walk", "run"])
    entries, origin = rng.integers(0, 12, n), rng.normal(0.0, 3.0, 3)
    placed, begin, arrays = placed_string(library, entries, origin, 4)
    place = origin
    for k, entry in enumerate(entries):
        np.testing.assert_allclose(placed[k, :3], place, atol=1e-12)
        frame = int(rng.integers(library.n_frames[entry]))
        row = int(library.path_start[entry]) + frame
        actual = place_in_clip(placed, arrays.path, row, k)
        np.testing.assert_allclose(
            actual, clip_cutting.compose(place, library.path[row]), atol=1e-12
        )
        assert clip_at(begin, n, int(begin[k]) + frame) == k
        place = clip_cutting.compose(place, library.step[entry])
    np.testing.assert_allclose(placed[:, 3], np.cos(placed[:, 2]), atol=1e-12)
    np.testing.assert_allclose(placed[:, 4], np.sin(placed[:, 2]), atol=1e-12)

    k = int(rng.integers(n))
    swapped = entries.copy()
    swapped[k] = rng.integers(0, 12)
    after, later, _ = placed_string(library, swapped, origin, 4)
    motion = clip_cutting.compose(after[k + 1, :3], clip_cutting.inverse(placed[k + 1, :3]))
    tail = clip_cutting.compose(motion, placed[k + 1 :, :3])
    np.testing.assert_allclose(after[k + 1 :, :3], tail, atol=1e-11)
    np.testing.assert_array_equal(after[: k + 1], placed[: k + 1])
    assert len(set((later - begin)[k + 1 :].tolist())) == 1


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
