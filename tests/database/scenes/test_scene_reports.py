"""What the report of a scene says, on records written by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from motiondb import store
from motiondb.database.scenes.scene_folder import report_facts, report_text

LISTS = (
    "collisions", "paces", "impossible", "planted_feet", "near_limbs", "guards", "sources",
)  # fmt: skip
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
    report={
        **{name: [] for name in LISTS},
        "rule_frames": [[40, 127], [200, 230], [240, 241]],
        "collisions_before": 0,
        "feet": {},
        "bone_error": 0.0,
        "ball_gap": None,
        "too_fast": [],
        "settled": True,
        "tries": 1,
        "cut_short": False,
    },
)


def table_of(scene: store.StoredScene) -> list[str]:
    """The rows of rules, from the column of frames on."""
    lines = report_text(scene).splitlines()
    head = next(n for n, line in enumerate(lines) if line.startswith("player "))
    column = lines[head].index("frame")
    return [line[column:] for line in lines[head + 1 : head + 1 + len(scene.rules)]]


def test_every_rule_tells_the_frames_that_it_looked_at() -> None:
    facts: Any = report_facts(SCENE)
    assert [(r.start, r.end, r.frames, r.frame) for r in facts.by_rule] == [
        (40, 127, 87, 60),
        (200, 230, 30, 201),
        (240, 241, 1, 240),
    ]
    assert table_of(SCENE) == [
        "40-126, 87 of 328",
        "200-229, 30 of 328  BROKEN, most at 201",
        "240                 BROKEN",
    ]


def test_sampling_that_time_ended_is_told() -> None:
    said = (
        "sampling was cut short by --minutes 0.5: the seed alone does not determine this scene, "
        "and more minutes may improve it"
    )
    assert said not in report_text(SCENE)
    short = replace(SCENE, report={**SCENE.report, "cut_short": True})
    assert report_text(short).splitlines()[2] == said
    assert report_facts(short).cut_short
    at = {"try": 2, "rounds": 31, "of": 70}
    told = replace(short, report={**short.report, "cut_at": at})
    assert report_text(told).splitlines()[2] == f"{said}; it ended after 31 of 70 rounds of try 2"


def test_frames_of_other_rules_are_refused() -> None:
    with pytest.raises(ValueError, match="zip"):
        report_text(replace(SCENE, report={**SCENE.report, "rule_frames": [[40, 127]]}))


def test_impossible_motion_is_told_with_its_frames() -> None:
    assert "impossible motion: none" in report_text(SCENE).splitlines()
    walk = {
        "kind": "airborne", "players": ["A1"], "action": "walk", "start": 20, "end": 32,
        "frame": 26, "value": 12.0, "limit": 3.0, "unit": "frames",
    }  # fmt: skip
    limbs = {
        "kind": "limbs", "players": ["A1", "D1"], "action": "", "start": 7, "end": 8,
        "frame": 7, "value": 0.001, "limit": 0.01, "unit": "m",
    }  # fmt: skip
    scene = replace(SCENE, report={**SCENE.report, "impossible": [walk, limbs]})
    lines = report_text(scene).splitlines()
    at = lines.index("impossible motion:")
    assert lines[at + 1 : at + 3] == [
        "  A1 walk, frames 20 to 31, most at 26: both feet in the air for 12 frames, at most 3 are"
        " possible",
        "  A1 and D1, frame 7: limbs pass through each other",
    ]
    facts: Any = report_facts(scene)
    assert [motion.frame for motion in facts.impossible] == [26, 7]


def test_guards_feet_and_limbs_are_told_beside_the_rules() -> None:
    report = {
        **SCENE.report,
        "guards": [{
            "player": "D1", "target": "A1", "near": 0.5, "far": 2.0, "n_frames": 87,
            "outside": 0.47, "farthest": 5.82, "frame": 300,
        }],
        "planted_feet": [{
            "player": "D1", "foot": "left", "metres": 0.031, "start": 177, "end": 186,
            "source_metres": 0.086,
        }],
        "seen": [
            {"kind": kind, "players": players, "start": 60, "end": 61, "value": value, "unit": unit}
            for kind, players, value, unit in (
                ("limbs", ["A1", "D1"], 0.03, "m"),
                ("leap", ["A1", "sit", "wave"], 4.1, ""),
                ("order", ["A1", "D1"], 5.0, "step"),
            )
        ],
    }  # fmt: skip
    text = report_text(replace(SCENE, report=report))
    assert (
        "  D1 from A1: outside 0.5 to 2 m in 47 % of 328 frames (rules use 87), farthest 5.8 m at "
        "frame 300\n"
    ) in text
    assert "  D1     0.031 (0.086), left foot, frames 177 to 186\n" in text
    assert (
        "seen at once, whatever the rules:\n"
        "  limbs of A1 and D1 touch, 0.03 m between their bones, frames 60 to 60\n"
        "  A1 goes from sit to wave at once, with no clip that leads there, frames 60 to 60\n"
        "  D1 does step 5 before A1 does an earlier one, frames 60 to 60\n"
        "rules kept: "
    ) in text
