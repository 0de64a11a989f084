"""Discs on the ground: which players overlap, and how they are moved apart.

Every player is a disc around the pelvis as in :mod:`motiondb.scene.energy.collisions`. Players who
are meant to touch have smaller discs around their contact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from motiondb.body.features import runs
from motiondb.records import FloatArray, IntArray
from motiondb.scene.energy.collisions import CONTACT_FRAMES, CONTACT_RADIUS, RADIUS
from motiondb.scene.energy.rule_table import RuleTable
from motiondb.scene.timing.timeline import Timeline, contact_frames

COMFORT = 0.36  # Radius, m, that keeps arms, and a ball in the hands, away from other players


@dataclass(frozen=True)
class Overlap:
    """Two players touch."""

    first: int  # Index of a player
    second: int  # Index of the other
    start: int
    end: int  # Frame after the last
    depth: float


def depths(
    table: RuleTable, timeline: Timeline, radius: float = RADIUS
) -> Iterator[tuple[int, int, FloatArray]]:
    """Yield for every pair of players the overlap of their discs: arrays (frames,), m.

    It is negative where they are apart. Players who are meant to touch at some time have the usual
    discs.
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
    """Return which players touch who should not, when, and how deep."""
    overlapping = []
    for q, p, depth in depths(table, timeline):
        for start, end in runs(depth > 1e-9):
            overlapping.append(Overlap(q, p, start, end, float(depth[start:end].max())))
    return tuple(overlapping)


def pushes(
    table: RuleTable, timeline: Timeline, slack: float, radius: float = RADIUS
) -> Iterator[tuple[int, IntArray, FloatArray]]:
    """Yield player, frames and displacements (frames, 2) that put discs ``slack`` apart."""
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
