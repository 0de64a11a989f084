"""Copies found by comparing every query with every take at every offset: the plain twin."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motiondb.records import Float32Array
from motiondb.search import copies

N_JOINTS = 21


def find_everywhere(
    poses: list[Float32Array], queries: Iterable[int], takes: Iterable[int]
) -> list[copies.Copy]:
    """The copies of ``copies.find_copies``, one offset after another."""
    found = []
    for query in queries:
        if len(poses[query]) < copies.LEAST_FRAMES:
            continue
        for mirrored in (False, True):
            shape = copies.mirror_poses(poses[query]) if mirrored else poses[query]
            hits = [
                (distance, offset, take)
                for take in takes
                if take != query
                for distance, offset in [_best_offset(poses[take], shape)]
                if distance < copies._limit(shape)
            ]
            for distance, offset, take in sorted(hits, key=lambda hit: hit[0]):
                n = len(poses[take])
                is_same = abs(n - len(shape)) <= copies.SLACK
                if is_same and take > query:
                    continue
                kind = "mirror" if mirrored else ("same" if is_same else "cut")
                end = min(offset + len(shape), n)
                found.append(copies.Copy(query, take, kind, offset, end, distance))
    return found


def _best_offset(take: Float32Array, shape: Float32Array) -> tuple[float, int]:
    """Least distance at an offset at which the key frames are near enough."""
    keys = copies._keys(len(shape))
    most = copies.reach(shape) ** 2 * copies.KEY_FRAMES * N_JOINTS
    best = (float("inf"), 0)
    for offset in range(len(take) + copies.SLACK - len(shape) + 1):
        if np.sum((take[offset + keys] - shape[keys]) ** 2) < most:
            best = min(best, (copies._distance(take, offset, shape), offset))
    return best
