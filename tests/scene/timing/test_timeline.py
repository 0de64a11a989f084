"""Rules measured frame by frame: beside the compiled values, and worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scene_energy import energy

from motiondb.database.scenes.scene_texts import read_scene_text
from motiondb.scene.energy.binding import (
    POINT,
    ROW,
    RuleTable,
    bind,
)
from motiondb.scene.energy.placement import clip_arrays
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.semantic_rules import Weights
from motiondb.scene.polish.path_editing import overlaps
from motiondb.scene.services import casting
from motiondb.scene.timing.timeline import (
    Timeline,
    measure,
    sampled_timeline,
)


def a_row(**values: object) -> np.void:
    row = np.zeros(1, ROW)
    row["target"], row["other"], row["far"], row["weight"] = POINT, POINT, math.inf, 1.0
    for name, value in values.items():
        row[name] = value
    return row[0]


def still(*places: tuple[float, float, float], frames: int = 4) -> Timeline:
    """Everybody stands still; one clip of all frames each."""
    everybody = np.repeat(np.array(places, dtype=float)[:, None], frames, axis=1)
    begins = tuple(np.array([0, frames]) for _ in places)
    return Timeline(everybody, begins, tuple(np.array([frames // 2]) for _ in places))


def a_table(*rows: np.void, players: int = 2, contacts: tuple = ()) -> RuleTable:
    return RuleTable(
        tuple(f"P{n}" for n in range(players)),
        tuple(("go",) for _ in range(players)),
        np.array(list(rows), dtype=ROW),
        np.array([0]),
        np.array(contacts, dtype=np.int64).reshape(-1, 4),
        tuple(None for _ in rows),
        np.full(len(rows), -1),
    )


@pytest.mark.parametrize("name", ["give-and-go", "screen", "pass-and-shoot"])
def test_compiled_rules_measure_the_same(name: str, wandering) -> None:
    text = read_scene_text(name)
    diagram, grammar = text.diagram, text.grammar
    library = wandering([terminal.name for terminal in grammar.terminals], seed=4)
    trees = casting.cast(diagram, grammar)
    table = bind(diagram, grammar, trees)
    rng = np.random.default_rng(8)
    players = []
    for number, player in enumerate(diagram.players):
        entries = [rng.choice(list(library.of(action))) for action in table.actions[number]]
        origin = (player.at.x, player.at.z, float(rng.uniform(-3.0, 3.0)))
        tree = trees[player.name]
        players.append(PlayerState(tree, np.array(entries), origin, int(rng.integers(0, 50))))
    state = SceneState(tuple(players))
    timeline = sampled_timeline(state, library)
    actual = energy(state, clip_arrays(library), table, Weights())
    ours = [measure(table, n, timeline).value / row["weight"] for n, row in enumerate(table.rows)]
    on_the_way = table.rows["moment"] == 4  # their shares of a way differ by a frame
    np.testing.assert_allclose(np.array(ours)[~on_the_way], actual.rules[~on_the_way], atol=1e-9)
    pairs = {(o.first, o.second) for o in overlaps(table, timeline)}
    assert pairs == {(a, b) for a, b in zip(*np.nonzero(actual.overlaps), strict=True) if a < b}


def test_who_stands_in_whom_is_told_with_depth() -> None:
    timeline = still((0.0, 0.0, 0.0), (0.3, 0.4, 0.0), (0.0, 0.45, 0.0))
    overlapping = overlaps(a_table(players=3), timeline)
    assert [(o.first, o.second) for o in overlapping] == [(0, 2), (1, 2)]
    assert overlapping[0].depth == pytest.approx(0.05)
    assert (overlapping[0].start, overlapping[0].end) == (0, 4)


def test_who_is_to_touch_may_come_nearer() -> None:
    timeline = still((0.0, 0.0, 0.0), (0.35, 0.0, 0.0), frames=60)
    overlapping = overlaps(a_table(contacts=((0, 0, 1, 0),)), timeline)
    assert [(o.start, o.end) for o in overlapping] == [(0, 15), (46, 60)]  # 30 -+ 15 left out
