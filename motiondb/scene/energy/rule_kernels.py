"""The values f_k of semantic rules, compiled: of a sampled scene, and of instants on any clock.

f_pos and f_line are metres, f_dir the radians in [0, pi] of the smallest turn, f_dist 0 within its
bounds, both included, and 1 elsewhere, f_synch seconds.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), equations (1) to (5).
"""

from __future__ import annotations

import math

from motiondb.grammar.kernels import inlined, kernel
from motiondb.records import MOTION_FPS, FloatArray
from motiondb.scene.energy.binding import (
    AT_END,
    AT_START,
    DIRECTION,
    DISTANCE,
    HEADING,
    LINE,
    ON_THE_WAY,
    ORDER,
    SYNCHRONISATION,
    THROUGHOUT,
    UNMET,
)
from motiondb.scene.energy.placement import ClipArrays, place_in_clip
from motiondb.scene.energy.scene_arrays import SceneArrays, place_of
from motiondb.scene.language.semantic_rules import PASS_SPEED, SMALLEST

LATEST = 1.0
"""Seconds from which on a late step is no worse: a search has to pass such scenes."""
EARLIER = 6
"""Frames by which a step is to come before a later one of somebody else: polishing moves both."""


@inlined
def wrapped(turn: float) -> float:
    """Return the size of a turn, radians in [0, pi]."""
    turn = abs(turn) % (2.0 * math.pi)
    return min(turn, 2.0 * math.pi - turn)


@inlined
def segment_distance(x: float, z: float, ax: float, az: float, bx: float, bz: float) -> float:
    """Return the distance of a point from the segment between two points, m."""
    dx, dz = bx - ax, bz - az
    share = ((x - ax) * dx + (z - az) * dz) / max(dx * dx + dz * dz, SMALLEST)
    share = min(max(share, 0.0), 1.0)
    return math.hypot(x - ax - share * dx, z - az - share * dz)


@inlined
def moment_of(scene: SceneArrays, library: ClipArrays, r: int) -> tuple[int, int]:
    """Return the clip and the frame within it at which rule ``r`` looks (not for throughout)."""
    row = scene.rows[r]
    entry = scene.entry[row.player]
    if row.moment == AT_START:
        return row.first, 0
    if row.moment == AT_END:
        return row.last - 1, library.clips[entry[row.last - 1]].n_frames - 1
    if row.moment == ON_THE_WAY:
        return _on_the_way(scene, library, r)
    return row.first, library.clips[entry[row.first]].event


@inlined
def _on_the_way(scene: SceneArrays, library: ClipArrays, r: int) -> tuple[int, int]:
    """Return the first frame at which a fraction of a sequence's distance has been covered."""
    row = scene.rows[r]
    entry = scene.entry[row.player]
    metres = 0.0
    for k in range(row.first, row.last):
        metres += library.clips[entry[k]].length
    metres *= row.fraction
    for k in range(row.first, row.last):
        clip = library.clips[entry[k]]
        low, high = 0, clip.n_frames - 1
        if metres > library.way[clip.path_start + high] and k < row.last - 1:
            metres -= clip.length
            continue
        while low < high:
            middle = (low + high) // 2
            if library.way[clip.path_start + middle] < metres:
                low = middle + 1
            else:
                high = middle
        return k, low
    return row.first, 0


@inlined
def _measure(
    kind: int,
    place: tuple[float, float, float],
    target: tuple[float, float, float],
    other: tuple[float, float, float],
    heading: bool,
    bounds: tuple[float, float],
) -> float:
    """Return f of one rule at one instant from all places."""
    x, z, theta = place
    if kind == DIRECTION:
        wanted = target[0] if heading else math.atan2(target[0] - x, target[1] - z)
        return wrapped(theta - wanted - bounds[0])
    if kind == LINE:
        return segment_distance(x, z, target[0], target[1], other[0], other[1])
    apart = math.hypot(x - target[0], z - target[1])
    if kind == DISTANCE:
        return 0.0 if bounds[0] <= apart <= bounds[1] else 1.0
    return apart


@kernel
def values_at(
    kind: int,
    places: FloatArray,
    targets: FloatArray,
    others: FloatArray,
    heading: bool,
    bounds: tuple[float, float],
    values: FloatArray,
) -> None:
    """Fill in f of one rule at instants with these places (n, 3), targets and others (n, 2)."""
    for i in range(len(places)):
        place = (places[i, 0], places[i, 1], places[i, 2])
        target = (targets[i, 0], targets[i, 1], 0.0)
        other = (others[i, 0], others[i, 1], 0.0)
        values[i] = _measure(kind, place, target, other, heading, bounds)


@inlined
def _throughout(scene: SceneArrays, r: int) -> tuple[float, int]:
    """Return the mean over the grid points of a rule's actions (the point before if none)."""
    row = scene.rows[r]
    every = scene.every[0]
    begin = scene.begin[row.player]
    g1 = -(-begin[row.last] // every)
    g0 = min(-(-begin[row.first] // every), g1 - 1)
    grid, filled = scene.grid, scene.filled
    bounds = (row.near, row.far)
    target = (row.x, row.z, 0.0)
    other = (row.other_x, row.other_z, 0.0)
    total = 0.0
    for g in range(g0, g1):
        i = min(g, filled[row.player])
        place = (grid[row.player, i, 0], grid[row.player, i, 1], grid[row.player, i, 2])
        if row.target >= 0:
            i = min(g, filled[row.target])
            target = (grid[row.target, i, 0], grid[row.target, i, 1], 0.0)
        if row.other >= 0:
            i = min(g, filled[row.other])
            other = (grid[row.other, i, 0], grid[row.other, i, 1], 0.0)
        total += _measure(row.kind, place, target, other, row.target == HEADING, bounds)
    return total / (g1 - g0), (g1 - 1) * every


@inlined
def lateness(scene: SceneArrays, library: ClipArrays, r: int, m: int) -> float:
    """Return the frames by which the partner's clip is later than synchronisation ``r`` asks."""
    row = scene.rows[r]
    k, frame = moment_of(scene, library, r)
    clip = library.clips[scene.entry[row.player, k]]
    theirs = library.clips[scene.entry[row.partner, m]]
    lag = row.lag
    if math.isnan(lag):
        x, z, _ = place_in_clip(scene.placed[row.player], library.path, clip.path_start + frame, k)
        at = theirs.path_start + theirs.event
        px, pz, _ = place_in_clip(scene.placed[row.partner], library.path, at, m)
        lag = math.hypot(px - x, pz - z) / PASS_SPEED
    time = scene.begin[row.player, k] + frame
    return float(scene.begin[row.partner, m] + theirs.event - time - lag * MOTION_FPS)


@inlined
def _synchronisation(scene: SceneArrays, library: ClipArrays, r: int) -> tuple[float, int]:
    """Return f_synch, s, for the partner's clip that fulfils it best, and that clip."""
    row = scene.rows[r]
    best, meant = math.inf, -1
    for n in range(row.partner_first, row.partner_last):
        m = scene.partners[n]
        error = abs(lateness(scene, library, r, m)) / MOTION_FPS
        if error < best:
            best, meant = error, m
    return best, meant


@inlined
def rule_value(scene: SceneArrays, library: ClipArrays, r: int) -> tuple[float, int, int]:
    """Return f of rule ``r``, the last frame at which it looks at others, the partner's clip."""
    row = scene.rows[r]
    if row.kind == UNMET:
        return 1.0, -1, -1
    if row.kind == SYNCHRONISATION:
        value, meant = _synchronisation(scene, library, r)
        return value, -1, meant
    if row.kind == ORDER:
        m = row.partner_first
        end = scene.begin[row.target, m + 1]
        until = end
        if row.fraction == 0.0:
            until = scene.begin[row.target, m] + library.clips[scene.entry[row.target, m]].event
        k, frame = moment_of(scene, library, r)
        late = scene.begin[row.player, k] + frame + EARLIER - until
        return min(max(late, 0) / MOTION_FPS, LATEST), end, -1
    if row.moment == THROUGHOUT:
        value, seen = _throughout(scene, r)
        return value, seen, -1
    k, frame = moment_of(scene, library, r)
    clip = library.clips[scene.entry[row.player, k]]
    place = place_in_clip(scene.placed[row.player], library.path, clip.path_start + frame, k)
    time = scene.begin[row.player, k] + frame
    target, other = (row.x, row.z, 0.0), (row.other_x, row.other_z, 0.0)
    if row.target >= 0:
        target = place_of(scene, library, row.target, time)
    if row.other >= 0:
        other = place_of(scene, library, row.other, time)
    bounds = (row.near, row.far)
    return _measure(row.kind, place, target, other, row.target == HEADING, bounds), time, -1
