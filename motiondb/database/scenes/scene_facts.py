"""Facts of a scene for its record: details of the report, and the actions of players with times."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby, pairwise
from typing import Any, TypeVar, cast

import numpy as np

from motiondb.answers.making import Source
from motiondb.answers.scenes import SceneDetails
from motiondb.database.scenes.scene_folder import waiting
from motiondb.database.scenes.scene_making import MadeScene
from motiondb.records import MOTION_FPS, Caption
from motiondb.scene.polish.placed import Placed

Record = TypeVar("Record")


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


def scene_details(made: MadeScene, sources: tuple[Source, ...]) -> SceneDetails:
    """Return what a report says beside the values of rules, with rounded numbers."""
    report = made.report
    cut_at = dict(zip(("try", "rounds", "of"), made.cut_at)) if made.cut_short else None
    return SceneDetails(
        collisions=tuple(map(_rounded, report.collisions)),
        collisions_before=len(report.collisions_before),
        feet={f.player: (round(f.slip, 4), round(f.source_slip, 4)) for f in report.feet},
        paces=tuple(_rounded(pace, 3) for pace in report.paces),
        impossible=tuple(map(_rounded, report.impossible)),
        planted_feet=tuple(map(_rounded, report.jumps)),
        near_limbs=tuple(map(_rounded, report.limbs)),
        guards=tuple(map(_rounded, report.guards)),
        bone_error=round(report.bone_error, 6),
        ball_gap=None if np.isnan(report.ball_gap) else round(report.ball_gap, 4),
        too_fast=made.too_fast,
        settled=bool(made.polished.settled),
        tries=made.tries,
        cut_short=made.cut_short,
        cut_at=cut_at,
        sources=sources,
    )


def _rounded(record: Record, digits: int = 4) -> Record:
    """Return a record with its floats rounded."""
    values = vars(record).items()
    rounded = {name: round(value, digits) for name, value in values if isinstance(value, float)}
    return replace(cast(Any, record), **rounded)
