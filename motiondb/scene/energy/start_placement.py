"""Where and when a string of clips begins best, in closed form: what a search starts from.

The origin of a player's string is the rigid motion of the plane that brings the places at which the
string stands when its position rules look nearest to the places that they ask for, and its headings
nearest to those of its direction rules: it maximises, over the turn phi,

    sum_k w_k p_k . R(phi) q_k  +  sum_d w_d cos(phi + theta_d - wanted_d) (1 m)^2,

q_k where the string stands and p_k where it should, both from their weighted means, w = 1 / c; the
first sum alone is Procrustes' problem. Where nothing tells a heading, who keeps a distance or a
line to somebody faces them.

Delays: each synchronisation rule asks that one string begins so much later than another; the least
squares solution, every group of linked players beginning at 0, is found by relaxation.

Source: P. H. Schönemann, "A generalized solution of the orthogonal Procrustes problem",
Psychometrika 31 (1966), here in the plane. Print does not say where a string begins.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from motiondb.records import MOTION_FPS
from motiondb.scene.energy.compilation import compiled
from motiondb.scene.energy.energy import evaluate
from motiondb.scene.energy.placement import ClipArrays, place_in_clip, put_origin
from motiondb.scene.energy.rule_kernels import moment_of
from motiondb.scene.energy.rule_table import (
    DIRECTION,
    DISTANCE,
    HEADING,
    LINE,
    POSITION,
    SYNCHRONISATION,
    THROUGHOUT,
)
from motiondb.scene.energy.scene_arrays import MOST_DELAY, SceneArrays
from motiondb.scene.energy.scene_places import place_of, place_string
from motiondb.scene.language.semantic_rules import PASS_SPEED

_SWEEPS = 4
"""Rounds over all players: directions and delays depend on where the others have come to stand."""
_RELAXATIONS = 200
_SURE = 1e-9


@njit(cache=True, nogil=True)
def place_start(scene: SceneArrays, library: ClipArrays) -> float:
    """Give all players their best origins and delays; -log P(Y) of what comes out.

    There is no undo of it.
    """
    n_players = len(scene.n_clips)
    for sweep in range(_SWEEPS):
        for player in range(n_players):
            place_player(scene, library, player, sweep > 0)
        set_delays(scene, library)
    return evaluate(scene, library)


@compiled
def place_player(scene: SceneArrays, library: ClipArrays, player: int, facing: bool) -> None:
    """Give one player the best origin, where the others are; ``facing``: heed directions, too.

    Changes the origin, the string and its grid, nothing else: evaluate() must follow.
    """
    weight, px, pz, qx, qz = _means(scene, library, player)
    c, s = _turn_of_places(scene, library, player, (px, pz, qx, qz))
    if facing:
        to_c, to_s = _turn_of_headings(scene, library, player)
        c, s = c + to_c, s + to_s
    if math.hypot(c, s) > _SURE:
        turn = math.atan2(s, c)
    else:
        turn = _turn_to_others(scene, library, player)
    if weight == 0.0:
        qx, qz = scene.placed[player, 0, 0], scene.placed[player, 0, 1]
        px, pz = qx, qz
    c, s = math.cos(turn), math.sin(turn)
    x, z = scene.placed[player, 0, 0] - qx, scene.placed[player, 0, 1] - qz
    theta = scene.placed[player, 0, 2] + turn
    put_origin(scene.placed[player], px + x * c + z * s, pz - x * s + z * c, theta)
    place_string(scene, library, player, -1)


@njit(cache=True, nogil=True)
def set_delays(scene: SceneArrays, library: ClipArrays) -> None:
    """Give all players the delays that fulfil the synchronisation rules best.

    Changes delays, strings and grids, nothing else: evaluate() must follow. Players whom no rule
    links with anybody begin at 0. Of several actions of a partner the first is taken.
    """
    n_players = len(scene.n_clips)
    starts = np.zeros(n_players)  # seconds
    group = np.arange(n_players)
    for player in range(n_players):
        scene.begin[player, 0] = 0
        place_string(scene, library, player, -1)
    for _ in range(_RELAXATIONS):
        for player in range(n_players):
            later, links = 0.0, 0.0
            for r in range(len(scene.rows)):
                row = scene.rows[r]
                if row.kind != SYNCHRONISATION or row.player == row.partner:
                    continue
                if row.player == player or row.partner == player:
                    asked = _lateness(scene, library, r)
                    asked += starts[row.partner] - starts[row.player]
                    later += (asked if row.player == player else -asked) / row.weight
                    links += 1.0 / row.weight
                    linked = min(group[row.player], group[row.partner])
                    group[row.player] = group[row.partner] = linked
            if links > 0.0:
                starts[player] += later / links
    for player in range(n_players):
        first = starts[player]
        for other in range(n_players):
            if group[other] == group[player]:
                first = min(first, starts[other])
        frames = round((starts[player] - first) * MOTION_FPS)
        scene.begin[player, 0] = min(frames, MOST_DELAY)
    for player in range(n_players):
        place_string(scene, library, player, -1)


@compiled
def _lateness(scene: SceneArrays, library: ClipArrays, r: int) -> float:
    """Seconds by which a synchronisation's own player should begin later than they do."""
    row = scene.rows[r]
    k, frame = moment_of(scene, library, r)
    m = scene.partners[row.partner_first]
    clip = library.clips[scene.entry[row.player, k]]
    theirs = library.clips[scene.entry[row.partner, m]]
    lag = row.lag
    if math.isnan(lag):
        placed, there = scene.placed[row.player], scene.placed[row.partner]
        x, z, _ = place_in_clip(placed, library.path, clip.path_start + frame, k)
        tx, tz, _ = place_in_clip(there, library.path, theirs.path_start + theirs.event, m)
        lag = math.hypot(tx - x, tz - z) / PASS_SPEED
    own = scene.begin[row.player, k] + frame
    return (scene.begin[row.partner, m] + theirs.event - own) / MOTION_FPS - lag


@compiled
def _where(
    scene: SceneArrays, library: ClipArrays, r: int
) -> tuple[float, float, float, float, float]:
    """Where the string stands when rule ``r`` looks, x, z, theta, and the x, z that it is about."""
    row = scene.rows[r]
    k, frame = moment_of(scene, library, r)
    clip = library.clips[scene.entry[row.player, k]]
    x, z, theta = place_in_clip(scene.placed[row.player], library.path, clip.path_start + frame, k)
    tx, tz = row.x, row.z
    if row.target >= 0:
        tx, tz, _ = place_of(scene, library, row.target, scene.begin[row.player, k] + frame)
    return x, z, theta, tx, tz


@compiled
def _means(
    scene: SceneArrays, library: ClipArrays, player: int
) -> tuple[float, float, float, float, float]:
    """The weight of a player's position rules, the mean of where to stand, and of where they do."""
    weight = px = pz = qx = qz = 0.0
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        if row.player == player and row.kind == POSITION and row.moment != THROUGHOUT:
            x, z, _, tx, tz = _where(scene, library, r)
            w = 1.0 / row.weight
            weight += w
            px, pz, qx, qz = px + w * tx, pz + w * tz, qx + w * x, qz + w * z
    if weight > 0.0:
        return weight, px / weight, pz / weight, qx / weight, qz / weight
    return 0.0, 0.0, 0.0, 0.0, 0.0


@compiled
def _turn_of_places(
    scene: SceneArrays, library: ClipArrays, player: int, means: tuple[float, float, float, float]
) -> tuple[float, float]:
    """The sums whose angle is the turn that the position rules ask for."""
    c = s = 0.0
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        if row.player == player and row.kind == POSITION and row.moment != THROUGHOUT:
            x, z, _, tx, tz = _where(scene, library, r)
            px, pz, qx, qz = tx - means[0], tz - means[1], x - means[2], z - means[3]
            c += (px * qx + pz * qz) / row.weight
            s += (px * qz - pz * qx) / row.weight
    return c, s


@compiled
def _turn_of_headings(scene: SceneArrays, library: ClipArrays, player: int) -> tuple[float, float]:
    """The same for the direction rules."""
    c = s = 0.0
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        if row.player == player and row.kind == DIRECTION and row.moment != THROUGHOUT:
            x, z, theta, tx, tz = _where(scene, library, r)
            wanted = row.x if row.target == HEADING else math.atan2(tx - x, tz - z)
            c += math.cos(wanted - theta) / row.weight
            s += math.sin(wanted - theta) / row.weight
    return c, s


@compiled
def _turn_to_others(scene: SceneArrays, library: ClipArrays, player: int) -> float:
    """The turn that faces whom the player keeps a distance or a line to; 0 without anybody."""
    x, z, theta = scene.placed[player, 0, 0], scene.placed[player, 0, 1], scene.placed[player, 0, 2]
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        if row.player == player and row.target >= 0 and (row.kind == DISTANCE or row.kind == LINE):
            frame = scene.begin[player, row.first]
            tx, tz, _ = place_of(scene, library, row.target, frame)
            if math.hypot(tx - x, tz - z) > _SURE:
                return math.atan2(tx - x, tz - z) - theta
    return 0.0
