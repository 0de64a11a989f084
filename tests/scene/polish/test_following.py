"""Guards who have nothing more to do go with whom they guard, and touch nobody on the way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motiondb.grammar.cfg.parse import parse
from motiondb.scene.clips.clip_cutting import compose
from motiondb.scene.clips.clips import ClipLibrary, ClipSource
from motiondb.scene.energy.binding import bind
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.polish.following import chase
from motiondb.scene.polish.path_editing import COMFORT
from motiondb.scene.polish.polish import _drift
from motiondb.scene.timing.scene_schedule import _is_awaited

TURNS = [math.radians(degrees) for degrees in (0.0, 45.0, -45.0, 90.0, -90.0)]
FRAMES, METRES = 10, 0.6  # of a step


def library() -> ClipLibrary:
    """Steps ahead and aside, and a clip of guarding in place; every seam fits."""
    share = np.linspace(0.0, 1.0, FRAMES + 1)
    ways = [
        np.column_stack([METRES * share * math.sin(t), METRES * share * math.cos(t), t * share])
        for t in TURNS
    ] + [np.zeros((FRAMES + 1, 3))]
    n = len(ways)
    return ClipLibrary(
        terminals=("walk", "guard"),
        terminal=np.array([0] * (n - 1) + [1], np.int32),
        first=np.array([0, n - 1, n], np.int32),
        n_frames=np.full(n, FRAMES, np.int32),
        step=np.array([way[-1] for way in ways]),
        event_frame=np.full(n, -1, np.int32),
        path_start=np.arange(n, dtype=np.int32) * FRAMES,
        path=np.concatenate([way[:-1] for way in ways]),
        seam=np.zeros((1, 1), np.float32),
        seam_class=np.zeros(n, np.int32),
        hand=np.zeros((n, 3)),
        source=tuple(ClipSource(f"clip{k}", 0, FRAMES) for k in range(n)),
    )


GRAMMAR = read_motion_grammar(
    """
    start S
    role attack, defence
    S -> walk S | guard S | walk | guard
    walk := "walk"
    guard := "guard"
    rest guard for guard
    guard: distance(opponent, 0.5 m .. 2 m)
    """
)
DIAGRAM = read_diagram(
    "defence D at 0 0 guards A\nattack A at 0 1\nattack B at 5 5\n", activity=GRAMMAR.activity
)
TABLE = bind(DIAGRAM, GRAMMAR, [parse(GRAMMAR.started(), ["guard"])] * 3)


def places(leaves: float, stands: tuple[float, float] = (9.0, 9.0)) -> np.ndarray:
    """A guard at the origin, somebody 1 m away who walks so far in 100 frames, and another."""
    found = np.zeros((3, 250, 3))
    found[1, :, 1] = 1.0 + leaves * np.clip((np.arange(250) - 20) / 100.0, 0.0, 1.0)
    found[2, :, :2] = stands
    return found


def way(entries: tuple[int, ...]) -> np.ndarray:
    """The places of a guard from frame 20 on who takes these clips, and then stands."""
    clips, here, parts = library(), np.zeros(3), []
    for entry in entries:
        parts.append(compose(here, clips.path_of(entry)))
        here = compose(here, clips.step[entry])
    walked = np.concatenate([np.zeros((0, 3)), *parts])
    return np.concatenate([walked, np.tile(here, (230 - len(walked), 1))])


def followed(scene: np.ndarray) -> tuple[int, ...]:
    return chase(library(), TABLE, 0, np.array([5]), scene, 20)


@pytest.mark.parametrize("stands", [(9.0, 9.0), (0.1, 2.0)])
def test_a_guard_comes_within_the_bounds_and_goes_around_who_stands_in_the_way(
    stands: tuple[float, float],
) -> None:
    scene = places(5.0, stands)
    shown = way(followed(scene))
    apart = np.linalg.norm(shown[:, :2] - scene[1, 20:, :2], axis=1)
    assert ((apart < 0.5) | (apart > 2.0)).mean() < 0.15
    assert 0.5 <= apart[-1] <= 2.0
    others = np.linalg.norm(shown[:, None, :2] - scene[1:, 20:, :2].transpose(1, 0, 2), axis=2)
    assert others.min() >= 2.0 * COMFORT - 1e-9


def test_nobody_follows_who_stays_or_is_guarded_by_nobody() -> None:
    assert followed(places(0.5)) == ()
    assert chase(library(), TABLE, 2, np.array([5]), places(5.0), 20) == ()
    assert chase(library(), TABLE, 0, np.array([5]), places(5.0), 250) == ()  # the scene is over


def test_the_drift_of_blends_is_what_leads_back_to_the_clips() -> None:
    entries, shown = (0, 1, 3, 2), way((0, 1, 3, 2))
    assert np.abs(_drift(shown, entries, library())).max() < 1e-9
    lost = shown + 0.3 * np.clip(np.arange(len(shown)) / 40.0, 0.0, 1.0)[:, None]
    found = lost + _drift(lost, entries, library())
    middles = np.arange(4) * FRAMES + FRAMES // 2
    np.testing.assert_allclose(found[middles], shown[middles], atol=1e-9)


def test_a_guard_who_begins_too_far_away_is_awaited() -> None:
    trees = [parse(GRAMMAR.started(), ["walk"])] * 3
    table = bind(DIAGRAM, GRAMMAR, trees)
    for metres, awaited in ((1.0, [False] * 3), (2.5, [True, False, False])):  # at most 2 m
        places = ((0.0, 0.0, 0.0), (0.0, metres, 0.0), (5.0, 5.0, 0.0))
        state = SceneState(tuple(PlayerState(trees[0], np.array([0]), at) for at in places))
        assert [_is_awaited(state, table, player) for player in range(3)] == awaited
