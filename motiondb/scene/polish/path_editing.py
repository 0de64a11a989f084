"""Editing of paths on the ground: rules of place made true with the least change of steps.

With p the spliced path of a player, d_t = p_(t+1) - p_t its steps, and phi the turn that editing
adds to the headings, the edited path p' minimises

    sum a_t |e_t|^2 + b |e_(t+1) - e_t|^2 + c |p'_t - p_t|^2,
    e_t = p'_(t+1) - p'_t - R(phi_t) d_t

and phi minimises the same with e_t = phi_(t+1) - phi_t. a_t is large while the player stands, so
that steps take up the change and feet do not slide; b makes the change smooth; c limits its extent.
Rows of greater weight hold single frames at places and headings. They are increased while a rule
still fails, so that paths stay smooth where they are held. With displacements from the turned path
as unknowns the normal equations have five diagonals and are solved directly.

The rules are not equations; they are projected. If a rule fails, the nearest place (or heading)
that fulfils it is held, the paths are solved again, and so on until all rules hold. A distance
between two players moves both, the one whose rule it is more. Overlapping discs move both players
equally.

Source: M. Kim, K. Hyun, J. Kim and J. Lee, "Synchronized Multi-Character Motion Editing", ACM
Transactions on Graphics 28 (2009), Laplacian editing of paths.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from motiondb.body.features import runs
from motiondb.records import MOTION_FPS, FloatArray, IntArray
from motiondb.scene.energy import binding as kinds
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.energy import CONTACT_FRAMES, CONTACT_RADIUS, RADIUS
from motiondb.scene.language.semantic_rules import nearest_on_line
from motiondb.scene.timing.timeline import (
    Timeline,
    contact_frames,
    moment_frames,
    target_places,
    wanted_headings,
)

# Discs on the ground: which players overlap, and how they are moved apart.


COMFORT = 0.36  # Radius, m, that keeps arms, and a ball in the hands, away from other players


@dataclass(frozen=True)
class Overlap:
    """Two players touch.

    Every player is a disc around the pelvis as in :mod:`motiondb.scene.energy.energy`. Players who
    are meant to touch have smaller discs around their contact.
    """

    first: int  # Index of a player
    second: int  # Index of the other
    start: int
    end: int  # Frame after the last
    depth: float


def depths(
    table: RuleTable,
    timeline: Timeline,
    radius: float = RADIUS,
    contact: float = CONTACT_RADIUS,
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
            needed = np.where(may_touch[p, q], 2.0 * contact, 2.0 * usual)
            yield q, p, needed - np.linalg.norm(away, axis=1)


def overlaps(table: RuleTable, timeline: Timeline) -> tuple[Overlap, ...]:
    """Return which players touch who should not, when, and how deep."""
    overlapping = []
    for q, p, depth in depths(table, timeline):
        for start, end in runs(depth > 1e-9):
            overlapping.append(Overlap(q, p, start, end, float(depth[start:end].max())))
    return tuple(overlapping)


def pushes(
    table: RuleTable,
    timeline: Timeline,
    slack: float,
    radius: float = RADIUS,
    contact: float = CONTACT_RADIUS,
) -> Iterator[tuple[int, IntArray, FloatArray]]:
    """Yield player, frames and displacements (frames, 2) that put discs ``slack`` apart."""
    for q, p, depth in depths(table, timeline, radius, contact):
        frames = np.flatnonzero(depth > 1e-9)
        if len(frames) == 0:
            continue
        away = timeline.places[p, frames, :2] - timeline.places[q, frames, :2]
        apart = np.linalg.norm(away, axis=1, keepdims=True)
        away = np.where(apart > 1e-6, away / np.maximum(apart, 1e-6), [1.0, 0.0])
        by = away * ((depth[frames] + slack) / 2.0)[:, None]
        yield p, frames, by
        yield q, frames, -by


WITHIN, BEYOND = 0.8, 0.95
"""Fractions of a rule's tolerance c_k: to which it is fulfilled, and from which on it is edited.

Chosen by hand: the gap keeps corrections from being repeated for rounding errors."""
SLACK = 0.03  # Margin of distances and discs inside their bounds, m
MOST_ROUNDS = 60  # Most rounds of projection. Chosen by hand; most scenes settle within ten
OWN_SHARE = 0.8  # Fraction of a correction between two players for the one whose rule it is
_BEND, _RETURN, _HOLD = 60.0, 1.0 / 60.0**2, 50.0
"""b, c, and the weight of held frames: changes spread over about 60 frames."""
_RETURN_TURNS = 1.0 / 15.0**2  # c of headings: turns spread over about 15 frames
_STANDING, _WALKING = 8.0, 0.6
"""How much stiffer standing is than moving, and the speed of moving, m/s."""


@dataclass(frozen=True, eq=False)
class Facing:
    """A player has to face another one."""

    player: int
    frames: IntArray  # Frames at which they face
    target: int
    seen: IntArray  # Frames at which the other player's place counts
    tolerance: float


@dataclass(frozen=True, eq=False)
class Edited:
    """The result of editing paths."""

    timeline: Timeline
    rounds: int  # Number of rounds; 0 if no edit was needed
    settled: bool  # Whether all rules of place hold


class _Held:
    """Places or headings held at frames of one player: the rows of great weight."""

    def __init__(self, n_frames: int, n_values: int) -> None:
        self.weight = np.zeros(n_frames)
        self.value = np.zeros((n_frames, n_values))
        self._moved = np.zeros((n_frames, n_values))
        self._count = np.zeros(n_frames)

    def move(self, frames: IntArray, by: FloatArray) -> None:
        """Add corrections (frames, values) of where frames are now."""
        np.add.at(self._moved, frames, by)
        np.add.at(self._count, frames, 1.0)

    def settle(self, now: FloatArray) -> bool:
        """Hold the corrected frames, relative to ``now``; return whether there were any."""
        some = self._count > 0.0
        known = (self.weight > 0.0)[:, None]
        since = np.where(known, self.value, now)  # held already: pull farther
        self.value[some] = since[some] + self._moved[some] / self._count[some, None]
        self.weight[some] = _HOLD
        self._moved[:], self._count[:] = 0.0, 0.0
        return bool(some.any())


def edit_paths(
    table: RuleTable,
    spliced: Timeline,
    wished: FloatArray,
    facings: tuple[Facing, ...] = (),
    before: Timeline | None = None,
    radius: float = RADIUS,
    contact: float = CONTACT_RADIUS,
) -> Edited:
    """Return the timeline with all paths edited so that the rules hold and no players overlap.

    Shapes: `wished` (players, frames, 3), m and rad.

    `before`: A timeline of the same times, by which fractions of a distance are found; by default
    ``spliced``. `radius`, `contact`: Of the discs, m, and of those of players who are to touch.
    """
    before = before or spliced
    n_players, n_frames, _ = spliced.places.shape
    places = [_Held(n_frames, 2) for _ in range(n_players)]
    turns = [_Held(n_frames, 1) for _ in range(n_players)]
    ways = spliced.places.astype(float)
    frames = [moment_frames(row, before) for row in table.rows]
    about = [
        {int(row[name]) for name in ("player", "target", "other") if row[name] >= 0}
        for row in table.rows
    ]
    changed = set(range(n_players))  # a rule about all others held in the round before
    for done in range(MOST_ROUNDS):
        for p in changed:
            ways[p] = _solve(spliced.places[p], wished[p], turns[p], places[p])
        timeline = replace(spliced, places=ways.copy())
        for number in range(len(table.rows)):
            if about[number] & changed:
                _correct(table.rows[number], frames[number], timeline, places, turns)
        for facing in facings:
            if {facing.player, facing.target} & changed:
                _face(facing, timeline, turns)
        for p, touching, by in pushes(table, timeline, SLACK, radius, contact):
            places[p].move(touching, by)
        moved = [places[p].settle(timeline.places[p, :, :2]) for p in range(n_players)]
        turned = [turns[p].settle(timeline.places[p, :, 2:]) for p in range(n_players)]
        changed = {p for p in range(n_players) if moved[p] or turned[p]}
        if not changed:
            return Edited(timeline, done, True)
    return Edited(timeline, MOST_ROUNDS, False)


def _solve(path: FloatArray, wished: FloatArray, turned: _Held, held: _Held) -> FloatArray:
    """Return one player's edited path: array (frames, 3)."""
    step = np.diff(path, axis=0)
    speed = np.linalg.norm(step[:, :2], axis=1) * MOTION_FPS
    stiff = 1.0 + _STANDING * np.clip(1.0 - speed / _WALKING, 0.0, 1.0)
    stiff[np.all(step == 0.0, axis=1)] *= 4.0
    back = wished[:, 2:] - path[:, 2:]
    phi = _displace(stiff, back, turned, path[:, 2:], _RETURN_TURNS)[:, 0]
    middle = (phi[1:] + phi[:-1]) / 2.0
    c, s = np.cos(middle), np.sin(middle)
    steps = np.stack([step[:, 0] * c + step[:, 1] * s, step[:, 1] * c - step[:, 0] * s], axis=1)
    way = path[0, :2] + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    way = way + _displace(stiff, wished[:, :2] - way, held, way)
    return np.column_stack([way, path[:, 2] + phi])


def _displace(
    stiff: FloatArray, wished: FloatArray, held: _Held, now: FloatArray, back: float = _RETURN
) -> FloatArray:
    """Return displacements u (frames, values): least a |du|^2 + b |ddu|^2 + c |u - wished|^2."""
    from scipy.linalg import solveh_banded

    n_frames = len(wished)
    bands = np.zeros((3, n_frames))  # bands[2] the diagonal, bands[1] one above it, bands[0] two
    bands[2] += back + held.weight
    bands[2, :-1] += stiff
    bands[2, 1:] += stiff
    bands[1, 1:] -= stiff
    if n_frames > 2:
        bands[2, :-2] += _BEND
        bands[2, 1:-1] += 4.0 * _BEND
        bands[2, 2:] += _BEND
        bands[1, 1:-1] -= 2.0 * _BEND
        bands[1, 2:] -= 2.0 * _BEND
        bands[0, 2:] += _BEND
    wanted = back * wished + held.weight[:, None] * (held.value - now)
    return np.asarray(solveh_banded(bands, wanted))


def _correct(
    row: np.void,
    frames: IntArray,
    timeline: Timeline,
    places: list[_Held],
    turns: list[_Held],
) -> None:
    """Record the required displacement where a rule fails."""
    kind = row["kind"]
    if kind in (kinds.UNMET, kinds.SYNCHRONISATION):
        return
    player, path = int(row["player"]), timeline.places[row["player"], frames]
    if kind == kinds.DIRECTION:
        wanted = wanted_headings(row, timeline, frames)
        _turn(turns[player], frames, path[:, 2], wanted, float(row["weight"]))
        return
    target = target_places(row, timeline, frames, "target")
    if kind == kinds.DISTANCE:
        away, apart = _apart(path[:, :2], target)
        near, far = float(row["near"]), float(row["far"])
        clear = min(SLACK, (far - near) / 4.0)
        wanted = np.clip(apart, near + clear * (near > 0.0), far - clear)
        bad = (apart < near) | (apart > far)
        by = (away * (wanted - apart)[:, None])[bad]
        share = OWN_SHARE if row["target"] >= 0 else 1.0
        places[player].move(frames[bad], by * share)
        if row["target"] >= 0:
            places[row["target"]].move(frames[bad], -by * (1.0 - share))
        return
    nearest = target
    if kind == kinds.LINE:
        other = target_places(row, timeline, frames, "other")
        nearest = nearest_on_line(path[:, :2], target, other)
    away, apart = _apart(path[:, :2], nearest)
    bad = apart > float(row["weight"]) * BEYOND
    by = away * (float(row["weight"]) * WITHIN - apart)[:, None]
    places[player].move(frames[bad], by[bad])


def _face(facing: Facing, timeline: Timeline, turns: list[_Held]) -> None:
    """Turn a player who does not face the target."""
    places = timeline.places[facing.player, facing.frames]
    away = timeline.places[facing.target, facing.seen, :2] - places[:, :2]
    off = np.unwrap(places[:, 2] - np.arctan2(away[:, 0], away[:, 1]))  # all in one direction
    off -= 2.0 * math.pi * np.rint(off.mean() / (2.0 * math.pi))
    _bring(turns[facing.player], facing.frames, off, facing.tolerance)


def _turn(
    turned: _Held, frames: IntArray, heading: FloatArray, wanted: FloatArray, tolerance: float
) -> None:
    off = np.mod(heading - wanted + math.pi, 2.0 * math.pi) - math.pi
    _bring(turned, frames, off, tolerance)


def _bring(turned: _Held, frames: IntArray, off: FloatArray, tolerance: float) -> None:
    """Turn by the part of the deviations ``off`` (frames,), rad, beyond a tolerance."""
    bad = np.abs(off) > tolerance * BEYOND
    by = np.sign(off) * tolerance * WITHIN - off
    turned.move(frames[bad], by[bad][:, None])


def _apart(points: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors (frames, 2) from target to place, and distances, m."""
    away = points - target
    apart = np.linalg.norm(away, axis=1)
    away = np.where(apart[:, None] > 1e-9, away / np.maximum(apart, 1e-9)[:, None], [0.0, 1.0])
    return away, apart
