"""Scenes in the store: whole or not at all, replaced by name, and checked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motiondb import store
from motiondb.errors import QueryError

CLIP = store.SceneClip("run", "ada/run_1", "ab" * 32, 10, 40, True, 0.25, 0.85, 12)
SCENE = store.StoredScene(
    "play",
    'diagram "Play"',
    "grammar g",
    {"seed": 3, "chains": 2},
    12.5,
    2,
    (
        store.ScenePlayer("A1", "attack", (0, 3, 1), (1.0, 8.0, -0.5), 4, (CLIP, CLIP)),
        store.ScenePlayer("D1", "defence", (2,), (0.0, 6.5, 3.0), 0, (replace(CLIP, begin=0),)),
    ),
    (store.SceneRule("A1", "run", 1, "position", "(1, 5)", "m", 0.8, 0.05, 0.3, 42, True),),
    np.array([[0.0, 1.0, 2.0], [0.5, 1.25, 2.5]]),
    {"collisions": []},
)


@pytest.fixture
def opened(tmp_path: Path) -> store.Store:
    return store.open_store(tmp_path / "s.duckdb")


def keep(opened: store.Store, scene: store.StoredScene) -> int:
    run = store.start_run(opened, "scene make", {}, 3)
    store.save_scene(opened, scene, run)
    store.finish_run(opened, run)
    return run


def test_what_is_kept_comes_back(opened: store.Store) -> None:
    run = keep(opened, SCENE)
    scene = store.load_scene(opened, "play")
    np.testing.assert_array_equal(scene.ball, SCENE.ball)
    assert replace(scene, ball=SCENE.ball, run_id=0).__dict__ == SCENE.__dict__
    assert scene.run_id == run
    assert store.check_store(opened) == []


def test_a_scene_takes_the_place_of_the_one_of_its_name(opened: store.Store) -> None:
    keep(opened, SCENE)
    keep(opened, replace(SCENE, name="other"))
    keep(opened, replace(SCENE, error=1.0, ball=np.zeros((0, 3)), rules=()))
    assert store.load_scene_names(opened) == ["other", "play"]
    assert store.load_scene(opened, "play").error == 1.0
    assert store.load_scene(opened, "play").ball.shape == (0, 3)
    assert store.load_scene(opened, "other").rules == SCENE.rules
    assert store.check_store(opened) == []


def test_removed_without_a_trace(opened: store.Store) -> None:
    keep(opened, SCENE)
    store.remove_scene(opened, "play")
    rows = store.count_rows(opened)
    assert {name: n for name, n in rows.items() if name.startswith("scene")} == dict.fromkeys(
        ("scene", "scene_ball", "scene_clip", "scene_player", "scene_rule"), 0
    )
    with pytest.raises(QueryError, match=r"'play': expected the name of a scene.*scene make"):
        store.remove_scene(opened, "play")


def test_nothing_is_left_of_a_scene_that_failed(opened: store.Store) -> None:
    run = store.start_run(opened, "scene make", {}, 3)
    twice = replace(SCENE, players=(SCENE.players[0], SCENE.players[0]))
    with pytest.raises(Exception, match=r"(?i)constraint"):
        store.save_scene(opened, twice, run)
    assert store.load_scene_names(opened) == []
    assert store.count_rows(opened)["scene_clip"] == 0


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ("DELETE FROM scene_clip WHERE player = 1", "scene play: expected clips of its players"),
        ("DELETE FROM scene_ball WHERE frame = 0", "scene play: expected its ball in every frame"),
        ("UPDATE scene_rule SET player = 'B9'", "scene play: expected rules about its players"),
        ("UPDATE scene_player SET capture_id = 7", "scene play: expected captures that were gen"),
        (
            "UPDATE scene_ball SET scene_id = 9",
            "scene_ball: expected rows of a scene and of its run, found 2",
        ),
        ("UPDATE scene_rule SET run_id = 9", "scene_rule: expected rows of a finished run"),
    ],
)
def test_check_finds_what_is_broken(opened: store.Store, change: str, fault: str) -> None:
    keep(opened, SCENE)
    opened.connection.execute(change)
    assert any(actual.startswith(fault) for actual in store.check_store(opened))
