"""Copies of a motion: the same take in another file, a mirror image, a cut out of a longer take.

Notation: p_t the joint positions of frame t relative to the pelvis, turned to the heading, on the
standard body. A query of n frames at offset o of a take differs by

    distance(o) = sqrt(mean over frames and joints of |p_t - p'_{o + t}|^2), metres.

A few frames of the query, spread evenly, are compared with every frame of every take at once; the
best offsets are then measured over all frames. A copy is nearer than ``NEAR`` metres and much
nearer than the motion itself is wide, so that two people standing still are no copies of one
another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.pose import body, features, retarget, rotation
from motiondb.records import Float32Array, IntArray, Motion

NEAR = 0.01
"""Metres."""
RELATIVE = 0.25
"""Share of the motion's own spread about its mean pose."""
KEY_FRAMES = 12
LEAST_FRAMES = 20
SLACK = 2
"""Frames by which two files of one take may differ in length."""


@dataclass(frozen=True)
class Copy:
    """``query`` is found in ``take`` from ``start`` to ``end``, frames of ``take``.

    kind : "same", "cut" or "mirror". distance : metres.
    """

    query: int
    take: int
    kind: str
    start: int
    end: int
    distance: float


@dataclass(frozen=True, eq=False)
class Library:
    """Poses of takes, one after another.

    poses : array (frames, 63), float32, metres. bounds : array (takes + 1,).
    """

    poses: Float32Array
    bounds: IntArray


def copy_poses(motion: Motion) -> Float32Array:
    """Joint positions relative to the pelvis and the heading: array (frames, 63), metres."""
    positions, world = retarget.motion_positions(motion)
    facing = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), -features.headings(world))
    local = rotation.rotate(facing[:, None], positions - positions[:, :1])
    return local.reshape(len(local), -1).astype(np.float32)


def mirror_poses(poses: Float32Array) -> Float32Array:
    """The poses of the mirror image."""
    joints = poses.reshape(len(poses), -1, 3)[:, body.MIRROR]
    return (joints * np.array([-1.0, 1.0, 1.0], dtype=np.float32)).reshape(len(poses), -1)


def build_library(poses: Sequence[Float32Array]) -> Library:
    """Put takes side by side."""
    bounds = np.concatenate([[0], np.cumsum([len(p) for p in poses])]).astype(np.int64)
    joined = np.concatenate(poses) if len(poses) else np.zeros((0, 63), dtype=np.float32)
    return Library(joined, bounds)


def find_copies(
    library: Library, queries: Sequence[int], takes: Sequence[int] | None = None
) -> list[Copy]:
    """Takes in which the queries are found again, nearest first per query.

    Of two takes of one length the later number is reported as a copy of the earlier.

    Parameters
    ----------
    queries : take numbers to look for. takes : where to look (default: everywhere).
    """
    places = range(len(library.bounds) - 1) if takes is None else takes
    mask = np.zeros(len(library.poses), dtype=bool)
    for take in places:
        mask[library.bounds[take] : library.bounds[take + 1]] = True
    norms = np.einsum("td,td->t", library.poses, library.poses)
    copies: list[Copy] = []
    for query in queries:
        poses = _take(library, query)
        if len(poses) < LEAST_FRAMES:
            continue
        spread = float(np.sqrt(np.mean(np.sum((poses - poses.mean(axis=0)) ** 2, axis=1) / 21)))
        limit = min(NEAR, RELATIVE * spread)
        flipped = mirror_poses(poses)
        symmetric = float(np.sqrt(np.mean((flipped - poses) ** 2) * 3)) < 2.0 * limit
        for mirrored in (False,) if symmetric else (False, True):
            shape = flipped if mirrored else poses
            for take, offset, distance in _find(library, norms, shape, limit, set(places)):
                length = int(library.bounds[take + 1] - library.bounds[take])
                same_length = abs(length - len(poses)) <= SLACK
                if take == query or (same_length and take > query):
                    continue
                kind = "mirror" if mirrored else ("same" if same_length else "cut")
                end = min(offset + len(poses), length)
                copies.append(Copy(query, take, kind, offset, end, distance))
    return copies


def _find(
    library: Library, norms: Float32Array, poses: Float32Array, limit: float, places: set[int]
) -> list[tuple[int, int, float]]:
    """(take, offset, distance) of every take that holds the poses, nearest first."""
    keys = np.linspace(0, len(poses) - 1 - SLACK, KEY_FRAMES).round().astype(np.int64)
    n = len(library.poses) - int(keys[-1])
    if n < 1:
        return []
    rough = np.zeros(n, dtype=np.float32)
    products = library.poses @ poses[keys].T
    for k, key in enumerate(keys):
        square = norms[key : key + n] - 2.0 * products[key : key + n, k]
        rough += square + poses[key] @ poses[key]
    rough = np.sqrt(np.maximum(rough, 0.0) / (KEY_FRAMES * 21))
    found = []
    for offset in np.flatnonzero(rough < 1.5 * limit):
        take = int(np.searchsorted(library.bounds, offset, side="right")) - 1
        if take not in places or offset + len(poses) > library.bounds[take + 1] + SLACK:
            continue
        part = library.poses[offset : min(offset + len(poses), int(library.bounds[take + 1]))]
        distance = float(np.sqrt(np.mean((part - poses[: len(part)]) ** 2) * 3))
        if distance < limit:
            found.append((take, int(offset - library.bounds[take]), distance))
    best: dict[int, tuple[int, int, float]] = {}
    for hit in found:
        if hit[0] not in best or hit[2] < best[hit[0]][2]:
            best[hit[0]] = hit
    return sorted(best.values(), key=lambda hit: hit[2])


def _take(library: Library, number: int) -> Float32Array:
    return library.poses[library.bounds[number] : library.bounds[number + 1]]
