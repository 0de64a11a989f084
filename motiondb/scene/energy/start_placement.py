"""The best origin of a string of clips, in closed form, as the start of a search.

The origin of a player's string is a rigid motion of the plane. It brings the places where the
string is when its position rules look as near as possible to the places that they ask for, and its
headings to those of its direction rules. It maximises, over the turn phi,

    sum_k w_k p_k . R(phi) q_k  +  sum_d w_d cos(phi + theta_d - wanted_d) (1 m)^2,

with q_k the actual and p_k the required positions, both relative to their weighted means, and
w = 1 / c. The first sum alone is Procrustes' problem. If no rule determines the heading, a player
with a distance or line rule faces its target.

Delays that fulfil the synchronisations best were computed here, too, by relaxation; searches that
begin without any end about as low (docs/measured/scenes.md).

Source: P. H. Schönemann, "A generalized solution of the orthogonal Procrustes problem",
Psychometrika 31 (1966), here in the plane. The paper on motion grammars does not say where a string
begins.
"""

from __future__ import annotations

import math

from motiondb.grammar.kernels import kernel
from motiondb.scene.energy.binding import (
    DIRECTION,
    DISTANCE,
    HEADING,
    LINE,
    POSITION,
    THROUGHOUT,
)
from motiondb.scene.energy.energy import evaluate
from motiondb.scene.energy.placement import ClipArrays, place_in_clip, put_origin
from motiondb.scene.energy.rule_kernels import moment_of
from motiondb.scene.energy.scene_arrays import SceneArrays, place_of, place_string

_SWEEPS = 4  # Rounds over all players: directions depend on the places of the others
_SURE = 1e-9  # Length below which a vector has no direction


@kernel
def place_start(scene: SceneArrays, library: ClipArrays) -> float:
    """Set the best origins of all players, and return -log P(Y).

    It cannot be undone.
    """
    n_players = len(scene.n_clips)
    for sweep in range(_SWEEPS):
        for player in range(n_players):
            place_player(scene, library, player, sweep > 0)
    return evaluate(scene, library)


@kernel
def place_player(scene: SceneArrays, library: ClipArrays, player: int, facing: bool) -> None:
    """Set the best origin of one player, given the others; ``facing`` includes direction rules.

    It changes the origin, the string and its grid, nothing else: evaluate() must follow.
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


@kernel
def _where(
    scene: SceneArrays, library: ClipArrays, r: int
) -> tuple[float, float, float, float, float]:
    """Return x, z, theta of the string when rule ``r`` looks, and x, z of the rule's target."""
    row = scene.rows[r]
    k, frame = moment_of(scene, library, r)
    clip = library.clips[scene.entry[row.player, k]]
    x, z, theta = place_in_clip(scene.placed[row.player], library.path, clip.path_start + frame, k)
    tx, tz = row.x, row.z
    if row.target >= 0:
        tx, tz, _ = place_of(scene, library, row.target, scene.begin[row.player, k] + frame)
    return x, z, theta, tx, tz


@kernel
def _means(
    scene: SceneArrays, library: ClipArrays, player: int
) -> tuple[float, float, float, float, float]:
    """Return the weight of a player's position rules, the mean of wanted and of actual places."""
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


@kernel
def _turn_of_places(
    scene: SceneArrays, library: ClipArrays, player: int, means: tuple[float, float, float, float]
) -> tuple[float, float]:
    """Return the sums whose angle is the turn that the position rules ask for."""
    c = s = 0.0
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        if row.player == player and row.kind == POSITION and row.moment != THROUGHOUT:
            x, z, _, tx, tz = _where(scene, library, r)
            px, pz, qx, qz = tx - means[0], tz - means[1], x - means[2], z - means[3]
            c += (px * qx + pz * qz) / row.weight
            s += (px * qz - pz * qx) / row.weight
    return c, s


@kernel
def _turn_of_headings(scene: SceneArrays, library: ClipArrays, player: int) -> tuple[float, float]:
    """Return the sums whose angle is the turn that the direction rules ask for."""
    c = s = 0.0
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        if row.player == player and row.kind == DIRECTION and row.moment != THROUGHOUT:
            x, z, theta, tx, tz = _where(scene, library, r)
            wanted = row.x if row.target == HEADING else math.atan2(tx - x, tz - z)
            wanted += row.near
            c += math.cos(wanted - theta) / row.weight
            s += math.sin(wanted - theta) / row.weight
    return c, s


@kernel
def _turn_to_others(scene: SceneArrays, library: ClipArrays, player: int) -> float:
    """Return the turn that faces the target of a distance or line rule; 0 without one."""
    x, z, theta = scene.placed[player, 0, 0], scene.placed[player, 0, 1], scene.placed[player, 0, 2]
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        if row.player == player and row.target >= 0 and (row.kind == DISTANCE or row.kind == LINE):
            frame = scene.begin[player, row.first]
            tx, tz, _ = place_of(scene, library, row.target, frame)
            if math.hypot(tx - x, tz - z) > _SURE:
                return math.atan2(tx - x, tz - z) - theta
    return 0.0
