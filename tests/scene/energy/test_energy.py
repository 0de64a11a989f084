"""A scene's energy: by hand, beside a slow twin in NumPy, and incremental beside from nothing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import naive_values
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_energy import energy

from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.scene.clips import clip_cutting
from motiondb.scene.energy import energy as energies
from motiondb.scene.energy.binding import (
    AT_END,
    AT_START,
    DIRECTION,
    DISTANCE,
    HEADING,
    LINE,
    ON_THE_WAY,
    ORDER,
    POSITION,
    SYNCHRONISATION,
    THROUGHOUT,
    UNMET,
    bind,
)
from motiondb.scene.energy.placement import clip_arrays
from motiondb.scene.energy.rule_kernels import EARLIER
from motiondb.scene.energy.scene_arrays import MOST_DELAY, PlayerState, SceneState, scene_state
from motiondb.scene.language.semantic_rules import Weights
from motiondb.scene.services import casting, services

WEIGHTS = Weights(smooth=0.7, collision=0.1, effort=5.0)

LONG = {
    "give-and-go": {
        "A1": "hold pass run run walk run catch layup",
        "A2": "run run catch pivot_left dribble pass run walk",
        "A3": "run run run idle walk screen run run",
        "D1": "guard guard run guard block run guard guard",
        "D3": "run walk run run guard guard guard run",
    },
    "figure-3": {
        "A2": "walk run run catch dribble dribble shoot",
        "A3": "run walk run screen idle walk",
        "D2": "guard run guard push run guard",
    },
}


@lru_cache
def cast(name: str):
    """A shipped diagram's table and trees, with longer strings than cast() finds."""
    text = read_scene_text(name)
    diagram, grammar = text.diagram, text.grammar
    trees = casting.cast(diagram, grammar)
    for player, string in LONG.get(name, {}).items():
        start = grammar.start_of(diagram.player[player].team)
        validation = services.validate(grammar, string.split(), start)
        assert validation.allowed, validation.message
        trees[player] = validation.tree
    table = bind(diagram, grammar, trees).weighed
    return diagram, grammar, table, [trees[name] for name in table.players]


def random_scene(wandering, name: str, rng: np.random.Generator, spread: float = 1.0):
    diagram, grammar, table, trees = cast(name)
    library = wandering([t.name for t in grammar.terminals], seed=int(rng.integers(5)))
    players = []
    for player, tree in zip(diagram.players, trees, strict=True):
        entries = [int(rng.choice(library.of(action))) for action in tree.leaves()]
        x, z = spread * player.at.x, spread * player.at.z
        origin = (x, z, float(rng.normal(0.0, 3.0)))
        players.append(PlayerState(tree, np.array(entries), origin, int(rng.integers(0, 40))))
    return SceneState(tuple(players)), library, table


class Twin:
    """The same energy, frame by frame, with the functions of naive_values.py."""

    def __init__(self, state, library, table, weights, every: int) -> None:
        self.library, self.table, self.every = library, table, every
        self.begins, self.tracks, self.states = [], [], state.players
        for player in state.players:
            place, frames, begin = np.array(player.origin), [], [player.delay]
            for entry in player.entries:
                frames.append(clip_cutting.compose(place, library.path_of(entry)))
                begin.append(begin[-1] + int(library.n_frames[entry]))
                place = clip_cutting.compose(place, library.step[entry])
            self.tracks.append(np.concatenate(frames))
            self.begins.append(begin)
        self.rules = [self.value(row) / row["weight"] for row in table.rows]
        seams = [
            library.seam[library.seam_class[a], library.seam_class[b]]
            for player in state.players
            for a, b in zip(player.entries[:-1], player.entries[1:], strict=True)
        ]
        self.smooth = float(sum(map(float, seams))) / weights.smooth
        self.collision = float(self.touching()) / weights.collision
        ways = [self.way(int(entry))[-1] for player in state.players for entry in player.entries]
        self.effort = sum(ways) / weights.effort
        self.total = sum(self.rules) + self.smooth + self.collision + self.effort

    def at(self, player: int, frame: int) -> np.ndarray:
        track = self.tracks[player]
        return track[min(max(frame - self.begins[player][0], 0), len(track) - 1)]

    def instant(self, player: int, k: int) -> int:
        entry = self.states[player].entries[k]
        event = int(self.library.event_frame[entry])
        middle = (int(self.library.n_frames[entry]) - 1) // 2
        return self.begins[player][k] + (event if event >= 0 else middle)

    def way(self, entry: int) -> np.ndarray:
        ends = np.vstack([self.library.path_of(entry)[:, :2], self.library.step[entry, :2]])
        metres = np.linalg.norm(np.diff(ends, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(metres)])

    def moments(self, row) -> list[int]:
        player, begin = row["player"], self.begins[row["player"]]
        first, last = begin[row["first"]], begin[row["last"]]
        if row["moment"] == AT_START:
            return [first]
        if row["moment"] == AT_END:
            return [last - 1]
        if row["moment"] == THROUGHOUT:
            return [frame for frame in range(first, last) if frame % self.every == 0]
        if row["moment"] == ON_THE_WAY:
            metres = [0.0]
            for k in range(row["first"], row["last"]):
                way = self.way(int(self.states[player].entries[k]))
                metres = [*metres[:-1], *(metres[-1] + way)]
            wanted = row["fraction"] * metres[-1]
            late = (i for i, m in enumerate(metres[:-1]) if m >= wanted - 1e-12)
            return [first + next(late, len(metres) - 2)]
        return [self.instant(player, row["first"])]

    def spot(self, target: int, x: float, z: float, frame: int) -> np.ndarray:
        return self.at(target, frame)[:2] if target >= 0 else np.array([x, z])

    def value(self, row) -> float:
        if row["kind"] == UNMET:
            return 1.0
        if row["kind"] == SYNCHRONISATION:
            return self.synchronisation(row)
        if row["kind"] == ORDER:
            (own,) = self.moments(row)
            target, m = row["target"], row["partner_first"]
            ends = self.begins[target][m + 1] if row["fraction"] else self.instant(target, m)
            return min(max(own + EARLIER - ends, 0) / 30.0, 1.0)
        actual = []
        for frame in self.moments(row):
            x, z, theta = self.at(row["player"], frame)
            place = np.array([x, z])
            target = self.spot(row["target"], row["x"], row["z"], frame)
            if row["kind"] == POSITION:
                actual.append(naive_values.position_error(place, target))
            elif row["kind"] == DIRECTION:
                wanted = (
                    row["x"] if row["target"] == HEADING else naive_values.bearing(place, target)
                )
                actual.append(naive_values.direction_error(theta, wanted))
            elif row["kind"] == DISTANCE:
                actual.append(naive_values.distance_error(place, target, row["near"], row["far"]))
            else:
                assert row["kind"] == LINE
                other = self.spot(row["other"], row["other_x"], row["other_z"], frame)
                actual.append(naive_values.line_error(place, target, other))
        return float(np.mean(actual))

    def synchronisation(self, row) -> float:
        (frame,) = self.moments(row)
        actual = []
        for k in self.table.partners[row["partner_first"] : row["partner_last"]]:
            theirs = self.instant(row["partner"], k)
            lag = row["lag"]
            if math.isnan(lag):
                thrown, caught = self.at(row["player"], frame), self.at(row["partner"], theirs)
                lag = naive_values.flight_time(thrown[:2], caught[:2])
            actual.append(float(naive_values.synchronisation_error(frame / 30, theirs / 30, lag)))
        return min(actual)

    def touching(self) -> bool:
        last = max(begin[-1] for begin in self.begins) + self.every
        for p in range(len(self.tracks)):
            for q in range(p):
                for frame in range(0, last, self.every):
                    apart = np.linalg.norm(self.at(p, frame)[:2] - self.at(q, frame)[:2])
                    if apart < (0.3 if self.in_contact(p, q, frame) else 0.5):
                        return True
        return False

    def in_contact(self, p: int, q: int, frame: int) -> bool:
        return any(
            {one, other} == {p, q}
            and min(abs(frame - self.instant(one, k)), abs(frame - self.instant(other, m))) <= 15
            for one, k, other, m in self.table.contacts
        )


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("name", ["give-and-go", "figure-3", "pass-and-shoot", "carrying"])
def test_energies_are_those_of_the_slow_twin(wandering, name: str, every: int) -> None:
    rng = np.random.default_rng(3)
    for spread in (1.0, 1.0, 0.2):
        state, library, table = random_scene(wandering, name, rng, spread)
        actual = energy(state, clip_arrays(library), table, WEIGHTS, every)
        twin = Twin(state, library, table, WEIGHTS, every)
        np.testing.assert_allclose(actual.rules, twin.rules, rtol=0, atol=1e-9)
        assert actual.smooth == pytest.approx(twin.smooth, abs=1e-6)
        assert actual.collision == twin.collision
        assert actual.effort == pytest.approx(twin.effort, abs=1e-9)
        assert actual.total == pytest.approx(twin.total, abs=1e-6)
        errors = np.concatenate(actual.by_token)
        assert errors.min() >= 1.0
        assert errors.sum() == pytest.approx(len(errors) + actual.total)


def changed(scene, library, rng) -> tuple[float, Callable[[], None]]:
    """One random change of a scene: the energy that comes out, and what takes the change back."""
    player = int(rng.integers(len(scene.n_clips)))
    x, z, theta = scene.placed[player, 0, :3].tolist()
    dx, dz, turn = rng.normal(0.0, 0.5, 3)
    delay = int(scene.begin[player, 0]) + int(rng.integers(-20, 21))
    k = int(rng.integers(scene.n_clips[player]))
    clip = library.clips[scene.entry[player, k]]
    entry, way = int(rng.integers(clip["first"], clip["last"])), rng.random()

    def back() -> None:
        energies.undo(scene)

    if 0.6 <= way < 0.8:
        k = -1
    origin = (x, z, theta) if way < 0.7 else (x + dx, z + dz, theta + turn)
    if way < 0.6 or 0.7 <= way < 0.75:
        delay = int(scene.begin[player, 0])
    return energies.change(scene, library, player, k, entry, (*origin, delay)), back


@settings(max_examples=12, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(["give-and-go", "figure-3", "pass-and-shoot", "carrying"]),
    st.sampled_from([1, 3]),
)
def test_incremental_energies_are_those_from_nothing(wandering, seed, name, every) -> None:
    """Over hundreds of changes an example, about half of them taken back."""
    rng = np.random.default_rng(seed)
    state, library, table = random_scene(wandering, name, rng, spread=rng.uniform(0.1, 1.0))
    arrays = clip_arrays(library)
    scene = energies.scene_arrays(state, arrays, table, WEIGHTS, every)
    for step in range(400):
        before = scene.total.copy()
        actual, back = changed(scene, arrays, rng)
        if math.isinf(actual) or rng.random() < 0.5:
            back()
            np.testing.assert_array_equal(scene.total, before)
        else:
            assert actual == scene.total[0]
        if step % 20 == 19:
            state = scene_state(scene, state.trees)
            fresh = energy(state, arrays, table, WEIGHTS, every)
            assert abs(scene.total[0] - fresh.total) < 1e-9
            np.testing.assert_allclose(scene.cost, fresh.rules, rtol=0, atol=1e-9)
            np.testing.assert_array_equal(scene.overlaps, fresh.overlaps)
    twin = Twin(state, library, table, WEIGHTS, every)
    assert scene.total[0] == pytest.approx(twin.total, abs=1e-6)


def test_a_change_above_its_limit_is_infinite_and_others_are_whole(wandering) -> None:
    rng = np.random.default_rng(4)
    state, library, table = random_scene(wandering, "give-and-go", rng)
    arrays = clip_arrays(library)
    scene = energies.scene_arrays(state, arrays, table, WEIGHTS)
    refused = 0
    for _ in range(300):
        player = int(rng.integers(len(scene.n_clips)))
        k = int(rng.integers(scene.n_clips[player]))
        clip = arrays.clips[scene.entry[player, k]]
        entry = int(rng.integers(clip["first"], clip["last"]))
        start = (*scene.placed[player, 0, :3].tolist(), int(scene.begin[player, 0]))
        energy_then = energies.change(scene, arrays, player, k, entry, start)
        energies.undo(scene)
        limit = energy_then + rng.normal(0.0, 100.0)
        actual = energies.change(scene, arrays, player, k, entry, start, limit)
        assert actual == energy_then or (math.isinf(actual) and energy_then > limit)
        refused += math.isinf(actual)
        energies.undo(scene)
        assert energies.evaluate(scene, arrays) == pytest.approx(scene.total[0])
    assert refused > 50


def test_what_is_taken_back_was_never_there(wandering) -> None:
    """All arrays but the notes of what to take back are as before."""
    rng = np.random.default_rng(8)
    state, library, table = random_scene(wandering, "give-and-go", rng)
    arrays = clip_arrays(library)
    scene = energies.scene_arrays(state, arrays, table, WEIGHTS)
    kept = [name for name in scene._fields if name not in ("grid", "rows", "now", "kept", "last")]
    for _ in range(200):
        before = {name: getattr(scene, name).copy() for name in kept}
        grids = [scene.grid[p, : n + 1].copy() for p, n in enumerate(scene.filled)]
        changed(scene, arrays, rng)[1]()
        for name in kept:
            np.testing.assert_array_equal(getattr(scene, name), before[name], name)
        for p, n in enumerate(scene.filled):
            np.testing.assert_array_equal(scene.grid[p, : n + 1], grids[p])
    energies.undo(scene)
    np.testing.assert_array_equal(scene.total, before["total"])


def test_delays_are_bounded(wandering) -> None:
    state, library, table = random_scene(wandering, "carrying", np.random.default_rng(0))
    arrays = clip_arrays(library)
    scene = energies.scene_arrays(state, arrays, table, WEIGHTS)
    before, origin = scene.total[0], scene.placed[0, 0, :3].tolist()
    for delay in (-1, MOST_DELAY + 1):
        assert energies.change(scene, arrays, 0, -1, 0, (*origin, delay)) == math.inf
        energies.undo(scene)
        assert scene.total[0] == before
    assert math.isfinite(energies.change(scene, arrays, 0, -1, 0, (*origin, MOST_DELAY)))


def row(table, **columns):
    """A table with one row."""
    rows = table.rows[:1].copy()
    plain = {"target": -1, "other": -1, "first": 0, "last": 1, "moment": AT_START, "weight": 1.0}
    for name, value in {**plain, **columns}.items():
        rows[name] = value
    return replace(table, rows=rows)


def test_terms_by_hand(wandering) -> None:
    """Equation (7): 0.5 / 1 for a seam, 1 / 0.1 for two who touch, 6 m / 3 m for effort."""
    state, library, table = random_scene(wandering, "pass-and-shoot", np.random.default_rng(0))
    library.path[:], library.step[:], library.seam[:] = 0.0, [0.0, 2.0, 0.0], 0.5
    one, other = (replace(p, entries=p.entries[:1], delay=0) for p in state.players[:2])
    one = replace(one, entries=state.players[0].entries[:2], origin=(0.0, 0.0, 0.0))
    other = replace(other, origin=(0.4, 2.0, 0.0))
    nothing = replace(
        row(table, kind=UNMET, weight=math.inf), players=("A1", "A2"), contacts=table.contacts[:0]
    )
    weights = Weights(smooth=1.0, collision=0.1, effort=3.0)
    scene = SceneState((one, other))
    actual = energy(scene, clip_arrays(library), nothing, weights)
    assert (actual.smooth, actual.collision, actual.effort) == (0.5, 10.0, 2.0)
    assert actual.total == 12.5
    free = SceneState((one, replace(other, origin=(0.5, 2.0, 0.0))))
    assert energy(free, clip_arrays(library), nothing, weights).total == 2.5
