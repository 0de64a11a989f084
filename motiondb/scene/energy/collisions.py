"""Collisions: discs around the pelvis on the ground, compared at the points of a scene's time grid.

g_collision of a scene is 1 if any two players touch who should not. Two players who are meant to
touch (a screen and the screened player) may come closer, without overlap, within half a second of
their contact.
"""

from __future__ import annotations

import math

from motiondb.scene.energy.compilation import compiled
from motiondb.scene.energy.placement import ClipArrays
from motiondb.scene.energy.scene_arrays import SceneArrays

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
_ROUNDING = 1.0 - 1e-9  # Makes the skipped time of :func:`overlaps` shorter than any rounding error


@compiled
def _in_contact(scene: SceneArrays, library: ClipArrays, p: int, q: int, frame: int) -> bool:
    """Return whether two may touch at a frame: it is near the event of their contact."""
    for n in range(len(scene.contacts)):
        one, k, other, m = scene.contacts[n]
        if (one == p and other == q) or (one == q and other == p):
            first = scene.begin[one, k] + library.clips[scene.entry[one, k]].event
            second = scene.begin[other, m] + library.clips[scene.entry[other, m]].event
            if abs(frame - first) <= CONTACT_FRAMES or abs(frame - second) <= CONTACT_FRAMES:
                return True
    return False


@compiled
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


@compiled
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
