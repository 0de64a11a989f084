"""Places, times and random numbers that the steps of the inner loop are made of, compiled."""

from __future__ import annotations

import math

from motiondb.records import MOTION_FPS
from motiondb.scene.energy.compilation import compiled
from motiondb.scene.energy.placement import ClipArrays, place_in_clip
from motiondb.scene.energy.rule_kernels import moment_of
from motiondb.scene.energy.rule_table import SYNCHRONISATION
from motiondb.scene.energy.scene_arrays import SceneArrays
from motiondb.scene.language.semantic_rules import PASS_SPEED


@compiled
def origin_for_tail(
    scene: SceneArrays, library: ClipArrays, player: int, k: int, entry: int
) -> tuple[float, float, float]:
    """Return the origin that keeps everything after clip ``k`` in place when ``k`` is exchanged."""
    clip = library.clips[entry]
    start, here, end = scene.placed[player, 0], scene.placed[player, k], scene.placed[player, k + 1]
    theta = end[2] - clip.theta
    c, s = math.cos(theta), math.sin(theta)
    x, z = end[0] - (clip.x * c + clip.z * s), end[1] - (clip.z * c - clip.x * s)
    turn = theta - here[2]
    c, s = math.cos(turn), math.sin(turn)
    dx, dz = start[0] - here[0], start[1] - here[1]
    return x + dx * c + dz * s, z - dx * s + dz * c, start[2] + turn


@compiled
def gaussian(u: float, v: float) -> tuple[float, float]:
    """Return two standard normal numbers from two uniform ones (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - u))
    return radius * math.cos(2.0 * math.pi * v), radius * math.sin(2.0 * math.pi * v)


@compiled
def linked(scene: SceneArrays, player: int) -> int:
    """Return the players linked with one by synchronisations, itself too: bit p for player p."""
    group, before = 1 << player, 0
    while group != before:
        before = group
        for row in scene.rows:
            if row.kind == SYNCHRONISATION and (group >> row.player | group >> row.partner) & 1:
                group |= 1 << row.player | 1 << row.partner
    return group


@compiled
def lateness(scene: SceneArrays, library: ClipArrays, r: int) -> int:
    """Return the frames by which the partner is later than synchronisation ``r`` asks."""
    row = scene.rows[r]
    k, frame = moment_of(scene, library, r)
    time = scene.begin[row.player, k] + frame
    m = scene.meant[r]
    theirs = library.clips[scene.entry[row.partner, m]]
    lag = row.lag
    if math.isnan(lag):
        clip = library.clips[scene.entry[row.player, k]]
        x, z, _ = place_in_clip(scene.placed[row.player], library.path, clip.path_start + frame, k)
        at = theirs.path_start + theirs.event
        px, pz, _ = place_in_clip(scene.placed[row.partner], library.path, at, m)
        lag = math.hypot(px - x, pz - z) / PASS_SPEED
    return round(scene.begin[row.partner, m] + theirs.event - time - lag * MOTION_FPS)
