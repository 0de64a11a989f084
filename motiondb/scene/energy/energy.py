"""The energy -log P(Y) of a scene, and its change when a clip is exchanged or a player moved.

    -log P(Y) = sum_k f_k / c_k + g_smooth / w_2 + g_collision / w_3 + g_effort / w_4         (7)

over the semantic rules k. g_smooth is the sum of the mismatch of poses and velocities at all seams.
g_collision is 1 if any two players touch. g_effort is the distance that all travel, in metres. A
rule that fails by more than its weight can often not be polished into holding, except in time. For
a search, the part beyond the weight may cost more: x = f / c then counts x + excess max(x - 1, 0).
An excess of 0 is the measure of the paper.

:func:`change` changes a scene's arrays in place, evaluates only what can be affected (the rest of
one player's string, the rules that depend on it, its pairs), and returns the new -log P(Y).
:func:`undo` takes it back. Both are compiled and release the global lock, to be called from
compiled loops::

    before, start = scene.total[0], start_of(scene, player)
    if rng.random() >= exp(before - change(scene, library, player, k, entry, start)):
        undo(scene)

No part of -log P(Y) is negative. So a change that is refused above a ``limit`` is refused as soon
as the parts known so far exceed it: seams first, then rules of an instant, then what needs the
player's place at all frames. The result is then infinite, and the change has to be undone.

The error of a clip, by which proposals choose it, is 1 plus its share of -log P(Y): the cost of a
rule is divided equally among the clips of its actions (that of a synchronisation in halves among
both partners' clips), a seam's cost in halves, the collision's by the grid points at which the clip
touches somebody, and effort by the distance. The errors of a scene's n clips sum to n - log P(Y).

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), equation (7) and section 5.
"""

from __future__ import annotations

import math

from motiondb.grammar.kernels import inlined, kernel
from motiondb.records import FloatArray
from motiondb.scene.energy.binding import SYNCHRONISATION, THROUGHOUT, RuleTable
from motiondb.scene.energy.placement import ClipArrays, clip_at, put_origin
from motiondb.scene.energy.rule_kernels import rule_value
from motiondb.scene.energy.scene_arrays import (
    ANY_TIME,
    EVERY,
    MOST_DELAY,
    Changing,
    SceneArrays,
    SceneState,
    empty_scene,
    first_point,
    place_clips,
    place_grid,
    place_string,
)
from motiondb.scene.language.semantic_rules import Weights

# Collisions: discs around the pelvis on the ground, compared at the points of a scene's time grid.


RADIUS = 0.25
"""Radius of a disc, m; two players are at least twice this apart. Chosen by hand: half the width of
a body."""
CONTACT_RADIUS = 0.15
"""Radius for players who are meant to touch, around their contact, m. Chosen by hand: half the
depth of a body."""
CONTACT_FRAMES = 15
"""Frames before and after the contact in which the smaller radius holds: half a second."""

_APART = (2.0 * RADIUS) ** 2  # Square of the distance in metres below which two bodies overlap
_CONTACT_APART = (2.0 * CONTACT_RADIUS) ** 2  # The same for two bodies that are to touch
_ROUND_OFF = 1e-9  # Relative error by which a sum of costs in another order may differ
_ROUNDING = 1.0 - 1e-9  # Makes the skipped time of :func:`overlaps` shorter than any rounding error


@inlined
def _in_contact(scene: SceneArrays, library: ClipArrays, p: int, q: int, frame: int) -> bool:
    """Return whether two may touch at a frame: it is near the event of their contact.

    g_collision of a scene is 1 if any two players touch who should not. Two players who are meant
    to touch (a screen and the screened player) may come closer, without overlap, within half a
    second of their contact.
    """
    for n in range(len(scene.contacts)):
        one, k, other, m = scene.contacts[n]
        if (one == p and other == q) or (one == q and other == p):
            first = scene.begin[one, k] + library.clips[scene.entry[one, k]].event
            second = scene.begin[other, m] + library.clips[scene.entry[other, m]].event
            if abs(frame - first) <= CONTACT_FRAMES or abs(frame - second) <= CONTACT_FRAMES:
                return True
    return False


@inlined
def touch(scene: SceneArrays, library: ClipArrays, p: int, q: int, g: int) -> bool:
    """Return whether two players touch who should not, at point ``g`` of the grid."""
    i, j = min(g, scene.filled[p]), min(g, scene.filled[q])
    dx = scene.grid[p, i, 0] - scene.grid[q, j, 0]
    dz = scene.grid[p, i, 1] - scene.grid[q, j, 1]
    square = dx * dx + dz * dz
    if square >= _APART:
        return False
    if scene.near[p, q] == 1 and _in_contact(scene, library, p, q, g * scene.every[0]):
        return square < _CONTACT_APART
    return True


@inlined
def overlaps(scene: SceneArrays, library: ClipArrays, p: int, q: int) -> int:
    """Return the number of grid points at which two players touch, until both have ended.

    Players who are far apart are compared again only when they can have met.
    """
    one, other = scene.grid[p], scene.grid[q]
    last_p, last_q = scene.filled[p], scene.filled[q]
    nearer = 1.0 / (2.0 * library.fastest[0] * scene.every[0])  # looks a metre, at most
    n_overlaps, g = 0, 0
    while g <= max(last_p, last_q):
        i, j = min(g, last_p), min(g, last_q)
        dx, dz = one[i, 0] - other[j, 0], one[i, 1] - other[j, 1]
        square = dx * dx + dz * dz
        if square >= _APART:
            g += int((math.sqrt(square) - 2.0 * RADIUS) * nearer * _ROUNDING)
        elif touch(scene, library, p, q, g):
            n_overlaps += 1
        g += 1
    return n_overlaps


TOTAL, RULES, SMOOTH, COLLISION, EFFORT = range(5)  # Indices into ``scene.total``


def scene_arrays(
    state: SceneState,
    library: ClipArrays,
    table: RuleTable,
    weights: Weights,
    every: int = EVERY,
    excess: float = 0.0,
) -> SceneArrays:
    """Return the evaluated arrays of a scene, for the compiled loops."""
    scene = empty_scene(state, library, table, weights, every, excess)
    evaluate(scene, library)
    return scene


@kernel
def evaluate(scene: SceneArrays, library: ClipArrays) -> float:
    """Return -log P(Y) from clips, origins and delays alone, and fill all other arrays."""
    n_players = len(scene.n_clips)
    for p in range(n_players):
        place_string(scene, library, p, -1)
    for p in range(n_players):
        for q in range(p):
            scene.overlaps[p, q] = scene.overlaps[q, p] = overlaps(scene, library, p, q)
    for r in range(len(scene.rows)):
        _set_rule(scene, library, r)
    scene.last[0] = -1
    return _sum(scene, library)


@inlined
def start_of(scene: SceneArrays, player: int) -> tuple[float, float, float, int]:
    """Return where and when a player begins: x, z, theta and delay."""
    origin = scene.placed[player, 0]
    return origin[0], origin[1], origin[2], scene.begin[player, 0]


@kernel
def change(
    scene: SceneArrays,
    library: ClipArrays,
    player: int,
    k: int,
    entry: int,
    start: tuple[float, float, float, int],
    limit: float = math.inf,
) -> float:
    """Exchange clip ``k`` of a player (-1: none), change where and when they begin.

    ``start`` is x, z, theta and delay. Returns the new -log P(Y), infinite for a delay below 0 or
    above MOST_DELAY; the scene is then unchanged, and undo does no harm.
    """
    x, z, theta, delay = start
    was = start_of(scene, player)
    _keep(scene, player)
    if delay < 0 or delay > MOST_DELAY:
        return math.inf
    if k >= 0:
        scene.entry[player, k] = entry
    if was[0] == x and was[1] == z and was[2] == theta and was[3] == delay:
        return _refresh(scene, library, player, k, limit)
    scene.begin[player, 0] = delay
    put_origin(scene.placed[player], x, z, theta)
    return _refresh(scene, library, player, -1, limit)


@kernel
def undo(scene: SceneArrays) -> None:
    """Take the last change back; do nothing if there is none."""
    if scene.last[0] >= 0:
        _copy(scene, scene.kept, scene.now, scene.last[0])
        if scene.last[1] >= 0:
            _copy_grid(scene.kept, scene.now, scene.last[0], scene.last[1])
        scene.last[0] = -1


@kernel
def token_errors(scene: SceneArrays, library: ClipArrays, errors: FloatArray) -> float:
    """Fill ``errors`` (P, L) with the errors of all clips, 0 elsewhere; return their sum."""
    total = 0.0
    for p in range(len(scene.n_clips)):
        for k in range(errors.shape[1]):
            errors[p, k] = 0.0
        for k in range(scene.n_clips[p]):
            metres = library.clips[scene.entry[p, k]].length
            errors[p, k] += 1.0 + scene.scale[2] * metres
            half = 0.5 * scene.scale[0] * scene.seams[p, k]
            errors[p, k] += half
            if k > 0:
                errors[p, k - 1] += half
        total += scene.n_clips[p]
    for r in range(len(scene.rows)):
        row = scene.rows[r]
        cost = scene.cost[r]
        if row.kind == SYNCHRONISATION:
            cost *= 0.5
            errors[row.partner, scene.meant[r]] += cost
        for k in range(row.first, row.last):
            errors[row.player, k] += cost / (row.last - row.first)
    if scene.total[COLLISION] > 0.0:
        _share_collisions(scene, library, errors)
    return total + scene.total[TOTAL]


@kernel
def _share_collisions(scene: SceneArrays, library: ClipArrays, errors: FloatArray) -> None:
    """Add the cost of collisions to the clips that touch, by the grid points at which they do."""
    n_players = len(scene.n_clips)
    points = 0
    for p in range(n_players):
        for q in range(p):
            points += scene.overlaps[p, q]
    part = 0.5 * scene.total[COLLISION] / points
    for p in range(n_players):
        for q in range(p):
            left, g = scene.overlaps[p, q], 0
            while left > 0:
                if touch(scene, library, p, q, g):
                    frame = g * scene.every[0]
                    errors[p, clip_at(scene.begin[p], scene.n_clips[p], frame)] += part
                    errors[q, clip_at(scene.begin[q], scene.n_clips[q], frame)] += part
                    left -= 1
                g += 1


@inlined
def _keep(scene: SceneArrays, player: int) -> None:
    """Save what a change of a player will overwrite, but for the grid."""
    _copy(scene, scene.now, scene.kept, player)
    scene.last[0], scene.last[1] = player, -1


@inlined
def _copy(scene: SceneArrays, source: Changing, goal: Changing, player: int) -> None:
    """Copy a player's clips and the costs of the rules that depend on them, but not the grid."""
    n = scene.n_clips[player]
    for k in range(n):
        goal.entry[player, k] = source.entry[player, k]
        goal.seams[player, k] = source.seams[player, k]
    for k in range(n + 1):
        goal.begin[player, k] = source.begin[player, k]
        for a in range(5):
            goal.placed[player, k, a] = source.placed[player, k, a]
    for i in range(scene.depends_first[player], scene.depends_first[player + 1]):
        r = scene.depends[i, 0]
        goal.cost[r], goal.seen[r] = source.cost[r], source.seen[r]
        goal.meant[r] = source.meant[r]
    for a in range(5):
        goal.total[a] = source.total[a]


@inlined
def _copy_grid(source: Changing, goal: Changing, player: int, since: int) -> None:
    """Copy a player's grid from a point on, and with whom they touch."""
    goal.filled[player] = source.filled[player]
    for g in range(since, source.filled[player] + 1):
        for a in range(3):
            goal.grid[player, g, a] = source.grid[player, g, a]
    for q in range(source.overlaps.shape[1]):
        goal.overlaps[player, q] = goal.overlaps[q, player] = source.overlaps[player, q]


@kernel
def _refresh(scene: SceneArrays, library: ClipArrays, player: int, k: int, limit: float) -> float:
    """Evaluate everything that a change of clip ``k`` (-1: of all) of a player can affect.

    Above ``limit`` the result is infinite, see the module.
    """
    limit += _ROUND_OFF * (1.0 + abs(limit))
    least = _rest(scene, library, player, k)
    if least > limit:
        return math.inf
    for i in range(scene.depends_first[player], scene.depends_first[player + 1]):
        r = scene.depends[i, 0]
        if scene.rows[r].moment != THROUGHOUT and _touched(scene, player, k, i):
            _set_rule(scene, library, r)
            least += scene.cost[r]
            if least > limit:
                return math.inf
    since = first_point(scene, player, k)
    _copy_grid(scene.now, scene.kept, player, since)
    scene.last[1] = since
    place_grid(scene, library, player, k, since)
    for q in range(len(scene.n_clips)):
        if q != player:
            touching = overlaps(scene, library, player, q)
            scene.overlaps[player, q] = scene.overlaps[q, player] = touching
            if touching > 0 and least + scene.scale[1] > limit:
                return math.inf
    for i in range(scene.depends_first[player], scene.depends_first[player + 1]):
        r = scene.depends[i, 0]
        if scene.rows[r].moment == THROUGHOUT and _touched(scene, player, k, i):
            _set_rule(scene, library, r)
    return _sum(scene, library)


@inlined
def _rest(scene: SceneArrays, library: ClipArrays, player: int, k: int) -> float:
    """Place a player's clips; return the new cost of seams and of rules that do not change."""
    scale, n = scene.scale[0], scene.n_clips[player]
    place_clips(scene, library, player, k)
    least = float(scene.total[RULES] + scene.total[SMOOTH])
    if k >= 0:
        for m in range(max(k, 1), min(k + 2, n)):
            least += scale * (scene.seams[player, m] - scene.kept.seams[player, m])
    else:
        for m in range(1, n):
            least += scale * (scene.seams[player, m] - scene.kept.seams[player, m])
    for i in range(scene.depends_first[player], scene.depends_first[player + 1]):
        if _touched(scene, player, k, i):
            least -= scene.cost[scene.depends[i, 0]]
    return least


@inlined
def _touched(scene: SceneArrays, player: int, k: int, i: int) -> bool:
    """Return whether a change of clip ``k`` (-1: of all) matters to row ``i`` of ``depends``."""
    r, reach = scene.depends[i]
    since = scene.begin[player, max(k, 0)]
    return k < 0 or k < reach or (reach == ANY_TIME and scene.seen[r] >= since)


@inlined
def _set_rule(scene: SceneArrays, library: ClipArrays, r: int) -> None:
    value, scene.seen[r], scene.meant[r] = rule_value(scene, library, r)
    cost = value / scene.rows[r].weight
    if scene.rows[r].kind != SYNCHRONISATION:
        cost += scene.scale[3] * max(cost - 1.0, 0.0)
    scene.cost[r] = cost


@inlined
def _sum(scene: SceneArrays, library: ClipArrays) -> float:
    """Sum the parts of -log P(Y); from scratch, so that rounding errors do not accumulate."""
    total = scene.total
    total[RULES] = total[SMOOTH] = total[COLLISION] = total[EFFORT] = 0.0
    for r in range(len(scene.cost)):
        total[RULES] += scene.cost[r]
    for p in range(len(scene.n_clips)):
        for k in range(1, scene.n_clips[p]):
            total[SMOOTH] += scene.scale[0] * scene.seams[p, k]
        for q in range(p):
            if scene.overlaps[p, q] > 0:
                total[COLLISION] = scene.scale[1]
    if scene.scale[2] > 0.0:
        for p in range(len(scene.n_clips)):
            for k in range(scene.n_clips[p]):
                total[EFFORT] += scene.scale[2] * library.clips[scene.entry[p, k]].length
    total[TOTAL] = total[RULES] + total[SMOOTH] + total[COLLISION] + total[EFFORT]
    return float(total[TOTAL])
