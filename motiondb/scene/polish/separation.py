"""Discs on the ground pushed apart, and what of them overlaps.

Everybody is a disc round the pelvis as in :mod:`.collisions`; those who are to touch have smaller
ones about their contact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from motiondb.pose.features import runs
from motiondb.records import FloatArray, IntArray
from motiondb.scene.energy.collisions import CONTACT_FRAMES, CONTACT_RADIUS, RADIUS
from motiondb.scene.energy.rule_table import RuleTable
from motiondb.scene.timing.timeline import Timeline, contact_frames

COMFORT = 0.36
"""Metres round the pelvis that keep arms, and a ball in the hands, out of other people."""


@dataclass(frozen=True)
class Overlap:
    """Two players touch from frame ``start`` to before ``end``, by ``depth`` metres at most."""

    first: int
    second: int
    start: int
    end: int
    depth: float


def depths(
    table: RuleTable, timeline: Timeline, radius: float = RADIUS
) -> Iterator[tuple[int, int, FloatArray]]:
    """For every pair of players by how much their discs overlap: arrays (frames,), metres.

    Negative where they are apart. Those who are to touch at some time have the usual discs.
    """
    n_players = len(timeline.places)
    may_touch = contact_frames(table, timeline, CONTACT_FRAMES)
    for p in range(n_players):
        for q in range(p):
            away = timeline.places[p, :, :2] - timeline.places[q, :, :2]
            usual = RADIUS if may_touch[p, q].any() else radius
            needed = np.where(may_touch[p, q], 2.0 * CONTACT_RADIUS, 2.0 * usual)
            yield q, p, needed - np.linalg.norm(away, axis=1)


def overlaps(table: RuleTable, timeline: Timeline) -> tuple[Overlap, ...]:
    """Who touches whom that should not, when, and how deep."""
    found = []
    for q, p, depth in depths(table, timeline):
        for start, end in runs(depth > 1e-9):
            found.append(Overlap(q, p, start, end, float(depth[start:end].max())))
    return tuple(found)


def pushes(
    table: RuleTable, timeline: Timeline, slack: float, radius: float = RADIUS
) -> Iterator[tuple[int, IntArray, FloatArray]]:
    """Player, frames and displacements (frames, 2) that put overlapping discs ``slack`` apart."""
    for q, p, depth in depths(table, timeline, radius):
        frames = np.flatnonzero(depth > 1e-9)
        if len(frames) == 0:
            continue
        away = timeline.places[p, frames, :2] - timeline.places[q, frames, :2]
        apart = np.linalg.norm(away, axis=1, keepdims=True)
        away = np.where(apart > 1e-6, away / np.maximum(apart, 1e-6), [1.0, 0.0])
        by = away * ((depth[frames] + slack) / 2.0)[:, None]
        yield p, frames, by
        yield q, frames, -by
