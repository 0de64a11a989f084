"""Facts of a scene for its record: details of the report, and the actions of players with times."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from motiondb.database.scenes.scene_folder import waiting
from motiondb.database.scenes.scene_making import MadeScene
from motiondb.records import MOTION_FPS, Caption
from motiondb.scene.polish.placed import Placed


def action_captions(placed: Placed, actions: tuple[str, ...]) -> list[Caption]:
    """Return the actions of a player as captions with times; consecutive equal actions are joined.

    Waiting has no caption.
    """
    clips, waits = np.asarray(placed.clips).tolist(), waiting(placed.edits).tolist()
    words = [
        "" if wait else actions[clip].replace("_", " ")
        for clip, wait in zip(clips, waits, strict=True)
    ]
    bounds = [0]
    for _, run in groupby(words):
        bounds.append(bounds[-1] + len(list(run)))
    return [
        Caption(words[start], start / MOTION_FPS, end / MOTION_FPS)
        for start, end in pairwise(bounds)
        if words[start]
    ]


def report_details(made: MadeScene) -> dict[str, Any]:
    """Return the facts of a report other than the values of rules."""
    report = made.report
    return {
        "rule_frames": [[rule.start, rule.end] for rule in report.rules],
        "collisions": [_rounded(asdict(touch)) for touch in report.collisions],
        "collisions_before": len(report.collisions_before),
        "feet": {f.player: [round(f.slip, 4), round(f.source_slip, 4)] for f in report.feet},
        "paces": [_rounded(asdict(pace), 3) for pace in report.paces],
        "impossible": [_rounded(asdict(motion)) for motion in report.impossible],
        "planted_feet": [_rounded(asdict(jump)) for jump in report.jumps],
        "near_limbs": [_rounded(asdict(pair)) for pair in report.limbs],
        "guards": [_rounded(asdict(guard)) for guard in report.guards],
        "bone_error": round(report.bone_error, 6),
        "ball_gap": None if np.isnan(report.ball_gap) else round(report.ball_gap, 4),
        "too_fast": list(made.too_fast),
        "settled": bool(made.polished.settled),
        "tries": made.tries,
        "cut_short": made.cut_short,
        **({"cut_at": dict(zip(("try", "rounds", "of"), made.cut_at))} if made.cut_short else {}),
    }


def _rounded(facts: dict[str, Any], digits: int = 4) -> dict[str, Any]:
    """Return facts for JSON: floats rounded, tuples as lists."""
    return {
        key: round(value, digits)
        if isinstance(value, float)
        else list(value)
        if isinstance(value, tuple)
        else value
        for key, value in facts.items()
    }
