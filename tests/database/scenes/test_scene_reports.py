"""What the report of a scene says, on records written by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from motiondb import store
from motiondb.database.scenes.scene_reports import report_facts, report_text

CLIP = store.SceneClip("guard", "ada/guard_1", "ab" * 32, 10, 97)
SCENE = store.StoredScene(
    "play",
    'diagram "Play"',
    "grammar g",
    {"seed": 3, "minutes": 0.5},
    12.5,
    328,
    (store.ScenePlayer("D1", "defence", (0, 3, 1), (1.0, 8.0, -0.5), 4, (CLIP, CLIP)),),
    (
        store.SceneRule("D1", "guard", 0, "distance", "A1", "m", 0.5, 0.0, 0.0, 60, True),
        store.SceneRule("D1", "guard", 1, "distance", "A1", "m", 0.5, 0.2, 0.0, 201, False),
        store.SceneRule("D1", "guard", 1, "direction", "A1", "deg", 3.0, 30.0, 20.0, 240, False),
    ),
    report={"collisions": [], "rule_frames": [[40, 127], [200, 230], [240, 241]]},
)


def table_of(scene: store.StoredScene) -> list[str]:
    """The rows of rules, from the column of frames on."""
    lines = report_text(scene).splitlines()
    head = next(n for n, line in enumerate(lines) if line.startswith("player "))
    column = lines[head].index("frame")
    return [line[column:] for line in lines[head + 1 : head + 1 + len(scene.rules)]]


def test_every_rule_tells_the_frames_that_it_looked_at() -> None:
    facts: Any = report_facts(SCENE)
    assert [(r["start"], r["end"], r["frames"], r["frame"]) for r in facts["by_rule"]] == [
        (40, 127, 87, 60),
        (200, 230, 30, 201),
        (240, 241, 1, 240),
    ]
    assert "rule_frames" not in facts
    assert table_of(SCENE) == [
        "40-126, 87 of 328",
        "200-229, 30 of 328  BROKEN, most at 201",
        "240                 BROKEN",
    ]


def test_sampling_that_time_ended_is_told() -> None:
    said = (
        "sampling was cut short by --minutes 0.5: the seed alone does not fix this scene, and with"
        " more minutes it may be better"
    )
    assert said not in report_text(SCENE)
    short = replace(SCENE, report={**SCENE.report, "cut_short": True})
    assert report_text(short).splitlines()[2] == said
    assert report_facts(short)["cut_short"] is True


def test_scenes_that_did_not_note_frames_are_told_as_before() -> None:
    old = replace(SCENE, report={"collisions": []})
    assert table_of(old) == ["60", "201    BROKEN", "240    BROKEN"]
    facts: Any = report_facts(old)
    assert {(r["start"], r["end"], r["frames"]) for r in facts["by_rule"]} == {(None, None, None)}


def test_frames_of_other_rules_are_refused() -> None:
    with pytest.raises(ValueError, match="zip"):
        report_text(replace(SCENE, report={"rule_frames": [[40, 127]]}))
