"""Copies among the captures of a database, looked for when captures are added.

The outlines of captures (:mod:`motiondb.search.copy_outlines`) are kept in the cache of the
database, so that the motions of captures that are there already need not be loaded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from motiondb import store
from motiondb.records import MOTION_FPS, Float32Array, Motion, Relation
from motiondb.search import copies
from motiondb.search.copy_outlines import N_AXES, Int16Array, outline
from motiondb.workers import HERE, Workers

KIND = "outlines"  # Name of the outlines of all captures in the cache of the database


Made = tuple[Int16Array, float]
"""Outline (frames, 12) of a capture, and how far from it a copy may be."""


def load_outlines(
    opened: store.Store, ready: Mapping[int, Made] = MappingProxyType({})
) -> store.CaptureRows:
    """Outlines of all captures, and how far from them a copy may be.

    `ready`: Those that were made already, by number of the capture.
    """
    return store.cached_rows(opened, KIND, _make, ready)


def find_relations(
    opened: store.Store, new: set[str], workers: Workers = HERE
) -> tuple[list[Relation], dict[int, Made]]:
    """Copies, mirror images and cuts among the captures, of which at least one is new.

    Also gives the outlines of the new ones, by number of the capture.

    `new`: Names of captures.
    """
    held = load_outlines(opened)
    place_of = {number: place for place, number in enumerate(held.capture_ids.tolist())}
    infos = [info for info in store.load_captures(opened) if info.capture_id in place_of]
    numbers = [info.capture_id for info in infos]

    def poses_of(n: int) -> Float32Array:
        return copies.copy_poses(store.load_motion(opened, numbers[n]))

    places = np.array([place_of[number] for number in numbers], dtype=np.int64)
    firsts, ends = held.bounds[places], held.bounds[places + 1]
    limbs = held.rows if len(held.rows) else np.zeros((0, N_AXES), dtype=np.int16)
    library = copies.Library(ends - firsts, held.values[places], firsts, limbs, poses_of)
    fresh = [n for n, info in enumerate(infos) if info.name in new]
    old = [n for n, info in enumerate(infos) if info.name not in new]
    found = copies.find_copies(library, fresh, None, workers)
    found += copies.find_copies(library, old, fresh, workers)
    relations = [
        Relation(
            infos[c.query].name,
            infos[c.take].name,
            c.kind,
            c.start / MOTION_FPS,
            c.end / MOTION_FPS,
            c.distance,
        )
        for c in found
    ]
    made = {
        numbers[n]: (held.rows[firsts[n] : ends[n]], float(held.values[places[n]])) for n in fresh
    }
    return relations, made


def _make(motions: Sequence[Motion]) -> list[Made]:
    """Outline and reach of some motions, in their order."""
    poses = (copies.copy_poses(motion) for motion in motions)
    return [(outline(each), copies.reach(each)) for each in poses]
